//! Damage to what wires take.

use super::super::tally::Harm;
use super::{Kind, Loop};
use srp_archdesc::arch::{Input, Wire};
use srp_archdesc::entity::Entity;
use srp_ir::check::Rule;
use srp_ir::dfg::Node;
use srp_ir::dre::scheduled::{PlacedHop, Source};

/// Rules that a hop that goes wrong may break.
const WAYS: &[Rule] = &[
    Rule::Dataflow,
    Rule::Routing,
    Rule::Width,
    Rule::Wire,
    Rule::LiveOut,
    Rule::Collision,
    Rule::Form,
];

pub(super) const KINDS: &[Kind] = &[
    (
        "a hop that is gone",
        Harm::Always,
        &[Rule::Routing],
        hop_gone,
    ),
    ("a hop from another input", Harm::Perhaps, WAYS, other_input),
    (
        "a hop from what is no input",
        Harm::Always,
        &[Rule::Routing],
        no_input,
    ),
    ("a hop in another cycle", Harm::Perhaps, WAYS, other_cycle),
    ("a hop of another value", Harm::Perhaps, WAYS, other_value),
    ("two hops at once", Harm::Always, &[Rule::Wire], two_hops),
    ("wires in a circle", Harm::Always, &[Rule::Wire], circle),
    (
        "a wire that does not exist",
        Harm::Always,
        &[Rule::Range],
        no_wire,
    ),
    (
        "an operand from another wire",
        Harm::Perhaps,
        WAYS,
        other_wire,
    ),
    (
        "a wire to another unit",
        Harm::Always,
        &[Rule::Routing],
        wrong_wire,
    ),
];

/// One of the hops.
fn hop<'a>(broken: &'a mut Loop<'_>) -> Option<&'a mut PlacedHop> {
    let at = broken.dice.below(broken.schedule.hops.len());
    broken.schedule.hops.get_mut(at)
}

fn hop_gone(broken: &mut Loop<'_>) -> Option<()> {
    let at = broken.dice.below(broken.schedule.hops.len());
    (at < broken.schedule.hops.len()).then(|| broken.schedule.hops.remove(at))?;
    Some(())
}

/// Lets a wire take another input, which is one that it has or not.
fn input(broken: &mut Loop<'_>, has: bool) -> Option<()> {
    let wire = hop(broken)?.wire;
    let own = &broken.arch.srp.wires[wire].from;
    let units = broken.arch.srp.fus.keys().map(Input::Unit);
    let wires = broken.arch.srp.wires.keys().map(Input::Wire);
    let inputs = units
        .chain(wires)
        .filter(|input| own.contains(input) == has);
    let input = broken.dice.pick(&inputs.collect::<Vec<_>>())?;
    let mut hops = broken.schedule.hops.iter_mut();
    hops.find(|hop| hop.wire == wire)?.from = input;
    Some(())
}

fn other_input(broken: &mut Loop<'_>) -> Option<()> {
    input(broken, true)
}

fn no_input(broken: &mut Loop<'_>) -> Option<()> {
    input(broken, false)
}

fn other_cycle(broken: &mut Loop<'_>) -> Option<()> {
    let by = broken.dice.below(3) as u32;
    let late = broken.dice.chance();
    let time = &mut hop(broken)?.time;
    *time = match late {
        true => *time + 1 + by,
        false => time.checked_sub(1 + by)?,
    };
    Some(())
}

fn other_value(broken: &mut Loop<'_>) -> Option<()> {
    let dfg = &broken.schedule.dfg;
    let values: Vec<Node> = dfg.nodes.keys().filter(|&n| dfg.ty(n).is_some()).collect();
    let node = broken.dice.pick(&values)?;
    hop(broken)?.node = node;
    Some(())
}

fn two_hops(broken: &mut Loop<'_>) -> Option<()> {
    let later = broken.dice.chance();
    let ii = broken.schedule.ii;
    let mut other = *hop(broken)?;
    other.time += if later { ii } else { 0 };
    broken.schedule.hops.push(other);
    Some(())
}

/// Sets wires without registers to take from each other, in place of what they took.
fn circle(broken: &mut Loop<'_>) -> Option<()> {
    let PlacedHop { node, time, .. } = *hop(broken)?;
    let wires = &broken.arch.srp.wires;
    let mut way: Vec<Wire> = vec![broken.dice.pick(&wires.keys().collect::<Vec<_>>())?];
    let first = loop {
        let before = wires[*way.last()?]
            .from
            .iter()
            .filter_map(|input| match *input {
                Input::Wire(wire) => Some(wire).filter(|&wire| wires[wire].delay == 0),
                Input::Unit(_) => None,
            });
        let next = broken.dice.pick(&before.collect::<Vec<_>>())?;
        if let Some(first) = way.iter().position(|&wire| wire == next) {
            break first;
        }
        way.push(next);
    };
    let ring = &way[first..];
    let slot = time % broken.schedule.ii;
    let ii = broken.schedule.ii;
    let hops = &mut broken.schedule.hops;
    hops.retain(|hop| hop.time % ii != slot || !ring.contains(&hop.wire));
    for (wire, before) in ring.iter().zip(ring.iter().cycle().skip(1)) {
        hops.push(PlacedHop {
            node,
            wire: *wire,
            from: Input::Wire(*before),
            time,
        });
    }
    Some(())
}

fn no_wire(broken: &mut Loop<'_>) -> Option<()> {
    let wire = Wire::new(broken.arch.srp.wires.len() + broken.dice.below(9));
    match broken.dice.chance() {
        true => hop(broken)?.wire = wire,
        false => hop(broken)?.from = Input::Wire(wire),
    }
    Some(())
}

/// Changes the wire that an operand comes over to one that is like this.
fn rewire(broken: &mut Loop<'_>, leads_here: bool) -> Option<()> {
    let (op, i) = broken.operand_like(|source| matches!(source, Source::Wire(_)))?;
    let to = broken.schedule.ops[op].fu;
    let wires = broken.arch.srp.wires.iter();
    let wires: Vec<Wire> = wires
        .filter(|(_, wire)| wire.to.contains(&to) == leads_here)
        .map(|(wire, _)| wire)
        .collect();
    broken.schedule.ops[op].operands[i] = Source::Wire(broken.dice.pick(&wires)?);
    Some(())
}

fn other_wire(broken: &mut Loop<'_>) -> Option<()> {
    rewire(broken, true)
}

fn wrong_wire(broken: &mut Loop<'_>) -> Option<()> {
    rewire(broken, false)
}
