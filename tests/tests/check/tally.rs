//! Outcomes of the damage, by its kind.

use srp_ir::check::{Rule, Violation};
use std::fmt::Write;

/// The possible harm of a kind of damage.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Harm {
    /// It breaks one of the rules each time.
    Always,
    /// Where the checker finds nothing, the program has to do what it did.
    Perhaps,
}

/// How often a kind of damage was tried, and what became of it.
#[derive(Default)]
struct Count {
    caught: u32,
    harmless: u32,
    missed: Vec<String>,
}

/// The outcome of all kinds.
#[derive(Default)]
pub(crate) struct Tally {
    counts: Vec<(&'static str, Harm, Count)>,
}

impl Tally {
    /// Notes what came of one damaged schedule: what the checker said, and, where that was nothing,
    /// in what `difference` the damage shows.
    pub(crate) fn note(
        &mut self,
        (name, harm, rules): (&'static str, Harm, &[Rule]),
        place: &str,
        violations: &[Violation],
        difference: impl FnOnce() -> Option<String>,
    ) {
        let count = self.count(name, harm);
        if violations.iter().any(|v| rules.contains(&v.rule)) {
            count.caught += 1;
        } else if let Some(violation) = violations.first() {
            count
                .missed
                .push(format!("{place}: found {violation} instead"));
        } else if harm == Harm::Always {
            count.missed.push(format!("{place}: nothing found"));
        } else {
            match difference() {
                None => count.harmless += 1,
                Some(what) => count.missed.push(format!("{place}: {what}")),
            }
        }
    }

    fn count(&mut self, name: &'static str, harm: Harm) -> &mut Count {
        let at = self.counts.iter().position(|(n, ..)| *n == name);
        let at = at.unwrap_or_else(|| {
            self.counts.push((name, harm, Count::default()));
            self.counts.len() - 1
        });
        &mut self.counts[at].2
    }

    /// Prints a line for each kind, and fails where something was missed, or where a kind of
    /// `names` was not caught at least `least` times.
    pub(crate) fn finish(self, names: impl Iterator<Item = &'static str>, least: u32) {
        let mut faults = String::new();
        for (name, harm, count) in &self.counts {
            let Count {
                caught,
                harmless,
                missed,
            } = count;
            let all = caught + harmless + missed.len() as u32;
            let still = match harm {
                Harm::Always => String::new(),
                Harm::Perhaps => format!(", {harmless} still right"),
            };
            println!(
                "{caught:4} of {all:4} caught{still}, {} missed: {name}",
                missed.len()
            );
            for what in missed.iter().take(3) {
                writeln!(faults, "{name}: {what}").expect("a string takes everything");
            }
        }
        for name in names {
            let found = self.counts.iter().find(|(n, ..)| *n == name);
            let caught = found.map_or(0, |(_, _, count)| count.caught);
            if caught < least {
                writeln!(
                    faults,
                    "{name}: caught {caught} times, which shows too little"
                )
                .expect("a string takes everything");
            }
        }
        assert!(faults.is_empty(), "{faults}");
    }
}
