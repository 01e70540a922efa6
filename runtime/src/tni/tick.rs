//! Cycles that are counted later: a part of the unit in which nothing happens is left alone, and its
//! counters make up for it.

use serde::{Deserialize, Serialize};

/// A cycle of the unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Tick {
    /// Its number on the unit's clock.
    pub(super) now: u64,
    /// Its place among the cycles in which the unit had rays.
    pub(super) index: u64,
}

/// The cycles of a part up to which everything is counted.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Counted(Tick);

impl Counted {
    /// Takes up the cycles before `tick`: the first of them and how many there are, if there are
    /// any. As long as there are rays they follow on each other.
    #[inline]
    pub(super) fn until(&mut self, tick: Tick) -> Option<(u64, u64)> {
        let first = std::mem::replace(&mut self.0, tick);
        let cycles = tick.index - first.index;
        (cycles > 0).then_some((first.now, cycles))
    }
}
