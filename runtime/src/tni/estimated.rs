//! The unit without contention: when a submission is back, by rays that go through the unit one by one.
//!
//! A ray takes a stack of its traversal unit as soon as one is free. A visit or a test takes as long as in
//! empty pipelines and caches. A line that misses comes from the level-2 cache or from memory after their
//! latencies, once for all rays that wait for it. The unit cannot be faster than its pipelines issue. The
//! estimate leaves out queueing: for pipelines, banks, misses and the bus.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use srp_archdesc::system::TniSpec;

use super::counters::TniCounters;
use super::decoded::Decoded;
use super::full::describe;
use super::function::{Step, Tracer};
use super::submission::Queue;
use super::{
    Buffers, Client, Finished, LineRequest, RAY_BYTES, SubmitError, Tree, WarmCaches, read_ray,
};
use crate::memory::SystemMemory;
use crate::memory::cache::{Access, Cache};

/// A line of a level-1 cache: of a traversal unit or an intersection unit, by its number, and the
/// line's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Line {
    Trv(usize, u32),
    Ist(usize, u32),
}

/// The unit without contention.
#[derive(Clone, Debug)]
pub struct Estimated {
    tree: Tree,
    /// The inner nodes, once they were read.
    decoded: Option<Arc<Decoded>>,
    queue: Queue,
    /// The first cycle in which each submission of the queue is back.
    back: VecDeque<u64>,
    /// The traversal unit of the next ray.
    next_trv: usize,
    paths: Paths,
    counters: TniCounters,
}

/// Stacks and caches: when each is free, and when lines come.
#[derive(Clone, Debug)]
struct Paths {
    spec: TniSpec,
    /// Cycles that a line from memory takes.
    latency: u64,
    level1: Vec<Cache>,
    level2: Cache,
    ists: Vec<Cache>,
    /// Of each traversal unit, when each of its stacks is free.
    stacks: Vec<Vec<u64>>,
    /// When lines come that are on the way.
    coming: BTreeMap<Line, u64>,
    /// When the next ray can be dispatched.
    dispatch: u64,
    /// When the pipelines have begun with all that has come.
    pipelines: u64,
    /// Lines that were read from memory.
    requests: VecDeque<(Client, u32)>,
}

impl Estimated {
    /// An idle unit over a tree, which takes at most `max_submissions` at once. A line from memory
    /// takes `latency` cycles.
    pub fn new(spec: &TniSpec, tree: Tree, max_submissions: u32, latency: u64) -> Estimated {
        let mut counters = TniCounters::default();
        (counters.trvs, counters.ists) = (spec.trvs.into(), spec.ists.into());
        Estimated {
            tree,
            decoded: None,
            queue: Queue::new(max_submissions),
            back: VecDeque::new(),
            next_trv: 0,
            paths: Paths::new(*spec, latency),
            counters,
        }
    }

    /// Takes a submission in cycle `now`, and answers it at once. Says when it is back: the first cycle
    /// after that in which its last ray is.
    ///
    /// # Errors
    ///
    /// The unit is full, or the buffers do not lie in the SRAM.
    pub fn submit(
        &mut self,
        now: u64,
        buffers: Buffers,
        memory: &SystemMemory,
        sram: &mut [u8],
    ) -> Result<u64, SubmitError> {
        let mut submission = self.queue.admit(buffers, sram.len())?;
        let decoded = (self.decoded)
            .get_or_insert_with(|| Decoded::shared(&self.paths.spec, &self.tree, memory));
        let spec = self.paths.spec;
        let mut tracer = Tracer::over(&spec, &self.tree, memory, Arc::clone(decoded));
        self.paths.begin(now);
        let (trvs, ists) = (self.paths.level1.len(), self.paths.ists.len());
        let mut issued = vec![0u64; trvs];
        let (mut tests, mut end) = (0u64, now);
        for ray in 0..buffers.count {
            let source = read_ray(sram, buffers.rays + ray * RAY_BYTES);
            let trv = self.next_trv;
            self.next_trv = (trv + 1) % trvs;
            let (stack, since) = self.paths.dispatch(trv);
            let mut time = since;
            let paths = &mut self.paths;
            let traced = tracer.follow(&source, &mut |step| {
                time = paths.step(trv, trv % ists, step, time);
            });
            self.paths.stacks[trv][stack] = time;
            end = end.max(time);
            issued[trv] += u64::from(traced.inner_visits + traced.leaf_visits);
            tests += u64::from(traced.triangle_tests);
            let counters = &mut self.counters;
            counters.unit.resident_cycles += time - since;
            counters.unit.hits += u64::from(traced.hit.is_hit());
            counters.unit.rays += 1;
            counters.unit.results += 1;
            counters.trv.inner_visits += u64::from(traced.inner_visits);
            counters.trv.leaf_visits += u64::from(traced.leaf_visits);
            counters.triangle_tests += u64::from(traced.triangle_tests);
            submission.answer(ray, traced.hit, source.flags);
        }
        submission.write_hits(sram);
        self.queue.push(submission);
        let busiest = issued.into_iter().max().unwrap_or(0);
        let pipelines = busiest.max(tests / ists as u64);
        self.paths.pipelines = self.paths.pipelines.max(now) + pipelines;
        let back = end.max(self.paths.pipelines) + 1;
        self.back.push_back(back);
        Ok(back)
    }

