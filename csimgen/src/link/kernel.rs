//! Modulo schedules.
//!
//! Iteration `i` runs its cycle `t` in context `t mod ii`, `t / ii` iterations after it has begun.
//! So within a context the iteration of a step is known relative to the one begun last, which is
//! how registers of rotating files and of rings are named.
//!
//! A context sets the inputs of all wires. So what is read from a wire is read from the output to which the wires lead
//! back then, and wires take no time in a simulator.

use super::Linker;
use super::flow::{Contexts, Dest, Flow};
use crate::spec::{Action, Cell, KernelSpec, Operand, Origin, Preset};
use srp_archdesc::arch::{Carrier, Input, Wire};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Opcode, Ty};
use srp_archdesc::resource::Place;
use srp_ir::dfg::{Initial, Node};
use srp_ir::dre::scheduled::{
    ModuloSchedule, PlacedHop, PlacedOp, PlacedTransfer, Preload, RegAt, Source,
};
use srp_ir::program::Kernel;
use std::collections::BTreeMap;

/// The kernel with this number.
pub(super) fn kernel(linker: &mut Linker, kernel: Kernel) -> KernelSpec {
    let schedule = &linker.program.kernels[kernel];
    let trip = schedule.dfg.trip.expect("a kernel has a trip count");
    let trip = live_in(linker, schedule, trip);
    let preloads = schedule.preloads.iter();
    let preloads: Vec<Preset> = preloads
        .map(|preload| preset(linker, schedule, preload))
        .collect();
    let mut array = Array {
        schedule,
        contexts: Contexts::new(kernel.index() as u32, schedule),
        hops: (schedule.hops.iter())
            .map(|hop| ((hop.wire, hop.time % schedule.ii), *hop))
            .collect(),
        delayed: BTreeMap::new(),
    };
    array.add_all(linker);
    let contexts = array.contexts.finish(linker);
    let setting = (preloads.len() as u32).div_ceil(linker.arch.srp.preload_width.max(1));
    KernelSpec {
        name: schedule.dfg.name.clone(),
        at: linker.position(schedule.dfg.pos),
        ii: schedule.ii,
        length: schedule.length,
        enter_cycles: linker.arch.srp.mode_switch + setting,
        leave_cycles: linker.arch.srp.mode_switch,
        operations: schedule.dfg.nodes.len() as u32,
        trip,
        preloads,
        // So often that each ring is back at its first register.
        unroll: schedule.contexts() / schedule.ii,
        contexts,
    }
}

/// The central register of live-in `number`.
fn live_in(linker: &Linker, schedule: &ModuloSchedule, number: u32) -> Cell {
    linker.plain(schedule.live_in_regs[number as usize])
}

fn preset(linker: &Linker, schedule: &ModuloSchedule, preload: &Preload) -> Preset {
    let at = RegAt {
        file: preload.file,
        index: preload.index,
        ring: 1,
    };
    Preset {
        cell: linker.register(at, 0),
        value: match preload.value {
            Initial::Const(bits) => Operand::Const(bits),
            Initial::LiveIn(n) => Operand::Cell(live_in(linker, schedule, n)),
            Initial::Any => unreachable!("registers are set to values"),
        },
        ty: preload.ty,
    }
}

/// The other end of wires.
struct Behind {
    /// The output that they lead back to.
    output: Place,
    /// Registers on the way.
    delay: u32,
}

/// One kernel on its way into contexts.
struct Array<'a> {
    schedule: &'a ModuloSchedule,
    contexts: Contexts,
    /// What each wire takes in each slot of the II.
    hops: BTreeMap<(Wire, u32), PlacedHop>,
    /// The store of the earlier values of an output, for outputs that are read over links or wires with registers.
    delayed: BTreeMap<Place, u32>,
}

