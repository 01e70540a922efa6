//! Haste of a T&I unit: how many times more logic lies in the cycles that it has than fits, as
//! [`Depth`](crate::cost::pipeline::Depth) has it of the SRP's operations.

use crate::cost::memory::access_fo4;
use crate::cost::operator::{SINGLE, compare, float_add, float_mul, integer_add};
use crate::cost::usable_fo4;
use crate::datapath::{FpLatency, box_depth, exact_rcp_fo4, stack_bits};
use crate::precision::Approx;
use crate::system::TniSpec;

/// Haste of each kind of operator of a test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperatorHaste {
    /// Of adders.
    pub add: f64,
    /// Of multipliers.
    pub mul: f64,
    /// Of comparators.
    pub cmp: f64,
    /// Of reciprocals.
    pub rcp: f64,
}

impl OperatorHaste {
    /// That of operators which all have as much of their cycles.
    pub const fn all(haste: f64) -> OperatorHaste {
        OperatorHaste {
            add: haste,
            mul: haste,
            cmp: haste,
            rcp: haste,
        }
    }
}

/// Haste of the stages of a T&I unit; 1 where all fits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Haste {
    /// Of TRV_PRE.
    pub pre: f64,
    /// Of the operators of TRV_AABB.
    pub aabb: OperatorHaste,
    /// Of TRV_POST.
    pub post: f64,
    /// Of the operators of the triangle test.
    pub ist: OperatorHaste,
}

impl Haste {
    /// That of a unit at a clock. Latencies that follow from the clock have none.
    pub fn of(tni: &TniSpec, mhz: u32) -> Haste {
        let ways = Ways::of(tni, mhz);
        let cycle = usable_fo4(mhz);
        let in_cycles = |fo4: f64, cycles: u32| (fo4 / (f64::from(cycles) * cycle)).max(1.0);
        let given = &tni.given;
        let stage = |is_given: bool, fo4: f64, latency: u32| match is_given {
            true => in_cycles(fo4, latency),
            false => 1.0,
        };
        let operators = match given.operators {
            Some(fp) => OperatorHaste {
                add: in_cycles(ways.add, fp.add),
                mul: in_cycles(ways.mul, fp.mul),
                cmp: in_cycles(ways.cmp, fp.cmp),
                rcp: in_cycles(ways.rcp, fp.rcp),
            },
            None => OperatorHaste::all(1.0),
        };
        // A latency of a whole test is divided among its operators as they need it.
        let test = |is_given: bool, fo4: f64, latency: u32| match is_given {
            true => OperatorHaste::all(in_cycles(fo4, latency)),
            false => operators,
        };
        Haste {
            pre: stage(given.pre, ways.pre, tni.pre_latency),
            aabb: test(given.aabb, ways.aabb, tni.aabb_latency),
            post: stage(given.post, ways.post, tni.post_latency),
            ist: test(given.ist, ways.ist, tni.ist_latency),
        }
    }
}

/// Delays of the operators and stages of a unit, FO4.
struct Ways {
    add: f64,
    mul: f64,
    cmp: f64,
    rcp: f64,
    pre: f64,
    aabb: f64,
    post: f64,
    ist: f64,
}

impl Ways {
    fn of(tni: &TniSpec, mhz: u32) -> Ways {
        let (add, mul, cmp) = (
            float_add(SINGLE).fo4,
            float_mul(SINGLE).fo4,
            compare(32).fo4,
        );
        // Other units of a reciprocal take a time, however they are built.
        let rcp = match (tni.rcp, tni.rcp_build.exact) {
            (Approx::Exact, None) => exact_rcp_fo4(),
            _ => f64::from(tni.rcp_latency) * usable_fo4(mhz),
        };
        // The longest way through a test is found in whole numbers.
        const PARTS: f64 = 1024.0;
        let parts = |fo4: f64| (fo4 * PARTS) as u32;
        let fp = FpLatency {
            add: parts(add),
            mul: parts(mul),
            cmp: parts(cmp),
            rcp: parts(rcp),
        };
        let fo4 = |parts: u32| f64::from(parts) / PARTS;
        Ways {
            add,
            mul,
            cmp,
            rcp,
            pre: integer_add(32).fo4 + cmp,
            aabb: fo4(box_depth(fp)),
            post: cmp + access_fo4(stack_bits(tni)),
            ist: fo4(tni.intersection.depth(tni.rcp, fp)),
        }
    }
}
