//! A unit with its SRAM, and the packets that wait for it.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;
use std::sync::Arc;

use srp_archdesc::system::SystemSpec;

use super::run_counts::RunCounts;
use super::{Options, PixelCost, TracedRay};
use srp_runtime::tni::arithmetic::Ray;
use srp_runtime::tni::{
    Buffers, HIT_BYTES, HitRecord, RAY_BYTES, RayCost, Runs, Tni, TniCounters, Tree, WarmCaches,
};

/// Buffers for packets in front of a unit: so many that it never waits for rays because of one that
/// takes long.
const BUFFERS: u32 = 32;

/// A packet of rays.
#[derive(Clone, Debug)]
pub(super) struct Packet {
    pub(super) rays: Arc<[Ray]>,
    pub(super) range: Range<usize>,
    /// The run that it is measured in.
    pub(super) run: u64,
    /// Its place among all that are measured.
    pub(super) number: u64,
    pub(super) role: Role,
    /// True if the unit has nothing after it: its run ends when it is back, and not when it is taken.
    pub(super) is_last: bool,
}

/// The purpose of a packet.
#[derive(Clone, Debug)]
pub(super) enum Role {
    /// To be measured, as soon as there is room.
    Measured,
    /// To begin a stretch of so many rays, when no unit of the group has anything to do, with caches that
    /// hold these lines. The rays before it are a run of their own.
    First {
        caches: Arc<WarmCaches>,
        rays: u64,
        before: u64,
    },
    /// To keep a unit busy until all units of the group have taken their stretch.
    Company,
}

impl Packet {
    fn rays(&self) -> &[Ray] {
        &self.rays[self.range.clone()]
    }
}

/// The hits of a packet.
#[derive(Clone, Debug)]
pub(super) struct Answer {
    pub(super) number: u64,
    pub(super) hits: Vec<HitRecord>,
    pub(super) rays: Vec<TracedRay>,
    pub(super) runs: Runs,
}

/// A unit and what it is fed from.
pub(super) struct FedUnit {
    pub(super) tni: Tni,
    sram: Vec<u8>,
    /// Rays of a packet.
    packet: u32,
    waiting: VecDeque<Packet>,
    under_way: VecDeque<Packet>,
    /// Packets that were given to the unit, and packets that have come back.
    sent: u64,
    back: u64,
    /// Rays that the unit will have taken when it has taken all of a run that it has in hand.
    to_take: VecDeque<(u64, u64)>,
    /// The cycle after that in which the last ray of each run was taken, and what had been counted then. What is under
    /// way then is that of the run's last rays, as it is that of others' when the run begins.
    taken: BTreeMap<u64, (u64, TniCounters)>,
    /// The cycle after that in which the last packet came back.
    end: u64,
    /// Rays that the unit will have taken at the end of its stretch.
    stretch: u64,
    keep_hits: bool,
    pub(super) answers: Vec<Answer>,
    costs: BTreeMap<u32, PixelCost>,
    /// Where rays are kept, the costs of those of packets that are under way, by packet and place in it.
    of_rays: Option<BTreeMap<(u64, u32), RayCost>>,
}

impl FedUnit {
    pub(super) fn new(spec: &SystemSpec, tree: Tree, options: &Options) -> FedUnit {
        let packet = spec.buffers.rays.max(1);
        let mut tni = Tni::new(&spec.tni, tree, BUFFERS);
        if options.costs {
            tni.note_costs();
        }
        FedUnit {
            tni,
            sram: vec![0; (BUFFERS * packet * (RAY_BYTES + HIT_BYTES)) as usize],
            packet,
            waiting: VecDeque::new(),
            under_way: VecDeque::new(),
            sent: 0,
            back: 0,
            to_take: VecDeque::new(),
            taken: BTreeMap::new(),
            end: 0,
            stretch: 0,
            keep_hits: options.hits,
            answers: Vec::new(),
            costs: BTreeMap::new(),
            of_rays: (options.hits && options.costs).then(BTreeMap::new),
        }
    }

