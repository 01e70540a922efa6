//! Loop collapsing: a loop and the one inside it as one loop.
//!
//! Where both run a constant number of times, the kernel runs as often as both together. It begins
//! where the inner loop does; what stands around that one in the outer loop is done, under the test of
//! the inner loop, on the way to the next iteration. Values that cross blocks go through stack slots,
//! which [`mem2reg`](super::super::mem2reg) makes values again.

use super::estimate::{Callees, Work};
use crate::flow::{Dominators, Flow, Loop, LoopData};
use crate::pass::alias::Scopes;
use crate::pass::duplicate::copy;
use crate::pass::slots::{Uses, demote, load, slot_for, store};
use crate::pass::trip::trip;
use crate::program::*;
use rustc_hash::FxHashSet;
use srp_archdesc::arch::Precision;
use srp_archdesc::isa::{Effect, Opcode, Ty};

/// Iterations of the loops.
const MAX_INNER: u32 = 64;
const MAX_OUTER: u32 = 4096;

/// Operations around the inner loop: they take part in every iteration.
const MAX_AROUND: u32 = 48;

/// Cycles until the first iteration of a launch is done.
const FILLING: u32 = 20;

/// Cycles from one iteration to the next that the tests of both loops and what they select take.
const TESTS: u32 = 5;

/// Cycles from a load to the load that reads what was stored then. Of the two loops as one nothing tells how many iterations
/// those are apart.
const THROUGH_MEMORY: u32 = 7;

/// Operations of both: that of a loop that is soon scheduled.
const MAX_SIZE: u32 = 200;

/// Collapses a marked loop and the only one inside it, where that can be done and gains.
pub(super) fn collapse(
    func: &mut Function,
    flow: &Flow,
    id: Loop,
    callees: &Callees,
    precision: &Precision,
) -> bool {
    let Flow {
        dominators, loops, ..
    } = flow;
    let outer = &loops.loops[id];
    let mut inside = loops.inside(id);
    let (Some((inner_id, inner)), None) = (inside.next(), inside.next()) else {
        return false;
    };
    let mark = func.blocks[inner.header].kernel.as_ref();
    // What a pragma says of the iterations of one loop says nothing of those of both.
    let says = |mark: &KernelMark| !mark.independence.is_none();
    if !loops.is_innermost(inner_id) || mark.is_none_or(|m| m.required || says(m)) {
        return false;
    }
    let Some(nest) = Nest::of(func, dominators, outer, inner) else {
        return false;
    };
    let often = trip(func, dominators, inner, MAX_INNER, precision);
    let rounds = trip(func, dominators, outer, MAX_OUTER, precision);
    let (Some(often), Some(rounds)) = (often, rounds) else {
        return false;
    };
    if often.test != inner.latches[0] || rounds.test != outer.latches[0] || rounds.count < 2 {
        return false;
    }
    let (mut own, mut around) = (Work::default(), Work::default());
    for &block in &outer.blocks {
        let work = match inner.contains(block) {
            true => &mut own,
            false => &mut around,
        };
        if work.add(func, block, 1, callees).is_none() {
            return false;
        }
    }
    if around.size() > MAX_AROUND || around.size() + own.size() > MAX_SIZE {
        return false;
    }
    // A launch fills and drains the array; an iteration of both waits for the tests of the one before.
    let apart = FILLING + own.launched(often.count);
    own.and(&around);
    let waits = THROUGH_MEMORY * through_memory(func, outer);
    if often.count * own.interval().max(TESTS).max(waits) >= apart {
        return false;
    }
    nest.collapse(func, often.count * rounds.count);
    true
}

/// Stores of a loop to what it also loads from, as far as is known.
fn through_memory(func: &Function, data: &LoopData) -> u32 {
    let mut scopes = Scopes::default();
    let objects = scopes.of_block(func, data.header);
    let (mut loads, mut stores) = (Vec::new(), Vec::new());
    for &inst in data.blocks.iter().flat_map(|&b| &func.blocks[b].insts) {
        let InstKind::Op { op, args, .. } = &func.insts[inst].kind else {
            continue;
        };
        match op.info().effect {
            Effect::Load => loads.push(args[1]),
            Effect::Store => stores.push(args[1]),
            _ => {}
        }
    }
    let is_loaded = |&&to: &&Value| loads.iter().any(|&from| !objects.are_apart(from, to));
    stores.iter().filter(is_loaded).count() as u32
}

/// Two loops, one in the other, that are entered and left at one place each.
struct Nest<'a> {
    outer: &'a LoopData,
    inner: &'a LoopData,
    /// The blocks of the outer loop before the inner one.
    before: Vec<Block>,
}

