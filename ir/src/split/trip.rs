//! How often a loop runs, computed before it starts.
//!
//! The loop is in rotated form: the body runs once before the test is first made. Two ways lead to
//! the number. Where the control code has made the same test just before entering (the guard of a
//! `for` or `while` loop), the number is the distance from the start to the bound in strides,
//! rounded up. Where it has not (a `do` loop), it is one more than the number of tests that succeed.
//!
//! Integers wrap, and `!=` loops are exact even then. For ordered tests the variable is taken to
//! meet its bound before it wraps: a loop for which it does not runs over 2³² / stride times.
//! 2³² iterations come out as 0, which is what a trip count of 0 means.

use super::induction::Inductions;
use super::linear::{Affine, Linear};
use super::shape::Loop;
use super::words::{Word, Words};
use super::{Reason, Refusal};
use crate::program::{Bits, Terminator, Value};
use srp_archdesc::isa::Opcode;

/// How far back guards are looked for.
const MAX_GUARD_BLOCKS: usize = 32;

/// The loop goes on while `left test right`.
struct ExitTest {
    test: Opcode,
    left: Affine,
    right: Affine,
}

/// The trip count, as instructions appended to `words`.
pub(super) fn trip_count(
    lp: &Loop<'_>,
    inductions: &Inductions<'_>,
    words: &mut Words<'_>,
) -> Result<Word, Refusal> {
    if let Some(Bits::Pred(p)) = lp.constant(lp.cond) {
        return if p == lp.sense {
            Err(refusal(lp, lp.cond, Reason::NeverEnds))
        } else {
            Ok(Word::Const(1))
        };
    }
    let exit = exit_test(lp, inductions)?;
    let constant_stride = |a: &Affine| a.stride.as_constant();
    let (Some(left), Some(right)) = (constant_stride(&exit.left), constant_stride(&exit.right))
    else {
        return Err(refusal(lp, lp.cond, Reason::VariableStride));
    };
    // What one iteration takes off the distance `right - left`.
    let step = left.wrapping_sub(right);
    if step == 0 {
        return Err(refusal(lp, lp.cond, Reason::ConstantExit));
    }
    let guarded = is_guarded(lp, inductions, &exit);
    let trip = match exit.test {
        Opcode::Ne => until_equal(&exit, step, guarded, words),
        Opcode::Eq => {
            let equal = words.test(Opcode::Eq, &exit.left.base, &exit.right.base);
            words.select(equal, Word::Const(2), Word::Const(1))
        }
        _ if (step as i32) > 0 => until_past(&exit, step, guarded, words),
        Opcode::Ltu if step == u32::MAX && right == 0 => down_past_zero(&exit, guarded, words),
        _ => {
            return Err(refusal(lp, lp.cond, Reason::AwayFromBound));
        }
    };
    Ok(trip)
}

fn refusal(lp: &Loop<'_>, value: Value, reason: Reason) -> Refusal {
    let pos = lp.inst(value).map(|data| data.pos);
    Refusal {
        pos: pos.unwrap_or(lp.func.blocks[lp.block].end_pos),
        reason,
    }
}

/// A comparison in a form in which equal ones are equal: `lt`, `le`, `ltu`, `leu`, `eq` or `ne`
/// that is true.
fn comparison(lp: &Loop<'_>, mut cond: Value, mut sense: bool) -> Option<(Opcode, Value, Value)> {
    loop {
        match lp.op(cond)? {
            (Opcode::Pnot, [inner]) => {
                cond = *inner;
                sense = !sense;
            }
            (Opcode::Pmov, [inner]) => cond = *inner,
            (op, [a, b]) => {
                return Some(match (op, sense) {
                    (Opcode::Eq | Opcode::Ne | Opcode::Lt, true) => (op, *a, *b),
                    (Opcode::Le | Opcode::Ltu | Opcode::Leu, true) => (op, *a, *b),
                    (Opcode::Eq, false) => (Opcode::Ne, *a, *b),
                    (Opcode::Ne, false) => (Opcode::Eq, *a, *b),
                    (Opcode::Lt, false) => (Opcode::Le, *b, *a),
                    (Opcode::Le, false) => (Opcode::Lt, *b, *a),
                    (Opcode::Ltu, false) => (Opcode::Leu, *b, *a),
                    (Opcode::Leu, false) => (Opcode::Ltu, *b, *a),
                    _ => return None,
                });
            }
            _ => return None,
        }
    }
}

