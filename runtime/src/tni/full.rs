//! The unit, cycle by cycle.
//!
//! The ray dispatch unit takes one ray a cycle, in the order of submissions, to a traversal unit (`trv`)
//! that has a stack for it; rays go to and fro between traversal and intersection units (`ist`); one
//! finished ray a cycle goes back.

use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::sync::Arc;

use srp_archdesc::system::TniSpec;

use super::arithmetic::{Hit, Prepared};
use super::counters::TniCounters;
use super::function::Function;
use super::ist::Ist;
use super::level2::Level2;
use super::occupancy::Occupancy;
use super::ray_state::{Phase, RayState};
use super::replay::Recording;
use super::submission::Queue;
use super::tick::Tick;
use super::trv::{Exits, Trv};
use super::{
    Buffers, Client, Event, Finished, HitRecord, LineRequest, Logged, RAY_BYTES, RayCost, Slot,
    SubmitError, Tree, UnitCounters, Visited, WarmCaches, read_ray,
};
use crate::bvh::TRIANGLE_BYTES;
use crate::memory::SystemMemory;

/// The data that all parts of the unit read.
pub(super) struct Context<'a> {
    pub(super) function: Function<'a>,
    /// Where events are noted, if they are.
    log: Option<&'a RefCell<Vec<Logged>>>,
    /// Where visits are noted, if they are.
    visits: Option<&'a RefCell<Vec<Visited>>>,
}

impl Context<'_> {
    #[inline]
    pub(super) fn spec(&self) -> &TniSpec {
        self.function.spec
    }

    /// Notes an event of a resident ray, where somebody wants to know.
    #[inline]
    pub(super) fn log(&self, cycle: u64, slot: Slot, event: impl FnOnce() -> Event) {
        if let Some(log) = self.log {
            let event = event();
            log.borrow_mut().push(Logged { cycle, slot, event });
        }
    }

    /// Notes a visit, where somebody wants to know.
    #[inline]
    pub(super) fn visit(&self, visited: Visited) {
        if let Some(visits) = self.visits {
            visits.borrow_mut().push(visited);
        }
    }

    /// Prepares a ray for the visit of the node of its walk.
    pub(super) fn begin_visit(&self, ray: &mut RayState) {
        ray.phase = Phase::Visit;
        ray.direct = false;
        if ray.walk.node.is_leaf() {
            ray.need_nothing();
        } else {
            let address = self.function.pair_address(ray.walk.node.index);
            let shift = self.spec().trv_l1.line.trailing_zeros();
            ray.need(address, self.function.pair_bytes(), shift);
        }
    }

    /// Prepares a ray for the triangles of the leaf that it visits.
    pub(super) fn begin_leaf(&self, now: u64, ray: &mut RayState) {
        ray.ist_since = now;
        ray.triangle = ray.walk.node.index;
        ray.triangles = ray.walk.node.count;
        self.begin_triangle(ray);
    }

    pub(super) fn begin_triangle(&self, ray: &mut RayState) {
        let address = self.function.triangle_address(ray.triangle);
        let shift = self.spec().ist_l1.line.trailing_zeros();
        ray.need(address, TRIANGLE_BYTES, shift);
    }
}

/// What units share is kept as each's own.
mod shared {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::sync::Arc;

    pub(super) fn serialize<T: Serialize, S: Serializer>(
        of: &Arc<T>,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        T::serialize(of, to)
    }

    pub(super) fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Arc<T>, D::Error> {
        T::deserialize(from).map(Arc::new)
    }
}

/// The unit, cycle by cycle.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Tni {
    #[serde(with = "shared")]
    pub(super) spec: Arc<TniSpec>,
    tree: Tree,
    pub(super) trvs: Vec<Trv>,
    pub(super) ists: Vec<Ist>,
    pub(super) level2: Level2,
    rays: Vec<RayState>,
    results: VecDeque<Slot>,
    queue: Queue,
    /// Submissions all of whose rays have been dispatched.
    dispatched: u64,
    next_trv: usize,
    requests: VecDeque<(Client, u32)>,
    lines: Vec<u32>,
    pub(super) counters: UnitCounters,
    /// The cycle after the last.
    pub(super) end: u64,
    #[serde(skip)]
    recording: Recording,
}

