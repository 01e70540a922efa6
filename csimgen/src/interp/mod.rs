//! The table interpreter: the engine that needs no compiler, and the one that generated simulators
//! are compared with.
//!
//! All state lies in one vector of cells, constants behind it, so that an operand is an index. What
//! a cycle does is a stretch of one vector of operations. Nothing is looked up by name or allocated
//! while it runs.

mod counted;
mod recorded;
mod runners;
mod state;
mod tables;

pub use counted::{Counting, Counts, KernelCounts, SharedCounts, Turn};
pub use recorded::{Record, Recorder, Snapshot};

use crate::preamble::border::{Banks, Border, Fault, Stop};
use crate::preamble::issue::Issue;
use crate::preamble::ops::V4;
use crate::preamble::saved::{Saved, Words};
use crate::preamble::sequencer::{Datapath, KernelTimes, Sequencer, callee};
use crate::spec::SimSpec;
use srp_archdesc::isa::Ty;
use srp_ir::dre::scheduled::FUNC_BASE;
use srp_runtime::core::{Bus, Core, CoreState, MAX_TOLD_CALLS, Run, Trap, TrapKind};
use state::{Index, State};
use tables::{ControlAct, Issued, Tables, Talk};

/// A simulated SRP that interprets the tables.
#[derive(Clone)]
pub struct Interpreter {
    sequencer: Sequencer,
    tables: Tables,
    positions: Vec<String>,
    first_address: u32,
    banks: Banks,
}

impl Interpreter {
    /// A core at the start of its program, all registers zero.
    pub fn new(spec: &SimSpec) -> Interpreter {
        Interpreter {
            sequencer: Sequencer::new(spec.start, spec.branch_delay, spec.max_latency),
            tables: Tables::of(spec),
            positions: spec.positions.clone(),
            first_address: spec.first_address,
            banks: spec.banks,
        }
    }
}

impl std::fmt::Debug for Interpreter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Interpreter")
            .field("sequencer", &self.sequencer)
            .finish_non_exhaustive()
    }
}

impl Core for Interpreter {
    fn run(&mut self, bus: &mut dyn Bus, budget: u64) -> Result<Run, Trap> {
        let mut border = Border::new(bus, self.first_address, self.banks);
        let result = self.sequencer.run(&mut self.tables, &mut border, budget);
        result.map_err(|fault| {
            let calls = self.sequencer.open_calls();
            trap(fault.kind, fault.at, calls, &self.positions)
        })
    }

    fn save(&self) -> Option<CoreState> {
        let mut words = Vec::new();
        self.tables.save(&mut words);
        self.sequencer
            .save(&mut words)
            .then_some(CoreState { words })
    }

    fn restore(&mut self, state: &CoreState) -> bool {
        let mut words = Words::of(&state.words);
        let Interpreter {
            sequencer, tables, ..
        } = self;
        let restored = tables.restore(&mut words).and_then(|()| {
            let kernels = tables.kernels.len() as u32;
            sequencer.restore::<dyn Bus>(tables, kernels, &mut words)
        });
        restored.is_some() && words.is_empty()
    }
}

/// A trap with its place and those of the open calls in words.
pub(crate) fn trap(
    kind: TrapKind,
    at: u32,
    calls: impl Iterator<Item = u32>,
    positions: &[String],
) -> Trap {
    let place = |at: u32| {
        let text = positions.get(at as usize);
        text.filter(|text| !text.is_empty()).cloned()
    };
    Trap {
        kind,
        at: place(at),
        calls: calls.take(MAX_TOLD_CALLS).filter_map(place).collect(),
    }
}

/// Hears of the values that steps make. `()` hears nothing, and costs nothing.
trait Listener {
    /// The step that comes next in its cycle has made the value in this cell, if it makes one.
    fn made(&mut self, cells: &[V4], cell: Index);

    /// The same for a port operation.
    fn talked(&mut self, value: u32);
}

impl Listener for () {
    #[inline(always)]
    fn made(&mut self, _: &[V4], _: Index) {}

    #[inline(always)]
    fn talked(&mut self, _: u32) {}
}

impl Tables {
    /// Issues a bundle, of whose steps `listener` hears.
    #[inline(always)]
    fn issue<'b>(
        &mut self,
        number: u32,
        issue: &mut Issue,
        bus: &mut Border<'_, dyn Bus + 'b>,
        listener: &mut impl Listener,
    ) -> Result<(), Stop> {
        let Some(bundle) = self.bundles.get(number as usize) else {
            return Err(Fault::unreachable(0).into());
        };
        if let Some(talk) = bundle.talk {
            issue.meet_bus()?;
            listener.talked(self.state.talk(talk, issue, bus)?);
        }
        if let Some((control, at)) = bundle.control {
            self.transfer(control, at, issue)?;
        }
        let steps = bundle.steps.start as usize..bundle.steps.end as usize;
        for Issued { micro, landing } in &self.issued[steps] {
            (micro.run)(&mut self.state, micro, bus).map_err(|fault| *fault)?;
            listener.made(&self.state.cells, micro.dests[0]);
            if let Some((latency, dest, wide)) = *landing {
                let value = self.state.cells[self.state.result as usize];
                if wide {
                    issue.land_vec(latency, dest, value);
                } else {
                    issue.land(latency, dest, value.as_word());
                }
            }
        }
        Ok(())
    }

    /// Carries out a context, of whose steps `listener` hears.
    #[inline(always)]
    fn carry_out<'b>(
        &mut self,
        kernel: u32,
        context: u32,
        stages: u64,
        bus: &mut Border<'_, dyn Bus + 'b>,
        listener: &mut impl Listener,
    ) -> Result<(), Box<Fault>> {
        for group in &self.kernels[kernel as usize].contexts[context as usize] {
            if group.stage & stages != 0 {
                let steps = group.steps.start as usize..group.steps.end as usize;
                for micro in &self.micros[steps] {
                    (micro.run)(&mut self.state, micro, bus)?;
                    listener.made(&self.state.cells, micro.dests[0]);
                }
            }
        }
        Ok(())
    }
}

