//! [`compile()`]: an input all the way to a schedule.

use crate::divide::{Divided, NotPipelined, divide, give_back};
use crate::front_end::{front_end, optimise};
use crate::loops;
use crate::session::{Session, Timed, Times};
use crate::{Effort, Error, Input, Options};
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::{Messages, Source};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::watch::{Stage, Watch};
use srp_ir::check::{self, Checked, Refused, Violation};
use srp_ir::dfg::{Dfg, Order};
use srp_ir::dre::Dre;
use srp_ir::dre::scheduled::ModuloSchedule;
use srp_ir::layout::Layout;
use srp_ir::pass;
use srp_ir::program::{Kernel, Program, SourceFile};
use srp_ir::split::{Counter, Remark};
use srp_scheduler::modulo::{self, Unschedulable};
use srp_scheduler::{LoopFacts, Schedule, ScheduleError, vliw};
use std::collections::BTreeMap;

/// A scheduled program, and the facts about it.
pub struct Compiled {
    /// The program before it was scheduled; `None` for a program that was read scheduled.
    pub dre: Option<Dre>,
    /// The schedule.
    pub schedule: Schedule,
    /// Warnings about the sources.
    pub messages: Messages,
    /// Remarks of the passes.
    pub pass_remarks: Vec<pass::Remark>,
    /// Loops that stay in the control code, with the obstacle of each.
    pub not_pipelined: Vec<NotPipelined>,
    /// Memory accesses of the kernels that stay in order because nothing shows that they never meet.
    pub remarks: Vec<Remark>,
    /// The memory orders of each kernel that would be left if pointers were `restrict`.
    pub relaxed: BTreeMap<String, Vec<Order>>,
    /// The counters of each kernel, by its name.
    pub counters: BTreeMap<String, Vec<Counter>>,
    /// Loops that the array could not run, and that went back to the control code.
    pub refused: Vec<Dfg>,
    /// How long each stage took, and the search for the schedule of each loop by name.
    pub times: Times,
}

impl Compiled {
    /// The program, if there is a function to start with.
    ///
    /// # Errors
    ///
    /// [`Error::NoMain`].
    pub fn runnable(&self) -> Result<&Checked, Error> {
        match &self.dre {
            Some(dre) if dre.control.main.is_none() => Err(Error::NoMain),
            _ => Ok(&self.schedule.program),
        }
    }

    /// A program that was read scheduled, without other facts.
    fn of(schedule: Schedule) -> Compiled {
        Compiled {
            dre: None,
            schedule,
            messages: Messages::default(),
            pass_remarks: Vec::new(),
            not_pipelined: Vec::new(),
            remarks: Vec::new(),
            relaxed: BTreeMap::new(),
            counters: BTreeMap::new(),
            refused: Vec::new(),
            times: Times::default(),
        }
    }
}

/// Some loops of a program, scheduled without the rest of it, and the facts about them.
pub struct CompiledLoops {
    /// The program's files.
    pub files: EntityMap<SourceFile, String>,
    /// The loops on the array, each with its schedule and the other facts about it.
    pub schedules: Vec<(ModuloSchedule, LoopFacts)>,
    /// The names of the loops that the caller did not ask for.
    pub others: Vec<String>,
    /// Warnings about the sources.
    pub messages: Messages,
    /// Remarks of the passes.
    pub pass_remarks: Vec<pass::Remark>,
    /// All loops that stay in the control code, with the obstacle of each.
    pub not_pipelined: Vec<NotPipelined>,
    /// Memory accesses of all loops that stay in order because nothing shows that they never meet.
    pub remarks: Vec<Remark>,
    /// The memory orders of each loop that would be left if pointers were `restrict`.
    pub relaxed: BTreeMap<String, Vec<Order>>,
    /// Loops that the array could not run, and that stay in the control code.
    pub refused: Vec<Dfg>,
    /// How long each stage took, and the search for the schedule of each loop by name.
    pub times: Times,
}

