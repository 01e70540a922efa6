//! Modulo schedules.
//!
//! Iteration `i` runs its cycle `t` in context `t mod ii`, `t / ii` iterations after it has begun.
//! So within a context the iteration of a step is known relative to the one begun last, which is
//! how registers of rotating files and of rings are named.

use super::flow::{Contexts, Dest, Flow};
use super::{LinkError, Linker, Site};
use crate::spec::{Action, Cell, KernelSpec, MAX_STAGES, Operand, Preset};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Effect, Opcode, Ty};
use srp_archdesc::resource::Place;
use srp_ir::dfg::Initial;
use srp_ir::dre::scheduled::{ModuloSchedule, PlacedOp, PlacedTransfer, RegAt, Source};
use srp_ir::program::Kernel;
use std::collections::BTreeMap;

/// The kernel with this number.
pub(super) fn kernel(linker: &mut Linker, kernel: Kernel) -> Result<KernelSpec, LinkError> {
    let schedule = &linker.program.kernels[kernel];
    let site = Site {
        scope: format!("kernel `{}`", schedule.dfg.name),
        pos: schedule.dfg.pos,
    };
    let unroll = unrolling(linker, schedule, &site)?;
    let Some(trip) = schedule.dfg.trip else {
        return Err(site.error(linker, "a graph without a trip count cannot be launched"));
    };
    let trip = live_in(linker, schedule, trip, Ty::Word, &site)?;
    let preloads = preloads(linker, schedule, &site)?;
    let mut array = Array {
        schedule,
        contexts: Contexts::new(kernel.index() as u32, schedule),
        delayed: BTreeMap::new(),
    };
    array.add_all(linker)?;
    let contexts = array.contexts.finish(linker);
    let setting = (preloads.len() as u32).div_ceil(linker.arch.srp.preload_width.max(1));
    Ok(KernelSpec {
        name: schedule.dfg.name.clone(),
        at: linker.position(schedule.dfg.pos),
        ii: schedule.ii,
        length: schedule.length,
        enter_cycles: linker.arch.srp.mode_switch + setting,
        leave_cycles: linker.arch.srp.mode_switch,
        trip,
        preloads,
        unroll,
        contexts,
    })
}

/// How often the contexts are repeated so that each ring is back at its first register.
fn unrolling(linker: &Linker, schedule: &ModuloSchedule, site: &Site) -> Result<u32, LinkError> {
    if schedule.ii == 0 || schedule.length == 0 {
        return Err(site.error(linker, "initiation interval and length must not be 0"));
    }
    let ring_is_zero = |reg: &RegAt| reg.ring == 0;
    let sources = schedule.ops.values().flat_map(|op| &op.operands);
    let read = sources.filter_map(|source| match source {
        Source::Reg { reg, .. } => Some(reg),
        Source::Const(_) | Source::Out(_) => None,
    });
    let written = schedule.ops.values().flat_map(|op| &op.writes);
    let transferred = schedule.transfers.iter().map(|t| &t.to);
    let mut rings: Vec<_> = read.chain(written).chain(transferred).collect();
    if rings.iter().any(|reg| ring_is_zero(reg)) {
        return Err(site.error(linker, "a ring has no register"));
    }
    rings.sort_by_key(|reg| reg.ring);
    rings.dedup_by_key(|reg| reg.ring);
    let depth = linker.arch.srp.contexts;
    let mut contexts = u64::from(schedule.ii);
    let mut unroll = 1u64;
    for reg in rings {
        unroll = lcm(unroll, u64::from(reg.ring));
        contexts = u64::from(schedule.ii).saturating_mul(unroll);
        if contexts > u64::from(depth) {
            break;
        }
    }
    if contexts > u64::from(depth) {
        let message =
            format!("{contexts} contexts or more do not fit in the {depth} of the machine");
        return Err(site.error(linker, message));
    }
    let stages = schedule.length.div_ceil(schedule.ii);
    if stages > MAX_STAGES {
        let message = format!("{stages} stages overlap; simulators have {MAX_STAGES} predicates");
        return Err(site.error(linker, message));
    }
    Ok(unroll as u32)
}

fn lcm(a: u64, b: u64) -> u64 {
    let (mut x, mut y) = (a, b);
    while y != 0 {
        (x, y) = (y, x % y);
    }
    (a / x).saturating_mul(b)
}

