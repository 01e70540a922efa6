//! Chains of integer operations as trees: `a & (b & (c & d))` becomes `((a & b) & c) & d` where `d` comes
//! last, so that one operation is left to do then. Hyperblocks nest their predicates the other way, and what
//! a loop carries through several operations may often be taken last of all.

use super::ready::ready;
use crate::program::*;
use rustc_hash::{FxHashMap, FxHashSet};
use srp_archdesc::isa::Opcode;

/// The operations, all associative and commutative.
const ASSOCIATIVE: [Opcode; 6] = [
    Opcode::Add,
    Opcode::Pand,
    Opcode::Por,
    Opcode::And,
    Opcode::Or,
    Opcode::Xor,
];

/// Operands of a tree.
const MAX_LEAVES: usize = 16;

/// Takes the operands of associative operations in the order in which they come, where that shortens
/// the way to the result.
pub(crate) fn balance(func: &mut Function) -> bool {
    let mut constants = FxHashSet::default();
    for &inst in func.layout.iter().flat_map(|&b| &func.blocks[b].insts) {
        if let InstKind::Const(_) | InstKind::SymbolAddr(..) = func.insts[inst].kind {
            constants.extend(func.insts[inst].results.iter().copied());
        }
    }
    let mut changed = false;
    for block in func.layout.clone() {
        changed |= balance_block(func, block, &constants);
    }
    changed
}

fn associative(func: &Function, inst: Inst) -> Option<(Opcode, [Value; 2])> {
    match &func.insts[inst].kind {
        InstKind::Op { op, args, .. } if ASSOCIATIVE.contains(op) => {
            Some((*op, [args[0], args[1]]))
        }
        _ => None,
    }
}

fn balance_block(func: &mut Function, block: Block, constants: &FxHashSet<Value>) -> bool {
    let mut ready = ready(func, block);
    let mut made_by: FxHashMap<Value, Inst> = FxHashMap::default();
    let mut changed = false;
    for inst in std::mem::take(&mut func.blocks[block].insts) {
        if let Some((op, args)) = associative(func, inst) {
            let result = func.insts[inst].results[0];
            let at = |v: Value| ready.get(&v).copied().unwrap_or(0);
            // Operands may be there earlier than before.
            let before = at(args[0]).max(at(args[1])) + 1;
            ready.insert(result, before);
            let leaves = leaves(func, &made_by, op, args);
            // A constant at the end of a sum goes into the accesses that it is an address of.
            let fixed = op == Opcode::Add && leaves.iter().any(|v| constants.contains(v));
            let leaves = if fixed { Vec::new() } else { leaves };
            if let Some((order, stands)) = plan(&ready, &leaves).filter(|plan| plan.1 < before) {
                let pos = func.insts[inst].pos;
                rebuild(func, block, (op, pos), (inst, order), &mut ready);
                ready.insert(result, stands);
                changed = true;
            }
        }
        let results = func.insts[inst].results.iter();
        made_by.extend(results.map(|&v| (v, inst)));
        func.blocks[block].insts.push(inst);
    }
    changed
}

/// The operands of a tree whose root has these.
fn leaves(
    func: &Function,
    made_by: &FxHashMap<Value, Inst>,
    op: Opcode,
    args: [Value; 2],
) -> Vec<Value> {
    let (mut leaves, mut seen) = (Vec::new(), FxHashSet::default());
    let mut open = vec![args[1], args[0]];
    while let Some(value) = open.pop() {
        // Logic takes an operand that comes twice once.
        if !matches!(op, Opcode::Add | Opcode::Xor) && !seen.insert(value) {
            continue;
        }
        let inner = made_by
            .get(&value)
            .and_then(|&inst| associative(func, inst));
        match inner.filter(|(inner, _)| *inner == op) {
            Some((_, args)) if leaves.len() + open.len() + 2 <= MAX_LEAVES => {
                open.extend([args[1], args[0]]);
            }
            _ => leaves.push(value),
        }
    }
    leaves
}

/// Operands by the cycle in which they stand: always the first two make one. Gives the steps, of operands
/// and results numbered through, and when the last result stands; `None` for less than three operands.
fn plan(ready: &FxHashMap<Value, u32>, leaves: &[Value]) -> Option<(Plan, u32)> {
    if leaves.len() < 3 {
        return None;
    }
    let at = |v: &Value| ready.get(v).copied().unwrap_or(0);
    let mut open: Vec<(u32, usize)> = leaves.iter().map(at).zip(0..).collect();
    open.sort_unstable();
    let (mut steps, mut stands) = (Vec::new(), 0);
    while let [(_, a), (later, b), ..] = open[..] {
        open.drain(..2);
        stands = later + 1;
        let made = (stands, leaves.len() + steps.len());
        steps.push([a, b]);
        let place = open.partition_point(|&other| other < made);
        open.insert(place, made);
    }
    let plan = Plan {
        leaves: leaves.to_vec(),
        steps,
    };
    Some((plan, stands))
}

struct Plan {
    leaves: Vec<Value>,
    steps: Vec<[usize; 2]>,
}

/// Appends the steps of a plan but the last, which the root becomes.
fn rebuild(
    func: &mut Function,
    block: Block,
    (op, pos): (Opcode, Pos),
    (root, plan): (Inst, Plan),
    ready: &mut FxHashMap<Value, u32>,
) {
    let mut values = plan.leaves;
    for (at, [a, b]) in plan.steps.iter().enumerate() {
        let args = [values[*a], values[*b]];
        if at + 1 == plan.steps.len() {
            if let InstKind::Op { args: own, .. } = &mut func.insts[root].kind {
                *own = args.to_vec();
            }
            return;
        }
        let stands = args.map(|v| ready.get(&v).copied().unwrap_or(0));
        let value = func.append_op(block, op, &args, 0, pos);
        let value = value.expect("the operation has a result");
        ready.insert(value, stands[0].max(stands[1]) + 1);
        values.push(value);
    }
}
