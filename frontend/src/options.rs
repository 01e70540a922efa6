//! Options of the front end.

use srp_archdesc::arch::{Approx, Precision};
use srp_archdesc::choice::Choices;
use srp_archdesc::diagnostic::Source;
use srp_archdesc::isa::{Class, Opcode};

/// A file that a source asks for with `#include`.
#[derive(Clone, Copy, Debug)]
pub struct Include<'a> {
    /// The name as written.
    pub name: &'a str,
    /// The name of the file that asks.
    pub from: &'a str,
    /// Written `<name>`, not `"name"`.
    pub system: bool,
}

/// What [`Options::resolve`] finds for an include.
#[derive(Clone, Debug)]
pub enum Included {
    /// The file. Messages show its name; one file always gets one name.
    Found(Source),
    /// The file, and a fact about it that the user is told.
    Doubtful(Source, String),
    /// No file.
    Missing,
    /// A file that is there, or may be, and is not read, with the reason.
    Refused(String),
}

impl From<Option<Source>> for Included {
    fn from(found: Option<Source>) -> Included {
        found.map_or(Included::Missing, Included::Found)
    }
}

/// Options of the front end.
#[derive(Clone)]
pub struct Options<'a> {
    /// Macros defined before each source: name and body.
    pub defines: Vec<(String, String)>,
    /// Finds included files.
    pub resolve: &'a dyn Fn(&Include<'_>) -> Included,
    /// Marks innermost loops as kernels where no pragma does.
    pub auto_kernel: bool,
    /// `double` means `float`; each place where it does is told.
    pub double_is_float: bool,
    /// Floating constants without suffix are floats; each is told.
    pub single_constants: bool,
    /// The machine's units, of which pragmas choose.
    pub choices: Choices,
    /// Lets reciprocals, roots and quotients of the program be computed by the cheapest unit whose relative error
    /// is no larger than this many units in the last place of 1; those in loops with a pragma by its.
    pub max_ulp: Option<f64>,
    /// Classes of operations that no unit of the machine runs: the program gets the functions that compute them.
    pub software: Vec<Class>,
}

impl Options<'_> {
    /// The functions of the library that compute what no unit runs.
    pub(crate) fn software(&self) -> impl Iterator<Item = String> {
        let lacking = |op: &&Opcode| self.software.contains(&op.class());
        Opcode::ALL
            .iter()
            .filter(lacking)
            .filter_map(|op| op.software())
    }
}

impl Default for Options<'_> {
    /// No macros, no included files, innermost loops marked.
    fn default() -> Self {
        Options {
            defines: Vec::new(),
            resolve: &|_| Included::Missing,
            auto_kernel: true,
            double_is_float: false,
            single_constants: false,
            choices: Choices::default(),
            max_ulp: None,
            software: Vec::new(),
        }
    }
}

impl std::fmt::Debug for Options<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Options")
            .field("defines", &self.defines)
            .field("auto_kernel", &self.auto_kernel)
            .finish_non_exhaustive()
    }
}

/// The macros by which the library knows which special functions of a machine are exact: its own
/// functions then take what the unit gives. And the one by which kernels know what to multiply a reciprocal by that is
/// not ([`Precision::narrowing`]).
pub fn precision_macros(precision: &Precision) -> Vec<(String, String)> {
    let units = [
        ("__SRP_EXACT_SQRT", precision.sqrt),
        ("__SRP_EXACT_DIV", precision.div),
        ("__SRP_EXACT_EXP2", precision.exp2),
        ("__SRP_EXACT_LOG2", precision.log2),
        ("__SRP_EXACT_SINCOS", precision.sincos),
    ];
    let exact = units.into_iter().filter(|(_, unit)| *unit == Approx::Exact);
    let exact = exact.map(|(name, _)| (name.to_owned(), "1".to_owned()));
    let narrowing = match precision.rcp {
        Approx::Exact => None,
        _ => Some((
            "__SRP_RCP_NARROWING".to_owned(),
            format!("{:?}f", precision.narrowing()),
        )),
    };
    exact.chain(narrowing).collect()
}
