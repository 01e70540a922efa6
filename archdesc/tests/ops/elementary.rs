//! The special functions: exact ones against exact arithmetic or a finer reference, tables against
//! what their precision promises.

use crate::double_double::{self, Dd};
use crate::values::{Random, floats, result, rounds};
use srp_archdesc::Opcode;
use srp_archdesc::arch::{Approx, Refine};
use srp_archdesc::structure::Structure;

use srp_archdesc::ops::semantics::elementary::{
    SEPARATE, cos, exp2, fdiv, log2, rcp, rsqrt, sin, sqrt,
};

const ONE: u32 = 0x3f80_0000;
const NAN: u32 = 0x7fc0_0000;
const INFINITY: u32 = 0x7f80_0000;
const SIGN: u32 = 1 << 31;
/// The float that comes closest to a multiple of π/2 for its size.
const CLOSEST: u32 = 0x6f79_be45;

/// Mantissa and exponent, `mantissa · 2^exponent`, of a positive finite float.
fn parts(x: u32) -> (u128, i32) {
    match x >> 23 {
        0 => (u128::from(x), -149),
        e => (u128::from(x & 0x7f_ffff | 0x80_0000), e as i32 - 150),
    }
}

/// True if `y` is the float nearest to 1/√x: (y ± half a place)² · x lies on both sides of 1.
fn nearest_rsqrt(x: u32, y: u32) -> bool {
    let ((m, e), (n, f)) = (parts(x), parts(y));
    // Half a place below a power of two is half as long; then the test asks for more than it must.
    let one = 1u128 << -(e + 2 * (f - 1));
    (2 * n - 1).pow(2) * m < one && one < (2 * n + 1).pow(2) * m
}

/// True if `y` is the float nearest to √x.
fn nearest_sqrt(x: u32, y: u32) -> bool {
    let ((m, e), (n, f)) = (parts(x), parts(y));
    let m = m << (e - 2 * (f - 1));
    (2 * n - 1).pow(2) < m && m < (2 * n + 1).pow(2)
}

#[test]
fn rsqrt_is_correctly_rounded_for_every_mantissa() {
    for x in 0x3f80_0000u32..0x4080_0000 {
        let y = rsqrt(x, 0, 0);
        assert!(nearest_rsqrt(x, y), "{x:#x} {y:#x}");
    }
    // Four times as much is half as much, down to the denormals.
    for shift in (2..=126).step_by(2) {
        let y = rsqrt(0x3fc1_2345 - (shift << 23), 0, 0);
        assert_eq!(y, rsqrt(0x3fc1_2345, 0, 0) + ((shift / 2) << 23));
    }
    for denormal in 1..1000u32 {
        let scaled = (f64::from(f32::from_bits(denormal)) * 2f64.powi(60)) as f32;
        let y = rsqrt(scaled.to_bits(), 0, 0);
        assert_eq!(rsqrt(denormal, 0, 0), y + (30 << 23));
    }
}

#[test]
fn sqrt_is_correctly_rounded() {
    let mut random = Random(7);
    let specials = floats();
    let values = (0..rounds(200_000)).map(|_| random.word() & !SIGN);
    let mut tested = 0;
    for x in values.chain(specials).filter(|&x| x > 0 && x < INFINITY) {
        assert!(nearest_sqrt(x, sqrt(x, 0, 0)), "{x:#x}");
        tested += 1;
    }
    assert!(tested > rounds(200_000) / 2);
}

