//! Pointers that a loop round a kernel exchanges, as those of a buffer that is read and of one that is written are: each
//! may point into either of two objects, but never both into one.

use super::linear::{Atom, Linear};
use super::places::Def;
use super::shape::Loop;
use crate::pass::restrict_number;
use crate::program::{Block, InstKind, KernelMark, Slot, Symbol, Value};
use srp_archdesc::isa::Opcode;

/// Pairs of parameters that are taken to be apart until one is found that is not.
const MAX_PAIRS: usize = 16;

/// Sums of a pointer and a constant that are looked through, one in another.
const MAX_SUMS: usize = 16;

/// The start of a pointer.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Start {
    Symbol(Symbol),
    Slot(Slot),
    /// The `restrict` pointer of this number, in its scope.
    Restrict(u32),
    /// The pointers that jumps to a block bring, as the parameter in this place.
    Param(Block, usize),
}

/// True if two addresses start from pointers that never point into one object while the kernel runs.
pub(super) fn are_apart(lp: &Loop<'_>, mark: &KernelMark, one: &Linear, other: &Linear) -> bool {
    let pointers = |sum: &Linear, not: &Linear| -> Vec<Value> {
        let alone = sum
            .terms
            .iter()
            .filter(|(atom, _)| !not.terms.contains_key(atom));
        let values = alone.filter_map(|(atom, times)| match atom {
            // What the kernel itself exchanges is another pointer in each iteration.
            Atom::Value(value) if *times == 1 && !lp.is_inside(*value) => Some(*value),
            _ => None,
        });
        values.collect()
    };
    let others = pointers(other, one);
    pointers(one, other).iter().any(|&one| {
        let is_param = |value: &Value| matches!(lp.def(*value), Some(Def::Param(..)));
        let mut others = others
            .iter()
            .filter(|other| is_param(&one) && is_param(other));
        others.any(|&other| pair_is_apart(lp, mark, one, other))
    })
}

/// True if two parameters never point into one object at a time: the greatest solution, in which pairs are apart
/// unless a jump brings two pointers that are not.
fn pair_is_apart(lp: &Loop<'_>, mark: &KernelMark, one: Value, other: Value) -> bool {
    let (Some(a), Some(b)) = (start(lp, mark, one), start(lp, mark, other)) else {
        return false;
    };
    let mut pairs = vec![(a, b)];
    let mut looked_at = 0;
    while let Some(&pair) = pairs.get(looked_at) {
        looked_at += 1;
        match pair {
            (Start::Param(block, a), Start::Param(same, b)) if block == same && a != b => {
                for (_, target) in lp.jumps_to(block) {
                    let starts = [a, b].map(|place| start(lp, mark, target.args[place]));
                    let [Some(a), Some(b)] = starts else {
                        return false;
                    };
                    if !pairs.contains(&(a, b)) && !pairs.contains(&(b, a)) {
                        pairs.push((a, b));
                    }
                }
            }
            (Start::Param(..), _) | (_, Start::Param(..)) => return false,
            (Start::Restrict(_), Start::Restrict(_)) if pair.0 != pair.1 => {}
            (Start::Restrict(_), _) | (_, Start::Restrict(_)) => return false,
            (a, b) if a == b => return false,
            _ => {}
        }
        if pairs.len() > MAX_PAIRS {
            return false;
        }
    }
    true
}

/// The start of a pointer that is it and a constant.
fn start(lp: &Loop<'_>, mark: &KernelMark, mut value: Value) -> Option<Start> {
    for _ in 0..MAX_SUMS {
        if let Some(Def::Param(block, place)) = lp.def(value) {
            return (!lp.is_entry(block)).then_some(Start::Param(block, place));
        }
        let kind = &lp.inst(value)?.kind;
        value = match kind {
            InstKind::SymbolAddr(symbol, _) => return Some(Start::Symbol(*symbol)),
            InstKind::SlotAddr(slot, _) => return Some(Start::Slot(*slot)),
            InstKind::Op {
                op: Opcode::Mov,
                args,
                ..
            } => match restrict_number(kind).filter(|number| mark.restrict.contains(number)) {
                Some(number) => return Some(Start::Restrict(number)),
                None => args[0],
            },
            InstKind::Op {
                op: Opcode::Add,
                args,
                ..
            } if lp.constant(args[1]).is_some() => args[0],
            _ => return None,
        };
    }
    None
}
