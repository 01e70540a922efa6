//! A traversal unit: TRV_PRE, TRV_AABB and TRV_POST with their buffers (SGRT section 3.3.1,
//! Figure 4).
//!
//! A visit of an inner node reads its two children in TRV_PRE and tests both boxes in TRV_AABB, one
//! a cycle. Where the ray enters one of them it goes there; where it enters both or none, TRV_POST
//! pushes the farther or pops the stack. A leaf goes from TRV_PRE to the intersection unit, and the
//! ray comes back to TRV_POST.
//!
//! In the parallel form each sub-pipeline feeds only those that can come next. In the single form
//! they are one deep pipeline, and a ray passes through stages that it does not need.
//!
//! There may be several of each sub-pipeline in the parallel form. Each kind has one FIFO in front,
//! from which every sub-pipeline of the kind takes a ray a cycle, and the crossbar has these paths
//! only: RD→PRE, PRE→AABB, PRE→IST, AABB→PRE, AABB→POST, IST→POST,
//! POST→PRE, POST→SRP. In the single form the
//! last stage feeds IST and RD's FIFO instead, and IST comes back there.
//!
//! Nothing blocks: a ray that cannot leave, because the buffer behind is full, passes through its
//! pipeline again without work. So there is no circle of waiting.

use schemars::JsonSchema;
use std::collections::VecDeque;

use serde::{Deserialize, Serialize};
use srp_archdesc::system::{Pipeline, TniSpec};

use super::fetch::{Fetch, Need};
use super::ist::Ist;
use super::occupancy::TrvOccupancy;
use super::pipe::Pipes;
use super::ray_state::{Phase, RayState};
use super::replay::{Event, Visited};
use super::ring::Ring;
use super::tick::{Counted, Tick};
use super::walk::{Next, StackCounters};
use super::{Context, Slot};
use crate::sums::sums;

/// Where rays that leave a traversal unit go.
pub(super) struct Exits<'a> {
    /// The intersection units; the least busy takes a leaf.
    pub(super) ists: &'a mut [Ist],
    /// Finished rays.
    pub(super) results: &'a mut VecDeque<Slot>,
    /// Byte addresses of lines that the level-1 cache asks for.
    pub(super) lines: &'a mut Vec<u32>,
}

impl Exits<'_> {
    /// An intersection unit that can take a ray, if one can.
    fn ist(&mut self) -> Option<&mut Ist> {
        let ist = self.ists.iter_mut().min_by_key(|i| i.fetch.input.len())?;
        (ist.fetch.input.len() < ist.capacity).then_some(ist)
    }
}

/// A kind of sub-pipeline: those of the kind, and the FIFO in front of them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Stage {
    pub(super) input: Ring<Slot>,
    pub(super) pipes: Pipes,
}

impl Stage {
    fn new(count: u32, latency: u32, resident: usize) -> Stage {
        Stage {
            input: Ring::new(resident),
            pipes: Pipes::new(count, latency, resident),
        }
    }
}

/// Counts of a traversal unit as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct TrvCounters {
    /// Visits of inner nodes.
    pub inner_visits: u64,
    /// Visits of leaves.
    pub leaf_visits: u64,
    /// Cycles in which a ray was in any of its pipelines.
    pub busy_cycles: u64,
    /// Cycles in which it had no ray at all.
    pub idle_cycles: u64,
}

sums!(TrvCounters: inner_visits leaf_visits busy_cycles idle_cycles);

/// A traversal unit.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Trv {
    /// Slots of rays that are not taken.
    pub(super) free: Vec<Slot>,
    /// The FIFO in front of TRV_PRE, with accumulation unit and cache.
    pub(super) fetch: Fetch,
    pub(super) pre: Pipes,
    pub(super) aabb: Stage,
    pub(super) post: Stage,
    capacity: usize,
    pub(super) stacks: StackCounters,
    pub(super) counters: TrvCounters,
    resident: usize,
    /// Before this cycle nothing happens here, unless something comes from outside.
    pub(super) wakes: u64,
    counted: Counted,
}

impl Trv {
    /// A unit with a stack for each of these slots.
    pub(super) fn new(spec: &TniSpec, mut slots: std::ops::Range<Slot>) -> Trv {
        let most = spec.most_in_flight().min(u32::from(Slot::MAX)) as usize;
        slots.end = slots.start + slots.len().min(most) as Slot;
        let resident = slots.len();
        let pre_latency = spec.pre_latency + spec.trv_l1.latency;
        Trv {
            // The lowest slot is taken first.
            free: slots.rev().collect(),
            fetch: Fetch::new((spec.rau_rows, spec.rau_rays), &spec.trv_l1, resident),
            pre: Pipes::new(spec.pres, pre_latency, resident),
            aabb: Stage::new(spec.aabbs, spec.aabb_latency, resident),
            post: Stage::new(spec.posts, spec.post_latency, resident),
            capacity: spec.fifo.max(1) as usize,
            stacks: StackCounters::default(),
            counters: TrvCounters::default(),
            resident,
            wakes: u64::MAX,
            counted: Counted::default(),
        }
    }

