//! What each tile took: a core's account and counters, parted by the tile in whose service it was.
//!
//! A core works for one tile at a time: from the port's word that gives it the tile, or the hits of
//! one of its packets, until the next such word. What it waits for a packet belongs to that packet's
//! tile. The T&I unit says of each ray what it took; what its caches do is shared among the tiles whose
//! rays come back meanwhile, by their visits. So every cycle and every byte has a tile, but for those before a core's
//! first tile and after its last, and the sum is the whole.

use std::collections::{BTreeMap, VecDeque};

use super::data_cache::DataCache;
use super::report::Account;
use super::texture_cache::TextureCache;
use crate::memory::cache::CacheCounters;
use crate::tni::{RayCost, Tni};

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
    /// Bytes that the T&I unit has read from memory.
    TniBytes,
    /// Bytes that the data and texture caches have read.
    BytesRead,
    /// Bytes written to memory.
    BytesWritten,
}

/// Number of [`Column`]s; the cycles of each kernel follow.
pub const COLUMNS: usize = Column::BytesWritten as usize + 1;

/// Counters of one tile, or sums of several: by [`Column`], then by kernel.
pub type Tally = Vec<u64>;

/// Adds counters.
pub(super) fn add(sum: &mut Tally, more: &Tally) {
    sum.resize(sum.len().max(more.len()), 0);
    sum.iter_mut()
        .zip(more)
        .for_each(|(sum, more)| *sum += more);
}

/// Counts and parts.
#[derive(Clone, Debug, Default)]
pub(super) struct Ledger {
    /// The tile in hand: its place in the queue.
    current: Option<u32>,
    /// Whose packets the T&I unit has, oldest first.
    owners: VecDeque<Option<u32>>,
    /// Packets that have come back.
    back: u64,
    /// What rays took that have come back and are not charged yet.
    returned: BTreeMap<Option<u32>, Returned>,
    /// What has been charged already.
    charged: Tally,
    /// Of each tile taken: its place in the queue, and its counters.
    pub(super) tallies: Vec<(u32, Tally)>,
    /// Bytes of requests of the data and texture caches, and of the T&I unit.
    pub(super) read: u64,
    pub(super) written: u64,
    pub(super) tni_read: u64,
    /// What was in the service of no tile: before the first and after the last.
    pub(super) of_none: Tally,
    kernels: usize,
}

/// Rays of a tile.
#[derive(Clone, Copy, Debug, Default)]
struct Returned {
    rays: u64,
    visits: u64,
    tests: u64,
    cycles: u64,
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
            of_none: vec![0; COLUMNS + kernels],
            kernels,
            ..Ledger::default()
        }
    }

    /// The core takes the tile at this place of the queue, or none.
    pub(super) fn take_tile(&mut self, place: Option<u32>, sources: &Sources<'_>) {
        self.charge(sources);
        self.current = place;
        if let Some(place) = place {
            self.tallies.push((place, vec![0; COLUMNS + self.kernels]));
        }
    }

    /// A packet of the tile in hand goes to the T&I unit.
    pub(super) fn send_packet(&mut self) {
        self.owners.push_back(self.current);
    }

    /// Rays have come back.
    pub(super) fn take_rays(&mut self, costs: &[RayCost]) {
        for cost in costs {
            let packet = cost.submission.saturating_sub(self.back) as usize;
            let owner = self.owners.get(packet).copied().flatten();
            let returned = self.returned.entry(owner).or_default();
            returned.rays += 1;
            returned.visits += u64::from(cost.visits);
            returned.tests += u64::from(cost.tests);
            returned.cycles += cost.cycles;
        }
    }

    /// The oldest packet has come back.
    pub(super) fn take_packet(&mut self, sources: &Sources<'_>) {
        self.charge(sources);
        self.back += 1;
        if let Some(owner) = self.owners.pop_front() {
            self.current = owner;
        }
    }

    /// Charges what was counted since the last time.
    pub(super) fn charge(&mut self, sources: &Sources<'_>) {
        let mut now = self.look(sources);
        let in_unit = self.owners.front().copied().flatten().or(self.current);
        let waited = now[Column::Wait as usize] - self.charged[Column::Wait as usize];
        let returned = std::mem::take(&mut self.returned);
        let untimed = sources.tni.counts_no_costs();
        for (column, now) in now.iter_mut().enumerate() {
            let mut grown = *now - self.charged[column];
            if (Column::Rays as usize..=Column::TniBytes as usize).contains(&column) && !untimed {
                // Until rays come back it stays.
                if !self.share(column, grown, &returned) {
                    *now = self.charged[column];
                }
                continue;
            }
            if column == Column::Cycles as usize {
                grown -= waited;
            }
            let waits = column == Column::Wait as usize;
            let tile = if waits { in_unit } else { self.current };
            self.add(tile, column, grown);
        }
        self.add(in_unit, Column::Cycles as usize, waited);
        self.charged = now;
    }

    /// Shares what the T&I unit has counted among the tiles of the rays that have come back; whether
    /// there were any.
    fn share(
        &mut self,
        column: usize,
        grown: u64,
        returned: &BTreeMap<Option<u32>, Returned>,
    ) -> bool {
        let weight = |r: &Returned| match column {
            c if c == Column::Rays as usize || c == Column::Hits as usize => r.rays,
            c if c == Column::Tests as usize => r.tests,
            c if c == Column::Resident as usize => r.cycles,
            _ => r.visits,
        };
        let exact = [Column::Rays, Column::Tests, Column::Resident];
        let exact = exact.iter().any(|&c| c as usize == column);
        let all: u64 = returned.values().map(weight).sum();
        let (mut shared, mut of) = (0, 0);
        for (&tile, rays) in returned {
            of += weight(rays);
            let upto = match (exact, all) {
                (true, _) => of,
                (_, 0) => 0,
                _ => (u128::from(grown) * u128::from(of) / u128::from(all)) as u64,
            };
            self.add(tile, column, upto - shared);
            shared = upto;
        }
        exact || all > 0
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
            self.tni_read,
            self.read,
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

    fn add(&mut self, tile: Option<u32>, column: usize, grown: u64) {
        if grown == 0 {
            return;
        }
        // The tiles in hand are the last that were taken.
        let of_tile = self.tallies.iter_mut().rev().find(|t| Some(t.0) == tile);
        match of_tile {
            Some((_, tally)) => tally[column] += grown,
            None => self.of_none[column] += grown,
        }
    }
}
