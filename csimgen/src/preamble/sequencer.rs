//! The order of events in an SRP: which bundle issues, when results of VLIW code land, and how the
//! mode changes between the VLIW engine and the array. A [`Datapath`] knows what a bundle or a context
//! *does*: the interpreter has one in tables, a generated simulator one in code.
//!
//! Rules, beside those of time in the scheduled program, which the checker has seen kept:
//! * While the core is stalled or waits for a port, time stands still for all of it: results in
//!   flight do not move.
//! * A bundle that talks to a port is the first of its run, so that the bus knows the time.
//! * A bundle's code is read, and a kernel's contexts are looked for, in the cycle in which the bundle issues: where they
//!   are not there, the core is stalled after it.
//! * A launch is a bundle like others; from the next cycle on, when nothing is in flight, the mode
//!   switch takes `enter_cycles`. Trip count and preloads are read at the end of the switch. A trip
//!   count of 0 stands for 2³².

use super::border::{Border, Fault, Stop};
use super::core_border::{Activity, Bus, Run, TrapKind};
use super::issue::{Issue, Landing, NextMode, TransferKind};
use super::ops::V4;
use super::saved::{Words, put_long};

/// Most open calls. No stack in SRAM has room for so many, but a schedule that was written by hand may call itself
/// without one.
pub const MAX_OPEN_CALLS: usize = 1 << 20;

/// The two engines' work, cycle by cycle.
pub trait Datapath<B: ?Sized> {
    /// Issues a bundle; on `Err` it has had no effect, or the simulation is over.
    fn bundle(
        &mut self,
        number: u32,
        issue: &mut Issue,
        bus: &mut Border<'_, B>,
    ) -> Result<(), Stop>;

    /// The operations of a bundle, its control transfer included.
    fn operations(&self, bundle: u32) -> u64;

    /// Writes a word, or a predicate as 0 or 1, into a register, by its number among all cells of
    /// state.
    fn write(&mut self, register: u32, value: u32);

    /// Writes a vector into a register.
    fn write_vec(&mut self, register: u32, value: V4);

    /// The times of a kernel.
    fn kernel(&self, kernel: u32) -> KernelTimes;

    /// Sets the registers of a kernel and gives its trip count; 0 stands for 2³².
    fn enter(&mut self, kernel: u32) -> u32;

    /// One cycle of a kernel; bit `s` of `stages` says whether stage `s` has an iteration.
    fn context(
        &mut self,
        kernel: u32,
        context: u32,
        stages: u64,
        bus: &mut Border<'_, B>,
    ) -> Result<(), Box<Fault>>;

    /// Advances the rotating files: an iteration begins.
    fn rotate(&mut self, kernel: u32);

    /// The core goes on in a kernel whose iteration of this number has begun last.
    fn resume(&mut self, kernel: u32, iteration: u64);
}

/// The entry of the function at `address`: `functions` are the entries, their addresses begin at
/// `base` and are 4 apart.
pub fn callee(functions: &[u32], base: u32, address: u32, at: u32) -> Result<u32, Fault> {
    let offset = address.wrapping_sub(base);
    match functions.get(offset as usize / 4) {
        Some(&entry) if offset.is_multiple_of(4) => Ok(entry),
        _ => Err(Fault {
            kind: TrapKind::BadCall(address),
            at,
        }),
    }
}

/// The times of a kernel, in cycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KernelTimes {
    /// Initiation interval.
    pub ii: u32,
    /// Number of contexts: a multiple of `ii`.
    pub contexts: u32,
    /// From the start of an iteration until all its results have landed.
    pub length: u32,
    /// Mode switch to the array, setting of registers included.
    pub enter_cycles: u32,
    /// Mode switch back.
    pub leave_cycles: u32,
    /// Operations of an iteration.
    pub operations: u32,
}

/// Where a core goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// It issues a bundle.
    Bundle(u32),
    /// It does a context of a kernel.
    Context {
        /// The kernel.
        kernel: u32,
        /// Cycles since an iteration has begun.
        slot: u32,
        /// The iteration that begins, or has begun last.
        iteration: u64,
        /// Bit `s`: whether stage `s` has an iteration.
        stages: u64,
    },
    /// It changes between the VLIW engine and the array.
    Switch,
    /// It has ended with this status.
    Halted(i32),
    /// It traps at this position.
    Faulted(u32),
}

