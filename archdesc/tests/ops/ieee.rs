//! Float arithmetic against `rustc_apfloat`, a software implementation of IEEE 754.

use crate::values::{INTEGERS, Random, floats, result, rounds};
use rustc_apfloat::ieee::Single;
use rustc_apfloat::{Float, Round};
use srp_archdesc::arch::{Precision, Subnormals};
use srp_archdesc::isa::Kind;
use srp_archdesc::ops::{V4, eval};
use srp_archdesc::{Class, Opcode};

/// The opcodes that this file tests.
pub(crate) const COVERED: &[Opcode] = &[
    Opcode::Fadd,
    Opcode::Fsub,
    Opcode::Fmul,
    Opcode::Fdiv,
    Opcode::Fma,
    Opcode::Fmin,
    Opcode::Fmax,
    Opcode::Fneg,
    Opcode::Fabs,
    Opcode::Ffloor,
    Opcode::Feq,
    Opcode::Fne,
    Opcode::Flt,
    Opcode::Fle,
    Opcode::Itof,
    Opcode::Utof,
    Opcode::Ftoi,
    Opcode::Ftou,
];

fn single(bits: u32) -> Single {
    Single::from_bits(bits.into())
}

fn bits(x: Single) -> u32 {
    if x.is_nan() {
        0x7fc0_0000
    } else {
        x.to_bits() as u32
    }
}

/// `x` less or equal `y`, −0 less than +0; neither NaN.
fn ordered(x: Single, y: Single) -> bool {
    x < y || (x == y && (x.is_negative() || !y.is_negative()))
}

fn expected(op: Opcode, a: u32, b: u32, c: u32) -> u32 {
    let (x, y) = (single(a), single(b));
    let mut exact = false;
    let mut integer = |width| x.to_i128_r(width, Round::TowardZero, &mut exact).value as u32;
    match op {
        Opcode::Fadd => bits((x + y).value),
        Opcode::Fsub => bits((x - y).value),
        Opcode::Fmul => bits((x * y).value),
        Opcode::Fdiv => bits((x / y).value),
        Opcode::Fma => bits(x.mul_add(y, single(c)).value),
        Opcode::Fmin | Opcode::Fmax if x.is_nan() => bits(y),
        Opcode::Fmin | Opcode::Fmax if y.is_nan() => bits(x),
        Opcode::Fmin => bits(if ordered(x, y) { x } else { y }),
        Opcode::Fmax => bits(if ordered(x, y) { y } else { x }),
        Opcode::Fneg => bits(-x),
        Opcode::Fabs => bits(x.abs()),
        Opcode::Ffloor => bits(x.round_to_integral(Round::TowardNegative).value),
        Opcode::Feq => (x == y).into(),
        Opcode::Fne => (x != y).into(),
        Opcode::Flt => (x < y).into(),
        Opcode::Fle => (x <= y).into(),
        Opcode::Itof => bits(Single::from_i128((a as i32).into()).value),
        Opcode::Utof => bits(Single::from_u128(a.into()).value),
        Opcode::Ftoi => integer(32),
        Opcode::Ftou => x.to_u128_r(32, Round::TowardZero, &mut exact).value as u32,
        _ => unreachable!("not listed"),
    }
}

fn check(op: Opcode, a: u32, b: u32, c: u32) {
    let operands = &[a, b, c][..op.info().operands.len()];
    let (got, expected) = (result(op, operands), expected(op, a, b, c));
    assert_eq!(
        got, expected,
        "{op} {a:#x} {b:#x} {c:#x}: {got:#x}, {expected:#x}"
    );
}

#[test]
fn special_values() {
    let values = floats();
    for &op in COVERED {
        for (&a, &b) in values
            .iter()
            .flat_map(|a| values.iter().map(move |b| (a, b)))
        {
            check(op, a, b, 0);
        }
        for &a in INTEGERS {
            check(op, a, a, a);
        }
    }
}

#[test]
fn fused_multiply_add_of_special_values() {
    let values = floats();
    for &a in &values {
        for (&b, &c) in values
            .iter()
            .flat_map(|b| values.iter().map(move |c| (b, c)))
        {
            check(Opcode::Fma, a, b, c);
        }
    }
}

#[test]
fn random_values() {
    let mut random = Random(4);
    for &op in COVERED {
        for round in 0..rounds(100_000) {
            // Any bits; or floats that meet, so that something cancels and something is kept.
            let mut word = || match round % 2 {
                0 => random.word(),
                _ => random.near_one(13),
            };
            check(op, word(), word(), word());
        }
    }
}

