//! Loops that can be seen to have no schedule on an array before one is looked for.

use super::obstacle::{Operation, Unschedulable};
use super::problem::{Edge, Problem};
use super::{MAX_STAGES, bounds};
use crate::abi;
use srp_archdesc::arch::Srp;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Ty;
use srp_ir::dfg::Dfg;
use srp_ir::dre::scheduled::Reg;

/// Refuses a loop that can be seen to have no schedule before one is looked for: values come in
/// without room in the central registers, no unit runs an operation, or the II takes more contexts
/// than there are. [`schedule`](super::schedule) may still find none.
pub fn admit(dfg: &Dfg, srp: &Srp) -> Result<(), Unschedulable> {
    fixed_registers(dfg, srp)?;
    for (node, data) in dfg.nodes.iter() {
        if !srp.fus.values().any(|fu| fu.runs(data.op).is_some()) {
            return Err(Unschedulable::NoUnit(Operation::of(dfg, node)));
        }
    }
    // Small loops have room.
    if dfg.nodes.len() > srp.contexts as usize {
        let bound = bounds(dfg, srp).min_ii();
        let contexts = srp.contexts;
        if bound > contexts {
            return Err(Unschedulable::Contexts { bound, contexts });
        }
    }
    Ok(())
}

/// Refuses a loop that needs more values of earlier iterations than the array has places for.
///
/// A value that a node takes from `d` iterations ago lives for `d` IIs, less its own latency where the two are
/// one node, or else less the [`MAX_STAGES`] IIs by which the consumer may be ahead; so at least that many of
/// its instances live at once, whatever the II. Each is in a register, in an output, on a link or in a unit.
pub(super) fn storage(problem: &Problem<'_>) -> Result<(), Unschedulable> {
    let unkept = |edge: &&Edge| edge.to().is_none() && !problem.keeps(edge.ty);
    if let Some(edge) = problem.edges.iter().find(unkept) {
        let bits = edge.ty.bits();
        return Err(Unschedulable::LiveOut { bits });
    }
    let mut held: EntityMap<_, u64> = EntityMap::filled(problem.dfg.nodes.len(), 0);
    for edge in &problem.edges {
        let Some(to) = edge.to() else { continue };
        let ahead = if to == edge.from { 0 } else { MAX_STAGES };
        let latency = (problem.units[edge.from].iter())
            .map(|&fu| problem.timing(edge.from, fu).latency)
            .max();
        let less = latency.unwrap_or(0) + ahead;
        let least = u64::from(edge.distance.saturating_sub(less));
        held[edge.from] = held[edge.from].max(least);
    }
    let held: u64 = held.values().sum();
    if held == 0 {
        return Ok(());
    }
    let room = places_of_values(problem);
    match held > room {
        true => Err(Unschedulable::Storage { held, room }),
        false => Ok(()),
    }
}

/// How many values there can be on the array at once: in registers, in outputs, in units, on links and on wires.
pub(super) fn places_of_values(problem: &Problem<'_>) -> u64 {
    let srp = problem.srp;
    let registers: u64 = srp.files.values().map(|file| u64::from(file.size)).sum();
    let in_units = srp.fus.values().map(|fu| {
        let latencies = fu.ops.iter().map(|op| op.latency);
        u64::from(latencies.max().unwrap_or(0)) * Ty::ALL.len() as u64
    });
    let on_links = problem.graph.transfers.values().flatten();
    let on_links: u64 = on_links.map(|way| u64::from(way.delay)).sum();
    let read_delays = problem.graph.reads.values().flatten();
    let read_delays: u64 = read_delays.map(|way| u64::from(way.delay)).sum();
    let on_wires = srp.wires.values().map(|wire| u64::from(wire.delay));
    let outputs = problem.graph.places.len() as u64;
    let on_the_way = on_links + read_delays + on_wires.sum::<u64>();
    registers + outputs + in_units.sum::<u64>() + on_the_way
}

/// The central registers that hold something else than the loop's own values: those that bring the live-ins, in their
/// order, and after them the [reserved ones](abi::reserved).
pub(super) fn fixed_registers(dfg: &Dfg, srp: &Srp) -> Result<Vec<Reg>, Unschedulable> {
    let passing = abi::passing(srp, dfg.live_ins.iter().map(|l| l.ty));
    if let Some(place) = passing.iter().position(Option::is_none) {
        let ty = dfg.live_ins[place].ty;
        // A machine may keep several types in one file.
        let in_file = dfg.live_ins.iter().map(|live| live.ty);
        let in_file = in_file.filter(|&other| srp.central(other) == srp.central(ty));
        return Err(Unschedulable::LiveIns {
            ty: in_file.clone().all(|other| other == ty).then_some(ty),
            count: in_file.count(),
            room: abi::live_ins(srp)[ty as usize],
        });
    }
    let reserved = abi::reserved(srp);
    Ok(passing.into_iter().flatten().chain(reserved).collect())
}
