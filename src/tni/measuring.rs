//! Running T&I units over the views of a scene, several at a time.

use crate::cli;
use crate::failure::Failure;
use crate::interrupt;
use crate::talk::CONSOLE;
use crate::talk::{self, Progress};
use srp_archdesc::system::SystemSpec;
use srp_archdesc::threads;
use srp_runtime::bvh::{self, Bvh, Layout};
use srp_runtime::memory::SystemMemory;
use srp_runtime::scene::{Camera, Scene};
use srp_runtime::tni::{TniCounters, Tracer, Tree, place_for};
use srp_studies::fidelity::Fidelity;
use srp_studies::rays::{Kind, Order, Ray, Sampling, Source};
use srp_studies::tni::sampled::{self, Found, Sampled, Subject};
use srp_studies::tni::{
    Bench, Estimated, Measure, Memories, Options, Outcome, RunCounts, UnitFigure,
};
use std::sync::atomic::{AtomicU64, Ordering};

/// The rays that are traced.
pub(crate) enum Rays {
    /// Rays of a view.
    Of(Kind),
    /// These, whatever the view.
    Given(Vec<Ray>),
}

impl Rays {
    /// Returns their name.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Rays::Of(Kind::Primary) => "primary",
            Rays::Of(Kind::AmbientOcclusion { .. }) => "ambient occlusion",
            Rays::Of(Kind::Diffuse { .. }) => "diffuse",
            Rays::Given(_) => "given",
        }
    }
}

/// The subject and the settings of a measurement.
#[derive(Clone, Copy)]
pub(crate) struct Job<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) bvh: &'a Bvh,
    pub(crate) spec: &'a SystemSpec,
    pub(crate) cameras: &'a [Camera],
    pub(crate) size: (u32, u32),
    pub(crate) rays: &'a Rays,
    pub(crate) order: Order,
    /// One run of packets in so many is measured, that in the middle.
    pub(crate) one_in: u64,
    pub(crate) units: u32,
    pub(crate) memories: Memories,
    pub(crate) threads: usize,
    /// True if the cost of each pixel is kept.
    pub(crate) costs: bool,
}

impl<'a> Job<'a> {
    /// The tree as the unit reads it.
    pub(crate) fn place(&self) -> (SystemMemory, Tree) {
        let layout = Layout::of(&self.spec.tni);
        let image = bvh::lay_out(self.bvh, &self.scene.triangles, layout);
        place_for(self.spec, &image)
    }

    /// The views to run: of given rays, one.
    pub(crate) fn views(&self) -> usize {
        match self.rays {
            Rays::Of(_) => self.cameras.len(),
            Rays::Given(_) => 1,
        }
    }

    /// The rays of a view.
    pub(crate) fn source(&self, view: usize, tree: &Tree, memory: &SystemMemory) -> Source {
        match self.rays {
            Rays::Given(rays) => Source::given(rays.clone(), self.order),
            Rays::Of(kind) => {
                let tracer = Tracer::new(&self.spec.tni, tree, memory);
                let view = (&self.cameras[view], self.size);
                Source::new(view, *kind, &self.scene.triangles, tracer, self.order)
            }
        }
    }

    /// The rays of all views, several at a time; `None` where Ctrl-C said so.
    fn sources(&self, tree: &Tree, memory: &SystemMemory) -> Option<Vec<Source>> {
        let source = |(): &mut (), view: usize| {
            (!interrupt::requested()).then(|| self.source(view, tree, memory))
        };
        threads::all(self.threads, self.views(), || (), source)
    }

    fn options(&self, threads: usize) -> Options {
        Options {
            units: self.units,
            memories: self.memories,
            threads,
            hits: false,
            costs: self.costs,
        }
    }

    /// About how many rays a view has.
    fn expected(&self) -> u64 {
        let pixels = u64::from(self.size.0) * u64::from(self.size.1);
        match self.rays {
            Rays::Of(Kind::Primary) => pixels,
            Rays::Of(Kind::AmbientOcclusion { samples, .. } | Kind::Diffuse { samples }) => {
                pixels * u64::from(*samples)
            }
            Rays::Given(rays) => rays.len() as u64,
        }
    }
}

/// A measurement.
pub(crate) struct Measured {
    /// The outcome of each view, or, of a sample, of each group of blocks.
    pub(crate) outcomes: Vec<Outcome>,
    /// The figures of all rays. In a sample, figures without an interval are those of the rays that were run.
    pub(crate) all: Measure,
    /// The sample, if there is one.
    pub(crate) sample: Option<Box<Sampled>>,
    /// One run of packets in so many was measured.
    pub(crate) one_in: u64,
}

impl Measured {
    fn of(job: &Job<'_>, outcomes: Vec<Outcome>) -> Measured {
        Measured {
            all: Measure::of(&outcomes, job.units, job.spec),
            outcomes,
            sample: None,
            one_in: job.one_in,
        }
    }

    /// The figures with intervals; none where all was measured.
    pub(crate) fn intervals(&self, job: &Job<'_>) -> Vec<UnitFigure> {
        if let Some(sample) = &self.sample {
            return sample.figures.clone();
        }
        if self.one_in == 1 {
            return Vec::new();
        }
        let spent = self.outcomes.iter().flat_map(|o| o.spent.iter().cloned());
        let spent: Vec<RunCounts> = spent.collect();
        srp_studies::tni::figures(&spent, job.units, job.spec)
    }
}

