//! What runs of packets took, and figures with intervals from the spread between them.

use srp_archdesc::system::SystemSpec;

use crate::fidelity::Figure;
use crate::survey::{Estimate, ratio};
use srp_runtime::tni::TniCounters;

/// What is counted of a run: see [`Spent::at`].
const COUNTS: usize = 15;

/// Counters of a run of packets.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Spent([u64; COUNTS]);

impl Spent {
    /// Everything up to a cycle. The misses are those that ask for a line, and those that join them.
    pub(super) fn at(cycles: u64, c: &TniCounters) -> Spent {
        Spent([
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

    /// What came after `before`.
    pub(super) fn since(&self, before: &Spent) -> Spent {
        Spent(std::array::from_fn(|i| self.0[i] - before.0[i]))
    }

    /// Adds what another unit spent on the same run.
    pub(super) fn add(&mut self, other: &Spent) {
        for (sum, more) in self.0.iter_mut().zip(other.0) {
            *sum += more;
        }
    }

    /// Cycles of the run, of all units.
    pub(super) fn cycles(&self) -> u64 {
        self.0[1]
    }
}

/// Figures of runs that are a simple sample of all, on so many units of a machine.
pub fn figures(runs: &[Spent], units: u32, spec: &SystemSpec) -> Vec<Figure> {
    figures_of(runs, units, spec, &ratio)
}

/// Figures of runs, with quotients of sums over all runs from those of some.
pub(super) fn figures_of(
    runs: &[Spent],
    units: u32,
    spec: &SystemSpec,
    ratio: &dyn Fn(&[f64], &[f64]) -> Estimate,
) -> Vec<Figure> {
    let mhz = f64::from(spec.tni_mhz);
    let of = |column: usize| -> Vec<f64> { runs.iter().map(|r| r.0[column] as f64).collect() };
    let both =
        |a: usize| -> Vec<f64> { runs.iter().map(|r| (r.0[a] + r.0[a + 1]) as f64).collect() };
    let figure = |name: &str, unit: &'static str, estimate: Estimate| Figure {
        name: name.to_owned(),
        unit,
        estimate,
    };
    let rays = of(0);
    let a_ray = ratio(&of(1), &rays);
    let rate = a_ray.under(f64::from(units) * mhz);
    let mut all = vec![
        figure("rate", "Mrays/s", rate),
        figure("cycles a ray and unit", "", a_ray),
    ];
    let per_ray = [
        ("hits a ray", 2),
        ("inner nodes a ray", 3),
        ("leaves a ray", 4),
        ("triangle tests a ray", 5),
        ("residence of a ray", 6),
    ];
    all.extend(per_ray.map(|(name, column)| figure(name, "", ratio(&of(column), &rays))));
    let caches = [("TRV L1 hits", 7), ("TRV L2 hits", 9), ("IST L1 hits", 11)];
    all.extend(caches.map(|(name, column)| {
        let rate = ratio(&of(column), &both(column)).times(100.0);
        figure(name, "%", rate)
    }));
    let lines = [(13, spec.tni.trv_l2.line), (14, spec.tni.ist_l1.line)];
    let bytes = |run: &Spent| -> f64 {
        let lines = lines.map(|(column, bytes)| run.0[column] as f64 * f64::from(bytes));
        lines.iter().sum()
    };
    let bytes: Vec<f64> = runs.iter().map(bytes).collect();
    let memory = ratio(&bytes, &of(1)).times(f64::from(units) * mhz * 1e-3);
    all.push(figure("memory", "GB/s", memory));
    all
}
