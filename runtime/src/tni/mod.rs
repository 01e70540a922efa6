//! The traversal and intersection unit, cycle by cycle (SGRT section 3.3, Figures 3 and 4).
//!
//! Rays come in submissions: a ray buffer and a hit buffer in the core's SRAM, and a count. The
//! ray dispatch unit takes one ray a cycle, in order, to a traversal unit (`trv`) that has a
//! stack for it; rays wander between traversal and intersection units (`ist`); one finished ray a
//! cycle goes back. When the last ray of a submission is back, its hits stand in the hit buffer in
//! four runs: shadow hits, shadow misses, other hits, other misses, each in the order of the rays.
//!
//! What a ray hits is decided by [`arithmetic`] alone. Time is counted in cycles of the unit's own
//! clock; the memory below the caches is the owner's business: [`Tni::take_request`] and
//! [`Tni::fill`].

pub mod arithmetic;
mod counters;
mod decoded;
mod estimate;
mod exact;
mod fetch;
mod function;
mod ist;
mod level2;
mod pipe;
mod ray_state;
mod recorded;
mod replay;
mod ring;
pub mod standalone;
mod submission;
mod tags;
mod tick;
mod trv;
mod untimed;
mod walk;

use std::cell::RefCell;
use std::collections::VecDeque;
use std::sync::Arc;

use srp_archdesc::system::TniSpec;

use self::arithmetic::{Hit, Prepared, Ray};
use self::decoded::Decoded;
use self::function::Function;
use self::ist::Ist;
use self::level2::Level2;
use self::ray_state::{Phase, RayState};
use self::submission::Submission;
use self::tick::Tick;
use self::trv::{Exits, Trv};
use crate::bvh::{NodeRef, TRIANGLE_BYTES};
use crate::memory::SystemMemory;

pub use counters::{DispatchAccount, TniCounters, UnitCounters};
pub use exact::{Exact, ExactRay, Meeting};
pub use fetch::RauCounters;
pub(crate) use function::Step;
pub use function::{Traced, Tracer};
pub use pipe::{PipeCounters, StallAccount};
pub use replay::{Event, Logged, RayCost};
pub use submission::{HitRecord, Runs, SubmitError};
pub(crate) use tags::{Misses, Tags};
pub use trv::TrvCounters;
pub use untimed::{RayCounts, Untimed};
pub use walk::StackCounters;

/// Bytes of a ray that the unit reads.
pub const RAY_BYTES: u32 = 64;

/// Bytes of a hit that the unit writes.
pub const HIT_BYTES: u32 = 24;

/// Number of a resident ray: traversal unit times stacks, plus stack.
type Slot = u16;

/// Where the tree of the scene lies in system memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tree {
    /// The root; `None` for a scene without triangles.
    pub root: Option<NodeRef>,
    /// Address of node 0.
    pub nodes: u32,
    /// Address of triangle record 0.
    pub triangles: u32,
}

/// Which cache of the unit talks to the memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Client {
    /// The level-2 cache of the traversal units.
    TrvL2,
    /// The level-1 cache of this intersection unit.
    IstL1(u32),
}

/// What all parts of the unit look at.
struct Context<'a> {
    function: Function<'a>,
    /// Where events are noted, if they are.
    log: Option<&'a RefCell<Vec<Logged>>>,
}

impl Context<'_> {
    #[inline]
    fn spec(&self) -> &TniSpec {
        self.function.spec
    }

    /// Notes an event of a resident ray, where somebody wants to know.
    #[inline]
    fn log(&self, cycle: u64, slot: Slot, event: impl FnOnce() -> Event) {
        if let Some(log) = self.log {
            let event = event();
            log.borrow_mut().push(Logged { cycle, slot, event });
        }
    }

    /// Prepares a ray for the visit of the node of its walk.
    fn begin_visit(&self, ray: &mut RayState) {
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
    fn begin_leaf(&self, now: u64, ray: &mut RayState) {
        ray.ist_since = now;
        ray.triangle = ray.walk.node.index;
        ray.triangles = ray.walk.node.count;
        self.begin_triangle(ray);
    }

    fn begin_triangle(&self, ray: &mut RayState) {
        let address = self.function.triangle_address(ray.triangle);
        let shift = self.spec().ist_l1.line.trailing_zeros();
        ray.need(address, TRIANGLE_BYTES, shift);
    }
}

