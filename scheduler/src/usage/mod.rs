//! Resources of the machine that a modulo schedule takes, slot by slot, once the pipeline is full:
//! issue cycles, shared resources, links, wires, registers and the ports of their files.
//!
//! They are read off the schedule alone, whoever made it. A *slot* is a cycle modulo the II.

mod fullest;
mod registers;

pub use fullest::{Part, Share};
use srp_archdesc::arch::{Carrier, Fu, FuOp, Input, Link, RegFile, Resource, Srp, Wire};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Opcode;
use srp_ir::dfg::Node;
use srp_ir::dre::scheduled::{ModuloSchedule, Placed, PlacedOp, Source};
use std::collections::BTreeSet;

/// The resources that a loop takes. Every list by slot has as many entries as the II.
#[derive(Clone, Debug, PartialEq)]
pub struct Usage {
    /// Of each unit.
    pub units: EntityMap<Fu, UnitUse>,
    /// Of each link.
    pub links: EntityMap<Link, LinkUse>,
    /// Of each wire.
    pub wires: EntityMap<Wire, LinkUse>,
    /// Uses of each shared resource, by slot.
    pub resources: EntityMap<Resource, Vec<u32>>,
    /// Of each register file.
    pub files: EntityMap<RegFile, FileUse>,
}

/// Slots of a unit, at most the II together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UnitUse {
    /// In which it issues an operation of the loop.
    pub operations: u32,
    /// In which it issues a routing move.
    pub moves: u32,
    /// In which it can issue nothing, for an operation before keeps it.
    pub held: u32,
}

impl UnitUse {
    /// Slots in which it can issue nothing else.
    pub fn busy(self) -> u32 {
        self.operations + self.moves + self.held
    }
}

/// The use of a link or a wire.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinkUse {
    /// The values taken from its end, by slot, each with its destination.
    pub carried: Vec<Carried>,
}

impl LinkUse {
    /// Slots in which something is taken from a link, or a wire takes something.
    pub fn slots(&self) -> u32 {
        let slots: BTreeSet<u32> = self.carried.iter().map(|c| c.slot).collect();
        slots.len() as u32
    }
}

/// A value taken from the end of a link or a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Carried {
    /// The slot in which it is taken from a link, or in which a wire takes it.
    pub slot: u32,
    /// Whose value it is.
    pub node: Node,
    /// Its destination.
    pub to: Taker,
}

/// The destination of a value taken from a link or a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Taker {
    /// An operand of this operation.
    Op(Placed),
    /// A register file, past the unit.
    File(RegFile),
    /// Another wire.
    Wire(Wire),
}

/// The use of a register file and its ports.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileUse {
    /// Registers that hold something that is still needed, by slot.
    pub live: Vec<u32>,
    /// Those among them that hold one value throughout: loop invariants, live-ins and live-outs,
    /// and registers that the calling convention keeps.
    pub kept: u32,
    /// Registers read, by slot: the most of any iteration.
    pub reads: Vec<u32>,
    /// Registers written, by slot.
    pub writes: Vec<u32>,
}

impl FileUse {
    /// The most registers live at once, and the first slot in which they are.
    pub fn worst(&self) -> (u32, u32) {
        most(&self.live)
    }

    /// The most registers read at once, and the first slot in which they are.
    pub fn most_read(&self) -> (u32, u32) {
        most(&self.reads)
    }

    /// The most registers written at once, and the first slot in which they are.
    pub fn most_written(&self) -> (u32, u32) {
        most(&self.writes)
    }
}

/// The largest entry, and the first slot that has it.
fn most(by_slot: &[u32]) -> (u32, u32) {
    let largest = by_slot.iter().copied().max().unwrap_or(0);
    let slot = by_slot.iter().position(|&n| n == largest).unwrap_or(0);
    (largest, slot as u32)
}

/// Returns the resources that a schedule takes. [`check`](srp_ir::check) must have accepted the
/// schedule.
pub fn usage(schedule: &ModuloSchedule, srp: &Srp) -> Usage {
    let ii = schedule.ii as usize;
    let mut usage = Usage {
        units: EntityMap::filled(srp.fus.len(), UnitUse::default()),
        links: EntityMap::filled(srp.links.len(), LinkUse::default()),
        wires: EntityMap::filled(srp.wires.len(), LinkUse::default()),
        resources: EntityMap::filled(srp.resources.len(), vec![0; ii]),
        files: registers::files(schedule, srp),
    };
    for (number, op) in schedule.ops.iter() {
        let unit = &mut usage.units[op.fu];
        match op.is_move {
            true => unit.moves += 1,
            false => unit.operations += 1,
        }
        if let Some(how) = timing(schedule, srp, op) {
            unit.held += how.interval.saturating_sub(1);
            for cycle in 0..how.interval {
                for &resource in &how.uses {
                    usage.resources[resource][((op.time + cycle) % schedule.ii) as usize] += 1;
                }
            }
        }
        for (operand, source) in op.operands.iter().enumerate() {
            let over = match *source {
                Source::Out(Some(link)) => Carrier::Link(link),
                Source::Wire(wire) => Carrier::Wire(wire),
                Source::Out(None) | Source::Const(_) | Source::Reg { .. } => continue,
            };
            let node = producer(schedule, op, operand);
            usage.carry(srp, over, op.time, node, Taker::Op(number), schedule.ii);
        }
    }
    for transfer in &schedule.transfers {
        let time = transfer.time + srp.delay(transfer.over);
        let to = Taker::File(transfer.to.file);
        usage.carry(srp, transfer.over, time, transfer.node, to, schedule.ii);
    }
    for hop in &schedule.hops {
        if let Input::Wire(before) = hop.from {
            let (over, to) = (Carrier::Wire(before), Taker::Wire(hop.wire));
            usage.carry(srp, over, hop.time, hop.node, to, schedule.ii);
        }
    }
    for used in usage.links.values_mut().chain(usage.wires.values_mut()) {
        used.carried.sort();
        used.carried.dedup();
    }
    usage
}

impl Usage {
    /// Notes a value that is taken from the end of a link or a wire in a cycle.
    fn carry(&mut self, srp: &Srp, over: Carrier, time: u32, node: Node, to: Taker, ii: u32) {
        let (used, time) = match over {
            Carrier::Link(link) => (&mut self.links[link], i64::from(time)),
            Carrier::Wire(wire) => {
                let delay = i64::from(srp.wires[wire].delay);
                (&mut self.wires[wire], i64::from(time) - delay)
            }
        };
        let slot = time.rem_euclid(i64::from(ii)) as u32;
        used.carried.push(Carried { slot, node, to });
    }
}

/// Returns the opcode of a placed operation: that of its node, or a move of the node's value.
pub fn opcode(schedule: &ModuloSchedule, op: &PlacedOp) -> Opcode {
    let node = schedule.dfg.nodes[op.node].op;
    match node.result() {
        Some(ty) if op.is_move => Opcode::mov(ty),
        _ => node,
    }
}

/// How the unit of a placed operation runs it.
pub fn timing<'a>(schedule: &ModuloSchedule, srp: &'a Srp, op: &PlacedOp) -> Option<&'a FuOp> {
    srp.fus[op.fu].timing(opcode(schedule, op))
}

/// Whose value an operand is.
fn producer(schedule: &ModuloSchedule, op: &PlacedOp, operand: usize) -> Node {
    let node = &schedule.dfg.nodes[op.node];
    let producer = node.operands.get(operand).and_then(|o| o.producer());
    match producer {
        Some((node, _)) if !op.is_move => node,
        _ => op.node,
    }
}