#[test]
fn special_operands() {
    let precisions = [(0, 0), (4, 0), (8, 1), (12, 2), (23, 3)];
    let separate = [(4, 3 | SEPARATE), (12, 1 | SEPARATE)];
    for (bits, steps) in precisions.into_iter().chain(separate) {
        for (x, y) in [
            (0, INFINITY),
            (SIGN, SIGN | INFINITY),
            (INFINITY, 0),
            (SIGN | INFINITY, SIGN),
            (0x7f80_0001, NAN),
            (0xffff_ffff, NAN),
            (ONE, ONE),
            (SIGN | ONE, SIGN | ONE),
            (0x0000_0001, INFINITY),
            (0x8010_0000, SIGN | INFINITY),
            (0x0040_0000, 0x7f00_0000),
            (0x7f00_0000, 0x0040_0000),
        ] {
            assert_eq!(rcp(x, bits, steps), y, "rcp {x:#x}, {bits} bits");
        }
        for (x, root, inverse) in [
            (0, 0, INFINITY),
            (SIGN, SIGN, SIGN | INFINITY),
            (INFINITY, INFINITY, 0),
            (SIGN | INFINITY, NAN, NAN),
            (SIGN | ONE, NAN, NAN),
            (0x8000_0001, NAN, NAN),
            (0xff80_0001, NAN, NAN),
            (ONE, ONE, ONE),
            (0x4080_0000, 0x4000_0000, 0x3f00_0000),
            (0x0020_0000, 0x1f80_0000, 0x5f80_0000),
        ] {
            assert_eq!(sqrt(x, bits, steps), root, "sqrt {x:#x}, {bits} bits");
            assert_eq!(rsqrt(x, bits, steps), inverse, "rsqrt {x:#x}, {bits} bits");
        }
        for (x, power) in [
            (0, ONE),
            (SIGN, ONE),
            (INFINITY, INFINITY),
            (SIGN | INFINITY, 0),
            (0x7f80_0001, NAN),
            (0x42fe_0000, 0x7f00_0000),
            (0x4300_0000, INFINITY),
            (0xc2fc_0000, 0x0080_0000),
            (0xc2fe_0000, 0x0040_0000),
            (0xc315_0000, 1),
            (0xc316_0000, 0),
            (0xff7f_ffff, 0),
        ] {
            assert_eq!(exp2(x, bits), power, "exp2 {x:#x}, {bits} bits");
        }
        for (x, log) in [
            (0, SIGN | INFINITY),
            (SIGN, SIGN | INFINITY),
            (INFINITY, INFINITY),
            (SIGN | INFINITY, NAN),
            (0x8000_0001, NAN),
            (NAN, NAN),
            (ONE, 0),
            (0x4300_0000, 0x40e0_0000),
            (0x0000_0001, 0xc315_0000),
        ] {
            assert_eq!(log2(x, bits), log, "log2 {x:#x}, {bits} bits");
        }
        assert_eq!([sin(0, bits), sin(SIGN, bits)], [0, SIGN]);
        assert_eq!([cos(0, bits), cos(SIGN, bits)], [ONE, ONE]);
        for x in [INFINITY, SIGN | INFINITY, NAN, 0xff80_0001] {
            assert_eq!([sin(x, bits), cos(x, bits)], [NAN, NAN]);
        }
    }
}

/// |y − reference| in units in the last place of a binary32 number of that size.
fn ulps(y: u32, reference: Dd) -> f64 {
    let exponent = (reference.0.abs().to_bits() >> 52) as i32 - 1023;
    let difference = Dd(f64::from(f32::from_bits(y)), 0.0).add(Dd(-reference.0, -reference.1));
    difference.0.abs() / 2f64.powi(exponent.max(-126) - 23)
}

/// The largest error of `op` over operands from `pick`, for finite results.
fn worst(op: Opcode, pick: impl Fn(&mut Random) -> u32, reference: impl Fn(f32) -> Dd) -> f64 {
    let mut random = Random(8);
    let mut worst: f64 = 0.0;
    for _ in 0..rounds(100_000) {
        let x = pick(&mut random);
        let value = f32::from_bits(x);
        let y = result(op, &[x]);
        if value.is_finite() && f32::from_bits(y).is_finite() {
            worst = worst.max(ulps(y, reference(value)));
        }
    }
    println!("{op}: at most {worst:.6} ulp");
    worst
}

#[test]
fn transcendental_functions_are_rounded_once() {
    let power = |x: f32| double_double::exp2(Dd(x.into(), 0.0));
    let spread = |random: &mut Random| (random.word() as i32 as f32 * 2f32.powi(-24)).to_bits();
    assert!(worst(Opcode::Exp2, spread, power) < 0.501);
    let small = |random: &mut Random| random.near_one(30) & !0x4000_0000;
    assert!(worst(Opcode::Exp2, small, power) < 0.501);
    let log = |x: f32| double_double::log2(x.into());
    assert!(worst(Opcode::Log2, |random| random.word() & !SIGN, log) < 0.501);
    let about_one = |random: &mut Random| ONE - 0x1_0000 + random.word() % 0x2_0000;
    assert!(worst(Opcode::Log2, about_one, log) < 0.501);
    for (op, quadrant) in [(Opcode::Sin, 0), (Opcode::Cos, 1)] {
        let sine = |x: f32| double_double::shifted_sine(x, quadrant);
        assert!(worst(op, Random::word, sine) < 0.501);
        assert!(worst(op, |random| random.near_one(10), sine) < 0.501);
        // The floats nearest to multiples of π/2, where nearly all of the operand goes.
        let multiple = |random: &mut Random| {
            let turns = f64::from(random.word() >> (random.word() % 32));
            ((turns * std::f64::consts::FRAC_PI_2) as f32).to_bits()
        };
        assert!(worst(op, multiple, sine) < 0.501);
        let closest = sine(f32::from_bits(CLOSEST));
        assert!(ulps(result(op, &[CLOSEST]), closest) < 0.501);
        assert!(
            quadrant == 0 || closest.0.abs() < 2f64.powi(-29),
            "{closest:?}"
        );
    }
}

