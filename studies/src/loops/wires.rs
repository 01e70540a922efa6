//! Loads of wires.

use super::model::{Taken, WireLoad};
use srp_archdesc::arch::{Input, Srp, Wire};
use srp_archdesc::entity::Entity;
use srp_ir::dre::scheduled::{ModuloSchedule, PlacedHop};
use srp_scheduler::usage::{Taker, Usage};

/// The load of each wire.
pub(super) fn wires(schedule: &ModuloSchedule, srp: &Srp, usage: &Usage) -> Vec<WireLoad> {
    let load = |wire: Wire| {
        let mut takes: Vec<Taken> = (schedule.hops.iter())
            .filter(|hop| hop.wire == wire)
            .map(|hop| taken(schedule, srp, usage, hop))
            .collect();
        takes.sort_by_key(|taken| taken.slot);
        let spec = &srp.wires[wire];
        WireLoad {
            wire: spec.name.clone(),
            width: spec.width,
            delay: spec.delay,
            slots: takes.len() as u32,
            takes,
        }
    };
    srp.wires.keys().map(load).collect()
}

fn taken(schedule: &ModuloSchedule, srp: &Srp, usage: &Usage, hop: &PlacedHop) -> Taken {
    let slot = hop.time % schedule.ii;
    let carried = usage.wires[hop.wire].carried.iter();
    let mut to: Vec<String> = carried
        .filter(|c| (c.slot, c.node) == (slot, hop.node))
        .map(|c| match c.to {
            Taker::Op(op) => srp.fus[schedule.ops[op].fu].name.clone(),
            Taker::File(file) => srp.files[file].name.clone(),
            Taker::Wire(wire) => srp.wires[wire].name.clone(),
        })
        .collect();
    // One operation may take it twice.
    to.dedup();
    Taken {
        slot,
        node: hop.node.index() as u32,
        from: match hop.from {
            Input::Unit(fu) => srp.fus[fu].name.clone(),
            Input::Wire(wire) => srp.wires[wire].name.clone(),
        },
        unit: unit(schedule, srp, hop),
        to,
    }
}

/// The unit at the other end of the wires that lead to a hop.
fn unit(schedule: &ModuloSchedule, srp: &Srp, hop: &PlacedHop) -> String {
    let (mut from, mut cycle) = (hop.from, i64::from(hop.time));
    // A schedule that was checked leads back to a unit in no more hops than there are.
    for _ in 0..=schedule.hops.len() {
        let before = match from {
            Input::Unit(fu) => return srp.fus[fu].name.clone(),
            Input::Wire(before) => before,
        };
        cycle -= i64::from(srp.wires[before].delay);
        let slot = cycle.rem_euclid(i64::from(schedule.ii)) as u32;
        let mut hops = schedule.hops.iter();
        match hops.find(|hop| hop.wire == before && hop.time % schedule.ii == slot) {
            Some(hop) => from = hop.from,
            None => break,
        }
    }
    String::new()
}