/// The central register of live-in `number`.
fn live_in(
    linker: &Linker,
    schedule: &ModuloSchedule,
    number: u32,
    ty: Ty,
    site: &Site,
) -> Result<Cell, LinkError> {
    let Some(reg) = schedule.live_in_regs.get(number as usize) else {
        return Err(site.error(linker, format!("there is no live-in {number}")));
    };
    linker.plain(*reg, ty, site)
}

fn preloads(
    linker: &Linker,
    schedule: &ModuloSchedule,
    site: &Site,
) -> Result<Vec<Preset>, LinkError> {
    let mut presets = Vec::new();
    for preload in &schedule.preloads {
        let ty = preload.ty;
        let at = RegAt {
            file: preload.file,
            index: preload.index,
            ring: 1,
        };
        let value = match preload.value {
            Initial::Const(bits) => linker.constant(bits, ty, site)?,
            Initial::LiveIn(n) => Operand::Cell(live_in(linker, schedule, n, ty, site)?),
            Initial::Any => {
                return Err(site.error(linker, "a register is set at entry to no value"));
            }
        };
        presets.push(Preset {
            cell: linker.register(at, 0, ty, site)?,
            value,
            ty,
        });
    }
    Ok(presets)
}

/// One kernel on its way into contexts.
struct Array<'a> {
    schedule: &'a ModuloSchedule,
    contexts: Contexts,
    /// The store of what an output was, for those read over links with registers.
    delayed: BTreeMap<Place, u32>,
}

