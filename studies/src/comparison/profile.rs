//! Two profiles.
//!
//! Lines are compared as an editor's user sees them: a line that moved because another was written above it is
//! the same line. The profiles hold their sources for that.

use super::{Change, Comparison, Document, Figures, PROFILE, Section, add, changes};
use crate::{Error, same_loops};
use serde_json::Value;
use similar::{DiffTag, TextDiff};
use std::collections::BTreeMap;

/// The parts of cycles, with their names.
const PARTS: [(&str, &str); 10] = [
    ("vliw", "VLIW"),
    ("empty", "empty"),
    ("array", "array"),
    ("switch", "switch"),
    ("memory_stall", "memory"),
    ("texture_stall", "texture"),
    ("instruction_stall", "instructions"),
    ("context_stall", "contexts"),
    ("sram_stall", "banks"),
    ("wait", "wait"),
];

/// Compares two profiles.
pub(super) fn compare(old: &Document<'_>, new: &Document<'_>) -> Result<Comparison, Error> {
    let total = |profile: &Document<'_>| total(profile, &profile.value["parts"]);
    let [a, b] = [total(old)?, total(new)?];
    let lines = Lines::between(old, new);
    let mut notes = Vec::new();
    let cores = [old.number("/cores")?, new.number("/cores")?];
    if cores[0] != cores[1] {
        notes.push(format!("cores: {} → {}", cores[0], cores[1]));
    }
    notes.extend(lines.notes());
    let parts = |profile: &Document<'_>| -> Result<Figures, Error> {
        let mut figures = Figures::new();
        for (member, name) in PARTS {
            let cycles = profile.count_in(&profile.value, &format!("/parts/{member}"))?;
            add(&mut figures, name, cycles);
        }
        Ok(figures)
    };
    let functions = |profile: &Document<'_>| by(profile, "/functions", "/name");
    Ok(Comparison {
        of: PROFILE.format,
        machines: [old.machine()?, new.machine()?],
        notes,
        cycles: Change::new("all cores", Some(a), Some(b)),
        figures: Vec::new(),
        sections: vec![
            Section::of(
                "cycles by part",
                "cycles",
                changes(&parts(old)?, &parts(new)?),
            ),
            Section::of(
                "cycles by loop on the array",
                "cycles",
                loops(old, new, &lines)?,
            ),
            Section::of(
                "cycles by function",
                "cycles",
                changes(&functions(old)?, &functions(new)?),
            ),
            Section::of("cycles by line", "cycles", lines.changes(old, new)?),
        ],
    })
}

/// The cycles of a part of an entry. Banks are younger than the form of the document: where they are missing, they have none.
fn part_of(profile: &Document<'_>, entry: &Value, member: &str) -> Result<f64, Error> {
    let pointer = format!("/{member}");
    match member {
        "sram_stall" => profile.count_in(entry, &pointer),
        _ => profile.number_in(entry, &pointer),
    }
}

/// All cycles of an entry.
fn total(profile: &Document<'_>, entry: &Value) -> Result<f64, Error> {
    let cycles = PARTS.map(|(member, _)| part_of(profile, entry, member));
    cycles.into_iter().sum()
}

/// The cycles of the entries of a list, by name.
fn by(profile: &Document<'_>, list: &str, name: &str) -> Result<Figures, Error> {
    let mut figures = Figures::new();
    for entry in profile.list(list)? {
        add(
            &mut figures,
            profile.text_in(entry, name)?,
            total(profile, entry)?,
        );
    }
    Ok(figures)
}

/// The loops, with what of them changed beside their cycles.
fn loops(old: &Document<'_>, new: &Document<'_>, lines: &Lines) -> Result<Vec<Change>, Error> {
    let names = |profile: &Document<'_>| -> Result<Vec<(String, String)>, Error> {
        let loops = profile.list("/loops")?.iter();
        let name_and_place = |l: &Value| {
            let at = l.get("at").and_then(Value::as_str).unwrap_or_default();
            Ok((profile.text_in(l, "/kernel")?.to_owned(), at.to_owned()))
        };
        loops.map(name_and_place).collect()
    };
    let (was, is) = (names(old)?, names(new)?);
    let was = was
        .iter()
        .map(|(name, at)| (name.as_str(), lines.place_now(at)));
    let is = is.iter().map(|(name, at)| (name.as_str(), at.clone()));
    let (was, is): (Vec<_>, Vec<_>) = (was.collect(), is.collect());
    let renamed = same_loops::renamed(&was, &is);
    let mut before = Figures::new();
    for (kernel, cycles) in by(old, "/loops", "/kernel")? {
        let kernel = renamed.get(&kernel).cloned().unwrap_or(kernel);
        before.insert(kernel, cycles);
    }
    let mut changes = changes(&before, &by(new, "/loops", "/kernel")?);
    for change in &mut changes {
        let find = |profile: &Document<'_>, names: &BTreeMap<String, String>| {
            let name = |l: &Value| {
                let name = l["kernel"].as_str()?;
                Some(names.get(name).map_or(name, String::as_str).to_owned())
            };
            let mut loops = profile.list("/loops")?.iter();
            let found = loops.find(|l| name(l).as_ref() == Some(&change.what));
            Ok::<_, Error>(found.cloned())
        };
        let (Some(a), Some(b)) = (find(old, &renamed)?, find(new, &BTreeMap::new())?) else {
            continue;
        };
        for (what, pointer) in [
            ("II", "/ii"),
            ("cycles of an iteration", "/length"),
            ("launches", "/launches"),
            ("iterations", "/iterations/all"),
        ] {
            let [a, b] = [old.number_in(&a, pointer)?, new.number_in(&b, pointer)?];
            if a != b {
                change.why.push(format!("{what} {a} → {b}"));
            }
        }
        for (member, what) in PARTS {
            let difference = part_of(new, &b, member)? - part_of(old, &a, member)?;
            if difference != 0.0 {
                change.why.push(format!("{what} {difference:+}"));
            }
        }
    }
    Ok(changes)
}