impl Array<'_> {
    fn add_all(&mut self, linker: &mut Linker) {
        let schedule = self.schedule;
        self.find_delayed(linker);
        for (placed, op) in schedule.ops.iter() {
            self.add_op(linker, placed.index(), op);
        }
        for (number, transfer) in schedule.transfers.iter().enumerate() {
            self.add_transfer(linker, number, transfer);
        }
    }

    /// Makes a store for the earlier values of each output that is read over links or wires with registers.
    fn find_delayed(&mut self, linker: &mut Linker) {
        let mut longest: BTreeMap<Place, u32> = BTreeMap::new();
        let mut note = |place: Place, delay: u32| {
            if delay > 0 {
                let entry = longest.entry(place).or_default();
                *entry = delay.max(*entry);
            }
        };
        for op in self.schedule.ops.values() {
            for source in &op.operands {
                match *source {
                    Source::Out(Some(link)) => {
                        let spec = &linker.arch.srp.links[link];
                        let outputs = linker.graph.outputs(spec.from);
                        outputs.for_each(|place| note(place, spec.delay));
                    }
                    Source::Wire(wire) => {
                        let behind = self.behind(linker, wire, op.time);
                        note(behind.output, behind.delay);
                    }
                    Source::Out(None) | Source::Const(_) | Source::Reg { .. } => {}
                }
            }
        }
        for transfer in &self.schedule.transfers {
            if let Carrier::Wire(wire) = transfer.over {
                let spec = &linker.arch.srp.wires[wire];
                let behind = self.behind(linker, wire, transfer.time + spec.delay);
                note(behind.output, behind.delay - spec.delay);
            }
        }
        for (place, delay) in longest {
            let store = self.contexts.add_past(linker, place, delay);
            self.delayed.insert(place, store);
        }
    }

    /// Follows the wires that are set to lead to the end of `wire` in a cycle of iteration 0.
    fn behind(&self, linker: &Linker, mut wire: Wire, time: u32) -> Behind {
        let ii = i64::from(self.schedule.ii);
        let mut delay = 0;
        loop {
            delay += linker.arch.srp.wires[wire].delay;
            let slot = (i64::from(time) - i64::from(delay)).rem_euclid(ii) as u32;
            let hop = &self.hops[&(wire, slot)];
            match hop.from {
                Input::Wire(before) => wire = before,
                Input::Unit(fu) => {
                    let ty = self.ty(hop.node);
                    let output = linker.output_place(fu, ty);
                    return Behind { output, delay };
                }
            }
        }
    }

    /// The type of a value.
    fn ty(&self, node: Node) -> Ty {
        let ty = self.schedule.dfg.nodes[node].op.result();
        ty.expect("what goes its way is a value")
    }

    /// The cell with what an output held some cycles ago.
    fn past(&self, linker: &Linker, output: Place, delay: u32) -> Cell {
        match delay {
            0 => linker.place_cell(output, 0),
            _ => Cell::new(self.delayed[&output], delay - 1),
        }
    }

    fn add_op(&mut self, linker: &mut Linker, number: usize, op: &PlacedOp) {
        let node = &self.schedule.dfg.nodes[op.node];
        let (opcode, imm) = match node.op.result() {
            Some(ty) if op.is_move => (Opcode::mov(ty), 0),
            _ => (node.op, node.imm),
        };
        let latency = match opcode.result() {
            Some(_) => linker.latency(op.fu, opcode),
            // A store is over with its cycle.
            None => 1,
        };
        let result = linker.graph.result_place(op.fu, opcode);
        let mut dests: Vec<Dest> = result.into_iter().map(Dest::Place).collect();
        dests.extend(op.writes.iter().map(|write| Dest::Reg(*write)));
        let back = i64::from(op.time / self.schedule.ii);
        let operands = op.operands.iter().zip(opcode.info().operands);
        let operands =
            operands.map(|(source, kind)| self.source(linker, op, source, kind.ty(), back));
        let action = Action::Op {
            op: opcode,
            operands: operands.collect(),
            imm,
        };
        let flow = Flow {
            name: format!("op{number}"),
            time: op.time,
            latency,
            ty: opcode.result(),
            dests,
            origin: Origin::Unit {
                unit: op.fu,
                latency,
            },
            at: linker.position(node.pos),
        };
        self.contexts.add_flow(linker, &flow, action);
    }

    /// Where an operand of the iteration `back` before the last is read.
    fn source(
        &self,
        linker: &Linker,
        op: &PlacedOp,
        source: &Source,
        ty: Ty,
        back: i64,
    ) -> Operand {
        let cell = match source {
            Source::Const(bits) => return Operand::Const(*bits),
            Source::Out(None) => linker.output(op.fu, ty),
            Source::Out(Some(link)) => {
                let spec = &linker.arch.srp.links[*link];
                self.past(linker, linker.output_place(spec.from, ty), spec.delay)
            }
            Source::Wire(wire) => {
                let behind = self.behind(linker, *wire, op.time);
                self.past(linker, behind.output, behind.delay)
            }
            Source::Reg { reg, distance } => linker.register(*reg, back + i64::from(*distance)),
        };
        Operand::Cell(cell)
    }

    fn add_transfer(&mut self, linker: &mut Linker, number: usize, transfer: &PlacedTransfer) {
        let node = &self.schedule.dfg.nodes[transfer.node];
        let ty = self.ty(transfer.node);
        let delay = linker.arch.srp.delay(transfer.over);
        let from = match transfer.over {
            Carrier::Link(link) => linker.output(linker.arch.srp.links[link].from, ty),
            Carrier::Wire(wire) => {
                // As the wire takes it; its own registers are part of the latency.
                let behind = self.behind(linker, wire, transfer.time + delay);
                self.past(linker, behind.output, behind.delay - delay)
            }
        };
        let flow = Flow {
            name: format!("transfer{number}"),
            time: transfer.time,
            latency: delay + 1,
            ty: Some(ty),
            dests: vec![Dest::Reg(transfer.to)],
            origin: Origin::Over {
                carrier: transfer.over,
                latency: delay + 1,
            },
            at: linker.position(node.pos),
        };
        self.contexts.add_flow(linker, &flow, Action::Copy(from));
    }
}