impl Tni {
    /// An idle unit over a tree, which takes at most `max_submissions` at once.
    pub fn new(spec: &TniSpec, tree: Tree, max_submissions: u32) -> Tni {
        let resident = spec.trvs * spec.stacks;
        assert!(
            (1..=u32::from(Slot::MAX)).contains(&resident) && spec.ists > 0,
            "a T&I unit has units, and numbers its rays with 16 bits"
        );
        let trv = |i: u32| {
            let first = i * spec.stacks;
            Trv::new(spec, first as Slot..(first + spec.stacks) as Slot)
        };
        Tni {
            spec: Arc::new(*spec),
            tree,
            trvs: (0..spec.trvs).map(trv).collect(),
            ists: vec![Ist::new(spec, resident as usize); spec.ists as usize],
            level2: Level2::new(&spec.trv_l2),
            rays: vec![RayState::new(spec.stack_depth); resident as usize],
            results: VecDeque::with_capacity(resident as usize),
            queue: Queue::new(max_submissions),
            dispatched: 0,
            next_trv: 0,
            requests: VecDeque::new(),
            lines: Vec::new(),
            counters: UnitCounters::default(),
            end: 0,
            recording: Recording::default(),
        }
    }

    /// Takes a submission whose buffers lie in an SRAM of `sram_bytes`.
    ///
    /// # Errors
    ///
    /// The unit is full, or the buffers do not lie in the SRAM.
    pub fn submit(&mut self, buffers: Buffers, sram_bytes: usize) -> Result<(), SubmitError> {
        let submission = self.queue.admit(buffers, sram_bytes)?;
        self.queue.push(submission);
        Ok(())
    }

    /// Takes the oldest submission out of the unit, where it is complete.
    pub fn take_finished(&mut self) -> Option<Finished> {
        let finished = self.queue.take_finished()?;
        self.dispatched = self.dispatched.max(self.queue.taken());
        Some(finished)
    }

    /// Submissions in the unit, finished ones included.
    pub fn submissions(&self) -> usize {
        self.queue.len()
    }

    /// Rays that have been taken from submissions so far.
    pub fn rays(&self) -> u64 {
        self.counters.rays
    }

    /// Where its rays are.
    pub fn occupancy(&self) -> Occupancy {
        Occupancy {
            trvs: self.trvs.iter().map(Trv::occupancy).collect(),
            ists: self.ists.iter().map(Ist::occupancy).collect(),
        }
    }

    /// True if a cycle would do nothing but count.
    pub fn is_idle(&self) -> bool {
        self.queue.is_complete()
    }

    /// The next line to be read from memory; its owner has to [`fill`](Self::fill) it.
    pub fn take_request(&mut self) -> Option<LineRequest> {
        let (client, address) = self.requests.pop_front()?;
        let bytes = match client {
            Client::TrvL2 => self.spec.trv_l2.line,
            Client::IstL1(_) => self.spec.ist_l1.line,
        };
        Some(LineRequest {
            client,
            address,
            bytes,
        })
    }

    /// A line that was asked for arrives before cycle `now`.
    pub fn fill(&mut self, now: u64, client: Client, address: u32) {
        match client {
            Client::TrvL2 => self.level2.fill(now, address),
            Client::IstL1(i) => {
                let ist = &mut self.ists[i as usize];
                ist.count_until(Tick {
                    now,
                    index: self.counters.active_cycles,
                });
                ist.fill(now, address / self.spec.ist_l1.line);
            }
        }
    }

    /// Takes over the contents of these caches. Counts, and lines on their way, stay.
    pub fn hold(&mut self, caches: &WarmCaches) {
        for (trv, cache) in self.trvs.iter_mut().zip(&caches.level1) {
            trv.fetch.cache.hold_lines_of(cache);
        }
        self.level2.cache.hold_lines_of(&caches.level2);
        for (ist, cache) in self.ists.iter_mut().zip(&caches.ists) {
            ist.fetch.cache.hold_lines_of(cache);
        }
    }

    /// Goes on as another, but notes costs, visits and events as it did before.
    pub(super) fn go_on_as(&mut self, from: &Tni) {
        let recording = std::mem::take(&mut self.recording);
        self.clone_from(from);
        self.recording = recording;
    }

    /// Notes the cost of each ray from now on.
    pub fn note_costs(&mut self) {
        self.recording.costs.get_or_insert_default();
    }

