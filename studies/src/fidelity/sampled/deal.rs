//! Tiles dealt out to cores as the frame would deal them, without its time: which core takes which, what its caches
//! hold meanwhile, and about how long it takes.

use std::sync::Arc;

use srp_archdesc::SystemSpec;

use srp_runtime::system::{Misses, WarmCaches};

use super::look::{Seen, View, Work};
use srp_runtime::memory::unloaded::unloaded_ns;

/// A tile of more packets may be in hand while a core takes several others.
const LONG: usize = 8;

/// Tiles that are run behind a unit, at most.
const MOST_BEHIND: usize = 24;

/// SRP cycles of a tile, a ray and a shaded hit: round figures of the default machine. They deal tiles out and make
/// strata; that they are not exact makes intervals wider.
const OF_TILE: f64 = 400.0;
const OF_RAY: f64 = 15.0;
const OF_SHADED: f64 = 10.0;

/// What is counted of tiles before they are run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    tiles: f64,
    work: Work,
    misses: Misses,
    /// SRP cycles for which cores wait for T&I units.
    wait: f64,
}

/// What things take, in SRP cycles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Takes {
    /// A miss of the data or the texture cache.
    miss: f64,
    /// A cycle of the T&I unit.
    tni_cycle: f64,
    /// Rays in a T&I unit.
    resident: f64,
}

impl Takes {
    pub(super) fn of(spec: &SystemSpec) -> Takes {
        let mhz = f64::from(spec.srp_mhz);
        Takes {
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
    pub(super) fn size(&self, takes: &Takes) -> f64 {
        let Work { rays, shaded, .. } = self.work;
        OF_TILE * self.tiles
            + OF_RAY * rays
            + OF_SHADED * shaded
            + takes.miss * (self.misses.data + self.misses.texture)
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
    seen: Seen,
    /// Its place among the core's tiles, and the caches before it where it may be in hand for long.
    place: usize,
    find: Option<Arc<WarmCaches>>,
    /// Packets that are done.
    done: usize,
    /// The unit that it is counted for.
    unit: usize,
    /// When its packet was sent.
    sent: f64,
}

impl Job {
    fn is_done(&self) -> bool {
        self.done == self.seen.packets()
    }
}

/// A core while tiles are dealt out.
pub(super) struct Hand {
    pub(super) tiles: Vec<u32>,
    /// Packets of each.
    packets: Vec<usize>,
    tags: WarmCaches,
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

/// The cores while tiles are dealt out.
pub(super) struct Deal {
    pub(super) hands: Vec<Hand>,
    /// Tiles of a unit.
    pub(super) length: usize,
    pub(super) takes: Takes,
}

impl Deal {
    /// Cores take packets of their jobs in turn, the core first that is free first, as the program in
    /// `kernels/frame.c` does, until one of them needs this tile; it takes it.
    pub(super) fn take(&mut self, tile: u32, seen: Seen) {
        loop {
            let busy = |c: usize| self.hands[c].busy;
            let cores = 1..self.hands.len();
            let core = cores.fold(0, |best, c| if busy(c) < busy(best) { c } else { best });
            if self.hands[core].needs_tile() {
                self.hands[core].take(tile, seen, self.length);
                return;
            }
            self.hands[core].run_packet(&self.takes);
        }
    }

    /// Runs what is left.
    pub(super) fn finish(&mut self) {
        for hand in &mut self.hands {
            while hand.jobs.iter().flatten().any(|job| !job.is_done()) {
                hand.run_packet(&self.takes);
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

impl Hand {
    pub(super) fn new(spec: &SystemSpec, view: &View<'_>) -> Hand {
        let jobs = jobs(spec);
        let tags = WarmCaches::new(spec, view.image);
        Hand {
            tiles: Vec::new(),
            packets: Vec::new(),
            next_start: (0, Arc::new(tags.clone())),
            tags,
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

    fn take(&mut self, tile: u32, seen: Seen, length: usize) {
        let place = self.tiles.len();
        let leads = (place + self.jobs.len()).is_multiple_of(length);
        let find = (leads || seen.packets() > LONG).then(|| Arc::new(self.tags.clone()));
        if place.is_multiple_of(length) {
            self.counts.push(Counts::default());
            self.starts.push(self.start());
        }
        if let Some(find) = find.as_ref().filter(|_| leads) {
            self.next_start = (place, Arc::clone(find));
        }
        let unit = place / length;
        self.counts[unit].tiles += 1.0;
        self.busy += OF_TILE;
        self.tiles.push(tile);
        self.packets.push(seen.packets());
        self.jobs[self.turn] = Some(Job {
            seen,
            place,
            find,
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
        let long = in_hand.filter_map(|job| Some((job.place, job.find.as_ref()?)));
        let (place, find) = &self.next_start;
        let oldest = long.chain([(*place, find)]).min_by_key(|l| l.0);
        let (place, find) = oldest.unwrap_or((*place, find));
        (place, Arc::clone(find))
    }

    /// Waits for the packet of the job whose turn it is, and shades it. The T&I unit takes packets one after the
    /// other, each as long as its rays fill the unit, and no shorter than its slowest ray.
    fn run_packet(&mut self, takes: &Takes) {
        if let Some(job) = self.jobs[self.turn].as_mut().filter(|job| !job.is_done()) {
            let (work, touched) = job.seen.packet(job.done);
            let misses = self.tags.read(touched);
            let lines = misses.tni.level2 + misses.tni.ist;
            let begun = self.traced.max(job.sent);
            let filled = takes.tni_cycle * work.resident + takes.miss * lines;
            self.traced = begun + filled / takes.resident;
            let back = self.traced.max(begun + takes.tni_cycle * work.slowest);
            let mut alone = Counts {
                wait: (back - self.busy).max(0.0),
                ..Counts::default()
            };
            alone.add(work, &misses);
            self.busy += alone.size(takes);
            self.counts[job.unit].add(work, &misses);
            self.counts[job.unit].wait += alone.wait;
            job.done += 1;
            job.sent = self.busy;
        }
        self.next_turn();
    }
}