    pub(super) fn push(&mut self, packet: Packet) {
        self.waiting.push_back(packet);
    }

    /// True if no packet waits for the unit.
    pub(super) fn is_fed(&self) -> bool {
        self.waiting.is_empty()
    }

    /// True if all packets are back.
    pub(super) fn is_done(&self) -> bool {
        self.waiting.is_empty() && self.under_way.is_empty()
    }

    /// True if it has nothing to do.
    pub(super) fn is_idle(&self) -> bool {
        self.under_way.is_empty()
    }

    /// True if the unit has not taken all of its stretch.
    pub(super) fn is_in_stretch(&self) -> bool {
        self.tni.rays() < self.stretch
    }

    /// Gives the unit packets, as long as buffers are free: a buffer is, once the submission that
    /// used it last has been taken. `all_idle` and `in_stretch` say whether no unit, and any, of the group is.
    #[inline]
    pub(super) fn fill(&mut self, now: u64, all_idle: bool, in_stretch: bool) {
        while self.tni.submissions() < BUFFERS as usize {
            let Some(packet) = self.waiting.front() else {
                return;
            };
            match &packet.role {
                Role::Measured => {}
                Role::First { .. } if !all_idle || !self.is_idle() => return,
                Role::First {
                    caches,
                    rays,
                    before,
                } => {
                    self.tni.hold(caches);
                    self.stretch = self.tni.rays() + rays;
                    self.taken.insert(*before, (now, self.tni.counters()));
                }
                Role::Company if !in_stretch && !self.is_in_stretch() => {
                    self.waiting.pop_front();
                    continue;
                }
                // No sooner than it is needed.
                Role::Company if !self.to_take.is_empty() => return,
                Role::Company => {}
            }
            let Some(packet) = self.waiting.pop_front() else {
                return;
            };
            let (rays, hits) = self.buffer(self.sent);
            write_rays(&mut self.sram[rays as usize..], packet.rays());
            let count = packet.range.len() as u32;
            let buffers = Buffers { rays, hits, count };
            self.tni
                .submit(buffers, self.sram.len())
                .expect("the buffers lie inside the SRAM, and the unit has room");
            self.sent += 1;
            let before = self.to_take.back().map_or(self.tni.rays(), |last| last.1);
            self.to_take
                .push_back((packet.run, before + u64::from(count)));
            self.under_way.push_back(packet);
        }
    }

    /// One cycle of the unit.
    #[inline]
    pub(super) fn tick(&mut self, now: u64, memory: &srp_runtime::memory::SystemMemory) {
        if !self.tni.is_idle() {
            self.tni.tick(now, memory, &mut self.sram);
        }
    }

    /// Takes what the unit has finished by the end of cycle `now`.
    #[inline]
    pub(super) fn collect(&mut self, now: u64) {
        while let Some(&(run, rays)) = self.to_take.front()
            && rays <= self.tni.rays()
        {
            self.to_take.pop_front();
            if self.to_take.front().is_none_or(|next| next.0 != run) {
                self.note_end(run, now + 1);
            }
        }
        while let Some(finished) = self.tni.take_finished() {
            self.note_costs();
            let packet = self
                .under_way
                .pop_front()
                .expect("what comes back was under way");
            self.end = now + 1;
            if packet.is_last {
                self.note_end(packet.run, self.end);
            }
            let (_, hits) = self.buffer(self.back);
            if self.keep_hits {
                let hits = read_hits(&self.sram[hits as usize..], packet.range.len());
                let rays = self.traced(&packet, &hits);
                self.answers.push(Answer {
                    number: packet.number,
                    rays,
                    hits,
                    runs: finished.runs,
                });
            }
            self.back += 1;
        }
    }

    /// A run has ended: the accounts of pipelines, which take a copy of the unit, are those of stretches only.
    fn note_end(&mut self, run: u64, now: u64) {
        let counters = match self.stretch {
            0 => self.tni.progress(),
            _ => self.tni.counters(),
        };
        self.taken.insert(run, (now, counters));
    }

