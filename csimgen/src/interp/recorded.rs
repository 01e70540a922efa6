//! The interpreter that tells what every cycle does: the same cycles, and the value of every step.

use super::state::Index;
use super::tables::Tables;
use super::{Interpreter, Listener, trap};
use crate::preamble::border::{Border, Fault, Stop};
use crate::preamble::issue::Issue;
use crate::preamble::ops::V4;
use crate::preamble::sequencer::{Datapath, KernelTimes, Place};
use crate::spec::SimSpec;
use srp_runtime::core::{Bus, Core, CoreState, Run, Trap};

/// What a core does, in its order. With the [`Snapshot`] of the state before, it says all that the program and the
/// machine do not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Record {
    /// A cycle issues this bundle. The values of its steps follow, of all of them in their order.
    Bundle(u32),
    /// A cycle does this context of a kernel. The values of its steps follow, in their order, of those whose stage
    /// has an iteration.
    Context {
        /// The kernel.
        kernel: u32,
        /// The context, of as many as the kernel has before its rings are back at their first registers.
        context: u32,
        /// Bit `s`: whether stage `s` has an iteration.
        stages: u64,
    },
    /// The value that a step makes; it means nothing of a step without a result, but for a port operation that gives
    /// it.
    Value(V4),
    /// A result of VLIW code lands at the end of the cycle: a word or predicate.
    Word(u32, u32),
    /// The same of a vector.
    Vector(u32, V4),
    /// The registers of a kernel are set: its first cycle comes next.
    Entered(u32),
    /// The rotating files of a kernel advance at the end of the cycle: an iteration begins.
    Rotated(u32),
}

/// The registers of a core between two runs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Snapshot {
    /// All cells, those of rotating files in their physical order.
    pub cells: Vec<V4>,
    /// How far the rotating files have advanced, in the order of their stores.
    pub advanced: Vec<u32>,
    /// The kernel on the array, and the iteration that has begun last.
    pub on_array: Option<(u32, u64)>,
}

/// An interpreter that records.
#[derive(Clone)]
pub struct Recorder {
    interpreter: Interpreter,
}

impl Recorder {
    /// A core at the start of its program, all registers zero.
    pub fn new(spec: &SimSpec) -> Recorder {
        Recorder {
            interpreter: Interpreter::new(spec),
        }
    }

    /// Runs as [`Core::run`] does; `tape` gets what every cycle does.
    ///
    /// # Errors
    ///
    /// The trap that ends the program.
    pub fn run(
        &mut self,
        bus: &mut dyn Bus,
        budget: u64,
        tape: &mut Vec<Record>,
    ) -> Result<Run, Trap> {
        let interpreter = &mut self.interpreter;
        let mut border = Border::new(bus, interpreter.first_address, interpreter.banks);
        let mut path = Recorded {
            tables: &mut interpreter.tables,
            tape: Tape(tape),
        };
        let result = interpreter.sequencer.run(&mut path, &mut border, budget);
        result.map_err(|fault| {
            let calls = interpreter.sequencer.open_calls();
            trap(fault.kind, fault.at, calls, &interpreter.positions)
        })
    }

    /// The registers.
    pub fn snapshot(&self) -> Snapshot {
        let state = &self.interpreter.tables.state;
        let mut cells = state.cells[..state.result as usize].to_vec();
        for file in &state.rotating {
            cells[file.cells.clone()].rotate_right(file.advanced);
        }
        Snapshot {
            cells,
            advanced: (state.rotating.iter())
                .map(|file| file.advanced as u32)
                .collect(),
            on_array: self.interpreter.sequencer.on_array(),
        }
    }

    /// The kernel that is on the array in the next cycle.
    pub fn next_kernel(&self) -> Option<u32> {
        let on_array = self.interpreter.sequencer.on_array();
        on_array.map(|(kernel, _)| kernel)
    }

    /// Where it goes on.
    pub fn place(&self) -> Place {
        self.interpreter.sequencer.place()
    }

    /// The positions of the open calls, innermost first.
    pub fn open_calls(&self) -> impl Iterator<Item = u32> + '_ {
        self.interpreter.sequencer.open_calls()
    }

    /// All of its state, as [`Core::save`].
    pub fn save(&self) -> Option<CoreState> {
        self.interpreter.save()
    }

    /// Goes on from a state, as [`Core::restore`].
    pub fn restore(&mut self, state: &CoreState) -> bool {
        self.interpreter.restore(state)
    }
}

/// The records of a run.
struct Tape<'a>(&'a mut Vec<Record>);

impl Listener for Tape<'_> {
    fn made(&mut self, cells: &[V4], cell: Index) {
        self.0.push(Record::Value(cells[cell as usize]));
    }

    fn talked(&mut self, value: u32) {
        self.0.push(Record::Value(V4([value, 0, 0, 0])));
    }
}

/// The tables, with a tape.
struct Recorded<'a> {
    tables: &'a mut Tables,
    tape: Tape<'a>,
}

/// The tables' own work, which is the same for every bus.
type Own<'b> = dyn Bus + 'b;

impl<'b> Datapath<Own<'b>> for Recorded<'_> {
    fn bundle(
        &mut self,
        number: u32,
        issue: &mut Issue,
        bus: &mut Border<'_, Own<'b>>,
    ) -> Result<(), Stop> {
        let before = self.tape.0.len();
        self.tape.0.push(Record::Bundle(number));
        let result = self.tables.issue(number, issue, bus, &mut self.tape);
        if result.is_err() {
            self.tape.0.truncate(before);
        }
        result
    }

    fn operations(&self, bundle: u32) -> u64 {
        Datapath::<Own<'b>>::operations(self.tables, bundle)
    }

    fn write(&mut self, register: u32, value: u32) {
        self.tape.0.push(Record::Word(register, value));
        Datapath::<Own<'b>>::write(self.tables, register, value);
    }

    fn write_vec(&mut self, register: u32, value: V4) {
        self.tape.0.push(Record::Vector(register, value));
        Datapath::<Own<'b>>::write_vec(self.tables, register, value);
    }

    fn kernel(&self, kernel: u32) -> KernelTimes {
        Datapath::<Own<'b>>::kernel(self.tables, kernel)
    }

    fn enter(&mut self, kernel: u32) -> u32 {
        self.tape.0.push(Record::Entered(kernel));
        Datapath::<Own<'b>>::enter(self.tables, kernel)
    }

    fn context(
        &mut self,
        kernel: u32,
        context: u32,
        stages: u64,
        bus: &mut Border<'_, Own<'b>>,
    ) -> Result<(), Box<Fault>> {
        let before = self.tape.0.len();
        self.tape.0.push(Record::Context {
            kernel,
            context,
            stages,
        });
        let tape = &mut self.tape;
        let result = (self.tables).carry_out(kernel, context, stages, bus, tape);
        if result.is_err() {
            self.tape.0.truncate(before);
        }
        result
    }

    fn rotate(&mut self, kernel: u32) {
        self.tape.0.push(Record::Rotated(kernel));
        Datapath::<Own<'b>>::rotate(self.tables, kernel);
    }

    fn resume(&mut self, kernel: u32, iteration: u64) {
        Datapath::<Own<'b>>::resume(self.tables, kernel, iteration);
    }
}
