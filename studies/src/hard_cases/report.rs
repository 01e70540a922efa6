//! Verdicts on all cases, as data.

use super::catalogue::{Case, Level};
use super::judge::Verdict;
use super::settings::Setting;
use schemars::JsonSchema;
use serde::Serialize;
use srp_toolchain::envelope::Contents;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// A column of the matrix: a level, and there a setting by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Column {
    /// The level.
    pub level: Level,
    /// The setting's number.
    pub setting: usize,
}

/// Verdicts on all cases, in each column that they run in.
#[derive(Clone, Debug)]
pub struct Matrix {
    /// The machine's name.
    pub machine: String,
    /// The settings of the machine.
    pub settings: Vec<Setting>,
    /// The cases.
    pub cases: Vec<Case>,
    /// Columns in which a case runs.
    pub columns: Vec<Column>,
    /// Verdicts by case and column.
    pub verdicts: BTreeMap<(usize, Column), Verdict>,
    /// Levels that could not be run, and why.
    pub skipped: Vec<String>,
}

impl Matrix {
    /// How many verdicts are of this kind.
    pub fn count(&self, is: impl Fn(&Verdict) -> bool) -> usize {
        self.verdicts.values().filter(|v| is(v)).count()
    }

    /// How many verdicts are of answers that are off and keep a bound.
    pub fn bounded(&self) -> usize {
        self.count(|v| matches!(v, Verdict::Bounded(_) | Verdict::Off { .. }))
    }

    /// How many times the error of a number the bound is that it keeps, at the median of those that are off.
    pub fn room(&self) -> Option<f64> {
        let room = |verdict: &Verdict| match verdict {
            Verdict::Off { by, most } => Some(most / by),
            _ => None,
        };
        let mut rooms: Vec<f64> = self.verdicts.values().filter_map(room).collect();
        rooms.sort_by(f64::total_cmp);
        rooms.get(rooms.len() / 2).copied()
    }

    /// True if an answer is wrong that is not listed as failing by design.
    pub fn is_wrong(&self) -> bool {
        self.count(|v| matches!(v, Verdict::Wrong(_))) > 0
    }

    /// The name of a column's setting; on the host everything is exact.
    pub fn setting(&self, column: Column) -> &str {
        match column.level {
            Level::Host => "exact",
            _ => &self.settings[column.setting].name,
        }
    }
}

impl Verdict {
    /// The verdict in a word, and what is said of it.
    pub fn told(&self) -> (&'static str, Cow<'_, str>) {
        match self {
            Verdict::Right => ("right", "".into()),
            Verdict::Bounded(what) => ("bounded", what.into()),
            Verdict::Off { by, most } => (
                "bounded",
                format!("off by {by:.1e}, at most {most:.1e}").into(),
            ),
            Verdict::Wrong(what) => ("wrong", what.into()),
            Verdict::Unbounded(what) => ("unbounded", what.into()),
        }
    }
}

/// Verdicts on all cases, as they are written.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Listing {
    /// The settings of the machine, by name.
    pub settings: Vec<String>,
    /// Levels that could not be run, and why.
    pub skipped: Vec<String>,
    /// Answers that are wrong and are not listed as failing by design.
    pub wrong: usize,
    /// Answers that are other ones than the right ones, and that nothing bounds.
    #[serde(default)]
    pub unbounded: usize,
    /// How many times the error of a number the bound is that it keeps, at the median of those that are off; null where none is.
    pub room: Option<f64>,
    /// The cases.
    pub cases: Vec<ListedCase>,
}

impl Contents for Listing {
    const FORMAT: &'static str = "srp-hard-cases";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp hard-cases --json`";
}

/// Cases without verdicts, as they are written.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct CaseList {
    /// The cases.
    pub cases: Vec<WrittenCase>,
}

impl CaseList {
    /// The list of some cases.
    pub fn of(cases: &[Case]) -> CaseList {
        CaseList {
            cases: cases.iter().map(WrittenCase::of).collect(),
        }
    }
}

impl Contents for CaseList {
    const FORMAT: &'static str = "srp-cases";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp hard-cases --list --json`";
}

