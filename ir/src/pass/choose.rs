//! Loads from one of two addresses as two loads and a selection of what they find: the loads then do not
//! wait for the choice.

use super::nearby::Facts;
use super::ready::ready;
use crate::program::*;
use rustc_hash::FxHashMap;
use srp_archdesc::isa::{Effect, Opcode};

/// Makes two of each load of a block whose address is chosen late. `is_safe` says of a load that it cannot
/// trap. Returns the loads that run in vain.
pub(super) fn choose_loads(
    func: &mut Function,
    block: Block,
    facts: &Facts,
    is_safe: impl Fn(Opcode, &[Value], i32) -> bool,
) -> Vec<Inst> {
    let ready = ready(func, block);
    let at = |v: Value| ready.get(&v).copied().unwrap_or(0);
    let mut choices: FxHashMap<Value, [Value; 3]> = FxHashMap::default();
    let mut made = Vec::new();
    for inst in std::mem::take(&mut func.blocks[block].insts) {
        let pos = func.insts[inst].pos;
        let result = func.insts[inst].results.first().copied();
        if let (InstKind::Op { op, args, imm }, Some(result)) = (&func.insts[inst].kind, result) {
            let (op, imm) = (*op, *imm);
            if op == Opcode::Sel {
                choices.insert(result, [args[0], args[1], args[2]]);
            } else if op.info().effect == Effect::Load
                && facts.truths.contains(&args[0])
                && let Some(&[cond, a, b]) = choices.get(&args[1])
                && at(cond) > at(a).max(at(b))
            {
                let both = [[args[0], a], [args[0], b]];
                if both.iter().all(|args| is_safe(op, args, imm)) {
                    let loaded = both.map(|args| {
                        let value = func.append_op(block, op, &args, imm, pos);
                        made.extend(func.blocks[block].insts.last());
                        value.expect("a load has a result")
                    });
                    func.insts[inst].kind = InstKind::Op {
                        op: Opcode::select(func.values[result]),
                        args: vec![cond, loaded[0], loaded[1]],
                        imm: 0,
                    };
                }
            }
        }
        func.blocks[block].insts.push(inst);
    }
    made
}
