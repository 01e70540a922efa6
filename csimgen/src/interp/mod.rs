//! The table interpreter: the engine that needs no compiler, and the one that generated simulators
//! are compared with.
//!
//! All state lies in one vector of cells, constants behind it, so that an operand is an index. What
//! a cycle does is a stretch of one vector of operations. Nothing is looked up by name or allocated
//! while it runs.

mod tables;

use crate::preamble::border::{Border, Fault, Stop, divided};
use crate::preamble::ops::V4;
use crate::preamble::sequencer::{Datapath, Issue, KernelTimes, Sequencer, callee};
use crate::spec::SimSpec;
use srp_archdesc::isa::Opcode;
use srp_archdesc::ops;
use srp_ir::dre::scheduled::FUNC_BASE;
use srp_runtime::core::{Bus, Core, Run, Trap, TrapKind};
use tables::{Act, ControlAct, Index, Micro, NOWHERE, ROTATING, Tables, Width};

/// A simulated SRP that interprets the tables.
#[derive(Clone, Debug)]
pub struct Interpreter {
    sequencer: Sequencer,
    tables: Tables,
    positions: Vec<String>,
    first_address: u32,
}

impl Interpreter {
    /// A core at the start of its program, all registers zero.
    pub fn new(spec: &SimSpec) -> Interpreter {
        Interpreter {
            sequencer: Sequencer::new(spec.start, spec.branch_delay, spec.max_latency),
            tables: Tables::of(spec),
            positions: spec.positions.clone(),
            first_address: spec.first_address,
        }
    }
}

impl Core for Interpreter {
    fn run(&mut self, bus: &mut dyn Bus, budget: u64) -> Result<Run, Trap> {
        let mut border = Border::new(bus, self.first_address);
        self.sequencer
            .run(&mut self.tables, &mut border, budget)
            .map_err(|fault| trap(fault.kind, fault.at, &self.positions))
    }
}

/// A trap with its place in words.
pub(crate) fn trap(kind: TrapKind, at: u32, positions: &[String]) -> Trap {
    let at = positions.get(at as usize);
    Trap {
        kind,
        at: at.filter(|text| !text.is_empty()).cloned(),
    }
}

impl<'b> Datapath<dyn Bus + 'b> for Tables {
    fn bundle(
        &mut self,
        number: u32,
        issue: &mut Issue,
        bus: &mut Border<'_, dyn Bus + 'b>,
    ) -> Result<(), Stop> {
        let Some(bundle) = self.bundles.get(number as usize) else {
            return Err(Fault::unreachable(0).into());
        };
        let (mut steps, control) = (bundle.steps.clone(), bundle.control);
        if bundle.talks {
            issue.meet_bus()?;
            self.talk(steps.start, issue, bus)?;
            steps.start += 1;
        }
        if let Some((control, at)) = control {
            self.transfer(control, at, issue)?;
        }
        for step in steps {
            let micro = self.micros[step as usize];
            let value = self.carry_out(&micro, bus)?;
            match (micro.latency, micro.width) {
                (0, _) => self.put(&micro, value),
                (latency, Width::Narrow) => issue.land(latency, micro.dest, value.as_word()),
                (latency, Width::Wide) => issue.land_vec(latency, micro.dest, value),
            }
        }
        Ok(())
    }

    fn write(&mut self, register: u32, value: u32) {
        self.cells[register as usize].0[0] = value;
    }

    fn write_vec(&mut self, register: u32, value: V4) {
        self.cells[register as usize] = value;
    }

    fn kernel(&self, kernel: u32) -> KernelTimes {
        self.kernels[kernel as usize].times
    }

    fn enter(&mut self, kernel: u32) -> u32 {
        for (advanced, _) in &mut self.rotations {
            *advanced = 0;
        }
        let table = &self.kernels[kernel as usize];
        let trip = self.cells[table.trip as usize].as_word();
        for &(dest, source, width) in &table.preloads {
            let value = self.cells[source as usize];
            set(&mut self.cells[dest as usize], value, width);
        }
        trip
    }

    fn context(
        &mut self,
        kernel: u32,
        context: u32,
        stages: u64,
        bus: &mut Border<'_, dyn Bus + 'b>,
    ) -> Result<(), Fault> {
        for step in self.kernels[kernel as usize].contexts[context as usize].clone() {
            let micro = self.micros[step as usize];
            if micro.stage & stages != 0 {
                let value = self.carry_out(&micro, bus)?;
                self.put(&micro, value);
            }
        }
        Ok(())
    }

    fn rotate(&mut self, _kernel: u32) {
        for (advanced, size) in &mut self.rotations {
            *advanced += 1;
            if advanced == size {
                *advanced = 0;
            }
        }
    }
}

impl Tables {
    /// The index of a cell now.
    #[inline(always)]
    fn locate(&self, index: Index) -> usize {
        if index & ROTATING == 0 {
            return index as usize;
        }
        let rotated = self.rotating[(index & !ROTATING) as usize];
        let (advanced, size) = self.rotations[rotated.file as usize];
        let number = rotated.index + advanced;
        let number = if number < size { number } else { number - size };
        (rotated.base + number) as usize
    }

    #[inline(always)]
    fn get(&self, index: Index) -> V4 {
        self.cells[self.locate(index)]
    }

