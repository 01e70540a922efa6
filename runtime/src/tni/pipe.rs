//! A fully pipelined stretch of logic of fixed depth: TRV_PRE, TRV_AABB, TRV_POST or the triangle
//! test.

use std::collections::VecDeque;

use serde::Serialize;

use super::Slot;

/// What a pipeline did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PipeCounters {
    /// Rays that passed and were worked on.
    pub passes: u64,
    /// Rays that passed without work, on the way to a later stage.
    pub bypasses: u64,
    /// Rays that passed again without work, because the buffer behind was full.
    pub recirculated: u64,
    /// Cycles in which the first stage was taken.
    pub issue_cycles: u64,
    /// Cycles in which any stage was.
    pub busy_cycles: u64,
}

impl PipeCounters {
    /// Adds what another pipeline did.
    pub fn add(&mut self, other: &PipeCounters) {
        self.passes += other.passes;
        self.bypasses += other.bypasses;
        self.recirculated += other.recirculated;
        self.issue_cycles += other.issue_cycles;
        self.busy_cycles += other.busy_cycles;
    }
}

/// A pipeline and the rays in it.
#[derive(Clone, Debug)]
pub(super) struct Pipe {
    latency: u64,
    /// Rays with the cycle in which they leave, in order.
    flight: VecDeque<(u64, Slot)>,
    /// Cycle from which the first stage is free.
    free: u64,
    pub(super) counters: PipeCounters,
}

impl Pipe {
    /// An empty pipeline of `latency` ≥ 1 stages.
    pub(super) fn new(latency: u32, resident: usize) -> Pipe {
        Pipe {
            latency: u64::from(latency.max(1)),
            flight: VecDeque::with_capacity(resident),
            free: 0,
            counters: PipeCounters::default(),
        }
    }

    /// Whether a ray can enter in cycle `now`.
    #[inline]
    pub(super) fn is_free(&self, now: u64) -> bool {
        self.free <= now
    }

    /// A ray enters, to be worked on; it takes the first stage for `cycles`.
    #[inline]
    pub(super) fn issue(&mut self, now: u64, slot: Slot, cycles: u64) {
        self.counters.passes += 1;
        self.enter(now, slot, cycles);
    }

    /// A ray enters that has no work here.
    #[inline]
    pub(super) fn bypass(&mut self, now: u64, slot: Slot) {
        self.counters.bypasses += 1;
        self.enter(now, slot, 1);
    }

    /// A ray that cannot leave enters again. It goes before any other in this cycle.
    pub(super) fn recirculate(&mut self, now: u64, slot: Slot) {
        self.counters.recirculated += 1;
        self.enter(now.max(self.free), slot, 1);
    }

    fn enter(&mut self, now: u64, slot: Slot, cycles: u64) {
        self.free = now + cycles;
        self.counters.issue_cycles += cycles;
        self.flight
            .push_back((now + cycles - 1 + self.latency, slot));
    }

    /// The ray that leaves in cycle `now`, if one does.
    #[inline]
    pub(super) fn leave(&mut self, now: u64) -> Option<Slot> {
        let (_, slot) = self.flight.pop_front_if(|(at, _)| *at <= now)?;
        Some(slot)
    }

    /// Ends a cycle.
    #[inline]
    pub(super) fn count(&mut self) {
        self.counters.busy_cycles += u64::from(!self.flight.is_empty());
    }

    /// Whether no ray is in it.
    pub(super) fn is_empty(&self) -> bool {
        self.flight.is_empty()
    }
}
