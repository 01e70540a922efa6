//! Adders, multipliers and what else arithmetic is made of.
//!
//! Floating-point operators are SimTRaX's at 24 significand bits (Spjut et al., *TRaX: a multicore
//! hardware architecture for real-time ray tracing*, 2009; its 65 nm synthesis), and their growth with the
//! significand is that of Horowitz's and ALADDIN's adders and multipliers.

use super::Part;
use super::memory::{REGISTER_BIT, REGISTER_PJ};
use crate::isa::Class;

/// Significand bits of binary32 with the hidden one.
pub const SINGLE: u32 = 24;

/// Area of an input of a multiplexer beyond its first, µm² a bit: 2.4 gates of 1.44 µm².
pub const MULTIPLEXER_BIT: f64 = 3.4;

/// Area of an array of partial products of a × b bits, µm².
pub fn product_area(a: f64, b: f64) -> f64 {
    11.4 * a * b
}

/// Its energy, pJ.
pub fn product_energy(a: f64, b: f64) -> f64 {
    0.0173 * a * b
}

/// Its delay with a sum that is not carried, FO4.
pub fn product_fo4(a: f64, b: f64) -> f64 {
    6.0 + 8.5 * a.min(b).max(2.0).log2()
}

/// A floating-point adder of m significand bits.
pub fn float_add(m: u32) -> Part {
    let m = f64::from(m);
    Part::new("adder", 125.0 * m, 0.31 * m, 22.0 + 6.5 * m.log2())
}

/// A floating-point multiplier of m significand bits.
pub fn float_mul(m: u32) -> Part {
    let m = f64::from(m);
    Part::new(
        "multiplier",
        11.4 * m * m + 143.0 * m,
        0.016 * m * m + 0.208 * m,
        14.0 + 8.5 * m.log2(),
    )
}

/// A fused multiply-adder: both, without the rounding between, and a sum of three times the width.
pub fn float_fma(m: u32) -> Part {
    let (mul, add) = (float_mul(m), float_add(m));
    Part::new(
        "multiply-adder",
        mul.area_um2 + add.area_um2,
        mul.energy_pj + add.energy_pj,
        mul.fo4 + unrounded_sum_fo4(m),
    )
}

/// Delay of a sum of products of m significand bits, which are three times as wide with the places that they may be shifted
/// by, FO4; without its rounding.
pub fn unrounded_sum_fo4(m: u32) -> f64 {
    6.5 * f64::from(3 * m).log2()
}

/// The cycles that operations of a class take with m significand bits, where those of binary32 take so many: as much less
/// as the operator is quicker, in whole cycles.
pub fn cycles_in(m: u32, class: Class, single: u32) -> u32 {
    let of: fn(u32) -> Part = match class {
        Class::Fadd | Class::Vfadd => float_add,
        Class::Fmul | Class::Vfmul => float_mul,
        Class::Fma | Class::Vfma | Class::Vdot => float_fma,
        _ => return single,
    };
    let part = of(m).fo4 / of(SINGLE).fo4;
    ((f64::from(single) * part).ceil() as u32).clamp(1, single)
}

/// A comparator of floats or integers of n bits.
pub fn compare(n: u32) -> Part {
    let n = f64::from(n);
    Part::new("comparator", 22.5 * n, 0.0168 * n, 12.0)
}

/// An integer adder or logic unit of n bits.
pub fn integer_add(n: u32) -> Part {
    let n = f64::from(n);
    Part::new("integer adder", 21.0 * n, 0.0179 * n, 6.0 + 2.0 * n.log2())
}

/// An integer multiplier of n bits.
pub fn integer_mul(n: u32) -> Part {
    let n = f64::from(n);
    Part::new(
        "integer multiplier",
        11.4 * n * n,
        0.0173 * n * n,
        14.0 + 8.5 * n.log2(),
    )
}

/// A shifter of n bits by any distance: a multiplexer of two for each bit and level.
pub fn shift(n: u32) -> Part {
    let n = f64::from(n);
    let levels = n.log2();
    Part::new(
        "shifter",
        5.0 * n * levels,
        0.004 * n * levels,
        4.0 + 2.0 * levels,
    )
}

/// Registers of n bits.
pub fn registers(n: u32) -> Part {
    let n = f64::from(n);
    Part::new("registers", REGISTER_BIT * n, REGISTER_PJ * n, 0.0)
}

/// A converter between integers and floats.
pub fn convert() -> Part {
    Part::new("converter", 1814.0, 1.0, 40.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_precision_is_simtraxs() {
        let near = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 0.02, "{a} {b}");
        near(float_add(SINGLE).area_um2, 3000.0);
        near(float_add(SINGLE).energy_pj, 7.4);
        near(float_mul(SINGLE).area_um2, 10_000.0);
        near(float_mul(SINGLE).energy_pj, 14.2);
        near(compare(32).area_um2, 722.0);
        near(integer_add(32).area_um2, 660.0);
        near(integer_mul(32).energy_pj, 17.7);
    }
}
