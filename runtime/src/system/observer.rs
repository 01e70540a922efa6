//! Observers, which see the events of a system and change nothing.
//!
//! An event names its core and its SRP cycle, and gives access to the counts of the core by then. Events of
//! one core come in the order of its cycles. A core may run ahead of the others: the events of a run come
//! when the run is simulated.

use super::report::Account;
use crate::core::Run;
use crate::memory::cache::CacheCounters;
use crate::tni::{Buffers, Client, HitRecord, RayCost, Tni, TniCounters, Unit, Visited};
use serde::{Deserialize, Serialize};

/// A reason to stand still: the first of these that a core waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Stall {
    /// Its data cache.
    Data,
    /// Its texture cache.
    Texture,
    /// Its instruction cache.
    Instructions,
    /// The contexts of a kernel.
    Contexts,
    /// The banks of its SRAM.
    Banks,
}

/// Who asks the memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Requester {
    /// The data cache of a core.
    DataCache,
    /// Its texture cache.
    TextureCache,
    /// Its instruction cache.
    InstructionCache,
    /// Its configuration memory.
    ConfigurationMemory,
    /// A cache of its T&I unit.
    Tni(Client),
}

/// A request to the memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryRequest {
    /// Who asks.
    pub requester: Requester,
    /// The address.
    pub address: u32,
    /// Bytes that are read or written.
    pub bytes: u32,
    /// True if they are written.
    pub is_write: bool,
}

/// A tile that a core takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TakenTile {
    /// Its place in the queue.
    pub place: u32,
    /// Its number in the frame.
    pub tile: u32,
}

/// A packet of rays that a core sends to its T&I unit.
#[derive(Clone, Copy, Debug)]
pub struct SentPacket<'a> {
    /// Its number: the first of the core is 0.
    pub number: u64,
    /// Where its rays are, and where their hits go.
    pub buffers: Buffers,
    /// The ray buffer's contents.
    pub rays: &'a [u8],
}

/// A core at an event.
pub struct CoreView<'a> {
    /// Its number.
    pub core: u32,
    /// The SRP cycle.
    pub cycle: u64,
    /// Its cycles so far, by activity. The cycles of a run in which it uses ports, or of a stall, are not
    /// included yet.
    pub account: &'a Account,
    /// Counts of its data cache.
    pub data_cache: &'a CacheCounters,
    /// Counts of its texture cache.
    pub texture_cache: &'a CacheCounters,
    /// Samples of its texture unit.
    pub texture_samples: u64,
    pub(super) tni: &'a Unit,
}

impl CoreView<'_> {
    /// Counts of its T&I unit, without the accounts of pipelines. This call makes the sums.
    pub fn tni(&self) -> TniCounters {
        self.tni.progress()
    }
}

/// An observer of a system. Every event has a default that ignores it.
#[expect(unused_variables, reason = "the defaults ignore everything")]
pub trait Observer {
    /// The core has asked for a tile and takes this one, or there is none left.
    fn tile_taken(&mut self, core: &CoreView<'_>, taken: Option<TakenTile>) {}

    /// The core sends a packet of rays to its T&I unit.
    fn packet_sent(&mut self, core: &CoreView<'_>, packet: &SentPacket<'_>) {}

    /// The core has written so many bytes of the memory that all cores share, in a run that begins in this cycle.
    fn stored(&mut self, core: &CoreView<'_>, address: u32, bytes: u32) {}

    /// The T&I unit of a core gives back a ray. Only a unit that is run cycle by cycle tells of rays.
    fn ray_returned(&mut self, core: u32, cycle: u64, cost: &RayCost) {}

    /// Rays in the T&I unit of a core have visited parts of the tree, in this order. Only a unit that is run cycle by
    /// cycle tells of them.
    fn tni_visited(&mut self, core: u32, visited: &[Visited]) {}

    /// The T&I unit of a core has had a cycle of its own in this one. Only a unit that is run cycle by cycle has.
    fn tni_ticked(&mut self, core: u32, cycle: u64, unit: &Tni) {}

    /// The core takes the hits of a packet, which are in the order of its hit buffer.
    fn packet_returned(&mut self, core: &CoreView<'_>, packet: u64, hits: &[HitRecord]) {}

    /// A cache of the core, or of its T&I unit, sends a request to the memory.
    fn requested(&mut self, core: &CoreView<'_>, request: &MemoryRequest) {}

    /// The core has done one thing for a run of cycles that begins in this one.
    fn ran(&mut self, core: &CoreView<'_>, run: &Run) {}

    /// The core stands still from this cycle on.
    fn stall_began(&mut self, core: &CoreView<'_>, stall: Stall) {}

    /// The core does not stand still for this any more.
    fn stall_ended(&mut self, core: &CoreView<'_>, stall: Stall) {}

    /// The program of the core has ended.
    fn halted(&mut self, core: &CoreView<'_>) {}

    /// The frame is over, or was cancelled: the last event of the core, with all that it has counted.
    fn finished(&mut self, core: &CoreView<'_>) {}
}

/// Several observers as one, which see every event one after the other.
pub struct Observers<'a>(pub Vec<&'a mut dyn Observer>);

impl<'a> Observers<'a> {
    /// One observer for all; where there is one only, that one, and `None` where there is none.
    pub fn as_one(&mut self) -> Option<&mut (dyn Observer + 'a)> {
        match self.0.len() {
            0 => None,
            1 => Some(&mut *self.0[0]),
            _ => Some(self),
        }
    }

    fn tell(&mut self, event: impl Fn(&mut dyn Observer)) {
        for observer in &mut self.0 {
            event(&mut **observer);
        }
    }
}

impl Observer for Observers<'_> {
    fn tile_taken(&mut self, core: &CoreView<'_>, taken: Option<TakenTile>) {
        self.tell(|o| o.tile_taken(core, taken));
    }

    fn packet_sent(&mut self, core: &CoreView<'_>, packet: &SentPacket<'_>) {
        self.tell(|o| o.packet_sent(core, packet));
    }

    fn stored(&mut self, core: &CoreView<'_>, address: u32, bytes: u32) {
        self.tell(|o| o.stored(core, address, bytes));
    }

    fn ray_returned(&mut self, core: u32, cycle: u64, cost: &RayCost) {
        self.tell(|o| o.ray_returned(core, cycle, cost));
    }

    fn tni_visited(&mut self, core: u32, visited: &[Visited]) {
        self.tell(|o| o.tni_visited(core, visited));
    }

    fn tni_ticked(&mut self, core: u32, cycle: u64, unit: &Tni) {
        self.tell(|o| o.tni_ticked(core, cycle, unit));
    }

    fn packet_returned(&mut self, core: &CoreView<'_>, packet: u64, hits: &[HitRecord]) {
        self.tell(|o| o.packet_returned(core, packet, hits));
    }

    fn requested(&mut self, core: &CoreView<'_>, request: &MemoryRequest) {
        self.tell(|o| o.requested(core, request));
    }

    fn ran(&mut self, core: &CoreView<'_>, run: &Run) {
        self.tell(|o| o.ran(core, run));
    }

    fn stall_began(&mut self, core: &CoreView<'_>, stall: Stall) {
        self.tell(|o| o.stall_began(core, stall));
    }

    fn stall_ended(&mut self, core: &CoreView<'_>, stall: Stall) {
        self.tell(|o| o.stall_ended(core, stall));
    }

    fn halted(&mut self, core: &CoreView<'_>) {
        self.tell(|o| o.halted(core));
    }

    fn finished(&mut self, core: &CoreView<'_>) {
        self.tell(|o| o.finished(core));
    }
}
