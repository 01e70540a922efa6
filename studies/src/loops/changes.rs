//! Changes that lower an II, as reports and tables have them: what they are, what they give, and what they cost.

use crate::bases::{Bases, Made};
use crate::settings;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The outcome of trying changes of the machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WhatIf {
    /// Changes that were tried.
    pub tried: u32,
    /// Those that lower the II, the best first, of those that give the same II the smallest first.
    pub changes: Vec<Change>,
}

/// A change of the machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Change {
    /// The change.
    pub what: String,
    /// The settings of the machine's file that make it, as `--set` takes them; none where it takes more than these.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// The II that the loop then has.
    pub ii: u32,
    /// Area that an SRP then has more, mm² at 65 nm; null of a change that is not of the machine.
    #[serde(default)]
    pub mm2: Option<f64>,
}

impl Change {
    /// That of a machine, and the II that it gives.
    pub(crate) fn of(made: &Made, ii: u32, bases: &Bases<'_>) -> Change {
        Change {
            what: bases.in_words(made),
            set: bases.settings(made),
            ii,
            mm2: Some(bases.more_area(made)),
        }
    }

    /// The change in words, with the arguments that make it.
    pub fn in_words(&self) -> String {
        format!("{}{}", self.what, settings::in_brackets(&self.set))
    }

    /// The II that it gives, and its price: `II = 2, +0.124 mm² an SRP`.
    pub fn result(&self) -> String {
        match self.mm2 {
            Some(mm2) => format!("II = {}, {mm2:+.3} mm² an SRP", self.ii),
            None => format!("II = {}", self.ii),
        }
    }
}

/// A change of the machine, and the loops that it helps.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct Advice {
    /// The change.
    pub what: String,
    /// The settings of the machine's file that make it, as `--set` takes them; none where it takes more than these.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// The loops.
    pub lowers: Vec<Lowered>,
}

impl Advice {
    /// The change in words, with the arguments that make it.
    pub fn in_words(&self) -> String {
        format!("{}{}", self.what, settings::in_brackets(&self.set))
    }
}

/// A loop that a change helps.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct Lowered {
    /// Its kernel.
    pub kernel: String,
    /// Its II on the machine as it is; null where it is not on the array.
    pub from: Option<u32>,
    /// Its II on the changed machine.
    pub to: u32,
}
