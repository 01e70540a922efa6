//! Powers with constant exponents.

use super::tree::{Expressions, Made, Tree, operation};
use crate::program::*;
use srp_archdesc::isa::{Opcode, Ty};

/// The largest exponent that is written out as products.
const MOST_PRODUCTS: f32 = 32.0;

/// The least exponent for which exp2 and log2 are tried.
const LEAST_BY_LOGARITHM: u32 = 5;

/// exp2 (c · log2 x), or `powf (x, c)`, as products, with a root for half an exponent.
pub(super) fn products(within: &Expressions<'_>, inst: Inst) -> Option<Tree> {
    let Expressions { func, made, .. } = within;
    let (base, exponent) = match within.power(inst) {
        Some(&[base, exponent]) => (base, made.constant(func, exponent)?),
        Some(_) => return None,
        None => of_logarithm(func, made, inst)?,
    };
    let twice = exponent * 2.0;
    if twice.fract() != 0.0 || exponent == 0.0 || exponent.abs() > MOST_PRODUCTS {
        return None;
    }
    let whole = exponent.abs().trunc() as u32;
    let power = whole_power(&Tree::Value(base), whole);
    let power = match exponent.fract() == 0.0 {
        true => power,
        false => Tree::product(power, Tree::Op(Opcode::Sqrt, vec![Tree::Value(base)])),
    };
    Some(match exponent < 0.0 {
        true => Tree::quotient(Tree::Constant(1.0), power),
        false => power,
    })
}

/// Base and exponent of exp2 (c · log2 x).
fn of_logarithm(func: &Function, made: &Made, inst: Inst) -> Option<(Value, f32)> {
    let (Opcode::Exp2, [exponent]) = operation(func, inst)? else {
        return None;
    };
    let (Opcode::Fmul, [a, b]) = made.operation(func, *exponent)? else {
        return None;
    };
    let parts = |factor: Value, logarithm: Value| {
        let (Opcode::Log2, [base]) = made.operation(func, logarithm)? else {
            return None;
        };
        Some((*base, made.constant(func, factor)?))
    };
    parts(*a, *b).or_else(|| parts(*b, *a))
}

/// x to a whole exponent by squares.
fn whole_power(x: &Tree, exponent: u32) -> Tree {
    match exponent {
        0 => Tree::Constant(1.0),
        1 => x.clone(),
        _ => {
            let half = whole_power(x, exponent / 2);
            let square = Tree::product(half.clone(), half);
            match exponent % 2 {
                0 => square,
                _ => Tree::product(square, x.clone()),
            }
        }
    }
}

/// Products of one factor alone as exp2 (n · log2 x).
pub(super) fn exp2_log2(within: &Expressions<'_>, inst: Inst) -> Option<Tree> {
    let Expressions { func, made, .. } = within;
    let result = *func.insts[inst].results.first()?;
    if func.values[result] != Ty::Word || operation(func, inst)?.0 != Opcode::Fmul {
        return None;
    }
    let (base, exponent) = power(func, made, result);
    if !(LEAST_BY_LOGARITHM..=1 << 20).contains(&exponent) {
        return None;
    }
    let logarithm = Tree::Op(Opcode::Log2, vec![Tree::Value(base)]);
    let scaled = Tree::product(Tree::Constant(exponent as f32), logarithm);
    Some(Tree::Op(Opcode::Exp2, vec![scaled]))
}

/// A value as a power of another.
fn power(func: &Function, made: &Made, value: Value) -> (Value, u32) {
    if let Some((Opcode::Fmul, &[a, b])) = made.operation(func, value) {
        let (a, b) = (power(func, made, a), power(func, made, b));
        if a.0 == b.0 {
            return (a.0, a.1.saturating_add(b.1));
        }
    }
    (value, 1)
}
