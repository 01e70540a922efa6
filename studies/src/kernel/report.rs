//! The report of a kernel's study.

use super::origin::Origins;
use super::rewritten::Rewritten;
use super::target::Target;
use super::trial::Trial;
use schemars::JsonSchema;
use serde::Serialize;

/// A range of an input.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Range {
    /// The parameter or object.
    pub name: String,
    /// The least value.
    pub low: f64,
    /// The greatest value.
    pub high: f64,
    /// Numbers of one evaluation.
    pub length: u32,
}

/// The outcome of a kernel's trials.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Report {
    /// The function, benchmark or program.
    pub name: String,
    /// Its file.
    pub file: String,
    /// The machine's name, which the envelope of a document has.
    #[serde(skip)]
    pub machine: String,
    /// Its inputs.
    pub ranges: Vec<Range>,
    /// Its outputs by name.
    pub outputs: Vec<String>,
    /// Evaluations that were drawn.
    pub points: usize,
    /// The assumptions that were made.
    pub notes: Vec<String>,
    /// The special functions that it computes.
    pub units: Vec<String>,
    /// The limits that settings have to keep to.
    pub target: Target,
    /// The machine as it is, then the others in the order in which they were tried.
    pub trials: Vec<Trial>,
    /// Numbers of the trials on the front of error and cycles, by error.
    pub front_cycles: Vec<usize>,
    /// The same of error and area.
    pub front_area: Vec<usize>,
    /// The same of error and energy.
    pub front_energy: Vec<usize>,
    /// The number of the cheapest that keeps to the target: by cycles, then area, then energy.
    pub cheapest: Option<usize>,
    /// Where the errors come from, with the machine as it is.
    pub origins: Origins,
    /// Where they come from with the cheapest, if that is another.
    pub cheapest_origins: Option<Origins>,
    /// Rewrites of single expressions, each tried alone.
    pub rewrites: Vec<Rewritten>,
    /// True when all combinations were tried.
    pub exhaustive: bool,
    /// True when all neighbours of the fronts were tried or are predicted to be beaten.
    pub closed: bool,
    /// True when the study was not interrupted.
    pub complete: bool,
}
