//! Hits that are there at once: what the unit answers, without its time and its memory accesses, for
//! measuring what the kernels take by themselves.

use std::sync::Arc;

use super::function::Tracer;
use super::{RAY_BYTES, Tni, read_ray};
use crate::memory::SystemMemory;

impl Tni {
    /// Answers all submissions in the cycle in which they come.
    pub fn answer_at_once(&mut self, memory: &SystemMemory, sram: &mut [u8]) {
        let (spec, tree) = (Arc::clone(&self.spec), self.tree);
        let mut tracer = Tracer::over(&spec, &tree, memory, self.decoded(memory));
        let waiting = self.submissions.iter_mut().filter(|s| !s.is_complete());
        for submission in waiting {
            for ray in submission.dispatched..submission.count {
                let at = (submission.rays + ray * RAY_BYTES) as usize;
                let source = read_ray(&sram[at..at + RAY_BYTES as usize]);
                let traced = tracer.trace(&source);
                self.counters.hits += u64::from(traced.hit.is_hit());
                self.counters.rays += 1;
                self.counters.results += 1;
                if let (Some(trv), Some(ist)) = (self.trvs.first_mut(), self.ists.first_mut()) {
                    trv.counters.inner_visits += u64::from(traced.inner_visits);
                    trv.counters.leaf_visits += u64::from(traced.leaf_visits);
                    ist.tests += u64::from(traced.triangle_tests);
                }
                submission.answer(ray, traced.hit, source.flags);
            }
            submission.write_hits(sram);
        }
    }
}