/// Takes C sources to the schedules of some of their loops: those that `wanted` says yes to, by name and
/// place.
///
/// # Errors
///
/// The sources are wrong, or the program does not fit the machine.
pub fn compile_loops(
    sources: &[Source],
    wanted: &dyn Fn(&Dfg, &EntityMap<SourceFile, String>) -> bool,
    arch: &Arch,
    options: &Options,
    session: &Session<'_>,
) -> Result<CompiledLoops, Error> {
    let timed = Timed::new(session.watch);
    let (mut program, messages, pass_remarks) = optimised(sources, arch, options, &timed)?;
    let divided = divided(&mut program, arch, &timed)?;
    let mut not_pipelined = divided.not_pipelined;
    let mut refused = divided.refused;
    let dre = divided.dre;
    let files = dre.control.files.clone();
    let (wanted, others): (Vec<&Dfg>, Vec<&Dfg>) =
        (dre.kernels.values()).partition(|dfg| wanted(dfg, &files));
    // Kernels that share contexts are scheduled together.
    let all: Vec<&Dfg> = match arch.srp.shared_contexts {
        true => dre.kernels.values().collect(),
        false => wanted.clone(),
    };
    let results = loops::schedule_all(&all, arch, &options.effort.modulo(), session, &timed);
    let mut schedules = Vec::new();
    let is_wanted = |dfg: &&Dfg| wanted.iter().any(|one| std::ptr::eq(*one, *dfg));
    let results = all.iter().copied().zip(results);
    for (dfg, result) in results.filter(|(dfg, _)| is_wanted(dfg)) {
        match result {
            Ok(scheduled) => schedules.push(srp_scheduler::with_facts(scheduled)),
            Err(why) => {
                let kernel = dre.kernels.iter().find(|(_, d)| d.name == dfg.name);
                let (kernel, _) = kernel.expect("it is one of them");
                not_pipelined.push(give_back(&mut program, &dre, kernel, why)?);
                refused.push(dfg.clone());
            }
        }
    }
    Ok(CompiledLoops {
        others: others.iter().map(|dfg| dfg.name.clone()).collect(),
        files,
        schedules,
        messages,
        pass_remarks,
        not_pipelined,
        remarks: divided.remarks,
        relaxed: divided.relaxed,
        refused,
        times: timed.times(),
    })
}

/// A loop that goes to the array, and the II that no schedule of it is below.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeastIi {
    /// The loop's name.
    pub kernel: String,
    /// The II.
    pub ii: u32,
}

/// The least IIs of loops of C sources, those that `wanted` says yes to. They take no schedule, and so a small part of the
/// time of one.
///
/// # Errors
///
/// The sources are wrong, or the program does not fit the machine.
pub fn least_iis(
    sources: &[Source],
    wanted: &dyn Fn(&Dfg, &EntityMap<SourceFile, String>) -> bool,
    arch: &Arch,
    options: &Options,
) -> Result<Vec<LeastIi>, Error> {
    let (mut program, _) = front_end(sources, arch, options)?;
    optimise(&mut program, arch, options);
    let dre = divide(&mut program, arch)?.dre;
    let wanted = (dre.kernels.values()).filter(|dfg| wanted(dfg, &dre.control.files));
    let least = |dfg: &Dfg| LeastIi {
        kernel: dfg.name.clone(),
        ii: modulo::bounds(dfg, &arch.srp).min_ii(),
    };
    Ok(wanted.map(least).collect())
}

/// C through front end and passes.
fn optimised(
    sources: &[Source],
    arch: &Arch,
    options: &Options,
    watch: &dyn Watch,
) -> Result<(Program, Messages, Vec<pass::Remark>), Error> {
    let stage = Stage::unknown(watch, "front end");
    let (mut program, messages) = front_end(sources, arch, options)?;
    drop(stage);
    let _stage = Stage::unknown(watch, "passes");
    let remarks = optimise(&mut program, arch, options);
    Ok((program, messages, remarks))
}

fn divided(program: &mut Program, arch: &Arch, watch: &dyn Watch) -> Result<Divided, Error> {
    let _stage = Stage::unknown(watch, "dividing");
    divide(program, arch)
}

/// Takes an input all the way to a schedule.
///
/// # Errors
///
/// The sources are wrong, the program does not fit the machine, or the work was cancelled before it had a schedule.
pub fn compile(
    input: Input,
    arch: &Arch,
    options: &Options,
    session: &Session<'_>,
) -> Result<Compiled, Error> {
    let timed = Timed::new(session.watch);
    match input {
        Input::C(sources) => {
            let (program, messages, pass_remarks) = optimised(&sources, arch, options, &timed)?;
            Ok(Compiled {
                messages,
                pass_remarks,
                ..schedule_timed(program, arch, options.effort, session, &timed)?
            })
        }
        Input::Ir(program) => schedule_timed(*program, arch, options.effort, session, &timed),
        Input::Dre(dre) => {
            frames_fit(&dre.control, arch)?;
            let scheduled = schedule_dre(&dre, arch, &options.effort.modulo(), session, &timed);
            let scheduled = match scheduled {
                Ok(scheduled) => scheduled,
                Err(error) => {
                    session.check()?;
                    return Err(refusal(&dre, error));
                }
            };
            Ok(Compiled {
                times: timed.times(),
                ..Compiled::of(scheduled)
            }
            .with(*dre))
        }
        Input::Scheduled { file, program } => {
            let program = check::check(*program, arch);
            let program = program.map_err(|refused| broken(file, &refused, arch))?;
            let loops = program.kernels.values();
            let loops: EntityMap<_, _> = loops.map(|s| facts_alone(s, arch)).collect();
            Ok(Compiled::of(Schedule {
                program,
                loops,
                control: Vec::new(),
            }))
        }
    }
}

/// The rules that a file of a schedule breaks, where it does.
fn broken(file: Source, refused: &Refused, arch: &Arch) -> Error {
    let Refused {
        program,
        violations,
    } = refused;
    let describe = |violation: &Violation| violation.describe(program);
    let diagnostics = check::diagnostics(violations, &file, arch, &describe);
    let sources = vec![file];
    Error::Messages(Messages {
        diagnostics,
        sources,
    })
}