    /// The first cycle in which the oldest submission is back.
    pub fn back(&self) -> Option<u64> {
        self.back.front().copied()
    }

    /// Takes the oldest submission out of the unit, whose time [has come](Self::back).
    pub fn take_finished(&mut self) -> Option<Finished> {
        self.back.pop_front();
        self.queue.take_finished()
    }

    /// The next line that was read from memory; when it has come is in the estimate.
    pub fn take_request(&mut self) -> Option<LineRequest> {
        let (client, address) = self.paths.requests.pop_front()?;
        let bytes = match client {
            Client::TrvL2 => self.paths.spec.trv_l2.line,
            Client::IstL1(_) => self.paths.spec.ist_l1.line,
        };
        Some(LineRequest {
            client,
            address,
            bytes,
        })
    }

    /// Takes over the contents of these caches. Counts stay.
    pub fn hold(&mut self, caches: &WarmCaches) {
        let level1 = self.paths.level1.iter_mut().zip(&caches.level1);
        let ists = self.paths.ists.iter_mut().zip(&caches.ists);
        let level2 = (&mut self.paths.level2, &caches.level2);
        for (own, other) in level1.chain(ists).chain([level2]) {
            own.hold_lines_of(other);
        }
    }

    /// Counts of the unit so far: rays, visits, tests and caches.
    pub fn counters(&self) -> TniCounters {
        let paths = &self.paths;
        let spec = &paths.spec;
        let mut sum = TniCounters {
            trv_l2: paths.level2.counters,
            ..self.counters
        };
        for cache in &paths.level1 {
            sum.trv_l1.add(&cache.counters);
        }
        for cache in &paths.ists {
            sum.ist_l1.add(&cache.counters);
        }
        sum.bytes_read = sum.trv_l2.misses * u64::from(spec.trv_l2.line)
            + sum.ist_l1.misses * u64::from(spec.ist_l1.line);
        sum
    }

    /// Rays that have come and results that have gone so far.
    pub fn results(&self) -> u64 {
        self.counters.unit.rays + self.counters.unit.results
    }

    /// Describes in words what the unit waits for.
    pub fn describe_state(&self) -> String {
        describe(&self.queue, [0; 3])
    }
}

impl Paths {
    fn new(spec: TniSpec, latency: u64) -> Paths {
        Paths {
            latency,
            level1: vec![Cache::new(&spec.trv_l1); spec.trvs as usize],
            level2: Cache::new(&spec.trv_l2),
            ists: vec![Cache::new(&spec.ist_l1); spec.ists as usize],
            stacks: vec![vec![0; spec.stacks as usize]; spec.trvs as usize],
            coming: BTreeMap::new(),
            dispatch: 0,
            pipelines: 0,
            requests: VecDeque::new(),
            spec,
        }
    }

    fn begin(&mut self, now: u64) {
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

    /// When a ray of these units has made a step that it begins at `time`.
    fn step(&mut self, trv: usize, ist: usize, step: Step, mut time: u64) -> u64 {
        let TniSpec { trv_l1, ist_l1, .. } = self.spec;
        let visit = self.spec.pre_latency + trv_l1.latency + self.spec.post_latency;
        let visit = u64::from(visit);
        match step {
            Step::Leaf => time + visit,
            Step::Pair { address, bytes } => {
                let line = trv_l1.line;
                for number in address / line..=(address + bytes - 1) / line {
                    time = self.read_node(trv, number, time);
                }
                time + visit + u64::from(self.spec.aabb_latency) + 1
            }
            Step::Triangle { address, bytes } => {
                let line = ist_l1.line;
                for number in address / line..=(address + bytes - 1) / line {
                    time = self.read_triangle(ist, number, time);
                }
                time + u64::from(self.spec.ist_latency + ist_l1.latency)
            }
        }
    }

    /// When a line of nodes is there that a traversal unit asks for at `time`.
    fn read_node(&mut self, trv: usize, number: u32, time: u64) -> u64 {
        let key = Line::Trv(trv, number);
        if look_up(&mut self.level1[trv], number) {
            return self.has_come(key, time);
        }
        let spec = &self.spec;
        let number = number * spec.trv_l1.line / spec.trv_l2.line;
        let mut takes = u64::from(spec.trv_l2.latency);
        if !look_up(&mut self.level2, number) {
            takes += self.latency;
            let address = number * spec.trv_l2.line;
            self.requests.push_back((Client::TrvL2, address));
        }
        self.coming.insert(key, time + takes);
        time + takes
    }

    /// When a line of triangles is there that an intersection unit asks for at `time`.
    fn read_triangle(&mut self, ist: usize, number: u32, time: u64) -> u64 {
        let key = Line::Ist(ist, number);
        if look_up(&mut self.ists[ist], number) {
            return self.has_come(key, time);
        }
        let address = number * self.spec.ist_l1.line;
        self.requests
            .push_back((Client::IstL1(ist as u32), address));
        self.coming.insert(key, time + self.latency);
        time + self.latency
    }

    /// When a line of a cache is there, which may be on the way.
    fn has_come(&self, line: Line, time: u64) -> u64 {
        self.coming.get(&line).map_or(time, |&at| at.max(time))
    }
}

/// Looks for a line, and puts it there.
fn look_up(cache: &mut Cache, line: u32) -> bool {
    match cache.access(line) {
        Access::Hit => true,
        _ => {
            cache.fill(line);
            false
        }
    }
}
