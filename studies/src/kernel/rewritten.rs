//! Rewrites of single expressions, and what each gains.

use super::setting::Subject;
use super::subject::Kernel;
use super::trial::{Costs, Measure, Trial};
use schemars::JsonSchema;
use serde::Serialize;
use srp_ir::pass::{self, Rewrite};
use srp_ir::program::Program;

/// Rewrites that are tried, at most.
const MOST_REWRITES: usize = 40;

/// Bits lost that are too few to speak of.
const SAME_BITS: f64 = 0.02;

/// A rewrite that was tried alone.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Rewritten {
    /// Rule and place.
    pub name: String,
    /// The forms before and after it.
    pub what: &'static str,
    /// How a user says it.
    pub how: String,
    /// Why it could not be tried.
    pub failed: Option<String>,
    /// How far the results are off then.
    pub error: Measure,
    /// Its cost.
    pub costs: Costs,
    /// Its gain over the text as it stands.
    pub gain: Gain,
}

/// The gain of a rewrite over the text as it stands, the best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Gain {
    /// More digits at a lower II, or in fewer cycles where no loop is on the array.
    Both,
    /// More digits at the same II.
    Digits,
    /// As many digits at a lower II.
    Cycles,
    /// More digits at a higher II.
    DigitsForCycles,
    /// Fewer digits at a lower II.
    CyclesForDigits,
    /// Neither more digits nor a lower II.
    Nothing,
}

impl Gain {
    /// In a few words.
    pub const fn words(self) -> &'static str {
        match self {
            Gain::Both => "more digits, and faster",
            Gain::Digits => "more digits at the same pace",
            Gain::Cycles => "the same digits, faster",
            Gain::DigitsForCycles => "more digits, slower",
            Gain::CyclesForDigits => "faster, fewer digits",
            Gain::Nothing => "nothing gained",
        }
    }

    fn of(error: &Measure, costs: &Costs, base: &Trial) -> Gain {
        use std::cmp::Ordering::{Equal, Greater, Less};
        let bits = error.bits - base.error.bits;
        let bits = match bits.abs() <= SAME_BITS {
            true => error.not_finite.cmp(&base.error.not_finite),
            false => bits.total_cmp(&0.0),
        };
        // Loops of equal intervals are equally fast, whatever the way into them and out takes.
        let names = |costs: &Costs| {
            costs
                .ii
                .iter()
                .map(|(name, _)| name.clone())
                .collect::<Vec<_>>()
        };
        let sum = |costs: &Costs| costs.ii.iter().map(|(_, ii)| ii).sum::<u32>();
        let share = costs.cycles / base.costs.cycles.max(1.0);
        let pace = match names(costs) == names(&base.costs) && !costs.ii.is_empty() {
            true => sum(costs).cmp(&sum(&base.costs)),
            false if (0.99..=1.01).contains(&share) => Equal,
            false => share.total_cmp(&1.0),
        };
        match (bits, pace) {
            (Less, Less) => Gain::Both,
            (Less, Equal) => Gain::Digits,
            (Equal, Less) => Gain::Cycles,
            (Less, Greater) => Gain::DigitsForCycles,
            (Greater, Less) => Gain::CyclesForDigits,
            _ => Gain::Nothing,
        }
    }
}

impl Rewritten {
    pub(super) fn of(rewrite: &Rewrite, name: &str, trial: &Trial, base: &Trial) -> Rewritten {
        let gain = match trial.failed {
            Some(_) => Gain::Nothing,
            None => Gain::of(&trial.error, &trial.costs, base),
        };
        Rewritten {
            name: name.to_owned(),
            what: rewrite.rule.what(),
            how: trial.how.clone(),
            failed: trial.failed.clone(),
            error: trial.error.clone(),
            costs: trial.costs.clone(),
            gain,
        }
    }
}

/// The rewrites that the kernel's program has places for, each with its place as the user knows it.
pub(super) fn rewrites(
    kernel: &Kernel,
    program: &Program,
    base: &Subject,
) -> Vec<(Rewrite, String)> {
    let options = pass::Options::new(base.arch.precision);
    let is_own = |file: &str| kernel.sources.iter().any(|source| source.name == file);
    let mut all = Vec::new();
    for rewrite in pass::places(program, &options) {
        let Some(file) = rewrite.file.as_deref().filter(|file| is_own(file)) else {
            continue;
        };
        let place = match kernel.lines.get(&rewrite.line) {
            Some(at) => format!("{}:{}", kernel.file, at.line),
            None if kernel.sources.len() == 1 => rewrite.line.to_string(),
            None => format!("{file}:{}", rewrite.line),
        };
        let is_asked = base.options.rewrites.iter();
        let is_asked = is_asked.filter(|wish| wish.rule == rewrite.rule);
        if is_asked.clone().any(|wish| wish.is_at(file, rewrite.line)) {
            continue;
        }
        // Lines of what was made of a benchmark may be of one line of it.
        let same = |(known, at): &&(Rewrite, String)| known.rule == rewrite.rule && *at == place;
        let place = match all.iter().find(same) {
            Some(_) => format!("{place}({})", rewrite.line),
            None => place,
        };
        all.push((rewrite, place));
    }
    all.truncate(MOST_REWRITES);
    all
}