impl<'a> Nest<'a> {
    fn of(
        func: &Function,
        dominators: &Dominators,
        outer: &'a LoopData,
        inner: &'a LoopData,
    ) -> Option<Nest<'a>> {
        let ([latch], [inner_latch]) = (&outer.latches[..], &inner.latches[..]) else {
            return None;
        };
        // Every round of the outer loop runs the inner one, and both end at their latches.
        if !dominators.dominates(inner.header, *latch) || inner.header == outer.header {
            return None;
        }
        let early = |data: &LoopData, latch: Block| data.exits(func).any(|(from, _)| from != latch);
        if early(outer, *latch) || early(inner, *inner_latch) {
            return None;
        }
        let after = |b: Block| dominators.dominates(inner.header, b);
        let mut before = outer.blocks.clone();
        before.retain(|&b| !inner.contains(b) && !after(b));
        before.contains(&outer.header).then_some(Nest {
            outer,
            inner,
            before,
        })
    }

    /// Makes both one loop that runs so often.
    fn collapse(&self, func: &mut Function, count: u32) {
        let (mark, pos) = self.take_marks(func);
        self.keep_in_slots(func);
        let again = self.copy_prologue(func);
        let counter = self.add_counter(func, count, pos);
        self.enter_counted(func, &again, &counter);
        let (back, out) = self.back_and_out(func);
        let head = go_on_to(func, &back, self.outer.header, again.head);
        let leave = self.leave_counted(func, &counter, &out, head, pos);
        self.begin_counting(func, &counter, pos);
        func.blocks[self.inner.header].kernel = mark;
        func.layout.extend(again.blocks);
        func.layout.extend([counter.latch, leave, counter.exit]);
    }

    /// Takes the marks of both off. Returns that of the one loop, and the position of the outer one.
    fn take_marks(&self, func: &mut Function) -> (Option<KernelMark>, Pos) {
        let mut mark = func.blocks[self.inner.header].kernel.take();
        let outer = func.blocks[self.outer.header].kernel.take();
        if let (Some(mark), Some(outer)) = (&mut mark, &outer) {
            // What holds of pointers holds for as long as the outer loop runs.
            mark.restrict.clone_from(&outer.restrict);
        }
        (mark, outer.map_or(Pos::nowhere(), |outer| outer.pos))
    }

    /// Lets no block of the outer loop use a value of another.
    fn keep_in_slots(&self, func: &mut Function) {
        let headers = [self.outer.header, self.inner.header];
        let others = self.outer.blocks.iter().filter(|b| !headers.contains(b));
        for &block in headers.iter().chain(others) {
            params_to_slots(func, block);
        }
        demote(func, &self.outer.blocks, Uses::Elsewhere);
    }

    /// Copies what comes before the inner loop: the way to the next round.
    fn copy_prologue(&self, func: &mut Function) -> Prologue {
        let mut old = self.before.clone();
        // Blocks that were put on jumps between those before the inner loop, and into it.
        for &block in &func.layout {
            let on_edge = !self.outer.contains(block);
            let from = |b: &Block| func.blocks[*b].end.targets().any(|t| t.block == block);
            if on_edge && self.before.iter().any(from) {
                old.push(block);
            }
        }
        let (blocks, _) = copy(func, &old);
        for &block in &blocks {
            func.blocks[block].kernel = None;
        }
        let head = old.iter().position(|&b| b == self.outer.header);
        let head = blocks[head.expect("the header is before the inner loop")];
        Prologue { old, blocks, head }
    }

    /// Makes the latch of the one loop, which counts its iterations.
    fn add_counter(&self, func: &mut Function, count: u32, pos: Pos) -> Counter {
        let slot = slot_for(func, Ty::Word);
        let [latch, exit] = [(); 2].map(|()| new_block(func, pos));
        let one = func.append_const(latch, Bits::Word(1), pos);
        let (insts, counted) = load(func, slot, Ty::Word, pos);
        func.blocks[latch].insts.extend(insts);
        let next = func.append_op(latch, Opcode::Add, &[counted, one], 0, pos);
        let next = next.expect("sums have a result");
        let insts = store(func, slot, next, pos);
        func.blocks[latch].insts.extend(insts);
        let all = func.append_const(latch, Bits::Word(count), pos);
        let more = func.append_op(latch, Opcode::Ne, &[next, all], 0, pos);
        func.blocks[latch].end = Terminator::Branch {
            cond: more.expect("comparisons have a result"),
            then: Target::to(self.inner.header),
            other: Target::to(exit),
        };
        Counter { slot, latch, exit }
    }

    /// Lets jumps to the inner loop go to the latch, but for those from what first comes before it.
    fn enter_counted(&self, func: &mut Function, again: &Prologue, counter: &Counter) {
        let first: FxHashSet<Block> = again.old.iter().copied().collect();
        for &block in func.layout.iter().chain(&again.blocks) {
            if !first.contains(&block) {
                let end = &mut func.blocks[block].end;
                end.retarget(self.inner.header, counter.latch);
            }
        }
    }

    /// Where the latch of the outer loop goes back, and where it leaves.
    fn back_and_out(&self, func: &Function) -> (Target, Target) {
        let header = self.outer.header;
        let end = &func.blocks[self.outer.latches[0]].end;
        let Terminator::Branch { then, other, .. } = end.clone() else {
            unreachable!("the outer loop is left at its latch")
        };
        match then.block == header || func.blocks[then.block].end.is_jump_to(header) {
            true => (then, other),
            false => (other, then),
        }
    }

    /// Lets the latch of the outer loop go back to a block, and out to a new one before the latch of the one
    /// loop, from where the loop is left for the place that `out` names. What `out` brings there waits in slots.
    fn leave_counted(
        &self,
        func: &mut Function,
        counter: &Counter,
        out: &Target,
        back: Block,
        pos: Pos,
    ) -> Block {
        let leave = new_block(func, pos);
        let mut kept = Vec::new();
        for &arg in &out.args {
            let ty = func.values[arg];
            let slot = slot_for(func, ty);
            let insts = store(func, slot, arg, pos);
            func.blocks[leave].insts.extend(insts);
            kept.push((slot, ty));
        }
        func.blocks[leave].end = Terminator::Jump(Target::to(counter.latch));
        for target in func.blocks[self.outer.latches[0]].end.targets_mut() {
            match target == out {
                true => *target = Target::to(leave),
                false => *target = Target::to(back),
            }
        }
        let mut args = Vec::new();
        for (slot, ty) in kept {
            let (insts, value) = load(func, slot, ty, pos);
            func.blocks[counter.exit].insts.extend(insts);
            args.push(value);
        }
        func.blocks[counter.exit].end = Terminator::Jump(Target {
            block: out.block,
            args,
        });
        leave
    }

    /// Begins the count where the outer loop begins.
    fn begin_counting(&self, func: &mut Function, counter: &Counter, pos: Pos) {
        let zero = func.make_inst(InstKind::Const(Bits::Word(0)), &[Ty::Word], pos);
        let value = func.insts[zero].results[0];
        let mut insts = store(func, counter.slot, value, pos);
        insts.insert(0, zero);
        func.blocks[self.outer.header].insts.splice(0..0, insts);
    }
}