fn exit_test(lp: &Loop<'_>, inductions: &Inductions<'_>) -> Result<ExitTest, Refusal> {
    let Some((test, left, right)) = comparison(lp, lp.cond, lp.sense) else {
        return Err(refusal(lp, lp.cond, Reason::NoExitBound));
    };
    let affine = |value: Value| {
        let affine = inductions.affine(value);
        affine.ok_or_else(|| refusal(lp, value, Reason::IrregularExit))
    };
    Ok(ExitTest {
        test,
        left: affine(left)?,
        right: affine(right)?,
    })
}

/// True if control code reaches the loop only where the exit test held one step before.
fn is_guarded(lp: &Loop<'_>, inductions: &Inductions<'_>, exit: &ExitTest) -> bool {
    let before = |a: &Affine| a.base.minus(&a.stride);
    let wanted = canonical(exit.test, before(&exit.left), before(&exit.right));
    let mut block = lp.block;
    for _ in 0..MAX_GUARD_BLOCKS {
        if lp.is_entry(block) {
            return false;
        }
        // Only the loop's own back edge is no entry.
        let is_entry = |from| block != lp.block || from != lp.block;
        let mut entries = lp.jumps_to(block).filter(|(from, _)| is_entry(*from));
        let (Some((from, _)), None) = (entries.next(), entries.next()) else {
            return false;
        };
        if let Terminator::Branch { cond, then, .. } = &lp.func.blocks[from].end {
            let taken = then.block == block;
            let known = comparison(lp, *cond, taken).and_then(|(test, a, b)| {
                let (a, b) = (inductions.affine(a)?, inductions.affine(b)?);
                Some(canonical(test, a.base, b.base))
            });
            if known.is_some_and(|known| implies(&known, &wanted)) {
                return true;
            }
        }
        block = from;
    }
    false
}

/// Equalities with the constant second; `0 < x` unsigned as `x != 0`.
fn canonical(test: Opcode, a: Linear, b: Linear) -> (Opcode, Linear, Linear) {
    match test {
        Opcode::Ltu if a.as_constant() == Some(0) => (Opcode::Ne, b, a),
        Opcode::Eq | Opcode::Ne if a.as_constant().is_some() => (test, b, a),
        _ => (test, a, b),
    }
}

fn implies(known: &(Opcode, Linear, Linear), wanted: &(Opcode, Linear, Linear)) -> bool {
    let same = known.1 == wanted.1 && known.2 == wanted.2;
    let swapped = known.1 == wanted.2 && known.2 == wanted.1;
    let stronger = match wanted.0 {
        Opcode::Le => matches!(known.0, Opcode::Le | Opcode::Lt),
        Opcode::Leu => matches!(known.0, Opcode::Leu | Opcode::Ltu),
        Opcode::Ne => matches!(known.0, Opcode::Ne | Opcode::Lt | Opcode::Ltu),
        test => known.0 == test,
    };
    (same && stronger) || (swapped && wanted.0 == Opcode::Ne && stronger)
}

