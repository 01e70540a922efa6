//! Energy of the T&I units: their counts times the energy of each event.

use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::area::{cache_energy, operations_energy, triangle_energy};
use srp_archdesc::datapath::BOX_TEST;
use srp_archdesc::system::{CacheSpec, TniSpec};
use srp_runtime::memory::cache::CacheCounters;
use srp_runtime::tni::TniCounters;

/// Energy in mJ, without registers, control, clock and the memory outside.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
pub struct Energy {
    /// Ray-box tests.
    pub boxes: f64,
    /// Ray-triangle tests.
    pub triangles: f64,
    /// Accesses to the caches, and their refills.
    pub caches: f64,
}

impl Energy {
    /// Returns the energy of these counters.
    pub fn of(tni: &TniSpec, c: &TniCounters) -> Energy {
        const MJ: f64 = 1e-6;
        let test = triangle_energy(tni);
        let cache = |spec: &CacheSpec, c: &CacheCounters| {
            // A miss looks for the line, and writes it when it comes.
            (c.hits + c.joined + 2 * c.misses) as f64 * cache_energy(spec.bytes)
        };
        Energy {
            boxes: c.box_tests as f64 * operations_energy(BOX_TEST) * MJ,
            triangles: c.triangle_tests as f64 * test * MJ,
            caches: MJ
                * (cache(&tni.trv_l1, &c.trv_l1)
                    + cache(&tni.trv_l2, &c.trv_l2)
                    + cache(&tni.ist_l1, &c.ist_l1)),
        }
    }

    /// All of it.
    pub fn total(&self) -> f64 {
        self.boxes + self.triangles + self.caches
    }
}
