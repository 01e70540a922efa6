//! Re-association: `a + b + c + d` becomes `(a + b) + (c + d)`, and what a loop carries is taken last, so that a
//! recurrence through many operations becomes one through a single one.
//!
//! Of floating-point sums and products for those who ask, since results differ in their rounding. Of integer
//! operations, which are exact, wherever it makes a recurrence shorter. Selections leave recurrences of both.

use super::cycle::{Cycles, latency};
use super::fast_math::uses;
use super::{Remark, dce};
use crate::program::*;
use rustc_hash::{FxHashMap, FxHashSet};
use srp_archdesc::arch::Precision;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Opcode;

mod distribute;
mod selected;
mod sums;

/// The floating-point operations that are taken to be associative: each is commutative as it stands.
const FLOATS: &[Opcode] = &[Opcode::Fadd, Opcode::Fmul, Opcode::Vfadd, Opcode::Vfmul];

/// The associative and commutative operations of integers but for [sums](sums), whose terms have signs.
const INTEGERS: &[Opcode] = &[
    Opcode::Mul,
    Opcode::And,
    Opcode::Or,
    Opcode::Xor,
    Opcode::Min,
    Opcode::Max,
];

/// How long a value takes: what the loop carries last of all, then by the cycles since it has been carried, or by the
/// operations before it.
type Rank = (bool, u32);

/// The name of this pass in remarks.
pub(super) const REASSOCIATE: &str = "associative-math";

/// Balances the trees of floating-point operations within each block.
pub(crate) fn reassociate(func: &mut Function, remarks: &mut Vec<Remark>) -> bool {
    let before = remarks.len();
    let remark = |pos| Remark {
        pos,
        pass: REASSOCIATE,
        message: "the sum or product is taken in another order".to_owned(),
    };
    for block in func.layout.clone() {
        remarks.extend(trees(func, block, FLOATS).into_iter().map(remark));
    }
    remarks.len() > before
}

/// Shortens the recurrences of operations in blocks that are loops, where results stay as they are.
/// `has_products`: the machine has units that multiply.
pub(crate) fn shorten_recurrences(
    func: &mut Function,
    precision: &Precision,
    has_products: bool,
) -> bool {
    let mut changed = false;
    for block in func.layout.clone() {
        if distribute::distribute(func, block, precision) | selected::take_in(func, block) {
            // What they leave unused is no use of a term.
            dce(func);
            changed = true;
        }
        changed |= sums::shorten(func, block, has_products);
        changed |= !trees(func, block, INTEGERS).is_empty();
    }
    changed
}

/// The operation of an associative instruction, with its operands.
fn associative(func: &Function, inst: Inst, of: &[Opcode]) -> Option<(Opcode, [Value; 2])> {
    match &func.insts[inst].kind {
        InstKind::Op { op, args, .. } if of.contains(op) => Some((*op, [args[0], args[1]])),
        _ => None,
    }
}

/// The trees of operations of a block.
struct Trees {
    uses: EntityMap<Value, u32>,
    /// The instruction of the block that makes each value.
    made_by: FxHashMap<Value, Inst>,
}

impl Trees {
    fn of(func: &Function, block: Block) -> Trees {
        let made = |&inst: &Inst| func.insts[inst].results.iter().map(move |&v| (v, inst));
        Trees {
            uses: uses(func),
            made_by: func.blocks[block].insts.iter().flat_map(made).collect(),
        }
    }

    /// The operation that makes a value in this block, if nothing else uses the value.
    fn inner<'f>(&self, func: &'f Function, value: Value) -> Option<(Inst, Opcode, &'f [Value])> {
        let inst = *self.made_by.get(&value).filter(|_| self.uses[value] == 1)?;
        match &func.insts[inst].kind {
            InstKind::Op { op, args, .. } => Some((inst, *op, args)),
            _ => None,
        }
    }
}

/// Takes the trees of some operations in another order, and says where. Trees of integers stay where no recurrence gets
/// shorter.
fn trees(func: &mut Function, block: Block, of: &[Opcode]) -> Vec<Pos> {
    let cycles = Cycles::of(func, block);
    let is_exact = of == INTEGERS;
    if is_exact && cycles.is_empty() {
        return Vec::new();
    }
    let trees = Trees::of(func, block);
    let inner = |func: &Function, value: Value, op: Opcode| {
        let made = trees.inner(func, value).filter(|made| made.1 == op);
        made.map(|(inst, ..)| inst)
    };
    // Inner instructions belong to the tree of the one that uses them.
    let mut within = FxHashSet::default();
    for &inst in &func.blocks[block].insts {
        if let Some((op, args)) = associative(func, inst, of) {
            within.extend(args.iter().filter_map(|&arg| inner(func, arg, op)));
        }
    }
    let mut changed = Vec::new();
    for root in func.blocks[block].insts.clone() {
        let Some((op, args)) = associative(func, root, of).filter(|_| !within.contains(&root))
        else {
            continue;
        };
        let result = func.insts[root].results[0];
        let (mut leaves, mut tree) = (Vec::new(), Vec::new());
        let waits = match is_exact {
            true => cycles.waits(func, block, result),
            false => FxHashMap::default(),
        };
        let wait = |value: Value| {
            let carried = cycles.has(value, result);
            carried.then(|| waits.get(&value).copied().unwrap_or(0))
        };
        // The cycles from what is carried to the result.
        let mut longest = None;
        let mut open = vec![(args[1], 1), (args[0], 1)];
        while let Some((value, depth)) = open.pop() {
            match inner(func, value, op) {
                Some(inst) => {
                    let (_, args) = associative(func, inst, of).expect("inner instructions are");
                    tree.push(inst);
                    open.extend([(args[1], depth + 1), (args[0], depth + 1)]);
                }
                None => {
                    leaves.push(value);
                    longest = longest.max(wait(value).map(|wait| wait + depth * latency(op)));
                }
            }
        }
        let is_worth_it = || {
            let waits = leaves.iter().map(|&leaf| wait(leaf)).collect();
            !is_exact || least_wait(waits, latency(op)) < longest
        };
        if leaves.len() > 2 && is_worth_it() {
            let ranks = ranks(func, block);
            let rank = |value: &Value| match wait(*value) {
                Some(wait) if is_exact => (true, wait),
                carried => (carried.is_some(), ranks.get(value).copied().unwrap_or(0)),
            };
            if rebuild(func, block, (root, tree), leaves, rank) {
                changed.push(func.insts[root].pos);
            }
        }
    }
    changed
}

/// The cycles to the result where the two operands that are there first are always combined; `None` stands
/// for what the loop does not carry.
fn least_wait(mut open: Vec<Option<u32>>, step: u32) -> Option<u32> {
    open.sort_unstable();
    while let [_, later, ..] = open[..] {
        open.drain(..2);
        let made = later.map(|later| later + step);
        let place = open.partition_point(|&other| other < made);
        open.insert(place, made);
    }
    open.pop().flatten()
}

/// Combines the leaves of a tree, always the two that are there first; whether that is new.
fn rebuild(
    func: &mut Function,
    block: Block,
    (root, mut tree): (Inst, Vec<Inst>),
    leaves: Vec<Value>,
    rank: impl Fn(&Value) -> Rank,
) -> bool {
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
