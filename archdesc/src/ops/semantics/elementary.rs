//! The special functions: reciprocal, roots, exponential, logarithm, sine and cosine.
//!
//! Each takes its precision in `bits`. **0 bits** means exact: reciprocal and roots correctly
//! rounded, the others evaluated in binary64 by fixed series, of `+ − · /` alone, and rounded once,
//! which leaves an error below 0.501 units in the last place. Else it is a unit word of
//! [`super::approximation`], which has the other structures; with nothing above its **4 to
//! 23 bits** of precision it is what small hardware does: a table addressed by the top bits of the operand, each entry the value in the
//! middle of its interval; the first interval has its value at its beginning, so that 1/1, √1, 2⁰,
//! log2 1, sin 0 are exact. Tables are monotone. Reciprocal and roots are good to a relative error
//! of 2^−bits and can be improved by `steps` Newton–Raphson steps, in binary32 with fused
//! multiply-add, or, with [`SEPARATE`], with a rounding after every operation; exp2 to a relative error
//! of 2^−bits; log2, sine and cosine to an absolute one; all this before the result is rounded to
//! binary32. A compiler that puts the same steps behind a first approximation gets the same bits.

use super::approximation::{
    self, CORDIC, Curve, RECURRENCE, TABLE, kind, precision, rounded, tabulated,
};
use super::word::{canonical, flt, fma, fmul, fsub};

/// In a number of Newton–Raphson steps: they have no fused operations.
pub const SEPARATE: u32 = 1 << 8;

const ONE: u32 = 0x3f80_0000;
const MINUS_ONE: u32 = 0xbf80_0000;
const HALF: u32 = 0x3f00_0000;
const TWO: u32 = 0x4000_0000;
const THREE: u32 = 0x4040_0000;
const SIGN: u32 = 0x8000_0000;

/// 2ⁿ for −1022 ≤ n ≤ 1023.
fn power_of_two(n: i32) -> f64 {
    f64::from_bits(((n + 1023) as u64) << 52)
}

/// `x` > 0, normal, as (m, n) with x = m·2ⁿ and 1 ≤ m < 2.
fn normalized(x: f64) -> (f64, i32) {
    let fraction = x.to_bits() & ((1 << 52) - 1);
    let exponent = (x.to_bits() >> 52) as i32 - 1023;
    (f64::from_bits(fraction | (1023 << 52)), exponent)
}

/// The middle of the interval of length 2^−index that holds `x`, 0 ≤ x < 2. The intervals from 0
/// and from 1 are met at their beginning.
fn interval(x: f64, index: u32) -> f64 {
    let unit = power_of_two(index as i32);
    let number = f64::from((x * unit) as u32);
    if number == 0.0 || number == unit {
        number / unit
    } else {
        (number + 0.5) / unit
    }
}

/// A table entry: `x`, 0 ≤ x ≤ 2, rounded to the fraction bits that a table of this precision has.
fn entry(x: f64, bits: u32) -> f64 {
    let unit = power_of_two((bits + 3).min(24) as i32);
    f64::from((x * unit + 0.5) as u32) / unit
}

/// 1/x. 1/±0 = ±∞, 1/±∞ = ±0; denormal operands and results are kept. A Newton step is
/// e = fma(−x, y, 1), y = fma(y, e, y); without fused operations y = y·(2 − x·y). Where the reciprocal
/// overflows there is no step that makes sense, and none is taken: e is −∞.
pub fn rcp(x: u32, bits: u32, steps: u32) -> u32 {
    let value = f32::from_bits(x);
    if bits == 0 || value == 0.0 || !value.is_finite() {
        return canonical(1.0 / value);
    }
    let (mantissa, exponent) = normalized(f64::from(value.abs()));
    let first = match kind(bits) {
        TABLE => entry(1.0 / interval(mantissa, bits), bits),
        RECURRENCE => rounded(1.0 / mantissa, precision(bits)),
        CORDIC => approximation::cordic_quotient(1.0, mantissa, precision(bits)),
        _ => tabulated(Curve::Reciprocal, mantissa - 1.0, bits),
    };
    let first = first * power_of_two(-exponent);
    let mut y = (first as f32).to_bits() | (x & SIGN);
    for _ in 0..steps % SEPARATE {
        if steps < SEPARATE {
            let error = fma(x ^ SIGN, y, ONE);
            if flt(MINUS_ONE, error) {
                y = fma(y, error, y);
            }
        } else {
            let factor = fsub(TWO, fmul(x, y));
            if flt(0, factor) {
                y = fmul(y, factor);
            }
        }
    }
    y
}

