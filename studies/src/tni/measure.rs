//! Figures from counters: rates, shares, and means a ray.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use srp_archdesc::system::SystemSpec;

use super::{Outcome, UnitFigure, UnitQuantity};
use crate::figure::estimate_of;
use srp_runtime::memory::cache::CacheCounters;
use srp_runtime::memory::dram::{DramCounters, DramReport};
use srp_runtime::memory::path::Clock;
use srp_runtime::tni::TniCounters;

/// Figures of one or several views, summed over all units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Measure {
    /// Rays traced.
    pub rays: u64,
    /// Cycles of the T&I clock until the last unit was done.
    pub cycles: u64,
    /// Units.
    pub units: u32,
    /// Million rays per second of simulated time, of all units that had rays together while they have
    /// them: that one unit ends before another does not count.
    pub mrays_per_second: f64,
    /// Half the width of its 95 % confidence interval over it; `None` of fewer than two runs, and
    /// where all rays were run.
    pub relative_error: Option<f64>,
    /// Visits of inner nodes a ray.
    pub inner_visits: f64,
    /// Visits of leaves a ray.
    pub leaf_visits: f64,
    /// Ray–triangle tests a ray.
    pub triangle_tests: f64,
    /// Ways through a sub-pipeline a ray, with work or without.
    pub passes: f64,
    /// Of these, ways without work: bypassed and recirculated.
    pub idle_passes: f64,
    /// Cycles that a ray is in the unit.
    pub residence: f64,
    /// Cycles that a visit takes on average: the residence without the time at intersection units,
    /// over the visits of inner nodes and leaves.
    pub cycles_per_visit: f64,
    /// Cycles in which any pipeline of a traversal unit held a ray, over all.
    pub trv_busy: f64,
    /// Cycles in which TRV_AABB began with a box, over all.
    pub trv_issue: f64,
    /// Cycles in which an intersection unit's pipeline held a ray, over all.
    pub ist_busy: f64,
    /// Cycles in which an intersection unit began with a triangle, over all.
    pub ist_issue: f64,
    /// Hit rate of the traversal units' level-1 caches, in front of which accesses that join an
    /// outstanding miss are no hits.
    pub trv_l1: f64,
    /// Hit rate of their level-2 cache.
    pub trv_l2: f64,
    /// Hit rate of the intersection units' caches.
    pub ist_l1: f64,
    /// Rays that wait in accumulation units of one T&I unit, on average.
    pub waiting_rays: f64,
    /// Lines that the level-1 caches of one T&I unit wait for, on average.
    pub outstanding: f64,
    /// Gigabytes per second of simulated time that moved between units and memories.
    pub gigabytes_per_second: f64,
    /// The report of the memory, or of the memories of all units.
    pub memory: DramReport,
    /// All counters.
    pub counters: TniCounters,
}

