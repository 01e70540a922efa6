//! The interpreter with counters: the same cycles, and how often each bundle and context had its turn.
//!
//! A core goes into a system and does not come back, so its counts are shared with whoever wants them.

use super::tables::Tables;
use super::{Interpreter, trap};
use crate::preamble::border::{Border, Fault, Stop};
use crate::preamble::ops::V4;
use crate::preamble::sequencer::{Datapath, Issue, KernelTimes};
use crate::spec::{BundleSpec, KernelSpec, SimSpec};
use srp_runtime::core::{Activity, Bus, Core, CoreState, Run, Trap};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The part of a program that has its turn in a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Turn {
    /// A bundle of VLIW code.
    Bundle(u32),
    /// A context of a kernel, by its number below the II.
    Context {
        /// The kernel.
        kernel: u32,
        /// The cycle since an iteration began.
        slot: u32,
    },
}

/// How often the parts of a program had their turn on one core.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Cycles in which each bundle was issued.
    pub bundles: Vec<u64>,
    /// Of each kernel.
    pub kernels: Vec<KernelCounts>,
    /// The turn of the last cycle: of a wait, the bundle that waits.
    pub last: Option<Turn>,
}

/// How often a kernel and its contexts had their turn.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct KernelCounts {
    /// Cycles of each context.
    pub contexts: Vec<u64>,
    /// Cycles of the changes to the array and back.
    pub switch: u64,
    /// Launches that have begun on the array.
    pub launches: u64,
    /// Iterations that have begun.
    pub iterations: u64,
    /// The fewest iterations that a launch was for.
    pub fewest: u64,
    /// The most.
    pub most: u64,
}

impl Counts {
    fn of(spec: &SimSpec) -> Counts {
        let kernel = |kernel: &KernelSpec| KernelCounts {
            contexts: vec![0; kernel.contexts.len()],
            ..KernelCounts::default()
        };
        Counts {
            bundles: vec![0; spec.bundles.len()],
            kernels: spec.kernels.iter().map(kernel).collect(),
            ..Counts::default()
        }
    }
}

/// The counts of a core that runs elsewhere.
#[derive(Clone, Debug)]
pub struct SharedCounts(Arc<Mutex<Counts>>);

impl SharedCounts {
    /// The counts so far. While they are held, the core does not run.
    pub fn get(&self) -> MutexGuard<'_, Counts> {
        // A count is whole at any time.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// An interpreter that counts.
pub struct Counting {
    interpreter: Interpreter,
    counts: SharedCounts,
    /// The kernel that each bundle launches.
    launches: Vec<Option<u32>>,
}

impl Counting {
    /// A core at the start of its program, all registers and counts zero.
    pub fn new(spec: &SimSpec) -> Counting {
        Counting {
            interpreter: Interpreter::new(spec),
            counts: SharedCounts(Arc::new(Mutex::new(Counts::of(spec)))),
            launches: spec.bundles.iter().map(BundleSpec::launches).collect(),
        }
    }

    /// Its counts.
    pub fn counts(&self) -> SharedCounts {
        self.counts.clone()
    }
}

impl Core for Counting {
    fn run(&mut self, bus: &mut dyn Bus, budget: u64) -> Result<Run, Trap> {
        let Counting {
            interpreter,
            counts,
            launches,
        } = self;
        let mut counts = counts.get();
        let mut border = Border::new(bus, interpreter.first_address);
        let mut path = Counted {
            tables: &mut interpreter.tables,
            counts: &mut counts,
        };
        let result = interpreter.sequencer.run(&mut path, &mut border, budget);
        let run = result.map_err(|fault| {
            let calls = interpreter.sequencer.open_calls();
            trap(fault.kind, fault.at, calls, &interpreter.positions)
        })?;
        if run.activity == Activity::Switch {
            // To the array after the bundle that launches, and back after the kernel.
            let kernel = match counts.last {
                Some(Turn::Bundle(bundle)) => launches[bundle as usize],
                Some(Turn::Context { kernel, .. }) => Some(kernel),
                None => None,
            };
            if let Some(kernel) = kernel {
                counts.kernels[kernel as usize].switch += run.cycles;
            }
        }
        Ok(run)
    }

    fn save(&self) -> Option<CoreState> {
        self.interpreter.save()
    }

    fn restore(&mut self, state: &CoreState) -> bool {
        self.interpreter.restore(state)
    }
}

/// The tables, with counts of their turns.
struct Counted<'a> {
    tables: &'a mut Tables,
    counts: &'a mut Counts,
}

/// The tables' own work, which is the same for every bus.
type Own<'b> = dyn Bus + 'b;

impl<'b> Datapath<Own<'b>> for Counted<'_> {
    fn bundle(
        &mut self,
        number: u32,
        issue: &mut Issue,
        bus: &mut Border<'_, Own<'b>>,
    ) -> Result<(), Stop> {
        let result = self.tables.bundle(number, issue, bus);
        match result {
            Ok(()) => self.counts.bundles[number as usize] += 1,
            Err(Stop::Wait(_)) => {}
            Err(Stop::Fault(_) | Stop::Behind) => return result,
        }
        self.counts.last = Some(Turn::Bundle(number));
        result
    }

    fn write(&mut self, register: u32, value: u32) {
        Datapath::<Own<'b>>::write(self.tables, register, value);
    }

    fn write_vec(&mut self, register: u32, value: V4) {
        Datapath::<Own<'b>>::write_vec(self.tables, register, value);
    }

    fn kernel(&self, kernel: u32) -> KernelTimes {
        Datapath::<Own<'b>>::kernel(self.tables, kernel)
    }

    fn enter(&mut self, kernel: u32) -> u32 {
        let trip = Datapath::<Own<'b>>::enter(self.tables, kernel);
        let iterations = match trip {
            0 => 1 << 32,
            trip => u64::from(trip),
        };
        let counts = &mut self.counts.kernels[kernel as usize];
        counts.fewest = match counts.launches {
            0 => iterations,
            _ => counts.fewest.min(iterations),
        };
        counts.most = counts.most.max(iterations);
        counts.launches += 1;
        trip
    }

    fn context(
        &mut self,
        kernel: u32,
        context: u32,
        stages: u64,
        bus: &mut Border<'_, Own<'b>>,
    ) -> Result<(), Box<Fault>> {
        self.tables.context(kernel, context, stages, bus)?;
        let counts = &mut self.counts.kernels[kernel as usize];
        let slot = context % counts.contexts.len() as u32;
        counts.contexts[slot as usize] += 1;
        counts.iterations += u64::from(slot == 0 && stages & 1 != 0);
        self.counts.last = Some(Turn::Context { kernel, slot });
        Ok(())
    }

    fn rotate(&mut self, kernel: u32) {
        Datapath::<Own<'b>>::rotate(self.tables, kernel);
    }

    fn resume(&mut self, kernel: u32, iteration: u64) {
        Datapath::<Own<'b>>::resume(self.tables, kernel, iteration);
    }
}
