//! The first pass over a frame that is to be sampled: its tiles in runs of each core, and what is known of every run.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use srp_archdesc::Arch;

use srp_runtime::system::{QueuedTile, TileQueue, WarmCaches, frame_blocks, z_order};

use super::dispatch::{CoreModel, Costs, Dispatch, jobs};
use super::trace::{TileTrace, TileTracer, TracedFrame};
use crate::survey::Population;

/// Tiles of a unit, at least: few, so that there are many, and enough for those around them to be few.
const LEAST_TILES: u32 = 8;

/// Units of a frame, at most: each has caches to be remembered.
const MOST_UNITS: u32 = 4096;

/// Strata, at most, and units of each, at least.
const STRATA: usize = 24;
const UNITS_A_STRATUM: usize = 12;

/// Tiles that are traced before their reads are followed through the caches.
const CHUNK: usize = 256;

/// A run of tiles that one core takes one after the other.
#[derive(Clone, Debug)]
struct Unit {
    core: usize,
    /// Those that are measured, in the core's tiles, and all that are run.
    measured: Range<usize>,
    run: Range<usize>,
    /// Contents of the core's caches before the first that is run.
    caches: Arc<WarmCaches>,
}

/// The result of the first pass: the units of a frame, and the population to sample from.
#[derive(Clone, Debug)]
pub struct FirstPass {
    /// Tiles of each core, in their order.
    tiles: Vec<Vec<u32>>,
    units: Vec<Unit>,
    sizes: Vec<f64>,
    population: Population,
}

impl FirstPass {
    /// Traces a frame for a machine, on so many threads of the host, which change nothing of the result.
    pub fn of(frame: &TracedFrame<'_>, arch: &Arch, threads: usize) -> FirstPass {
        let spec = &arch.system;
        let blocks = frame_blocks(frame.image, spec);
        let order = blocks.concat();
        let cores = spec.cores.max(1) as usize;
        let length = LEAST_TILES.max((order.len() as u32).div_ceil(MOST_UNITS)) as usize;
        let cores = (0..cores).map(|_| CoreModel::new(spec, frame)).collect();
        let length = length.max(jobs(spec) + 1);
        let queue = TileQueue::of_blocks(blocks);
        let mut dispatch = Dispatch::new(cores, length, Costs::of(spec), queue);
        trace_all(frame, &order, threads, &mut |tile, trace| {
            dispatch.tell(tile, trace)
        });
        dispatch.finish();
        FirstPass::from(dispatch, frame.image.across)
    }

    fn from(dispatch: Dispatch, across: u32) -> FirstPass {
        let Dispatch {
            cores,
            length,
            costs,
            ..
        } = dispatch;
        let mut units = Vec::new();
        let mut tiles = Vec::new();
        for (core, model) in cores.into_iter().enumerate() {
            for (i, (counts, (from, caches))) in model.counts.iter().zip(&model.starts).enumerate()
            {
                let measured = i * length..((i + 1) * length).min(model.tiles.len());
                let first = model.tiles[measured.start];
                let curve = z_order(first % across, first / across);
                let unit = Unit {
                    core,
                    run: *from..model.end(measured.end),
                    measured,
                    caches: Arc::clone(caches),
                };
                units.push((curve, unit, *counts));
            }
            tiles.push(model.tiles);
        }
        // Neighbours in the picture are alike.
        units.sort_by_key(|&(curve, ..)| curve);
        let sizes: Vec<f64> = units.iter().map(|(.., c)| c.size(&costs)).collect();
        let strata = STRATA.min(units.len().div_ceil(UNITS_A_STRATUM));
        let auxiliaries = units.iter().zip(&sizes);
        let auxiliaries = auxiliaries.map(|((.., c), &size)| c.auxiliaries(size));
        FirstPass {
            population: Population::of(sizes.clone(), auxiliaries.collect(), strata),
            units: units.into_iter().map(|(_, unit, _)| unit).collect(),
            sizes,
            tiles,
        }
    }

    /// Tiles of the frame.
    pub fn tiles(&self) -> usize {
        self.tiles.iter().map(Vec::len).sum()
    }

    pub(super) fn population(&self) -> &Population {
        &self.population
    }

    /// About the cycles of a unit.
    pub(super) fn size(&self, unit: u32) -> f64 {
        self.sizes[unit as usize]
    }

    /// About the part of the frame's cycles that it takes to run a unit, with the tiles around it.
    pub(super) fn cost(&self, unit: u32) -> f64 {
        let Unit { measured, run, .. } = &self.units[unit as usize];
        let around = run.len() as f64 / measured.len().max(1) as f64;
        self.size(unit) * around / self.sizes.iter().sum::<f64>()
    }

    /// The tiles of a unit.
    pub(super) fn measured(&self, unit: u32) -> &[u32] {
        let unit = &self.units[unit as usize];
        &self.tiles[unit.core][unit.measured.clone()]
    }

    /// Returns the tiles that a core runs for a unit: those that lead to it, its own, and those behind it
    /// that are in hand together with its last.
    pub(super) fn queue(&self, unit: u32) -> impl Iterator<Item = QueuedTile> {
        let unit = &self.units[unit as usize];
        let tiles = &self.tiles[unit.core];
        tiles[unit.run.clone()]
            .iter()
            .enumerate()
            .map(|(i, &tile)| QueuedTile {
                tile,
                caches: (i == 0).then(|| Arc::clone(&unit.caches)),
            })
    }
}

/// Traces tiles, and tells their traces in this order. While one thread tells a chunk, others trace the next.
fn trace_all(
    frame: &TracedFrame<'_>,
    order: &[u32],
    threads: usize,
    tell: &mut dyn FnMut(u32, TileTrace),
) {
    let mut tracers = vec![TileTracer::new(frame); threads.max(1)];
    let mut ready: Vec<(usize, TileTrace)> = Vec::new();
    for start in (0..order.len()).step_by(CHUNK) {
        let next = AtomicUsize::new(start);
        let end = (start + CHUNK).min(order.len());
        let trace_on = |tracer: &mut TileTracer<'_>| {
            let mut traces = Vec::new();
            loop {
                let place = next.fetch_add(1, Ordering::Relaxed);
                if place >= end {
                    return traces;
                }
                traces.push((place, tracer.tile(order[place])));
            }
        };
        let (own, others) = tracers.split_at_mut(1);
        ready = std::thread::scope(|scope| {
            let work = |tracer| scope.spawn(|| trace_on(tracer));
            let others: Vec<_> = others.iter_mut().map(work).collect();
            ready
                .drain(..)
                .for_each(|(place, trace)| tell(order[place], trace));
            let mut found = trace_on(&mut own[0]);
            for other in others {
                match other.join() {
                    Ok(more) => found.extend(more),
                    Err(panic) => std::panic::resume_unwind(panic),
                }
            }
            found
        });
        ready.sort_unstable_by_key(|r| r.0);
    }
    ready
        .drain(..)
        .for_each(|(place, trace)| tell(order[place], trace));
}
