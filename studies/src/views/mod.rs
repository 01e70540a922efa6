//! T&I units over the views of a scene, several views at a time.
//!
//! A [`Job`] names the scene, the rays, the units and the [`Level`] of simulation. [`Job::measure`] runs units with a
//! clock, all rays or a sample of them; [`Job::count`] traces rays without one; [`Job::follow`] logs a single ray.

use crate::Error;
use crate::fidelity::Fidelity;
use crate::rays::{Kind, Order, Ray, Sampling, Source};
use crate::tni::sampled::{self, Found, Sampled, Subject};
use crate::tni::{
    Bench, Estimated, Measure, Memories, Options, Outcome, RunCounts, UnitFigure, figures,
};
use serde::Serialize;
use srp_archdesc::system::SystemSpec;
use srp_archdesc::watch::{Event, Stage, Watch};
use srp_archdesc::{Unwatched, threads};
use srp_runtime::bvh::{self, Bvh, Layout};
use srp_runtime::memory::SystemMemory;
use srp_runtime::scene::{Camera, Scene};
use srp_runtime::tni::{Logged, TniCounters, Tracer, Tree, place_for};

/// Length of ambient-occlusion rays where nothing says it, as a part of the scene's diagonal.
const AO_RADIUS: f32 = 0.1;

/// Returns the length of ambient-occlusion rays in a scene of which no file of cameras says it.
pub fn ao_radius(scene: &Scene) -> f32 {
    let bounds = srp_runtime::scene::bounds(&scene.triangles);
    bounds.map_or(1.0, |(lo, hi)| AO_RADIUS * (hi - lo).length())
}

/// The rays that are traced.
pub enum Rays {
    /// Rays of a view.
    Of(Kind),
    /// These, whatever the view.
    Given(Vec<Ray>),
}

impl Rays {
    /// The name of their kind.
    pub fn name(&self) -> &'static str {
        match self {
            Rays::Of(Kind::Primary) => "primary",
            Rays::Of(Kind::AmbientOcclusion { .. }) => "ambient occlusion",
            Rays::Of(Kind::Diffuse { .. }) => "diffuse",
            Rays::Given(_) => "given",
        }
    }
}

/// How much is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Level {
    /// The level.
    pub fidelity: Fidelity,
    /// Of samples: half of the interval of cycles that drawing may leave, over the cycles.
    pub error: f64,
    /// Of samples: the seed of what is drawn.
    pub seed: u64,
}

/// The subject and the settings of a measurement.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// The scene, and the tree over its triangles.
    pub scene: &'a Scene,
    /// The tree.
    pub bvh: &'a Bvh,
    /// The system with the units and their memory.
    pub spec: &'a SystemSpec,
    /// A camera for each view.
    pub cameras: &'a [Camera],
    /// Width and height of each view in pixels.
    pub size: (u32, u32),
    /// The rays.
    pub rays: &'a Rays,
    /// Their order.
    pub order: Order,
    /// How much is simulated.
    pub level: Level,
    /// One run of packets in so many is measured, that in the middle.
    pub one_in: u64,
    /// Units that share the rays.
    pub units: u32,
    /// Their memories.
    pub memories: Memories,
    /// Threads of the host; they change no figure.
    pub threads: usize,
    /// True if the cost of each pixel is kept.
    pub costs: bool,
    /// True if each ray is kept, with its hit and its cost.
    pub keeps_rays: bool,
    /// Watches the work, ray by ray.
    pub watch: &'a dyn Watch,
}

impl<'a> Job<'a> {
    /// The tree as the unit reads it, and the memory that it is in.
    pub fn place(&self) -> (SystemMemory, Tree) {
        let layout = Layout::of(&self.spec.tni);
        let image = bvh::lay_out(self.bvh, &self.scene.triangles, layout);
        place_for(self.spec, &image)
    }

    /// The views to run: of given rays, one.
    pub fn views(&self) -> usize {
        match self.rays {
            Rays::Of(_) => self.cameras.len(),
            Rays::Given(_) => 1,
        }
    }

