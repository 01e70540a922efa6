//! Unrolling of short loops inside others.
//!
//! A launch of the array costs more than a few iterations bring back, and only an innermost loop can be
//! launched. Where all loops inside a marked one run a constant, small number of times, they are
//! written out, and the loop around them becomes the kernel, if that is estimated to take less time.
//!
//! The copies of an iteration do not tell what they come to: counters become constants, and with them conditions,
//! addresses and what tables hold; what the copies have in common is computed once. So a loop is written
//! out in a [`trial`] first, and what is left there decides.

use super::constants::never_written;
use super::duplicate::{copy, rename_outside};
use super::slots::{Uses, demote};
use super::trip::Trip;
use crate::flow::{Flow, Loop, LoopData};
use crate::program::*;
use rustc_hash::{FxHashMap, FxHashSet};
use srp_archdesc::arch::Precision;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Ty;

mod collapse;
mod estimate;
mod trial;

use collapse::collapse;
use estimate::Callees;
use trial::written_out;

/// The program round the function that is unrolled, as far as that is asked about.
struct Around<'a> {
    globals: &'a EntityMap<Global, GlobalData>,
    /// The globals whose values never change, where the whole program is known.
    fixed: Option<EntityMap<Global, bool>>,
    callees: Callees,
    precision: Precision,
    /// Values of each type that can wait in registers for a loop.
    live_ins: [u32; Ty::ALL.len()],
}

/// Unrolls the loops inside marked ones; whether there were any. A loop with a pragma of its own
/// stays, and so do all loops beside it. `simplify` makes a function as simple as it gets.
pub(crate) fn unroll(
    program: &mut Program,
    precision: &Precision,
    live_ins: [u32; Ty::ALL.len()],
    simplify: &mut dyn FnMut(&mut Function),
) -> bool {
    if !program.funcs.values().any(has_marks) {
        return false;
    }
    let fixed = program.main.is_some().then(|| never_written(program));
    let callees = Callees::of(program);
    let Program { globals, funcs, .. } = program;
    let around = Around {
        globals,
        fixed,
        callees,
        precision: *precision,
        live_ins,
    };
    let mut changed = false;
    for func in funcs.values_mut() {
        let mut refused = FxHashSet::default();
        while unroll_in_one(func, &around, simplify, &mut refused) {
            changed = true;
        }
    }
    changed
}

fn has_marks(func: &Function) -> bool {
    func.layout.iter().any(|&b| func.blocks[b].kernel.is_some())
}

/// Forgets the marks of loops that count only without loops inside them and still have some.
pub(crate) fn unnest(func: &mut Function) -> bool {
    if !has_marks(func) {
        return false;
    }
    let loops = Flow::of(func).loops;
    let mut changed = false;
    for (id, data) in loops.loops.iter() {
        let mark = &mut func.blocks[data.header].kernel;
        if !loops.is_innermost(id) && mark.as_ref().is_some_and(|m| m.nest) {
            *mark = None;
            changed = true;
        }
    }
    changed
}

/// Unrolls all loops inside one marked loop, or makes one loop of the two, if there is a marked loop with which that can be done and
/// gains. `refused` has the headers of those for which that was tried since a loop in them has changed.
fn unroll_in_one(
    func: &mut Function,
    around: &Around,
    simplify: &mut dyn FnMut(&mut Function),
    refused: &mut FxHashSet<Block>,
) -> bool {
    if !has_marks(func) {
        return false;
    }
    let flow = Flow::of(func);
    let loops = &flow.loops;
    // Inner loops first: what becomes of them decides about those round them.
    let mut marked: Vec<(Loop, &LoopData)> = loops.loops.iter().collect();
    marked.retain(|(id, data)| {
        func.blocks[data.header].kernel.is_some()
            && !loops.is_innermost(*id)
            && !refused.contains(&data.header)
    });
    for (id, data) in marked.into_iter().rev() {
        let new = written_out(func, data.header, around, simplify);
        let changed = match new {
            Some(mut new) => {
                take_over_mark(func, &mut new, data);
                *func = new;
                true
            }
            None => collapse(func, &flow, id, &around.callees, &around.precision),
        };
        if changed {
            for round in loops.loops.values().filter(|l| l.contains(data.header)) {
                refused.remove(&round.header);
            }
            return true;
        }
        refused.insert(data.header);
    }
    false
}

/// Lets the mark of a loop stand for the loops that were written out in it.
fn take_over_mark(old: &Function, new: &mut Function, outer: &LoopData) {
    let mark = new.blocks[outer.header].kernel.as_mut();
    let mark = mark.expect("only marked loops are written out");
    if mark.nest {
        let mut inside = outer.blocks.iter().skip(1);
        let inner = inside.find_map(|&b| old.blocks[b].kernel.as_ref().filter(|m| !m.nest));
        if let Some(inner) = inner {
            mark.name.clone_from(&inner.name);
        }
    }
    mark.nest = false;
}

/// Writes a loop out: copies of its blocks follow each other, and the last goes where the loop ended.
pub(super) fn write_out(func: &mut Function, data: &LoopData, trip: Trip) {
    let latch = data.latches[0];
    if data.exits(func).any(|(from, _)| from != trip.test) {
        demote(func, &data.blocks, Uses::Outside);
    }
    let mut names: Vec<FxHashMap<Value, Value>> = vec![FxHashMap::default()];
    let mut copies = vec![data.blocks.clone()];
    for _ in 1..trip.count {
        let (blocks, map) = copy(func, &data.blocks);
        copies.push(blocks);
        names.push(map);
    }
    let at = |block: Block| data.blocks.iter().position(|&b| b == block);
    let header = at(data.header).expect("the header is in its loop");
    let tail = at(latch).expect("the latch is in its loop");
    let test = at(trip.test).expect("the test is in its loop");
    for number in 0..copies.len() {
        let (own, next) = (&copies[number], copies.get(number + 1));
        // In the copies, jumps back go to the copy's own header so far.
        if let Some(next) = next {
            let end = &mut func.blocks[own[tail]].end;
            end.retarget(own[header], next[header]);
        }
        let stays =
            |t: &Target| own.contains(&t.block) || next.is_some_and(|n| n[header] == t.block);
        let mut targets = func.blocks[own[test]].end.targets();
        let way = targets.find(|t| stays(t) == next.is_some()).cloned();
        drop(targets);
        let way = way.expect("a test goes on or ends the loop");
        func.blocks[own[test]].end = Terminator::Jump(way);
        if next.is_none() && test != tail {
            // Never reached.
            func.blocks[own[tail]].end = Terminator::Unreachable;
        }
    }
    // What is used after the loop is what the last copy made.
    let last = names.pop().expect("there is one copy at least");
    if copies.len() > 1 {
        let inside: Vec<Block> = copies.iter().flatten().copied().collect();
        rename_outside(func, &inside, &last);
    }
    let place = func.layout.iter().position(|&b| b == latch);
    let place = place.map_or(func.layout.len(), |p| p + 1);
    let added = copies.into_iter().skip(1).flatten();
    func.layout.splice(place..place, added);
}
