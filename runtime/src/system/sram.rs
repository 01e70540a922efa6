//! The banks of a core's SRAM: what conflicts and packets of the T&I unit cost.

use serde::{Deserialize, Serialize};
use srp_archdesc::system::{BankSpec, SystemSpec};

/// Cycles for which the banks of an SRAM keep their core.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Banks {
    /// The banks that the T&I unit's packets go through too, and the bytes of a ray and of a hit.
    shared: Option<(BankSpec, u32, u32)>,
    /// Cycles that the core has not stood still for yet.
    pub(super) owed: u64,
}

impl Banks {
    /// Those of a machine.
    pub(super) fn of(spec: &SystemSpec) -> Banks {
        let shared = spec.sram_banks.filter(|banks| banks.shared);
        Banks {
            shared: shared.map(|banks| (banks, spec.buffers.ray_bytes, spec.buffers.hit_bytes)),
            owed: 0,
        }
    }

    /// The accesses of a cycle take so many more.
    pub(super) fn conflict(&mut self, cycles: u32) {
        self.owed += u64::from(cycles);
    }

    /// So many rays go to the T&I unit.
    pub(super) fn rays_leave(&mut self, count: u32) {
        if let Some((banks, ray, _)) = self.shared {
            self.owed += banks.cycles(u64::from(count) * u64::from(ray));
        }
    }

    /// So many hits come from it.
    pub(super) fn hits_arrive(&mut self, count: usize) {
        if let Some((banks, _, hit)) = self.shared {
            self.owed += banks.cycles(count as u64 * u64::from(hit));
        }
    }
}
