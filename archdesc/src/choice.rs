//! [`Choices`]: which unit of a machine computes a reciprocal, a root or a quotient most cheaply within an error.
//!
//! A machine may have two units for each of these functions, the ordinary one and a fast one. A unit is
//! cheaper if it holds up the next operation for less time, then if its result comes earlier, then if an
//! operation takes less energy. Steps that the program takes count as operations of the program.

use std::collections::BTreeMap;

use crate::arch::{Approx, Arch, Refine};
use crate::isa::{Class, Opcode};
use crate::structure::Special;

/// A unit that computes a function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// The operation that it runs.
    pub op: Opcode,
    /// Bound of its relative error before the result is rounded to binary32; 0 of an exact one.
    pub unrounded: f64,
    /// Bound of its relative error.
    pub error: f64,
    /// Cycles from issue to issue.
    pub interval: u32,
    /// Cycles from issue to result.
    pub latency: u32,
    /// Energy of an operation, pJ.
    pub energy_pj: f64,
}

impl Choice {
    /// Bits to which its results are good before they are rounded, at most the 24 of binary32.
    pub fn bits(&self) -> u32 {
        // A bound of 2^−12 means 12 bits, whatever its logarithm is rounded to.
        (-self.unrounded.log2() + 1e-9).min(24.0) as u32
    }
}

/// The units of the functions that a machine may have two units for.
#[derive(Clone, Debug)]
pub struct Choices {
    /// By function, the cheapest first.
    units: BTreeMap<Special, Vec<Choice>>,
}

/// Functions that a machine may have two units for.
const FUNCTIONS: [Special; 4] = [Special::Rcp, Special::Rsqrt, Special::Sqrt, Special::Div];

impl Default for Choices {
    /// The units of a machine of which nothing is said: exact ones, and no fast ones.
    fn default() -> Choices {
        let units = FUNCTIONS.map(|special| {
            let exact = Choice {
                op: special.opcodes()[0],
                unrounded: 0.0,
                error: Approx::Exact.error_bound(),
                interval: 1,
                latency: 1,
                energy_pj: 0.0,
            };
            (special, vec![exact])
        });
        Choices {
            units: BTreeMap::from(units),
        }
    }
}

impl Choices {
    /// The units of a machine.
    pub fn of(arch: &Arch) -> Choices {
        let units = FUNCTIONS.map(|special| {
            let all = [Some(special), special.fast()].into_iter().flatten();
            let has = all.filter(|&special| arch.precision.has(special));
            let mut units: Vec<Choice> = has.map(|special| choice(special, arch)).collect();
            units.sort_by(|a, b| {
                let cycles = |unit: &Choice| (unit.interval, unit.latency);
                let by_cycles = cycles(a).cmp(&cycles(b));
                by_cycles.then(a.energy_pj.total_cmp(&b.energy_pj))
            });
            (special, units)
        });
        Choices {
            units: BTreeMap::from(units),
        }
    }

    /// The units of a function, the cheapest first.
    pub fn of_function(&self, special: Special) -> &[Choice] {
        self.units
            .get(&special.ordinary())
            .map_or(&[], Vec::as_slice)
    }

    /// True if there is a unit that runs an operation; none of these functions is missing but fast ones.
    pub fn has(&self, op: Opcode) -> bool {
        Special::of(op).is_none_or(|special| {
            !special.is_fast() || self.of_function(special).iter().any(|unit| unit.op == op)
        })
    }

    /// The cheapest unit of a function that is good to so many bits.
    pub fn to_bits(&self, special: Special, bits: u32) -> Option<&Choice> {
        let units = self.of_function(special).iter();
        units.into_iter().find(|unit| unit.bits() >= bits)
    }

    /// The cheapest unit of a function whose relative error is no larger.
    pub fn within(&self, special: Special, error: f64) -> Option<&Choice> {
        let units = self.of_function(special).iter();
        units.into_iter().find(|unit| unit.error <= error)
    }
}

/// The unit of one function of a machine.
fn choice(special: Special, arch: &Arch) -> Choice {
    let op = special.opcodes()[0];
    let approx = arch.precision.of(special);
    let ways = arch.srp.fus.values().filter_map(|fu| fu.runs(op));
    let (interval, latency) = (ways.map(|how| (how.interval, how.latency)).min()).unwrap_or((1, 1));
    let (more, later) = match approx {
        Approx::Table {
            steps,
            fused,
            refine: Refine::Code,
            ..
        } => in_code(steps, fused, arch),
        _ => (0, 0),
    };
    Choice {
        op,
        unrounded: approx.error_before_rounding(),
        error: approx.error_bound(),
        interval: interval + more,
        latency: latency + later,
        energy_pj: arch.special_unit(special).energy_pj,
    }
}

/// Operations and cycles of steps that the program takes: a comparison and a selection beside two fused
/// operations, or two products and a difference, that wait for each other.
fn in_code(steps: u32, fused: bool, arch: &Arch) -> (u32, u32) {
    let latency = |class| arch.srp.least_latency(class).unwrap_or(1);
    let selection = latency(Class::Fadd) + latency(Class::Alu);
    let (operations, cycles) = match fused {
        true => (4, 2 * latency(Class::Fma) + selection),
        false => (
            5,
            2 * latency(Class::Fmul) + latency(Class::Fadd) + selection,
        ),
    };
    (steps * operations, steps * cycles)
}
