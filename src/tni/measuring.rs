//! Running T&I units over the views of a scene, several at a time.

use crate::failure::Failure;
use crate::interrupt;
use crate::talk::Progress;
use srp_archdesc::system::SystemSpec;
use srp_runtime::bvh::{self, Bvh, Layout};
use srp_runtime::memory::SystemMemory;
use srp_runtime::rays::{self, BATCH, Kind, Order, Ray, Sampling, Source};
use srp_runtime::scene::{Camera, Scene};
use srp_runtime::tni::standalone::{self, Bench, Estimated, Measure, Memories, Options, Outcome};
use srp_runtime::tni::{TniCounters, Tracer, Tree};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What is traced.
pub(crate) enum Rays {
    /// Rays of a view.
    Of(Kind),
    /// These, whatever the view.
    Given(Vec<Ray>),
}

impl Rays {
    /// What they are called.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Rays::Of(Kind::Primary) => "primary",
            Rays::Of(Kind::AmbientOcclusion { .. }) => "ambient occlusion",
            Rays::Of(Kind::Diffuse { .. }) => "diffuse",
            Rays::Given(_) => "given",
        }
    }
}

/// What is measured.
#[derive(Clone, Copy)]
pub(crate) struct Job<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) bvh: &'a Bvh,
    pub(crate) spec: &'a SystemSpec,
    pub(crate) cameras: &'a [Camera],
    pub(crate) size: (u32, u32),
    pub(crate) rays: &'a Rays,
    pub(crate) order: Order,
    /// One run of packets in so many is measured.
    pub(crate) one_in: u64,
    /// The seed of runs at random; without one those in the middle are taken.
    pub(crate) seed: Option<u64>,
    pub(crate) units: u32,
    pub(crate) memories: Memories,
    pub(crate) threads: usize,
    /// Whether what each pixel costs is kept.
    pub(crate) costs: bool,
}

impl<'a> Job<'a> {
    /// The tree as the unit reads it.
    pub(crate) fn place(&self) -> (SystemMemory, Tree) {
        let layout = Layout::of(&self.spec.tni);
        let image = bvh::lay_out(self.bvh, &self.scene.triangles, layout);
        standalone::place_for(self.spec, &image)
    }

    /// The views to run: of given rays, one.
    fn views(&self) -> usize {
        match self.rays {
            Rays::Of(_) => self.cameras.len(),
            Rays::Given(_) => 1,
        }
    }

    /// The rays of a view; of given rays none.
    pub(crate) fn source<'b>(
        &'b self,
        view: usize,
        tree: &'b Tree,
        memory: &'b SystemMemory,
    ) -> Option<Source<'b>> {
        let Rays::Of(kind) = self.rays else {
            return None;
        };
        let tracer = Tracer::new(&self.spec.tni, tree, memory);
        let view = (&self.cameras[view], self.size);
        let triangles = &self.scene.triangles;
        Some(Source::new(view, *kind, triangles, tracer, self.order))
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

/// Packets of all runs that a sample begins with, and the least of them in a run.
const FIRST_PACKETS: u64 = 48 * 8;

/// Measures so many runs of a job, at random, that half the interval of its cycles is at most `error`
/// of them. The job says how.
pub(crate) fn measure_to<'a>(
    job: &Job<'a>,
    seed: u64,
    error: f64,
) -> Result<(Job<'a>, Vec<Outcome>), Failure> {
    let packets = job.expected() / u64::from(job.spec.buffers.rays.max(1));
    let mut one_in = (packets / FIRST_PACKETS).max(1);
    loop {
        let part = Job {
            one_in,
            seed: Some(seed),
            ..*job
        };
        let outcomes = measure(&part)?;
        let found = Measure::of(&outcomes, job.units, job.spec).relative_error;
        let found = found.unwrap_or(f64::INFINITY);
        if found <= error || one_in == 1 {
            return Ok((part, outcomes));
        }
        // As many more as the square says, and at least twice as many.
        let fewer = (error / found) * (error / found) / 1.1;
        one_in = ((one_in as f64 * fewer) as u64)
            .clamp(one_in / 16, one_in / 2)
            .max(1);
    }
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
        match job.source(view, &tree, &memory) {
            Some(mut source) => loop {
                let batch = source.next_batch();
                if batch.is_empty() {
                    break;
                }
                feed(&batch);
                if interrupt::requested() {
                    return Err(Failure::Interrupted);
                }
            },
            None => {
                if let Rays::Given(rays) = job.rays {
                    let mut rays = rays.clone();
                    job.order.sort(&mut rays);
                    feed(&rays);
                }
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
            Rays::Given(_) => "the file has none",
            _ if job.one_in > 1 => "the sample has none, or nothing is seen that they start from",
            _ => "nothing is seen that they start from",
        }
    )))
}

/// Measures all views of a job. What comes out does not depend on the number of threads.
pub(crate) fn measure(job: &Job<'_>) -> Result<Vec<Outcome>, Failure> {
    let (memory, tree) = job.place();
    let views = job.views();
    let outer = job.threads.clamp(1, views.max(1));
    let options = Options {
        units: job.units,
        memories: job.memories,
        threads: job.threads / outer,
        hits: false,
        costs: job.costs,
    };
    let progress = Progress::steps("rays", job.expected() * views as u64);
    let done = AtomicUsize::new(0);
    let next = AtomicUsize::new(0);
    let outcomes: Mutex<Vec<Option<Outcome>>> = Mutex::new(vec![None; views]);
    std::thread::scope(|scope| {
        for _ in 0..outer {
            scope.spawn(|| {
                loop {
                    let view = next.fetch_add(1, Ordering::Relaxed);
                    if view >= views {
                        return;
                    }
                    let ray_count = |n: usize| {
                        progress.at((done.fetch_add(n, Ordering::Relaxed) + n) as u64);
                    };
                    let outcome = run_view(job, view, &tree, &memory, options, &ray_count);
                    outcomes.lock().expect("no thread panics with it")[view] = outcome;
                }
            });
        }
    });
    let outcomes = outcomes.into_inner().expect("no thread panics with it");
    let outcomes: Option<Vec<Outcome>> = outcomes.into_iter().collect();
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
    let sampling = job.seed.map_or(sampling, |seed| sampling.seeded(seed));
    let mut bench = Bench::new(job.spec, memory, *tree, options);
    let mut feed = |rays: Vec<Ray>| {
        count(rays.len());
        bench.feed(rays, &sampling, &interrupt::requested)
    };
    match job.source(view, tree, memory) {
        Some(mut source) => loop {
            let batch = source.next_batch();
            if batch.is_empty() {
                break;
            }
            if !feed(batch) {
                return None;
            }
        },
        None => {
            let Rays::Given(rays) = job.rays else {
                return None;
            };
            for batch in rays.chunks(BATCH) {
                let mut batch = batch.to_vec();
                job.order.sort(&mut batch);
                if !feed(batch) {
                    return None;
                }
            }
        }
    }
    bench.finish(&interrupt::requested)
}

impl From<crate::cli::RayOrder> for Order {
    fn from(order: crate::cli::RayOrder) -> Order {
        match order {
            crate::cli::RayOrder::Morton => rays::Order::Morton,
            crate::cli::RayOrder::Pixels => rays::Order::Pixels,
            crate::cli::RayOrder::Rows => rays::Order::Rows,
            crate::cli::RayOrder::Random => rays::Order::Random,
        }
    }
}
