//! T&I units without SRPs: rays in, hits and counters out.
//!
//! A [`Bench`] has some units, which share one memory or have each their own. It is fed packets of
//! rays, dealt in blocks to the units in turn, and every unit takes them as fast as it can. Units that share
//! nothing may run on threads of their own; the counters are the same.

mod energy;
mod estimated;
mod fed_unit;
mod group;
mod measure;
mod quantity;
mod run_counts;
pub mod sampled;

use srp_archdesc::{Unwatched, Watch};
use std::collections::BTreeMap;
use std::sync::Arc;

use srp_archdesc::system::SystemSpec;

use self::fed_unit::{FedUnit, Packet, Role};
use self::group::Group;
use crate::rays::Sampling;
use srp_runtime::bvh::TreeImage;
use srp_runtime::memory::SystemMemory;
use srp_runtime::memory::dram::DramCounters;
use srp_runtime::tni::arithmetic::{Hit, Ray};
use srp_runtime::tni::{HitRecord, Logged, Runs, TniCounters, Tree, place_for};

pub use energy::Energy;
pub use estimated::Estimated;
pub use group::Memories;
pub use measure::Measure;
pub use quantity::{UnitFigure, UnitQuantity};
pub use run_counts::{RunCounts, figures};

/// Packets that go to the same unit one after another: neighbours share what its caches hold.
const BLOCK: u64 = 16;

/// How units are run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// How many units.
    pub units: u32,
    /// True if they share the memory.
    pub memories: Memories,
    /// Threads of the host.
    pub threads: usize,
    /// True if hits are kept.
    pub hits: bool,
    /// True if the cost of each pixel is kept.
    pub costs: bool,
}

/// The cost of the rays of one pixel; the rays' payload names the pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PixelCost {
    /// Cycles from dispatch to result, summed over the rays.
    pub cycles: u64,
    /// Nodes visited.
    pub visits: u64,
    /// Triangles tested.
    pub tests: u64,
}

/// A ray that has come back: its hit and its cost. It is kept where both hits and costs are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracedRay {
    /// The ray.
    pub ray: Ray,
    /// Its hit.
    pub hit: Hit,
    /// Cycles of the unit from its dispatch to its result.
    pub cycles: u64,
    /// Nodes visited, inner ones and leaves.
    pub visits: u32,
    /// Triangles tested.
    pub tests: u32,
}

/// Hits and counters of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Cycles from the first ray to the last hit, of the unit that took longest.
    pub cycles: u64,
    /// Counters of all units.
    pub counters: TniCounters,
    /// Counters of each memory.
    pub dram: Vec<DramCounters>,
    /// Bytes that moved between the memories and the units.
    pub bytes: u64,
    /// Half the width of the 95 % confidence interval of the cycles a ray, over their mean, from
    /// the spread between runs of packets; `None` of fewer than two runs, and where all rays were run.
    pub relative_error: Option<f64>,
    /// Units that had rays.
    pub at_work: u64,
    /// Counts of each run of packets.
    pub spent: Vec<RunCounts>,
    /// The hits in the order of the rays, where they were kept.
    pub hits: Vec<HitRecord>,
    /// The rays in their order, where hits and costs were kept.
    pub rays: Vec<TracedRay>,
    /// The runs of hits of each packet, in order, where hits were kept.
    pub runs: Vec<Runs>,
    /// By pixel, where costs were kept.
    pub costs: Vec<PixelCost>,
}

/// T&I units with their memory, and the rays on their way to them.
pub struct Bench<'a> {
    spec: &'a SystemSpec,
    memory: &'a SystemMemory,
    options: Options,
    groups: Vec<Group>,
    /// Packets that have come, and packets that were measured.
    come: u64,
    dealt: u64,
    /// Rays of each run.
    rays: BTreeMap<u64, u64>,
}

