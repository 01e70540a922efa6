//! Hyperblocks: several blocks of control code as one, under predicates (Mahlke et al. 1992).
//!
//! A branch of the VLIW engine costs its own cycle, those of its delay, and the results under way,
//! which must stand before its target begins; and operations of different blocks never share a bundle.
//! So a branch goes where doing both ways takes less:
//!
//! * The ways of a small diamond or triangle become straight code, and selections.
//! * A block that only one branch reaches joins that branch's block, if both are in one loop and the
//!   other way leaves that loop, or if both blocks branch to the same place (`&&`, `||`). One branch is
//!   left on the way that stays; the tests of the ways out follow outside the loop.
//!
//! Arithmetic runs whether it is wanted or not. Loads, stores and divisions get the predicate into
//! their guards. A load needs none where the joined block, or one that control has come through before,
//! accesses memory near by in any case ([`nearby`](super::nearby)).

use super::cfg::{Nests, simplify_cfg};
use super::choose::choose_loads;
use super::nearby::{Access, Facts};
use super::order::Stage;
use super::rename::Renames;
use crate::flow::Flow;
use crate::program::*;
use rustc_hash::FxHashSet;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Class, Effect, Opcode};

/// Operations of a way that is not always taken: about those that the slots do in the cycles of a
/// branch.
const MAX_SIDE: usize = 10;

/// Operations of a block that joins another on the way that stays in the loop.
const MAX_JOINED: usize = 48;

/// Operations of a whole hyperblock.
const MAX_BLOCK: usize = 200;

/// Blocks before one that are searched for accesses.
const MAX_BEFORE: usize = 8;

/// Rounds over a function, each of which may make the next possible.
const MAX_ROUNDS: u32 = 32;

/// Joins the blocks of a function where that takes less time.
pub(super) fn hyperblocks(func: &mut Function, stage: Stage) -> bool {
    let mut former = Former::of(func, stage);
    let mut changed = false;
    for _ in 0..MAX_ROUNDS {
        if !former.round() {
            break;
        }
        changed = true;
        simplify_cfg(former.func, Nests::Keep, &mut Vec::new());
    }
    former.choose() | changed
}

struct Former<'a> {
    func: &'a mut Function,
    stage: Stage,
    /// Loads that run without a guard although their block might not have been reached.
    speculated: FxHashSet<Inst>,
    /// Blocks that a change of this round has touched.
    touched: EntityMap<Block, bool>,
}

/// A function at the beginning of a round.
struct Before {
    flow: Flow,
    facts: Facts,
}

impl Before {
    fn of(func: &Function) -> Before {
        Before {
            flow: Flow::of(func),
            facts: Facts::of(func),
        }
    }
}

/// One way of a branch.
#[derive(Clone)]
struct Way {
    target: Target,
    /// The value of the condition on this way.
    sense: bool,
}

