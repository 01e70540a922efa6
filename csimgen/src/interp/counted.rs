//! The interpreter with counters: the same cycles, and how often each bundle and context had its turn.
//!
//! A core goes into a system and does not come back, so its counts are shared with whoever wants them.

use super::tables::Tables;
use super::{Interpreter, trap};
use crate::preamble::border::{Border, Fault, Stop};
use crate::preamble::issue::Issue;
use crate::preamble::ops::V4;
use crate::preamble::sequencer::{Datapath, KernelTimes};
use crate::spec::{BundleSpec, KernelSpec, SimSpec};
use srp_runtime::core::{Activity, Bus, Core, CoreState, Run, Trap};
use std::cell::{Ref, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;

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
    /// Cycles for which banks of the SRAM have kept the core after a turn, where a run ends with each that they keep.
    pub conflicts: BTreeMap<Turn, u64>,
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

    /// A kernel has run on the array from this cycle of an iteration on: contexts have their turn one after the
    /// other, so that a run of them is counted when it is over. `to_begin` iterations had not begun before.
    fn on_array(&mut self, kernel: u32, slot: u32, cycles: u64, to_begin: u64) {
        if cycles == 0 {
            return;
        }
        let counts = &mut self.kernels[kernel as usize];
        let ii = counts.contexts.len() as u64;
        let (first, end) = (u64::from(slot), u64::from(slot) + cycles);
        let (rounds, rest) = (cycles / ii, cycles % ii);
        if rounds > 0 {
            counts
                .contexts
                .iter_mut()
                .for_each(|cycles| *cycles += rounds);
        }
        for cycle in first..first + rest {
            counts.contexts[(cycle % ii) as usize] += 1;
        }
        let starts = end.div_ceil(ii) - first.div_ceil(ii);
        counts.iterations += starts.min(to_begin);
        let slot = ((end - 1) % ii) as u32;
        self.last = Some(Turn::Context { kernel, slot });
    }
}

/// The counts of a core that runs elsewhere.
#[derive(Clone, Debug)]
pub struct SharedCounts(Rc<RefCell<Counts>>);

impl SharedCounts {
    /// The counts so far. They are given back before the core runs on.
    pub fn get(&self) -> Ref<'_, Counts> {
        self.0.borrow()
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
            counts: SharedCounts(Rc::new(RefCell::new(Counts::of(spec)))),
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
        let counts = &mut *counts.0.borrow_mut();
        let mut border = Border::new(bus, interpreter.first_address, interpreter.banks);
        let (slot, to_begin) = interpreter.sequencer.turn_on_array();
        let mut path = Counted {
            tables: &mut interpreter.tables,
            counts,
            to_begin,
        };
        let result = interpreter.sequencer.run(&mut path, &mut border, budget);
        let (to_begin, lost) = (path.to_begin, border.lost());
        let run = result.map_err(|fault| {
            let calls = interpreter.sequencer.open_calls();
            trap(fault.kind, fault.at, calls, &interpreter.positions)
        })?;
        match run.activity {
            Activity::Array(kernel) => counts.on_array(kernel, slot, run.cycles, to_begin),
            Activity::Switch => {
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
            Activity::Vliw | Activity::Wait(_) | Activity::Halted(_) => {}
        }
        if let (Some(turn), lost @ 1..) = (counts.last, lost) {
            *counts.conflicts.entry(turn).or_default() += lost;
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
    /// Iterations of the launch on the array that are yet to begin, before the run or at its launch.
    to_begin: u64,
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

    fn operations(&self, bundle: u32) -> u64 {
        Datapath::<Own<'b>>::operations(self.tables, bundle)
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
        self.to_begin = iterations;
        trip
    }

    fn context(
        &mut self,
        kernel: u32,
        context: u32,
        stages: u64,
        bus: &mut Border<'_, Own<'b>>,
    ) -> Result<(), Box<Fault>> {
        self.tables.context(kernel, context, stages, bus)
    }

    fn rotate(&mut self, kernel: u32) {
        Datapath::<Own<'b>>::rotate(self.tables, kernel);
    }

    fn resume(&mut self, kernel: u32, iteration: u64) {
        Datapath::<Own<'b>>::resume(self.tables, kernel, iteration);
    }
}