    /// Writes the result of a step at once.
    #[inline(always)]
    fn put(&mut self, micro: &Micro, value: V4) {
        if micro.dest == NOWHERE {
            return;
        }
        let first = self.locate(micro.dest);
        set(&mut self.cells[first], value, micro.width);
        for i in micro.more.0..micro.more.1 {
            let next = self.locate(self.dests[i as usize]);
            set(&mut self.cells[next], value, micro.width);
        }
    }

    /// Does all of a step but writing its result, which is zero where there is none.
    #[inline(always)]
    fn carry_out<'b>(
        &self,
        micro: &Micro,
        bus: &mut Border<'_, dyn Bus + 'b>,
    ) -> Result<V4, Fault> {
        let [a, b, c] = micro.operands;
        match micro.act {
            Act::Copy => Ok(self.get(a)),
            Act::CopyPred => Ok(V4::pred(self.get(a).as_pred())),
            Act::Compute(op) => {
                let args = [self.get(a), self.get(b), self.get(c)];
                let value = ops::eval(op, &args, micro.imm, &self.precision);
                divided(value.ok(), micro.at).map(Option::unwrap_or_default)
            }
            Act::Load(op) => {
                let (guard, address) = (self.get(a).as_pred(), self.get(b).as_word());
                load(op, guard, address, micro, bus)
            }
            Act::Store(op) => {
                let (guard, address) = (self.get(a).as_pred(), self.get(b).as_word());
                store(op, guard, address, self.get(c), micro, bus)
            }
            Act::In | Act::Out => Ok(V4::default()),
        }
    }

    /// Does a port operation.
    fn talk<'b>(
        &mut self,
        step: u32,
        issue: &mut Issue,
        bus: &mut Border<'_, dyn Bus + 'b>,
    ) -> Result<(), Stop> {
        let micro = self.micros[step as usize];
        let port = micro.imm as u32;
        if let Act::In = micro.act {
            issue.land(micro.latency, micro.dest, bus.port_in(port)?);
            return Ok(());
        }
        bus.port_out(port, self.get(micro.operands[0]).as_word())
    }

    fn transfer(&self, control: ControlAct, at: u32, issue: &mut Issue) -> Result<(), Fault> {
        match control {
            ControlAct::Jump(target) => issue.jump(target),
            ControlAct::Branch {
                cond,
                sense,
                target,
            } => {
                if self.get(cond).as_pred() == sense {
                    issue.jump(target);
                }
            }
            ControlAct::Call {
                target,
                link,
                back,
                latency,
            } => {
                issue.land(latency, link, back);
                issue.jump(target);
            }
            ControlAct::CallReg {
                target,
                link,
                back,
                latency,
            } => {
                let address = self.get(target).as_word();
                let target = callee(&self.functions, FUNC_BASE, address, at)?;
                issue.land(latency, link, back);
                issue.jump(target);
            }
            ControlAct::Return(cell) => issue.jump(self.get(cell).as_word()),
            ControlAct::Launch(kernel) => issue.launch(kernel),
            ControlAct::Halt(cell) => issue.halt(self.get(cell).as_word()),
            ControlAct::Unreachable => return Err(Fault::unreachable(at)),
            ControlAct::StackOverflow => return Err(Fault::stack_overflow(at)),
        }
        Ok(())
    }
}

#[inline(always)]
fn set(cell: &mut V4, value: V4, width: Width) {
    match width {
        Width::Narrow => cell.0[0] = value.0[0],
        Width::Wide => *cell = value,
    }
}

fn load(
    op: Opcode,
    guard: bool,
    address: u32,
    micro: &Micro,
    bus: &mut Border<'_, dyn Bus + '_>,
) -> Result<V4, Fault> {
    use Opcode::*;
    let (offset, at) = (micro.imm as u32, micro.at);
    let bytes = match op {
        Lb | Lbu => V4::word(bus.load::<1>(guard, address, offset, at)?),
        Lh | Lhu => V4::word(bus.load::<2>(guard, address, offset, at)?),
        Lw => V4::word(bus.load::<4>(guard, address, offset, at)?),
        Lv => bus.load_vec(guard, address, offset, at)?,
        Glb | Glbu => bus.cached_load::<1>(guard, address, offset, at)?,
        Glh | Glhu => bus.cached_load::<2>(guard, address, offset, at)?,
        Glw => bus.cached_load::<4>(guard, address, offset, at)?,
        _ => bus.cached_load::<16>(guard, address, offset, at)?,
    };
    Ok(ops::loaded(op, bytes))
}

fn store(
    op: Opcode,
    guard: bool,
    address: u32,
    value: V4,
    micro: &Micro,
    bus: &mut Border<'_, dyn Bus + '_>,
) -> Result<V4, Fault> {
    use Opcode::*;
    let (offset, at) = (micro.imm as u32, micro.at);
    let word = value.as_word();
    match op {
        Sb => bus.store::<1>(guard, address, word, offset, at)?,
        Sh => bus.store::<2>(guard, address, word, offset, at)?,
        Sw => bus.store::<4>(guard, address, word, offset, at)?,
        Sv => bus.store_vec(guard, address, value, offset, at)?,
        Gsb => bus.cached_store::<1>(guard, address, value, offset, at)?,
        Gsh => bus.cached_store::<2>(guard, address, value, offset, at)?,
        Gsw => bus.cached_store::<4>(guard, address, value, offset, at)?,
        _ => bus.cached_store::<16>(guard, address, value, offset, at)?,
    }
    Ok(V4::default())
}
