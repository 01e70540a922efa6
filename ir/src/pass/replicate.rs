//! Unrolling of loops that stay in control code.
//!
//! Copies of the body follow each other and keep their tests, so that the number of iterations may be
//! anything; [`hyperblocks`](super::hyperblock) makes one block of them. Where the number is known,
//! tests that never end the loop go.

use super::duplicate::{copy, rename_outside};
use super::hyperblock::size;
use super::slots::{Uses, demote};
use super::trip::{Trip, trip};
use super::unroll::write_out;
use crate::flow::{Flow, LoopData};
use crate::program::*;
use srp_archdesc::arch::Precision;

/// Iterations up to which a number is looked for.
const MAX_TRIP: u32 = 16_384;

/// Operations of a loop that is written out whole.
const MAX_WHOLE: usize = 192;

/// Operations of an unrolled loop.
const MAX_UNROLLED: usize = 72;

/// Operations of one whose tests go.
const MAX_UNTESTED_SIZE: usize = 128;

/// Copies of a body with their tests, and without: the first are done in vain where the loop ends
/// early.
const MAX_TESTED: usize = 4;
const MAX_UNTESTED: usize = 8;

/// Writes out the loops of control code that run a small, constant number of times.
pub(crate) fn write_out_loops(func: &mut Function, precision: &Precision) -> bool {
    let mut changed = false;
    while let Some((data, trip)) = short_loop(func, precision) {
        write_out(func, &data, trip);
        changed = true;
    }
    changed
}

/// A loop without loops inside it that is worth writing out.
fn short_loop(func: &Function, precision: &Precision) -> Option<(LoopData, Trip)> {
    let Flow {
        dominators, loops, ..
    } = Flow::of(func);
    let inner = loops
        .loops
        .iter()
        .filter(|(id, data)| loops.is_innermost(*id) && func.blocks[data.header].kernel.is_none());
    inner.into_iter().find_map(|(_, data)| {
        let sizes = data.blocks.iter().map(|&block| size(func, block));
        let whole = sizes.sum::<Option<usize>>()?.max(1);
        let most = (MAX_WHOLE / whole).min(32) as u32;
        let trip = trip(func, &dominators, data, most, precision)?;
        Some((data.clone(), trip))
    })
}

/// Unrolls the loops of control code that are one block.
pub(crate) fn replicate(func: &mut Function, precision: &Precision) -> bool {
    let Flow {
        dominators, loops, ..
    } = Flow::of(func);
    let mut changed = false;
    for data in loops.loops.values() {
        let [block] = data.blocks[..] else {
            continue;
        };
        let backs = func.blocks[block].end.targets();
        let once = backs.filter(|t| t.block == block).count() == 1;
        let Some(size) = size(func, block).filter(|_| once && block != func.entry()) else {
            continue;
        };
        if func.blocks[block].kernel.is_some() {
            continue;
        }
        let most = |operations: usize, copies: usize| (operations / size.max(1)).min(copies);
        let known = trip(func, &dominators, data, MAX_TRIP, precision);
        let divides = |copies: &usize| {
            let trip = known.map(|known| known.count as usize);
            trip.is_some_and(|trip| trip.is_multiple_of(*copies))
        };
        let untested = 2..=most(MAX_UNTESTED_SIZE, MAX_UNTESTED);
        let untested = untested.rev().find(divides);
        let copies = untested.unwrap_or(most(MAX_UNROLLED, MAX_TESTED));
        if copies > 1 {
            follow(func, block, copies, untested.is_none());
            changed = true;
        }
    }
    changed
}

/// Puts copies of a loop of one block behind it, the last of which goes back.
fn follow(func: &mut Function, block: Block, copies: usize, tested: bool) {
    if tested {
        demote(func, &[block], Uses::Outside);
    }
    let mut blocks = vec![block];
    let mut last = None;
    for _ in 1..copies {
        let (made, names) = copy(func, &[block]);
        blocks.extend(made);
        last = Some(names);
    }
    for (at, &own) in blocks.iter().enumerate() {
        let next = blocks.get(at + 1).copied().unwrap_or(block);
        let mut back = None;
        for target in func.blocks[own].end.targets_mut() {
            if target.block == own {
                target.block = next;
                back = Some(target.clone());
            }
        }
        if let (Some(back), false, true) = (back, tested, at + 1 < blocks.len()) {
            func.blocks[own].end = Terminator::Jump(back);
        }
    }
    if let (Some(last), false) = (last, tested) {
        rename_outside(func, &blocks, &last);
    }
    let place = func.layout.iter().position(|&b| b == block);
    let place = place.map_or(func.layout.len(), |p| p + 1);
    func.layout.splice(place..place, blocks.into_iter().skip(1));
}
