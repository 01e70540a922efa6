//! T&I units on a sample of their rays.
//!
//! The population are the [blocks] of packets that units are dealt, of all views: where units share a memory, rounds of
//! those that they have at a time. They are in strata of neighbours in the order of the rays. Some of each stratum are
//! [traced](trace): their rays are followed without time. Some of those are [run] cycle by cycle, from caches that
//! rays before them have warmed, after packets that are not measured. Regression on the counts of the traces makes
//! figures of all rays of it, with intervals ([`crate::survey`]). More is traced, and more is run, until the cycles
//! are known well enough.
//!
//! docs/fidelity.md says what the intervals hold.

mod blocks;
mod growing;
mod run;
mod trace;

use srp_archdesc::system::SystemSpec;
use srp_archdesc::watch::{Stage, Watch};

use self::growing::Growing;
use self::trace::{HITS, INNER, LEAVES, RAYS, TESTS};
use super::run_counts::figures_of;
use super::{BLOCK, Memories, Options, Outcome, UnitFigure, UnitQuantity};
use crate::rays::Source;
use crate::survey::{LEAST_DRAWS, Sample};
use srp_runtime::memory::SystemMemory;
use srp_runtime::tni::Tree;

/// Spread of the rounds of a stratum before one has been traced, as a part of their mean.
const SPREAD: f64 = 0.25;

/// Where so great a part of all would be traced, all is.
const ALL: f64 = 0.4;

/// Blocks of a stratum that are traced for each that is run, at least.
const TRACED_A_DRAW: usize = 4;

/// Samples that take more than this part of running everything are not worth it.
const MOST: f64 = 0.5;

/// Samples of fewer rounds tell too little.
const LEAST_ROUNDS: usize = 48;

/// Costs of tracing a block, of warming caches for it, and of its neighbours' company, as parts of the cost
/// of running it.
const OF_TRACING: f64 = 0.1;
const OF_WARMING: f64 = 0.8;
const OF_COMPANY: f64 = 0.4;

/// More is drawn than the spread so far asks for: it is an estimate too.
const MARGIN: f64 = 1.2;

/// The subject of a sample.
pub struct Subject<'a> {
    /// The machine.
    pub spec: &'a SystemSpec,
    /// System memory with the tree.
    pub memory: &'a SystemMemory,
    /// The tree.
    pub tree: Tree,
    /// The rays of each view.
    pub views: &'a [Source<'a>],
    /// The units; threads change no figure.
    pub options: Options,
    /// Watches the work, ray by ray.
    pub watch: &'a dyn Watch,
}

/// The result of a sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Sampled {
    /// The seed.
    pub seed: u64,
    /// Rays in all.
    pub rays: u64,
    /// Blocks in all.
    pub blocks: u64,
    /// Blocks that were traced.
    pub looked: u64,
    /// Blocks that were run.
    pub run: u64,
    /// The figures, with 95 % intervals.
    pub figures: Vec<UnitFigure>,
    /// Counters of the blocks and the memories, for each group of blocks.
    pub outcomes: Vec<Outcome>,
}

/// The outcome of sampling.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// The sample.
    Sample(Box<Sampled>),
    /// A sample that is precise enough would be most of the rays.
    TooMuch,
}

