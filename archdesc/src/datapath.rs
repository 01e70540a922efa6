//! The datapaths of the T&I unit: what a test computes, how many operators that takes, and how
//! deep its pipeline is.
//!
//! A datapath is fully pipelined: it starts a test every cycle, so it has one operator for every
//! operation of a test.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::cost::memory::access_fo4;
use crate::cost::operator::{SINGLE, compare, float_add, float_mul, integer_add};
use crate::cost::{cycles, usable_fo4};
use crate::precision::Approx;
use crate::system::{GivenLatencies, TniSpec};

/// Ray–triangle tests that an intersection unit can be built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Intersection {
    /// Wald's projection (2004), as in the SGRT paper: planes and edges relative to the origin of
    /// coordinates. Rays slip through between triangles.
    Wald,
    /// The same relative to a vertex of the triangle, which is subtracted from the ray's origin
    /// first: as many operations, and no cancellation far from the origin.
    AnchorWald,
    /// Relative to a vertex, with weights compared against an epsilon that scales with what
    /// rounding can do to them.
    AnchorWaldScaled,
    /// Woop, Benthin and Wald (2013): vertices sheared into the ray's space, where triangles that
    /// share an edge compute the very same number for it, whose sign is exact.
    Woop,
    /// The same without a division before the decision, all of it in 53 digits until a hit is rounded: as good as
    /// exact, by multipliers of which the largest are five times as large.
    WoopWide,
}

/// Operators of a datapath.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Operations {
    /// Additions and subtractions.
    pub add: u32,
    /// Multiplications.
    pub mul: u32,
    /// Reciprocals, or divisions where they are exact.
    pub rcp: u32,
    /// Comparisons: minima and maxima, and signs that decide something.
    pub cmp: u32,
}

impl Operations {
    /// So many datapaths together.
    pub fn times(self, count: u32) -> Operations {
        Operations {
            add: self.add * count,
            mul: self.mul * count,
            rcp: self.rcp * count,
            cmp: self.cmp * count,
        }
    }

    /// These and others.
    pub fn plus(self, other: Operations) -> Operations {
        Operations {
            add: self.add + other.add,
            mul: self.mul + other.mul,
            rcp: self.rcp + other.rcp,
            cmp: self.cmp + other.cmp,
        }
    }
}

/// Latencies of floating-point operators in cycles of the T&I unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FpLatency {
    /// Adder.
    pub add: u32,
    /// Multiplier.
    pub mul: u32,
    /// Comparator.
    pub cmp: u32,
    /// Reciprocal or divider.
    pub rcp: u32,
}

impl FpLatency {
    /// Operators of binary32 at a clock, each in as many cycles as its way fills, and a reciprocal of so many
    /// cycles. At 1 GHz they are SimTRaX's: 2, 2 and 1.
    pub fn at(mhz: u32, rcp: u32) -> FpLatency {
        FpLatency {
            add: cycles(float_add(SINGLE).fo4, mhz),
            mul: cycles(float_mul(SINGLE).fo4, mhz),
            cmp: cycles(compare(32).fo4, mhz),
            rcp,
        }
    }
}

/// Cycles through TRV_PRE at a clock: the address of a node is a sum, and what the node is decides where the ray
/// goes next.
pub fn fetch_depth(mhz: u32) -> u32 {
    cycles(integer_add(32).fo4 + compare(32).fo4, mhz)
}

/// Cycles through TRV_POST at a clock: the distances of the children are compared, and the farther one is pushed on
/// the ray's stack or the top one read from it.
pub fn stack_depth(mhz: u32, tni: &TniSpec) -> u32 {
    cycles(compare(32).fo4, mhz) + cycles(access_fo4(stack_bits(tni)), mhz)
}

/// Bits of the stacks of a traversal unit.
pub(crate) fn stack_bits(tni: &TniSpec) -> f64 {
    f64::from(tni.stacks * tni.stack_depth * STACK_ENTRY_BITS)
}

/// Delay of a reciprocal of which nothing is said, FO4.
pub(crate) fn exact_rcp_fo4() -> f64 {
    f64::from(RCP_LATENCY) * usable_fo4(RCP_MHZ)
}

/// Cycles through the reciprocal at a clock where the machine does not say how it is made: SimTRaX's, and more where the
/// clock is quicker than that one's.
pub fn rcp_depth(mhz: u32) -> u32 {
    cycles(exact_rcp_fo4(), mhz).max(RCP_LATENCY)
}

