//! The unit without its time: a submission is answered when it comes.

use std::collections::VecDeque;
use std::ops::AddAssign;

use srp_archdesc::system::TniSpec;

use super::function::Tracer;
use super::submission::{HitRecord, Runs, Submission, SubmitError};
use super::{Hit, RAY_BYTES, Tree, read_ray};
use crate::memory::SystemMemory;

/// What rays took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// Rays by what became of them.
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
pub struct Untimed<'a> {
    tracer: Tracer<'a>,
    max_submissions: usize,
    submissions: VecDeque<Submission>,
    /// What its rays have taken.
    pub counts: RayCounts,
}

impl<'a> Untimed<'a> {
    /// An idle unit over a tree in memory, which holds at most `max_submissions` answers that
    /// nobody has taken.
    pub fn new(
        spec: &'a TniSpec,
        tree: &'a Tree,
        memory: &'a SystemMemory,
        max_submissions: u32,
    ) -> Untimed<'a> {
        Untimed {
            tracer: Tracer::new(spec, tree, memory),
            max_submissions: max_submissions.max(1) as usize,
            submissions: VecDeque::new(),
            counts: RayCounts::default(),
        }
    }

    /// Answers `count` rays at `rays` in the SRAM, whose hits go to `hits`: as
    /// [`Tni::submit`](super::Tni::submit), and at once. Gives the hits in the order in which they
    /// stand there.
    pub fn submit(
        &mut self,
        rays: u32,
        hits: u32,
        count: u32,
        sram: &mut [u8],
    ) -> Result<&[HitRecord], SubmitError> {
        if self.submissions.len() == self.max_submissions {
            return Err(SubmitError::Busy);
        }
        let mut submission = Submission::within(rays, hits, count, sram.len())?;
        for ray in 0..count {
            let at = (rays + ray * RAY_BYTES) as usize;
            let source = read_ray(&sram[at..at + RAY_BYTES as usize]);
            let traced = self.tracer.trace(&source);
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
        Ok(&self.submissions.push_back_mut(submission).records)
    }

    /// The hits of the oldest submission.
    pub fn finished(&self) -> Option<&[HitRecord]> {
        Some(&self.submissions.front()?.records)
    }

    /// Takes the oldest submission out of the unit.
    pub fn take_finished(&mut self) -> Option<Runs> {
        Some(self.submissions.pop_front()?.runs())
    }
}

impl Submission {
    /// The answer to one of its rays.
    pub(super) fn answer(&mut self, ray: u32, hit: Hit, flags: u32) {
        self.dispatched += 1;
        self.records.push(HitRecord { hit, ray, flags });
    }
}
