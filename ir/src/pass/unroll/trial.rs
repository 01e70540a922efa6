//! Loops inside one written out in a copy of their function, and judged by what is left of them.

use super::estimate::{Callees, Work};
use super::{Around, write_out};
use crate::flow::{Flow, LoopData};
use crate::pass::constants::load_constants;
use crate::pass::ifconvert::ifconvert;
use crate::pass::licm::licm;
use crate::pass::trip::{Trip, trip};
use crate::program::*;
use rustc_hash::FxHashSet;
use srp_archdesc::isa::Ty;

/// Iterations that are written out at most.
const MAX_TRIP: u32 = 32;

/// Instructions of a loop while those inside it are written out.
const MAX_WRITTEN: usize = 1_500;

/// Operations that a loop may have when those inside it are written out, and where its branches do not become
/// predicates yet: beyond, it takes long to find a schedule.
const MAX_OPERATIONS: u32 = 230;
const MAX_CONDITIONAL: u32 = 110;

/// The function with all loops inside a marked one written out, if they run constant, small numbers of times and
/// that is estimated to gain.
pub(super) fn written_out(
    func: &Function,
    header: Block,
    around: &Around,
    simplify: &mut dyn FnMut(&mut Function),
) -> Option<Function> {
    let mut new = func.clone();
    // Cycles of the loops when each is launched.
    let mut apart = 0;
    loop {
        let flow = Flow::of(&new);
        let mut all = flow.loops.loops.values();
        let outer = all.find(|data| data.header == header)?;
        let inside: Vec<&LoopData> = flow
            .loops
            .loops
            .values()
            .filter(|data| data.header != header && outer.contains(data.header))
            .collect();
        if inside.is_empty() {
            break;
        }
        let required = |data: &&LoopData| {
            let mark = new.blocks[data.header].kernel.as_ref();
            mark.is_some_and(|mark| mark.required)
        };
        if inside.iter().any(required) {
            return None;
        }
        // Inner loops come last. One may run as often as a loop round it says: then that one goes first.
        let counted = inside.into_iter().rev().find_map(|data| {
            let trip = trip(&new, &flow.dominators, data, MAX_TRIP, &around.precision)?;
            Some((data, trip))
        });
        let (data, trip) = counted?;
        let size = |data: &LoopData| -> usize {
            data.blocks.iter().map(|&b| new.blocks[b].insts.len()).sum()
        };
        if size(outer) + (trip.count as usize - 1) * size(data) > MAX_WRITTEN {
            return None;
        }
        let innermost = !flow
            .loops
            .loops
            .values()
            .any(|other| other.header != data.header && data.contains(other.header));
        if innermost {
            apart += launched(&new, data, trip, &around.callees)?;
        }
        let data = data.clone();
        new.blocks[data.header].kernel = None;
        write_out(&mut new, &data, trip);
        simplify(&mut new);
        if let Some(fixed) = &around.fixed
            && load_constants(&mut new, around.globals, fixed)
        {
            simplify(&mut new);
        }
    }
    let work = work(&new, header, around, simplify)?;
    (work.interval() < apart).then_some(new)
}

/// Cycles of a loop that is launched.
fn launched(func: &Function, data: &LoopData, trip: Trip, callees: &Callees) -> Option<u32> {
    let mut one = Work::default();
    for &block in &data.blocks {
        one.add(func, block, 1, callees)?;
    }
    Some(one.launched(trip.count))
}

/// The work of an iteration of a loop, if it is not too much.
fn work(
    func: &Function,
    header: Block,
    around: &Around,
    simplify: &mut dyn FnMut(&mut Function),
) -> Option<Work> {
    let mut converted = func.clone();
    for &block in &func.layout {
        if block != header {
            converted.blocks[block].kernel = None;
        }
    }
    ifconvert(&mut converted, around.globals);
    simplify(&mut converted);
    licm(&mut converted, around.globals);
    let is_block = blocks(&converted, header)?.len() == 1;
    let mut waiting = live_ins(&converted, header)
        .into_iter()
        .zip(around.live_ins);
    if is_block && waiting.any(|(waiting, most)| waiting > most) {
        return None;
    }
    let (func, most) = match is_block {
        true => (&converted, MAX_OPERATIONS),
        false => (func, MAX_CONDITIONAL),
    };
    let mut work = Work::default();
    for block in blocks(func, header)? {
        work.add(func, block, 1, &around.callees)?;
    }
    (work.size() <= most).then_some(work)
}

/// Values of each type that wait for a loop that is one block: those made before it, and the first ones of what it carries.
fn live_ins(func: &Function, block: Block) -> [u32; Ty::ALL.len()] {
    let data = &func.blocks[block];
    let results = data.insts.iter().flat_map(|&i| &func.insts[i].results);
    let own: FxHashSet<Value> = data.params.iter().chain(results).copied().collect();
    let mut waiting: FxHashSet<Value> = data.params.iter().copied().collect();
    for &inst in &data.insts {
        func.insts[inst].kind.for_each_use(|value| {
            if !own.contains(&value) {
                waiting.insert(value);
            }
        });
    }
    // Constants and addresses are in the configuration.
    for inst in func.insts.values() {
        if let InstKind::Const(_) | InstKind::SymbolAddr(..) = inst.kind {
            waiting.remove(&inst.results[0]);
        }
    }
    let mut count = [0; Ty::ALL.len()];
    for value in waiting {
        count[func.values[value] as usize] += 1;
    }
    count
}

/// The blocks of the loop with a header.
fn blocks(func: &Function, header: Block) -> Option<Vec<Block>> {
    let flow = Flow::of(func);
    let mut all = flow.loops.loops.values();
    Some(all.find(|data| data.header == header)?.blocks.clone())
}
