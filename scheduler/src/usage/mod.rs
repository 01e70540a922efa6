//! Resources of the machine that a modulo schedule takes, slot by slot, once the pipeline is full:
//! issue cycles, shared resources, links, registers and the ports of their files.
//!
//! They are read off the schedule alone, whoever made it. A *slot* is a cycle modulo the II.

mod registers;

use srp_archdesc::arch::{Fu, FuOp, Link, RegFile, Resource, Srp};
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

/// The use of a link.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinkUse {
    /// The values taken from its end, by slot, each with its destination.
    pub carried: Vec<Carried>,
}

impl LinkUse {
    /// Slots in which something is taken from it.
    pub fn slots(&self) -> u32 {
        let slots: BTreeSet<u32> = self.carried.iter().map(|c| c.slot).collect();
        slots.len() as u32
    }
}

/// A value taken from the end of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Carried {
    /// The slot in which it is taken.
    pub slot: u32,
    /// Whose value it is.
    pub node: Node,
    /// Its destination.
    pub to: Taker,
}

/// The destination of a value taken from a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Taker {
    /// An operand of this operation.
    Op(Placed),
    /// A register file, past the unit.
    File(RegFile),
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
            if let Source::Out(Some(link)) = *source {
                usage.links[link].carried.push(Carried {
                    slot: op.time % schedule.ii,
                    node: producer(schedule, op, operand),
                    to: Taker::Op(number),
                });
            }
        }
    }
    for transfer in &schedule.transfers {
        let time = transfer.time + srp.links[transfer.link].delay;
        usage.links[transfer.link].carried.push(Carried {
            slot: time % schedule.ii,
            node: transfer.node,
            to: Taker::File(transfer.to.file),
        });
    }
    for (_, link) in usage.links.iter_mut() {
        link.carried.sort();
        link.carried.dedup();
    }
    usage
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
