//! Verdicts on all cases, as data.

use super::catalogue::{Case, Level};
use super::judge::Verdict;
use super::settings::Setting;
use serde::{Serialize, Serializer};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// A column of the matrix: a level, and there a setting by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Column {
    /// The level.
    pub level: Level,
    /// The setting's number.
    pub setting: usize,
}

/// Verdicts on all cases, in each column that they run in. It is written with the bits of all inputs.
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
    pub fn told(&self) -> (&'static str, &str) {
        match self {
            Verdict::Right => ("right", ""),
            Verdict::Bounded(what) => ("bounded", what),
            Verdict::Wrong(what) => ("wrong", what),
        }
    }
}

impl Serialize for Matrix {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        members(self).serialize(serializer)
    }
}

fn members(matrix: &Matrix) -> Value {
    let hex = |word: &u32| Value::String(format!("{word:08x}"));
    let case = |(i, case): (usize, &Case)| {
        let results = matrix.verdicts.iter().filter(|((c, _), _)| *c == i);
        let results = results.map(|((_, column), v)| {
            let (verdict, what) = v.told();
            json!({
                "level": column.level.name(),
                "setting": matrix.setting(*column),
                "verdict": verdict,
                "what": what,
            })
        });
        let arguments = case.arguments.iter();
        let arguments = arguments.map(|(name, words)| {
            let bits: Vec<Value> = words.iter().map(hex).collect();
            json!({ "name": name, "bits": bits })
        });
        json!({
            "id": case.id,
            "title": case.title,
            "place": case.place,
            "call": case.call,
            "arguments": arguments.collect::<Vec<_>>(),
            "gives": case.gives,
            "within_ulp": case.within,
            "oracle": case.oracle.name(),
            "source": case.source,
            "levels": case.levels.iter().map(|l| l.name()).collect::<Vec<_>>(),
            "results": results.collect::<Vec<_>>(),
        })
    };
    let cases: Vec<Value> = matrix.cases.iter().enumerate().map(case).collect();
    json!({
        "machine": matrix.machine,
        "settings": matrix.settings.iter().map(|s| &s.name).collect::<Vec<_>>(),
        "skipped": matrix.skipped,
        "wrong": matrix.count(|v| matches!(v, Verdict::Wrong(_))),
        "cases": cases,
    })
}
