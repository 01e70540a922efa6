//! The cheapest ways between units, and their neighbours, whatever is placed on them.

use super::super::problem::{Problem, UNREACHABLE};
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Ty;
use srp_archdesc::resource::Place;

/// The cheapest ways of a value from a unit's output to an operand of another unit.
#[derive(Clone, Copy)]
pub(super) struct Way {
    /// Fewest cycles.
    pub(super) reach: u32,
    /// Price beyond holding the value, if it goes on at once.
    pub(super) direct: u32,
    /// The same by way of a register file in which it can wait, with its cycles.
    pub(super) held: u32,
    pub(super) held_reach: u32,
}

/// Where a unit's results of a type stand.
#[inline]
pub(super) fn out_of(problem: &Problem<'_>, ty: Ty, fu: Fu) -> Place {
    match ty {
        Ty::Pred => problem.graph.pred_out[fu],
        Ty::Word | Ty::Vec => problem.graph.out[fu],
    }
}

/// The ways of a type between all units.
pub(super) fn ways(problem: &Problem<'_>, ty: Ty) -> Vec<Way> {
    let units = || problem.srp.fus.keys();
    let mut ways = Vec::new();
    for from in units() {
        let out = out_of(problem, ty, from);
        let wide = |&&file: &&_| problem.graph.places[file].width >= ty.bits();
        let files: Vec<_> = problem.graph.writes[from].iter().filter(wide).collect();
        for to in units() {
            let held = files
                .iter()
                .map(|&&f| (problem.detour(ty, f, to), problem.reach(ty, f, to)));
            let (held, held_reach) = held.min().unwrap_or((UNREACHABLE, UNREACHABLE));
            ways.push(Way {
                reach: problem.reach(ty, out, to),
                direct: problem.detour(ty, out, to),
                held,
                held_reach,
            });
        }
    }
    ways
}

/// The units that each unit's results reach without a move, itself among them.
pub(super) fn near(problem: &Problem<'_>) -> EntityMap<Fu, Vec<Fu>> {
    let reaches = |from: Fu, to: Fu| {
        let from = problem.graph.out[from];
        from_direct(problem, from, to)
    };
    let near = |from: Fu| {
        let there = |&to: &Fu| to == from || reaches(from, to) || reaches(to, from);
        problem.srp.fus.keys().filter(there).collect()
    };
    problem.srp.fus.keys().map(near).collect()
}

fn from_direct(problem: &Problem<'_>, from: Place, to: Fu) -> bool {
    problem.detour(Ty::Word, from, to) == 0
}

/// The units over which one move brings a value from each unit to each other.
pub(super) fn between(problem: &Problem<'_>) -> Vec<Vec<Fu>> {
    let units: Vec<Fu> = problem.srp.fus.keys().collect();
    let direct = |from: Fu, to: Fu| from == to || from_direct(problem, problem.graph.out[from], to);
    let mut all = Vec::new();
    for &from in &units {
        for &to in &units {
            let through = |&&m: &&Fu| direct(from, m) && direct(m, to);
            all.push(units.iter().filter(through).copied().collect());
        }
    }
    all
}
