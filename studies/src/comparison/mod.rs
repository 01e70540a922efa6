//! What two runs differ in: where the cycles, the traffic and the energy of one went beside another's.
//!
//! Two accounts of frames (`srp render --report`) are compared part by part, two profiles (`--profile`) by loop,
//! function and source line. Every list of cycles sums to the difference of the whole, so that what is not named
//! is not there. Runs that do not fit each other are refused rather than compared.

mod frame;
mod profile;

use crate::Error;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;
use srp_archdesc::diagnostic::Source;
use srp_toolchain::envelope::{self, Contents, Expected, Head, Named};
use srp_toolchain::json;
use std::collections::BTreeMap;

/// The account of a frame.
pub const FRAME: Expected = Expected {
    format: "srp-frame",
    version: 2,
    written_by: "`srp render --report FILE.json` at a level with a clock",
};

/// A profile.
pub const PROFILE: Expected = Expected {
    format: "srp-profile",
    version: 2,
    written_by: "`--profile FILE.json` of `srp run` and `srp render`",
};

/// The differences between two runs.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Comparison {
    /// The format of both documents.
    pub of: &'static str,
    /// The machine of each.
    pub machines: [Named; 2],
    /// What a reader should know before the figures.
    pub notes: Vec<String>,
    /// What counts most: the cycles of all cores, or of the frame.
    pub cycles: Change,
    /// Other figures of the whole.
    pub figures: Vec<Change>,
    /// What changed, by kind.
    pub sections: Vec<Section>,
}

impl Contents for Comparison {
    const FORMAT: &'static str = "srp-diff";
    const VERSION: u32 = 2;
    const WRITTEN_BY: &'static str = "`srp diff OLD NEW --json` of two frames or two profiles";
}

impl Comparison {
    /// True if the second took more cycles than the first and so many per cent of them.
    pub fn is_slower(&self, tolerance: f64) -> bool {
        self.cycles.difference() > self.cycles.old.unwrap_or(0.0) * tolerance / 100.0
    }
}

/// Figures of one kind that differ. Less of each is better.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Section {
    /// What they are.
    pub name: &'static str,
    /// Their unit.
    pub unit: &'static str,
    /// Those that differ: what grew most first, what shrank most last.
    pub changes: Vec<Change>,
    /// How many are the same.
    pub same: usize,
}

/// A figure of both runs.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Change {
    /// What it is of.
    pub what: String,
    /// In the first run; null where the first has nothing of the kind.
    pub old: Option<f64>,
    /// In the second run.
    pub new: Option<f64>,
    /// What else changed there, such as `II 11 → 12`.
    pub why: Vec<String>,
}

impl Change {
    fn new(what: impl Into<String>, old: Option<f64>, new: Option<f64>) -> Change {
        Change {
            what: what.into(),
            old,
            new,
            why: Vec::new(),
        }
    }

    /// The second less the first; what is not there is 0.
    pub fn difference(&self) -> f64 {
        self.new.unwrap_or(0.0) - self.old.unwrap_or(0.0)
    }
}

/// Compares two documents.
///
/// # Errors
///
/// One of them is neither an account of a frame nor a profile, they are not of the same kind, or not of the same
/// frame.
pub fn compare(old: &Source, new: &Source) -> Result<Comparison, Error> {
    let [old, new] = [Document::of(old)?, Document::of(new)?];
    if old.head.format != new.head.format {
        return Err(Error::invalid(format_args!(
            "{} is {}, but {} is {}: give two of a kind",
            old.file,
            in_words(&old.head),
            new.file,
            in_words(&new.head)
        )));
    }
    match is_frame(&old.head) {
        true => frame::compare(&old, &new),
        false => profile::compare(&old, &new),
    }
}

fn is_frame(head: &Head) -> bool {
    head.format == FRAME.format
}

fn in_words(head: &Head) -> &'static str {
    match is_frame(head) {
        true => "the account of a frame",
        false => "a profile",
    }
}

/// A document, read member by member.
struct Document<'a> {
    file: &'a str,
    head: Head,
    value: Value,
}

impl<'a> Document<'a> {
    fn of(source: &'a Source) -> Result<Document<'a>, Error> {
        Ok(Document {
            file: &source.name,
            head: envelope::read(source, &[FRAME, PROFILE])?,
            value: json::read(source)?,
        })
    }

    fn machine(&self) -> Result<Named, Error> {
        (self.head.machine.clone()).ok_or_else(|| self.lacks("/machine", "machine"))
    }

    fn scene(&self) -> Result<&Named, Error> {
        (self.head.scene.as_ref()).ok_or_else(|| self.lacks("/scene", "scene"))
    }

    fn number(&self, pointer: &str) -> Result<f64, Error> {
        self.number_in(&self.value, pointer)
    }

    fn number_in(&self, part: &Value, pointer: &str) -> Result<f64, Error> {
        let number = part.pointer(pointer).and_then(Value::as_f64);
        number.ok_or_else(|| self.lacks(pointer, "number"))
    }

    /// A number that documents of earlier versions lack where it is 0.
    fn count_in(&self, part: &Value, pointer: &str) -> Result<f64, Error> {
        match part.pointer(pointer) {
            None => Ok(0.0),
            Some(_) => self.number_in(part, pointer),
        }
    }

    fn text_in<'v>(&self, part: &'v Value, pointer: &str) -> Result<&'v str, Error> {
        let text = part.pointer(pointer).and_then(Value::as_str);
        text.ok_or_else(|| self.lacks(pointer, "text"))
    }

    fn list_in<'v>(&self, part: &'v Value, pointer: &str) -> Result<&'v [Value], Error> {
        let list = part.pointer(pointer).and_then(Value::as_array);
        let list = list.ok_or_else(|| self.lacks(pointer, "list"))?;
        Ok(list)
    }

    fn list(&self, pointer: &str) -> Result<&[Value], Error> {
        self.list_in(&self.value, pointer)
    }

    fn lacks(&self, pointer: &str, kind: &str) -> Error {
        let (file, what) = (self.file, in_words(&self.head));
        Error::invalid(format_args!(
            "{file}: {what} has a {kind} at `{pointer}`: write it again"
        ))
    }
}

/// Figures of one run by what they are of.
type Figures = BTreeMap<String, f64>;

fn add(figures: &mut Figures, what: impl Into<String>, figure: f64) {
    *figures.entry(what.into()).or_default() += figure;
}

/// Figures of both runs.
fn changes(old: &Figures, new: &Figures) -> Vec<Change> {
    let gone = old.keys().filter(|what| !new.contains_key(*what));
    let whats = gone.chain(new.keys());
    let change = |what: &String| Change::new(what, old.get(what).copied(), new.get(what).copied());
    whats.map(change).collect()
}

impl Section {
    /// Those of the figures that differ, or whose reasons do.
    fn of(name: &'static str, unit: &'static str, all: Vec<Change>) -> Section {
        let is_there = |c: &&Change| c.old.unwrap_or(0.0) != 0.0 || c.new.unwrap_or(0.0) != 0.0;
        let known = all.iter().filter(is_there).count();
        let differs = |c: &Change| c.difference() != 0.0 || !c.why.is_empty();
        let mut changes: Vec<Change> = all.into_iter().filter(differs).collect();
        changes.sort_by(|a, b| {
            let order = b.difference().total_cmp(&a.difference());
            order.then_with(|| a.what.cmp(&b.what))
        });
        Section {
            name,
            unit,
            same: known.saturating_sub(changes.len()),
            changes,
        }
    }
}