    /// Takes the costs of the rays that have come back since the last call, in the order of their return.
    pub fn take_costs(&mut self) -> impl Iterator<Item = RayCost> {
        let costs = self.recording.costs.iter_mut();
        costs.flat_map(|costs| costs.drain(..))
    }

    /// Notes from now on what rays visit.
    pub fn note_visits(&mut self) {
        self.recording.visits.get_or_insert_default();
    }

    /// Gives what rays have visited since the last call, where they have visited anything.
    pub fn give_visits(&mut self, take: impl FnOnce(&[Visited])) {
        if let Some(visits) = &mut self.recording.visits
            && !visits.is_empty()
        {
            take(visits);
            visits.clear();
        }
    }

    /// Notes from now on everything that happens to a ray.
    pub fn note_events(&mut self) {
        self.recording.events.get_or_insert_default();
    }

    /// Takes the events since the last call.
    pub fn take_events(&mut self) -> Vec<Logged> {
        let events = self.recording.events.as_mut();
        events.map(std::mem::take).unwrap_or_default()
    }

    /// One cycle. Cycles are numbered from anywhere, ascending; those in which the unit
    /// [is idle](Self::is_idle) may be left out.
    pub fn tick(&mut self, now: u64, memory: &SystemMemory, sram: &mut [u8]) {
        let index = self.counters.active_cycles;
        self.counters.active_cycles += 1;
        self.end = now + 1;
        let tick = Tick { now, index };
        self.give_back(tick, sram);
        while let Some((trv, address)) = self.level2.answer(now) {
            let line = address / self.spec.trv_l1.line;
            let trv = &mut self.trvs[trv as usize];
            trv.count_until(tick);
            trv.fill(now, line);
        }
        let log = self.recording.events.take().map(RefCell::new);
        let visits = self.recording.visits.take().map(RefCell::new);
        let tree = self.tree;
        let spec = Arc::clone(&self.spec);
        let context = Context {
            function: Function {
                spec: &spec,
                tree: &tree,
                memory,
            },
            log: log.as_ref(),
            visits: visits.as_ref(),
        };
        self.tick_units(tick, &context);
        let requests = &mut self.requests;
        self.level2
            .tick(now, |address| requests.push_back((Client::TrvL2, address)));
        self.dispatch(tick, sram, &context);
        self.recording.events = log.map(RefCell::into_inner);
        self.recording.visits = visits.map(RefCell::into_inner);
    }

    fn tick_units(&mut self, tick: Tick, context: &Context<'_>) {
        for (i, ist) in self.ists.iter_mut().enumerate() {
            if ist.wakes > tick.now {
                continue;
            }
            ist.tick(
                tick,
                &mut self.rays,
                context,
                &mut self.trvs,
                &mut self.lines,
            );
            let client = Client::IstL1(i as u32);
            self.requests
                .extend(self.lines.drain(..).map(|address| (client, address)));
        }
        for (i, trv) in self.trvs.iter_mut().enumerate() {
            if trv.wakes > tick.now {
                continue;
            }
            let mut exits = Exits {
                ists: &mut self.ists,
                results: &mut self.results,
                lines: &mut self.lines,
            };
            trv.tick(tick, &mut self.rays, context, &mut exits);
            for address in self.lines.drain(..) {
                self.level2.request(i as u32, address);
            }
        }
    }