#[derive(Clone, Copy, Debug)]
enum Mode {
    Vliw,
    Enter {
        kernel: u32,
        left: u64,
    },
    Array(Array),
    Leave {
        left: u64,
    },
    Halted(i32),
    /// The next cycle is one that cannot be.
    Faulted(Fault),
}

#[derive(Clone, Copy, Debug)]
struct Array {
    kernel: u32,
    times: KernelTimes,
    /// Cycles to go.
    left: u64,
    /// Iterations yet to begin.
    to_begin: u64,
    /// Bit `s`: whether stage `s` has an iteration.
    stages: u64,
    /// Cycles since the last iteration began.
    slot: u32,
    context: u32,
    /// The number of that iteration.
    iteration: u64,
}

/// The state of the program's course.
#[derive(Clone, Debug)]
pub struct Sequencer {
    pc: u32,
    mode: Mode,
    issue: Issue,
    /// The places of the open calls, outermost first.
    calls: Vec<u32>,
}

impl Sequencer {
    /// A core about to issue bundle `start`.
    pub fn new(start: u32, branch_delay: u32, max_latency: u32) -> Sequencer {
        Sequencer {
            pc: start,
            mode: Mode::Vliw,
            issue: Issue::new(branch_delay, max_latency),
            calls: Vec::new(),
        }
    }