/// Bits of an entry of a stack: a node's address, and how far its box is.
const STACK_ENTRY_BITS: u32 = 64;

impl TniSpec {
    /// Lets the latencies that are not given follow from the unit's operators at a clock.
    pub fn derive_latencies(&mut self, mhz: u32) {
        let given = self.given;
        let fp = (given.operators).unwrap_or_else(|| FpLatency::at(mhz, self.rcp_latency));
        if !given.pre {
            self.pre_latency = fetch_depth(mhz);
        }
        if !given.aabb {
            self.aabb_latency = box_depth(fp);
        }
        if !given.post {
            self.post_latency = stack_depth(mhz, self);
        }
        if !given.ist {
            self.ist_latency = self.intersection.depth(self.rcp, fp);
        }
    }
}

/// Latencies of a whole T&I unit by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Latencies {
    /// Those with which the unit has the rates of the SGRT paper: deep operators.
    Calibrated,
    /// Those of the 65 nm synthesis that SimTRaX ships, whose areas the paper prints: a lower
    /// bound, far shallower than the paper's rates ask for.
    Synthesis65nm,
}

impl Latencies {
    /// All of them.
    pub const ALL: [Latencies; 2] = [Latencies::Calibrated, Latencies::Synthesis65nm];

    /// The name in machine files.
    pub const fn name(self) -> &'static str {
        match self {
            Latencies::Calibrated => "calibrated",
            Latencies::Synthesis65nm => "65nm",
        }
    }

    /// Gives a unit these latencies: of its two tests what follows from the operators, of fetch and
    /// stack what is left of a visit.
    pub fn apply(self, tni: &mut TniSpec) {
        let (pre, post, fp) = match self {
            Latencies::Calibrated => (CALIBRATED_PRE, CALIBRATED_POST, CALIBRATED),
            Latencies::Synthesis65nm => (1, 2, SYNTHESIS_65NM),
        };
        (tni.pre_latency, tni.post_latency) = (pre, post);
        tni.given = GivenLatencies::ALL;
        tni.aabb_latency = box_depth(fp);
        tni.ist_latency = match self {
            Latencies::Calibrated => CALIBRATED_IST - CALIBRATED.rcp + tni.rcp_latency,
            Latencies::Synthesis65nm => tni.intersection.depth(
                tni.rcp,
                FpLatency {
                    rcp: tni.rcp_latency,
                    ..fp
                },
            ),
        };
    }
}

/// Operators of 65 nm, SimTRaX's.
pub const SYNTHESIS_65NM: FpLatency = FpLatency {
    add: 2,
    mul: 2,
    cmp: 1,
    rcp: RCP_LATENCY,
};

/// Deep operators, as of a library of pipelined parts.
const CALIBRATED: FpLatency = FpLatency {
    add: 5,
    mul: 5,
    cmp: 2,
    rcp: RCP_LATENCY,
};

/// Cycles through a reciprocal where the machine does not say how it is made: SimTRaX's, at its clock.
pub const RCP_LATENCY: u32 = 16;

/// That clock.
const RCP_MHZ: u32 = 1000;

/// Depth of TRV_PRE and TRV_POST with them, and of a triangle test with such a reciprocal.
const CALIBRATED_PRE: u32 = 6;
const CALIBRATED_POST: u32 = 14;
const CALIBRATED_IST: u32 = 37;

/// One ray–box test: both planes of each axis subtracted and multiplied; 3 comparisons to put them
/// in order, 3 for the latest entry, 3 for the earliest exit, one between the two and one with the
/// nearest hit.
pub const BOX_TEST: Operations = Operations {
    add: 6,
    mul: 6,
    rcp: 0,
    cmp: 11,
};

/// Cycles through one ray–box test: subtract, multiply, order, two levels of maximum and minimum,
/// decide.
pub fn box_depth(fp: FpLatency) -> u32 {
    fp.add + fp.mul + 4 * fp.cmp
}

/// Digits of a binary32 number, and of those that [`Intersection::WoopWide`] decides by.
const DIGITS: u32 = 24;
const WIDE_DIGITS: u32 = 53;

/// Adders of binary32 that are as large as one of 53 digits.
const WIDE_ADDER: u32 = 2;

