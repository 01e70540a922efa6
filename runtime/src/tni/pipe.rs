//! A fully pipelined block of logic of fixed depth: TRV_PRE, TRV_AABB, TRV_POST or the triangle
//! test. And the account of its cycles.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Slot;
use super::ring::Ring;
use crate::sums::sums;

/// Cycles of a pipeline's first stage by activity: every cycle counts in exactly one of these.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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
}

sums!(StallAccount: work occupied bypass recirculate memory latency elsewhere idle);

/// Counts of a pipeline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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

sums!(PipeCounters: passes bypasses recirculated issue_cycles busy_cycles; account);

/// The pipelines of a kind, which take rays from the same FIFO.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Pipes {
    all: Vec<Pipe>,
    /// The cycle in which the next ray leaves one of them.
    leaves: u64,
    /// The cycle from which on a ray can enter one of them.
    free: u64,
}

impl Pipes {
    /// `count` ≥ 1 empty pipelines of `latency` ≥ 1 stages.
    pub(super) fn new(count: u32, latency: u32, resident: usize) -> Pipes {
        Pipes {
            all: vec![Pipe::new(latency, resident); count.max(1) as usize],
            leaves: u64::MAX,
            free: 0,
        }
    }

    /// True if a ray leaves in cycle `now`.
    #[inline]
    pub(super) fn leave(&self, now: u64) -> bool {
        self.leaves <= now
    }

    /// True if a ray can enter in cycle `now`.
    #[inline]
    pub(super) fn take(&self, now: u64) -> bool {
        self.free <= now
    }

    /// All of them.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Pipe> {
        self.all.iter()
    }

    /// Each of them, for rays to enter and leave; after that comes [`changed`](Self::changed).
    #[inline]
    pub(super) fn each(&mut self) -> impl Iterator<Item = &mut Pipe> {
        self.all.iter_mut()
    }

    /// Rays have entered or left.
    #[inline]
    pub(super) fn changed(&mut self) {
        let (first, others) = self.all.split_first().expect("there is one at least");
        (self.leaves, self.free) = (first.next, first.free);
        for pipe in others {
            self.leaves = self.leaves.min(pipe.next);
            self.free = self.free.min(pipe.free);
        }
    }

    /// When something can happen after cycle `now`, where rays wait to enter or not.
    #[inline]
    pub(super) fn next_event(&self, now: u64, waits: bool) -> u64 {
        let enters = if waits {
            self.free.max(now + 1)
        } else {
            u64::MAX
        };
        self.leaves.min(enters)
    }

    /// True if no ray is in any of them.
    #[inline]
    pub(super) fn is_empty(&self) -> bool {
        self.leaves == u64::MAX
    }

    /// Rays in all of them.
    pub(super) fn rays(&self) -> u32 {
        self.all.iter().map(Pipe::rays).sum()
    }

    /// As [`Pipe::wait`], for all of them.
    pub(super) fn wait(&mut self, first: u64, cycles: u64) {
        for pipe in &mut self.all {
            pipe.wait(first, cycles);
        }
    }
}

/// A pipeline and the rays in it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Pipe {
    latency: u64,
    /// Rays with the cycle in which they leave, in order.
    flight: Ring<(u64, Slot)>,
    /// The cycle in which the first of them leaves.
    next: u64,
    /// Cycle from which the first stage is free.
    free: u64,
    /// The cycle since which there has been a ray, where there is one.
    busy_since: u64,
    /// Rays that took the first stage again only after the ray before.
    late: u64,
    /// Cycles in which the first stage was free and rays waited for memory; and those of them in
    /// which a ray was further down.
    waited: u64,
    waited_busy: u64,
    counters: PipeCounters,
}

impl Pipe {
    /// An empty pipeline of `latency` ≥ 1 stages.
    pub(super) fn new(latency: u32, resident: usize) -> Pipe {
        Pipe {
            latency: u64::from(latency.max(1)),
            flight: Ring::new(resident),
            next: u64::MAX,
            free: 0,
            busy_since: 0,
            late: 0,
            waited: 0,
            waited_busy: 0,
            counters: PipeCounters::default(),
        }
    }

    /// Rays in it.
    pub(super) fn rays(&self) -> u32 {
        self.flight.len() as u32
    }

    /// True if a ray can enter in cycle `now`.
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
        self.late += u64::from(self.free > now);
        self.enter(now, slot, 1);
    }

    #[inline]
    fn enter(&mut self, now: u64, slot: Slot, cycles: u64) {
        self.free = now.max(self.free) + cycles;
        self.counters.issue_cycles += cycles;
        let leaves = self.free - 1 + self.latency;
        if self.next == u64::MAX {
            self.next = leaves;
            self.busy_since = now;
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
        self.next = match self.flight.front() {
            Some((at, _)) => at,
            None => {
                self.counters.busy_cycles += now - self.busy_since;
                u64::MAX
            }
        };
        Some(slot)
    }

    /// Counts that rays wait for memory in `cycles` cycles from `first` on. At most in the first of these,
    /// rays have left or entered.
    pub(super) fn wait(&mut self, first: u64, cycles: u64) {
        let waited = cycles - self.free.saturating_sub(first).min(cycles);
        self.waited += waited;
        if self.next != u64::MAX {
            self.waited_busy += waited;
        }
    }

    /// Counts before cycle `end`, with `cycles` cycles in which there were rays for the pipeline.
    pub(super) fn counters(&self, end: u64, cycles: u64) -> PipeCounters {
        let mut all = self.counters;
        if self.next != u64::MAX {
            all.busy_cycles += end - self.busy_since;
        }
        all.issue_cycles -= self.free.saturating_sub(end).min(all.issue_cycles);
        let recirculate = all.recirculated - self.late;
        let entered = all.passes + all.bypasses + recirculate;
        all.account = StallAccount {
            work: all.passes,
            occupied: all.issue_cycles - entered,
            bypass: all.bypasses,
            recirculate,
            memory: self.waited,
            latency: all.busy_cycles - all.issue_cycles - self.waited_busy,
            elsewhere: cycles - all.busy_cycles - (self.waited - self.waited_busy),
            idle: 0,
        };
        all
    }

    /// The cycle in which the next ray leaves.
    #[inline]
    pub(super) fn next(&self) -> u64 {
        self.next
    }

    /// The cycle from which on a ray can enter.
    #[inline]
    pub(super) fn free(&self) -> u64 {
        self.free
    }
}
