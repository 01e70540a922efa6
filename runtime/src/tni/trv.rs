//! A traversal unit: TRV_PRE, TRV_AABB and TRV_POST with their buffers (SGRT section 3.3.1,
//! Figure 4).
//!
//! A visit of an inner node reads its two children in TRV_PRE, tests both boxes in TRV_AABB, one a
//! cycle, and goes to the nearer in TRV_POST, which keeps the stack. A leaf goes from TRV_PRE to
//! the intersection unit, and the ray comes back to TRV_POST.
//!
//! In the parallel form each sub-pipeline feeds only those that can come next. In the single form
//! they are one deep pipeline, and a ray passes through what it does not need.
//!
//! Nothing blocks: a ray that cannot leave, because the buffer behind is full, passes through its
//! pipeline again without work. So there is no circle of waiting.

use std::collections::VecDeque;

use srp_archdesc::system::{Pipeline, TniSpec};

use super::fetch::{Fetch, Need};
use super::pipe::Pipe;
use super::ray_state::{Phase, RayState};
use super::walk::{Next, StackCounters};
use super::{Context, Slot};
use crate::bvh::PairRecord;

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

/// A traversal unit.
#[derive(Clone, Debug)]
pub(super) struct Trv {
    /// Slots of rays that are not taken.
    pub(super) free: Vec<Slot>,
    pub(super) fetch: Fetch,
    pub(super) pre: Pipe,
    pub(super) aabb: Pipe,
    pub(super) post: Pipe,
    /// Between TRV_PRE and TRV_AABB, and in front of TRV_POST.
    aabb_input: VecDeque<Slot>,
    pub(super) post_input: VecDeque<Slot>,
    capacity: usize,
    pub(super) stacks: StackCounters,
    pub(super) inner_visits: u64,
    pub(super) leaf_visits: u64,
    resident: usize,
}

impl Trv {
    pub(super) fn new(spec: &TniSpec, slots: std::ops::Range<Slot>) -> Trv {
        let resident = slots.len();
        Trv {
            // The lowest slot is taken first.
            free: slots.rev().collect(),
            fetch: Fetch::new(spec.rau_rows, &spec.trv_l1, resident),
            pre: Pipe::new(spec.pre_latency + spec.trv_l1.latency, resident),
            aabb: Pipe::new(spec.aabb_latency, resident),
            post: Pipe::new(spec.post_latency, resident),
            aabb_input: VecDeque::with_capacity(resident),
            post_input: VecDeque::with_capacity(resident),
            capacity: spec.fifo.max(1) as usize,
            stacks: StackCounters::default(),
            inner_visits: 0,
            leaf_visits: 0,
            resident,
        }
    }

    /// Whether it holds any ray, the intersection unit's visitors included.
    pub(super) fn is_empty(&self) -> bool {
        self.free.len() == self.resident
    }

    /// Whether a ray can be dispatched to it.
    pub(super) fn has_room(&self) -> bool {
        !self.free.is_empty() && self.fetch.input.len() < self.capacity
    }

    /// Whether a ray can come back from the intersection unit.
    pub(super) fn can_return(&self, pipeline: Pipeline) -> bool {
        let buffer = match pipeline {
            Pipeline::Single => &self.fetch.input,
            Pipeline::Parallel => &self.post_input,
        };
        buffer.len() < self.capacity
    }

    /// A ray comes back from the intersection unit.
    pub(super) fn come_back(&mut self, slot: Slot, ray: &mut RayState, pipeline: Pipeline) {
        ray.phase = Phase::Pop;
        ray.need_nothing();
        match pipeline {
            Pipeline::Single => self.fetch.input.push_back(slot),
            Pipeline::Parallel => self.post_input.push_back(slot),
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
            return;
        }
        self.leave_post(now, rays, context, exits);
        self.leave_aabb(now);
        self.leave_pre(now, rays, context, exits);
        self.enter_post(now, rays);
        self.enter_aabb(now, rays, context);
        self.enter_pre(now, rays, context, exits);
        self.pre.count();
        self.aabb.count();
        self.post.count();
    }