    /// Where its rays are.
    pub(super) fn occupancy(&self) -> TrvOccupancy {
        TrvOccupancy {
            resident: self.resident as u32,
            fifo: self.fetch.input.len() as u32,
            rau: self.fetch.waiting(),
            pre: self.pre.rays(),
            aabb: self.aabb.pipes.rays(),
            post: self.post.pipes.rays(),
        }
    }

    /// True if it holds no ray, the intersection unit's visitors included.
    #[inline]
    pub(super) fn is_empty(&self) -> bool {
        self.free.len() == self.resident
    }

    /// True if a ray can be dispatched to it.
    #[inline]
    pub(super) fn has_room(&self) -> bool {
        !self.free.is_empty() && self.fetch.input.len() < self.capacity
    }

    /// True if a ray can come back from the intersection unit.
    pub(super) fn can_return(&self, pipeline: Pipeline) -> bool {
        let buffer = match pipeline {
            Pipeline::Single => &self.fetch.input,
            Pipeline::Parallel => &self.post.input,
        };
        buffer.len() < self.capacity
    }

    /// A ray comes from dispatch in cycle `now`, to be visible in the next.
    pub(super) fn arrive(&mut self, now: u64, slot: Slot) {
        self.fetch.input.push_back(slot);
        self.wakes = self.wakes.min(now + 1);
    }

    /// A ray comes back from the intersection unit in cycle `now`.
    pub(super) fn come_back(
        &mut self,
        now: u64,
        slot: Slot,
        ray: &mut RayState,
        pipeline: Pipeline,
    ) {
        self.wakes = self.wakes.min(now);
        ray.phase = Phase::Pop;
        ray.need_nothing();
        match pipeline {
            Pipeline::Single => self.fetch.input.push_back(slot),
            Pipeline::Parallel => self.post.input.push_back(slot),
        }
    }

    /// A line arrives before cycle `now`.
    pub(super) fn fill(&mut self, now: u64, line: u32) {
        self.wakes = self.wakes.min(now);
        self.fetch.fill(line);
    }

    /// Counts the cycles before `tick` that are not counted yet. Call it before any change that would count
    /// them otherwise.
    #[inline]
    pub(super) fn count_until(&mut self, tick: Tick) {
        let Some((first, cycles)) = self.counted.until(tick) else {
            return;
        };
        if self.is_empty() {
            self.counters.idle_cycles += cycles;
            return;
        }
        let (aabb, post) = (&self.aabb.pipes, &self.post.pipes);
        if !(self.pre.is_empty() && aabb.is_empty() && post.is_empty()) {
            self.counters.busy_cycles += cycles;
        }
        if self.fetch.waiting() > 0 {
            self.fetch.count(cycles);
            self.pre.wait(first, cycles);
        }
    }

    /// When something can happen here after cycle `now`, if nothing comes from outside.
    #[inline]
    fn next_event(&self, now: u64) -> u64 {
        let stage = |stage: &Stage| stage.pipes.next_event(now, !stage.input.is_empty());
        let pre = self.pre.next_event(now, self.fetch.has_work());
        pre.min(stage(&self.aabb)).min(stage(&self.post))
    }

    /// One cycle: rays leave the pipelines, then others enter them. It may be left out before
    /// [`wakes`](Self::wakes).
    pub(super) fn tick(
        &mut self,
        tick: Tick,
        rays: &mut [RayState],
        context: &Context<'_>,
        exits: &mut Exits<'_>,
    ) {
        self.count_until(tick);
        let now = tick.now;
        if self.post.pipes.leave(now) {
            self.leave_post(now, rays, context, exits);
        }
        if self.aabb.pipes.leave(now) {
            self.leave_aabb(now, rays, context);
        }
        if self.pre.leave(now) {
            self.leave_pre(now, rays, context, exits);
        }
        if !self.post.input.is_empty() && self.post.pipes.take(now) {
            self.enter_post(now, rays, context);
        }
        if !self.aabb.input.is_empty() && self.aabb.pipes.take(now) {
            self.enter_aabb(now, rays, context);
        }
        if self.fetch.has_work() && self.pre.take(now) {
            self.enter_pre(now, rays, context, exits);
        }
        self.wakes = self.next_event(now);
    }

    fn leave_post(
        &mut self,
        now: u64,
        rays: &mut [RayState],
        context: &Context<'_>,
        exits: &mut Exits<'_>,
    ) {
        let pipes = &mut self.post.pipes;
        for pipe in pipes.each() {
            let Some(slot) = pipe.leave(now) else {
                continue;
            };
            let ray = &mut rays[slot as usize];
            match ray.next {
                Next::Finished => exits.results.push_back(slot),
                Next::Visit if self.fetch.input.len() < self.capacity => {
                    context.begin_visit(ray);
                    self.fetch.input.push_back(slot);
                }
                Next::Intersect if let Some(ist) = exits.ist() => {
                    context.begin_leaf(now, ray);
                    ist.arrive(now, slot);
                }
                Next::Visit | Next::Intersect => pipe.recirculate(now, slot),
            }
        }
        pipes.changed();
    }