/// a/b: exact; or the quotient of the mantissas, digit by digit; or the product of the mantissa of a and
/// the reciprocal of that of b, with its steps, rounded once; and once more where it is denormal. Zeros,
/// infinities and NaNs as everywhere.
pub fn fdiv(a: u32, b: u32, bits: u32, steps: u32) -> u32 {
    let (above, below) = (f32::from_bits(a), f32::from_bits(b));
    let ordinary = |x: f32| x != 0.0 && x.is_finite();
    if bits == 0 || !ordinary(above) || !ordinary(below) {
        return canonical(above / below);
    }
    let (above, exponent) = normalized(f64::from(above.abs()));
    let (below, less) = normalized(f64::from(below.abs()));
    let quotient = match kind(bits) {
        RECURRENCE => rounded(above / below, precision(bits)),
        CORDIC => approximation::cordic_quotient(above, below, precision(bits)),
        _ => {
            let reciprocal = rcp((below as f32).to_bits(), bits, steps);
            let quotient = fmul((above as f32).to_bits(), reciprocal);
            f64::from(f32::from_bits(quotient))
        }
    };
    let quotient = quotient * power_of_two(exponent - less);
    (quotient as f32).to_bits() | ((a ^ b) & SIGN)
}

/// 1/√m for 1 ≤ m < 4; a direct table has 2·2^bits entries, half of them for m ≥ 2. A Newton step is
/// e = fma(−(m·y), y, 1), y = fma(y/2, e, y); without fused operations y = (y/2)·(3 − (m·y)·y).
fn approximate_rsqrt(m: f32, bits: u32, steps: u32) -> f32 {
    let half = if m < 2.0 { 1.0 } else { 2.0 };
    let operand = f64::from(m) / half;
    let first = match kind(bits) {
        TABLE => entry(1.0 / (half * interval(operand, bits)).sqrt(), bits),
        RECURRENCE => rounded(1.0 / f64::from(m).sqrt(), precision(bits)),
        _ if m < 2.0 => tabulated(Curve::InverseRoot, operand - 1.0, bits),
        _ => tabulated(Curve::InverseRootOfTwice, operand - 1.0, bits),
    };
    let mut y = (first as f32).to_bits();
    for _ in 0..steps % SEPARATE {
        let (along, halved) = (fmul(m.to_bits(), y), fmul(HALF, y));
        y = if steps < SEPARATE {
            fma(halved, fma(along ^ SIGN, y, ONE), y)
        } else {
            fmul(halved, fsub(THREE, fmul(along, y)))
        };
    }
    f32::from_bits(y)
}

/// `x` > 0, finite, as (m, n) with x = m·4ⁿ and 1 ≤ m < 4.
fn normalized_by_four(x: f32) -> (f32, i32) {
    let (m, n) = normalized(f64::from(x));
    ((m * power_of_two(n & 1)) as f32, n >> 1)
}

/// 1/√x. 1/√±0 = ±∞, 1/√+∞ = 0, NaN for negative operands.
pub fn rsqrt(x: u32, bits: u32, steps: u32) -> u32 {
    let value = f32::from_bits(x);
    if bits == 0 || value <= 0.0 || !value.is_finite() {
        return canonical((1.0 / f64::from(value).sqrt()) as f32);
    }
    let (m, n) = normalized_by_four(value);
    let result = f64::from(approximate_rsqrt(m, bits, steps)) * power_of_two(-n);
    (result as f32).to_bits()
}

/// √x; the approximate one is m·(1/√m), unless it is made digit by digit. √±0 = ±0, √+∞ = +∞, NaN for negative operands.
pub fn sqrt(x: u32, bits: u32, steps: u32) -> u32 {
    let value = f32::from_bits(x);
    if bits == 0 || value <= 0.0 || !value.is_finite() {
        return canonical(value.sqrt());
    }
    let (m, n) = normalized_by_four(value);
    let root = match kind(bits) {
        RECURRENCE => rounded(f64::from(m).sqrt(), precision(bits)),
        CORDIC => approximation::cordic_root(f64::from(m), precision(bits)),
        _ => f64::from(m * approximate_rsqrt(m, bits, steps)),
    };
    ((root * power_of_two(n)) as f32).to_bits()
}

/// 1/x on the fast unit.
pub fn rcp_fast(x: u32, bits: u32, steps: u32) -> u32 {
    rcp(x, bits, steps)
}

/// 1/√x on the fast unit.
pub fn rsqrt_fast(x: u32, bits: u32, steps: u32) -> u32 {
    rsqrt(x, bits, steps)
}