    /// The rays of a view.
    pub fn source<'s>(
        &'s self,
        view: usize,
        tree: &'s Tree,
        memory: &'s SystemMemory,
    ) -> Source<'s> {
        match self.rays {
            Rays::Given(rays) => Source::given(rays.as_slice(), self.order),
            Rays::Of(kind) => {
                let tracer = Tracer::new(&self.spec.tni, tree, memory);
                let view = (&self.cameras[view], self.size);
                Source::new(view, *kind, &self.scene.triangles, tracer, self.order)
            }
        }
    }

    /// The rays of all views, several at a time.
    fn sources<'s>(
        &'s self,
        tree: &'s Tree,
        memory: &'s SystemMemory,
    ) -> Result<Vec<Source<'s>>, Error> {
        let source = |(): &mut (), view: usize| {
            (!self.watch.cancelled()).then(|| self.source(view, tree, memory))
        };
        let sources = threads::all(self.threads, self.views(), || (), source);
        sources.ok_or_else(Error::cancelled)
    }

    fn options(&self, threads: usize) -> Options {
        Options {
            units: self.units,
            memories: self.memories,
            threads,
            hits: self.keeps_rays,
            costs: self.costs || self.keeps_rays,
        }
    }

    /// About how many rays all views have.
    fn rays_of_all(&self) -> u64 {
        self.expected() * self.views() as u64
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
pub struct Measured {
    /// The outcome of each view, or, of a sample, of each group of blocks.
    pub outcomes: Vec<Outcome>,
    /// The figures of all rays. In a sample, figures without an interval are those of the rays that were run.
    pub all: Measure,
    /// The sample, if there is one.
    pub sample: Option<Box<Sampled>>,
    /// One run of packets in so many was measured.
    pub one_in: u64,
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
    pub fn intervals(&self, job: &Job<'_>) -> Vec<UnitFigure> {
        if let Some(sample) = &self.sample {
            return sample.figures.clone();
        }
        if self.one_in == 1 {
            return Vec::new();
        }
        let spent = self.outcomes.iter().flat_map(|o| o.spent.iter().cloned());
        let spent: Vec<RunCounts> = spent.collect();
        figures(&spent, job.units, job.spec)
    }
}

impl Job<'_> {
    /// Runs the units with a clock. The result does not depend on the number of threads.
    ///
    /// # Errors
    ///
    /// There are no rays, or the watch ends the work.
    pub fn measure(&self) -> Result<Measured, Error> {
        if self.level.fidelity != Fidelity::Sampled {
            return Ok(Measured::of(self, self.run()?));
        }
        if let Some(sampled) = self.sample()? {
            return Ok(sampled);
        }
        self.watch.tell(Event::Note(
            "note: a sample that tells as much would be most of the rays, so all are run",
        ));
        let all = Job { one_in: 1, ..*self };
        Ok(Measured::of(&all, all.run()?))
    }

    /// A sample; `None` where it would have to be most of the rays.
    fn sample(&self) -> Result<Option<Measured>, Error> {
        let (memory, tree) = self.place();
        let views = self.sources(&tree, &memory)?;
        let subject = Subject {
            spec: self.spec,
            memory: &memory,
            tree,
            views: &views,
            options: self.options(self.threads),
            watch: self.watch,
        };
        let found = sampled::sample(&subject, self.level.seed, self.level.error);
        let Found::Sample(sample) = found.ok_or_else(Error::cancelled)? else {
            return Ok(None);
        };
        let outcomes = self.some(sample.outcomes.clone())?;
        let all = Measure::of(&outcomes, self.units, self.spec).with(&sample.figures);
        Ok(Some(Measured {
            outcomes,
            all,
            sample: Some(sample),
            one_in: 1,
        }))
    }

    /// The counts of each view without any clock; at the level `analytic`, with estimated cycles.
    ///
    /// # Errors
    ///
    /// There are no rays, or the watch ends the work.
    pub fn count(&self) -> Result<Vec<Outcome>, Error> {
        let (memory, tree) = self.place();
        let stage = Stage::of(self.watch, "rays", self.rays_of_all());
        let mut outcomes = Vec::new();
        for view in 0..self.views() {
            let source = self.source(view, &tree, &memory);
            let mut units = Estimated::new(self.spec, &memory, tree, self.units);
            let mut tracer = Tracer::new(&self.spec.tni, &tree, &memory);
            let mut counters = TniCounters::default();
            for batch in 0..source.batches() {
                let rays = source.batch(batch);
                stage.done(rays.len() as u64);
                match self.level.fidelity {
                    Fidelity::Analytic => units.feed(&rays),
                    _ => trace(&mut tracer, &rays, &mut counters),
                }
                if self.watch.cancelled() {
                    return Err(Error::cancelled());
                }
            }
            let mut outcome = units.finish();
            if self.level.fidelity != Fidelity::Analytic {
                outcome.counters = counters;
            }
            outcomes.push(outcome);
        }
        self.some(outcomes)
    }

    /// The first ray of a pixel of the first view, and all that happens to it, alone in a unit with empty caches.
    ///
    /// # Errors
    ///
    /// There is no such pixel, or no ray starts there.
    pub fn follow(&self, (x, y): (u32, u32)) -> Result<(Ray, Vec<Logged>), Error> {
        if x >= self.size.0 || y >= self.size.1 {
            return Err(Error::Invalid(format!(
                "there is no pixel {x},{y} in a picture of {}x{}",
                self.size.0, self.size.1
            )));
        }
        let (memory, tree) = self.place();
        let pixel = y * self.size.0 + x;
        let source = self.source(0, &tree, &memory);
        let mut rays = (0..source.batches()).flat_map(|batch| source.batch(batch));
        let ray = rays.find(|r| r.payload == pixel).ok_or_else(|| {
            Error::Invalid(format!("no ray of this kind starts at pixel {x},{y}"))
        })?;
        let options = Options {
            units: 1,
            memories: Memories::Private,
            threads: 1,
            hits: false,
            costs: false,
        };
        let mut bench = Bench::new(self.spec, &memory, tree, options);
        bench.note_events();
        bench.feed(vec![ray], &Sampling::new(1, 1), &Unwatched);
        Ok((ray, bench.run_out()))
    }

    /// Refuses outcomes of no ray at all.
    fn some(&self, outcomes: Vec<Outcome>) -> Result<Vec<Outcome>, Error> {
        if outcomes.iter().any(|o| o.counters.unit.rays > 0) {
            return Ok(outcomes);
        }
        Err(Error::Invalid(format!(
            "there are no {} rays to measure: {}",
            self.rays.name(),
            match self.rays {
                Rays::Given(rays) if rays.is_empty() => "the file has none",
                Rays::Given(_) => "the sample has none of the file's",
                _ if self.one_in > 1 =>
                    "the sample has none, or nothing is seen that they start from",
                _ => "nothing is seen that they start from",
            }
        )))
    }

    /// Runs all views.
    fn run(&self) -> Result<Vec<Outcome>, Error> {
        let (memory, tree) = self.place();
        let views = self.views();
        let outer = self.threads.clamp(1, views.max(1));
        let options = self.options(self.threads / outer);
        let stage = Stage::of(self.watch, "rays", self.rays_of_all());
        let run = |(): &mut (), view: usize| self.run_view(view, (&tree, &memory), options, &stage);
        let outcomes = threads::all(outer, views, || (), run);
        self.some(outcomes.ok_or_else(Error::cancelled)?)
    }

    /// Runs a view; `None` where the watch ends that.
    fn run_view(
        &self,
        view: usize,
        (tree, memory): (&Tree, &SystemMemory),
        options: Options,
        stage: &Stage<'_>,
    ) -> Option<Outcome> {
        let packet = u64::from(self.spec.buffers.rays.max(1));
        let sampling = Sampling::new(self.one_in, self.expected().div_ceil(packet));
        let mut bench = Bench::new(self.spec, memory, *tree, options);
        let source = self.source(view, tree, memory);
        for batch in 0..source.batches() {
            let rays = source.batch(batch);
            stage.done(rays.len() as u64);
            if !bench.feed(rays, &sampling, self.watch) {
                return None;
            }
        }
        let mut outcome = bench.finish(self.watch)?;
        if self.one_in == 1 {
            // Nothing is left to drawing.
            outcome.relative_error = None;
        }
        Some(outcome)
    }
}

/// Traces rays without a clock, and counts them.
fn trace(tracer: &mut Tracer<'_>, rays: &[Ray], counters: &mut TniCounters) {
    for ray in rays {
        let traced = tracer.trace(ray);
        counters.unit.rays += 1;
        counters.unit.hits += u64::from(traced.hit.is_hit());
        counters.trv.inner_visits += u64::from(traced.inner_visits);
        counters.trv.leaf_visits += u64::from(traced.leaf_visits);
        counters.triangle_tests += u64::from(traced.triangle_tests);
    }
}