impl<'a> Bench<'a> {
    /// Idle units with empty caches over a tree in memory.
    pub fn new(
        spec: &'a SystemSpec,
        memory: &'a SystemMemory,
        tree: Tree,
        options: Options,
    ) -> Bench<'a> {
        let units = (0..options.units.max(1)).map(|_| FedUnit::new(spec, tree, &options));
        let groups = match options.memories {
            Memories::Shared => vec![Group::new(spec, units.collect())],
            Memories::Private => units.map(|u| Group::new(spec, vec![u])).collect(),
        };
        Bench {
            spec,
            memory,
            options,
            groups,
            come: 0,
            dealt: 0,
            rays: BTreeMap::new(),
        }
    }

    /// Takes rays in packets of the machine's size, those that `sampling` measures, and runs until
    /// all but the last of them are in the units. `false` where the watch ended that.
    pub fn feed(&mut self, rays: Vec<Ray>, sampling: &Sampling, watch: &dyn Watch) -> bool {
        let rays: Arc<[Ray]> = rays.into();
        let size = self.spec.buffers.rays.max(1) as usize;
        for first in (0..rays.len()).step_by(size) {
            let packet = self.come;
            self.come += 1;
            let Some(run) = sampling.run_of(packet) else {
                continue;
            };
            let range = first..rays.len().min(first + size);
            *self.rays.entry(run).or_default() += range.len() as u64;
            self.deal(Packet {
                rays: Arc::clone(&rays),
                range,
                run,
                number: self.dealt,
                role: Role::Measured,
                is_last: false,
            });
            self.dealt += 1;
        }
        self.run(false, watch)
    }

    fn deal(&mut self, packet: Packet) {
        let block = packet.number / BLOCK;
        let unit = block % u64::from(self.options.units.max(1));
        self.fed_unit(unit as usize).push(packet);
    }

    fn fed_unit(&mut self, unit: usize) -> &mut FedUnit {
        match self.options.memories {
            Memories::Shared => &mut self.groups[0].units[unit],
            Memories::Private => &mut self.groups[unit].units[0],
        }
    }

    /// Runs until every unit has taken its packets, or has finished them.
    fn run(&mut self, to_the_end: bool, watch: &dyn Watch) -> bool {
        let memory = self.memory;
        let workers = self.options.threads.clamp(1, self.groups.len());
        if workers == 1 {
            let run = |g: &mut Group| g.run(memory, to_the_end, watch);
            return self.groups.iter_mut().all(run);
        }
        let share = self.groups.len().div_ceil(workers);
        std::thread::scope(|scope| {
            let work = |groups: &'_ mut [Group]| {
                groups.iter_mut().all(|g| g.run(memory, to_the_end, watch))
            };
            let threads: Vec<_> = self
                .groups
                .chunks_mut(share)
                .map(|groups| scope.spawn(move || work(groups)))
                .collect();
            let mut all = true;
            for thread in threads {
                match thread.join() {
                    Ok(ended) => all &= ended,
                    Err(panic) => std::panic::resume_unwind(panic),
                }
            }
            all
        })
    }

    /// Runs until the last ray is back; `None` where the watch ended that.
    pub fn finish(mut self, watch: &dyn Watch) -> Option<Outcome> {
        if !self.run(true, watch) {
            return None;
        }
        let mut outcome = Outcome {
            cycles: 0,
            counters: TniCounters::default(),
            dram: Vec::new(),
            bytes: 0,
            relative_error: self.relative_error(),
            at_work: 0,
            spent: self.spent_by_run().into_values().map(|(s, _)| s).collect(),
            hits: Vec::new(),
            rays: Vec::new(),
            runs: Vec::new(),
            costs: Vec::new(),
        };
        let mut packets = Vec::new();
        for group in self.groups {
            let dram = group.dram();
            outcome.bytes += dram.bytes_read + dram.bytes_written;
            outcome.dram.push(dram);
            for unit in group.units {
                outcome.cycles = outcome.cycles.max(unit.end());
                outcome.counters.add(&unit.tni.counters());
                outcome.at_work += u64::from(unit.tni.rays() > 0);
                unit.add_costs(&mut outcome.costs);
                packets.extend(unit.answers);
            }
        }
        packets.sort_by_key(|answer| answer.number);
        for answer in packets {
            outcome.hits.extend(answer.hits);
            outcome.rays.extend(answer.rays);
            outcome.runs.push(answer.runs);
        }
        Some(outcome)
    }

    /// Returns the cost and the counters of each run, of all units together.
    fn spent_by_run(&self) -> BTreeMap<u64, (RunCounts, TniCounters)> {
        let mut runs: BTreeMap<u64, (RunCounts, TniCounters)> = BTreeMap::new();
        let units = self.groups.iter().flat_map(|g| &g.units);
        for (run, spent, counted) in units.flat_map(FedUnit::spent) {
            let sum = runs.entry(run).or_default();
            sum.0.add(&spent);
            sum.1.add(&counted);
        }
        runs
    }

    fn relative_error(&self) -> Option<f64> {
        let cycles = self.spent_by_run();
        let values: Vec<f64> = (cycles.values().zip(self.rays.values()))
            .map(|((spent, _), &rays)| spent.cycles() as f64 / rays as f64)
            .collect();
        crate::survey::relative_error(&values)
    }

    /// Notes everything that happens to rays, for a look at single ones.
    pub fn note_events(&mut self) {
        for group in &mut self.groups {
            for unit in &mut group.units {
                unit.tni.note_events();
            }
        }
    }

    /// Runs until the last ray is back, and gives what has happened in the first unit.
    pub fn run_out(mut self) -> Vec<Logged> {
        self.run(true, &Unwatched);
        self.groups[0].units[0].tni.take_events()
    }
}

/// Runs `rays` through one unit of the machine, in packets of the machine's size. Hits are kept.
pub fn drive(spec: &SystemSpec, tree: &TreeImage, rays: &[Ray]) -> Outcome {
    let one = Options {
        units: 1,
        memories: Memories::Private,
        threads: 1,
        hits: true,
        costs: false,
    };
    let (memory, tree) = place_for(spec, tree);
    let mut bench = Bench::new(spec, &memory, tree, one);
    let all = Sampling::new(1, rays.len() as u64);
    bench.feed(rays.to_vec(), &all, &Unwatched);
    bench.finish(&Unwatched).expect("nobody has cancelled it")
}
