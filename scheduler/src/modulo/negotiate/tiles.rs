//! Units without a slot to spare for operations that hold them for several cycles.
//!
//! On such a unit the operations of an iteration tile the II: each begins where another ends. One that began in between
//! would take slots of two others, and nothing but moving all of them would mend that, so that a search by single moves stays
//! there. Where the tiles of one unit begin is free to choose, for a schedule all of whose operations are issued a cycle later is
//! one too. Those of several units depend on each other: they are drawn, and every second run goes without.

use crate::modulo::noise::noise;
use crate::modulo::problem::{Position, Problem};
use srp_archdesc::arch::{Fu, FuOp};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_ir::dfg::Node;
use std::collections::BTreeMap;

/// The fewest operations on a unit that tiles are worth while for: one alone may begin anywhere.
const FEWEST: u32 = 2;

/// Where operations begin on a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tiles {
    /// Cycles for which each operation holds the unit, a divisor of the II.
    interval: i32,
    /// The cycle in which one begins.
    first: i32,
}

impl Tiles {
    /// True of operations that are as long as the tiles.
    pub(super) fn suit(self, timing: &FuOp) -> bool {
        timing.interval as i32 == self.interval
    }

    /// True if an operation that is issued in a cycle takes one tile.
    pub(super) fn begin_in(self, time: i32) -> bool {
        (time - self.first) % self.interval == 0
    }
}

/// The tiles of each unit that has some, for a run with a seed.
pub(super) fn tiles(problem: &Problem<'_>, ii: u32, seed: u32) -> EntityMap<Fu, Option<Tiles>> {
    let mut tiles = EntityMap::filled(problem.srp.fus.len(), None);
    let mut count = 0;
    for (units, needed) in needed(problem) {
        let Needed {
            interval,
            operations,
        } = needed;
        let is_full = operations * interval == ii * units.len() as u32;
        if interval == 1 || !ii.is_multiple_of(interval) || ii / interval < FEWEST || !is_full {
            continue;
        }
        for &fu in units {
            let drawn = noise(u64::from(seed), fu.index() as u64, 0x7469) % interval;
            tiles[fu] = Some(Tiles {
                interval: interval as i32,
                first: if count == 0 { 0 } else { drawn as i32 },
            });
            count += 1;
        }
    }
    match count > 1 && seed % 2 == 1 {
        true => EntityMap::filled(problem.srp.fus.len(), None),
        false => tiles,
    }
}

/// The same as a schedule has them.
pub(super) fn of_schedule(
    problem: &Problem<'_>,
    ii: u32,
    at: &EntityMap<Node, Position>,
) -> EntityMap<Fu, Option<Tiles>> {
    let mut tiles = tiles(problem, ii, 0);
    let mut issued: EntityMap<Fu, Vec<i32>> = EntityMap::filled(problem.srp.fus.len(), Vec::new());
    for (node, &(fu, time)) in at.iter() {
        if tiles[fu].is_some_and(|tiles| tiles.suit(problem.timing(node, fu))) {
            issued[fu].push(time);
        }
    }
    for (fu, tiles) in tiles.iter_mut() {
        *tiles = tiles.and_then(|tiles| {
            let mut shifted = (0..tiles.interval).map(|first| Tiles { first, ..tiles });
            shifted.find(|tiles| issued[fu].iter().all(|&time| tiles.begin_in(time)))
        });
    }
    tiles
}

/// Operations that the same units run and no others.
#[derive(Clone, Copy)]
struct Needed {
    /// Cycles for which each holds its unit; 1 where they differ.
    interval: u32,
    operations: u32,
}

/// Operations by their units.
fn needed<'p>(problem: &'p Problem<'_>) -> BTreeMap<&'p [Fu], Needed> {
    let mut needed: BTreeMap<&[Fu], Needed> = BTreeMap::new();
    for node in problem.nodes() {
        let units = &problem.units[node][..];
        for &fu in units {
            let interval = problem.timing(node, fu).interval;
            let all = needed.entry(units).or_insert(Needed {
                interval,
                operations: 0,
            });
            if all.interval != interval {
                all.interval = 1;
            }
        }
        if let Some(all) = needed.get_mut(units) {
            all.operations += 1;
        }
    }
    needed
}