impl Intersection {
    /// All of them.
    pub const ALL: [Intersection; 5] = [
        Intersection::Wald,
        Intersection::AnchorWald,
        Intersection::AnchorWaldScaled,
        Intersection::Woop,
        Intersection::WoopWide,
    ];

    /// Its name in machine files.
    pub const fn name(self) -> &'static str {
        match self {
            Intersection::Wald => "wald",
            Intersection::AnchorWald => "anchor-wald",
            Intersection::AnchorWaldScaled => "anchor-wald-scaled",
            Intersection::Woop => "woop",
            Intersection::WoopWide => "woop-wide",
        }
    }

    /// Operators of one test. With an exact division the quotient needs no multiplication after
    /// it; a reciprocal of less precision does. Newton–Raphson steps of a reciprocal are part of
    /// its operator. What is wider than binary32 counts as the operators of binary32 that are as large: an adder of
    /// 53 digits as two, a multiplier as the product of its operands' digits.
    pub fn operations(self, rcp: Approx) -> Operations {
        // Wald: n·d 2+2, n·o 3+2, hit point 2+2, two weights of 2+2 each, their sum 1; against
        // tmin, the nearest hit, and three edges.
        let wald = Operations {
            add: 12,
            mul: 10 + u32::from(rcp != Approx::Exact),
            rcp: 1,
            cmp: 5,
        };
        match self {
            // Relative to a vertex, 3 subtractions more come first, and 3 constants fall away.
            Intersection::Wald | Intersection::AnchorWald => wald,
            // The epsilon: t·reach + largest of three, times slack, times the larger of 1 and
            // reach/|n·d| (a power of two, so an exponent is added), at most 1; and 1 + epsilon. What a
            // coarse reciprocal is off, again a power of two, is added to it.
            Intersection::AnchorWaldScaled => wald.plus(Operations {
                add: 2 + u32::from(rcp != Approx::Exact),
                mul: 3,
                rcp: 0,
                cmp: 4,
            }),
            // Vertices 9+0, shear 6+6, edges 3+6, determinant 2+0, depths 0+3, distance 2+3, and
            // three quotients by it. The sums of the edges are of whole products, to 53 digits: two adders each.
            Intersection::Woop => Operations {
                add: 25,
                mul: 21,
                rcp: 1,
                cmp: 5,
            },
            // All sums are to 53 digits: vertices 9, shear 6, edges 3, their sum 2, distance 2.
            Intersection::WoopWide => Operations {
                add: 22 * WIDE_ADDER,
                // Shear 12, by the direction, as the determinant and two weights 3; edges 6 and distance 3; the
                // quotients 3.
                mul: (15 * WIDE_DIGITS * DIGITS + 9 * WIDE_DIGITS * WIDE_DIGITS)
                    .div_ceil(DIGITS * DIGITS)
                    + 3,
                rcp: 1,
                cmp: 5,
            },
        }
    }

    /// Cycles through one test: the longest way from ray and triangle to the decision.
    pub fn depth(self, rcp: Approx, fp: FpLatency) -> u32 {
        let FpLatency { add, mul, cmp, .. } = fp;
        // Products by a reciprocal come after it; an exact division has them inside.
        let quotient = match rcp {
            Approx::Exact => fp.rcp,
            Approx::Table { .. } => fp.rcp + mul,
        };
        let (plane, point) = (mul + 2 * add, mul + add);
        match self {
            // The last multiplication is t itself: 11 with a reciprocal. The paper's count of 10
            // leaves it to the divider.
            Intersection::Wald => plane + quotient + point + mul + 2 * add + add + cmp,
            Intersection::AnchorWald => plane + quotient + point + mul + add + add + cmp,
            Intersection::AnchorWaldScaled => {
                let weights = point + mul + add + add;
                let coarse = if rcp == Approx::Exact { 0 } else { add };
                let epsilon = 3 * mul + add + cmp + add + coarse;
                plane + quotient + weights.max(epsilon) + cmp
            }
            Intersection::Woop => {
                let edges = add + point + point + add;
                edges + 2 * add + fp.rcp + mul + cmp
            }
            Intersection::WoopWide => {
                // A wide product is a sum of products.
                let wide = mul + add;
                let edges = add + 2 * (wide + add);
                edges + 2 * add + wide + fp.rcp + mul + cmp
            }
        }
    }
}