    fn note_costs(&mut self) {
        for cost in self.tni.take_costs() {
            let packet = &self.under_way[(cost.submission - self.back) as usize];
            let pixel = packet.rays()[cost.index as usize].payload;
            let sum = self.costs.entry(pixel).or_default();
            sum.cycles += cost.cycles;
            sum.visits += u64::from(cost.visits);
            sum.tests += u64::from(cost.tests);
            if let Some(of_rays) = &mut self.of_rays {
                of_rays.insert((cost.submission, cost.index), cost);
            }
        }
    }

    /// The rays of the packet that has come back, where they are kept.
    fn traced(&mut self, packet: &Packet, hits: &[HitRecord]) -> Vec<TracedRay> {
        let Some(of_rays) = &mut self.of_rays else {
            return Vec::new();
        };
        let later = of_rays.split_off(&(self.back + 1, 0));
        let costs = std::mem::replace(of_rays, later).into_values();
        let all = packet.rays().iter().zip(hits).zip(costs);
        all.map(|((&ray, record), cost)| TracedRay {
            ray,
            hit: record.hit,
            cycles: cost.cycles,
            visits: cost.visits,
            tests: cost.tests,
        })
        .collect()
    }

    /// Adds what each pixel has cost here.
    pub(super) fn add_costs(&self, costs: &mut Vec<PixelCost>) {
        for (&pixel, cost) in &self.costs {
            let pixel = pixel as usize;
            if costs.len() <= pixel {
                costs.resize(pixel + 1, PixelCost::default());
            }
            costs[pixel].cycles += cost.cycles;
            costs[pixel].visits += cost.visits;
            costs[pixel].tests += cost.tests;
        }
    }

    /// Cycles until the last packet came back.
    pub(super) fn end(&self) -> u64 {
        self.end
    }

    /// Returns cycles and counters of each run, from the last ray of its predecessor to its own. Where
    /// packets followed each other without stretches, the last run goes on until everything is back.
    pub(super) fn spent(&self) -> impl Iterator<Item = (u64, RunCounts, TniCounters)> {
        let last = self.taken.keys().next_back().copied();
        let drained = last.filter(|_| self.stretch == 0 && self.is_done());
        let mut before = (0, TniCounters::default());
        self.taken.iter().map(move |(&run, &taken)| {
            let end = match drained == Some(run) {
                true => (self.end, self.tni.progress()),
                false => taken,
            };
            let of = RunCounts::at(end.0, &end.1).since(&RunCounts::at(before.0, &before.1));
            let counted = TniCounters {
                trvs: end.1.trvs,
                ists: end.1.ists,
                ..end.1.since(&before.1)
            };
            before = end;
            (run, of, counted)
        })
    }

    /// Addresses of the ray and the hit buffer of a packet.
    fn buffer(&self, packet: u64) -> (u32, u32) {
        let buffer = (packet % u64::from(BUFFERS)) as u32;
        let hits = BUFFERS * self.packet * RAY_BYTES;
        (
            buffer * self.packet * RAY_BYTES,
            hits + buffer * self.packet * HIT_BYTES,
        )
    }
}

pub(super) fn write_rays(sram: &mut [u8], rays: &[Ray]) {
    let words = rays.iter().flat_map(|ray| ray.words());
    for (bytes, word) in sram.chunks_exact_mut(4).zip(words) {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
}

/// The hits of a packet in the order of its rays.
fn read_hits(sram: &[u8], count: usize) -> Vec<HitRecord> {
    let mut hits: Vec<HitRecord> = sram
        .chunks_exact(HIT_BYTES as usize)
        .take(count)
        .map(|bytes| {
            let mut words = [0; 6];
            for (word, bytes) in words.iter_mut().zip(bytes.chunks_exact(4)) {
                *word = u32::from_le_bytes(bytes.try_into().expect("chunks of 4 bytes"));
            }
            HitRecord::from_words(words)
        })
        .collect();
    hits.sort_by_key(|record| record.ray);
    hits
}
