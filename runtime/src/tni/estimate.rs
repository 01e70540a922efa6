//! Rays without contention: when a submission is answered, by rays that go through the unit one by one.
//!
//! A ray takes a stack of its traversal unit as soon as one is free, a visit or a test takes what the
//! pipelines and caches take that nobody else is in, and a line that is not there comes from the level-2
//! cache or from memory after their latencies, once for all that wait for it. The unit cannot be faster
//! than its pipelines issue. What is left out is queueing: for pipelines, banks, misses and the bus.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::function::{Step, Tracer};
use super::{RAY_BYTES, Tni, read_ray};
use crate::memory::SystemMemory;
use crate::memory::cache::{Access, Cache};

/// When stacks are free and lines are there, in cycles of the unit.
#[derive(Clone, Debug, Default)]
pub(super) struct Estimate {
    /// Of each traversal unit, when each of its stacks is free.
    stacks: Vec<Vec<u64>>,
    /// When lines come that are on the way: those of the traversal units and of the intersection
    /// units, by unit.
    coming: BTreeMap<(bool, u32, u32), u64>,
    /// When the next ray can be dispatched.
    dispatch: u64,
    /// When the pipelines have begun with all that has come.
    pipelines: u64,
}

impl Tni {
    /// Answers all submissions at once, and says when they would have been: the cycle of the unit in
    /// which the last ray of the last submission is back. A line from memory takes `latency` cycles.
    pub fn answer_by_estimate(
        &mut self,
        now: u64,
        latency: u64,
        memory: &SystemMemory,
        sram: &mut [u8],
    ) -> u64 {
        let (spec, tree) = (Arc::clone(&self.spec), self.tree);
        let mut tracer = Tracer::over(&spec, &tree, memory, self.decoded(memory));
        let mut estimate = std::mem::take(&mut self.estimate);
        estimate.begin(now, spec.trvs, spec.stacks);
        let visit = u64::from(spec.pre_latency + spec.trv_l1.latency + spec.post_latency);
        let boxes = u64::from(spec.aabb_latency) + 1;
        let test = u64::from(spec.ist_latency + spec.ist_l1.latency);
        let mut issued = vec![0u64; self.trvs.len()];
        let (mut tests, mut end) = (0u64, now);
        for order in 0..self.submissions.len() {
            if self.submissions[order].is_complete() {
                continue;
            }
            let (rays, count) = (self.submissions[order].rays, self.submissions[order].count);
            for ray in 0..count {
                let at = (rays + ray * RAY_BYTES) as usize;
                let source = read_ray(&sram[at..at + RAY_BYTES as usize]);
                let trv = self.next_trv;
                self.next_trv = (trv + 1) % self.trvs.len();
                let ist = trv % self.ists.len();
                let (stack, since) = estimate.dispatch(trv);
                let mut time = since;
                let traced = tracer.follow(&source, &mut |step| {
                    time += match step {
                        Step::Leaf => visit,
                        Step::Pair { address, bytes } => {
                            let lines = address / spec.trv_l1.line
                                ..=(address + bytes - 1) / spec.trv_l1.line;
                            for line in lines {
                                let level1 = &mut self.trvs[trv].fetch.cache;
                                let level2 = &mut self.level2.cache;
                                let address = line * spec.trv_l1.line / spec.trv_l2.line;
                                let key = (false, trv as u32, line);
                                time = estimate.wait(key, time, level1, line, || {
                                    let behind = look(level2, address);
                                    let more = if behind { 0 } else { latency };
                                    u64::from(spec.trv_l2.latency) + more
                                });
                            }
                            visit + boxes
                        }
                        Step::Triangle { address, bytes } => {
                            let lines = address / spec.ist_l1.line
                                ..=(address + bytes - 1) / spec.ist_l1.line;
                            for line in lines {
                                let cache = &mut self.ists[ist].fetch.cache;
                                let key = (true, ist as u32, line);
                                time = estimate.wait(key, time, cache, line, || latency);
                            }
                            test
                        }
                    };
                });
                estimate.stacks[trv][stack] = time;
                end = end.max(time);
                issued[trv] += u64::from(traced.inner_visits + traced.leaf_visits);
                tests += u64::from(traced.triangle_tests);
                self.counters.resident_cycles += time - since;
                self.trvs[trv].counters.inner_visits += u64::from(traced.inner_visits);
                self.trvs[trv].counters.leaf_visits += u64::from(traced.leaf_visits);
                self.ists[ist].tests += u64::from(traced.triangle_tests);
                self.counters.hits += u64::from(traced.hit.is_hit());
                self.counters.rays += 1;
                self.counters.results += 1;
                self.submissions[order].answer(ray, traced.hit, source.flags);
            }
            self.submissions[order].write_hits(sram);
        }
        self.estimate = estimate;
        let busiest = issued.into_iter().max().unwrap_or(0);
        let pipelines = busiest.max(tests / self.ists.len() as u64);
        self.estimate.pipelines = self.estimate.pipelines.max(now) + pipelines;
        end.max(self.estimate.pipelines)
    }
}

impl Estimate {
    fn begin(&mut self, now: u64, trvs: u32, stacks: u32) {
        if self.stacks.is_empty() {
            self.stacks = vec![vec![now; stacks as usize]; trvs as usize];
        }
        self.dispatch = self.dispatch.max(now);
        let now = self.dispatch;
        self.coming.retain(|_, &mut at| at > now);
    }

    /// The stack that the next ray gets, and the cycle in which it does.
    fn dispatch(&mut self, trv: usize) -> (usize, u64) {
        let free = self.stacks[trv].iter().enumerate();
        let (stack, &from) = free
            .min_by_key(|&(_, &at)| at)
            .expect("a traversal unit has stacks");
        let since = from.max(self.dispatch);
        self.dispatch = since + 1;
        (stack, since)
    }

    /// When a line is there that is asked for at `time`.
    fn wait(
        &mut self,
        key: (bool, u32, u32),
        time: u64,
        cache: &mut Cache,
        line: u32,
        behind: impl FnOnce() -> u64,
    ) -> u64 {
        match look(cache, line) {
            true => self.coming.get(&key).map_or(time, |&at| at.max(time)),
            false => {
                let at = time + behind();
                self.coming.insert(key, at);
                at
            }
        }
    }
}

/// Looks for a line, and puts it there.
fn look(cache: &mut Cache, line: u32) -> bool {
    match cache.access(line) {
        Access::Hit => true,
        _ => {
            cache.fill(line);
            false
        }
    }
}
