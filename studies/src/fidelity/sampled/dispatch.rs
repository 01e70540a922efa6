//! Dispatches tiles to cores as the frame would, without its time: models which core takes which tile, the
//! contents of its caches meanwhile, and about how long it takes.

use std::collections::HashMap;
use std::sync::Arc;

use srp_archdesc::SystemSpec;

use srp_runtime::system::{Misses, TileQueue, WarmCaches};

use super::trace::{TileTrace, TracedFrame, Work};
use srp_runtime::memory::unloaded::unloaded_ns;

/// A tile of more packets may be in hand while a core takes several others.
const LONG: usize = 8;

/// Tiles that are run behind a unit, at most.
const MOST_BEHIND: usize = 24;

/// SRP cycles of a tile, a ray and a shaded hit: round figures of the default machine. They dispatch tiles and make
/// strata; that they are not exact makes intervals wider.
const OF_TILE: f64 = 400.0;
const OF_RAY: f64 = 15.0;
const OF_SHADED: f64 = 10.0;

/// Counts of tiles, from before they are run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    tiles: f64,
    work: Work,
    misses: Misses,
    /// SRP cycles for which cores wait for T&I units.
    wait: f64,
}

/// Times of things, in SRP cycles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Costs {
    /// A miss of the data or the texture cache.
    miss: f64,
    /// A cycle of the T&I unit.
    tni_cycle: f64,
    /// Rays in a T&I unit.
    resident: f64,
}

impl Costs {
    pub(super) fn of(spec: &SystemSpec) -> Costs {
        let mhz = f64::from(spec.srp_mhz);
        Costs {
            miss: unloaded_ns(spec) * mhz * 1e-3,
            tni_cycle: mhz / f64::from(spec.tni_mhz.max(1)),
            resident: f64::from((spec.tni.trvs * spec.tni.stacks).max(1)),
        }
    }
}

impl Counts {
    fn add(&mut self, work: &Work, misses: &Misses) {
        self.work.rays += work.rays;
        self.work.shaded += work.shaded;
        self.work.visits += work.visits;
        self.work.tests += work.tests;
        self.work.samples += work.samples;
        self.work.resident += work.resident;
        self.work.slowest += work.slowest;
        self.misses.data += misses.data;
        self.misses.texture += misses.texture;
        self.misses.tni.add(&misses.tni);
    }

    /// About the SRP cycles.
    pub(super) fn size(&self, costs: &Costs) -> f64 {
        let Work { rays, shaded, .. } = self.work;
        OF_TILE * self.tiles
            + OF_RAY * rays
            + OF_SHADED * shaded
            + costs.miss * (self.misses.data + self.misses.texture)
            + self.wait
    }

    /// The auxiliary variables of a unit of this size, the most telling first.
    pub(super) fn auxiliaries(&self, size: f64) -> Vec<f64> {
        let (work, misses) = (&self.work, &self.misses);
        vec![
            size,
            self.tiles,
            self.wait,
            misses.data,
            misses.texture,
            work.visits,
            work.shaded,
            work.rays,
            misses.tni.level2,
            misses.tni.level1,
            misses.tni.ist,
            work.tests,
            work.samples,
            work.resident,
            work.slowest,
        ]
    }
}

/// A tile that a core has in hand.
struct Job {
    trace: TileTrace,
    /// Its place among the core's tiles, and the caches before it where it may be in hand for long.
    place: usize,
    caches: Option<Arc<WarmCaches>>,
    /// Packets that are done.
    done: usize,
    /// The unit that it is counted for.
    unit: usize,
    /// When its packet was sent.
    sent: f64,
}

impl Job {
    fn is_done(&self) -> bool {
        self.done == self.trace.packets()
    }
}

/// A core while tiles are dispatched.
pub(super) struct CoreModel {
    pub(super) tiles: Vec<u32>,
    /// Packets of each.
    packets: Vec<usize>,
    caches: WarmCaches,
    /// When it has done what it has, and when its T&I unit has.
    busy: f64,
    traced: f64,
    /// The tiles in hand, and the place whose turn it is.
    jobs: Vec<Option<Job>>,
    turn: usize,
    /// Of each unit what is counted, and where it is to be run from.
    pub(super) counts: Vec<Counts>,
    pub(super) starts: Vec<(usize, Arc<WarmCaches>)>,
    /// Where the next unit is run from, unless something is still in hand from before.
    next_start: (usize, Arc<WarmCaches>),
}

/// The cores while tiles are dispatched.
pub(super) struct Dispatch {
    pub(super) cores: Vec<CoreModel>,
    /// Tiles of a unit.
    pub(super) length: usize,
    pub(super) costs: Costs,
    /// The tiles that are left, as the frame deals them.
    queue: TileQueue,
    /// Traced tiles that no core has taken yet.
    traced: HashMap<u32, TileTrace>,
    /// A core that has got a tile which is not traced yet.
    wanted: Option<(usize, u32)>,
    /// The cores that still get tiles.
    open: Vec<usize>,
}

impl Dispatch {
    /// Cores with nothing in hand, units of so many tiles, and all tiles in a queue.
    pub(super) fn new(
        cores: Vec<CoreModel>,
        length: usize,
        costs: Costs,
        queue: TileQueue,
    ) -> Dispatch {
        Dispatch {
            open: (0..cores.len()).collect(),
            cores,
            length,
            costs,
            queue,
            traced: HashMap::new(),
            wanted: None,
        }
    }

