//! Costs of hardware: cycles, area and energy of units that follow from their structure and
//! precision, and of memories. [`chip`](mod@crate::chip) adds them up.
//!
//! All figures are for 65 nm, and its constants are fitted to published ones; `docs/costs.md` names the
//! sources and holds units of the model against units that were built. Area and energy of other
//! technologies are those times [`Technology`]'s factors. Absolute energies differ about tenfold between
//! bare datapaths, synthesis and measured silicon: these are of the class of synthesis (SimTRaX,
//! 65 nm), and ratios between units are what to trust.

pub mod cache;
pub mod memory;
pub mod operator;
pub mod pipeline;
pub mod special;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Area and energy of a part of a unit, and its share of the way through it.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Part {
    /// Its name in listings.
    pub name: String,
    /// Area, µm².
    pub area_um2: f64,
    /// Energy of one use, pJ.
    pub energy_pj: f64,
    /// How long it holds up what comes after it: in delays of an inverter with four others behind it.
    pub fo4: f64,
}

impl Part {
    /// A part.
    pub fn new(name: impl Into<String>, area_um2: f64, energy_pj: f64, fo4: f64) -> Part {
        Part {
            name: name.into(),
            area_um2,
            energy_pj,
            fo4,
        }
    }
}

/// Picoseconds of an inverter's delay with a fan-out of four, 65 nm.
pub const FO4_PS: f64 = 25.0;

/// Delays that registers, skew and jitter take of a cycle.
pub const OVERHEAD: f64 = 8.0;

/// The least that is left of a cycle.
pub const LEAST_FO4: f64 = 4.0;

/// The delays of logic that fit between two registers at a clock; 32 at 1 GHz.
pub fn usable_fo4(mhz: u32) -> f64 {
    (1e6 / f64::from(mhz) / FO4_PS - OVERHEAD).max(LEAST_FO4)
}

/// Cycles of a pipeline through so many delays of logic.
pub fn cycles(fo4: f64, mhz: u32) -> u32 {
    (fo4 / usable_fo4(mhz) - 1e-9).ceil().max(1.0) as u32
}

/// A technology, and what area and energy are in it against 65 nm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Technology {
    /// Its name in nm.
    pub nm: u32,
    /// Area over that at 65 nm.
    pub area: f64,
    /// Energy over that at 65 nm and 1.1 V.
    pub energy: f64,
}

impl Technology {
    /// 65 nm; 28 nm, between the 32 and 20 nm of Stillmaker and Baas (*Scaling equations for the
    /// accurate prediction of CMOS device performance from 180 nm to 7 nm*, Integration, 2017) in
    /// logarithms; and their 7 nm. 0.9 V, and 0.7 V at 7 nm.
    pub const ALL: [Technology; 3] = [
        Technology {
            nm: 65,
            area: 1.0,
            energy: 1.0,
        },
        Technology {
            nm: 28,
            area: 0.247,
            energy: 0.214,
        },
        Technology {
            nm: 7,
            area: 0.039,
            energy: 0.028,
        },
    ];
}