/// Measures a job at a level that has a clock; `sampled` with a seed and an error, as half an interval of the cycles
/// over them.
pub(crate) fn measure_at(job: &Job<'_>, level: &cli::Level) -> Result<Measured, Failure> {
    if level.fidelity == Fidelity::Sampled {
        let (memory, tree) = job.place();
        let views = interrupt::looked_for(|| job.sources(&tree, &memory));
        let views = views.ok_or(Failure::Interrupted)?;
        let subject = Subject {
            spec: job.spec,
            memory: &memory,
            tree,
            views: &views,
            options: job.options(job.threads),
            watch: &CONSOLE,
        };
        let found = interrupt::looked_for(|| sampled::sample(&subject, level.seed, level.error));
        if let Found::Sample(sample) = found.ok_or(Failure::Interrupted)? {
            let outcomes = some(job, sample.outcomes.clone())?;
            let all = Measure::of(&outcomes, job.units, job.spec).with(&sample.figures);
            return Ok(Measured {
                outcomes,
                all,
                sample: Some(sample),
                one_in: 1,
            });
        }
    }
    let job = match level.fidelity {
        Fidelity::Sampled => {
            talk::say(
                "note: a sample that tells as much would be most of the rays, so all are run",
            );
            Job { one_in: 1, ..*job }
        }
        _ => *job,
    };
    let outcomes = interrupt::looked_for(|| measure(&job))?;
    Ok(Measured::of(&job, outcomes))
}

/// The counts of all views without any clock, and, where estimates are wanted, cycles too.
pub(crate) fn count(job: &Job<'_>, estimated: bool) -> Result<Vec<Outcome>, Failure> {
    let (memory, tree) = job.place();
    let progress = Progress::steps("rays", job.expected() * job.views() as u64);
    let mut outcomes = Vec::new();
    let mut done = 0;
    for view in 0..job.views() {
        let mut units = Estimated::new(job.spec, &memory, tree, job.units);
        let mut tracer = Tracer::new(&job.spec.tni, &tree, &memory);
        let mut counters = TniCounters::default();
        let mut feed = |rays: &[Ray]| {
            done += rays.len();
            progress.at(done as u64);
            if estimated {
                return units.feed(rays);
            }
            for ray in rays {
                let traced = tracer.trace(ray);
                counters.unit.rays += 1;
                counters.unit.hits += u64::from(traced.hit.is_hit());
                counters.trv.inner_visits += u64::from(traced.inner_visits);
                counters.trv.leaf_visits += u64::from(traced.leaf_visits);
                counters.triangle_tests += u64::from(traced.triangle_tests);
            }
        };
        let source = job.source(view, &tree, &memory);
        for batch in 0..source.batches() {
            feed(&source.batch(batch));
            if interrupt::requested() {
                return Err(Failure::Interrupted);
            }
        }
        let mut outcome = units.finish();
        if !estimated {
            outcome.counters = counters;
        }
        outcomes.push(outcome);
    }
    some(job, outcomes)
}

/// Refuses outcomes of no ray at all.
fn some(job: &Job<'_>, outcomes: Vec<Outcome>) -> Result<Vec<Outcome>, Failure> {
    if outcomes.iter().any(|o| o.counters.unit.rays > 0) {
        return Ok(outcomes);
    }
    Err(Failure::Message(format!(
        "there are no {} rays to measure: {}",
        job.rays.name(),
        match job.rays {
            Rays::Given(rays) if rays.is_empty() => "the file has none",
            Rays::Given(_) => "the sample has none of the file's",
            _ if job.one_in > 1 => "the sample has none, or nothing is seen that they start from",
            _ => "nothing is seen that they start from",
        }
    )))
}

/// Measures all views of a job. The result does not depend on the number of threads.
pub(crate) fn measure(job: &Job<'_>) -> Result<Vec<Outcome>, Failure> {
    let (memory, tree) = job.place();
    let views = job.views();
    let outer = job.threads.clamp(1, views.max(1));
    let options = job.options(job.threads / outer);
    let progress = Progress::steps("rays", job.expected() * views as u64);
    let done = AtomicU64::new(0);
    let count = |n: usize| {
        let n = n as u64;
        progress.at(done.fetch_add(n, Ordering::Relaxed) + n);
    };
    let run = |(): &mut (), view: usize| run_view(job, view, &tree, &memory, options, &count);
    let outcomes = threads::all(outer, views, || (), run);
    some(job, outcomes.ok_or(Failure::Interrupted)?)
}

fn run_view(
    job: &Job<'_>,
    view: usize,
    tree: &Tree,
    memory: &SystemMemory,
    options: Options,
    count: &dyn Fn(usize),
) -> Option<Outcome> {
    let packet = u64::from(job.spec.buffers.rays.max(1));
    let sampling = Sampling::new(job.one_in, job.expected().div_ceil(packet));
    let mut bench = Bench::new(job.spec, memory, *tree, options);
    let source = job.source(view, tree, memory);
    for batch in 0..source.batches() {
        let rays = source.batch(batch);
        count(rays.len());
        if !bench.feed(rays, &sampling, &CONSOLE) {
            return None;
        }
    }
    let mut outcome = bench.finish(&CONSOLE)?;
    if job.one_in == 1 {
        // Nothing is left to drawing.
        outcome.relative_error = None;
    }
    Some(outcome)
}