/// The unit.
#[derive(Clone, Debug)]
pub struct Tni {
    spec: Arc<TniSpec>,
    tree: Tree,
    max_submissions: usize,
    trvs: Vec<Trv>,
    ists: Vec<Ist>,
    level2: Level2,
    rays: Vec<RayState>,
    results: VecDeque<Slot>,
    submissions: VecDeque<Submission>,
    /// Submissions that were finished and taken before the first of `submissions`.
    taken: u64,
    /// Submissions all of whose rays have been dispatched.
    dispatched: u64,
    next_trv: usize,
    requests: VecDeque<(Client, u32)>,
    lines: Vec<u32>,
    counters: UnitCounters,
    /// The cycle after the last.
    end: u64,
    /// What each ray cost, in the order of their return, where that is wanted.
    costs: Option<Vec<RayCost>>,
    /// The nodes, once rays are traced without the clock.
    decoded: Option<Arc<Decoded>>,
    /// When stacks and lines are free, where rays are not run cycle by cycle.
    estimate: estimate::Estimate,
    /// What happened to each ray, where that is wanted.
    log: Option<Vec<Logged>>,
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
            max_submissions: max_submissions.max(1) as usize,
            trvs: (0..spec.trvs).map(trv).collect(),
            ists: vec![Ist::new(spec, resident as usize); spec.ists as usize],
            level2: Level2::new(&spec.trv_l2),
            rays: vec![RayState::new(spec.stack_depth); resident as usize],
            results: VecDeque::with_capacity(resident as usize),
            submissions: VecDeque::new(),
            taken: 0,
            dispatched: 0,
            next_trv: 0,
            requests: VecDeque::new(),
            lines: Vec::new(),
            counters: UnitCounters::default(),
            end: 0,
            costs: None,
            decoded: None,
            estimate: estimate::Estimate::default(),
            log: None,
        }
    }

    /// The nodes, read where they were not yet.
    fn decoded(&mut self, memory: &SystemMemory) -> Arc<Decoded> {
        let function = Function {
            spec: &self.spec,
            tree: &self.tree,
            memory,
        };
        let decoded = (self.decoded).get_or_insert_with(|| Arc::new(Decoded::of(&function)));
        Arc::clone(decoded)
    }

    /// Takes a submission: `count` rays at `rays` in the SRAM, whose hits go to `hits`. The SRAM
    /// has `sram_bytes`.
    pub fn submit(
        &mut self,
        rays: u32,
        hits: u32,
        count: u32,
        sram_bytes: usize,
    ) -> Result<(), SubmitError> {
        if self.submissions.len() == self.max_submissions {
            return Err(SubmitError::Busy);
        }
        let submission = Submission::within(rays, hits, count, sram_bytes)?;
        self.submissions.push_back(submission);
        Ok(())
    }

    /// Takes the oldest submission out of the unit, where it is complete.
    pub fn take_finished(&mut self) -> Option<Runs> {
        let submission = self.submissions.pop_front_if(|s| s.is_complete())?;
        self.taken += 1;
        self.dispatched = self.dispatched.max(self.taken);
        Some(submission.runs())
    }

    /// The hits of the oldest submission, once it is finished.
    pub fn finished(&self) -> Option<&[HitRecord]> {
        let submission = self.submissions.front()?;
        submission.is_complete().then_some(&submission.records)
    }

    /// Submissions in the unit, finished ones included.
    pub fn submissions(&self) -> usize {
        self.submissions.len()
    }

    /// Rays that have been taken from submissions so far.
    pub fn rays(&self) -> u64 {
        self.counters.rays
    }

    /// Whether a cycle would do nothing but count.
    pub fn is_idle(&self) -> bool {
        self.submissions.iter().all(Submission::is_complete)
    }

    /// The next line to be read from memory: who reads it, its address and its size in bytes.
    pub fn take_request(&mut self) -> Option<(Client, u32, u32)> {
        let (client, address) = self.requests.pop_front()?;
        let line = match client {
            Client::TrvL2 => self.spec.trv_l2.line,
            Client::IstL1(_) => self.spec.ist_l1.line,
        };
        Some((client, address, line))
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

    /// Notes from now on what each ray costs.
    pub fn note_costs(&mut self) {
        self.costs.get_or_insert_default();
    }

    /// Whether nobody has asked for what each ray costs.
    pub fn counts_no_costs(&self) -> bool {
        self.costs.is_none()
    }

    /// What the rays cost that have come back since the last call, in the order of their return.
    pub fn take_costs(&mut self) -> Vec<RayCost> {
        self.costs.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Notes from now on everything that happens to a ray.
    pub fn note_events(&mut self) {
        self.log.get_or_insert_default();
    }

    /// What has happened since the last call.
    pub fn take_events(&mut self) -> Vec<Logged> {
        self.log.as_mut().map(std::mem::take).unwrap_or_default()
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
        let log = self.log.take().map(RefCell::new);
        let tree = self.tree;
        let spec = Arc::clone(&self.spec);
        let context = Context {
            function: Function {
                spec: &spec,
                tree: &tree,
                memory,
            },
            log: log.as_ref(),
        };
        self.tick_units(tick, &context);
        let requests = &mut self.requests;
        self.level2
            .tick(now, |address| requests.push_back((Client::TrvL2, address)));
        self.dispatch(tick, sram, &context);
        self.log = log.map(RefCell::into_inner);
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
            let order = (self.dispatched - self.taken) as usize;
            match self.submissions.get(order) {
                None => {
                    self.counters.dispatch.empty += 1;
                    return;
                }
                Some(s) if s.dispatched == s.count => self.dispatched += 1,
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
        // What is counted of this cycle is what the unit had before.
        self.trvs[trv].count_until(Tick {
            now: now + 1,
            index: tick.index + 1,
        });
        let slot = self.trvs[trv]
            .free
            .pop()
            .expect("a unit with room has a free slot");
        let submission = &mut self.submissions[order];
        let at = (submission.rays + submission.dispatched * RAY_BYTES) as usize;
        let source = read_ray(&sram[at..at + RAY_BYTES as usize]);
        let ray = &mut self.rays[slot as usize];
        ray.flags = source.flags;
        ray.hit = Hit::none(source.tmax);
        ray.triangles = 0;
        (ray.visits, ray.tests) = (0, 0);
        ray.submission = self.taken + order as u64;
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
        if let Some(log) = &mut self.log {
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
        if let Some(costs) = &mut self.costs {
            costs.push(RayCost {
                submission: ray.submission,
                index: ray.index,
                cycles: now - ray.since,
                visits: ray.visits,
                tests: ray.tests,
            });
        }
        let order = (ray.submission - self.taken) as usize;
        let submission = &mut self.submissions[order];
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

    /// What the unit did so far.
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

    /// Bytes of a line of the level-2 cache.
    pub fn line_bytes(&self) -> u32 {
        self.spec.trv_l2.line
    }

    /// Rays, visits, tests and caches so far, without the accounts of pipelines.
    pub fn progress(&self) -> TniCounters {
        TniCounters::progress(self)
    }

    /// Rays that have come and results that have gone so far: grows as long as the unit works.
    pub fn results(&self) -> u64 {
        self.counters.rays + self.counters.results
    }

    /// What it waits for, in words, for the report of a deadlock.
    pub fn describe_state(&self) -> String {
        let resident: usize = self
            .trvs
            .iter()
            .map(|t| self.spec.stacks as usize - t.free.len())
            .sum();
        let waiting: u32 = self.trvs.iter().map(|t| t.fetch.waiting()).sum();
        let in_ist: u32 = self.ists.iter().map(|i| i.fetch.waiting()).sum();
        format!(
            "{} submissions ({} complete), {resident} rays resident, {waiting} of them waiting \
             for nodes and {in_ist} for triangles",
            self.submissions.len(),
            self.submissions.iter().filter(|s| s.is_complete()).count(),
        )
    }
}

fn read_ray(bytes: &[u8]) -> Ray {
    let mut words = [0; 16];
    for (word, bytes) in words.iter_mut().zip(bytes.chunks_exact(4)) {
        *word = u32::from_le_bytes(bytes.try_into().expect("chunks of 4 bytes"));
    }
    Ray::from_words(words)
}
