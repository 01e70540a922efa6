//! The datapaths of the T&I unit: what a test computes, how many operators that takes, and how
//! deep its pipeline is.
//!
//! A datapath is fully pipelined: it starts a test every cycle, so it has one operator for every
//! operation of a test.

use crate::precision::Approx;

/// Ray–triangle tests that an intersection unit can be built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
    /// share an edge compute the very same numbers for it.
    Woop,
}

/// Operators of a datapath.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

impl Intersection {
    /// All of them.
    pub const ALL: [Intersection; 4] = [
        Intersection::Wald,
        Intersection::AnchorWald,
        Intersection::AnchorWaldScaled,
        Intersection::Woop,
    ];

    /// Its name in machine files.
    pub const fn name(self) -> &'static str {
        match self {
            Intersection::Wald => "wald",
            Intersection::AnchorWald => "anchor-wald",
            Intersection::AnchorWaldScaled => "anchor-wald-scaled",
            Intersection::Woop => "woop",
        }
    }

    /// Operators of one test. With an exact division the quotient needs no multiplication after
    /// it; a reciprocal of less precision does. Newton–Raphson steps of a reciprocal are part of
    /// its operator.
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
            // reach/|n·d| (a power of two, so an exponent is added), at most 1; and 1 + epsilon.
            Intersection::AnchorWaldScaled => wald.plus(Operations {
                add: 2,
                mul: 3,
                rcp: 0,
                cmp: 4,
            }),
            // Vertices 9+0, shear 6+6, edges 3+6, determinant 2+0, depths 0+3, distance 2+3, and
            // three quotients by it.
            Intersection::Woop => Operations {
                add: 22,
                mul: 21,
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
                let epsilon = 3 * mul + add + cmp + add;
                plane + quotient + weights.max(epsilon) + cmp
            }
            Intersection::Woop => {
                let edges = add + point + point;
                edges + 2 * add + fp.rcp + mul + cmp
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adders and multipliers of 2 cycles, comparators of 1, a reciprocal of 16: a 65 nm synthesis.
    const SHALLOW: FpLatency = FpLatency {
        add: 2,
        mul: 2,
        cmp: 1,
        rcp: 16,
    };

    #[test]
    fn operators_are_those_of_the_papers_table_1() {
        let trv = BOX_TEST.times(4);
        assert_eq!((trv.add, trv.mul, trv.cmp), (24, 24, 44));
        let ist = Intersection::Wald.operations(Approx::Exact);
        assert_eq!((ist.add, ist.mul, ist.rcp, ist.cmp), (12, 10, 1, 5));
    }

    #[test]
    fn depths_follow_from_latencies() {
        let table = Approx::Table { bits: 12, steps: 1 };
        assert_eq!(box_depth(SHALLOW), 8);
        assert_eq!(Intersection::Wald.depth(table, SHALLOW), 37);
        assert_eq!(Intersection::Wald.depth(Approx::Exact, SHALLOW), 35);
        assert_eq!(Intersection::AnchorWald.depth(table, SHALLOW), 35);
        assert_eq!(Intersection::AnchorWaldScaled.depth(table, SHALLOW), 36);
        assert_eq!(Intersection::Woop.depth(table, SHALLOW), 33);
    }
}
