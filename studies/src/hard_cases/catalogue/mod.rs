//! The catalogue of hard cases: the `.cases` files beside this one, and their form.
//!
//! A file is lines of `keyword rest`; `#` begins a comment. `case ID TITLE` begins a case, the lines
//! after it belong to it, and what stands before the first case of a file holds for all its cases:
//!
//! ```text
//! version 1                      of this form; may be left out
//!
//! case S1.1 a zero of the direction on a slab plane: 0 · ∞
//!   call box low 0 -1 -1 high 0 0 0 from 0 0 0 along 0 -1 0
//!   gives hit
//!   may miss                     another answer that is allowed; any number of these lines
//!   flushed miss                 the answer of machines that flush subnormals, where it is another
//!   by exact                     the oracle that decides
//!   source Barnes, …             who knows of it
//!   on host srp tni              the levels that it runs at
//!   within 2                     units of the last place that a result may be off; 0 where not said
//!   costs rsqrt 1                how often the error of an approximate unit may go into the result
//!   loses wald 0.16              a triangle test that may lose the ray, or this share of many
//! ```
//!
//! A number is the float nearest to a decimal number, `inf`, `nan`, or `x` and its bits in
//! hexadecimal. `docs/hard-cases.md` lists the calls, their arguments and their answers.

mod check;
mod read;

pub(super) use read::read;

use serde::{Deserialize, Serialize};
use srp_archdesc::arch::{Precision, Subnormals};
use srp_archdesc::diagnostic::{Messages, Source};

/// Where the files of the catalogue are.
const FOLDER: &str = "studies/src/hard_cases/catalogue";

/// The version of the form of `.cases` files.
pub(crate) const VERSION: u32 = 1;

/// The files of the catalogue.
const FILES: [(&str, &str); 11] = [
    ("boxes", include_str!("boxes.cases")),
    ("triangles", include_str!("triangles.cases")),
    ("origins", include_str!("origins.cases")),
    ("vectors", include_str!("vectors.cases")),
    ("functions", include_str!("functions.cases")),
    ("textures", include_str!("textures.cases")),
    ("light", include_str!("light.cases")),
    ("trees", include_str!("trees.cases")),
    ("floats", include_str!("floats.cases")),
    ("rounding", include_str!("rounding.cases")),
    ("pictures", include_str!("pictures.cases")),
];

/// Where a case is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Level {
    /// The kernels' C by the host's compiler.
    Host,
    /// The kernels on the simulated SRP.
    Srp,
    /// The T&I unit, with rays of the SRP where kernels make them.
    Tni,
    /// Whole frames: the kernels by their meaning, with a T&I unit that answers at once.
    Frame,
}

impl Level {
    /// All of them, from the one without a simulation.
    pub const ALL: [Level; 4] = [Level::Host, Level::Srp, Level::Tni, Level::Frame];

    /// Its name in the catalogue.
    pub fn name(self) -> &'static str {
        match self {
            Level::Host => "host",
            Level::Srp => "srp",
            Level::Tni => "tni",
            Level::Frame => "frame",
        }
    }
}

/// Who decides what is right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Oracle {
    /// Rational arithmetic.
    Exact,
    /// Binary64, where its error cannot matter.
    Binary64,
    /// A function of the reals, rounded once.
    Rounded,
    /// Every triangle, one after the other, in rational arithmetic.
    BruteForce,
    /// The text of a standard, or of this project's own documents.
    Rule,
}

impl Oracle {
    const ALL: [Oracle; 5] = [
        Oracle::Exact,
        Oracle::Binary64,
        Oracle::Rounded,
        Oracle::BruteForce,
        Oracle::Rule,
    ];

    /// Its name in the catalogue.
    pub fn name(self) -> &'static str {
        match self {
            Oracle::Exact => "exact",
            Oracle::Binary64 => "binary64",
            Oracle::Rounded => "rounded",
            Oracle::BruteForce => "brute-force",
            Oracle::Rule => "rule",
        }
    }
}

