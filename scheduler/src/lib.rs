//! Where and when every operation runs.
//!
//! A program divided between the two engines gets units, cycles, routes and registers: [`modulo`] gives them to the
//! loops on the array, [`vliw`] to everything else, and [`assemble`] puts both together. The result is data, a
//! [`ScheduledDre`]. [`check`](srp_ir::check) checks every one that leaves this crate, and shares no code with the
//! schedulers.

pub mod abi;
pub mod demand;
pub mod modulo;
pub mod usage;
pub mod vliw;
pub mod what_if;

use srp_archdesc::arch::Arch;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_ir::check::{Checked, Refused, check_against};
use srp_ir::dre::Dre;
use srp_ir::dre::scheduled::{ModuloSchedule, ScheduledDre};
use srp_ir::layout::{Layout, TooLarge};
use srp_ir::program::Kernel;

/// A scheduled program, and how its loops stand to their bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// The program, which the checker has found right on its machine.
    pub program: Checked,
    /// For each kernel, the bounds of its II and the reason why it is above the bound.
    pub loops: EntityMap<Kernel, LoopFacts>,
    /// Facts about the control code of each function; empty for a program that was read from a
    /// file.
    pub control: Vec<vliw::FunctionFacts>,
}

/// Facts about a loop besides its schedule.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopFacts {
    /// Lower bounds of the II.
    pub bounds: modulo::Bounds,
    /// Fewest cycles of an iteration at the schedule's II.
    pub least_length: u32,
    /// Why the II below was not reached; `None` where the II is the bound.
    pub why_not_lower: Option<modulo::FailedIi>,
    /// IIs from the bound on that were proved impossible.
    pub impossible: Vec<modulo::Impossible>,
    /// What the exact search tried; `None` where the schedule was made before.
    pub search: Option<modulo::Search>,
}

/// The schedule of a loop, and the facts about it.
pub fn with_facts(scheduled: modulo::Scheduled) -> (ModuloSchedule, LoopFacts) {
    let facts = LoopFacts {
        bounds: scheduled.bounds,
        least_length: scheduled.least_length,
        why_not_lower: scheduled.why_not_lower,
        impossible: scheduled.impossible,
        search: Some(scheduled.search),
    };
    (scheduled.schedule, facts)
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
    Wrong(Refused),
}

impl std::fmt::Display for ScheduleError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            ScheduleError::TooLarge(e) => e.fmt(f),
            ScheduleError::Kernels(kernels) => {
                let line = |(kernel, e): &(Kernel, modulo::Unschedulable)| {
                    format!("kernel {} cannot run on the array: {e}", kernel.index())
                };
                let lines: Vec<String> = kernels.iter().map(line).collect();
                f.write_str(&lines.join("\n"))
            }
            ScheduleError::Control(e) => e.fmt(f),
            ScheduleError::Wrong(refused) => {
                write!(
                    f,
                    "the schedule is wrong, which is a mistake of the scheduler:\n{refused}"
                )
            }
        }
    }
}

impl std::error::Error for ScheduleError {}

/// The result for a loop.
pub type LoopResult = Result<modulo::Scheduled, modulo::Unschedulable>;

/// Schedules the control code of a program, whose loops have been scheduled, and puts both together.
/// `loops` has the result of each kernel, in their order.
///
/// # Errors
///
/// A loop has no schedule, or the program does not fit the machine.
pub fn assemble(dre: &Dre, arch: &Arch, loops: Vec<LoopResult>) -> Result<Schedule, ScheduleError> {
    let layout =
        Layout::of(&dre.control, arch.system.sram_bytes).map_err(ScheduleError::TooLarge)?;
    let mut facts = EntityMap::new();
    let mut kernels: EntityMap<Kernel, ModuloSchedule> = EntityMap::new();
    let mut failed = Vec::new();
    for (index, result) in loops.into_iter().enumerate() {
        match result {
            Ok(scheduled) => {
                let (schedule, known) = with_facts(scheduled);
                kernels.push(schedule);
                facts.push(known);
            }
            Err(why) => failed.push((Kernel::new(index), why)),
        }
    }
    if !failed.is_empty() {
        return Err(ScheduleError::Kernels(failed));
    }
    let code = vliw::emit(&dre.control, &kernels, &arch.srp, &layout);
    let code = code.map_err(ScheduleError::Control)?;
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
    let program =
        check_against(program, &code.sequence, &dre.control, arch).map_err(ScheduleError::Wrong)?;
    Ok(Schedule {
        program,
        loops: facts,
        control: code.facts,
    })
}