/// The blocks before the inner loop, once more.
struct Prologue {
    /// The blocks that were copied.
    old: Vec<Block>,
    /// Their copies, which the layout does not have yet.
    blocks: Vec<Block>,
    /// The copy of the outer header.
    head: Block,
}

/// The latch of the one loop.
struct Counter {
    /// Its count of iterations.
    slot: Slot,
    latch: Block,
    /// Where it goes in the end.
    exit: Block,
}

/// A block that the layout does not have yet.
fn new_block(func: &mut Function, pos: Pos) -> Block {
    let block = func.blocks.push(BlockData::unreachable());
    func.blocks[block].end_pos = pos;
    block
}

/// Lets a way back to a header lead to another block. Returns where it begins then.
fn go_on_to(func: &mut Function, back: &Target, header: Block, head: Block) -> Block {
    if back.block == header {
        return head;
    }
    // A block on the jump, which stores what it brings.
    for target in func.blocks[back.block].end.targets_mut() {
        target.block = head;
    }
    back.block
}

/// Lets the parameters of a block come through slots: a block on each jump to it stores them.
fn params_to_slots(func: &mut Function, block: Block) {
    let params = std::mem::take(&mut func.blocks[block].params);
    if params.is_empty() {
        return;
    }
    let pos = func.blocks[block].end_pos;
    let mut slots = Vec::new();
    let mut loads = Vec::new();
    for &param in &params {
        let ty = func.values[param];
        let slot = slot_for(func, ty);
        let (insts, _) = load(func, slot, ty, pos);
        // The last instruction defines the parameter now.
        let last = *insts.last().expect("a load has instructions");
        func.insts[last].results = vec![param];
        loads.extend(insts);
        slots.push(slot);
    }
    func.blocks[block].insts.splice(0..0, loads);
    for from in func.layout.clone() {
        let ways = func.blocks[from].end.targets().count();
        for way in 0..ways {
            let target = func.blocks[from].end.targets().nth(way).cloned();
            let Some(target) = target.filter(|t| t.block == block) else {
                continue;
            };
            let on_way = func.add_block();
            func.blocks[on_way].end_pos = pos;
            for (&slot, &arg) in slots.iter().zip(&target.args) {
                let insts = store(func, slot, arg, pos);
                func.blocks[on_way].insts.extend(insts);
            }
            func.blocks[on_way].end = Terminator::Jump(Target::to(block));
            if let Some(to) = func.blocks[from].end.targets_mut().nth(way) {
                *to = Target::to(on_way);
            }
        }
    }
}
