//! Damage to where and when operations run, and to the schedule as a whole.

use super::super::tally::Harm;
use super::{Kind, Loop};
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::Opcode;
use srp_ir::check::Rule;
use srp_ir::dfg::Node;
use srp_ir::dre::scheduled::{Placed, PlacedOp, Source};
use srp_ir::program::Bits;

/// Rules that a change of times may break.
const TIMES: &[Rule] = &[
    Rule::Dataflow,
    Rule::MemoryOrder,
    Rule::LiveOut,
    Rule::Contexts,
    Rule::Collision,
    Rule::IssueInterval,
    Rule::Resource,
    Rule::ReadPorts,
    Rule::WritePorts,
    // Wires are read in other cycles, or set twice in one.
    Rule::Routing,
    Rule::Wire,
];

pub(super) const KINDS: &[Kind] = &[
    (
        "an operation an iteration early or late",
        Harm::Perhaps,
        TIMES,
        other_iteration,
    ),
    (
        "an operation a cycle early or late",
        Harm::Perhaps,
        TIMES,
        other_cycle,
    ),
    (
        "a memory access out of order",
        Harm::Always,
        &[Rule::MemoryOrder],
        out_of_order,
    ),
    (
        "two operations in a slot",
        Harm::Always,
        &[Rule::IssueInterval],
        same_slot,
    ),
    (
        "a move in a taken slot",
        Harm::Always,
        &[Rule::IssueInterval],
        move_in_slot,
    ),
    (
        "a shared resource over-used",
        Harm::Always,
        &[Rule::Resource],
        resource,
    ),
    (
        "a unit that does not run it",
        Harm::Always,
        &[Rule::Class],
        wrong_unit,
    ),
    (
        "another node in its place",
        Harm::Always,
        &[Rule::Placement],
        wrong_node,
    ),
    (
        "a node that is a move",
        Harm::Always,
        &[Rule::Placement],
        node_as_move,
    ),
    (
        "a node that is missing",
        Harm::Always,
        &[Rule::Placement],
        node_gone,
    ),
    (
        "an operand that is missing",
        Harm::Always,
        &[Rule::Form],
        operand_gone,
    ),
    (
        "too many constants",
        Harm::Always,
        &[Rule::Constants],
        too_many_constants,
    ),
    (
        "an operation of the wrong form in the graph",
        Harm::Always,
        &[Rule::Form],
        wrong_graph,
    ),
    (
        "an interval of no cycle",
        Harm::Always,
        &[Rule::Contexts],
        no_interval,
    ),
    ("a shorter interval", Harm::Perhaps, TIMES, shorter_interval),
    ("a longer interval", Harm::Perhaps, TIMES, longer_interval),
    (
        "an end too early",
        Harm::Perhaps,
        &[Rule::Contexts],
        early_end,
    ),
    (
        "too many contexts",
        Harm::Always,
        &[Rule::Contexts],
        too_many_contexts,
    ),
];

fn other_iteration(broken: &mut Loop<'_>) -> Option<()> {
    let op = broken.op()?;
    let ii = broken.schedule.ii;
    let late = broken.dice.chance();
    let time = &mut broken.schedule.ops[op].time;
    *time = if late {
        *time + ii
    } else {
        time.checked_sub(ii)?
    };
    Some(())
}

fn other_cycle(broken: &mut Loop<'_>) -> Option<()> {
    let op = broken.op()?;
    let time = broken.schedule.ops[op].time;
    broken.schedule.ops[op].time = broken.dice.step(time)?;
    Some(())
}

/// As many iterations earlier as it takes.
fn out_of_order(broken: &mut Loop<'_>) -> Option<()> {
    let order = broken.dice.pick(&broken.schedule.dfg.order.clone())?;
    (order.from != order.to).then_some(())?;
    let ii = broken.schedule.ii;
    let at = |node: Node| Placed::new(node.index());
    let first = broken.schedule.ops[at(order.from)].time;
    let second = &mut broken.schedule.ops[at(order.to)].time;
    while *second + ii * order.distance >= first {
        *second = second.checked_sub(ii)?;
    }
    Some(())
}

fn same_slot(broken: &mut Loop<'_>) -> Option<()> {
    let a = broken.op()?;
    let one = broken.schedule.ops[a].clone();
    (!broken.is_ordered(&one)).then_some(())?;
    let b = broken.op_like(|op| op.fu == one.fu)?;
    let ii = broken.schedule.ii;
    let time = one.time - one.time % ii + broken.schedule.ops[b].time % ii;
    broken.schedule.ops[a].time = time;
    broken.last(time + 64);
    (a != b).then_some(())
}

fn move_in_slot(broken: &mut Loop<'_>) -> Option<()> {
    let op = broken.op()?;
    let data = broken.schedule.ops[op].clone();
    let ty = broken.ty(&data)?;
    broken.arch.srp.fus[data.fu].op(Opcode::mov(ty).class())?;
    broken.last(data.time + 64);
    broken.schedule.ops.push(PlacedOp {
        is_move: true,
        operands: vec![Source::Out(None)],
        writes: Vec::new(),
        ..data
    });
    Some(())
}

