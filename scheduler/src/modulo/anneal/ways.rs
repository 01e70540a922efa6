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
    let reaches = direct(problem);
    let near = |from: Fu| {
        let there = |&to: &Fu| to == from || reaches[from][to] || reaches[to][from];
        problem.srp.fus.keys().filter(there).collect()
    };
    problem.srp.fus.keys().map(near).collect()
}

/// For each unit and each other, true if a value in the output of the first can be read by the second without a move:
/// at once, or over wires.
fn direct(problem: &Problem<'_>) -> EntityMap<Fu, EntityMap<Fu, bool>> {
    let units = || problem.srp.fus.keys();
    let from = |from: Fu| {
        let out = problem.graph.out[from];
        let at_once = units().map(|to| problem.detour(Ty::Word, out, to) == 0);
        let mut reaches: EntityMap<Fu, bool> = at_once.collect();
        over_wires(problem, out, &mut reaches);
        reaches
    };
    units().map(from).collect()
}

/// Adds the units that read a word in an output over wires.
fn over_wires(problem: &Problem<'_>, out: Place, reaches: &mut EntityMap<Fu, bool>) {
    let graph = &problem.graph;
    let mut seen = EntityMap::filled(graph.places.len(), false);
    let mut open = vec![out];
    while let Some(place) = open.pop() {
        let wide = (graph.hops[place].iter()).filter(|hop| hop.width >= Ty::Word.bits());
        for hop in wide {
            if std::mem::replace(&mut seen[hop.to], true) {
                continue;
            }
            open.push(hop.to);
            for &(fu, read) in &problem.readers[hop.to] {
                reaches[fu] |= graph.reads[fu][read as usize].width >= Ty::Word.bits();
            }
        }
    }
}

/// The units over which one move brings a value from each unit to each other.
pub(super) fn between(problem: &Problem<'_>) -> Vec<Vec<Fu>> {
    let units: Vec<Fu> = problem.srp.fus.keys().collect();
    let reaches = direct(problem);
    let direct = |from: Fu, to: Fu| from == to || reaches[from][to];
    let mut all = Vec::new();
    for &from in &units {
        for &to in &units {
            let through = |&&m: &&Fu| direct(from, m) && direct(m, to);
            all.push(units.iter().filter(through).copied().collect());
        }
    }
    all
}
