//! Pipelines of arithmetic: the cycles that an operation takes at a clock where nothing says them, and the area and energy
//! of an operator that is built for other cycles than these.
//!
//! [`operator`](mod@super::operator) prices an operator with the pipeline that it has at 1 GHz, in which an operation starts
//! every cycle. A deeper pipeline has more registers. A shallower one has fewer, and has to be quicker: what an operation
//! passes in a cycle may be longer than a cycle, and then the synthesis takes larger and more gates. An operation that
//! starts only every I-th cycle passes a multiplier's array I times, and leaves the registers out that would part it from
//! the next one.

use super::cycles;
use super::memory::{REGISTER_BIT, REGISTER_PJ, access_fo4};
use super::operator::{
    self, SINGLE, compare, convert, float_add, float_fma, float_mul, integer_add, integer_mul,
    shift,
};
use super::usable_fo4;
use crate::format::Format;
use crate::isa::Class;

/// The clock for which operators are priced.
const PRICED_MHZ: u32 = 1000;

/// The longest way that a synthesis makes fit, in the cycles that it has: ALADDIN's three-stage adder and multiplier exist
/// for 2 ns and for 1 ns a stage.
pub const MOST_HASTE: f64 = 2.0;

/// The way of an operation of a class from operands to result.
struct Way {
    /// Its operator's delay with the digits of binary32.
    fo4: f64,
    /// Cycles around it: operands of floats are unpacked and aligned with each other, and data of memories with their
    /// registers.
    around: u32,
    /// Cycles from issue to issue: how often an operation passes the rows of its unit.
    interval: u32,
    /// True if the delay is that of an operator, and not a time that caches and functions take, however they are built.
    is_operator: bool,
}

impl Way {
    /// The factor by which more of this way, with a part of its operator's delay, lies in so few cycles than fits.
    fn haste(&self, part: f64, latency: u32, mhz: u32) -> f64 {
        let (fo4, cycle) = (self.fo4 * part, usable_fo4(mhz));
        let around = f64::from(self.around) * usable_fo4(PRICED_MHZ);
        match latency.saturating_sub(self.around) {
            // No cycle is left for the operator alone.
            0 => (fo4 + around) / (f64::from(latency) * cycle),
            own => fo4 / (f64::from(own) * cycle),
        }
    }
}

fn way(class: Class) -> Way {
    use Class::*;
    let once = |fo4: f64, around| Way {
        fo4,
        around,
        interval: 1,
        is_operator: true,
    };
    // So many cycles of 1 GHz.
    let long = |cycles: u32, interval: u32| Way {
        fo4: f64::from(cycles) * usable_fo4(PRICED_MHZ),
        around: 0,
        interval,
        is_operator: false,
    };
    let adder = integer_add(32).fo4;
    match class {
        Alu | Valu | Branch | Store | Cstore => once(adder.max(shift(32).fo4), 0),
        Pred | Lane | Io => once(compare(32).fo4, 0),
        Imul | Vmul => once(integer_mul(32).fo4, 0),
        Cvt => once(convert().fo4, 0),
        Fadd | Vfadd => once(float_add(SINGLE).fo4, 1),
        Fmul | Vfmul => once(float_mul(SINGLE).fo4, 1),
        Fma | Vfma => once(float_fma(SINGLE).fo4, 1),
        // A product, and two levels of sums that are not rounded.
        Vdot => once(
            float_fma(SINGLE).fo4 + operator::unrounded_sum_fo4(SINGLE),
            1,
        ),
        Pair | Vpair => once(float_fma(Format::HALF.significand).fo4, 0),
        // An address, and a bank of 15 KB.
        Load => once(adder + access_fo4(15.0 * 8192.0), 1),
        Cload => long(4, 1),
        Tex => long(12, 1),
        Idiv | Fdiv => long(12, 4),
        Sfu | Fast => long(8, 2),
    }
}

/// The cycles of a class at a clock where nothing gives them, latency and interval. A unit has as many rows at any clock,
/// which an operation passes as often, a cycle each at least.
pub fn natural(class: Class, mhz: u32) -> (u32, u32) {
    const MOST: u32 = 64;
    let way = way(class);
    let latency = cycles(way.fo4, mhz) + way.around;
    (latency.clamp(way.interval, MOST), way.interval)
}

/// The cycles of an operator that a unit has, beside those with which it is priced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depth {
    /// How many times what an operation passes in a cycle is longer than the cycle; at least 1.
    pub haste: f64,
    /// Passes of an operation over the rows of its unit: one a cycle until it is through or lets the next one in.
    pub passes: u32,
    /// Operations in flight beyond those of the priced pipeline, each of which has registers.
    stages: i32,
}

/// How much larger an operator is when it has to be quicker: 1.45 times for twice the clock, an adder and a multiplier of
/// ALADDIN's at 40 nm.
const HASTE_AREA: f64 = 0.54;

/// The factor of the area of an operator that is so many times quicker.
pub fn haste_area(haste: f64) -> f64 {
    haste.powf(HASTE_AREA)
}

