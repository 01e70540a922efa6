//! Counters of narrow types. C computes `i++` of a `short` as a word and narrows the sum again (C17 6.3.1.8, 6.5.16.1);
//! where the test that a loop goes on by keeps the sum within the type, nothing is lost, and the counter is one of words,
//! of which the number of iterations is known before the loop runs.

use super::defs::Defs;
use super::narrow::{Range, extended, range};
use crate::flow::{Flow, LoopData};
use crate::program::*;
use srp_archdesc::isa::Opcode;

/// Takes sums of counters for what they are narrowed to, where the test of the loop rules out that they differ.
pub(crate) fn widen_counters(func: &mut Function) -> bool {
    let flow = Flow::of(func);
    let defs = Defs::of(func);
    let mut wide = Vec::new();
    for data in flow.loops.loops.values() {
        let count = func.blocks[data.header].params.len();
        wide.extend((0..count).filter_map(|place| narrowed(func, &defs, data, place)));
    }
    for (narrow, sum) in &wide {
        let (op, args) = (Opcode::Mov, vec![*sum]);
        func.insts[*narrow].kind = InstKind::Op { op, args, imm: 0 };
    }
    !wide.is_empty()
}

/// The instruction that narrows the next value of a loop's parameter, and its operand, which is the same.
fn narrowed(func: &Function, defs: &Defs, data: &LoopData, place: usize) -> Option<(Inst, Value)> {
    let [latch] = data.latches[..] else {
        return None;
    };
    let Terminator::Branch { cond, then, other } = &func.blocks[latch].end else {
        return None;
    };
    let (back, stays) = match (then.block == data.header, other.block == data.header) {
        (true, false) => (then, true),
        (false, true) => (other, false),
        _ => return None,
    };
    let next = back.args[place];
    let (sum, narrow) = extended(func, defs, next)?;
    let ty = narrow.range();
    let param = func.blocks[data.header].params[place];
    let stride = match defs.op(func, sum)? {
        (Opcode::Add, &[a, b]) if a == param => defs.word(func, b)? as i32,
        (Opcode::Sub, &[a, b]) if a == param => (defs.word(func, b)? as i32).checked_neg()?,
        _ => return None,
    };
    let continues = bounded(func, defs, (*cond, stays), next, ty)?;
    let begins = begins(func, defs, data, place)?;
    let before = begins.with(continues);
    let after = Range {
        first: before.first + i64::from(stride),
        last: before.last + i64::from(stride),
    };
    let narrow = defs.inst(next)?;
    (before.within(ty) && after.within(ty)).then_some((narrow, sum))
}

/// The words that a value of a type may be where a test that is made of it has this outcome.
fn bounded(
    func: &Function,
    defs: &Defs,
    (cond, outcome): (Value, bool),
    value: Value,
    ty: Range,
) -> Option<Range> {
    let (op, args) = defs.op(func, cond)?;
    let &[left, right] = args else { return None };
    let is_left = left == value;
    if is_left == (right == value) {
        return None;
    }
    let other = range(func, defs, if is_left { right } else { left });
    // Of numbers that are not negative the order is the same, signed or not.
    let is_ordered = match op {
        Opcode::Lt | Opcode::Le => true,
        Opcode::Ltu | Opcode::Leu => ty.first >= 0 && other.first >= 0,
        Opcode::Ne | Opcode::Eq => {
            let differs = (op == Opcode::Ne) == outcome;
            let is_end = (other.first, other.last) == (ty.first, ty.first);
            let first = ty.first + 1;
            return (differs && is_end).then_some(Range { first, ..ty });
        }
        _ => return None,
    };
    if !is_ordered {
        return None;
    }
    // The value is below, or above, the other one; a test that fails says the opposite, with the other strictness.
    let is_strict = matches!(op, Opcode::Lt | Opcode::Ltu) == outcome;
    let step = i64::from(is_strict);
    Some(match is_left == outcome {
        true => Range {
            last: ty.last.min(other.last - step),
            ..ty
        },
        false => Range {
            first: ty.first.max(other.first + step),
            ..ty
        },
    })
}

/// The words that a parameter may be when the loop begins.
fn begins(func: &Function, defs: &Defs, data: &LoopData, place: usize) -> Option<Range> {
    let outside = func.layout.iter().filter(|&&from| !data.contains(from));
    let entries = outside.flat_map(|&from| func.blocks[from].end.targets());
    let entries = entries.filter(|target| target.block == data.header);
    let ranges = entries.map(|target| range(func, defs, target.args[place]));
    ranges.reduce(Range::with)
}
