//! A fully pipelined stretch of logic of fixed depth: TRV_PRE, TRV_AABB, TRV_POST or the triangle
//! test. And the account of its cycles.

use std::collections::VecDeque;

use serde::Serialize;

use super::Slot;

/// What the first stage of a pipeline did in each cycle: every cycle counts in exactly one of
/// these.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct StallAccount {
    /// It took a ray to work on.
    pub work: u64,
    /// It was still at the work of the ray before: the second box, further stack entries.
    pub occupied: u64,
    /// It took a ray that only passes through.
    pub bypass: u64,
    /// It took back a ray that could not leave at the other end.
    pub recirculate: u64,
    /// It could have taken a ray, and rays only waited for lines of memory.
    pub memory: u64,
    /// No ray was there; at least one was further down the pipeline.
    pub latency: u64,
    /// Rays were elsewhere in the unit only.
    pub elsewhere: u64,
    /// There were no rays: in the traversal unit, or for an intersection unit in the T&I unit.
    pub idle: u64,
}

impl StallAccount {
    /// All cycles.
    pub fn total(&self) -> u64 {
        self.rows().iter().map(|(_, cycles)| cycles).sum()
    }

    /// The parts with their names.
    pub fn rows(&self) -> [(&'static str, u64); 8] {
        [
            ("work", self.work),
            ("occupied", self.occupied),
            ("bypass", self.bypass),
            ("recirculate", self.recirculate),
            ("memory", self.memory),
            ("latency", self.latency),
            ("elsewhere", self.elsewhere),
            ("idle", self.idle),
        ]
    }

    /// Adds the account of another pipeline.
    pub fn add(&mut self, other: &StallAccount) {
        self.work += other.work;
        self.occupied += other.occupied;
        self.bypass += other.bypass;
        self.recirculate += other.recirculate;
        self.memory += other.memory;
        self.latency += other.latency;
        self.elsewhere += other.elsewhere;
        self.idle += other.idle;
    }
}

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
    /// Every cycle of the first stage.
    pub account: StallAccount,
}

impl PipeCounters {
    /// Adds what another pipeline did.
    pub fn add(&mut self, other: &PipeCounters) {
        self.passes += other.passes;
        self.bypasses += other.bypasses;
        self.recirculated += other.recirculated;
        self.issue_cycles += other.issue_cycles;
        self.busy_cycles += other.busy_cycles;
        self.account.add(&other.account);
    }
}

/// What entered in the present cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Entered {
    Nothing,
    Work,
    Bypass,
    Recirculated,
}

/// A pipeline and the rays in it.
#[derive(Clone, Debug)]
pub(super) struct Pipe {
    latency: u64,
    /// Rays with the cycle in which they leave, in order.
    flight: VecDeque<(u64, Slot)>,
    /// The cycle in which the first of them leaves.
    next: u64,
    /// Cycle from which the first stage is free.
    free: u64,
    entered: Entered,
    pub(super) counters: PipeCounters,
}

impl Pipe {
    /// An empty pipeline of `latency` ≥ 1 stages.
    pub(super) fn new(latency: u32, resident: usize) -> Pipe {
        Pipe {
            latency: u64::from(latency.max(1)),
            flight: VecDeque::with_capacity(resident),
            next: u64::MAX,
            free: 0,
            entered: Entered::Nothing,
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
        self.entered = Entered::Work;
        self.enter(now, slot, cycles);
    }

    /// A ray enters that has no work here.
    #[inline]
    pub(super) fn bypass(&mut self, now: u64, slot: Slot) {
        self.counters.bypasses += 1;
        self.entered = Entered::Bypass;
        self.enter(now, slot, 1);
    }

    /// A ray that cannot leave enters again. It goes before any other in this cycle.
    pub(super) fn recirculate(&mut self, now: u64, slot: Slot) {
        self.counters.recirculated += 1;
        if self.free <= now {
            self.entered = Entered::Recirculated;
        }
        self.enter(now.max(self.free), slot, 1);
    }

    #[inline]
    fn enter(&mut self, now: u64, slot: Slot, cycles: u64) {
        self.free = now + cycles;
        self.counters.issue_cycles += cycles;
        let leaves = now + cycles - 1 + self.latency;
        if self.flight.is_empty() {
            self.next = leaves;
        }
        self.flight.push_back((leaves, slot));
    }

    /// The ray that leaves in cycle `now`, if one does.
    #[inline]
    pub(super) fn leave(&mut self, now: u64) -> Option<Slot> {
        if self.next > now {
            return None;
        }
        let (_, slot) = self.flight.pop_front()?;
        self.next = self.flight.front().map_or(u64::MAX, |(at, _)| *at);
        Some(slot)
    }

    /// Ends cycle `now`. `waits`: rays that could enter wait for memory. Says whether any ray is in
    /// the pipeline.
    #[inline]
    pub(super) fn count(&mut self, now: u64, waits: bool) -> bool {
        let busy = !self.flight.is_empty();
        self.counters.busy_cycles += u64::from(busy);
        let account = &mut self.counters.account;
        match self.entered {
            Entered::Nothing if self.free > now => account.occupied += 1,
            Entered::Nothing if waits => account.memory += 1,
            Entered::Nothing if busy => account.latency += 1,
            Entered::Nothing => account.elsewhere += 1,
            Entered::Work => account.work += 1,
            Entered::Bypass => account.bypass += 1,
            Entered::Recirculated => account.recirculate += 1,
        }
        self.entered = Entered::Nothing;
        busy
    }

    /// Whether no ray is in it.
    #[inline]
    pub(super) fn is_empty(&self) -> bool {
        self.flight.is_empty()
    }
}
