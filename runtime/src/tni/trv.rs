//! A traversal unit: TRV_PRE, TRV_AABB and TRV_POST with their buffers (SGRT section 3.3.1,
//! Figure 4).
//!
//! A visit of an inner node reads its two children in TRV_PRE and tests both boxes in TRV_AABB, one
//! a cycle. Where the ray enters one of them it goes there; where it enters both or none, TRV_POST
//! pushes the farther or pops the stack. A leaf goes from TRV_PRE to the intersection unit, and the
//! ray comes back to TRV_POST.
//!
//! In the parallel form each sub-pipeline feeds only those that can come next. In the single form
//! they are one deep pipeline, and a ray passes through what it does not need.
//!
//! There may be several of each sub-pipeline in the parallel form. Each kind has one FIFO in front,
//! from which every sub-pipeline of the kind takes a ray a cycle, and the crossbar has these paths
//! only: RD→PRE, PRE→AABB, PRE→IST, AABB→PRE, AABB→POST, IST→POST,
//! POST→PRE, POST→SRP. In the single form the
//! last stage feeds IST and RD's FIFO instead, and IST comes back there.
//!
//! Nothing blocks: a ray that cannot leave, because the buffer behind is full, passes through its
//! pipeline again without work. So there is no circle of waiting.

use std::collections::VecDeque;

use serde::Serialize;
use srp_archdesc::system::{Pipeline, TniSpec};

use super::fetch::{Fetch, Need};
use super::pipe::Pipe;
use super::ray_state::{Phase, RayState};
use super::replay::Event;
use super::walk::{Next, StackCounters};
use super::{Context, Slot};

/// Where rays that leave a traversal unit go.
pub(super) struct Exits<'a> {
    /// Input buffer of the intersection unit, and its size.
    pub(super) ist: &'a mut VecDeque<Slot>,
    pub(super) ist_capacity: usize,
    /// Finished rays.
    pub(super) results: &'a mut VecDeque<Slot>,
    /// Byte addresses of lines that the level-1 cache asks for.
    pub(super) lines: &'a mut Vec<u32>,
}

/// A kind of sub-pipeline: those of the kind, and the FIFO in front of them.
#[derive(Clone, Debug)]
pub(super) struct Stage {
    pub(super) input: VecDeque<Slot>,
    pub(super) pipes: Vec<Pipe>,
}

impl Stage {
    fn new(count: u32, latency: u32, resident: usize) -> Stage {
        Stage {
            input: VecDeque::with_capacity(resident),
            pipes: vec![Pipe::new(latency, resident); count.max(1) as usize],
        }
    }
}

/// What a traversal unit did as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
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

impl TrvCounters {
    /// Adds what another unit did.
    pub fn add(&mut self, other: &TrvCounters) {
        self.inner_visits += other.inner_visits;
        self.leaf_visits += other.leaf_visits;
        self.busy_cycles += other.busy_cycles;
        self.idle_cycles += other.idle_cycles;
    }
}

/// A traversal unit.
#[derive(Clone, Debug)]
pub(super) struct Trv {
    /// Slots of rays that are not taken.
    pub(super) free: Vec<Slot>,
    /// The FIFO in front of TRV_PRE, with accumulation unit and cache.
    pub(super) fetch: Fetch,
    pub(super) pre: Vec<Pipe>,
    pub(super) aabb: Stage,
    pub(super) post: Stage,
    capacity: usize,
    pub(super) stacks: StackCounters,
    pub(super) counters: TrvCounters,
    resident: usize,
}

impl Trv {
    pub(super) fn new(spec: &TniSpec, slots: std::ops::Range<Slot>) -> Trv {
        let resident = slots.len();
        let pre = Pipe::new(spec.pre_latency + spec.trv_l1.latency, resident);
        Trv {
            // The lowest slot is taken first.
            free: slots.rev().collect(),
            fetch: Fetch::new((spec.rau_rows, spec.rau_rays), &spec.trv_l1, resident),
            pre: vec![pre; spec.pres.max(1) as usize],
            aabb: Stage::new(spec.aabbs, spec.aabb_latency, resident),
            post: Stage::new(spec.posts, spec.post_latency, resident),
            capacity: spec.fifo.max(1) as usize,
            stacks: StackCounters::default(),
            counters: TrvCounters::default(),
            resident,
        }
    }

    /// Whether it holds any ray, the intersection unit's visitors included.
    #[inline]
    pub(super) fn is_empty(&self) -> bool {
        self.free.len() == self.resident
    }

    /// Whether a ray can be dispatched to it.
    #[inline]
    pub(super) fn has_room(&self) -> bool {
        !self.free.is_empty() && self.fetch.input.len() < self.capacity
    }

    /// Whether a ray can come back from the intersection unit.
    pub(super) fn can_return(&self, pipeline: Pipeline) -> bool {
        let buffer = match pipeline {
            Pipeline::Single => &self.fetch.input,
            Pipeline::Parallel => &self.post.input,
        };
        buffer.len() < self.capacity
    }

    /// A ray comes back from the intersection unit.
    pub(super) fn come_back(&mut self, slot: Slot, ray: &mut RayState, pipeline: Pipeline) {
        ray.phase = Phase::Pop;
        ray.need_nothing();
        match pipeline {
            Pipeline::Single => self.fetch.input.push_back(slot),
            Pipeline::Parallel => self.post.input.push_back(slot),
        }
    }