/// Rounded to binary64 and then to binary32: what a fused multiply-add must not be.
fn rounded_twice(a: u32, b: u32, c: u32) -> u32 {
    let [a, b, c] = [a, b, c].map(|x| f64::from(f32::from_bits(x)));
    ((a * b + c) as f32).to_bits()
}

/// Sums so close to half way between two floats that binary64 has them half way; normal and
/// denormal, from below and from above.
#[test]
fn fused_multiply_add_just_off_half_way() {
    let mut random = Random(5);
    let (mut normal, mut denormal) = (0, 0);
    for round in 0..rounds(100_000) {
        let k = 1 + random.word() % 200;
        let (a, b, c) = if round % 2 == 0 {
            // c and half a place of it, less one part in 2^46 / k²: (1 + k/2^23)·(1 − k/2^23).
            let exponent = random.word() % if round % 4 == 0 { 3 } else { 200 };
            let c = (random.word() & 0x807f_ffff) | exponent << 23;
            let (e, f) = (exponent.max(1) / 2 + 51, exponent.max(1).div_ceil(2) + 52);
            (e << 23 | k, ((f - 1) << 23) + (0x80_0000 - 2 * k), c)
        } else {
            // An odd product of 25 bits, and next to nothing.
            let a = (random.word() % 0x800 * 2 + 0x1001) as f32;
            let b = (random.word() % 0x1000 * 2 + 0x2001) as f32;
            let c = f32::from_bits(0x0080_0000 + k) * [1.0, -1.0][k as usize % 2];
            (a.to_bits(), b.to_bits(), c.to_bits())
        };
        for sign in [0, 1 << 31] {
            check(Opcode::Fma, a, b ^ sign, c);
            if rounded_twice(a, b ^ sign, c) != result(Opcode::Fma, &[a, b ^ sign, c]) {
                let small = result(Opcode::Fma, &[a, b ^ sign, c]) << 1 < 0x0100_0000;
                *if small { &mut denormal } else { &mut normal } += 1;
            }
        }
    }
    let least = rounds(100_000) / 100;
    assert!(
        normal > 10 * least && denormal > least,
        "{normal} {denormal}"
    );
}

/// Where subnormal floats are flushed, an operation on floats is that on operands without them, and its
/// result has none; all others are as they were.
#[test]
fn flushed_operations_know_no_subnormals() {
    let flushing = Precision {
        subnormals: Subnormals::Flush,
        ..Precision::EXACT
    };
    let subnormal = |x: u32| x & 0x7f80_0000 == 0 && x & 0x7f_ffff != 0;
    let flush = |x: u32| if subnormal(x) { x & 0x8000_0000 } else { x };
    let mut random = Random(12);
    let mut pick = || match random.word() % 3 {
        0 => random.word() & 0x80ff_ffff,
        1 => (random.word() % 0x2000_0000) | 0x3000_0000,
        _ => random.word(),
    };
    let mut flushed = 0;
    for &op in Opcode::ALL
        .iter()
        .filter(|op| op.is_pure() && op.class() != Class::Idiv)
    {
        let kinds = op.info().operands;
        let floats = matches!(
            op.class(),
            Class::Fadd
                | Class::Fmul
                | Class::Fma
                | Class::Fdiv
                | Class::Sfu
                | Class::Fast
                | Class::Vfadd
                | Class::Vfmul
                | Class::Vfma
                | Class::Vdot
        );
        let others = ["fneg", "fabs", "vfneg", "vfabs", "vitof", "vftoi"];
        let floats = floats && !others.contains(&op.name());
        for _ in 0..500 {
            let args: Vec<V4> = kinds.iter().map(|_| V4([0; 4].map(|_| pick()))).collect();
            let found = eval(op, &args, 1, &flushing).expect("nothing is divided");
            let args = match floats {
                true => args.iter().map(|v| V4(v.0.map(flush))).collect(),
                false => args,
            };
            let mut expected = eval(op, &args, 1, &Precision::EXACT).expect("nothing is divided");
            let gives_floats = matches!(op.info().result, Some(Kind::F | Kind::F4));
            if let Some(value) = expected.as_mut().filter(|_| floats && gives_floats) {
                flushed += value.0.iter().filter(|&&x| subnormal(x)).count();
                *value = V4(value.0.map(flush));
            }
            assert_eq!(found, expected, "{op} {args:x?}");
        }
    }
    assert!(flushed > 100, "{flushed} results were flushed");
}
