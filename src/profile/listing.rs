//! The source that a profile is about, as far as it can be read again.

use crate::files;
use srp_studies::profile::{Parts, Profile};
use std::collections::BTreeMap;

/// Lines without cycles between lines with some that are shown all the same.
const GAP: u32 = 3;

/// A file is worth its lines in text from the WORTH-th part of all cycles on.
const WORTH: u64 = 20;

/// The source of each file that took cycles.
pub(super) struct Listing {
    pub(super) files: Vec<File>,
    /// Cycles of which no line is known.
    pub(super) nowhere: Parts,
}

/// A file: its stretches with cycles.
pub(super) struct File {
    pub(super) name: String,
    pub(super) parts: Parts,
    pub(super) stretches: Vec<Vec<Line>>,
}

/// A line, with its cycles.
pub(super) struct Line {
    pub(super) number: u32,
    pub(super) text: String,
    pub(super) parts: Parts,
}

impl Listing {
    pub(super) fn of(profile: &Profile) -> Listing {
        let mut nowhere = Parts::default();
        let mut files: BTreeMap<&str, BTreeMap<u32, Parts>> = BTreeMap::new();
        for line in &profile.lines {
            match line.line {
                0 => nowhere += line.parts,
                number => {
                    let file = files.entry(&line.file).or_default();
                    *file.entry(number).or_default() += line.parts;
                }
            }
        }
        let mut files: Vec<File> = (files.iter())
            .map(|(name, lines)| File::of(name, lines))
            .collect();
        files.sort_by_key(|file| std::cmp::Reverse(file.parts.total()));
        Listing { files, nowhere }
    }

    /// Files that are worth their lines: the first, and others down to a part of all cycles.
    pub(super) fn shown(&self, all: u64) -> usize {
        let worth = |file: &&File| file.parts.total() * WORTH >= all;
        self.files
            .iter()
            .take_while(worth)
            .count()
            .max(1)
            .min(self.files.len())
    }
}

impl File {
    fn of(name: &str, lines: &BTreeMap<u32, Parts>) -> File {
        let source = files::source_text(name);
        let source: Vec<&str> = source.lines().collect();
        let line = |number: u32| Line {
            number,
            text: (number.checked_sub(1))
                .and_then(|i| source.get(i as usize))
                .map_or(String::new(), |text| text.replace('\t', "    ")),
            parts: lines.get(&number).copied().unwrap_or_default(),
        };
        let mut stretches: Vec<Vec<Line>> = Vec::new();
        for &number in lines.keys() {
            match stretches.last_mut() {
                Some(stretch) if stretch.last().is_some_and(|l| number <= l.number + GAP) => {
                    let next = stretch.last().map_or(number, |l| l.number + 1);
                    stretch.extend((next..=number).map(line));
                }
                _ => stretches.push(vec![line(number)]),
            }
        }
        let mut parts = Parts::default();
        lines.values().for_each(|line| parts += *line);
        File {
            name: name.to_owned(),
            parts,
            stretches,
        }
    }
}