    /// A tile has been traced. Cores run packets of their jobs in turn, the core first that is free first, as the
    /// program in `kernels/frame.c` does, until one of them gets a tile that has not.
    pub(super) fn tell(&mut self, tile: u32, trace: TileTrace) {
        self.traced.insert(tile, trace);
        while let Some((core, tile)) = self.wanted.take().or_else(|| self.next()) {
            let Some(trace) = self.traced.remove(&tile) else {
                self.wanted = Some((core, tile));
                return;
            };
            self.cores[core].take(tile, trace, self.length);
        }
    }

    /// Runs packets until a core gets a tile; `None` where none is left.
    fn next(&mut self) -> Option<(usize, u32)> {
        loop {
            let free = |c: &usize, d: &usize| self.cores[*c].busy.total_cmp(&self.cores[*d].busy);
            let core = *self.open.iter().min_by(|c, d| free(c, d))?;
            if !self.cores[core].needs_tile() {
                self.cores[core].run_packet(&self.costs);
            } else if let Some((_, queued)) = self.queue.take(core as u32) {
                return Some((core, queued.tile));
            } else {
                self.open.retain(|&other| other != core);
            }
        }
    }

    /// Runs what is left.
    pub(super) fn finish(&mut self) {
        for core in &mut self.cores {
            while core.jobs.iter().flatten().any(|job| !job.is_done()) {
                core.run_packet(&self.costs);
            }
        }
    }
}

/// Tiles that a core has in hand at a time.
pub(super) fn jobs(spec: &SystemSpec) -> usize {
    let buffers = spec.buffers;
    let jobs = buffers
        .hit_buffers
        .min(buffers.ray_buffers.saturating_sub(1));
    jobs.max(1) as usize
}

impl CoreModel {
    pub(super) fn new(spec: &SystemSpec, frame: &TracedFrame<'_>) -> CoreModel {
        let jobs = jobs(spec);
        let caches = WarmCaches::new(spec, frame.image);
        CoreModel {
            tiles: Vec::new(),
            packets: Vec::new(),
            next_start: (0, Arc::new(caches.clone())),
            caches,
            busy: 0.0,
            traced: 0.0,
            jobs: (0..jobs).map(|_| None).collect(),
            turn: 0,
            counts: Vec::new(),
            starts: Vec::new(),
        }
    }

    fn needs_tile(&self) -> bool {
        self.jobs[self.turn].as_ref().is_none_or(Job::is_done)
    }

    fn next_turn(&mut self) {
        self.turn = (self.turn + 1) % self.jobs.len();
    }

    fn take(&mut self, tile: u32, trace: TileTrace, length: usize) {
        let place = self.tiles.len();
        let leads = (place + self.jobs.len()).is_multiple_of(length);
        let caches = (leads || trace.packets() > LONG).then(|| Arc::new(self.caches.clone()));
        if place.is_multiple_of(length) {
            self.counts.push(Counts::default());
            self.starts.push(self.start());
        }
        if let Some(caches) = caches.as_ref().filter(|_| leads) {
            self.next_start = (place, Arc::clone(caches));
        }
        let unit = place / length;
        self.counts[unit].tiles += 1.0;
        self.busy += OF_TILE;
        self.tiles.push(tile);
        self.packets.push(trace.packets());
        self.jobs[self.turn] = Some(Job {
            trace,
            place,
            caches,
            done: 0,
            unit,
            sent: self.busy,
        });
        self.next_turn();
    }

    /// The place behind the last tile that is to be run for a unit that ends before `end`: with so many behind
    /// it that its last tiles are in hand together with others until they are done.
    pub(super) fn end(&self, end: usize) -> usize {
        let last = self.packets[..end].iter().rev().take(self.jobs.len());
        let longest = last.max().copied().unwrap_or(0);
        let mut packets = 0;
        let behind = self.packets[end..].iter().take(MOST_BEHIND);
        let needed = behind.take_while(|&&more| {
            let before = packets;
            packets += more;
            before <= longest
        });
        end + needed
            .count()
            .max(self.jobs.len() - 1)
            .min(self.packets.len() - end)
    }

    /// Where a unit is to be run from that begins now: with the oldest tile that is still in hand.
    fn start(&self) -> (usize, Arc<WarmCaches>) {
        let in_hand = self.jobs.iter().flatten().filter(|job| !job.is_done());
        let long = in_hand.filter_map(|job| Some((job.place, job.caches.as_ref()?)));
        let (place, caches) = &self.next_start;
        let oldest = long.chain([(*place, caches)]).min_by_key(|l| l.0);
        let (place, caches) = oldest.unwrap_or((*place, caches));
        (place, Arc::clone(caches))
    }

    /// Waits for the packet of the job whose turn it is, and shades it. The T&I unit takes packets one after the
    /// other, each as long as its rays fill the unit, and no shorter than its slowest ray.
    fn run_packet(&mut self, costs: &Costs) {
        if let Some(job) = self.jobs[self.turn].as_mut().filter(|job| !job.is_done()) {
            let (work, touched) = job.trace.packet(job.done);
            let misses = self.caches.read(touched);
            let lines = misses.tni.level2 + misses.tni.ist;
            let begun = self.traced.max(job.sent);
            let filled = costs.tni_cycle * work.resident + costs.miss * lines;
            self.traced = begun + filled / costs.resident;
            let back = self.traced.max(begun + costs.tni_cycle * work.slowest);
            let mut alone = Counts {
                wait: (back - self.busy).max(0.0),
                ..Counts::default()
            };
            alone.add(work, &misses);
            self.busy += alone.size(costs);
            self.counts[job.unit].add(work, &misses);
            self.counts[job.unit].wait += alone.wait;
            job.done += 1;
            job.sent = self.busy;
        }
        self.next_turn();
    }
}