impl Array<'_> {
    fn add_all(&mut self, linker: &mut Linker) -> Result<(), LinkError> {
        let schedule = self.schedule;
        self.find_delayed(linker)?;
        for (placed, op) in schedule.ops.iter() {
            let Some(node) = schedule.dfg.nodes.get(op.node) else {
                let scope = format!("kernel `{}`, {placed}", schedule.dfg.name);
                let message = format!("there is no node {}", op.node);
                return Err(linker.error(&scope, schedule.dfg.pos, message));
            };
            let site = Site {
                scope: format!("kernel `{}`, {placed}", schedule.dfg.name),
                pos: node.pos,
            };
            self.add_op(linker, placed.index(), op, &site)?;
        }
        for (number, transfer) in schedule.transfers.iter().enumerate() {
            let pos = schedule.dfg.nodes.get(transfer.node).map(|n| n.pos);
            let site = Site {
                scope: format!("kernel `{}`, transfer {number}", schedule.dfg.name),
                pos: pos.unwrap_or(schedule.dfg.pos),
            };
            self.add_transfer(linker, number, transfer, &site)?;
        }
        Ok(())
    }

    /// Makes a store for what each output was, where a link with registers is read.
    fn find_delayed(&mut self, linker: &mut Linker) -> Result<(), LinkError> {
        let mut longest: BTreeMap<Place, u32> = BTreeMap::new();
        for op in self.schedule.ops.values() {
            for source in &op.operands {
                let Source::Out(Some(link)) = source else {
                    continue;
                };
                let Some(spec) = linker.arch.srp.links.get(*link) else {
                    continue;
                };
                for place in linker.graph.outputs(spec.from) {
                    if spec.delay > 0 {
                        let entry = longest.entry(place).or_default();
                        *entry = spec.delay.max(*entry);
                    }
                }
            }
        }
        for (place, delay) in longest {
            let store = self.contexts.add_past(linker, place, delay);
            self.delayed.insert(place, store);
        }
        Ok(())
    }

    fn add_op(
        &mut self,
        linker: &mut Linker,
        number: usize,
        op: &PlacedOp,
        site: &Site,
    ) -> Result<(), LinkError> {
        let (opcode, imm) = self.opcode(linker, op, site)?;
        let latency = match opcode.result() {
            Some(_) => linker.latency(op.fu, opcode, site)?,
            // A store is over with its cycle.
            None => linker.latency(op.fu, opcode, site).map(|_| 1)?,
        };
        let result = linker.graph.result_place(op.fu, opcode);
        let mut dests: Vec<Dest> = result.into_iter().map(Dest::Place).collect();
        for write in &op.writes {
            linker.writes(op.fu, write.file, site)?;
            dests.push(Dest::Reg(*write));
        }
        let back = i64::from(op.time / self.schedule.ii);
        let mut operands = Vec::new();
        for (source, kind) in op.operands.iter().zip(opcode.info().operands) {
            operands.push(self.source(linker, op, source, kind.ty(), back, site)?);
        }
        let action = Action::Op {
            op: opcode,
            operands,
            imm,
        };
        let flow = Flow {
            name: format!("op{number}"),
            time: op.time,
            latency,
            ty: opcode.result(),
            dests,
            at: linker.position(site.pos),
        };
        self.contexts.add_flow(linker, &flow, action, site)
    }

    /// What an operation is, with its immediate.
    fn opcode(
        &self,
        linker: &Linker,
        op: &PlacedOp,
        site: &Site,
    ) -> Result<(Opcode, i32), LinkError> {
        let node = &self.schedule.dfg.nodes[op.node];
        let (opcode, imm) = match (op.is_move, node.op.result()) {
            (false, _) => (node.op, node.imm),
            (true, Some(ty)) => (Opcode::mov(ty), 0),
            (true, None) => {
                return Err(site.error(linker, format!("`{}` has no value to move", node.op)));
            }
        };
        if opcode.info().effect == Effect::Io {
            return Err(site.error(linker, "the array has no ports"));
        }
        let takes = opcode.info().operands.len();
        if op.operands.len() != takes {
            return Err(site.error(linker, format!("`{opcode}` takes {takes} operands")));
        }
        Ok((opcode, imm))
    }

    /// Where an operand of the iteration `back` before the last is read.
    fn source(
        &self,
        linker: &Linker,
        op: &PlacedOp,
        source: &Source,
        ty: Ty,
        back: i64,
        site: &Site,
    ) -> Result<Operand, LinkError> {
        let cell = match source {
            Source::Const(bits) => return linker.constant(*bits, ty, site),
            Source::Out(None) => linker.output(op.fu, ty),
            Source::Out(Some(link)) => {
                let (from, to) = self.ends(linker, *link, ty, site)?;
                if to != op.fu {
                    let unit = &linker.arch.srp.fus[op.fu].name;
                    return Err(site.error(linker, format!("{link} does not lead to {unit}")));
                }
                match linker.arch.srp.links[*link].delay {
                    0 => linker.output(from, ty),
                    delay => {
                        let past = self.delayed[&linker.output_place(from, ty)];
                        Cell::new(past, delay - 1)
                    }
                }
            }
            Source::Reg { reg, distance } => {
                linker.reads(op.fu, reg.file, site)?;
                linker.register(*reg, back + i64::from(*distance), ty, site)?
            }
        };
        linker.holds(cell, ty, site)?;
        Ok(Operand::Cell(cell))
    }

    /// The units that a link joins; it carries values of type `ty`.
    fn ends(
        &self,
        linker: &Linker,
        link: srp_archdesc::arch::Link,
        ty: Ty,
        site: &Site,
    ) -> Result<(srp_archdesc::arch::Fu, srp_archdesc::arch::Fu), LinkError> {
        let Some(spec) = linker.arch.srp.links.get(link) else {
            return Err(site.error(linker, format!("there is no {link}")));
        };
        if ty.bits() > spec.width {
            let message = format!("{link} is too narrow for a {}", super::name(ty));
            return Err(site.error(linker, message));
        }
        Ok((spec.from, spec.to))
    }

    fn add_transfer(
        &mut self,
        linker: &mut Linker,
        number: usize,
        transfer: &PlacedTransfer,
        site: &Site,
    ) -> Result<(), LinkError> {
        let node = self.schedule.dfg.nodes.get(transfer.node);
        let Some(ty) = node.and_then(|n| n.op.result()) else {
            let message = format!("{} has no value to transfer", transfer.node);
            return Err(site.error(linker, message));
        };
        let (from, to) = self.ends(linker, transfer.link, ty, site)?;
        linker.writes(to, transfer.to.file, site)?;
        let file = linker.file(transfer.to.file, ty, site)?;
        if !linker.arch.srp.files[file].from_links {
            let file = &linker.arch.srp.files[file].name;
            return Err(site.error(linker, format!("{file} cannot be written from links")));
        }
        let output = linker.output(from, ty);
        linker.holds(output, ty, site)?;
        let flow = Flow {
            name: format!("transfer{number}"),
            time: transfer.time,
            latency: linker.arch.srp.links[transfer.link].delay + 1,
            ty: Some(ty),
            dests: vec![Dest::Reg(transfer.to)],
            at: linker.position(site.pos),
        };
        self.contexts
            .add_flow(linker, &flow, Action::Copy(output), site)
    }
}