impl Compiled {
    fn with(self, dre: Dre) -> Compiled {
        Compiled {
            dre: Some(dre),
            ..self
        }
    }
}

/// Divides a program and schedules it. Loops that the array cannot run go back to the control code.
///
/// # Errors
///
/// The program does not fit the machine, or the work was cancelled before it had a schedule.
pub fn schedule(
    program: Program,
    arch: &Arch,
    effort: Effort,
    session: &Session<'_>,
) -> Result<Compiled, Error> {
    let timed = Timed::new(session.watch);
    schedule_timed(program, arch, effort, session, &timed)
}

fn schedule_timed(
    mut program: Program,
    arch: &Arch,
    effort: Effort,
    session: &Session<'_>,
    timed: &Timed<'_>,
) -> Result<Compiled, Error> {
    frames_fit(&program, arch)?;
    let (mut unschedulable, mut all_refused) = (Vec::new(), Vec::new());
    loop {
        let Divided {
            dre,
            mut not_pipelined,
            remarks,
            relaxed,
            counters,
            refused,
        } = divided(&mut program, arch, timed)?;
        all_refused.extend(refused);
        match schedule_dre(&dre, arch, &effort.modulo(), session, timed) {
            Ok(schedule) => {
                not_pipelined.extend(unschedulable);
                return Ok(Compiled {
                    not_pipelined,
                    remarks,
                    relaxed,
                    counters,
                    refused: all_refused,
                    times: timed.times(),
                    ..Compiled::of(schedule)
                }
                .with(dre));
            }
            Err(ScheduleError::Kernels(failed)) => {
                // A search that was cut short says nothing of the loop.
                session.check()?;
                for (kernel, why) in failed {
                    all_refused.push(dre.kernels[kernel].clone());
                    unschedulable.push(give_back(&mut program, &dre, kernel, why)?);
                }
            }
            Err(error) => return Err(error.into()),
        }
    }
}

/// Refuses a function whose variables alone are more than the stack can be, before anything is
/// scheduled for long.
fn frames_fit(program: &Program, arch: &Arch) -> Result<(), Error> {
    let layout = Layout::of(program, arch.system.sram_bytes)?;
    let left = u64::from(layout.stack_top).saturating_sub(layout.image.len() as u64);
    for func in program.funcs.values() {
        let sizes = func.slots.values().map(|slot| u64::from(slot.size));
        let bytes: u64 = sizes.sum();
        if bytes > left {
            return Err(Error::Invalid(format!(
                "{}: the variables of {} need {bytes} bytes of stack; beside its globals, the program \
                 has {left} in SRAM: make them static or smaller, or the `<sram size=\"…\"/>` larger",
                program.show_pos(func.pos),
                func.name,
            )));
        }
    }
    Ok(())
}

/// Schedules a program that is divided: its loops, then the control code around them.
///
/// # Errors
///
/// A loop has no schedule, or the program does not fit the machine.
pub fn schedule_divided(
    dre: &Dre,
    arch: &Arch,
    options: &modulo::Options,
    session: &Session<'_>,
) -> Result<Schedule, ScheduleError> {
    schedule_dre(dre, arch, options, session, &Timed::new(session.watch))
}

fn schedule_dre(
    dre: &Dre,
    arch: &Arch,
    options: &modulo::Options,
    session: &Session<'_>,
    timed: &Timed<'_>,
) -> Result<Schedule, ScheduleError> {
    // Loops take long; what cannot run after all is refused before them.
    vliw::admit(&dre.control, &arch.srp).map_err(ScheduleError::Control)?;
    let all: Vec<&Dfg> = dre.kernels.values().collect();
    let loops = loops::schedule_all(&all, arch, options, session, timed);
    let _stage = Stage::unknown(timed, "control code");
    srp_scheduler::assemble(dre, arch, loops)
}

/// Why a divided program, whose loops cannot go back to the control code, has no schedule.
fn refusal(dre: &Dre, error: ScheduleError) -> Error {
    let ScheduleError::Kernels(failed) = error else {
        return error.into();
    };
    let line = |(kernel, why): (Kernel, Unschedulable)| {
        let dfg = &dre.kernels[kernel];
        let pos = why.node().map_or(dfg.pos, |n| dfg.nodes[n].pos);
        let file = dre.control.files.get(pos.file).map_or("", String::as_str);
        let name = &dfg.name;
        format!(
            "{file}:{}:{}: {name} cannot run on the array: {why}",
            pos.line, pos.column
        )
    };
    Error::Invalid(failed.into_iter().map(line).collect::<Vec<_>>().join("\n"))
}

/// The facts about a loop whose schedule was made before.
pub fn facts_alone(schedule: &ModuloSchedule, arch: &Arch) -> LoopFacts {
    LoopFacts {
        bounds: modulo::bounds(&schedule.dfg, &arch.srp),
        least_length: modulo::least_length(schedule, &arch.srp),
        why_not_lower: None,
        impossible: Vec::new(),
        search: None,
    }
}