impl Measure {
    /// The figures of views that ran one after another on `units` units of a machine.
    pub fn of(views: &[Outcome], units: u32, spec: &SystemSpec) -> Measure {
        let mhz = spec.tni_mhz;
        let mut counters = TniCounters::default();
        let (mut cycles, mut bytes, mut error) = (0, 0, Some(0.0));
        for view in views {
            counters.add(&view.counters);
            cycles += view.cycles;
            bytes += view.bytes;
            let spread = view.relative_error.map(|e| e * view.cycles as f64);
            error = error.zip(spread).map(|(sum, s)| sum + s * s);
        }
        let c = &counters;
        let over = |n: u64, of: u64| if of == 0 { 0.0 } else { n as f64 / of as f64 };
        let a_ray = |n: u64| over(n, c.unit.rays);
        let active = c.unit.active_cycles;
        // Units that had no rays have no rate.
        let of_view = |v: &Outcome| v.counters.unit.active_cycles as f64 / v.at_work.max(1) as f64;
        let seconds = views.iter().map(of_view).sum::<f64>() / (f64::from(mhz) * 1e6);
        let per_second = |n: u64| if active == 0 { 0.0 } else { n as f64 / seconds };
        let pipes = [&c.pre, &c.aabb, &c.post];
        let idle = pipes.map(|p| p.bypasses + p.recirculated).iter().sum();
        let work: u64 = pipes.map(|p| p.passes).iter().sum();
        // Cycles are counted by unit and view, and so are the parts.
        let counted = views.len().max(1) as u64 * u64::from(units.max(1));
        let of_cycles = |n: u64, parts: u64| over(n, active * parts / counted);
        let rate = CacheCounters::hit_rate;
        Measure {
            rays: c.unit.rays,
            cycles,
            units,
            mrays_per_second: per_second(c.unit.rays) / 1e6,
            relative_error: error
                .filter(|_| cycles > 0)
                .map(|sum| sum.sqrt() / cycles as f64),
            inner_visits: a_ray(c.trv.inner_visits),
            leaf_visits: a_ray(c.trv.leaf_visits),
            triangle_tests: a_ray(c.triangle_tests),
            passes: a_ray(work + idle),
            idle_passes: a_ray(idle),
            residence: a_ray(c.unit.resident_cycles),
            cycles_per_visit: over(c.unit.resident_cycles - c.ist_cycles, c.node_visits()),
            trv_busy: of_cycles(c.trv.busy_cycles, c.trvs),
            trv_issue: of_cycles(c.aabb.account.work + c.aabb.account.occupied, c.trvs),
            ist_busy: of_cycles(c.ist.busy_cycles, c.ists),
            ist_issue: of_cycles(c.ist.account.work, c.ists),
            trv_l1: rate(&c.trv_l1),
            trv_l2: rate(&c.trv_l2),
            ist_l1: rate(&c.ist_l1),
            waiting_rays: over(c.trv_rau.occupancy + c.ist_rau.occupancy, active),
            outstanding: over(c.trv_rau.outstanding + c.ist_rau.outstanding, active),
            gigabytes_per_second: per_second(bytes) / 1e9,
            memory: memory(views, cycles, spec),
            counters,
        }
    }
}

impl Measure {
    /// The same with what a sample says of the rays that it stands for.
    pub fn with(mut self, sampled: &[UnitFigure]) -> Measure {
        use UnitQuantity as Q;
        let figures = [
            (Q::Rate, &mut self.mrays_per_second, 1.0),
            (Q::InnerNodesPerRay, &mut self.inner_visits, 1.0),
            (Q::LeavesPerRay, &mut self.leaf_visits, 1.0),
            (Q::TestsPerRay, &mut self.triangle_tests, 1.0),
            (Q::Residence, &mut self.residence, 1.0),
            (Q::TrvL1Hits, &mut self.trv_l1, 100.0),
            (Q::TrvL2Hits, &mut self.trv_l2, 100.0),
            (Q::IstL1Hits, &mut self.ist_l1, 100.0),
            (Q::Bandwidth, &mut self.gigabytes_per_second, 1.0),
        ];
        for (quantity, value, unit) in figures {
            if let Some(estimate) = estimate_of(sampled, &quantity) {
                *value = estimate.value / unit;
            }
        }
        let rate = estimate_of(sampled, &Q::Rate);
        self.relative_error = rate.map(|rate| rate.relative());
        self
    }
}

/// Returns the report of the memories in all views, `cycles` of the T&I clock long.
fn memory(views: &[Outcome], cycles: u64, spec: &SystemSpec) -> DramReport {
    let memories = views.iter().map(|v| v.dram.len()).max().unwrap_or(0);
    let mut all = DramCounters::default();
    for memory in 0..memories {
        let mut runs = DramCounters::default();
        for counters in views.iter().filter_map(|v| v.dram.get(memory)) {
            runs.add_run(counters);
        }
        all.add(&runs);
    }
    let time = Clock::new(spec.tni_mhz).start(cycles);
    let cycles = Clock::new(spec.dram.mhz).cycle_from(time);
    DramReport::of(&spec.dram, memories as u32, cycles, all)
}