    fn leave_post(
        &mut self,
        now: u64,
        rays: &mut [RayState],
        context: &Context<'_>,
        exits: &mut Exits<'_>,
    ) {
        let Some(slot) = self.post.leave(now) else {
            return;
        };
        let ray = &mut rays[slot as usize];
        match ray.next {
            Next::Finished => exits.results.push_back(slot),
            Next::Visit if self.fetch.input.len() < self.capacity => {
                context.begin_visit(ray);
                self.fetch.input.push_back(slot);
            }
            Next::Intersect if exits.ist.len() < exits.ist_capacity => {
                exits.ist.push_back(slot);
            }
            Next::Visit | Next::Intersect => self.post.recirculate(now, slot),
        }
    }

    fn leave_aabb(&mut self, now: u64) {
        if let Some(slot) = self.aabb.leave(now) {
            if self.post_input.len() < self.capacity {
                self.post_input.push_back(slot);
            } else {
                self.aabb.recirculate(now, slot);
            }
        }
    }

    fn leave_pre(
        &mut self,
        now: u64,
        rays: &mut [RayState],
        context: &Context<'_>,
        exits: &mut Exits<'_>,
    ) {
        let Some(slot) = self.pre.leave(now) else {
            return;
        };
        let ray = &mut rays[slot as usize];
        let to_ist = context.spec.pipeline == Pipeline::Parallel && ray.walk.node.is_leaf();
        let (buffer, capacity) = if to_ist {
            (&mut *exits.ist, exits.ist_capacity)
        } else {
            (&mut self.aabb_input, self.capacity)
        };
        if buffer.len() >= capacity {
            return self.pre.recirculate(now, slot);
        }
        if ray.phase == Phase::Visit && ray.walk.node.is_leaf() {
            context.begin_leaf(ray);
        }
        buffer.push_back(slot);
    }

    fn enter_post(&mut self, now: u64, rays: &mut [RayState]) {
        if !self.post.is_free(now) {
            return;
        }
        let Some(slot) = self.post_input.pop_front() else {
            return;
        };
        let ray = &mut rays[slot as usize];
        let popped = match ray.phase {
            Phase::Visit if ray.walk.node.is_leaf() => {
                ray.next = Next::Intersect;
                return self.post.bypass(now, slot);
            }
            Phase::Visit => {
                let (next, popped) =
                    ray.walk
                        .descend(ray.children, ray.enter, ray.limit, &mut self.stacks);
                ray.next = next;
                popped
            }
            Phase::Pop if ray.is_settled() => {
                ray.next = Next::Finished;
                0
            }
            Phase::Pop => {
                let (next, popped) = ray.walk.pop(ray.limit, &mut self.stacks);
                ray.next = next;
                popped
            }
        };
        // The stack gives one entry a cycle.
        self.post.issue(now, slot, u64::from(popped.max(1)));
    }

    fn enter_aabb(&mut self, now: u64, rays: &mut [RayState], context: &Context<'_>) {
        if !self.aabb.is_free(now) {
            return;
        }
        let Some(slot) = self.aabb_input.pop_front() else {
            return;
        };
        let ray = &mut rays[slot as usize];
        if ray.phase == Phase::Pop || ray.walk.node.is_leaf() {
            return self.aabb.bypass(now, slot);
        }
        let pair: PairRecord = context.pair(ray.walk.node.index);
        ray.children = pair.child;
        for side in 0..2 {
            ray.enter[side] = ray.ray.meets(&pair.min[side], &pair.max[side], ray.limit);
        }
        // Two boxes, one a cycle.
        self.aabb.issue(now, slot, 2);
    }

    fn enter_pre(
        &mut self,
        now: u64,
        rays: &mut [RayState],
        context: &Context<'_>,
        exits: &mut Exits<'_>,
    ) {
        if !self.pre.is_free(now) || self.fetch.is_empty() {
            return;
        }
        let line = context.spec.trv_l1.line;
        let need = |slot: Slot| -> Need { rays[slot as usize].needs() };
        let request = |number: u32| exits.lines.push(number * line);
        let Some(slot) = self.fetch.tick(need, request) else {
            return;
        };
        let ray = &mut rays[slot as usize];
        if !ray.got_line() {
            // The rest of the node lies in another line.
            self.fetch.input.push_front(slot);
            return;
        }
        if ray.phase == Phase::Pop {
            return self.pre.bypass(now, slot);
        }
        ray.visits += 1;
        if ray.walk.node.is_leaf() {
            self.leaf_visits += 1;
        } else {
            self.inner_visits += 1;
        }
        self.pre.issue(now, slot, 1);
    }
}