    fn leave_aabb(&mut self, now: u64, rays: &mut [RayState], context: &Context<'_>) {
        let pipes = &mut self.aabb.pipes;
        for pipe in pipes.each() {
            let Some(slot) = pipe.leave(now) else {
                continue;
            };
            let ray = &mut rays[slot as usize];
            let to_pre = context.spec().pipeline == Pipeline::Parallel && ray.direct;
            let buffer = match to_pre {
                true => &mut self.fetch.input,
                false => &mut self.post.input,
            };
            if buffer.len() >= self.capacity {
                pipe.recirculate(now, slot);
                continue;
            }
            if to_pre {
                context.begin_visit(ray);
            }
            buffer.push_back(slot);
        }
        pipes.changed();
    }

    fn leave_pre(
        &mut self,
        now: u64,
        rays: &mut [RayState],
        context: &Context<'_>,
        exits: &mut Exits<'_>,
    ) {
        for pipe in self.pre.each() {
            let Some(slot) = pipe.leave(now) else {
                continue;
            };
            let ray = &mut rays[slot as usize];
            let to_ist = context.spec().pipeline == Pipeline::Parallel && ray.walk.node.is_leaf();
            if to_ist && let Some(ist) = exits.ist() {
                context.begin_leaf(now, ray);
                ist.arrive(now, slot);
            } else if !to_ist && self.aabb.input.len() < self.capacity {
                self.aabb.input.push_back(slot);
            } else {
                pipe.recirculate(now, slot);
            }
        }
        self.pre.changed();
    }

    fn enter_post(&mut self, now: u64, rays: &mut [RayState], context: &Context<'_>) {
        let pipes = &mut self.post.pipes;
        for pipe in pipes.each() {
            if !pipe.is_free(now) {
                continue;
            }
            let Some(slot) = self.post.input.pop_front() else {
                break;
            };
            let ray = &mut rays[slot as usize];
            let is_leaf = ray.walk.node.is_leaf();
            if ray.phase == Phase::Visit && (ray.direct || is_leaf) {
                if !ray.direct {
                    ray.next = Next::Intersect;
                }
                pipe.bypass(now, slot);
                continue;
            }
            let (next, popped) = if ray.phase == Phase::Visit {
                ray.walk
                    .descend(ray.children, ray.enter, ray.hit.t, &mut self.stacks)
            } else if context.function.is_settled(ray.flags, &ray.hit) {
                (Next::Finished, 0)
            } else {
                ray.walk.pop(ray.hit.t, &mut self.stacks)
            };
            ray.next = next;
            context.log(now, slot, || Event::Post {
                popped,
                finished: next == Next::Finished,
            });
            // The stack gives one entry a cycle.
            pipe.issue(now, slot, u64::from(popped.max(1)));
        }
        pipes.changed();
    }

    fn enter_aabb(&mut self, now: u64, rays: &mut [RayState], context: &Context<'_>) {
        let pipes = &mut self.aabb.pipes;
        for pipe in pipes.each() {
            if !pipe.is_free(now) {
                continue;
            }
            let Some(slot) = self.aabb.input.pop_front() else {
                break;
            };
            let ray = &mut rays[slot as usize];
            if ray.phase == Phase::Pop || ray.walk.node.is_leaf() {
                pipe.bypass(now, slot);
                continue;
            }
            let found = context.function.boxes(ray.walk.node, &ray.ray, ray.hit.t);
            (ray.children, ray.enter) = found;
            ray.direct = ray.walk.is_direct(found.1);
            if ray.direct {
                let (children, enter) = found;
                (ray.next, _) = ray
                    .walk
                    .descend(children, enter, ray.hit.t, &mut self.stacks);
            }
            context.log(now, slot, || Event::Boxes {
                children: found.0,
                enter: found.1,
            });
            // Two boxes, one a cycle.
            pipe.issue(now, slot, 2);
        }
        pipes.changed();
    }

    fn enter_pre(
        &mut self,
        now: u64,
        rays: &mut [RayState],
        context: &Context<'_>,
        exits: &mut Exits<'_>,
    ) {
        let line = context.spec().trv_l1.line;
        for pipe in self.pre.each() {
            if !pipe.is_free(now) || !self.fetch.has_work() {
                continue;
            }
            let need = |slot: Slot| -> Need { rays[slot as usize].needs() };
            let request = |number: u32| exits.lines.push(number * line);
            let Some(slot) = self.fetch.tick(need, request) else {
                continue;
            };
            let ray = &mut rays[slot as usize];
            if !ray.got_line() {
                // The rest of the node lies in another line.
                self.fetch.input.push_front(slot);
                continue;
            }
            if ray.phase == Phase::Pop {
                pipe.bypass(now, slot);
                continue;
            }
            ray.visits += 1;
            let node = ray.walk.node;
            if node.is_leaf() {
                self.counters.leaf_visits += 1;
            } else {
                self.counters.inner_visits += 1;
            }
            context.visit(Visited::Node(node));
            context.log(now, slot, || Event::Visit {
                node,
                enter: ray.walk.enter,
            });
            pipe.issue(now, slot, 1);
        }
        self.pre.changed();
    }
}
