//! The multiplexers that lead accesses of units to the banks of a memory, and words back.
//!
//! As many accesses begin in a cycle as the units' shared resources let: its *ports*. Units choose a port, and ports a
//! bank; or units choose banks at once, where that takes less.

use std::collections::BTreeSet;

use crate::arch::{FuSpec, Resource, Srp};
use crate::cost::operator::MULTIPLEXER_BIT;
use crate::isa::Class;
use crate::system::BankSpec;

/// Bits of an address.
const ADDRESS: u32 = 32;

/// The units that access a memory, and its ports.
pub(super) struct Accesses {
    /// Units that load or store.
    units: u32,
    /// Those among them that load.
    loads: u32,
    /// Accesses that begin in a cycle at most.
    pub(super) ports: u32,
}

impl Accesses {
    /// Those of a load's and a store's class.
    pub(super) fn of(srp: &Srp, load: Class, store: Class) -> Accesses {
        let runs = |class| move |fu: &&FuSpec| fu.op(class).is_some();
        let fus = || srp.fus.values();
        let units = fus().filter(|fu| runs(load)(fu) || runs(store)(fu));
        let ops = || fus().flat_map(|fu| [fu.op(load), fu.op(store)]).flatten();
        let resources: BTreeSet<Resource> = ops().flat_map(|op| op.uses.iter().copied()).collect();
        let counts = resources
            .iter()
            .map(|&resource| srp.resources[resource].count);
        let units = units.count() as u32;
        // An operation without a resource is held up by nothing but its unit.
        let ports = match ops().any(|op| op.uses.is_empty()) {
            true => units,
            false => counts.fold(0, u32::saturating_add).min(units),
        };
        Accesses {
            units,
            loads: fus().filter(runs(load)).count() as u32,
            ports,
        }
    }

    /// Inputs of multiplexers, and their area, µm². The T&I unit is one more where it has no ports of its own.
    pub(super) fn choices(&self, banks: BankSpec) -> (u32, f64) {
        let more = u32::from(banks.shared);
        let word = 8 * banks.width;
        let (units, loads, ports) = (self.units, self.loads, self.ports);
        // So many multiplexers, each of so many inputs and bits.
        let at_once = [
            (banks.count, units + more, ADDRESS + word),
            (loads, banks.count, word),
        ];
        let by_port = [
            (ports, units, ADDRESS + word),
            (banks.count, ports + more, ADDRESS + word),
            (ports, banks.count, word),
            (loads, ports, word),
        ];
        let (at_once, by_port) = (taken(&at_once), taken(&by_port));
        match by_port.1 < at_once.1 {
            true => by_port,
            false => at_once,
        }
    }
}

/// Inputs and area, µm², of multiplexers.
fn taken(multiplexers: &[(u32, u32, u32)]) -> (u32, f64) {
    let inputs = multiplexers
        .iter()
        .map(|(number, inputs, _)| number * inputs);
    let bits = multiplexers.iter().map(|&(number, inputs, bits)| {
        f64::from(number) * f64::from(inputs.saturating_sub(1)) * f64::from(bits)
    });
    (inputs.sum(), MULTIPLEXER_BIT * bits.sum::<f64>())
}
