//! Unrolling of short loops inside others.
//!
//! A launch of the array costs more than a few iterations bring back, and only an innermost loop can be
//! launched. Where all loops inside a marked one run a constant, small number of times, they are
//! written out, and the loop around them becomes the kernel, if that is estimated to take less time.

use super::duplicate::{copy, rename_outside};
use super::slots::{Uses, demote};
use super::trip::{Trip, trip};
use crate::flow::{Flow, Loop, LoopData};
use crate::program::*;
use rustc_hash::FxHashMap;
use srp_archdesc::arch::Precision;

mod collapse;
mod estimate;

use collapse::collapse;
use estimate::{Callees, Work};

/// Iterations that are written out at most.
const MAX_TRIP: u32 = 32;

/// Operations that a loop may have when those inside it are written out, and where they have branches,
/// which become predicates: beyond, it takes long to find a schedule.
const MAX_OPERATIONS: u32 = 230;
const MAX_CONDITIONAL: u32 = 110;

/// Unrolls the loops inside marked ones; whether there were any. A loop with a pragma of its own
/// stays, and so do all loops beside it.
pub(crate) fn unroll(program: &mut Program, precision: &Precision) -> bool {
    if !program.funcs.values().any(has_marks) {
        return false;
    }
    let callees = Callees::of(program);
    let mut changed = false;
    for func in program.funcs.values_mut() {
        while unroll_in_one(func, &callees, precision) {
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

/// Unrolls all loops inside one marked loop, if there is one whose loops can be.
fn unroll_in_one(func: &mut Function, callees: &Callees, precision: &Precision) -> bool {
    if !has_marks(func) {
        return false;
    }
    let flow = Flow::of(func);
    for (id, outer) in flow.loops.loops.iter() {
        if func.blocks[outer.header].kernel.is_none() {
            continue;
        }
        let unrolled = worth_unrolling(func, &flow, id, callees, precision);
        let Some(inner) = unrolled else {
            if collapse(func, &flow, id, callees, precision) {
                return true;
            }
            continue;
        };
        let named = inner.iter().find_map(|(data, _)| {
            let mark = func.blocks[data.header].kernel.take();
            mark.map(|mark| mark.name)
        });
        for (data, trip) in inner {
            func.blocks[data.header].kernel = None;
            write_out(func, data, trip);
        }
        let mark = func.blocks[outer.header].kernel.as_mut();
        let mark = mark.expect("only marked loops are looked at");
        if let (true, Some(name)) = (mark.nest, named) {
            mark.name = name;
        }
        mark.nest = false;
        return true;
    }
    false
}

/// The loops inside one, with how often they run, if all of them can be written out and that is
/// estimated to gain.
fn worth_unrolling<'a>(
    func: &Function,
    flow: &'a Flow,
    outer: Loop,
    callees: &Callees,
    precision: &Precision,
) -> Option<Vec<(&'a LoopData, Trip)>> {
    let loops = &flow.loops;
    let mut inner = Vec::new();
    for (id, data) in loops.inside(outer) {
        let required = func.blocks[data.header].kernel.as_ref();
        if !loops.is_innermost(id) || required.is_some_and(|mark| mark.required) {
            return None;
        }
        inner.push((
            data,
            trip(func, &flow.dominators, data, MAX_TRIP, precision)?,
        ));
    }
    if inner.is_empty() {
        return None;
    }
    let mut whole = Work::default();
    let mut apart = 0;
    for &block in &loops.loops[outer].blocks {
        let around = inner.iter().find(|(data, _)| data.contains(block));
        let times = around.map_or(1, |(_, trip)| trip.count);
        whole.add(func, block, times, callees)?;
    }
    for (data, trip) in &inner {
        let mut one = Work::default();
        for &block in &data.blocks {
            one.add(func, block, 1, callees)?;
        }
        apart += one.launched(trip.count);
    }
    let branches = |b: Block| matches!(func.blocks[b].end, Terminator::Branch { .. });
    let straight = inner.iter().all(|(data, trip)| {
        let mut others = data.blocks.iter().filter(|&&b| b != trip.test);
        others.all(|&b| !branches(b))
    });
    let most = if straight {
        MAX_OPERATIONS
    } else {
        MAX_CONDITIONAL
    };
    let fits = whole.size() <= most;
    (fits && whole.interval() < apart).then_some(inner)
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
