//! Capacity limits of the folded formula: for every resource and slot of the II, the literals that compete for it.

use super::Folded;
use crate::abi;
use crate::modulo::exact::formula::{Formula, Lit};
use crate::modulo::exact::names;
use crate::modulo::problem::Problem;
use srp_archdesc::arch::{Fu, FuOp, Resource};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::resource::Place;

/// Literals that compete in each slot, by resource.
pub(super) struct Limits {
    ii: usize,
    issue: EntityMap<Fu, Vec<Vec<Lit>>>,
    outputs: EntityMap<Place, Vec<Vec<Lit>>>,
    registers: EntityMap<Place, Vec<Vec<Lit>>>,
    writes: EntityMap<Place, Vec<Vec<Lit>>>,
    shared: EntityMap<Resource, Vec<Vec<Lit>>>,
    /// True where a move of any value is issued, by unit and slot.
    moves: EntityMap<Fu, Vec<Option<Lit>>>,
    units: EntityMap<Fu, String>,
}

impl Limits {
    pub(super) fn new(problem: &Problem<'_>, ii: u32) -> Limits {
        let (ii, srp) = (ii as usize, problem.srp);
        let slots = vec![Vec::new(); ii];
        let places = || EntityMap::filled(problem.graph.places.len(), slots.clone());
        Limits {
            ii,
            issue: EntityMap::filled(srp.fus.len(), slots.clone()),
            outputs: places(),
            registers: places(),
            writes: places(),
            shared: EntityMap::filled(srp.resources.len(), slots.clone()),
            moves: EntityMap::filled(srp.fus.len(), vec![None; ii]),
            units: srp.fus.values().map(|fu| fu.name.clone()).collect(),
        }
    }

    /// An operation or a move is issued.
    pub(super) fn issue(&mut self, fu: Fu, time: usize, timing: &FuOp, literal: Lit) {
        for k in 0..timing.interval as usize {
            let slot = (time + k) % self.ii;
            self.issue[fu][slot].push(literal);
            for &resource in &timing.uses {
                self.shared[resource][slot].push(literal);
            }
        }
    }

    /// A move is issued, of which there are not too many.
    pub(super) fn moved(&mut self, formula: &mut Formula, fu: Fu, time: usize, literal: Lit) {
        let slot = time % self.ii;
        let unit = &self.units[fu];
        let moves = (self.moves[fu][slot])
            .get_or_insert_with(|| formula.variable(|| names::slot("moves", unit, slot)));
        formula.clause([-literal, *moves]);
    }

    pub(super) fn output(&mut self, place: Place, time: usize, literal: Lit) {
        self.outputs[place][time % self.ii].push(literal);
    }

    pub(super) fn register(&mut self, place: Place, time: usize, literal: Lit) {
        self.registers[place][time % self.ii].push(literal);
    }

    pub(super) fn write(&mut self, place: Place, time: usize, literal: Lit) {
        self.writes[place][time % self.ii].push(literal);
    }
}

/// The lists of a resource, in the order of their variables.
fn sorted(slots: &mut [Vec<Lit>]) -> impl Iterator<Item = (usize, &[Lit])> {
    slots.iter_mut().enumerate().map(|(slot, uses)| {
        uses.sort_unstable();
        (slot, &uses[..])
    })
}

impl Folded<'_, '_> {
    /// In every slot of the II, limits the uses of each unit, output, shared resource, register file and port, and
    /// the moves of all slots.
    pub(super) fn limit(&mut self) {
        let problem = self.problem;
        let (formula, limits) = (&mut self.formula, &mut self.limits);
        for (fu, slots) in limits.issue.iter_mut() {
            let unit = &problem.srp.fus[fu].name;
            for (slot, uses) in sorted(slots) {
                formula.at_most_one(uses, || names::slot("issue", unit, slot));
            }
        }
        for (place, slots) in limits.outputs.iter_mut() {
            let name = problem.graph.name(problem.srp, place);
            for (slot, uses) in sorted(slots) {
                formula.at_most_one(uses, || names::slot("output", &name, slot));
            }
        }
        for (resource, slots) in limits.shared.iter_mut() {
            let spec = &problem.srp.resources[resource];
            for (slot, uses) in sorted(slots) {
                formula.at_most(spec.count, uses, || names::slot("shared", &spec.name, slot));
            }
        }
        let reserved = abi::reserved(problem.srp);
        for (file, spec) in problem.srp.files.iter() {
            let place = problem.graph.file[file];
            let taken = reserved.iter().filter(|reg| reg.file == file).count() as u32;
            let room = spec.size.saturating_sub(taken);
            for (slot, uses) in sorted(&mut limits.registers[place]) {
                formula.at_most(room, uses, || names::slot("registers", &spec.name, slot));
            }
            for (slot, uses) in sorted(&mut limits.writes[place]) {
                let most = spec.write_ports;
                formula.at_most(most, uses, || names::slot("writes", &spec.name, slot));
            }
        }
        let moves: Vec<Lit> = limits.moves.values().flatten().flatten().copied().collect();
        let mut moves = moves;
        moves.sort_unstable();
        formula.at_most(self.spare, &moves, || "all-moves".to_owned());
    }
}
