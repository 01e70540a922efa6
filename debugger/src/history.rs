//! Checkpoints: the states that a session goes back to, and runs on from.

use crate::machine::State;
use crate::watched::Marks;

/// Bytes of all checkpoints together.
const ROOM: usize = 256 << 20;

/// Most checkpoints.
const MOST: usize = 256;

/// Instants between two checkpoints at first.
const INTERVAL: u64 = 1 << 14;

/// A state with what is noted of its cores.
pub(crate) struct Checkpoint {
    pub(crate) instant: u64,
    pub(crate) state: State,
    pub(crate) marks: Vec<Marks>,
}

/// Checkpoints in the order of their instants. Where there is no room, every second goes, and the next come half as
/// often.
pub(crate) struct History {
    checkpoints: Vec<Checkpoint>,
    interval: u64,
    bytes: usize,
}

impl History {
    pub(crate) fn new() -> History {
        History {
            checkpoints: Vec::new(),
            interval: INTERVAL,
            bytes: 0,
        }
    }

    /// True if there should be a checkpoint of this instant.
    pub(crate) fn is_due(&self, instant: u64) -> bool {
        let last = self.checkpoints.last();
        last.is_none_or(|last| instant >= last.instant + self.interval)
    }

    pub(crate) fn last(&self) -> Option<&Checkpoint> {
        self.checkpoints.last()
    }

    pub(crate) fn add(&mut self, checkpoint: Checkpoint) {
        self.bytes += checkpoint.state.bytes();
        self.checkpoints.push(checkpoint);
        while self.checkpoints.len() > 2 && (self.bytes > ROOM || self.checkpoints.len() > MOST) {
            let mut number = 0;
            self.checkpoints.retain(|_| {
                number += 1;
                number % 2 == 1
            });
            self.interval *= 2;
            self.bytes = self.checkpoints.iter().map(|c| c.state.bytes()).sum();
        }
    }

    /// The last checkpoint at this instant or before.
    pub(crate) fn before(&self, instant: u64) -> Option<&Checkpoint> {
        let after = self.checkpoints.partition_point(|c| c.instant <= instant);
        self.checkpoints[..after].last()
    }
}
