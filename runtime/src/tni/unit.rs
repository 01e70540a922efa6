//! A unit, whichever way it keeps time: the operations that all of them have.

use super::{
    Buffers, Client, Estimated, Finished, LineRequest, SubmitError, Tni, TniCounters, Untimed,
    WarmCaches,
};
use crate::memory::SystemMemory;
use serde::{Deserialize, Serialize};

/// A T&I unit by how it keeps time. Hits and counts of rays, visits and tests are the same for all.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Unit {
    /// Cycle by cycle.
    Full(Box<Tni>),
    /// Rays one by one, each as if it met no other.
    #[serde(skip)]
    Estimated(Box<Estimated>),
    /// Hits that are there at once.
    #[serde(skip)]
    Untimed(Box<Untimed>),
}

impl Unit {
    /// Goes on as another of its kind, but notes the costs of rays as it did before.
    pub(crate) fn go_on_as(&mut self, from: &Unit) {
        match (&mut *self, from) {
            (Unit::Full(unit), Unit::Full(from)) => unit.go_on_as(from),
            _ => self.clone_from(from),
        }
    }

    /// Takes a submission in cycle `now`.
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
    ) -> Result<(), SubmitError> {
        match self {
            Unit::Full(unit) => unit.submit(buffers, sram.len()),
            Unit::Estimated(unit) => unit.submit(now, buffers, memory, sram).map(|_| ()),
            Unit::Untimed(unit) => unit.submit(buffers, memory, sram).map(|_| ()),
        }
    }

    /// True if a cycle would do nothing but count.
    #[inline]
    pub fn is_idle(&self) -> bool {
        match self {
            Unit::Full(unit) => unit.is_idle(),
            Unit::Estimated(_) | Unit::Untimed(_) => true,
        }
    }

    /// One cycle of a unit that is not [idle](Self::is_idle). Cycles are numbered from anywhere,
    /// ascending.
    #[inline]
    pub fn tick(&mut self, now: u64, memory: &SystemMemory, sram: &mut [u8]) {
        if let Unit::Full(unit) = self {
            unit.tick(now, memory, sram);
        }
    }

    /// True if lines that it requests have to be read and [filled](Self::fill); else it has them already, and
    /// only tells of them.
    #[inline]
    pub fn waits_for_lines(&self) -> bool {
        matches!(self, Unit::Full(_))
    }

    /// The next line to be read from memory.
    #[inline]
    pub fn take_request(&mut self) -> Option<LineRequest> {
        match self {
            Unit::Full(unit) => unit.take_request(),
            Unit::Estimated(unit) => unit.take_request(),
            Unit::Untimed(_) => None,
        }
    }

    /// A line that was requested arrives before cycle `now`.
    pub fn fill(&mut self, now: u64, client: Client, address: u32) {
        if let Unit::Full(unit) = self {
            unit.fill(now, client, address);
        }
    }

    /// The first cycle in which the oldest submission is back, where that is known beforehand.
    #[inline]
    pub fn back(&self) -> Option<u64> {
        match self {
            Unit::Full(_) | Unit::Untimed(_) => None,
            Unit::Estimated(unit) => unit.back(),
        }
    }

    /// Takes the oldest submission out of the unit, where it is complete and its time
    /// [has come](Self::back).
    pub fn take_finished(&mut self) -> Option<Finished> {
        match self {
            Unit::Full(unit) => unit.take_finished(),
            Unit::Estimated(unit) => unit.take_finished(),
            Unit::Untimed(unit) => unit.take_finished(),
        }
    }

    /// Takes over the contents of these caches. Counts, and lines on their way, stay.
    pub fn hold(&mut self, caches: &WarmCaches) {
        match self {
            Unit::Full(unit) => unit.hold(caches),
            Unit::Estimated(unit) => unit.hold(caches),
            Unit::Untimed(_) => {}
        }
    }

    /// Counts of the unit so far.
    pub fn counters(&self) -> TniCounters {
        match self {
            Unit::Full(unit) => unit.counters(),
            Unit::Estimated(unit) => unit.counters(),
            Unit::Untimed(unit) => unit.counters(),
        }
    }

    /// Rays, visits, tests and caches so far, without the accounts of pipelines: they take longer.
    pub fn progress(&self) -> TniCounters {
        match self {
            Unit::Full(unit) => unit.progress(),
            Unit::Estimated(unit) => unit.counters(),
            Unit::Untimed(unit) => unit.counters(),
        }
    }

    /// Rays that have come and results that have gone so far: grows as long as the unit works.
    #[inline]
    pub fn results(&self) -> u64 {
        match self {
            Unit::Full(unit) => unit.results(),
            Unit::Estimated(unit) => unit.results(),
            Unit::Untimed(unit) => 2 * unit.counts.rays(),
        }
    }

    /// Describes in words what the unit waits for, for the report of a deadlock.
    pub fn describe_state(&self) -> String {
        match self {
            Unit::Full(unit) => unit.describe_state(),
            Unit::Estimated(unit) => unit.describe_state(),
            Unit::Untimed(unit) => unit.describe_state(),
        }
    }
}
