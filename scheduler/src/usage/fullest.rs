//! The parts of the machine that a schedule takes most of: what more of would give it room.

use super::Usage;
use srp_archdesc::arch::{Fu, Link, RegFile, Resource, Srp, Wire};

/// A part of the machine, in the order in which parts that are equally full are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// A resource that units share.
    Resource(Resource),
    /// The ports to read of a register file.
    ReadPorts(RegFile),
    /// Its ports to write.
    WritePorts(RegFile),
    /// Its registers.
    Registers(RegFile),
    /// A unit's issue cycles.
    Unit(Fu),
    /// A link.
    Link(Link),
    /// A wire.
    Wire(Wire),
}

/// How much of a part a loop takes: in all slots together, of registers in the slot with the most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// The part.
    pub part: Part,
    /// Taken of it.
    pub used: u32,
    /// All of it, at least 1.
    pub of: u32,
}

impl Part {
    /// The part in words: `ports to write of g`.
    pub fn in_words(self, srp: &Srp) -> String {
        match self {
            Part::Resource(resource) => srp.resources[resource].name.clone(),
            Part::ReadPorts(file) => format!("ports to read of {}", srp.files[file].name),
            Part::WritePorts(file) => format!("ports to write of {}", srp.files[file].name),
            Part::Registers(file) => format!("registers of {}", srp.files[file].name),
            Part::Unit(fu) => srp.fus[fu].name.clone(),
            Part::Link(link) => {
                let link = &srp.links[link];
                let name = |fu: Fu| srp.fus[fu].name.as_str();
                format!("link {} to {}", name(link.from), name(link.to))
            }
            Part::Wire(wire) => format!("wire {}", srp.wires[wire].name),
        }
    }
}

impl Usage {
    /// The parts of which all is taken, or the fullest one where there are none; in the order of [`Part`].
    pub fn fullest(&self, srp: &Srp, ii: u32) -> Vec<Share> {
        let mut shares = self.shares(srp, ii);
        shares.retain(|share| share.used > 0 && share.of > 0);
        shares.sort_by_key(|share| share.part);
        let product = |a: u32, b: u32| u64::from(a) * u64::from(b);
        let by_part = |a: &&Share, b: &&Share| product(a.used, b.of).cmp(&product(b.used, a.of));
        // Of equals the last is the largest.
        let fullest = shares.iter().rev().max_by(by_part).copied();
        if fullest.is_some_and(|fullest| fullest.used < fullest.of) {
            return fullest.into_iter().collect();
        }
        shares.retain(|share| share.used >= share.of);
        shares
    }

    fn shares(&self, srp: &Srp, ii: u32) -> Vec<Share> {
        let share = |part: Part, used: u32, of: u32| Share { part, used, of };
        let slots = |used: &[u32]| used.iter().sum::<u32>();
        let resources = (self.resources.iter()).map(|(resource, used)| {
            let of = srp.resources[resource].count * ii;
            share(Part::Resource(resource), slots(used), of)
        });
        let files = self.files.iter().flat_map(|(file, used)| {
            let spec = &srp.files[file];
            [
                share(
                    Part::ReadPorts(file),
                    slots(&used.reads),
                    spec.read_ports * ii,
                ),
                share(
                    Part::WritePorts(file),
                    slots(&used.writes),
                    spec.write_ports * ii,
                ),
                share(Part::Registers(file), used.worst().0, spec.size),
            ]
        });
        let units = self
            .units
            .iter()
            .map(|(fu, used)| share(Part::Unit(fu), used.busy(), ii));
        let links = self
            .links
            .iter()
            .map(|(link, used)| share(Part::Link(link), used.slots(), ii));
        let wires = self
            .wires
            .iter()
            .map(|(wire, used)| share(Part::Wire(wire), used.slots(), ii));
        resources
            .chain(files)
            .chain(units)
            .chain(links)
            .chain(wires)
            .collect()
    }
}
