//! What each tile took: a core's account and counters, parted by the tile in whose service it was.
//!
//! A core works for one tile at a time: from the port's word that gives it the tile, or the hits of
//! one of its packets, until the next such word. What it waits for a packet belongs to that packet's
//! tile, and so does what the T&I unit does while that packet is the oldest it has. So every cycle and
//! every byte has one tile, and the sum over tiles is the whole.

use std::collections::VecDeque;

use super::data_cache::DataCache;
use super::report::Account;
use super::texture_cache::TextureCache;
use crate::memory::cache::CacheCounters;
use crate::tni::Tni;

/// What is counted for each tile, apart from the kernels' cycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(usize)]
pub enum Column {
    /// SRP cycles of the core, all that follow.
    Cycles,
    /// VLIW bundles.
    Vliw,
    /// Mode switches.
    Switch,
    /// Stalls of the data cache.
    MemoryStall,
    /// Stalls of the texture cache.
    TextureStall,
    /// Waiting for ports.
    Wait,
    /// Hits of the data cache.
    DataHits,
    /// Its misses, joined ones too.
    DataMisses,
    /// Hits of the texture cache.
    TextureHits,
    /// Its misses, joined ones too.
    TextureMisses,
    /// Texture samples.
    Samples,
    /// Rays.
    Rays,
    /// Rays that hit something.
    Hits,
    /// Visits of inner nodes.
    InnerVisits,
    /// Visits of leaves.
    LeafVisits,
    /// Ray–triangle tests.
    Tests,
    /// Cycles of rays in the T&I unit.
    Resident,
    /// Hits of the traversal units' level-1 caches.
    TrvL1Hits,
    /// Their misses, joined ones too.
    TrvL1Misses,
    /// Hits of the level-2 cache.
    TrvL2Hits,
    /// Its misses, joined ones too.
    TrvL2Misses,
    /// Hits of the intersection units' caches.
    IstL1Hits,
    /// Their misses, joined ones too.
    IstL1Misses,
    /// Bytes read from memory.
    BytesRead,
    /// Bytes written to memory.
    BytesWritten,
}

/// Number of [`Column`]s; the cycles of each kernel follow.
pub const COLUMNS: usize = Column::BytesWritten as usize + 1;

/// Counters of one tile, or sums of several: by [`Column`], then by kernel.
pub type Tally = Vec<u64>;

/// Counts and parts.
#[derive(Clone, Debug, Default)]
pub(super) struct Ledger {
    /// The tile in hand: its place in the queue.
    current: Option<u32>,
    /// Whose packets the T&I unit has, oldest first.
    owners: VecDeque<Option<u32>>,
    /// What has been charged already.
    charged: Tally,
    /// Of each tile taken: its place in the queue, and its counters.
    pub(super) tallies: Vec<(u32, Tally)>,
    /// Bytes of requests of the data and texture caches, and of the T&I unit.
    pub(super) read: u64,
    pub(super) written: u64,
    pub(super) tni_read: u64,
    /// SRP cycles before the first tile.
    pub(super) before: u64,
    kernels: usize,
}

/// What is looked at.
pub(super) struct Sources<'a> {
    pub(super) account: &'a Account,
    pub(super) data: &'a DataCache,
    pub(super) texture: &'a TextureCache,
    pub(super) tni: &'a Tni,
}

impl Ledger {
    pub(super) fn new(kernels: usize) -> Ledger {
        Ledger {
            charged: vec![0; COLUMNS + kernels],
            kernels,
            ..Ledger::default()
        }
    }

    /// The core takes the tile at this place of the queue, or none.
    pub(super) fn take_tile(&mut self, place: Option<u32>, sources: &Sources<'_>) {
        if self.tallies.is_empty() {
            self.before = sources.account.total();
        }
        self.charge(sources);
        self.current = place;
        if let Some(place) = place {
            self.tallies.push((place, vec![0; COLUMNS + self.kernels]));
        }
    }

    /// The tile in hand.
    pub(super) fn current(&self) -> Option<u32> {
        self.current
    }

    /// A packet of the tile in hand goes to the T&I unit.
    pub(super) fn send_packet(&mut self) {
        self.owners.push_back(self.current);
    }

    /// The oldest packet has come back.
    pub(super) fn take_packet(&mut self, sources: &Sources<'_>) {
        self.charge(sources);
        if let Some(owner) = self.owners.pop_front() {
            self.current = owner;
        }
    }

    /// Charges what was counted since the last time.
    pub(super) fn charge(&mut self, sources: &Sources<'_>) {
        let now = self.look(sources);
        let in_unit = self.owners.front().copied().flatten().or(self.current);
        let waited = now[Column::Wait as usize] - self.charged[Column::Wait as usize];
        for (column, (&now, &before)) in now.iter().zip(&self.charged).enumerate() {
            let mut grown = now - before;
            let of_unit = column == Column::Wait as usize
                || (Column::Rays as usize..=Column::IstL1Misses as usize).contains(&column);
            if column == Column::Cycles as usize {
                grown -= waited;
            }
            let tile = if of_unit { in_unit } else { self.current };
            add(&mut self.tallies, tile, column, grown);
        }
        add(&mut self.tallies, in_unit, Column::Cycles as usize, waited);
        self.charged = now;
    }

    /// All counters as they are.
    fn look(&self, sources: &Sources<'_>) -> Tally {
        let account = sources.account;
        let tni = sources.tni.progress();
        let missed = |c: &CacheCounters| c.misses + c.joined;
        let (data, texture) = (
            &sources.data.cache.counters,
            &sources.texture.lines.cache.counters,
        );
        let mut tally = vec![
            account.total(),
            account.vliw,
            account.switch,
            account.memory_stall,
            account.texture_stall,
            account.wait.values().sum(),
            data.hits,
            missed(data),
            texture.hits,
            missed(texture),
            sources.texture.samples,
            tni.unit.rays,
            tni.unit.hits,
            tni.trv.inner_visits,
            tni.trv.leaf_visits,
            tni.triangle_tests,
            tni.unit.resident_cycles,
            tni.trv_l1.hits,
            missed(&tni.trv_l1),
            tni.trv_l2.hits,
            missed(&tni.trv_l2),
            tni.ist_l1.hits,
            missed(&tni.ist_l1),
            self.read + self.tni_read,
            self.written,
        ];
        tally.resize(COLUMNS + self.kernels, 0);
        for (&kernel, &cycles) in &account.array {
            if let Some(cell) = tally.get_mut(COLUMNS + kernel as usize) {
                *cell = cycles;
            }
        }
        tally
    }
}

fn add(tallies: &mut [(u32, Tally)], tile: Option<u32>, column: usize, grown: u64) {
    if grown == 0 {
        return;
    }
    // The tiles in hand are the last that were taken.
    if let Some((_, tally)) = tallies.iter_mut().rev().find(|t| Some(t.0) == tile) {
        tally[column] += grown;
    }
}