    /// The places of the open calls, innermost first.
    pub fn open_calls(&self) -> impl Iterator<Item = u32> + '_ {
        self.calls.iter().rev().copied()
    }

    /// The kernel on the array and the iteration that has begun last there, or the kernel whose first cycle on the
    /// array comes next: iteration 0.
    pub fn on_array(&self) -> Option<(u32, u64)> {
        match self.mode {
            Mode::Enter { kernel, left: 0 } => Some((kernel, 0)),
            Mode::Array(array) if array.left > 0 => Some((array.kernel, array.iteration)),
            _ => None,
        }
    }

    /// On the array, the cycles since an iteration began there and the iterations that are yet to begin; else zeros.
    pub fn turn_on_array(&self) -> (u32, u64) {
        match self.mode {
            Mode::Array(array) => (array.slot, array.to_begin),
            _ => (0, 0),
        }
    }

    /// Where the core goes on.
    pub fn place(&self) -> Place {
        match self.mode {
            Mode::Vliw | Mode::Leave { left: 0 } => Place::Bundle(self.pc),
            Mode::Enter { kernel, left: 0 } => Place::Context {
                kernel,
                slot: 0,
                iteration: 0,
                stages: 1,
            },
            Mode::Array(array) if array.left > 0 => Place::Context {
                kernel: array.kernel,
                slot: array.slot,
                iteration: array.iteration,
                stages: match array.slot {
                    0 => array.stages << 1 | u64::from(array.to_begin > 0),
                    _ => array.stages,
                },
            },
            Mode::Array(array) if array.times.leave_cycles == 0 => Place::Bundle(self.pc),
            Mode::Enter { .. } | Mode::Array(_) | Mode::Leave { .. } => Place::Switch,
            Mode::Halted(status) => Place::Halted(status),
            Mode::Faulted(fault) => Place::Faulted(fault.at),
        }
    }

    /// Runs at most `budget` cycles of one kind; see [`Core::run`](super::core_border::Core::run).
    pub fn run<B: Bus + ?Sized>(
        &mut self,
        path: &mut impl Datapath<B>,
        bus: &mut Border<'_, B>,
        budget: u64,
    ) -> Result<Run, Fault> {
        let budget = budget.max(1);
        loop {
            self.mode = match self.mode {
                Mode::Halted(status) => return Ok(run(0, Activity::Halted(status), 0)),
                Mode::Faulted(fault) => return Err(fault),
                Mode::Vliw => return self.run_vliw(path, bus, budget),
                Mode::Array(array) if array.left > 0 => {
                    return self.run_array(array, path, bus, budget);
                }
                Mode::Enter { kernel, left: 0 } => self.start(path, kernel),
                Mode::Array(array) => Mode::Leave {
                    left: u64::from(array.times.leave_cycles),
                },
                Mode::Leave { left: 0 } => Mode::Vliw,
                Mode::Enter { kernel, left } => {
                    let cycles = left.min(budget);
                    let left = left - cycles;
                    self.mode = Mode::Enter { kernel, left };
                    return Ok(run(cycles, Activity::Switch, 0));
                }
                Mode::Leave { left } => {
                    let cycles = left.min(budget);
                    let left = left - cycles;
                    self.mode = Mode::Leave { left };
                    return Ok(run(cycles, Activity::Switch, 0));
                }
            };
        }
    }

    fn run_vliw<B: Bus + ?Sized>(
        &mut self,
        path: &mut impl Datapath<B>,
        bus: &mut Border<'_, B>,
        budget: u64,
    ) -> Result<Run, Fault> {
        let (mut cycles, mut operations) = (0, 0);
        let mut fetched = 0..0;
        self.issue.begin_run();
        while cycles < budget {
            match path.bundle(self.pc, &mut self.issue, bus) {
                Ok(()) => operations += path.operations(self.pc),
                Err(Stop::Fault(fault)) if cycles == 0 => return Err(fault),
                Err(Stop::Fault(fault)) => {
                    // The cycles before it count.
                    self.mode = Mode::Faulted(fault);
                    break;
                }
                Err(Stop::Wait(port)) => return Ok(run(1, Activity::Wait(port), 0)),
                Err(Stop::Behind) => break,
            }
            if !fetched.contains(&self.pc) {
                fetched = bus.fetch(self.pc);
            }
            self.issue.land_due(|register, value| match value {
                Landing::Word(value) => path.write(register, value),
                Landing::Vec(value) => path.write_vec(register, value),
            });
            let mut is_over = false;
            self.pc = match self.issue.next_transfer() {
                None => self.pc.wrapping_add(1),
                Some(transfer) => {
                    match transfer.kind {
                        TransferKind::Jump => {}
                        TransferKind::Call { at } if self.calls.len() == MAX_OPEN_CALLS => {
                            self.mode = Mode::Faulted(Fault::stack_overflow(at));
                            is_over = true;
                        }
                        TransferKind::Call { at } => self.calls.push(at),
                        TransferKind::Return => {
                            self.calls.pop();
                        }
                    }
                    transfer.target
                }
            };
            self.issue.end_cycle();
            cycles += 1;
            let stalled = bus.cycle_stalled();
            if let Some(next) = self.issue.take_mode() {
                self.mode = match next {
                    NextMode::Halt(status) => Mode::Halted(status),
                    NextMode::Launch(kernel) => {
                        bus.launch(kernel);
                        Mode::Enter {
                            kernel,
                            left: u64::from(path.kernel(kernel).enter_cycles),
                        }
                    }
                };
                break;
            }
            if stalled || is_over {
                break;
            }
        }
        Ok(run(cycles, Activity::Vliw, operations))
    }

    fn start<B: ?Sized>(&mut self, path: &mut impl Datapath<B>, kernel: u32) -> Mode {
        let times = path.kernel(kernel);
        let trip = match path.enter(kernel) {
            0 => 1 << 32,
            trip => u64::from(trip),
        };
        let left = u64::from(times.ii) * (trip - 1) + u64::from(times.length);
        Mode::Array(Array {
            kernel,
            times,
            left,
            to_begin: trip,
            stages: 0,
            slot: 0,
            context: 0,
            iteration: 0,
        })
    }

    fn run_array<B: Bus + ?Sized>(
        &mut self,
        mut array: Array,
        path: &mut impl Datapath<B>,
        bus: &mut Border<'_, B>,
        budget: u64,
    ) -> Result<Run, Fault> {
        let mut cycles = 0;
        let to_begin = array.to_begin;
        let on_array = |cycles, array: &Array| {
            let begun = to_begin - array.to_begin;
            let operations = begun * u64::from(array.times.operations);
            run(cycles, Activity::Array(array.kernel), operations)
        };
        let limit = budget.min(array.left);
        while cycles < limit {
            if array.slot == 0 {
                array.stages = array.stages << 1 | u64::from(array.to_begin > 0);
                array.to_begin = array.to_begin.saturating_sub(1);
            }
            match path.context(array.kernel, array.context, array.stages, bus) {
                Ok(()) => {}
                Err(fault) if cycles == 0 => return Err(*fault),
                Err(fault) => {
                    // The cycles before it count.
                    self.mode = Mode::Faulted(*fault);
                    return Ok(on_array(cycles, &array));
                }
            }
            cycles += 1;
            array.context += 1;
            array.slot += 1;
            if array.slot == array.times.ii {
                array.slot = 0;
                array.iteration += 1;
                path.rotate(array.kernel);
                if array.context == array.times.contexts {
                    array.context = 0;
                }
            }
            if bus.cycle_stalled() {
                break;
            }
        }
        array.left -= cycles;
        self.mode = Mode::Array(array);
        Ok(on_array(cycles, &array))
    }
}

