//! Counters of each tile: an observer that assigns a core's account and counters to the tile that it works
//! for.
//!
//! A core works for one tile at a time: from the port's word that gives it the tile, or the hits of one of
//! its packets, until the next such word. Cycles in which it waits for a packet belong to that packet's tile.
//! The T&I unit gives the cost of each ray; the work of its caches is shared among the tiles whose rays come
//! back meanwhile, by their visits. So every cycle and every byte has a tile, but for those before a core's
//! first tile and after its last, and the sum is the whole.

use std::collections::{BTreeMap, VecDeque};

use srp_archdesc::Arch;

use srp_runtime::core::Core;
use srp_runtime::memory::cache::CacheCounters;
use srp_runtime::scene_image::SceneImage;
use srp_runtime::system::{
    self, CoreView, MemoryRequest, Observer, Options, Report, Requester, SentPacket, SystemError,
    TakenTile, Timing,
};
use srp_runtime::tni::{HitRecord, RayCost};

/// A counter of each tile, apart from the kernels' cycles.
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

/// Counters of a frame, or of a part of one.
#[derive(Clone, Debug)]
pub struct Part {
    /// The account of all of it.
    pub report: Report,
    /// Counters of each of its tiles, by the tile's place in the queue.
    pub tallies: Vec<Tally>,
    /// Counters of all cores before their first tiles and after their last.
    pub around: Tally,
}

/// Runs a frame, or the tiles that the options have, with what each tile took; the image gets the pixels.
///
/// # Errors
///
/// Those of [`system::run`].
pub fn render_tiles(
    image: &mut SceneImage,
    engines: Vec<Box<dyn Core>>,
    arch: &Arch,
    options: Options<'_>,
) -> Result<Part, SystemError> {
    let kernels = options.kernel_names.len();
    let mut ledger = Ledger::new(engines.len(), kernels, options.timing);
    let options = Options {
        observer: Some(&mut ledger),
        ..options
    };
    let report = system::run(image, engines, arch, options)?;
    let (tallies, around) = ledger.tallies();
    Ok(Part {
        report,
        tallies,
        around,
    })
}

/// Parts what the cores of a system count by tiles.
#[derive(Clone, Debug)]
struct Ledger {
    cores: Vec<CoreLedger>,
}

impl Ledger {
    /// For so many cores whose units keep time so, and a program with so many kernels.
    fn new(cores: usize, kernels: usize, timing: Timing) -> Ledger {
        let core = CoreLedger {
            charged: vec![0; COLUMNS + kernels],
            of_none: vec![0; COLUMNS + kernels],
            kernels,
            rays_return: timing == Timing::Full,
            ..CoreLedger::default()
        };
        Ledger {
            cores: vec![core; cores],
        }
    }

    fn core(&mut self, core: &CoreView<'_>) -> &mut CoreLedger {
        &mut self.cores[core.core as usize]
    }

    /// Of each tile, by its place in the queue, its counters; and what was in the service of no tile: before
    /// the first and after the last of each core.
    fn tallies(self) -> (Vec<Tally>, Tally) {
        let mut around = Tally::new();
        let mut tallies = Vec::new();
        for core in self.cores {
            add(&mut around, &core.of_none);
            for (place, tally) in core.tallies {
                let place = place as usize;
                tallies.resize(tallies.len().max(place + 1), Tally::new());
                tallies[place] = tally;
            }
        }
        (tallies, around)
    }
}

impl Observer for Ledger {
    fn tile_taken(&mut self, core: &CoreView<'_>, taken: Option<TakenTile>) {
        let place = taken.map(|taken| taken.place);
        self.core(core).take_tile(place, core);
    }

    fn packet_sent(&mut self, core: &CoreView<'_>, _packet: &SentPacket<'_>) {
        self.core(core).send_packet();
    }

    fn ray_returned(&mut self, core: u32, _cycle: u64, cost: &RayCost) {
        self.cores[core as usize].take_ray(cost);
    }

    fn packet_returned(&mut self, core: &CoreView<'_>, _packet: u64, _hits: &[HitRecord]) {
        self.core(core).take_packet(core);
    }

    fn requested(&mut self, core: &CoreView<'_>, request: &MemoryRequest) {
        let bytes = u64::from(request.bytes);
        let ledger = self.core(core);
        match (request.requester, request.is_write) {
            (Requester::Tni(_), _) => ledger.tni_read += bytes,
            (_, false) => ledger.read += bytes,
            (_, true) => ledger.written += bytes,
        }
    }

    fn finished(&mut self, core: &CoreView<'_>) {
        self.core(core).charge(core);
    }
}

/// Parts what one core counts.
#[derive(Clone, Debug, Default)]
struct CoreLedger {
    /// The tile in hand: its place in the queue.
    current: Option<u32>,
    /// Whose packets the T&I unit has, oldest first.
    owners: VecDeque<Option<u32>>,
    /// Packets that have come back.
    back: u64,
    /// Costs of rays that have come back and are not charged yet.
    returned: BTreeMap<Option<u32>, Returned>,
    /// True if the T&I unit tells of every ray that comes back.
    rays_return: bool,
    /// The sum of all that has been charged already.
    charged: Tally,
    /// Of each tile taken: its place in the queue, and its counters.
    tallies: Vec<(u32, Tally)>,
    /// Bytes of requests of the data and texture caches, and of the T&I unit.
    read: u64,
    written: u64,
    tni_read: u64,
    of_none: Tally,
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

impl CoreLedger {
    /// The core takes the tile at this place of the queue, or none.
    fn take_tile(&mut self, place: Option<u32>, core: &CoreView<'_>) {
        self.charge(core);
        self.current = place;
        if let Some(place) = place {
            self.tallies.push((place, vec![0; COLUMNS + self.kernels]));
        }
    }

    /// A packet of the tile in hand goes to the T&I unit.
    fn send_packet(&mut self) {
        self.owners.push_back(self.current);
    }

    /// A ray has come back.
    fn take_ray(&mut self, cost: &RayCost) {
        let packet = cost.submission.saturating_sub(self.back) as usize;
        let owner = self.owners.get(packet).copied().flatten();
        let returned = self.returned.entry(owner).or_default();
        returned.rays += 1;
        returned.visits += u64::from(cost.visits);
        returned.tests += u64::from(cost.tests);
        returned.cycles += cost.cycles;
    }

    /// The oldest packet has come back.
    fn take_packet(&mut self, core: &CoreView<'_>) {
        self.charge(core);
        self.back += 1;
        if let Some(owner) = self.owners.pop_front() {
            self.current = owner;
        }
    }

    /// Charges what was counted since the last time.
    fn charge(&mut self, core: &CoreView<'_>) {
        let mut now = self.counters(core);
        let in_unit = self.owners.front().copied().flatten().or(self.current);
        let waited = now[Column::Wait as usize] - self.charged[Column::Wait as usize];
        let returned = std::mem::take(&mut self.returned);
        for (column, now) in now.iter_mut().enumerate() {
            let mut grown = *now - self.charged[column];
            if (Column::Rays as usize..=Column::TniBytes as usize).contains(&column)
                && self.rays_return
            {
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
    fn counters(&self, core: &CoreView<'_>) -> Tally {
        let account = core.account;
        let tni = core.tni();
        let missed = |c: &CacheCounters| c.misses + c.joined;
        let (data, texture) = (core.data_cache, core.texture_cache);
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
            core.texture_samples,
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