    /// One cycle: rays leave the pipelines, then others enter them.
    pub(super) fn tick(
        &mut self,
        now: u64,
        rays: &mut [RayState],
        context: &Context<'_>,
        exits: &mut Exits<'_>,
    ) {
        if self.is_empty() {
            self.counters.idle_cycles += 1;
            return;
        }
        for i in 0..self.post.pipes.len() {
            if let Some(slot) = self.post.pipes[i].leave(now) {
                self.leave_post(now, i, slot, rays, context, exits);
            }
        }
        for i in 0..self.aabb.pipes.len() {
            if let Some(slot) = self.aabb.pipes[i].leave(now) {
                self.leave_aabb(now, i, slot, rays, context);
            }
        }
        for i in 0..self.pre.len() {
            if let Some(slot) = self.pre[i].leave(now) {
                self.leave_pre(now, i, slot, rays, context, exits);
            }
        }
        self.enter_post(now, rays, context);
        self.enter_aabb(now, rays, context);
        self.enter_pre(now, rays, context, exits);
        self.count(now);
    }

    #[inline]
    fn count(&mut self, now: u64) {
        let waits = self.fetch.waiting() > 0;
        self.fetch.count();
        let mut busy = false;
        for pipe in &mut self.pre {
            busy |= pipe.count(now, waits);
        }
        for pipe in self.aabb.pipes.iter_mut().chain(&mut self.post.pipes) {
            busy |= pipe.count(now, false);
        }
        self.counters.busy_cycles += u64::from(busy);
    }

    fn leave_post(
        &mut self,
        now: u64,
        pipe: usize,
        slot: Slot,
        rays: &mut [RayState],
        context: &Context<'_>,
        exits: &mut Exits<'_>,
    ) {
        let ray = &mut rays[slot as usize];
        match ray.next {
            Next::Finished => exits.results.push_back(slot),
            Next::Visit if self.fetch.input.len() < self.capacity => {
                context.begin_visit(ray);
                self.fetch.input.push_back(slot);
            }
            Next::Intersect if exits.ist.len() < exits.ist_capacity => {
                context.begin_leaf(now, ray);
                exits.ist.push_back(slot);
            }
            Next::Visit | Next::Intersect => self.post.pipes[pipe].recirculate(now, slot),
        }
    }

    fn leave_aabb(
        &mut self,
        now: u64,
        pipe: usize,
        slot: Slot,
        rays: &mut [RayState],
        context: &Context<'_>,
    ) {
        let ray = &mut rays[slot as usize];
        let to_pre = context.spec().pipeline == Pipeline::Parallel && ray.direct;
        let buffer = if to_pre {
            &mut self.fetch.input
        } else {
            &mut self.post.input
        };
        if buffer.len() >= self.capacity {
            return self.aabb.pipes[pipe].recirculate(now, slot);
        }
        if to_pre {
            context.begin_visit(ray);
        }
        buffer.push_back(slot);
    }

    fn leave_pre(
        &mut self,
        now: u64,
        pipe: usize,
        slot: Slot,
        rays: &mut [RayState],
        context: &Context<'_>,
        exits: &mut Exits<'_>,
    ) {
        let ray = &mut rays[slot as usize];
        let to_ist = context.spec().pipeline == Pipeline::Parallel && ray.walk.node.is_leaf();
        let (buffer, capacity) = if to_ist {
            (&mut *exits.ist, exits.ist_capacity)
        } else {
            (&mut self.aabb.input, self.capacity)
        };
        if buffer.len() >= capacity {
            return self.pre[pipe].recirculate(now, slot);
        }
        if to_ist {
            context.begin_leaf(now, ray);
        }
        buffer.push_back(slot);
    }

    fn enter_post(&mut self, now: u64, rays: &mut [RayState], context: &Context<'_>) {
        for pipe in &mut self.post.pipes {
            if !pipe.is_free(now) {
                continue;
            }
            let Some(slot) = self.post.input.pop_front() else {
                return;
            };
            let ray = &mut rays[slot as usize];
            let is_leaf = ray.walk.node.is_leaf();
            if ray.phase == Phase::Visit && ray.direct {
                pipe.bypass(now, slot);
                continue;
            }
            if ray.phase == Phase::Visit && is_leaf {
                ray.next = Next::Intersect;
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
    }

    fn enter_aabb(&mut self, now: u64, rays: &mut [RayState], context: &Context<'_>) {
        for pipe in &mut self.aabb.pipes {
            if !pipe.is_free(now) {
                continue;
            }
            let Some(slot) = self.aabb.input.pop_front() else {
                return;
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
    }

    fn enter_pre(
        &mut self,
        now: u64,
        rays: &mut [RayState],
        context: &Context<'_>,
        exits: &mut Exits<'_>,
    ) {
        let line = context.spec().trv_l1.line;
        for pipe in &mut self.pre {
            if !pipe.is_free(now) || self.fetch.is_empty() {
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
            context.log(now, slot, || Event::Visit {
                node,
                enter: ray.walk.enter,
            });
            pipe.issue(now, slot, 1);
        }
    }
}