/// Largest relative error of a table over these operands, rising; its values must fall.
fn falling(
    operands: impl Iterator<Item = u32>,
    approximate: impl Fn(u32) -> u32,
    exact: impl Fn(f64) -> f64,
) -> f64 {
    let (mut last, mut worst) = (f32::INFINITY, 0f64);
    for x in operands {
        let y = f32::from_bits(approximate(x));
        assert!(y <= last, "{x:#x}");
        last = y;
        worst = worst.max((f64::from(y) / exact(f32::from_bits(x).into()) - 1.0).abs());
    }
    worst
}

#[test]
fn reciprocal_tables_are_monotone_and_keep_their_bits() {
    // Every mantissa of one table, every fifth of the others.
    for (bits, step) in [(4, 5), (8, 5), (12, 1), (17, 5), (23, 5)] {
        let bound = 2f64.powi(-(bits as i32));
        let octave = (ONE..ONE + (1 << 23)).step_by(step);
        let error = falling(octave, |x| rcp(x, bits, 0), |x| 1.0 / x);
        assert!(error < bound, "rcp, {bits} bits: 2^{}", error.log2());
        let octaves = (ONE..ONE + (2 << 23)).step_by(step);
        let error = falling(octaves, |x| rsqrt(x, bits, 0), |x| 1.0 / x.sqrt());
        assert!(error < bound, "rsqrt, {bits} bits: 2^{}", error.log2());
    }
}

#[test]
fn tables_scale_by_powers_of_two_and_keep_signs() {
    let mut random = Random(9);
    for (bits, steps) in [(4, 0), (7, 1), (12, 2)] {
        for k in 1..254u32 {
            assert_eq!(
                f32::from_bits(rcp(k << 23, bits, steps)),
                2f32.powi(127 - k as i32)
            );
            let mantissa = random.word() & 0x7f_ffff;
            let (x, y) = (k << 23 | mantissa, rcp(ONE | mantissa, bits, steps));
            let scaled = f64::from(f32::from_bits(y)) * 2f64.powi(127 - k as i32);
            assert_eq!(rcp(x, bits, steps), (scaled as f32).to_bits());
            assert_eq!(rcp(x | SIGN, bits, steps), rcp(x, bits, steps) | SIGN);
        }
    }
}

/// Every 61st mantissa.
#[test]
fn newton_steps_reach_full_precision() {
    for (bits, steps, bound) in [(12, 1, 1.0), (8, 2, 0.51), (12, 2, 0.5001)] {
        let mut worst = 0f64;
        for x in (ONE..ONE + (1 << 23)).step_by(61) {
            let exact = 1.0 / f64::from(f32::from_bits(x));
            worst = worst.max(ulps(rcp(x, bits, steps), Dd(exact, 0.0)));
        }
        println!("rcp {bits}+{steps}: {worst:.4} ulp");
        assert!(worst <= bound, "rcp {bits}+{steps}: {worst}");
    }
    for (bits, steps, bound) in [(12, 1, 1.2), (12, 2, 1.0), (8, 2, 1.1)] {
        let (mut inverse, mut root) = (0f64, 0f64);
        for x in (ONE..ONE + (2 << 23)).step_by(61) {
            let exact = f64::from(f32::from_bits(x)).sqrt();
            inverse = inverse.max(ulps(rsqrt(x, bits, steps), Dd(1.0 / exact, 0.0)));
            root = root.max(ulps(sqrt(x, bits, steps), Dd(exact, 0.0)));
        }
        println!("rsqrt {bits}+{steps}: {inverse:.4} ulp, sqrt {root:.4} ulp");
        assert!(
            inverse <= bound && root <= bound + 0.6,
            "{bits}+{steps}: {inverse} {root}"
        );
    }
}

