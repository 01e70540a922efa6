//! Selections of nothing on recurrences.

use super::{Cycles, Trees};
use crate::pass::nearby::Facts;
use crate::program::*;
use srp_archdesc::isa::Opcode;

/// Makes of `y + (p ? x : 0)`, where a loop carries p and that is there after y, the selection `p ? y + x : y`: the sum
/// does not wait for p.
pub(super) fn take_in(func: &mut Function, block: Block) -> bool {
    let cycles = Cycles::of(func, block);
    if cycles.is_empty() {
        return false;
    }
    let (trees, facts) = (Trees::of(func, block), Facts::of(func));
    let mut changed = false;
    for inst in func.blocks[block].insts.clone() {
        let InstKind::Op { op, args, .. } = &func.insts[inst].kind else {
            continue;
        };
        let op = *op;
        if !matches!(op, Opcode::Add | Opcode::Sub | Opcode::Or | Opcode::Xor) {
            continue;
        }
        let chosen = |value: Value| match trees.inner(func, value)? {
            (_, Opcode::Sel, &[p, x, zero]) if facts.constants.get(&zero) == Some(&0) => {
                Some((p, x))
            }
            _ => None,
        };
        let (y, (p, x)) = match (chosen(args[0]), chosen(args[1])) {
            (_, Some(found)) => (args[0], found),
            (Some(found), None) if op != Opcode::Sub => (args[1], found),
            _ => continue,
        };
        let result = func.insts[inst].results[0];
        if !cycles.has(p, result) {
            continue;
        }
        let waits = cycles.waits(func, block, result);
        let wait = |v: Value, steps: u32| waits.get(&v).map(|wait| wait + steps);
        let before = wait(p, 2).max(wait(x, 2)).max(wait(y, 1));
        let after = wait(p, 1).max(wait(x, 2)).max(wait(y, 2));
        if after >= before {
            continue;
        }
        let pos = func.insts[inst].pos;
        let args = vec![y, x];
        let ty = func.values[result];
        let sum = func.make_inst(InstKind::Op { op, args, imm: 0 }, &[ty], pos);
        let args = vec![p, func.insts[sum].results[0], y];
        let op = Opcode::Sel;
        func.insts[inst].kind = InstKind::Op { op, args, imm: 0 };
        let insts = &mut func.blocks[block].insts;
        let place = insts.iter().position(|&i| i == inst).expect("it is there");
        insts.insert(place, sum);
        changed = true;
    }
    changed
}