impl<'b> Datapath<dyn Bus + 'b> for Tables {
    fn bundle(
        &mut self,
        number: u32,
        issue: &mut Issue,
        bus: &mut Border<'_, dyn Bus + 'b>,
    ) -> Result<(), Stop> {
        self.issue(number, issue, bus, &mut ())
    }

    fn operations(&self, bundle: u32) -> u64 {
        self.bundles[bundle as usize].operations
    }

    fn write(&mut self, register: u32, value: u32) {
        self.state.cells[register as usize].0[0] = value;
    }

    fn write_vec(&mut self, register: u32, value: V4) {
        self.state.cells[register as usize] = value;
    }

    fn kernel(&self, kernel: u32) -> KernelTimes {
        self.kernels[kernel as usize].times
    }

    fn enter(&mut self, kernel: u32) -> u32 {
        let State {
            cells, rotating, ..
        } = &mut self.state;
        for file in rotating {
            let advanced = std::mem::take(&mut file.advanced);
            cells[file.cells.clone()].rotate_right(advanced);
        }
        let table = &self.kernels[kernel as usize];
        let trip = cells[table.trip as usize].as_word();
        for &(dest, source, ty) in &table.preloads {
            let value = cells[source as usize];
            match ty {
                Ty::Pred | Ty::Word => cells[dest as usize].0[0] = value.0[0],
                Ty::Vec => cells[dest as usize] = value,
            }
        }
        trip
    }

    fn context(
        &mut self,
        kernel: u32,
        context: u32,
        stages: u64,
        bus: &mut Border<'_, dyn Bus + 'b>,
    ) -> Result<(), Box<Fault>> {
        self.carry_out(kernel, context, stages, bus, &mut ())
    }

    fn rotate(&mut self, kernel: u32) {
        let State {
            cells, rotating, ..
        } = &mut self.state;
        for &file in &self.kernels[kernel as usize].rotating {
            let file = &mut rotating[file as usize];
            cells[file.cells.clone()].rotate_left(1);
            file.advanced += 1;
            if file.advanced == file.cells.len() {
                file.advanced = 0;
            }
        }
    }

    fn resume(&mut self, _: u32, _: u64) {}
}

impl Tables {
    /// Appends the registers in the order of a generated simulator's, rotating files in their
    /// physical order.
    fn save(&self, out: &mut Vec<u32>) {
        let cells = &self.state.cells;
        for store in &self.saved {
            let cells = &cells[store.cells.clone()];
            let advanced = store
                .rotating
                .map_or(0, |r| self.state.rotating[r].advanced);
            if store.rotating.is_some() {
                out.push(advanced as u32);
            }
            let (last, first) = cells.split_at(cells.len() - advanced);
            for cell in first.iter().chain(last) {
                match store.ty {
                    Ty::Vec => cell.save(out),
                    Ty::Pred | Ty::Word => out.push(cell.0[0]),
                }
            }
        }
    }

    fn restore(&mut self, words: &mut Words<'_>) -> Option<()> {
        for store in &self.saved {
            let cells = &mut self.state.cells[store.cells.clone()];
            let mut advanced = 0;
            if let Some(rotating) = store.rotating {
                advanced = words.next_word()? as usize;
                self.state.rotating[rotating].advanced =
                    (advanced < cells.len()).then_some(advanced)?;
            }
            for cell in cells.iter_mut() {
                match store.ty {
                    Ty::Vec => cell.restore(words)?,
                    Ty::Pred | Ty::Word => cell.0 = [words.next_word()?, 0, 0, 0],
                }
            }
            cells.rotate_left(advanced);
        }
        Some(())
    }
}

impl State {
    /// Does a port operation. Returns the word.
    fn talk<'b>(
        &mut self,
        talk: Talk,
        issue: &mut Issue,
        bus: &mut Border<'_, dyn Bus + 'b>,
    ) -> Result<u32, Stop> {
        match talk {
            Talk::In {
                port,
                dest,
                latency,
            } => {
                let value = bus.port_in(port)?;
                issue.land(latency, dest, value);
                Ok(value)
            }
            Talk::Out { port, value } => {
                let value = self.cells[value as usize].as_word();
                bus.port_out(port, value)?;
                Ok(value)
            }
        }
    }
}

impl Tables {
    fn get(&self, cell: Index) -> V4 {
        self.state.cells[cell as usize]
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
                issue.call(target, at);
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
                issue.call(target, at);
            }
            ControlAct::Return(cell) => issue.give_back(self.get(cell).as_word()),
            ControlAct::Launch(kernel) => issue.launch(kernel),
            ControlAct::Halt(cell) => issue.halt(self.get(cell).as_word()),
            ControlAct::Unreachable => return Err(Fault::unreachable(at)),
            ControlAct::StackOverflow => return Err(Fault::stack_overflow(at)),
        }
        Ok(())
    }
}
