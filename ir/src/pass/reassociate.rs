//! Re-association of floating-point sums and products, for those who ask: `a + b + c + d` becomes
//! `(a + b) + (c + d)`, and what a loop carries is taken last, so that a recurrence through many
//! additions becomes one through a single one. Results differ in their rounding, so no other pass
//! does this.

use super::Remark;
use super::fast_math::uses;
use crate::program::*;
use rustc_hash::{FxHashMap, FxHashSet};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Opcode;

/// The operations that are taken to be associative: each is commutative as it stands.
const ASSOCIATIVE: [Opcode; 4] = [Opcode::Fadd, Opcode::Fmul, Opcode::Vfadd, Opcode::Vfmul];

/// How long a value takes: what the loop carries last of all, then by the operations before it.
type Rank = (bool, u32);

/// The name of this pass in remarks.
pub(super) const REASSOCIATE: &str = "associative-math";

/// Balances the trees of associative operations within each block.
pub(crate) fn reassociate(func: &mut Function, remarks: &mut Vec<Remark>) -> bool {
    let uses = uses(func);
    let before = remarks.len();
    for block in func.layout.clone() {
        balance_block(func, block, &uses, remarks);
    }
    remarks.len() > before
}

/// The operation of an associative instruction, with its operands.
fn associative(func: &Function, inst: Inst) -> Option<(Opcode, [Value; 2])> {
    match &func.insts[inst].kind {
        InstKind::Op { op, args, .. } if ASSOCIATIVE.contains(op) => {
            Some((*op, [args[0], args[1]]))
        }
        _ => None,
    }
}

fn balance_block(
    func: &mut Function,
    block: Block,
    uses: &EntityMap<Value, u32>,
    remarks: &mut Vec<Remark>,
) {
    let made_by: FxHashMap<Value, Inst> = (func.blocks[block].insts.iter())
        .flat_map(|&inst| func.insts[inst].results.iter().map(move |&v| (v, inst)))
        .collect();
    let inner = |func: &Function, value: Value, op: Opcode| {
        let inst = *made_by.get(&value).filter(|_| uses[value] == 1)?;
        (associative(func, inst)?.0 == op).then_some(inst)
    };
    // Inner instructions belong to the tree of the one that uses them.
    let mut within = FxHashSet::default();
    for &inst in &func.blocks[block].insts {
        if let Some((op, args)) = associative(func, inst) {
            within.extend(args.iter().filter_map(|&arg| inner(func, arg, op)));
        }
    }
    for root in func.blocks[block].insts.clone() {
        let Some((op, args)) = associative(func, root).filter(|_| !within.contains(&root)) else {
            continue;
        };
        let (mut leaves, mut tree) = (Vec::new(), Vec::new());
        let mut open = vec![args[1], args[0]];
        while let Some(value) = open.pop() {
            match inner(func, value, op) {
                Some(inst) => {
                    let (_, args) = associative(func, inst).expect("inner instructions are");
                    tree.push(inst);
                    open.extend([args[1], args[0]]);
                }
                None => leaves.push(value),
            }
        }
        if leaves.len() > 2 && rebuild(func, block, root, tree, leaves) {
            remarks.push(Remark {
                pos: func.insts[root].pos,
                pass: REASSOCIATE,
                message: "the sum or product is taken in another order".to_owned(),
            });
        }
    }
}

/// Combines the leaves of a tree, always the two that are there first; whether that is new.
fn rebuild(
    func: &mut Function,
    block: Block,
    root: Inst,
    mut tree: Vec<Inst>,
    leaves: Vec<Value>,
) -> bool {
    let ranks = ranks(func, block);
    let result = func.insts[root].results[0];
    let carried = carried(func, block, result);
    let rank = |&value: &Value| {
        let depth = ranks.get(&value).copied().unwrap_or(0);
        (carried.contains(&value), depth)
    };
    let mut open: Vec<(Rank, Value)> = leaves.iter().map(|v| (rank(v), *v)).collect();
    // Of equals the first comes first: the sort is stable.
    open.sort_by_key(|&(rank, _)| std::cmp::Reverse(rank));
    open.reverse();
    tree.sort_unstable();
    let mut order = Vec::new();
    let mut changed = false;
    while let [(a_rank, a), (b_rank, b), ..] = open[..] {
        open.drain(..2);
        let inst = match open.is_empty() {
            true => root,
            false => tree
                .pop()
                .expect("a tree has a leaf more than instructions"),
        };
        if let InstKind::Op { args, .. } = &mut func.insts[inst].kind {
            changed |= args[..] != [a, b];
            *args = vec![a, b];
        }
        order.push(inst);
        let (carried, depth) = a_rank.max(b_rank);
        let made = ((carried, depth + 1), func.insts[inst].results[0]);
        let place = open.partition_point(|&(rank, _)| rank <= made.0);
        open.insert(place, made);
    }
    let insts = &mut func.blocks[block].insts;
    insts.retain(|inst| *inst == root || !order.contains(inst));
    let place = insts.iter().position(|&inst| inst == root);
    let place = place.expect("the root stays");
    insts.splice(place..=place, order);
    changed
}

/// Operations before each value of a block, in a row.
fn ranks(func: &Function, block: Block) -> FxHashMap<Value, u32> {
    let mut ranks = FxHashMap::default();
    for &inst in &func.blocks[block].insts {
        let mut depth = 0;
        let data = &func.insts[inst];
        data.kind
            .for_each_use(|v| depth = depth.max(ranks.get(&v).copied().unwrap_or(0)));
        ranks.extend(data.results.iter().map(|&v| (v, depth + 1)));
    }
    ranks
}

/// The parameters of a block that is a loop which take a value on its way round.
fn carried(func: &Function, block: Block, value: Value) -> Vec<Value> {
    let data = &func.blocks[block];
    let back = data.end.targets().filter(|target| target.block == block);
    back.flat_map(|target| target.args.iter().zip(&data.params))
        .filter(|(arg, _)| **arg == value)
        .map(|(_, param)| *param)
        .collect()
}