/// Samples the rays until drawing leaves at most `error` of the cycles to half their interval. `None` where it was
/// cancelled.
pub fn sample(subject: &Subject<'_>, seed: u64, error: f64) -> Option<Found> {
    let rays: u64 = subject.views.iter().map(|v| v.rays() as u64).sum();
    let _stage = Stage::of(subject.watch, "rays", rays);
    let mut growing = Growing::new(subject, seed);
    let all = growing.rounds.len();
    let strata = growing.strata.len();
    // Half of the variance that is left may come of tracing some only.
    let traces = 2.0 * (1.96 * SPREAD / error).powi(2) / strata as f64;
    let mut traces = (traces.ceil() as usize).max(TRACED_A_DRAW * LEAST_DRAWS);
    let mut draws = LEAST_DRAWS;
    let leading = growing.leading as f64 / BLOCK as f64;
    let company = match subject.options.memories {
        Memories::Shared if subject.options.units > 1 => OF_COMPANY,
        _ => 0.0,
    };
    loop {
        let traces_all = (strata * traces) as f64 > ALL * all as f64;
        let warming = if traces_all { 0.0 } else { OF_WARMING };
        let run = (strata * draws) as f64 * (1.0 + leading + company + warming);
        let traced = if traces_all { all } else { strata * traces };
        if all < LEAST_ROUNDS || run + OF_TRACING * traced as f64 > MOST * all as f64 {
            return Some(Found::TooMuch);
        }
        match traces_all {
            true => growing.trace_all()?,
            false => growing.trace(traces)?,
        }
        growing.run(draws)?;
        let sample = growing.sample();
        let cycles: Vec<f64> = growing.spent.iter().map(|s| s.cycles() as f64).collect();
        let total = sample.total(&cycles);
        if total.relative() <= error {
            return Some(Found::Sample(Box::new(Sampled {
                seed,
                rays,
                blocks: growing.blocks.count(),
                looked: growing.blocks_of(growing.traces.keys()),
                run: growing.blocks_of(growing.drawn.iter()),
                figures: figures(&growing, &sample),
                outcomes: growing.outcomes,
            })));
        }
        let half = 0.5 * (error * total.value / 2.0).powi(2) / MARGIN;
        let variance = sample.variance(&cycles);
        let more = |variance: f64, now: usize, allowed: f64| {
            let factor = (variance / allowed).clamp(1.0, 4.0);
            (now as f64 * factor).ceil() as usize
        };
        traces = more(variance.unlooked, traces, half);
        let allowed = 2.0 * half - variance.unlooked.min(half);
        draws = more(variance.drawn, draws, allowed).max(draws + 1);
        traces = traces.max(TRACED_A_DRAW * draws);
    }
}

/// The figures of all rays.
fn figures(growing: &Growing<'_>, sample: &Sample) -> Vec<UnitFigure> {
    let Subject { spec, options, .. } = growing.subject;
    let ratio = |above: &[f64], below: &[f64]| sample.ratio(above, below);
    let mut figures = figures_of(&growing.spent, options.units, spec, &ratio);
    for figure in &mut figures {
        if let Some(count) = count(figure.quantity) {
            figure.estimate = sample.known(count, RAYS);
        }
        figure.estimate.half_width += beyond_drawing(figure);
    }
    figures
}

/// The auxiliary variable that a quantity is the mean of: it needs no running.
fn count(quantity: UnitQuantity) -> Option<usize> {
    match quantity {
        UnitQuantity::HitsPerRay => Some(HITS),
        UnitQuantity::InnerNodesPerRay => Some(INNER),
        UnitQuantity::LeavesPerRay => Some(LEAVES),
        UnitQuantity::TestsPerRay => Some(TESTS),
        _ => None,
    }
}

/// How far off a figure may be with all blocks drawn, because caches are warmed by some of the rays before, and units
/// that share a memory have other company than in their turn. Parts of the value, or of 100 % for rates, as they
/// were seen, rounded up, where all blocks were run (docs/fidelity.md).
fn beyond_drawing(figure: &UnitFigure) -> f64 {
    let value = figure.estimate.value.abs();
    match figure.quantity {
        UnitQuantity::Rate | UnitQuantity::CyclesPerRay => 0.015 * value,
        UnitQuantity::Residence => 0.045 * value,
        UnitQuantity::TrvL1Hits => 0.2,
        UnitQuantity::TrvL2Hits => 2.3,
        UnitQuantity::IstL1Hits => 0.6,
        UnitQuantity::Bandwidth => 0.1 * value,
        UnitQuantity::HitsPerRay
        | UnitQuantity::InnerNodesPerRay
        | UnitQuantity::LeavesPerRay
        | UnitQuantity::TestsPerRay => 0.0,
    }
}
