//! What is debugged: a program by itself, or a frame on all cores of a system.

use crate::watched::Shared;
use srp_csimgen::SimSpec;
use srp_runtime::core::{Activity, Core, CoreState};
use srp_runtime::memory::BASE;
use srp_runtime::solo::Solo;
use srp_runtime::system::{System, SystemSnapshot};

/// Cores and what is round them.
pub(crate) enum Machine<'a> {
    Program(Box<Program>),
    Frame(Box<System<'a>>),
}

/// A program by itself.
pub(crate) struct Program {
    core: Shared,
    bus: Solo,
    cycle: u64,
    status: Option<i32>,
}

/// All of it at an instant.
pub(crate) enum State {
    Program {
        core: CoreState,
        bus: Solo,
        cycle: u64,
        status: Option<i32>,
    },
    /// And the bytes of the memory, which it may share with others.
    Frame(Box<SystemSnapshot>, usize),
}

impl State {
    /// About how many bytes it takes.
    pub(crate) fn bytes(&self) -> usize {
        match self {
            State::Program { bus, .. } => bus.sram.len() + bus.output.len(),
            State::Frame(snapshot, memory) => snapshot.bytes() + memory,
        }
    }
}

/// Why it went no further.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// The program ended with this status.
    Over(i32),
    /// It cannot go on.
    Failed(String),
}

impl<'a> Machine<'a> {
    pub(crate) fn program(core: Shared, spec: &SimSpec) -> Machine<'a> {
        Machine::Program(Box::new(Program {
            core,
            bus: Solo::new(&spec.image, spec.sram_bytes),
            cycle: 0,
            status: None,
        }))
    }

    /// The cycle that comes next.
    pub(crate) fn cycle(&self) -> u64 {
        match self {
            Machine::Program(program) => program.cycle,
            Machine::Frame(system) => system.cycle(),
        }
    }

    /// Advances to the next instant.
    pub(crate) fn advance(&mut self) -> Result<(), End> {
        match self {
            Machine::Program(program) => program.advance(),
            Machine::Frame(system) if system.is_over() => Err(End::Over(0)),
            Machine::Frame(system) => {
                let advanced = system.advance();
                advanced.map_err(|error| End::Failed(error.to_string()))
            }
        }
    }

    pub(crate) fn save(&self, last: Option<&State>) -> Option<State> {
        match self {
            Machine::Program(program) => Some(State::Program {
                core: program.core.save()?,
                bus: program.bus.clone(),
                cycle: program.cycle,
                status: program.status,
            }),
            Machine::Frame(system) => {
                let last = match last {
                    Some(State::Frame(snapshot, _)) => Some(&**snapshot),
                    _ => None,
                };
                let snapshot = system.snapshot(last)?;
                let memory = system.memory().bytes().len();
                Some(State::Frame(Box::new(snapshot), memory))
            }
        }
    }

    /// Goes to a state of the same machine.
    pub(crate) fn restore(&mut self, from: &State) -> bool {
        match (self, from) {
            (
                Machine::Program(program),
                State::Program {
                    core,
                    bus,
                    cycle,
                    status,
                },
            ) => {
                program.bus.clone_from(bus);
                (program.cycle, program.status) = (*cycle, *status);
                program.core.restore(core)
            }
            (Machine::Frame(system), State::Frame(snapshot, _)) => system.restore(snapshot),
            _ => false,
        }
    }

    /// Bytes of a core's SRAM, or of the memory that all share, as many as there are.
    pub(crate) fn read(&self, core: u32, address: u32, bytes: u32) -> &[u8] {
        let within = |memory: &'_ [u8], from: u32| {
            let start = (address.checked_sub(from)? as usize).min(memory.len());
            let end = start.saturating_add(bytes as usize).min(memory.len());
            Some(start..end)
        };
        let (sram, memory) = match self {
            Machine::Program(program) => (&program.bus.sram[..], &program.bus.memory[..]),
            Machine::Frame(system) => {
                let sram = system.sram(core).unwrap_or_default();
                (sram, system.memory().bytes())
            }
        };
        match within(memory, BASE) {
            Some(range) => &memory[range],
            None => within(sram, 0).map_or(&[], |range| &sram[range]),
        }
    }

    /// The text that the programs of all cores have printed.
    pub(crate) fn output(&self, core: u32) -> &[u8] {
        match self {
            Machine::Program(program) => &program.bus.output,
            Machine::Frame(system) => system.output(core),
        }
    }

    /// Who waits for what, of a frame.
    pub(crate) fn waits(&self) -> Option<String> {
        match self {
            Machine::Program(_) => None,
            Machine::Frame(system) => Some(system.waits()),
        }
    }
}

impl Program {
    fn advance(&mut self) -> Result<(), End> {
        if let Some(status) = self.status {
            return Err(End::Over(status));
        }
        if self.bus.stand_still() {
            self.cycle += 1;
            return Ok(());
        }
        let run = self.core.run(&mut self.bus, 1);
        let run = run.map_err(|trap| End::Failed(trap.to_string()))?;
        self.cycle += run.cycles;
        match run.activity {
            Activity::Halted(status) => self.status = Some(status),
            Activity::Wait(port) => {
                let why = format!("the program waits for port {port}, where nothing is connected");
                return Err(End::Failed(why));
            }
            _ => self.status = self.bus.exit,
        }
        match self.status {
            Some(status) => Err(End::Over(status)),
            None => Ok(()),
        }
    }
}