/// Every 61st mantissa, with and without steps; `certificates` tries all of them.
#[test]
fn the_bound_of_a_unit_holds() {
    let tables = [(4, 0), (8, 1), (12, 0), (12, 1), (23, 0), (5, 3)];
    let separate = |(bits, steps)| Approx::Table {
        structure: Structure::Table,
        bits,
        steps,
        fused: false,
        refine: Refine::Unit,
    };
    let fused = tables.map(|(bits, steps)| Approx::table(bits, steps));
    for approx in fused
        .into_iter()
        .chain([(8, 1), (12, 1), (12, 2)].map(separate))
    {
        let bound = approx.error_bound();
        let (bits, steps) = approx.arguments();
        let (mut inverse, mut roots) = (0f64, 0f64);
        for x in (ONE..ONE + (2 << 23)).step_by(61) {
            let value = f64::from(f32::from_bits(x));
            let off = |y: u32, by: f64| (f64::from(f32::from_bits(y)) * by - 1.0).abs();
            if x < ONE + (1 << 23) {
                inverse = inverse.max(off(rcp(x, bits, steps), value));
            }
            let root = value.sqrt();
            roots = roots.max(off(rsqrt(x, bits, steps), root));
            roots = roots.max(off(sqrt(x, bits, steps), 1.0 / root));
        }
        println!("{bits}+{steps}: {inverse:.3e}, {roots:.3e}, at most {bound:.3e}");
        assert!(inverse <= bound && roots <= bound, "{bits}+{steps}");
        // It is no idle one.
        assert!(inverse.max(roots) * 16.0 > bound, "{bits}+{steps}");
    }
}

/// The quotient of a table is off by what its reciprocal is and a rounding more, and where it is
/// denormal by half of the least number; zeros, infinities and NaNs are those of exact division.
#[test]
fn quotients_keep_their_bits() {
    let mut random = Random(11);
    let specials = floats();
    let pairs = specials.iter().flat_map(|&a| {
        let specials = specials.clone();
        specials.into_iter().map(move |b| (a, b))
    });
    let pairs: Vec<(u32, u32)> = pairs
        .chain((0..50_000).map(|_| (random.word(), random.word())))
        .collect();
    for (bits, steps, error) in [
        (0, 0, 0.5f64.powi(24)),
        (6, 0, 0.5f64.powi(6)),
        (12, 1 | SEPARATE, 2.5 * 0.5f64.powi(23)),
        (12, 2, 1.1 * 0.5f64.powi(23)),
    ] {
        for &(a, b) in &pairs {
            let (above, below) = (f32::from_bits(a), f32::from_bits(b));
            let found = f32::from_bits(fdiv(a, b, bits, steps));
            let exact = f64::from(above) / f64::from(below);
            if !exact.is_normal() || !below.is_finite() {
                let expected = above / below;
                assert!(
                    found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan(),
                    "{above} / {below} = {found}"
                );
            } else if exact.abs() < f64::from(f32::MAX) * (1.0 - error) {
                let bound = exact.abs() * (error + 0.5f64.powi(24)) + 0.5f64.powi(150);
                let off = (f64::from(found) - exact).abs();
                assert!(off <= bound, "{above} / {below} = {found}, {bits} bits");
            } else if exact.abs() > f64::from(f32::MAX) * (1.0 + 2.0 * error) {
                assert_eq!(f64::from(found), exact.signum() * f64::INFINITY);
            }
        }
    }
}

#[test]
fn tables_of_the_other_functions_keep_their_bits() {
    let mut random = Random(10);
    for bits in [4, 8, 12, 16, 23] {
        // Besides the table's own error, the result is rounded to binary32.
        let bound = 2f64.powi(-(bits as i32));
        let mut last = 0f32;
        for k in -12_700..12_700 {
            let x = k as f32 * 0.01;
            let y = f32::from_bits(exp2(x.to_bits(), bits));
            assert!(y >= last, "exp2 {x}");
            last = y;
            let exact = f64::from(x).exp2();
            let error = (f64::from(y) - exact).abs();
            assert!(
                error < exact * (bound + 2f64.powi(-24)) + 2f64.powi(-150),
                "exp2 {x}"
            );
        }
        for _ in 0..20_000 {
            let x = random.word() & !SIGN;
            let value = f32::from_bits(x);
            if value.is_finite() && value > 0.0 {
                let exact = f64::from(value).log2();
                let y = f64::from(f32::from_bits(log2(x, bits)));
                assert!(
                    (y - exact).abs() < bound + exact.abs() * 2f64.powi(-24),
                    "log2 {value}"
                );
                let next = f64::from(f32::from_bits(log2(x + 1, bits)));
                assert!(next >= y, "log2 {value}");
            }
            let x = random.near_one(20);
            let (angle, half) = (f64::from(f32::from_bits(x)), 2f64.powi(-25));
            let y = f64::from(f32::from_bits(sin(x, bits)));
            assert!((y - angle.sin()).abs() < bound + half, "sin {angle}");
            let y = f64::from(f32::from_bits(cos(x, bits)));
            assert!((y - angle.cos()).abs() < bound + half, "cos {angle}");
            assert_eq!(sin(x ^ SIGN, bits), sin(x, bits) ^ SIGN);
            assert_eq!(cos(x ^ SIGN, bits), cos(x, bits));
        }
    }
}
