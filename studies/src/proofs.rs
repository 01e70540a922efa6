//! Proofs that an II is impossible, and the searches that found them, as reports and tables have them.
//! `docs/proofs.md` says what is proved.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use srp_scheduler::modulo::{self, Outcome, Scope, Stopped};

/// A proof that there is no schedule with an II.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Impossible {
    /// The II.
    pub ii: u32,
    /// Null if there is no schedule of any length. Else the proof holds where no operation is issued later than so
    /// many cycles after its latest start on the critical path.
    pub slack: Option<u32>,
    /// The formula that was refuted.
    #[serde(default)]
    pub formula: String,
}

impl Impossible {
    /// A proof of the scheduler.
    pub fn of(proof: &modulo::Impossible) -> Impossible {
        Impossible {
            ii: proof.ii,
            slack: proof.slack(),
            formula: formula(proof.scope),
        }
    }

    /// The proof in words: `II = 3 is impossible`, or up to which horizon.
    pub fn in_words(&self) -> String {
        format!("II = {} is {}", self.ii, reach(self.slack))
    }
}

/// How far it is that something is impossible: outright, or up to a horizon.
pub fn reach(slack: Option<u32>) -> String {
    match slack {
        None => "impossible".to_owned(),
        Some(1) => "impossible up to 1 cycle beyond the critical path".to_owned(),
        Some(slack) => format!("impossible up to {slack} cycles beyond the critical path"),
    }
}

/// The name of a formula: `timed, slack 3` or `folded, laps 2, depth 4`.
pub(crate) fn formula(scope: Scope) -> String {
    match scope {
        Scope::Timed { slack } => format!("timed, slack {slack}"),
        Scope::Folded(fold) => format!("folded, laps {}, depth {}", fold.laps, fold.depth),
    }
}

/// An exact search.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Search {
    /// The questions below the II that was found, and that II's, in the order of II and formula.
    pub asked: Vec<Asked>,
    /// Why it ended: `at-bound`, `impossible`, `nothing-left`, `steps`, `time`; empty where there was none.
    pub stopped: String,
}

/// A question of an exact search.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Asked {
    /// The II.
    pub ii: u32,
    /// The formula that says that there is a schedule.
    pub formula: String,
    /// The last answer: `schedule`, `impossible` (at any length), `impossible-within` (its slack), `silent` (a
    /// folded formula with a model, which says nothing), `unknown`, `too-large`, `too-many-stages`.
    pub answer: String,
    /// How often it was asked.
    pub times: u32,
    /// Steps that it took in all.
    pub steps: u64,
}

impl Search {
    /// A search of the scheduler.
    pub fn of(search: &modulo::Search) -> Search {
        let asked = |asked: &modulo::Asked| Asked {
            ii: asked.ii,
            formula: formula(asked.scope),
            answer: answer(asked.outcome).to_owned(),
            times: asked.times,
            steps: asked.steps,
        };
        Search {
            asked: search.asked.iter().map(asked).collect(),
            stopped: stopped(search.stopped).to_owned(),
        }
    }
}

fn answer(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Schedule => "schedule",
        Outcome::Impossible { outright: true } => "impossible",
        Outcome::Impossible { outright: false } => "impossible-within",
        Outcome::Silent => "silent",
        Outcome::Unknown => "unknown",
        Outcome::TooLarge => "too-large",
        Outcome::TooLong => "too-many-stages",
    }
}

fn stopped(stopped: Stopped) -> &'static str {
    match stopped {
        Stopped::AtBound => "at-bound",
        Stopped::Impossible => "impossible",
        Stopped::NothingLeft => "nothing-left",
        Stopped::Steps => "steps",
        Stopped::Time => "time",
    }
}
