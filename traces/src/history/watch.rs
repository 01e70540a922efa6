//! When an address is written last, and what the core had done until the window with its history begins.

use srp_runtime::core::{Activity, Run};
use srp_runtime::system::{CoreView, Observer, TakenTile};
use std::ops::Range;

/// Sees the last store to an address of the memory that all cores share.
pub struct StoreWatch {
    address: u32,
    /// The tile with which its history begins.
    tile: u32,
    cores: Vec<Watched>,
    stored: Option<Stored>,
}

/// A store, and the window with its history.
#[derive(Clone, Debug)]
pub struct Stored {
    /// The core.
    pub core: u32,
    /// Its cycles from its taking of the tile to the store.
    pub cycles: Range<u64>,
    /// Launches of each kernel on that core before.
    pub launches: Vec<u64>,
}

/// What is known of a core.
#[derive(Clone, Debug, Default)]
struct Watched {
    last: Option<Activity>,
    launches: Vec<u64>,
    /// The cycle in which it took the tile, and the launches until then.
    taken: (u64, Vec<u64>),
    /// It has stored in the run of which the system tells next.
    stores: bool,
}

impl StoreWatch {
    /// Of the four bytes at an address.
    pub fn new(address: u32, tile: u32) -> StoreWatch {
        StoreWatch {
            address,
            tile,
            cores: Vec::new(),
            stored: None,
        }
    }

    /// The last store, if there was one.
    pub fn stored(self) -> Option<Stored> {
        self.stored
    }

    fn core(&mut self, number: u32) -> &mut Watched {
        let number = number as usize;
        if self.cores.len() <= number {
            self.cores.resize(number + 1, Watched::default());
        }
        &mut self.cores[number]
    }
}

impl Observer for StoreWatch {
    fn tile_taken(&mut self, core: &CoreView<'_>, taken: Option<TakenTile>) {
        if taken.is_some_and(|taken| taken.tile == self.tile) {
            let of = self.core(core.core);
            of.taken = (core.cycle, of.launches.clone());
        }
    }

    fn stored(&mut self, core: &CoreView<'_>, address: u32, bytes: u32) {
        let (from, to) = (u64::from(self.address), u64::from(self.address) + 4);
        if u64::from(address) < to && u64::from(address) + u64::from(bytes) > from {
            self.core(core.core).stores = true;
        }
    }

    fn ran(&mut self, core: &CoreView<'_>, run: &Run) {
        let of = self.core(core.core);
        if let Activity::Array(kernel) = run.activity
            && of.last != Some(run.activity)
        {
            let kernel = kernel as usize;
            of.launches.resize(of.launches.len().max(kernel + 1), 0);
            of.launches[kernel] += 1;
        }
        of.last = Some(run.activity);
        if std::mem::take(&mut of.stores) {
            let (from, launches) = of.taken.clone();
            self.stored = Some(Stored {
                core: core.core,
                cycles: from..core.cycle + run.cycles,
                launches,
            });
        }
    }
}
