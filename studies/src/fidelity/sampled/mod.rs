//! A frame from a sample of its tiles.
//!
//! A [first pass](first_pass) traces all rays without time, dispatches the tiles to cores as the frame would,
//! and follows the contents of the caches. A unit of the sample is a run of tiles that one core takes one
//! after the other. It is run cycle by cycle, on all units of the machine, from the caches as the first pass
//! leaves them, with tiles before and behind it that are not measured; other cores run other units meanwhile.
//! Its counters come from the [`ledger`](super::ledger); strata, and regression on the counts of the first
//! pass, turn them into figures of the frame, with intervals ([`crate::survey`]). Units are drawn until the
//! cycles are known well enough; where that would be most of the frame, all of it is run.
//!
//! SMARTS (Wunderlich et al., ISCA 2003) measures few runs of a long program, from warm caches, and tells how
//! far they can be trusted; Zatel (ISPASS 2024) does it with parts of a picture.

mod dispatch;
mod figures;
mod first_pass;
mod trace;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use srp_archdesc::Arch;
use srp_archdesc::watch::{Stage, Unstaged, Watch};

use super::figures::{FrameFigure, known, read_ns};
use super::ledger::{Part, Tally, add, render_tiles};
use crate::survey::{LEAST_DRAWS, draws_needed};
use srp_runtime::core::Core;
use srp_runtime::effect::Guard;
use srp_runtime::scene_image::SceneImage;
use srp_runtime::system::{CodeSizes, Options, QueuedTile, SystemError, TileQueue, Timing};
use srp_toolchain::cache::{Key, Kind};
use srp_toolchain::envelope::Contents;
use srp_toolchain::{Error, Session};

pub use first_pass::FirstPass;
pub use trace::TracedFrame;

/// Units of a batch for each core: with so many a core is seldom without work before the others are.
const UNITS_A_CORE: usize = 8;

/// Samples that take more than this part of the frame are not worth it, nor are those of fewer units.
const MOST: f64 = 0.5;
const LEAST_UNITS: usize = 32;

/// A frame that is to be sampled.
pub struct Frame<'a> {
    /// System memory at its start.
    pub image: &'a SceneImage,
    /// The first pass over it.
    pub first_pass: &'a FirstPass,
    /// The cores at their start, as often as they are asked for.
    pub engines: &'a (dyn Fn() -> Vec<Box<dyn Core>> + Sync),
    /// The machine.
    pub arch: &'a Arch,
    /// The program's data.
    pub sram_image: &'a [u8],
    /// The guard against effects that the program was not built for.
    pub guard: Guard,
    /// True if T&I units answer at once.
    pub recorded_hits: bool,
    /// Names of the kernels.
    pub kernel_names: &'a [String],
    /// Sizes of the program's code.
    pub code: &'a CodeSizes,
    /// Most SRP cycles of a batch.
    pub max_cycles: u64,
    /// Threads of the host; they change no figure.
    pub threads: usize,
    /// Who watches the work, tile by tile, and who shares it.
    pub session: &'a Session<'a>,
    /// Names the frame by all that its batches depend on; empty where nobody shares the work.
    pub name: &'a str,
}

/// Counters of a batch of units.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Batch {
    /// Units of the population.
    units: Vec<u32>,
    /// Counters of each unit.
    tallies: Vec<Tally>,
    /// Counters of all cores before their first tiles and after their last.
    around: Tally,
    /// Cycles of all reads from memory, over their number, in ns.
    read_ns: f64,
}

/// A frame, estimated.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Sampled {
    /// Tiles of the frame.
    pub tiles: usize,
    /// Tiles measured.
    pub measured: usize,
    /// Strata; none where the frame was run as a whole.
    pub strata: usize,
    /// The seed.
    pub seed: u64,
    /// The figures, with 95 % intervals; the first is the cycles of the frame.
    pub figures: Vec<FrameFigure>,
}

impl Contents for Sampled {
    const FORMAT: &'static str = "srp-frame-sample";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp render --fidelity sampled`, by --json and --report";
}

