//! What everything in a window was made of.

use super::Place;
use super::numbering::{Numbering, Thing, is_operation};
use crate::event::{Done, Packet, What};
use crate::flow::Flow;
use crate::replay::replay;
use crate::trace::Trace;
use srp_archdesc::isa::{Opcode, Space};
use srp_csimgen::spec::{Action, Operand, Step};
use srp_runtime::tni::{Buffers, HIT_BYTES, HitRecord, RAY_BYTES};
use std::collections::{BTreeMap, HashMap};

/// What something was made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    /// The operation, by its number in [`Links::steps`]; none for a ray.
    pub(super) step: Option<u32>,
    /// Where it was done.
    pub(super) place: Place,
    /// Who made its operands.
    pub(super) operands: [Option<u32>; 3],
    /// Where in [`Links::memory`] those are, and how many, who made what it has read.
    memory: (u32, u32),
    /// True for an access that is made.
    pub(super) is_made: bool,
}

/// An operation of the program.
#[derive(Clone, Copy, Debug)]
pub(super) struct Opcodes {
    pub(super) opcode: Option<Opcode>,
    /// True if of its operands one at most is no constant.
    pub(super) counts: bool,
}

/// What everything in a window was made of.
#[derive(Default)]
pub(super) struct Links {
    pub(super) links: Vec<Link>,
    pub(super) steps: Vec<Opcodes>,
    memory: Vec<u32>,
    /// Who has written each byte of the SRAM.
    sram: Vec<Option<u32>>,
    /// The same of the memory that all cores share.
    shared: HashMap<u32, u32>,
}

impl Links {
    /// Of the core of a trace.
    pub(super) fn of(trace: &Trace, launches: &[u64]) -> Links {
        let mut builder = Builder {
            links: Links {
                sram: vec![None; trace.spec.sram_bytes as usize],
                ..Links::default()
            },
            numbers: HashMap::new(),
            flow: Flow::default(),
            turn: None,
            packets: BTreeMap::new(),
        };
        let mut numbering = Numbering::new(launches);
        replay(trace, &mut |event| {
            if builder.turn.is_some_and(|turn| turn < event.cycle) {
                builder.turn = None;
                builder.flow.end_turn();
            }
            if let What::Turn(_) = event.what {
                builder.turn = Some(event.cycle);
            }
            let numbered = numbering.take(&event);
            match (numbered, event.what) {
                (Some((id, Thing::Operation(place))), What::Step(done)) => {
                    builder.operation(id, place, &done);
                }
                (Some((first, Thing::Packet(packet))), _) => builder.packet(first, packet),
                (Some((_, Thing::Hits(number, hits))), _) => builder.hits(number, hits),
                (None, What::Step(done)) => builder.flow.pass_on(&done),
                (None, What::Preset(cell, _, source)) => builder.flow.set(cell, source),
                _ => {}
            }
        });
        builder.links
    }

    /// Who has written the four bytes at an address of the memory that all cores share.
    pub(super) fn writers(&self, address: u32) -> Vec<u32> {
        self.found(Space::Cached, address, 4)
    }

    /// Who made what it has read.
    pub(super) fn memory(&self, link: &Link) -> &[u32] {
        let (first, count) = link.memory;
        &self.memory[first as usize..(first + count) as usize]
    }

    fn found(&self, space: Space, address: u32, bytes: u32) -> Vec<u32> {
        let of = |byte: u32| match space {
            Space::Sram => self.sram.get(byte as usize).copied().flatten(),
            Space::Cached => self.shared.get(&byte).copied(),
        };
        let mut found: Vec<u32> = (0..bytes)
            .filter_map(|byte| of(address.checked_add(byte)?))
            .collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    fn write(&mut self, space: Space, address: u32, bytes: u32, writer: u32) {
        for byte in (0..bytes).filter_map(|byte| address.checked_add(byte)) {
            match space {
                Space::Sram => {
                    if let Some(of) = self.sram.get_mut(byte as usize) {
                        *of = Some(writer);
                    }
                }
                Space::Cached => {
                    self.shared.insert(byte, writer);
                }
            }
        }
    }

    fn remember(&mut self, found: Vec<u32>) -> (u32, u32) {
        let at = (self.memory.len() as u32, found.len() as u32);
        self.memory.extend(found);
        at
    }
}

struct Builder {
    links: Links,
    /// The number of each step, by where it lies: the program's tables stay where they are.
    numbers: HashMap<*const Step, u32>,
    flow: Flow<u32>,
    /// The cycle of the turn that is being taken.
    turn: Option<u64>,
    /// The packets in the T&I unit: the number of the first ray, and the buffers.
    packets: BTreeMap<u64, (u32, Buffers)>,
}

impl Builder {
    fn operation(&mut self, id: u32, place: Place, done: &Done<'_>) {
        debug_assert!(is_operation(done.step));
        debug_assert_eq!(id as usize, self.links.links.len());
        let mut operands = self.flow.producers(done);
        let opcode = done.step.opcode();
        if let Some(Opcode::Sel | Opcode::Psel | Opcode::Vsel) = opcode {
            // The other has made nothing.
            let left_out = if done.operands[0].as_pred() { 2 } else { 1 };
            operands[left_out] = None;
        }
        let mut memory = (0, 0);
        let access = opcode.and_then(|op| Some((op.space()?, op.access_bytes()?)));
        let address = done.address();
        if let (Some((space, bytes)), Some(address)) = (access, address) {
            match done.step.ty {
                None => self.links.write(space, address, bytes, id),
                Some(_) => {
                    let found = self.links.found(space, address, bytes);
                    memory = self.links.remember(found);
                }
            }
        }
        self.flow.make(done, id);
        let step = self.number(done.step);
        self.links.links.push(Link {
            step: Some(step),
            place,
            operands,
            memory,
            is_made: address.is_some(),
        });
    }

    fn number(&mut self, step: &Step) -> u32 {
        let steps = &mut self.links.steps;
        *self.numbers.entry(step).or_insert_with(|| {
            let variable = match &step.action {
                Action::Op { operands, .. } => operands
                    .iter()
                    .filter(|operand| matches!(operand, Operand::Cell(_)))
                    .count(),
                Action::Copy(_) => 1,
            };
            steps.push(Opcodes {
                opcode: step.opcode(),
                counts: variable <= 1,
            });
            steps.len() as u32 - 1
        })
    }

    fn packet(&mut self, first: u32, packet: &Packet) {
        let Packet {
            number, buffers, ..
        } = packet;
        self.packets.insert(*number, (first, *buffers));
        for ray in 0..buffers.count {
            let address = buffers.rays + ray * RAY_BYTES;
            let found = self.links.found(Space::Sram, address, RAY_BYTES);
            let memory = self.links.remember(found);
            self.links.links.push(Link {
                step: None,
                place: Place::Bundle(0),
                operands: [None; 3],
                memory,
                is_made: true,
            });
        }
    }

    fn hits(&mut self, number: u64, hits: &[HitRecord]) {
        let Some((first, buffers)) = self.packets.remove(&number) else {
            return;
        };
        for (i, hit) in (0..).zip(hits) {
            let address = buffers.hits + i * HIT_BYTES;
            self.links
                .write(Space::Sram, address, HIT_BYTES, first + hit.ray);
        }
    }
}
