//! Flattening: a loop and the one inside it as one loop.
//!
//! Where both run a constant number of times, the kernel runs as often as both together. It begins
//! where the inner loop does; what stands around that one in the outer loop is done, under the test of
//! the inner loop, on the way to the next iteration. Values that cross blocks go through stack slots,
//! which [`mem2reg`](super::super::mem2reg) makes values again.

use super::estimate::{Callees, Work};
use crate::flow::{Dominators, Flow, Loop, LoopData};
use crate::pass::duplicate::copy;
use crate::pass::slots::{Uses, demote, load, slot_for, store};
use crate::pass::trip::trip;
use crate::program::*;
use rustc_hash::FxHashSet;
use srp_archdesc::arch::Precision;
use srp_archdesc::isa::{Opcode, Ty};

/// Iterations of the loops.
const MAX_INNER: u32 = 64;
const MAX_OUTER: u32 = 4096;

/// Operations around the inner loop: they take part in every iteration.
const MAX_AROUND: u32 = 48;

/// Cycles until the first iteration of a launch is done.
const FILLING: u32 = 20;

/// Cycles from one iteration to the next that the tests of both loops and what they select take.
const TESTS: u32 = 5;

/// The slots of values that cross blocks.
const NAME: &str = "nest";

/// Operations of both: that of a loop that is soon scheduled.
const MAX_SIZE: u32 = 200;

/// Flattens a marked loop that has one loop inside it, where that can be done and gains.
pub(super) fn flatten(
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
    if often.count * own.interval().max(TESTS) >= apart {
        return false;
    }
    nest.flatten(func, often.count * rounds.count);
    true
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

    fn flatten(&self, func: &mut Function, count: u32) {
        let Nest { outer, inner, .. } = self;
        let mut mark = func.blocks[inner.header].kernel.take();
        let outer_mark = func.blocks[outer.header].kernel.take();
        if let (Some(mark), Some(outer)) = (&mut mark, &outer_mark) {
            // What holds of pointers holds for as long as the outer loop runs.
            mark.restrict.clone_from(&outer.restrict);
        }
        let pos = outer_mark.as_ref().map_or(Pos::nowhere(), |m| m.pos);
        let blocks = outer.blocks.clone();
        params_to_slots(func, outer.header);
        params_to_slots(func, inner.header);
        for &block in &blocks {
            if block != outer.header && block != inner.header {
                params_to_slots(func, block);
            }
        }
        demote(func, &blocks, Uses::Elsewhere, NAME);

        // The way to the next round: what comes before the inner loop, once more.
        let mut again_old = self.before.clone();
        let edges: Vec<Block> = func.layout.clone();
        // Blocks that were put on jumps between those before the inner loop, and into it.
        for &block in &edges {
            let on_edge = !blocks.contains(&block) && !again_old.contains(&block);
            let from = |b: &Block| func.blocks[*b].end.targets().any(|t| t.block == block);
            if on_edge && self.before.iter().any(from) {
                again_old.push(block);
            }
        }
        let (again, _) = copy(func, &again_old);
        for &block in &again {
            func.blocks[block].kernel = None;
        }
        let head = again_old.iter().position(|&b| b == outer.header);
        let head = again[head.expect("the header is before the inner loop")];

        let counter = slot_for(func, Ty::Word, "rounds");
        let [latch, exit] = [(); 2].map(|()| {
            let block = func.blocks.push(BlockData::unreachable());
            func.blocks[block].end_pos = pos;
            block
        });
        let one = func.append_const(latch, Bits::Word(1), pos);
        let (insts, counted) = load(func, counter, Ty::Word, pos);
        func.blocks[latch].insts.extend(insts);
        let next = func.append_op(latch, Opcode::Add, &[counted, one], 0, pos);
        let next = next.expect("sums have a result");
        let insts = store(func, counter, next, pos);
        func.blocks[latch].insts.extend(insts);
        let all = func.append_const(latch, Bits::Word(count), pos);
        let more = func.append_op(latch, Opcode::Ne, &[next, all], 0, pos);
        func.blocks[latch].end = Terminator::Branch {
            cond: more.expect("comparisons have a result"),
            then: Target::to(inner.header),
            other: Target::to(exit),
        };

        // Into the inner loop: from the first copy as before, from all else by the new latch.
        let stored: Vec<Block> = func.layout.iter().copied().chain(again.clone()).collect();
        let first: FxHashSet<Block> = again_old.iter().copied().collect();
        for &block in stored.iter().filter(|block| !first.contains(block)) {
            func.blocks[block].end.retarget(inner.header, latch);
        }
        // Back to the outer loop: to the copy of what comes before the inner one. Out of it: to the
        // new latch, which goes on to where it left.
        let end_of = outer.latches[0];
        let Terminator::Branch { then, other, .. } = func.blocks[end_of].end.clone() else {
            unreachable!("the outer loop is left at its latch")
        };
        let goes_back =
            then.block == outer.header || func.blocks[then.block].end.is_jump_to(outer.header);
        let (back, out) = match goes_back {
            true => (then, other),
            false => (other, then),
        };
        let mut entry_of_back = back.block;
        if entry_of_back == outer.header {
            entry_of_back = head;
        } else {
            // A block on the jump, which stores what it brings.
            for target in func.blocks[entry_of_back].end.targets_mut() {
                target.block = head;
            }
        }
        let leave = func.blocks.push(BlockData::unreachable());
        func.blocks[leave].end_pos = pos;
        let mut kept = Vec::new();
        for &arg in &out.args {
            let ty = func.values[arg];
            let slot = slot_for(func, ty, NAME);
            let insts = store(func, slot, arg, pos);
            func.blocks[leave].insts.extend(insts);
            kept.push((slot, ty));
        }
        func.blocks[leave].end = Terminator::Jump(Target::to(latch));
        for target in func.blocks[end_of].end.targets_mut() {
            match *target == out {
                true => *target = Target::to(leave),
                false => *target = Target::to(entry_of_back),
            }
        }
        let mut args = Vec::new();
        for (slot, ty) in kept {
            let (insts, value) = load(func, slot, ty, pos);
            func.blocks[exit].insts.extend(insts);
            args.push(value);
        }
        func.blocks[exit].end = Terminator::Jump(Target {
            block: out.block,
            args,
        });
        // The count begins where the outer loop does.
        let zero = func.make_inst(InstKind::Const(Bits::Word(0)), &[Ty::Word], pos);
        let value = func.insts[zero].results[0];
        let mut insts = store(func, counter, value, pos);
        insts.insert(0, zero);
        func.blocks[outer.header].insts.splice(0..0, insts);
        func.blocks[inner.header].kernel = mark;
        func.layout.extend(again);
        func.layout.extend([latch, leave, exit]);
    }
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
        let slot = slot_for(func, ty, NAME);
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