impl Frame<'_> {
    /// Tiles that batches measure.
    fn tiles_of(&self, batches: &[&[u32]]) -> u64 {
        let units = batches.iter().flat_map(|batch| batch.iter());
        units
            .map(|&u| self.first_pass.measured(u).len() as u64)
            .sum()
    }

    fn options<'a>(&'a self, watch: &'a dyn Watch) -> Options<'a> {
        Options {
            max_cycles: self.max_cycles,
            guard: self.guard.clone(),
            timing: match self.recorded_hits {
                true => Timing::RecordedHits,
                false => Timing::Full,
            },
            kernel_names: self.kernel_names.to_vec(),
            code: self.code.clone(),
            watch,
            ..Options::new(self.sram_image)
        }
    }

    /// Runs batches, several at a time, each by one of the processes that share the work. `None` where it was cancelled.
    fn run(&self, batches: &[&[u32]]) -> Result<Option<Vec<Batch>>, Error> {
        let stage = Stage::of(self.session.watch, "sampling", self.tiles_of(batches));
        let key = |i: usize| {
            let key = Key::of(Kind::Frames).text("batch").text(self.name);
            Ok(key.value(&batches[i]).finish())
        };
        let image = || self.image.clone();
        let run = |image: &mut SceneImage, i: usize| {
            let batch = self.run_batch(image, batches[i])?;
            stage.done(self.tiles_of(&batches[i..=i]));
            // A batch that was cut off is none.
            self.session.check().map(|()| batch)
        };
        let batches = (self.session).pieces(self.threads, batches.len(), key, image, run);
        match batches {
            Err(Error::Cancelled) => Ok(None),
            batches => batches,
        }
    }

    /// Runs some units, each on the core that has the least to do so far.
    fn run_batch(&self, image: &mut SceneImage, units: &[u32]) -> Result<Batch, SystemError> {
        let cores = self.arch.system.cores as usize;
        let mut queues: Vec<Vec<QueuedTile>> = vec![Vec::new(); cores];
        let mut load = vec![0.0; cores];
        let mut run_on: Vec<(u32, usize)> = Vec::new();
        let mut by_size = units.to_vec();
        by_size.sort_by(|&a, &b| self.first_pass.size(b).total_cmp(&self.first_pass.size(a)));
        for unit in by_size {
            let core = (0..cores).fold(0, |best, c| if load[c] < load[best] { c } else { best });
            load[core] += self.first_pass.size(unit);
            run_on.push((unit, core));
            queues[core].extend(self.first_pass.queue(unit));
        }
        let quiet = Unstaged::new(self.session.watch);
        let options = Options {
            tiles: Some(TileQueue::of_cores(queues)),
            ..self.options(&quiet)
        };
        let part = render_tiles(image, (self.engines)(), self.arch, options)?;
        // Places go core by core.
        run_on.sort_by_key(|&(_, core)| core);
        let mut tallies = part.tallies.iter();
        let mut batch = Batch {
            around: part.around,
            read_ns: read_ns(&part.report, self.arch),
            ..Batch::default()
        };
        for (unit, _) in run_on {
            let mut sum = Tally::new();
            for (queued, tally) in self.first_pass.queue(unit).zip(tallies.by_ref()) {
                if self.first_pass.measured(unit).contains(&queued.tile) {
                    add(&mut sum, tally);
                }
            }
            batch.units.push(unit);
            batch.tallies.push(sum);
        }
        Ok(batch)
    }

    /// Runs all of the frame.
    fn run_whole(&self) -> Result<Option<Part>, SystemError> {
        let mut image = self.image.clone();
        let options = self.options(self.session.watch);
        let part = render_tiles(&mut image, (self.engines)(), self.arch, options)?;
        Ok((!self.session.watch.cancelled()).then_some(part))
    }
}

/// Samples a frame until drawing leaves at most `error` of its cycles to half their interval, or runs it as a
/// whole where that is cheaper. `None` where it was cancelled.
///
/// # Errors
///
/// Those of [`system::run`](srp_runtime::system::run), or a batch cannot be kept for others.
pub fn sample(frame: &Frame<'_>, seed: u64, error: f64) -> Result<Option<Sampled>, Error> {
    let first = frame.first_pass;
    let population = first.population();
    let draws = population.batches(seed);
    let units_a_batch = UNITS_A_CORE * frame.arch.system.cores as usize;
    let mut done: Vec<Batch> = Vec::new();
    let (mut drawn, mut wanted) = (0, LEAST_DRAWS.min(draws.len()));
    loop {
        let cost: f64 = draws[..wanted]
            .iter()
            .flatten()
            .map(|&u| first.cost(u))
            .sum();
        if cost > MOST || population.len() < LEAST_UNITS {
            let Some(part) = frame.run_whole()? else {
                return Ok(None);
            };
            return Ok(Some(Sampled {
                tiles: first.tiles(),
                measured: first.tiles(),
                strata: 0,
                seed,
                figures: known(&part, frame.arch, frame.kernel_names),
            }));
        }
        let units = draws[drawn..wanted].concat();
        let batches: Vec<&[u32]> = units.chunks(units_a_batch).collect();
        let Some(more) = frame.run(&batches)? else {
            return Ok(None);
        };
        done.extend(more);
        drawn = wanted;
        let (figures, found) = figures::figures(population, &done, frame.arch, frame.kernel_names);
        if found <= error || drawn == draws.len() {
            let units = done.iter().flat_map(|b| &b.units);
            return Ok(Some(Sampled {
                tiles: first.tiles(),
                measured: units.map(|&u| first.measured(u).len()).sum(),
                strata: population.strata(),
                seed,
                figures,
            }));
        }
        wanted = draws_needed(drawn, found, error).min(draws.len());
    }
}
