//! The record of an exact search: what it asked, the answers, and why it ended.

use super::MAX_STAGES;
use super::exact::{self, Answer, Scope};
use super::problem::Problem;
use serde::{Deserialize, Serialize};

/// The exact search of a loop.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Search {
    /// What it asked, by II.
    pub asked: Vec<Asked>,
    /// Why it ended.
    pub stopped: Stopped,
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stopped {
    /// The II is the bound.
    AtBound,
    /// Every lower II was proved impossible, at any length.
    Impossible,
    /// Every question was asked that there is, and answered or found too large.
    NothingLeft,
    /// It had taken its steps.
    Steps,
    /// It had taken its time, or was interrupted.
    Time,
}

/// A question, and the last answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Asked {
    /// The II.
    pub ii: u32,
    /// The formula.
    pub scope: Scope,
    /// The answer.
    pub outcome: Outcome,
    /// How often it was asked, each time with more conflicts.
    pub times: u32,
    /// Steps that it took in all.
    pub steps: u64,
}

/// An answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Outcome {
    /// There is a schedule.
    Schedule,
    /// There is none: at any length where it is outright, else within the horizon.
    Impossible {
        /// At any length.
        outright: bool,
    },
    /// The folded formula has a model, or is not of this machine, which says nothing.
    Silent,
    /// The solver gave up.
    Unknown,
    /// The formula is too large.
    TooLarge,
    /// The schedule that was found has too many stages.
    TooLong,
}

impl Outcome {
    /// The outcome of a question about an II that was answered so.
    pub(super) fn of(answer: &Answer, problem: &Problem<'_>, ii: u32, scope: Scope) -> Outcome {
        match answer {
            Answer::Placed(found) if found.stages(problem) > MAX_STAGES => Outcome::TooLong,
            Answer::Placed(_) => Outcome::Schedule,
            Answer::Impossible => Outcome::Impossible {
                outright: match scope {
                    Scope::Folded(_) => true,
                    Scope::Timed { slack } => exact::is_complete(problem, ii, slack),
                },
            },
            Answer::Silent => Outcome::Silent,
            Answer::Unknown => Outcome::Unknown,
            Answer::TooLarge => Outcome::TooLarge,
        }
    }

    /// True if it may be asked again.
    pub(super) fn is_open(self) -> bool {
        matches!(self, Outcome::Unknown | Outcome::Schedule)
    }
}
