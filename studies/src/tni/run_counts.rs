//! Counts of runs of packets, and figures with intervals from the spread between them.

use srp_archdesc::system::SystemSpec;

use crate::survey::{Estimate, ratio};
use srp_runtime::tni::TniCounters;

use super::quantity::{UnitFigure, UnitQuantity};

/// An event that is counted of a run. A miss asks for a line, or joins one that does; a line is read from
/// memory.
#[derive(Clone, Copy)]
enum Count {
    Rays,
    Cycles,
    Hits,
    InnerVisits,
    LeafVisits,
    Tests,
    Resident,
    TrvL1Hits,
    TrvL1Misses,
    TrvL2Hits,
    TrvL2Misses,
    IstL1Hits,
    IstL1Misses,
    TrvL2Lines,
    IstL1Lines,
}

const COUNTS: usize = Count::IstL1Lines as usize + 1;

/// Counters of a run of packets, by [`Count`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RunCounts([u64; COUNTS]);

impl RunCounts {
    /// Everything up to a cycle.
    pub(super) fn at(cycles: u64, c: &TniCounters) -> RunCounts {
        RunCounts([
            c.unit.rays,
            cycles,
            c.unit.hits,
            c.trv.inner_visits,
            c.trv.leaf_visits,
            c.triangle_tests,
            c.unit.resident_cycles,
            c.trv_l1.hits,
            c.trv_l1.misses + c.trv_l1.joined,
            c.trv_l2.hits,
            c.trv_l2.misses + c.trv_l2.joined,
            c.ist_l1.hits,
            c.ist_l1.misses + c.ist_l1.joined,
            c.trv_l2.misses,
            c.ist_l1.misses,
        ])
    }

    /// Returns the counts after `before`.
    pub(super) fn since(&self, before: &RunCounts) -> RunCounts {
        RunCounts(std::array::from_fn(|i| self.0[i] - before.0[i]))
    }

    /// Adds what another unit has counted of the same run.
    pub(super) fn add(&mut self, other: &RunCounts) {
        for (sum, more) in self.0.iter_mut().zip(other.0) {
            *sum += more;
        }
    }

    fn of(&self, count: Count) -> u64 {
        self.0[count as usize]
    }

    /// Cycles of the run, of all units.
    pub(super) fn cycles(&self) -> u64 {
        self.of(Count::Cycles)
    }
}

/// Figures of runs that are a simple sample of all, on so many units of a machine.
pub fn figures(runs: &[RunCounts], units: u32, spec: &SystemSpec) -> Vec<UnitFigure> {
    figures_of(runs, units, spec, &ratio)
}

/// Figures of runs, with quotients of sums over all runs from those of some.
pub(super) fn figures_of(
    runs: &[RunCounts],
    units: u32,
    spec: &SystemSpec,
    ratio: &dyn Fn(&[f64], &[f64]) -> Estimate,
) -> Vec<UnitFigure> {
    use Count as C;
    let mhz = f64::from(spec.tni_mhz);
    let sums = |counts: &[Count]| -> Vec<f64> {
        let sum = |run: &RunCounts| counts.iter().map(|&c| run.of(c)).sum::<u64>() as f64;
        runs.iter().map(sum).collect()
    };
    let (rays, cycles) = (sums(&[C::Rays]), sums(&[C::Cycles]));
    let per_ray = |count| ratio(&sums(&[count]), &rays);
    let hits = |hits, misses| ratio(&sums(&[hits]), &sums(&[hits, misses])).times(100.0);
    let lines = [
        (C::TrvL2Lines, spec.tni.trv_l2.line),
        (C::IstL1Lines, spec.tni.ist_l1.line),
    ];
    let bytes = |run: &RunCounts| -> f64 {
        let lines = lines.map(|(count, bytes)| run.of(count) as f64 * f64::from(bytes));
        lines.iter().sum()
    };
    let estimate = |quantity| match quantity {
        UnitQuantity::Rate => per_ray(C::Cycles).under(f64::from(units) * mhz),
        UnitQuantity::CyclesPerRay => per_ray(C::Cycles),
        UnitQuantity::HitsPerRay => per_ray(C::Hits),
        UnitQuantity::InnerNodesPerRay => per_ray(C::InnerVisits),
        UnitQuantity::LeavesPerRay => per_ray(C::LeafVisits),
        UnitQuantity::TestsPerRay => per_ray(C::Tests),
        UnitQuantity::Residence => per_ray(C::Resident),
        UnitQuantity::TrvL1Hits => hits(C::TrvL1Hits, C::TrvL1Misses),
        UnitQuantity::TrvL2Hits => hits(C::TrvL2Hits, C::TrvL2Misses),
        UnitQuantity::IstL1Hits => hits(C::IstL1Hits, C::IstL1Misses),
        UnitQuantity::Bandwidth => {
            let bytes: Vec<f64> = runs.iter().map(bytes).collect();
            ratio(&bytes, &cycles).times(f64::from(units) * mhz * 1e-3)
        }
    };
    let figure = |quantity| UnitFigure {
        quantity,
        estimate: estimate(quantity),
    };
    UnitQuantity::ALL.map(figure).into()
}
