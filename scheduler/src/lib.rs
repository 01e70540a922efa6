//! Where and when every operation runs; and a checker that does not trust it.
//!
//! [`schedule`] takes the program divided between the two engines and gives it units, cycles,
//! routes and registers: [`modulo`] for the loops on the array, [`vliw`] for everything else. The
//! result is data, a [`ScheduledDre`]; [`check`] goes over every one that leaves this crate, and
//! shares no code with what made it.

pub mod abi;
pub mod check;
pub mod demand;
pub mod modulo;
pub mod sequence;
pub mod usage;
pub mod vliw;
pub mod what_if;

use check::Violation;
use srp_archdesc::arch::Arch;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::threads;
use srp_archdesc::watch::{Event, Stage, Watch};
use srp_ir::dfg::Dfg;
use srp_ir::dre::Dre;
use srp_ir::dre::scheduled::{ModuloSchedule, ScheduledDre};
use srp_ir::layout::{Layout, TooLarge};
use srp_ir::program::Kernel;
use std::sync::Mutex;

/// How to schedule.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// How hard to try for each loop.
    pub modulo: modulo::Options,
    /// Threads to use; the result does not depend on it.
    pub threads: usize,
    /// Loops scheduled before for this machine, with these options; those of this call are added.
    pub known: Option<&'a Known>,
}

/// Loops and what came of scheduling them.
#[derive(Default)]
pub struct Known(Mutex<Vec<(Dfg, LoopResult)>>);

impl Known {
    fn of(&self, dfg: &Dfg) -> Option<LoopResult> {
        let known = self.0.lock().expect("no thread panics with the lock held");
        let same = known.iter().find(|(other, _)| other == dfg);
        same.map(|(_, result)| result.clone())
    }

    fn add(&self, dfg: &Dfg, result: &LoopResult) {
        let mut known = self.0.lock().expect("no thread panics with the lock held");
        known.push((dfg.clone(), result.clone()));
    }
}

impl Default for Options<'_> {
    fn default() -> Self {
        Options {
            modulo: modulo::Options::default(),
            threads: 1,
            known: None,
        }
    }
}

/// A scheduled program, and how its loops stand to their bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// The program.
    pub program: ScheduledDre,
    /// For each kernel, what bounds its II and what kept it from the bound.
    pub loops: EntityMap<Kernel, LoopFacts>,
    /// What is known of the control code of each function; nothing for a program that was read.
    pub control: Vec<vliw::FunctionFacts>,
}

/// What is known of a loop besides its schedule.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopFacts {
    /// Lower bounds of the II.
    pub bounds: modulo::Bounds,
    /// Why the II below was not reached, in words; `None` where the II is the bound.
    pub obstacle: Option<String>,
    /// IIs from the bound on that were proved impossible.
    pub impossible: Vec<modulo::Impossible>,
}

/// Why a program has no schedule on a machine.
#[derive(Clone, Debug, PartialEq)]
pub enum ScheduleError {
    /// Its globals do not fit in the SRAM.
    TooLarge(TooLarge),
    /// Loops that cannot run on the array. Without them among the kernels, the program may still
    /// run.
    Kernels(Vec<(Kernel, modulo::Unschedulable)>),
    /// The control code cannot run on the VLIW engine.
    Control(vliw::VliwError),
    /// The schedule breaks the machine's rules: a mistake of this crate.
    Wrong(Vec<Violation>),
}

impl std::fmt::Display for ScheduleError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            ScheduleError::TooLarge(e) => e.fmt(f),
            ScheduleError::Kernels(kernels) => {
                let line = |(kernel, e): &(Kernel, modulo::Unschedulable)| {
                    format!(
                        "kernel {} cannot run on the array: {}",
                        kernel.index(),
                        e.why
                    )
                };
                let lines: Vec<String> = kernels.iter().map(line).collect();
                f.write_str(&lines.join("\n"))
            }
            ScheduleError::Control(e) => e.fmt(f),
            ScheduleError::Wrong(violations) => {
                write!(
                    f,
                    "the schedule is wrong, which is a mistake of the scheduler:"
                )?;
                violations.iter().try_for_each(|v| write!(f, "\n  {v}"))
            }
        }
    }
}

impl std::error::Error for ScheduleError {}

/// Schedules a program for a machine.
pub fn schedule(
    dre: &Dre,
    arch: &Arch,
    options: &Options<'_>,
    watch: &dyn Watch,
) -> Result<Schedule, ScheduleError> {
    let layout =
        Layout::of(&dre.control, arch.system.sram_bytes).map_err(ScheduleError::TooLarge)?;
    let mut loops = EntityMap::new();
    let mut kernels: EntityMap<Kernel, ModuloSchedule> = EntityMap::new();
    let mut failed = Vec::new();
    for (index, result) in schedule_loops(&dre.kernels, arch, options, watch)
        .into_iter()
        .enumerate()
    {
        let modulo::Scheduled {
            schedule,
            bounds,
            obstacle,
            impossible,
        } = match result {
            Ok(scheduled) => scheduled,
            Err(why) => {
                failed.push((Kernel::new(index), why));
                continue;
            }
        };
        kernels.push(schedule);
        loops.push(LoopFacts {
            bounds,
            obstacle,
            impossible,
        });
    }
    if !failed.is_empty() {
        return Err(ScheduleError::Kernels(failed));
    }
    let code = vliw::emit(&dre.control, &kernels, arch, &layout).map_err(ScheduleError::Control)?;
    let program = ScheduledDre {
        machine: arch.name.clone(),
        files: dre.control.files.clone(),
        symbols: layout.symbols(&dre.control),
        image: layout.image,
        bundles: code.bundles,
        functions: code.functions,
        start: code.start,
        kernels,
    };
    check::check(&program, arch).map_err(ScheduleError::Wrong)?;
    let wrong = check::check_sequence(&program, &code.sequence, arch);
    if !wrong.is_empty() {
        return Err(ScheduleError::Wrong(wrong));
    }
    Ok(Schedule {
        program,
        loops,
        control: code.facts,
    })
}

type LoopResult = Result<modulo::Scheduled, modulo::Unschedulable>;

/// Schedules all loops, on as many threads as asked for, in their order.
fn schedule_loops(
    kernels: &EntityMap<Kernel, Dfg>,
    arch: &Arch,
    options: &Options<'_>,
    watch: &dyn Watch,
) -> Vec<LoopResult> {
    let stage = Stage::of(watch, "scheduling", kernels.len() as u64);
    let state = || ();
    threads::each(options.threads, kernels.len(), state, |(), index| {
        let dfg = &kernels[Kernel::new(index)];
        watch.tell(Event::ItemBegins(&dfg.name));
        let result = options.known.and_then(|k| k.of(dfg)).unwrap_or_else(|| {
            let result = modulo::schedule(dfg, arch, &options.modulo, watch);
            options.known.inspect(|k| k.add(dfg, &result));
            result
        });
        watch.tell(Event::ItemEnds(&dfg.name));
        stage.done(1);
        result
    })
}