/// The words of a mode's kind.
const VLIW: u32 = 0;
const ENTER: u32 = 1;
const ARRAY: u32 = 2;
const LEAVE: u32 = 3;
const HALTED: u32 = 4;

impl Sequencer {
    /// Appends the course, as it is between two runs; `false` where it has ended with a fault.
    pub fn save(&self, out: &mut Vec<u32>) -> bool {
        out.push(self.pc);
        match self.mode {
            Mode::Vliw => out.push(VLIW),
            Mode::Enter { kernel, left } => {
                out.extend([ENTER, kernel]);
                put_long(out, left);
            }
            Mode::Array(array) => {
                out.extend([ARRAY, array.kernel, array.slot]);
                for long in [array.left, array.to_begin, array.stages, array.iteration] {
                    put_long(out, long);
                }
            }
            Mode::Leave { left } => {
                out.push(LEAVE);
                put_long(out, left);
            }
            Mode::Halted(status) => out.extend([HALTED, status as u32]),
            Mode::Faulted(_) => return false,
        }
        self.issue.save(out);
        out.push(self.calls.len() as u32);
        out.extend(&self.calls);
        true
    }

    /// Takes a course that [`save`](Self::save) has appended; `None` where the words mean nothing.
    pub fn restore<B: ?Sized>(
        &mut self,
        path: &mut impl Datapath<B>,
        kernels: u32,
        words: &mut Words<'_>,
    ) -> Option<()> {
        let kernel = |words: &mut Words<'_>| words.next_word().filter(|&kernel| kernel < kernels);
        self.pc = words.next_word()?;
        self.mode = match words.next_word()? {
            VLIW => Mode::Vliw,
            ENTER => Mode::Enter {
                kernel: kernel(words)?,
                left: words.next_long()?,
            },
            ARRAY => {
                let kernel = kernel(words)?;
                let times = path.kernel(kernel);
                let slot = words.next_word().filter(|&slot| slot < times.ii)?;
                let (left, to_begin) = (words.next_long()?, words.next_long()?);
                let (stages, iteration) = (words.next_long()?, words.next_long()?);
                path.resume(kernel, iteration);
                let repetitions = u64::from(times.contexts / times.ii);
                Mode::Array(Array {
                    kernel,
                    times,
                    left,
                    to_begin,
                    stages,
                    slot,
                    context: (iteration % repetitions) as u32 * times.ii + slot,
                    iteration,
                })
            }
            LEAVE => Mode::Leave {
                left: words.next_long()?,
            },
            HALTED => Mode::Halted(words.next_word()? as i32),
            _ => return None,
        };
        self.issue.restore(words)?;
        let calls = words.next_word()?;
        (calls as usize <= MAX_OPEN_CALLS).then_some(())?;
        self.calls.clear();
        for _ in 0..calls {
            self.calls.push(words.next_word()?);
        }
        Some(())
    }
}

fn run(cycles: u64, activity: Activity, operations: u64) -> Run {
    Run {
        cycles,
        activity,
        operations,
    }
}