/// A hard case.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its identifier: a letter for its family, and numbers.
    pub id: String,
    /// The difficulty of the case.
    pub title: String,
    /// The function that is called.
    pub call: String,
    /// Its arguments by name, as bits.
    pub arguments: Vec<(String, Vec<u32>)>,
    /// The answer that it must give: numbers and words.
    pub gives: Vec<String>,
    /// Other answers that it may give.
    pub may: Vec<Vec<String>>,
    /// The answer on a machine that flushes subnormals, where it is another one.
    pub flushed: Vec<String>,
    /// Who decides what is right.
    pub oracle: Oracle,
    /// Who knows of it.
    pub source: String,
    /// The levels that it runs at.
    pub levels: Vec<Level>,
    /// Units of the last place of the largest part of the result.
    pub within: f64,
    /// Approximate units, and how often their error goes into the result.
    pub costs: Vec<(String, f64)>,
    /// Triangle tests that may lose the ray, or this share of many.
    pub loses: Vec<(String, f64)>,
    /// File and line.
    pub place: String,
}

impl Case {
    /// A case of which nothing is said.
    fn empty() -> Case {
        Case {
            id: String::new(),
            title: String::new(),
            call: String::new(),
            arguments: Vec::new(),
            gives: Vec::new(),
            may: Vec::new(),
            flushed: Vec::new(),
            oracle: Oracle::Rule,
            source: String::new(),
            levels: Vec::new(),
            within: 0.0,
            costs: Vec::new(),
            loses: Vec::new(),
            place: String::new(),
        }
    }

    /// The case with each of the other answers that it may give.
    pub(super) fn others(&self) -> impl Iterator<Item = Case> + '_ {
        self.may.iter().map(|answer| Case {
            gives: answer.clone(),
            flushed: Vec::new(),
            may: Vec::new(),
            ..self.clone()
        })
    }

    /// An argument of this name.
    pub(super) fn argument(&self, name: &str) -> Option<&[u32]> {
        let found = self.arguments.iter().find(|(n, _)| n == name);
        found.map(|(_, words)| words.as_slice())
    }

    /// The bits of an argument of `N` words; 0 where it is not given.
    pub(super) fn words<const N: usize>(&self, name: &str) -> [u32; N] {
        let given = self.argument(name).unwrap_or_default();
        std::array::from_fn(|i| given.get(i).copied().unwrap_or(0))
    }

    /// The same as floats.
    pub(super) fn floats<const N: usize>(&self, name: &str) -> [f32; N] {
        self.words(name).map(f32::from_bits)
    }

    /// The numbers that it is to give on a machine of some precision.
    pub(super) fn numbers_on(&self, precision: &Precision) -> Vec<f32> {
        match (precision.subnormals, self.flushed.is_empty()) {
            (Subnormals::Flush, false) => floats(&self.flushed),
            _ => self.numbers(),
        }
    }

    /// The numbers that it is to give.
    pub(super) fn numbers(&self) -> Vec<f32> {
        floats(&self.gives)
    }

    /// True if it must give this word.
    pub(super) fn gives(&self, word: &str) -> bool {
        self.gives.iter().any(|w| w == word)
    }

    /// The share of rays that a test may lose.
    pub(super) fn may_lose(&self, test: &str) -> Option<f64> {
        let found = self.loses.iter().find(|(name, _)| name == test);
        found.map(|&(_, share)| share)
    }
}

/// The numbers among some words.
fn floats(words: &[String]) -> Vec<f32> {
    let numbers = words.iter().filter_map(|word| number(word));
    numbers.map(f32::from_bits).collect()
}

/// The bits of a number as the catalogue writes it.
pub(super) fn number(word: &str) -> Option<u32> {
    if let Some(bits) = word.strip_prefix('x') {
        return u32::from_str_radix(bits, 16).ok();
    }
    let begins = |c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.');
    let special = matches!(word, "inf" | "-inf" | "nan");
    if !special && !word.starts_with(begins) {
        return None;
    }
    word.parse().ok().map(f32::to_bits)
}

/// The catalogue's own cases, in the order of its files.
///
/// # Errors
///
/// All that is wrong with it.
pub(super) fn own() -> Result<Vec<Case>, Messages> {
    let source = |(name, text)| Source::new(format!("{FOLDER}/{name}.cases"), text);
    read(&FILES.map(source))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_files_are_in_the_catalogue() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/hard_cases/catalogue");
        let entries = std::fs::read_dir(folder).expect("the folder is there");
        let paths = entries.map(|e| e.expect("the entry can be read").path());
        let cases = paths.filter(|p| p.extension().is_some_and(|e| e == "cases"));
        let names = cases.filter_map(|p| Some(p.file_stem()?.to_str()?.to_owned()));
        let mut names: Vec<String> = names.collect();
        let mut read: Vec<&str> = FILES.iter().map(|(name, _)| *name).collect();
        names.sort();
        read.sort_unstable();
        assert_eq!(names, read);
    }
}
