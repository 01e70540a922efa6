//! The intersection unit: one triangle a cycle, or as often as its reciprocal takes one, looping over the triangles of a leaf
//! (SGRT section 3.3).

use serde::{Deserialize, Serialize};
use srp_archdesc::system::TniSpec;

use super::fetch::Fetch;
use super::occupancy::IstOccupancy;
use super::pipe::Pipe;
use super::ray_state::RayState;
use super::replay::{Event, Visited};
use super::tick::{Counted, Tick};
use super::trv::Trv;
use super::{Context, Slot};

/// An intersection unit.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Ist {
    pub(super) fetch: Fetch,
    pub(super) pipe: Pipe,
    /// Entries that traversal units may use of the input buffer. Rays that come round again have
    /// places of their own.
    pub(super) capacity: usize,
    pub(super) tests: u64,
    pub(super) accepted: u64,
    /// Cycles from a traversal unit and back to it, summed over the visits.
    pub(super) resident_cycles: u64,
    /// Before this cycle nothing happens here, unless something comes from outside.
    pub(super) wakes: u64,
    counted: Counted,
}

impl Ist {
    pub(super) fn new(spec: &TniSpec, resident: usize) -> Ist {
        Ist {
            fetch: Fetch::new((spec.rau_rows, spec.rau_rays), &spec.ist_l1, resident),
            pipe: Pipe::new(spec.ist_latency + spec.ist_l1.latency, resident),
            capacity: spec.fifo.max(1) as usize,
            tests: 0,
            accepted: 0,
            resident_cycles: 0,
            wakes: u64::MAX,
            counted: Counted::default(),
        }
    }

    /// Where its rays are.
    pub(super) fn occupancy(&self) -> IstOccupancy {
        IstOccupancy {
            fifo: self.fetch.input.len() as u32,
            rau: self.fetch.waiting(),
            pipe: self.pipe.rays(),
        }
    }

    /// A leaf arrives in cycle `now`, to be visible in the next.
    pub(super) fn arrive(&mut self, now: u64, slot: Slot) {
        self.fetch.input.push_back(slot);
        self.wakes = self.wakes.min(now + 1);
    }

    /// A line arrives before cycle `now`.
    pub(super) fn fill(&mut self, now: u64, line: u32) {
        self.wakes = self.wakes.min(now);
        self.fetch.fill(line);
    }

    /// Counts the cycles before `tick` that are not counted yet. Call it before any change that would count
    /// them otherwise.
    pub(super) fn count_until(&mut self, tick: Tick) {
        if let Some((first, cycles)) = self.counted.until(tick)
            && self.fetch.waiting() > 0
        {
            self.fetch.count(cycles);
            self.pipe.wait(first, cycles);
        }
    }

    /// One cycle: a ray leaves the pipeline, then another enters it. It may be left out before
    /// [`wakes`](Self::wakes).
    pub(super) fn tick(
        &mut self,
        tick: Tick,
        rays: &mut [RayState],
        context: &Context<'_>,
        trvs: &mut [Trv],
        lines: &mut Vec<u32>,
    ) {
        self.count_until(tick);
        let now = tick.now;
        self.leave(now, rays, context, trvs);
        self.enter(now, rays, context, lines);
        let enters = match self.fetch.has_work() {
            true => self.pipe.free().max(now + 1),
            false => u64::MAX,
        };
        self.wakes = self.pipe.next().min(enters);
    }

    fn leave(&mut self, now: u64, rays: &mut [RayState], context: &Context<'_>, trvs: &mut [Trv]) {
        let Some(slot) = self.pipe.leave(now) else {
            return;
        };
        let ray = &mut rays[slot as usize];
        if ray.triangles > 0 {
            self.fetch.input.push_back(slot);
            return;
        }
        let trv = &mut trvs[slot as usize / context.spec().stacks as usize];
        if trv.can_return(context.spec().pipeline) {
            self.resident_cycles += now - ray.ist_since;
            trv.come_back(now, slot, ray, context.spec().pipeline);
        } else {
            self.pipe.recirculate(now, slot);
        }
    }

    fn enter(
        &mut self,
        now: u64,
        rays: &mut [RayState],
        context: &Context<'_>,
        lines: &mut Vec<u32>,
    ) {
        if !self.pipe.is_free(now) {
            return;
        }
        let line = context.spec().ist_l1.line;
        let need = |slot: Slot| rays[slot as usize].needs();
        let request = |number: u32| lines.push(number * line);
        let Some(slot) = self.fetch.tick(need, request) else {
            return;
        };
        let ray = &mut rays[slot as usize];
        if !ray.got_line() {
            self.fetch.input.push_front(slot);
            return;
        }
        self.test(now, slot, ray, context);
        self.pipe
            .issue(now, slot, u64::from(context.spec().rcp_interval));
    }

    /// Tests the ray's triangle, and goes on to the next of its leaf.
    fn test(&mut self, now: u64, slot: Slot, ray: &mut RayState, context: &Context<'_>) {
        self.tests += 1;
        ray.tests += 1;
        context.visit(Visited::Triangle(ray.triangle));
        let enter = ray.walk.enter;
        let (primitive, hit, taken) =
            context
                .function
                .test(ray.triangle, &ray.ray, enter, &mut ray.hit);
        self.accepted += u64::from(taken);
        context.log(now, slot, || Event::Triangle {
            primitive,
            t: hit.map(|hit| hit.t),
            taken,
        });
        ray.triangle += 1;
        ray.triangles -= 1;
        if context.function.is_settled(ray.flags, &ray.hit) {
            ray.triangles = 0;
        }
        if ray.triangles > 0 {
            context.begin_triangle(ray);
        }
    }
}
