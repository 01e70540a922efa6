//! [`Needs`]: what a node needs on a unit besides its issue slot, for the operands that no node computes.

use srp_archdesc::arch::{FileKind, Fu, Srp};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Ty;
use srp_archdesc::resource::{Place, ResourceGraph};
use srp_ir::dfg::{Dfg, Initial, Node, Operand};
use std::cmp::Reverse;

/// The registers and read ports of a node on a unit. Each constant takes a word of the context while there are any, each
/// value from outside the loop its central register if the unit reads that; what is left has a register of a static
/// file. A register is read once a cycle, however many operands it is, and no file is read more often than it has ports.
#[derive(Clone, Default)]
pub(super) struct Needs {
    /// The static file of each operand that has one.
    pub(super) kept: Vec<Option<Place>>,
    /// The registers of static files, each once.
    pub(super) constants: Vec<(Place, Initial)>,
    /// The files that they and central registers are read from, once for each register.
    pub(super) reads: Vec<Place>,
}

impl Needs {
    pub(super) fn is_empty(&self) -> bool {
        self.reads.is_empty()
    }
}

/// The files that units read, for the nodes of a loop.
pub(super) struct Files<'a> {
    dfg: &'a Dfg,
    srp: &'a Srp,
    graph: &'a ResourceGraph,
    /// The static ones of each unit, the narrowest first.
    kept: EntityMap<Fu, Vec<Place>>,
}

impl<'a> Files<'a> {
    pub(super) fn new(dfg: &'a Dfg, srp: &'a Srp, graph: &'a ResourceGraph) -> Files<'a> {
        let is_static = |place: &Place| {
            let file = graph.as_file(*place);
            file.is_some_and(|file| srp.files[file].kind == FileKind::Static)
        };
        let of_unit = |fu: Fu| {
            let read = graph.reads[fu].iter().map(|read| read.from);
            let mut files: Vec<Place> = read.filter(is_static).collect();
            files.sort_by_key(|&place| graph.places[place].width);
            files
        };
        Files {
            dfg,
            srp,
            graph,
            kept: srp.fus.keys().map(of_unit).collect(),
        }
    }

    /// The needs of a node on a unit; `None` where the unit has no room for them.
    pub(super) fn needs(&self, node: Node, fu: Fu) -> Option<Needs> {
        let operands = &self.dfg.nodes[node].operands;
        let mut needs = Needs {
            kept: vec![None; operands.len()],
            ..Needs::default()
        };
        let mut central: Vec<u32> = Vec::new();
        let mut in_context = self.srp.fus[fu].constants;
        for (i, ty, value) in self.invariants(operands) {
            match value {
                Initial::Const(_) if in_context > 0 => {
                    in_context -= 1;
                    continue;
                }
                Initial::LiveIn(k) if central.contains(&k) => continue,
                Initial::LiveIn(k) => {
                    let file = self.central_of(fu, ty);
                    if let Some(file) = file.filter(|&file| self.has_port(&needs, file)) {
                        central.push(k);
                        needs.reads.push(file);
                        continue;
                    }
                }
                Initial::Const(_) | Initial::Any => {}
            }
            let known = needs.constants.iter().find(|&&(_, other)| other == value);
            needs.kept[i] = Some(match known {
                Some(&(file, _)) => file,
                None => {
                    let mut files = self.kept[fu].iter().copied();
                    let file = files.find(|&file| {
                        let is_wide = self.graph.places[file].width >= ty.bits();
                        is_wide && self.has_port(&needs, file)
                    })?;
                    needs.constants.push((file, value));
                    needs.reads.push(file);
                    file
                }
            });
        }
        Some(needs)
    }

    /// The central file of a type, if a unit reads it.
    fn central_of(&self, fu: Fu, ty: Ty) -> Option<Place> {
        let file = self.srp.central(ty)?;
        let is_read = self.srp.files[file].readers.contains(&fu);
        is_read.then(|| self.graph.file[file])
    }

    /// True if a file has a port left in the cycle of a node with these needs.
    fn has_port(&self, needs: &Needs, file: Place) -> bool {
        let rf = self.graph.as_file(file);
        let ports = rf.map_or(0, |rf| self.srp.files[rf].read_ports as usize);
        needs.reads.iter().filter(|&&other| other == file).count() < ports
    }

    /// The operands that are constants, predicates apart, or come from outside the loop. Wide ones have fewer files to
    /// choose from, and are first: so what finds no room has none.
    fn invariants(&self, operands: &[Operand]) -> Vec<(usize, Ty, Initial)> {
        let invariant = |(i, operand): (usize, &Operand)| match *operand {
            Operand::Const(bits) if bits.ty() == Ty::Pred => None,
            Operand::Const(bits) => Some((i, bits.ty(), Initial::Const(bits))),
            Operand::LiveIn(k) => {
                let ty = self.dfg.live_ins[k as usize].ty;
                Some((i, ty, Initial::LiveIn(k)))
            }
            Operand::Node { .. } => None,
        };
        let mut all: Vec<_> = operands.iter().enumerate().filter_map(invariant).collect();
        all.sort_by_key(|&(_, ty, _)| Reverse(ty.bits()));
        all
    }
}
