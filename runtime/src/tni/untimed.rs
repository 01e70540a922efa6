//! The unit without its time and its memory accesses: a submission is answered when it comes.

use std::ops::AddAssign;
use std::sync::Arc;

use srp_archdesc::system::TniSpec;

use super::counters::TniCounters;
use super::decoded::Decoded;
use super::full::describe;
use super::function::Tracer;
use super::submission::Queue;
use super::{Buffers, Finished, HitRecord, RAY_BYTES, Runs, SubmitError, Tree, read_ray};
use crate::memory::SystemMemory;

/// The work of tracing rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// Rays by their outcome.
    pub runs: Runs,
    /// Submissions.
    pub submissions: u64,
    /// Visits of inner nodes, two boxes each.
    pub inner_visits: u64,
    /// Visits of leaves.
    pub leaf_visits: u64,
    /// Ray–triangle tests.
    pub triangle_tests: u64,
}

impl RayCounts {
    /// Rays of all kinds.
    pub fn rays(&self) -> u64 {
        let Runs {
            shadow_hits,
            shadow_misses,
            other_hits,
            other_misses,
        } = self.runs;
        [shadow_hits, shadow_misses, other_hits, other_misses]
            .map(u64::from)
            .iter()
            .sum()
    }

    /// Rays that hit something.
    pub fn hits(&self) -> u64 {
        u64::from(self.runs.shadow_hits) + u64::from(self.runs.other_hits)
    }
}

impl AddAssign for RayCounts {
    fn add_assign(&mut self, other: RayCounts) {
        self.runs.shadow_hits += other.runs.shadow_hits;
        self.runs.shadow_misses += other.runs.shadow_misses;
        self.runs.other_hits += other.runs.other_hits;
        self.runs.other_misses += other.runs.other_misses;
        self.submissions += other.submissions;
        self.inner_visits += other.inner_visits;
        self.leaf_visits += other.leaf_visits;
        self.triangle_tests += other.triangle_tests;
    }
}

/// The unit without its time.
#[derive(Clone, Debug)]
pub struct Untimed {
    spec: Arc<TniSpec>,
    tree: Tree,
    /// The inner nodes, once they were read.
    decoded: Option<Arc<Decoded>>,
    queue: Queue,
    /// The work of its rays.
    pub counts: RayCounts,
}

impl Untimed {
    /// An idle unit over a tree, which holds at most `max_submissions` answers that nobody has taken.
    pub fn new(spec: &TniSpec, tree: Tree, max_submissions: u32) -> Untimed {
        Untimed {
            spec: Arc::new(*spec),
            tree,
            decoded: None,
            queue: Queue::new(max_submissions),
            counts: RayCounts::default(),
        }
    }

    /// The same unit, which has read the inner nodes of its tree: its clones need not do so again.
    pub fn having_read(mut self, memory: &SystemMemory) -> Untimed {
        self.decoded = Some(Decoded::shared(&self.spec, &self.tree, memory));
        self
    }

    /// Answers a submission. Gives the hits in the order in which they stand in the hit buffer.
    ///
    /// # Errors
    ///
    /// The unit is full, or the buffers do not lie in the SRAM.
    pub fn submit(
        &mut self,
        buffers: Buffers,
        memory: &SystemMemory,
        sram: &mut [u8],
    ) -> Result<&[HitRecord], SubmitError> {
        let mut submission = self.queue.admit(buffers, sram.len())?;
        let decoded =
            (self.decoded).get_or_insert_with(|| Decoded::shared(&self.spec, &self.tree, memory));
        let mut tracer = Tracer::over(&self.spec, &self.tree, memory, Arc::clone(decoded));
        for ray in 0..buffers.count {
            let source = read_ray(sram, buffers.rays + ray * RAY_BYTES);
            let traced = tracer.trace(&source);
            self.counts.inner_visits += u64::from(traced.inner_visits);
            self.counts.leaf_visits += u64::from(traced.leaf_visits);
            self.counts.triangle_tests += u64::from(traced.triangle_tests);
            submission.answer(ray, traced.hit, source.flags);
        }
        submission.write_hits(sram);
        self.counts += RayCounts {
            runs: submission.runs(),
            submissions: 1,
            ..RayCounts::default()
        };
        Ok(&self.queue.push(submission).records)
    }

    /// Takes the oldest submission out of the unit.
    pub fn take_finished(&mut self) -> Option<Finished> {
        self.queue.take_finished()
    }

    /// Counts of the unit so far: rays, visits and tests.
    pub fn counters(&self) -> TniCounters {
        let mut counters = TniCounters {
            trvs: self.spec.trvs.into(),
            ists: self.spec.ists.into(),
            triangle_tests: self.counts.triangle_tests,
            ..TniCounters::default()
        };
        counters.unit.rays = self.counts.rays();
        counters.unit.results = self.counts.rays();
        counters.unit.hits = self.counts.hits();
        counters.trv.inner_visits = self.counts.inner_visits;
        counters.trv.leaf_visits = self.counts.leaf_visits;
        counters
    }

    /// Describes in words what the unit waits for.
    pub fn describe_state(&self) -> String {
        describe(&self.queue, [0; 3])
    }
}