impl Depth {
    /// That of a class with so many significand bits, in a unit that has such latency and interval, at a clock.
    pub fn of(class: Class, (latency, interval): (u32, u32), digits: u32, mhz: u32) -> Depth {
        let priced = natural(class, PRICED_MHZ);
        let priced = (operator::cycles_in(digits, class, priced.0), priced.1);
        let in_flight = |latency: u32, interval: u32| latency.div_ceil(interval) as i32;
        let narrower = f64::from(operator::cycles_in(digits, class, 64)) / 64.0;
        let way = way(class);
        let follows = operator::cycles_in(digits, class, natural(class, mhz).0);
        let haste = match way.is_operator && latency < follows {
            true => way.haste(narrower, latency, mhz),
            false => 1.0,
        };
        Depth {
            haste: haste.max(1.0),
            passes: latency.min(interval),
            stages: in_flight(latency, interval) - in_flight(priced.0, priced.1),
        }
    }

    /// The factor of an operator's area.
    pub fn area(&self) -> f64 {
        haste_area(self.haste)
    }

    /// The factors of the energy of an adder and of a multiplier: ALADDIN's take 1.52 and 1.19 times as much
    /// at twice the clock.
    pub fn energy(&self) -> [f64; 2] {
        [0.6, 0.25].map(|power| self.haste.powf(power))
    }

    /// Area of the registers beyond those of the priced pipeline, µm², of stages of so many bits; less than none where
    /// it has fewer.
    pub fn registers_um2(&self, bits: u32) -> f64 {
        REGISTER_BIT * f64::from(self.stages) * f64::from(bits)
    }

    /// Their energy, pJ.
    pub fn registers_pj(&self, bits: u32) -> f64 {
        REGISTER_PJ * f64::from(self.stages) * f64::from(bits)
    }
}

/// Bits between two stages of an operator of a class: two operands, or sums and carries, with what goes along of
/// exponents; of memory operations an address and where the answer goes.
pub fn stage_bits(class: Class, digits: u32) -> u32 {
    use Class::*;
    let float = 2 * digits + 8;
    match class {
        Fadd | Fmul | Fma => float,
        Vfadd | Vfmul | Vfma | Vdot => 4 * float,
        Pair => 2 * float,
        Vpair => 8 * float,
        Alu | Imul | Cvt | Branch | Io => 64,
        Valu | Vmul | Lane => 256,
        Pred => 3,
        Load | Store | Cload | Cstore | Tex => 40,
        // What is iterated has its registers in its own price.
        Idiv | Fdiv | Sfu | Fast => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cycles_grow_with_the_clock() {
        for &class in Class::ALL {
            let mut before = (1, 1);
            for mhz in [45, 100, 250, 500, 800, 1000, 1250, 1600, 2000, 2500] {
                let now = natural(class, mhz);
                assert!(now.0 >= before.0 && now.1 >= before.1, "{class} {mhz}");
                before = now;
            }
            assert!(before.0 > natural(class, PRICED_MHZ).0, "{class}");
        }
    }

    #[test]
    fn an_operator_as_it_is_priced_costs_no_more() {
        for &class in Class::ALL {
            let (latency, interval) = natural(class, PRICED_MHZ);
            let depth = Depth::of(class, (latency, interval), SINGLE, PRICED_MHZ);
            assert_eq!((depth.stages, depth.haste), (0, 1.0), "{class}");
            let deeper = Depth::of(class, (latency + 3, interval), SINGLE, PRICED_MHZ);
            assert!(deeper.stages >= 1, "{class}");
            let quicker = Depth::of(class, (latency, interval), SINGLE, 5 * PRICED_MHZ / 2);
            assert_eq!(quicker.haste > 1.0, way(class).is_operator, "{class}");
        }
    }

    #[test]
    fn cycles_around_an_operator_are_not_its_own() {
        let haste = |class, latency| Depth::of(class, (latency, 1), SINGLE, PRICED_MHZ).haste;
        // 52 FO4 of a sum in the one cycle that unpacking leaves of two, and with it in one.
        let sum = float_add(SINGLE).fo4;
        assert_eq!(haste(Class::Fadd, 3), 1.0);
        assert_eq!(haste(Class::Fadd, 2), sum / 32.0);
        assert_eq!(haste(Class::Fadd, 1), (sum + 32.0) / 32.0);
        assert!(haste(Class::Load, 2) > 1.8 && haste(Class::Load, 2) < MOST_HASTE);
    }

    #[test]
    fn what_follows_from_the_clock_has_no_haste_and_all_rows() {
        for &class in Class::ALL {
            let rows = natural(class, PRICED_MHZ).1;
            for mhz in [45, 250, 500, 800, 1000, 1600, 2500] {
                let (latency, interval) = natural(class, mhz);
                assert!(interval == rows && latency >= rows, "{class} {mhz}");
                for digits in [3, 8, 11, SINGLE] {
                    let cycles = (operator::cycles_in(digits, class, latency), interval);
                    let depth = Depth::of(class, cycles, digits, mhz);
                    assert_eq!(depth.haste, 1.0, "{class} {digits} {mhz}");
                }
            }
        }
    }
}
