//! Words of memory that cores share.
//!
//! Each core has a data cache of its own, and nothing keeps these coherent. Here values are in one memory that is
//! always up to date, and a core may run ahead of the others while it is simulated: what one reads of another's writes
//! follows the order of the simulation, and on hardware the line that each cache has. Programs whose cores share
//! nothing but tiles and ports mean the same on both. Whether one shares does not depend on the order, so it is found
//! and told.

use crate::memory::SystemMemory;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Words of memory that several cores used and one or more wrote.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct SharedWords {
    /// How many.
    pub count: u64,
    /// The lowest of their addresses.
    pub first: Option<u32>,
}

/// The part of a word's state that is set when it is written.
const WRITTEN: u8 = 1 << 7;

/// The user of a word that more than one core has used; else it is a core's number and 1, or 0.
const SEVERAL: u8 = WRITTEN - 1;

/// True if the state is that of a shared word.
fn is_shared(state: u8) -> bool {
    state == WRITTEN | SEVERAL
}

/// The users of each word that may be written.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Sharing {
    /// The first address that cores may write to.
    first: u32,
    words: Vec<u8>,
    pub(super) found: SharedWords,
}

impl Sharing {
    /// Of the part of memory that so many cores may write to. One alone shares nothing, and nothing is kept for it.
    pub(super) fn of(memory: &SystemMemory, cores: usize) -> Sharing {
        Sharing::from(
            memory.first_writable_address(),
            memory.writable().len(),
            cores,
        )
    }

    fn from(first: u32, bytes: usize, cores: usize) -> Sharing {
        let words = if cores > 1 { bytes.div_ceil(4) } else { 0 };
        Sharing {
            first,
            words: vec![0; words],
            found: SharedWords::default(),
        }
    }

    /// A core reads or writes `bytes`, naturally aligned, at `address`.
    #[inline]
    pub(super) fn used(&mut self, core: u32, address: u32, bytes: u32, writes: bool) {
        if address < self.first {
            return;
        }
        let begin = ((address - self.first) / 4) as usize;
        let words = self
            .words
            .get_mut(begin..begin + bytes.div_ceil(4) as usize);
        for (word, number) in words.into_iter().flatten().zip(0..) {
            let user = match *word & SEVERAL {
                0 => core as u8 + 1,
                user if user == core as u8 + 1 => user,
                _ => SEVERAL,
            };
            let state = user | *word & WRITTEN | if writes { WRITTEN } else { 0 };
            if is_shared(state) && !is_shared(*word) {
                let address = (address & !3) + 4 * number;
                self.found.count += 1;
                self.found.first = Some(self.found.first.map_or(address, |a| a.min(address)));
            }
            *word = state;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whoever comes first, the same words are shared: those that one core wrote and another used.
    #[test]
    fn the_order_of_uses_does_not_matter() {
        let uses = [
            // Two read.
            (0, 0x100, 16, false),
            (1, 0x104, 4, false),
            // One writes, the other reads a part.
            (2, 0x120, 16, true),
            (0, 0x12a, 2, false),
            // Two write.
            (1, 0x140, 4, true),
            (2, 0x140, 1, true),
            // One alone.
            (2, 0x150, 8, true),
            (2, 0x150, 8, false),
            // Below what may be written.
            (0, 0x80, 4, false),
            (1, 0x80, 4, true),
        ];
        for turn in 0..uses.len() {
            let mut sharing = Sharing::from(0x100, 0x100, 3);
            for i in 0..uses.len() {
                let (core, address, bytes, writes) = uses[(i + turn) % uses.len()];
                sharing.used(core, address, bytes, writes);
            }
            let expected = SharedWords {
                count: 2,
                first: Some(0x128),
            };
            assert_eq!(sharing.found, expected, "{turn}");
        }
    }
}
