//! The source that a profile is about, as far as it can be read again.

use crate::files;
use srp_studies::profile::{Parts, Profile};
use std::collections::BTreeMap;
use std::ops::AddAssign;

/// Lines without cycles between lines with some that are shown all the same.
const GAP: u32 = 3;

/// A file is worth its lines in text from the WORTH-th part of all cycles on.
const WORTH: u64 = 20;

/// The source of each file that took cycles.
pub(super) struct Listing {
    pub(super) files: Vec<File>,
    /// The cost of code of no line.
    pub(super) nowhere: Cost,
}

/// A file: its stretches with cycles.
pub(super) struct File {
    pub(super) name: String,
    pub(super) cost: Cost,
    pub(super) stretches: Vec<Vec<Line>>,
}

/// A line, with its cycles.
pub(super) struct Line {
    pub(super) number: u32,
    pub(super) text: String,
    pub(super) cost: Cost,
}

/// Cycles, and the energy of what was done.
#[derive(Clone, Copy, Default)]
pub(super) struct Cost {
    pub(super) parts: Parts,
    /// mJ at 65 nm; 0 where it is not known, as outside frames.
    pub(super) mj: f64,
}

impl AddAssign for Cost {
    fn add_assign(&mut self, other: Cost) {
        self.parts += other.parts;
        self.mj += other.mj;
    }
}

impl Listing {
    pub(super) fn of(profile: &Profile) -> Listing {
        let cycles = profile.lines.iter().map(|l| {
            let (parts, mj) = (l.parts, 0.0);
            (&l.file, l.line, Cost { parts, mj })
        });
        let energy = profile.frame.iter().flat_map(|f| &f.energy_of_lines);
        let energy = energy.map(|l| {
            let (parts, mj) = (Parts::default(), l.mj);
            (&l.file, l.line, Cost { parts, mj })
        });
        let mut nowhere = Cost::default();
        let mut files: BTreeMap<&str, BTreeMap<u32, Cost>> = BTreeMap::new();
        for (file, line, cost) in cycles.chain(energy) {
            match line {
                0 => nowhere += cost,
                number => *files.entry(file).or_default().entry(number).or_default() += cost,
            }
        }
        let mut files: Vec<File> = (files.iter())
            .map(|(name, lines)| File::of(name, lines))
            .collect();
        files.sort_by_key(|file| std::cmp::Reverse(file.cost.parts.total()));
        Listing { files, nowhere }
    }

    /// Files that are worth their lines: the first, and others down to a part of all cycles.
    pub(super) fn shown(&self, all: u64) -> usize {
        let worth = |file: &&File| file.cost.parts.total() * WORTH >= all;
        self.files
            .iter()
            .take_while(worth)
            .count()
            .max(1)
            .min(self.files.len())
    }
}

impl File {
    fn of(name: &str, lines: &BTreeMap<u32, Cost>) -> File {
        let source = files::source_text(name);
        let source: Vec<&str> = source.lines().collect();
        let line = |number: u32| Line {
            number,
            text: (number.checked_sub(1))
                .and_then(|i| source.get(i as usize))
                .map_or(String::new(), |text| text.replace('\t', "    ")),
            cost: lines.get(&number).copied().unwrap_or_default(),
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
        let mut cost = Cost::default();
        lines.values().for_each(|line| cost += *line);
        File {
            name: name.to_owned(),
            cost,
            stretches,
        }
    }
}
