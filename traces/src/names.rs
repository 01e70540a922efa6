//! What the parts of a core are called: in the machine file, and in the source.

use srp_archdesc::arch::{Arch, Carrier};
use srp_archdesc::entity::Entity;
use srp_archdesc::resource::ResourceGraph;
use srp_csimgen::SimSpec;
use srp_csimgen::spec::{Control, Position, Role};

/// The names of a machine's parts.
#[derive(Clone, Debug)]
pub struct Names {
    /// Of units.
    pub units: Vec<String>,
    /// Of links: the units at both ends.
    pub links: Vec<String>,
    /// Of wires.
    pub wires: Vec<String>,
    /// Of stores; those in which a kernel's values are on their way have the kernel's own.
    pub stores: Vec<String>,
    /// The store of each cell.
    store_of: Vec<u32>,
}

impl Names {
    /// The names of a machine's parts, and of what a program has besides.
    pub fn of(spec: &SimSpec, arch: &Arch) -> Names {
        let graph = ResourceGraph::of(&arch.srp);
        // Wires keep nothing, and have no stores.
        let places = graph.places.keys();
        let places: Vec<_> = places.filter(|&p| graph.as_wire(p).is_none()).collect();
        let store = |(i, store): (usize, &srp_csimgen::spec::Store)| match places.get(i) {
            Some(&place) => graph.name(&arch.srp, place),
            None => store.name.clone(),
        };
        let unit = |fu| arch.srp.fus[fu].name.clone();
        let links = arch.srp.links.values();
        let mut store_of = vec![0; spec.cells as usize];
        for (number, store) in (0..).zip(&spec.stores) {
            let first = store.base as usize;
            store_of[first..first + store.size as usize].fill(number);
        }
        Names {
            units: arch.srp.fus.values().map(|fu| fu.name.clone()).collect(),
            links: links
                .map(|link| format!("{}_to_{}", unit(link.from), unit(link.to)))
                .collect(),
            wires: arch
                .srp
                .wires
                .values()
                .map(|wire| wire.name.clone())
                .collect(),
            stores: spec.stores.iter().enumerate().map(store).collect(),
            store_of,
        }
    }

    /// A unit's name.
    pub fn unit(&self, unit: impl Entity) -> &str {
        &self.units[unit.index()]
    }

    /// The name of a link or a wire.
    pub fn carrier(&self, carrier: Carrier) -> &str {
        match carrier {
            Carrier::Link(link) => &self.links[link.index()],
            Carrier::Wire(wire) => &self.wires[wire.index()],
        }
    }

    /// The store of a cell, by its number.
    pub fn store_of(&self, cell: u32) -> u32 {
        self.store_of[cell as usize]
    }

    /// The name of a cell: the store's, and the register's number where there are several.
    pub fn cell(&self, spec: &SimSpec, cell: u32) -> String {
        let number = self.store_of(cell) as usize;
        let store = &spec.stores[number];
        match store.role {
            Role::Output => self.stores[number].clone(),
            _ => format!("{}[{}]", self.stores[number], cell - store.base),
        }
    }
}

/// A place in the source as `file:line`, without the folders; empty for nowhere.
pub fn short_place(spec: &SimSpec, at: Position) -> &str {
    let text = spec.position(at).unwrap_or_default();
    let text = text.rsplit_once(':').map_or(text, |(place, _)| place);
    text.rsplit_once('/').map_or(text, |(_, file)| file)
}

/// A control transfer in words.
pub fn control(spec: &SimSpec, control: &Control) -> String {
    match control {
        Control::Jump(target) => format!("jump {target}"),
        Control::Branch { target, sense, .. } => match sense {
            true => format!("branch {target}"),
            false => format!("branch_not {target}"),
        },
        Control::Call { target, .. } => {
            format!("call {}", spec.function_of(*target).unwrap_or("?"))
        }
        Control::CallReg { .. } => "call_register".to_owned(),
        Control::Return(_) => "return".to_owned(),
        Control::Launch(kernel) => format!("launch {}", spec.kernels[*kernel as usize].name),
        Control::Halt(_) => "halt".to_owned(),
        Control::Unreachable => "unreachable".to_owned(),
        Control::StackOverflow => "stack_overflow".to_owned(),
    }
}