/// A case as it is written.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct WrittenCase {
    /// Its name.
    pub id: String,
    /// What it tries.
    pub title: String,
    /// Where it is written down, `file:line`.
    pub place: String,
    /// The function that is called.
    pub call: String,
    /// Its arguments.
    pub arguments: Vec<Argument>,
    /// The answer that it has to give.
    pub gives: Vec<String>,
    /// Other answers that it may give.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub may: Vec<Vec<String>>,
    /// The answer on machines that flush subnormals, where it is another one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flushed: Vec<String>,
    /// How far it may be off, in units of the last place.
    pub within_ulp: f64,
    /// Approximate units, and how often their error may go into the answer.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub costs: Vec<Allowance>,
    /// Triangle tests that may lose the ray, or this share of many.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loses: Vec<Allowance>,
    /// The code that computes the answer again.
    pub oracle: String,
    /// The source that describes such cases.
    pub source: String,
    /// Levels that it runs at.
    pub levels: Vec<String>,
}

/// A case with its verdicts, as it is written.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ListedCase {
    /// The case.
    #[serde(flatten)]
    pub case: WrittenCase,
    /// Its verdicts.
    pub results: Vec<CaseResult>,
}

/// An argument of a case.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Argument {
    /// Its name.
    pub name: String,
    /// Its words in hexadecimal.
    pub bits: Vec<String>,
}

/// A unit or a triangle test, and the number that goes with it.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Allowance {
    /// Its name.
    pub name: String,
    /// How often, or which share.
    pub number: f64,
}

impl Allowance {
    fn all(pairs: &[(String, f64)]) -> Vec<Allowance> {
        let named = pairs.iter().map(|(name, number)| Allowance {
            name: name.clone(),
            number: *number,
        });
        named.collect()
    }
}

/// A verdict as it is written.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct CaseResult {
    /// The level.
    pub level: String,
    /// The setting of the machine.
    pub setting: String,
    /// `right`, `bounded` (wrong by design, within its bound), `unbounded` (another answer, with no bound in this setting)
    /// or `wrong`.
    pub verdict: String,
    /// What is said of it.
    pub what: String,
}

impl Listing {
    /// The verdicts of a matrix.
    pub fn of(matrix: &Matrix) -> Listing {
        let cases = matrix.cases.iter().enumerate();
        Listing {
            settings: matrix.settings.iter().map(|s| s.name.clone()).collect(),
            skipped: matrix.skipped.clone(),
            wrong: matrix.count(|v| matches!(v, Verdict::Wrong(_))),
            unbounded: matrix.count(|v| matches!(v, Verdict::Unbounded(_))),
            room: matrix.room(),
            cases: cases.map(|(i, case)| listed(matrix, i, case)).collect(),
        }
    }
}

fn listed(matrix: &Matrix, i: usize, case: &Case) -> ListedCase {
    let results = matrix.verdicts.iter().filter(|((c, _), _)| *c == i);
    let results = results.map(|((_, column), verdict)| {
        let (verdict, what) = verdict.told();
        CaseResult {
            level: column.level.name().to_owned(),
            setting: matrix.setting(*column).to_owned(),
            verdict: verdict.to_owned(),
            what: what.into_owned(),
        }
    });
    ListedCase {
        case: WrittenCase::of(case),
        results: results.collect(),
    }
}

impl WrittenCase {
    fn of(case: &Case) -> WrittenCase {
        let arguments = case.arguments.iter().map(|(name, words)| Argument {
            name: name.clone(),
            bits: words.iter().map(|word| format!("{word:08x}")).collect(),
        });
        WrittenCase {
            id: case.id.clone(),
            title: case.title.clone(),
            place: case.place.clone(),
            call: case.call.clone(),
            arguments: arguments.collect(),
            gives: case.gives.clone(),
            may: case.may.clone(),
            flushed: case.flushed.clone(),
            within_ulp: case.within,
            costs: Allowance::all(&case.costs),
            loses: Allowance::all(&case.loses),
            oracle: case.oracle.name().to_owned(),
            source: case.source.clone(),
            levels: case.levels.iter().map(|l| l.name().to_owned()).collect(),
        }
    }
}