/// `left != right`: the first multiple of the step that is the distance, modulo 2³².
fn until_equal(exit: &ExitTest, step: u32, guarded: bool, words: &mut Words<'_>) -> Word {
    let distance = exit.right.base.minus(&exit.left.base);
    let (distance, stride) = if (step as i32) < 0 {
        (Linear::default().minus(&distance), step.wrapping_neg())
    } else {
        (distance, step)
    };
    let shift = stride.trailing_zeros();
    let odd = stride >> shift;
    // From one step earlier the count comes out one larger; only where nothing is shifted out, or
    // where it is known not to be zero, does that survive the wrap.
    let early = guarded || shift == 0;
    let from = if early {
        distance.plus_constant(stride)
    } else {
        distance
    };
    let from = words.linear(&from);
    let mut count = words.op(Opcode::Shr, from, Word::Const(shift));
    if odd != 1 {
        count = words.op(Opcode::Mul, count, Word::Const(inverse(odd)));
        if shift > 0 {
            count = words.op(Opcode::And, count, Word::Const(u32::MAX >> shift));
        }
    }
    if early {
        count
    } else {
        words.op(Opcode::Add, count, Word::Const(1))
    }
}

/// The inverse of an odd number modulo 2³², by Newton's iteration.
fn inverse(odd: u32) -> u32 {
    // Right in the lowest 3 bits; each step doubles them.
    (0..4).fold(odd, |x, _| {
        x.wrapping_mul(2u32.wrapping_sub(odd.wrapping_mul(x)))
    })
}

/// An ordered test whose sides move towards each other by `step`.
fn until_past(exit: &ExitTest, step: u32, guarded: bool, words: &mut Words<'_>) -> Word {
    let distance = exit.right.base.minus(&exit.left.base);
    let strict = matches!(exit.test, Opcode::Lt | Opcode::Ltu);
    if guarded {
        let distance = distance.plus_constant(step);
        return if strict {
            ceil_div(words, &distance, step)
        } else {
            let whole = words.linear(&distance);
            let steps = floor_div(words, whole, step);
            words.op(Opcode::Add, steps, Word::Const(1))
        };
    }
    if strict && step == 1 {
        // One more than the distance, if there is any.
        let max = match exit.test {
            Opcode::Lt => Opcode::Max,
            _ => Opcode::Maxu,
        };
        let (left, right) = (
            words.linear(&exit.left.base),
            words.linear(&exit.right.base),
        );
        let end = words.op(max, right, left);
        return words.sum(end, &Linear::constant(1).minus(&exit.left.base));
    }
    let again = words.test(exit.test, &exit.left.base, &exit.right.base);
    let steps = if strict {
        ceil_div(words, &distance, step)
    } else {
        let whole = words.linear(&distance);
        let steps = floor_div(words, whole, step);
        words.op(Opcode::Add, steps, Word::Const(1))
    };
    let trip = words.op(Opcode::Add, steps, Word::Const(1));
    words.select(again, trip, Word::Const(1))
}

/// `x < n` unsigned while `x` counts down by one: ends when it has passed zero.
fn down_past_zero(exit: &ExitTest, guarded: bool, words: &mut Words<'_>) -> Word {
    let trip = words.linear(&exit.left.base.plus_constant(2));
    if guarded {
        return trip;
    }
    let again = words.test(Opcode::Ltu, &exit.left.base, &exit.right.base);
    words.select(again, trip, Word::Const(1))
}

fn floor_div(words: &mut Words<'_>, word: Word, divisor: u32) -> Word {
    if divisor.is_power_of_two() {
        words.op(Opcode::Shr, word, Word::Const(divisor.trailing_zeros()))
    } else {
        words.op(Opcode::Divu, word, Word::Const(divisor))
    }
}

/// `⌈distance / divisor⌉` of a distance that is not zero.
fn ceil_div(words: &mut Words<'_>, distance: &Linear, divisor: u32) -> Word {
    if divisor.is_power_of_two() {
        // Wraps only where the variable would, too.
        let up = words.linear(&distance.plus_constant(divisor - 1));
        floor_div(words, up, divisor)
    } else {
        let less = words.linear(&distance.plus_constant(u32::MAX));
        let steps = floor_div(words, less, divisor);
        words.op(Opcode::Add, steps, Word::Const(1))
    }
}