    /// Ray dispatch: the next ray of the oldest submission that has one, to the next traversal
    /// unit in turn that has room.
    fn dispatch(&mut self, tick: Tick, sram: &[u8], context: &Context<'_>) {
        let now = tick.now;
        let order = loop {
            let order = (self.dispatched - self.queue.taken()) as usize;
            match self.queue.get(order) {
                None => {
                    self.counters.dispatch.empty += 1;
                    return;
                }
                Some(s) if s.dispatched == s.buffers.count => self.dispatched += 1,
                Some(_) => break order,
            }
        };
        if self.counters.rays - self.counters.results == self.rays.len() as u64 {
            self.counters.dispatch.full += 1;
            return;
        }
        let count = self.trvs.len();
        let mut in_turn = (self.next_trv..count).chain(0..self.next_trv);
        let Some(trv) = in_turn.find(|&i| self.trvs[i].has_room()) else {
            self.counters.dispatch.full += 1;
            return;
        };
        self.next_trv = if trv + 1 == count { 0 } else { trv + 1 };
        // The counts of this cycle are of the rays that the unit had before.
        self.trvs[trv].count_until(Tick {
            now: now + 1,
            index: tick.index + 1,
        });
        let slot = self.trvs[trv]
            .free
            .pop()
            .expect("a unit with room has a free slot");
        let taken = self.queue.taken();
        let submission = &mut self.queue[order];
        let at = submission.buffers.rays + submission.dispatched * RAY_BYTES;
        let source = read_ray(sram, at);
        let ray = &mut self.rays[slot as usize];
        ray.flags = source.flags;
        ray.hit = Hit::none(source.tmax);
        ray.triangles = 0;
        (ray.visits, ray.tests) = (0, 0);
        ray.submission = taken + order as u64;
        ray.index = submission.dispatched;
        ray.since = now;
        submission.dispatched += 1;
        self.counters.rays += 1;
        self.counters.dispatch.work += 1;
        context.log(now, slot, || Event::Dispatch { trv: trv as u32 });
        match (Prepared::of(&source), self.tree.root) {
            (Some(prepared), Some(root)) => {
                ray.ray = prepared;
                ray.walk.start(root);
                context.begin_visit(ray);
                self.trvs[trv].arrive(now, slot);
            }
            (prepared, _) => {
                self.counters.void_rays += u64::from(prepared.is_none());
                self.results.push_back(slot);
            }
        }
    }

    /// One finished ray a cycle goes back to the SRP.
    fn give_back(&mut self, tick: Tick, sram: &mut [u8]) {
        let now = tick.now;
        let Some(slot) = self.results.pop_front() else {
            return;
        };
        let ray = &self.rays[slot as usize];
        if let Some(log) = &mut self.recording.events {
            let hit = ray.hit.is_hit().then_some((ray.hit.primitive, ray.hit.t));
            let event = Event::Result { hit };
            log.push(Logged {
                cycle: now,
                slot,
                event,
            });
        }
        self.counters.hits += u64::from(ray.hit.is_hit());
        self.counters.results += 1;
        self.counters.resident_cycles += now - ray.since;
        if let Some(costs) = &mut self.recording.costs {
            costs.push(RayCost {
                submission: ray.submission,
                index: ray.index,
                cycles: now - ray.since,
                visits: ray.visits,
                tests: ray.tests,
            });
        }
        let order = (ray.submission - self.queue.taken()) as usize;
        let submission = &mut self.queue[order];
        submission.records.push(HitRecord {
            hit: ray.hit,
            ray: ray.index,
            flags: ray.flags,
        });
        if submission.is_complete() {
            submission.write_hits(sram);
        }
        let trv = slot as usize / self.spec.stacks as usize;
        self.trvs[trv].count_until(tick);
        self.trvs[trv].free.push(slot);
    }

    /// Counts of the unit so far.
    pub fn counters(&self) -> TniCounters {
        let mut tni = self.clone();
        let end = Tick {
            now: tni.end,
            index: tni.counters.active_cycles,
        };
        tni.trvs.iter_mut().for_each(|trv| trv.count_until(end));
        tni.ists.iter_mut().for_each(|ist| ist.count_until(end));
        TniCounters::of(&tni)
    }

    /// Rays, visits, tests and caches so far, without the accounts of pipelines.
    pub fn progress(&self) -> TniCounters {
        TniCounters::progress(self)
    }

    /// Rays that have come and results that have gone so far: grows as long as the unit works.
    pub fn results(&self) -> u64 {
        self.counters.rays + self.counters.results
    }

    /// Describes in words what the unit waits for, for the report of a deadlock.
    pub fn describe_state(&self) -> String {
        let resident: usize = self
            .trvs
            .iter()
            .map(|t| self.spec.stacks as usize - t.free.len())
            .sum();
        let waiting: u32 = self.trvs.iter().map(|t| t.fetch.waiting()).sum();
        let in_ist: u32 = self.ists.iter().map(|i| i.fetch.waiting()).sum();
        describe(&self.queue, [resident as u32, waiting, in_ist])
    }
}

/// Describes in words what a unit waits for: its submissions; and the rays in it, those that wait for nodes,
/// and those that wait for triangles.
pub(super) fn describe(queue: &Queue, [resident, for_nodes, for_triangles]: [u32; 3]) -> String {
    format!(
        "{} submissions ({} complete), {resident} rays resident, {for_nodes} of them waiting for \
         nodes and {for_triangles} for triangles",
        queue.len(),
        queue.complete(),
    )
}