/// An access in a cycle in which others use the resource as often as there is of it.
fn resource(broken: &mut Loop<'_>) -> Option<()> {
    let accesses = broken.ops_like(|op| !broken.how(op).uses.is_empty());
    let (ii, schedule) = (broken.schedule.ii, &broken.schedule);
    let mut choices = Vec::new();
    for &op in &accesses {
        let data = &schedule.ops[op];
        let resource = broken.how(data).uses[0];
        for slot in (0..ii).filter(|&slot| slot != data.time % ii) {
            let in_slot = accesses
                .iter()
                .filter(|&&o| schedule.ops[o].time % ii == slot);
            let same = in_slot.filter(|&&o| broken.how(&schedule.ops[o]).uses.contains(&resource));
            let full = same.count() as u32 >= broken.arch.srp.resources[resource].count;
            let mut on_unit = schedule.ops.values().filter(|o| o.fu == data.fu);
            let free = on_unit.all(|o| o.time % ii != slot);
            if full && free && !broken.is_ordered(data) {
                choices.push((op, data.time - data.time % ii + slot));
            }
        }
    }
    let (op, time) = broken.dice.pick(&choices)?;
    broken.schedule.ops[op].time = time;
    broken.last(time + 64);
    Some(())
}

fn wrong_unit(broken: &mut Loop<'_>) -> Option<()> {
    let op = broken.op()?;
    let opcode = broken.opcode(&broken.schedule.ops[op]);
    let units = broken.arch.srp.fus.iter();
    let wrong: Vec<Fu> = units
        .filter(|(_, unit)| unit.runs(opcode).is_none())
        .map(|(fu, _)| fu)
        .collect();
    broken.schedule.ops[op].fu = broken.dice.pick(&wrong)?;
    Some(())
}

fn wrong_node(broken: &mut Loop<'_>) -> Option<()> {
    let op = broken.op_like(|op| !op.is_move)?;
    let nodes = broken.schedule.dfg.nodes.len();
    broken.schedule.ops[op].node = Node::new(broken.dice.below(nodes));
    Some(())
}

fn node_as_move(broken: &mut Loop<'_>) -> Option<()> {
    let op = broken.op()?;
    let is_move = &mut broken.schedule.ops[op].is_move;
    *is_move = !*is_move;
    Some(())
}

fn node_gone(broken: &mut Loop<'_>) -> Option<()> {
    let op = broken.op_like(|op| !op.is_move)?;
    without(broken, op);
    Some(())
}

/// Takes an operation out.
pub(super) fn without(broken: &mut Loop<'_>, op: Placed) {
    let ops = broken.schedule.ops.iter().filter(|&(other, _)| other != op);
    let ops: EntityMap<Placed, PlacedOp> = ops.map(|(_, data)| data.clone()).collect();
    broken.schedule.ops = ops;
}

fn operand_gone(broken: &mut Loop<'_>) -> Option<()> {
    let op = broken.op()?;
    broken.schedule.ops[op].operands.pop().map(drop)
}

fn too_many_constants(broken: &mut Loop<'_>) -> Option<()> {
    let op = broken.op_like(|op| !op.is_move)?;
    let data = broken.schedule.ops[op].clone();
    let room = broken.arch.srp.fus[data.fu].constants as usize;
    let kinds = broken.opcode(&data).info().operands;
    let words = kinds.iter().map(|k| k.ty() == srp_archdesc::Ty::Word);
    let words: Vec<usize> = words
        .enumerate()
        .filter(|(_, w)| *w)
        .map(|(i, _)| i)
        .collect();
    (words.len() > room).then_some(())?;
    for i in words {
        let bits = Bits::Word(1_000_000 + i as u32);
        broken.schedule.ops[op].operands[i] = Source::Const(bits);
    }
    Some(())
}

fn wrong_graph(broken: &mut Loop<'_>) -> Option<()> {
    let nodes = broken.schedule.dfg.nodes.len();
    let node = Node::new(broken.dice.below(nodes));
    let immediate = broken.dice.chance();
    let data = &mut broken.schedule.dfg.nodes[node];
    if immediate {
        data.imm = 1;
        (!data.op.info().immediate).then_some(())
    } else {
        data.operands.pop().map(drop)
    }
}

fn no_interval(broken: &mut Loop<'_>) -> Option<()> {
    broken.schedule.ii = 0;
    Some(())
}

fn shorter_interval(broken: &mut Loop<'_>) -> Option<()> {
    (broken.schedule.ii > 1).then_some(())?;
    broken.schedule.ii -= 1;
    Some(())
}

fn longer_interval(broken: &mut Loop<'_>) -> Option<()> {
    broken.schedule.ii += 1 + broken.dice.below(3) as u32;
    Some(())
}

fn early_end(broken: &mut Loop<'_>) -> Option<()> {
    let by = 1 + broken.dice.below(3) as u32;
    broken.schedule.length = broken.schedule.length.checked_sub(by).filter(|&l| l > 0)?;
    Some(())
}

fn too_many_contexts(broken: &mut Loop<'_>) -> Option<()> {
    let by = broken.dice.below(50) as u32;
    broken.schedule.ii = broken.arch.srp.contexts + 1 + by;
    Some(())
}
