//! The measures of a sweep.

use crate::Error;
use crate::fidelity::Fidelity;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Something that is measured.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Initiation intervals of the loops on the array.
    Ii,
    /// Cycles, time and frames a second.
    Cycles,
    /// Energy of a frame.
    Energy,
    /// Area of the chip.
    Area,
    /// The picture's distance from binary64.
    Psnr,
}

impl Measure {
    /// All of them.
    pub const ALL: [Measure; 5] = [
        Measure::Ii,
        Measure::Cycles,
        Measure::Energy,
        Measure::Area,
        Measure::Psnr,
    ];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Measure::Ii => "ii",
            Measure::Cycles => "cycles",
            Measure::Energy => "energy",
            Measure::Area => "area",
            Measure::Psnr => "psnr",
        }
    }

    /// Columns that are the same for all rows; `ii` has one more for each loop.
    pub(super) const COLUMNS: [(&'static str, Measure); 11] = [
        ("ii", Measure::Ii),
        ("cycles", Measure::Cycles),
        ("cycles.half-interval", Measure::Cycles),
        ("ms", Measure::Cycles),
        ("fps", Measure::Cycles),
        ("energy", Measure::Energy),
        ("energy.pj-per-ray", Measure::Energy),
        ("area", Measure::Area),
        ("area.srp", Measure::Area),
        ("area.tni", Measure::Area),
        ("psnr", Measure::Psnr),
    ];

    /// The measure that has a column.
    pub(super) fn of_column(column: &str) -> Option<Measure> {
        let mut fixed = Measure::COLUMNS.into_iter();
        let fixed = fixed.find(|(name, _)| *name == column);
        let of_loop = || column.strip_prefix("ii.").filter(|name| !name.is_empty());
        fixed
            .map(|(_, measure)| measure)
            .or_else(|| of_loop().map(|_| Measure::Ii))
    }

    pub(super) fn parse(name: &str) -> Result<Measure, Error> {
        let found = Measure::ALL.into_iter().find(|m| m.name() == name);
        found.ok_or_else(|| {
            let names: Vec<&str> = Measure::ALL.iter().map(|m| m.name()).collect();
            Error::Invalid(format!("measure `{name}`: there are {}", names.join(", ")))
        })
    }

    /// Refuses what only frames have.
    pub(super) fn check_of_program(self) -> Result<(), Error> {
        match self {
            Measure::Energy | Measure::Psnr => Err(Error::Invalid(format!(
                "a program has no {}, which is of frames: measure ii, cycles or area, or sweep a scene",
                self.name()
            ))),
            Measure::Ii | Measure::Cycles | Measure::Area => Ok(()),
        }
    }

    /// Refuses what a level of simulation does not know.
    pub(super) fn check(self, level: Fidelity) -> Result<(), Error> {
        let known = match self {
            Measure::Cycles => level != Fidelity::Functional,
            Measure::Energy => level >= Fidelity::Cycle,
            _ => true,
        };
        match known {
            true => Ok(()),
            false => Err(Error::Invalid(format!(
                "a frame at the level `{}` has no {}: leave one of the two out",
                level.name(),
                self.name()
            ))),
        }
    }

    /// The direction in which figures of a column are better.
    pub fn is_better_larger(column: &str) -> bool {
        matches!(column, "psnr" | "fps")
    }
}