impl<'a> Former<'a> {
    fn of(func: &'a mut Function, stage: Stage) -> Former<'a> {
        Former {
            func,
            stage,
            speculated: FxHashSet::default(),
            touched: EntityMap::new(),
        }
    }

    /// Changes every block once at most, the last of the control flow first.
    fn round(&mut self) -> bool {
        let old = Before::of(self.func);
        self.touched = EntityMap::filled(self.func.blocks.len(), false);
        let mut renames = Renames::default();
        let mut changed = false;
        for &block in old.flow.cfg.order.iter().rev() {
            if !self.touched[block] {
                changed |=
                    self.diamond(block, &old, &mut renames) || self.join(block, &old, &mut renames);
            }
        }
        renames.apply(self.func);
        changed
    }

    /// Makes loads independent of the choice of their addresses.
    fn choose(&mut self) -> bool {
        let old = Before::of(self.func);
        let before = self.speculated.len();
        for &block in &old.flow.cfg.order {
            let certain = self.certain(block, &old);
            let is_safe = |op: Opcode, args: &[Value], imm| {
                let access = Access::of(op, args, imm, &old.facts);
                access.is_some_and(|a| certain.iter().any(|c| c.vouches_for(&a)))
            };
            let made = choose_loads(self.func, block, &old.facts, is_safe);
            self.speculated.extend(made);
        }
        self.speculated.len() > before
    }

    fn ways(&self, block: Block) -> Option<(Value, [Way; 2])> {
        let Terminator::Branch { cond, then, other } = &self.func.blocks[block].end else {
            return None;
        };
        let way = |target: &Target, sense| Way {
            target: target.clone(),
            sense,
        };
        Some((*cond, [way(then, true), way(other, false)]))
    }

    /// The size of a block, if all of it can move into another.
    fn movable(&self, block: Block) -> Option<usize> {
        size(self.func, block)
    }

    /// True if `block` can become part of its only predecessor.
    fn follows(&self, block: Block, from: Block, old: &Before) -> bool {
        block != from
            && block != self.func.entry()
            && !self.touched[block]
            && old.flow.cfg.preds[block] == [from]
            && self.func.blocks[block].kernel.is_none()
    }

    /// Makes straight code of a branch around one or two blocks that meet again.
    fn diamond(&mut self, block: Block, old: &Before, renames: &mut Renames) -> bool {
        let Some((cond, ways)) = self.ways(block) else {
            return false;
        };
        let side = |way: &Way| {
            let at = way.target.block;
            let Terminator::Jump(to) = &self.func.blocks[at].end else {
                return None;
            };
            let size = self.movable(at).filter(|_| self.follows(at, block, old))?;
            Some((size, to.block))
        };
        let found = [side(&ways[0]), side(&ways[1])];
        let [then, other] = [ways[0].target.block, ways[1].target.block];
        let (size, meets, moved) = match found {
            [Some((a, x)), Some((b, y))] if x == y => (a + b, x, vec![0, 1]),
            [Some((a, x)), _] if x == other => (a, x, vec![0]),
            [_, Some((b, y))] if y == then => (b, y, vec![1]),
            _ => return false,
        };
        if size > MAX_SIDE || moved.iter().any(|&i| ways[i].target.block == meets) {
            return false;
        }
        let mut guards = Guards::of(cond);
        let mut ends = [ways[0].target.clone(), ways[1].target.clone()];
        for at in moved {
            let from = ways[at].target.block;
            self.absorb(block, &ways[at], &mut guards, old, renames);
            let end = std::mem::replace(&mut self.func.blocks[from].end, Terminator::Unreachable);
            let Terminator::Jump(to) = end else {
                unreachable!("it was a jump a moment ago")
            };
            ends[at] = to;
        }
        self.touched[block] = true;
        let [then, other] = ends;
        self.func.blocks[block].end = Terminator::Branch { cond, then, other };
        true
    }

    /// Puts the block that a branch goes on to into the block of the branch.
    fn join(&mut self, block: Block, old: &Before, renames: &mut Renames) -> bool {
        let Some((cond, ways)) = self.ways(block) else {
            return false;
        };
        (0..2).any(|at| {
            let (on, off) = (&ways[at], &ways[1 - at]);
            self.join_one(block, cond, on, off, old, renames)
        })
    }

    fn join_one(
        &mut self,
        block: Block,
        cond: Value,
        on: &Way,
        off: &Way,
        old: &Before,
        renames: &mut Renames,
    ) -> bool {
        let next = on.target.block;
        let around = old.flow.loops.innermost(block);
        if !self.follows(next, block, old)
            || off.target.block == next
            || old.flow.loops.innermost(next) != around
        {
            return false;
        }
        let around = around.map(|id| &old.flow.loops.loops[id]);
        let leaves = |to: Block| around.is_some_and(|data| !data.contains(to));
        let Some(size) = self.movable(next) else {
            return false;
        };
        let cold = leaves(off.target.block);
        let fits = self.size(block) + size <= MAX_BLOCK && size <= MAX_JOINED;
        match self.func.blocks[next].end.clone() {
            Terminator::Jump(to) if cold && fits && !leaves(to.block) => {
                let mut guards = Guards::of(cond);
                self.absorb(block, on, &mut guards, old, renames);
                self.close(block, cond, on.sense, to, off.target.clone(), next);
                true
            }
            Terminator::Branch {
                cond: second,
                then,
                other,
            } => {
                let out = off.target.block;
                let (stay, go, sense) = if other.block == out || leaves(other.block) {
                    (then, other, true)
                } else if then.block == out || leaves(then.block) {
                    (other, then, false)
                } else {
                    return false;
                };
                let same = go.block == out;
                let worth = cold && !leaves(stay.block) || same && size <= MAX_SIDE / 2;
                if !worth || !fits || stay.block == go.block || stay.block == out {
                    return false;
                }
                let mut guards = Guards::of(cond);
                self.absorb(block, on, &mut guards, old, renames);
                let pos = self.func.blocks[next].end_pos;
                let first = guards.when(self.func, block, on.sense, pos);
                let second = renames.find(second);
                let last = match sense {
                    true => second,
                    false => self.op(block, Opcode::Pnot, &[second], pos),
                };
                let both = self.op(block, Opcode::Pand, &[first, last], pos);
                let away = match same {
                    true => self.either(block, first, &go, &off.target, pos, renames),
                    false => self.outside(first, go, off.target.clone(), pos),
                };
                self.close(block, both, true, stay, away, next);
                true
            }
            _ => false,
        }
    }

    fn size(&self, block: Block) -> usize {
        let insts = self.func.blocks[block].insts.iter();
        let ops = insts.filter(|&&i| matches!(self.func.insts[i].kind, InstKind::Op { .. }));
        ops.count()
    }

    /// Ends a block by a branch, where the block `gone` has become part of it.
    fn close(
        &mut self,
        block: Block,
        cond: Value,
        sense: bool,
        stay: Target,
        away: Target,
        gone: Block,
    ) {
        let (then, other) = if sense { (stay, away) } else { (away, stay) };
        self.func.blocks[block].end = Terminator::Branch { cond, then, other };
        self.func.blocks[gone].end = Terminator::Unreachable;
        self.touched[block] = true;
    }

    /// The way out that two branches share: the values of the second where the first went on.
    fn either(
        &mut self,
        block: Block,
        first: Value,
        second_out: &Target,
        first_out: &Target,
        pos: Pos,
        renames: &Renames,
    ) -> Target {
        let pairs = second_out.args.iter().zip(&first_out.args);
        let pairs: Vec<(Value, Value)> = pairs
            .map(|(&a, &b)| (renames.find(a), renames.find(b)))
            .collect();
        let args = pairs.into_iter().map(|(second, early)| {
            if second == early {
                return second;
            }
            let op = Opcode::select(self.func.values[second]);
            self.op(block, op, &[first, second, early], pos)
        });
        Target {
            block: second_out.block,
            args: args.collect(),
        }
    }

    /// A new block that goes one of two ways.
    fn outside(&mut self, cond: Value, then: Target, other: Target, pos: Pos) -> Target {
        let block = self.func.add_block();
        self.touched.push(true);
        self.func.blocks[block].end = Terminator::Branch { cond, then, other };
        self.func.blocks[block].end_pos = pos;
        Target {
            block,
            args: Vec::new(),
        }
    }

    /// The accesses of SRAM that have been made, as their guards say, when a block ends.
    fn certain(&self, block: Block, old: &Before) -> Vec<Access> {
        let facts = &old.facts;
        let access = |&inst: &Inst| match &self.func.insts[inst].kind {
            InstKind::Op { op, args, imm } if !self.speculated.contains(&inst) => {
                Access::of(*op, args, *imm, facts)
            }
            _ => None,
        };
        // Elsewhere a pass may run any number of times, and each run takes a part of what there is.
        let blocks = match self.stage {
            Stage::Control => MAX_BEFORE,
            Stage::Whole => 0,
        };
        let before = std::iter::successors(Some(block), |&b| old.flow.dominators.parent(b));
        let before = before.take(blocks);
        let insts = before.flat_map(|b| &self.func.blocks[b].insts);
        insts.filter_map(access).collect()
    }

    fn op(&mut self, block: Block, op: Opcode, args: &[Value], pos: Pos) -> Value {
        let value = self.func.append_op(block, op, args, 0, pos);
        value.expect("the operation has a result")
    }

    /// Moves the operations of the block that a way leads to into `into`, under its predicate.
    fn absorb(
        &mut self,
        into: Block,
        way: &Way,
        guards: &mut Guards,
        old: &Before,
        renames: &mut Renames,
    ) {
        let from = way.target.block;
        let facts = &old.facts;
        let certain = self.certain(into, old);
        let data = &mut self.func.blocks[from];
        let insts = std::mem::take(&mut data.insts);
        for (&param, &arg) in data.params.iter().zip(&way.target.args) {
            renames.replace(param, renames.find(arg));
        }
        self.touched[from] = true;
        for inst in insts {
            let data = &mut self.func.insts[inst];
            data.kind.for_each_use_mut(|v| *v = renames.find(*v));
            let pos = data.pos;
            if let InstKind::Op { op, args, imm } = &data.kind
                && op.is_guarded()
            {
                let own = args[0];
                let unguarded = facts.truths.contains(&own);
                let access = Access::of(*op, args, *imm, facts);
                let is_load = op.info().effect == Effect::Load;
                let is_safe = access.is_some_and(|a| certain.iter().any(|c| c.vouches_for(&a)));
                if is_load && is_safe {
                    self.speculated.insert(inst);
                } else {
                    let guard = guards.when(self.func, into, way.sense, pos);
                    let guard = match unguarded {
                        true => guard,
                        false => self.op(into, Opcode::Pand, &[guard, own], pos),
                    };
                    if let InstKind::Op { args, .. } = &mut self.func.insts[inst].kind {
                        args[0] = guard;
                    }
                }
            }
            self.func.blocks[into].insts.push(inst);
        }
    }
}

/// The operations of a block, those that take long counted for the cycles they take; `None` if one
/// cannot be predicated.
pub(super) fn size(func: &Function, block: Block) -> Option<usize> {
    let mut count = 0;
    for &inst in &func.blocks[block].insts {
        count += match &func.insts[inst].kind {
            InstKind::Const(_) | InstKind::SymbolAddr(..) | InstKind::SlotAddr(..) => 0,
            InstKind::Op { op, .. } if op.info().effect == Effect::Io => return None,
            InstKind::Op { op, .. } => match op.class() {
                Class::Idiv | Class::Fdiv | Class::Sfu | Class::Fast | Class::Tex => MAX_SIDE,
                _ => 1,
            },
            InstKind::Call { .. } | InstKind::Launch { .. } => return None,
        };
    }
    Some(count)
}

/// The predicates of the two ways of a branch, made once.
struct Guards {
    cond: Value,
    negated: Option<Value>,
}

impl Guards {
    fn of(cond: Value) -> Guards {
        Guards {
            cond,
            negated: None,
        }
    }

    /// The predicate that is true where the condition is `sense`.
    fn when(&mut self, func: &mut Function, block: Block, sense: bool, pos: Pos) -> Value {
        if sense {
            return self.cond;
        }
        *self.negated.get_or_insert_with(|| {
            let not = func.append_op(block, Opcode::Pnot, &[self.cond], 0, pos);
            not.expect("it has a result")
        })
    }
}