/// Which line of an old source is which of the new one.
struct Lines {
    /// By file: the new line of each old one, both from 1.
    moved: BTreeMap<String, BTreeMap<u64, u64>>,
}

impl Lines {
    fn between(old: &Document<'_>, new: &Document<'_>) -> Lines {
        let sources = |profile: &Document<'_>| -> BTreeMap<String, String> {
            let sources = profile.value.get("sources").and_then(Value::as_object);
            let text =
                |(file, text): (&String, &Value)| Some((file.clone(), text.as_str()?.into()));
            sources.into_iter().flatten().filter_map(text).collect()
        };
        let [old, new] = [sources(old), sources(new)];
        let mut moved = BTreeMap::new();
        for (file, before) in &old {
            if let Some(after) = new.get(file).filter(|after| *after != before) {
                moved.insert(file.clone(), kept(before, after));
            }
        }
        Lines { moved }
    }

    /// A place FILE:LINE:COLUMN of the old source in the new one.
    fn place_now(&self, at: &str) -> String {
        let moved = || {
            let (rest, column) = at.rsplit_once(':')?;
            let (file, line) = rest.rsplit_once(':')?;
            let line = self.moved.get(file)?.get(&line.parse().ok()?)?;
            Some(format!("{file}:{line}:{column}"))
        };
        moved().unwrap_or_else(|| at.to_owned())
    }

    fn notes(&self) -> Option<String> {
        let files: Vec<&str> = self.moved.keys().map(String::as_str).collect();
        let files = files.join(", ");
        (!files.is_empty()).then(|| format!("edited: {files}; lines are numbered as in the new"))
    }

    /// The cycles of each line, by its number in the new source.
    fn changes(&self, old: &Document<'_>, new: &Document<'_>) -> Result<Vec<Change>, Error> {
        let was = self.cycles(old, |file, line| match self.moved.get(file) {
            Some(moved) => match moved.get(&line) {
                Some(&line) => named(file, line),
                None => format!("{} (gone)", named(file, line)),
            },
            None => named(file, line),
        })?;
        let is = self.cycles(new, named)?;
        let mut all = changes(&was.total, &is.total);
        for change in &mut all {
            for (_, part) in PARTS {
                let key = format!("{} {part}", change.what);
                let [a, b] = [&was, &is].map(|c| c.parts.get(&key).copied().unwrap_or(0.0));
                if a != b {
                    change.why.push(format!("{part} {:+}", b - a));
                }
            }
        }
        Ok(all)
    }

    fn cycles(
        &self,
        profile: &Document<'_>,
        name: impl Fn(&str, u64) -> String,
    ) -> Result<Cycles, Error> {
        let mut cycles = Cycles::default();
        for line in profile.list("/lines")? {
            let number = profile.number_in(line, "/line")?;
            let what = name(profile.text_in(line, "/file")?, number as u64);
            for (member, part) in PARTS {
                let figure = part_of(profile, line, member)?;
                add(&mut cycles.total, what.clone(), figure);
                add(&mut cycles.parts, format!("{what} {part}"), figure);
            }
        }
        Ok(cycles)
    }
}

/// The cycles of lines.
#[derive(Default)]
struct Cycles {
    total: Figures,
    parts: Figures,
}

fn named(file: &str, line: u64) -> String {
    match line {
        0 => "no line known".to_owned(),
        line => format!("{file}:{line}"),
    }
}

/// The lines of an old text that are in the new one. A line that took the place of another counts as that.
fn kept(old: &str, new: &str) -> BTreeMap<u64, u64> {
    let mut kept = BTreeMap::new();
    for op in TextDiff::from_lines(old, new).ops() {
        if let DiffTag::Equal | DiffTag::Replace = op.tag() {
            let pairs = op.old_range().zip(op.new_range());
            kept.extend(pairs.map(|(a, b)| (a as u64 + 1, b as u64 + 1)));
        }
    }
    kept
}