/// √x on the fast unit.
pub fn sqrt_fast(x: u32, bits: u32, steps: u32) -> u32 {
    sqrt(x, bits, steps)
}

/// a/b on the fast unit.
pub fn fdiv_fast(a: u32, b: u32, bits: u32, steps: u32) -> u32 {
    fdiv(a, b, bits, steps)
}

/// The polynomial with these coefficients, the last the constant one.
#[inline(always)]
fn polynomial<const N: usize>(x: f64, coefficients: [f64; N]) -> f64 {
    let mut sum = coefficients[0];
    for &c in &coefficients[1..] {
        sum = sum * x + c;
    }
    sum
}

/// 2^x for −150 < x < 128: 2ⁿ·e^(r ln 2), n the nearest integer.
pub(crate) fn power(x: f64) -> f64 {
    const TAYLOR: [f64; 13] = [
        1.0 / 479001600.0,
        1.0 / 39916800.0,
        1.0 / 3628800.0,
        1.0 / 362880.0,
        1.0 / 40320.0,
        1.0 / 5040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        1.0 / 2.0,
        1.0,
        1.0,
    ];
    let n = (x + 256.5) as i32 - 256;
    let r = (x - f64::from(n)) * std::f64::consts::LN_2;
    polynomial(r, TAYLOR) * power_of_two(n)
}

/// 2^x. +∞ from 128 on, denormal below −126, 0 from −150 down.
pub fn exp2(x: u32, bits: u32) -> u32 {
    let value = f32::from_bits(x);
    if value.is_nan() {
        return canonical(value);
    } else if value >= 128.0 {
        return f32::INFINITY.to_bits();
    } else if value <= -150.0 {
        return 0;
    }
    let value = f64::from(value);
    let result = if bits == 0 {
        power(value)
    } else {
        // Toward −∞: the cast truncates, and its operand is positive.
        let n = (value + 150.0) as i32 - 150;
        let fraction = value - f64::from(n);
        let first = match kind(bits) {
            TABLE => entry(power(interval(fraction, bits)), bits),
            CORDIC => approximation::cordic_power(fraction, precision(bits)),
            _ => tabulated(Curve::Power, fraction, bits),
        };
        first * power_of_two(n)
    };
    (result as f32).to_bits()
}

/// log2 x for normal x > 0: with x = 2ⁿ·m and m within a factor of √2 of 1,
/// n + (2 / ln 2)·artanh((m − 1)/(m + 1)).
pub(crate) fn logarithm(x: f64) -> f64 {
    const ARTANH: [f64; 10] = [
        1.0 / 19.0,
        1.0 / 17.0,
        1.0 / 15.0,
        1.0 / 13.0,
        1.0 / 11.0,
        1.0 / 9.0,
        1.0 / 7.0,
        1.0 / 5.0,
        1.0 / 3.0,
        1.0,
    ];
    const TWO_LOG2_E: f64 = 2.0 * std::f64::consts::LOG2_E;
    let (mut m, mut n) = normalized(x);
    if m >= std::f64::consts::SQRT_2 {
        (m, n) = (m * 0.5, n + 1);
    }
    let s = (m - 1.0) / (m + 1.0);
    f64::from(n) + s * polynomial(s * s, ARTANH) * TWO_LOG2_E
}

/// log2 x. −∞ for ±0, +∞ for +∞, NaN for negative operands.
pub fn log2(x: u32, bits: u32) -> u32 {
    let value = f32::from_bits(x);
    if value.is_nan() || value < 0.0 {
        return canonical(f32::NAN);
    } else if value == 0.0 {
        return f32::NEG_INFINITY.to_bits();
    } else if value == f32::INFINITY {
        return x;
    }
    let result = if bits == 0 {
        logarithm(f64::from(value))
    } else {
        let (m, n) = normalized(f64::from(value));
        let first = match kind(bits) {
            TABLE => entry(logarithm(interval(m, bits + 1)), bits),
            CORDIC => approximation::cordic_logarithm(m - 1.0, precision(bits)),
            _ => tabulated(Curve::Logarithm, m - 1.0, bits),
        };
        f64::from(n) + first
    };
    (result as f32).to_bits()
}

/// The angle less the nearest multiple of π/2, and that multiple modulo 4; for finite `x`. Fixed
/// point against the bits of 2/π (Payne and Hanek, *Radian reduction for trigonometric functions*,
/// 1983): what remains is right to 2⁻¹⁰⁰ however large `x` is.
fn reduce(x: f32) -> (f64, u32) {
    /// 32 zeros and then the fraction bits of 2/π.
    const TWO_OVER_PI: [u32; 9] = [
        0,
        0xa2f9_836e,
        0x4e44_1529,
        0xfc27_57d1,
        0xf534_ddc0,
        0xdb62_9599,
        0x3c43_9041,
        0xfe51_63ab,
        0xdebb_c561,
    ];
    let magnitude = x.abs();
    if magnitude < std::f32::consts::FRAC_PI_4 {
        return (f64::from(x), 0);
    }
    let mantissa = u128::from((magnitude.to_bits() & 0x007f_ffff) | 0x0080_0000);
    // x = mantissa · 2^(exponent − 150): bits of 2/π above this one only add multiples of 4.
    let exponent = (magnitude.to_bits() >> 23) as usize;
    let start = exponent - 120;
    let mut window: u128 = 0;
    for k in 0..4 {
        let (at, shift) = (start / 32 + k, start % 32);
        let pair = (u64::from(TWO_OVER_PI[at]) << 32) | u64::from(TWO_OVER_PI[at + 1]);
        window = (window << 32) | u128::from((pair << shift >> 32) as u32);
    }
    // Two bits of quarter turns, and 126 of their fraction.
    let turns = mantissa.wrapping_mul(window);
    let quadrant = (((turns >> 125) as u32) + 1) >> 1;
    let fraction = turns << 2;
    let high = (fraction >> 64) as i64 as f64 * power_of_two(-64);
    let low = fraction as u64 as f64 * power_of_two(-128);
    let rest = (high + low) * std::f64::consts::FRAC_PI_2;
    if x < 0.0 {
        (-rest, quadrant.wrapping_neg())
    } else {
        (rest, quadrant)
    }
}

/// sin r for |r| ≤ π/4, by Taylor's series.
pub(crate) fn sine(r: f64) -> f64 {
    const TAYLOR: [f64; 8] = [
        -1.0 / 1307674368000.0,
        1.0 / 6227020800.0,
        -1.0 / 39916800.0,
        1.0 / 362880.0,
        -1.0 / 5040.0,
        1.0 / 120.0,
        -1.0 / 6.0,
        1.0,
    ];
    r * polynomial(r * r, TAYLOR)
}

/// cos r for |r| ≤ π/4, by Taylor's series.
pub(crate) fn cosine(r: f64) -> f64 {
    const TAYLOR: [f64; 9] = [
        1.0 / 20922789888000.0,
        -1.0 / 87178291200.0,
        1.0 / 479001600.0,
        -1.0 / 3628800.0,
        1.0 / 40320.0,
        -1.0 / 720.0,
        1.0 / 24.0,
        -1.0 / 2.0,
        1.0,
    ];
    polynomial(r * r, TAYLOR)
}

/// The approximate sine: sin(t·π/2) for 0 ≤ t ≤ 1.
fn approximate_sine(t: f64, bits: u32) -> f64 {
    let t = match kind(bits) {
        TABLE => interval(t, bits + 1),
        CORDIC => return approximation::cordic_sine(t, precision(bits)),
        _ => return tabulated(Curve::QuarterSine, t, bits),
    };
    let value = if t <= 0.5 {
        sine(t * std::f64::consts::FRAC_PI_2)
    } else {
        cosine((1.0 - t) * std::f64::consts::FRAC_PI_2)
    };
    entry(value, bits)
}

/// sin(x + quadrant·π/2).
fn shifted_sine(x: f32, quadrant: u32, bits: u32) -> u32 {
    if !x.is_finite() {
        return canonical(f32::NAN);
    }
    let (r, reduced) = reduce(x);
    let quadrant = quadrant.wrapping_add(reduced);
    let t = r.abs() * std::f64::consts::FRAC_2_PI;
    let value = match (bits, quadrant & 1) {
        (0, 0) => sine(r),
        (0, _) => cosine(r),
        (_, 0) => approximate_sine(t, bits).copysign(r),
        (_, _) => approximate_sine(1.0 - t, bits),
    };
    let value = if quadrant & 2 == 0 { value } else { -value };
    (value as f32).to_bits()
}

/// sin x. sin ±0 = ±0, NaN for ±∞.
pub fn sin(x: u32, bits: u32) -> u32 {
    shifted_sine(f32::from_bits(x), 0, bits)
}

/// cos x. NaN for ±∞.
pub fn cos(x: u32, bits: u32) -> u32 {
    shifted_sine(f32::from_bits(x), 1, bits)
}
