//! Initiation intervals: the II of every loop of a program, its bounds, the resources that it takes, and
//! changes that would help.
//!
//! [`report()`] makes the [`Report`] of a [`Subject`]; [`diff()`] compares two reports. A [`Report`] is data:
//! it can be read back from the text that `serde` writes of it.

mod changes;
mod diff;
mod hint;
mod measure;
mod model;
mod resource;
mod trial;
mod wires;

pub use changes::{Advice, Change, Lowered, WhatIf};
pub use diff::{Difference, Differences, Figure, diff};
pub use model::{
    ArrayShape, Carried, Cell, Edge, FileKind, FileLoad, FunctionReport, Graph, LinkLoad,
    LoopReport, NotPipelined, Obstacle, Operation, Ordered, PortLoad, Position, Report, Resource,
    SharedLoad, StageTime, Status, Step, Taken, UnitLoad, WireLoad, part, percent,
};

use crate::Error;
use measure::{Names, View};
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::{Messages, Source};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_ir::check;
use srp_ir::dfg::{Dfg, Order};
use srp_ir::dre;
use srp_ir::dre::scheduled::{ModuloSchedule, ScheduledLoops};
use srp_ir::program::SourceFile;
use srp_ir::split::Remark;
use srp_scheduler::LoopFacts;
use srp_scheduler::vliw::FunctionFacts;
use srp_toolchain::envelope::Named;
use srp_toolchain::{Compiled, CompiledLoops, Session, Times, facts_alone};
use std::borrow::Cow;
use std::collections::BTreeMap;
use trial::Machine;

/// Contents of a report besides what a schedule shows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Report the loops of this name only.
    pub kernel: Option<String>,
    /// Say how long each schedule was looked for.
    pub times: bool,
    /// Try small changes of the machine, and say which lower each loop's II.
    pub what_if: bool,
    /// The text of the machine's file, where changes are to be told as settings of it.
    pub machine: Option<String>,
    /// Try what II is left where pointers that may alias keep accesses in order, and `restrict` would not.
    pub restrict: bool,
}

/// Scheduled loops to report on.
pub struct Subject<'a> {
    files: &'a EntityMap<SourceFile, String>,
    loops: Vec<(&'a ModuloSchedule, Cow<'a, LoopFacts>)>,
    /// The program that they are of, if there is one.
    program: Option<Known<'a>>,
    /// The names of loops of the program that are not among them.
    others: &'a [String],
}

/// Facts of a program besides its schedules.
#[derive(Clone, Copy)]
struct Known<'a> {
    not_pipelined: &'a [srp_toolchain::NotPipelined],
    remarks: &'a [Remark],
    relaxed: &'a BTreeMap<String, Vec<Order>>,
    refused: &'a [Dfg],
    functions: &'a [FunctionFacts],
    times: &'a Times,
}

impl<'a> Subject<'a> {
    /// The loops of a program.
    pub fn of_program(compiled: &'a Compiled) -> Subject<'a> {
        let program = &compiled.schedule.program;
        let facts = compiled.schedule.loops.values().map(Cow::Borrowed);
        Subject {
            files: &program.files,
            loops: program.kernels.values().zip(facts).collect(),
            program: Some(Known {
                not_pipelined: &compiled.not_pipelined,
                remarks: &compiled.remarks,
                relaxed: &compiled.relaxed,
                refused: &compiled.refused,
                functions: &compiled.schedule.control,
                times: &compiled.times,
            }),
            others: &[],
        }
    }

    /// Some loops of a program.
    pub fn of_some(compiled: &'a CompiledLoops) -> Subject<'a> {
        let loops = compiled.schedules.iter();
        Subject {
            files: &compiled.files,
            loops: loops.map(|(s, facts)| (s, Cow::Borrowed(facts))).collect(),
            program: Some(Known {
                not_pipelined: &compiled.not_pipelined,
                remarks: &compiled.remarks,
                relaxed: &compiled.relaxed,
                refused: &compiled.refused,
                functions: &[],
                times: &compiled.times,
            }),
            others: &compiled.others,
        }
    }

    /// Loops without a program, which nobody knows more of than their schedules.
    pub fn of_loops(scheduled: &'a ScheduledLoops, arch: &Arch) -> Subject<'a> {
        let facts = |s| Cow::Owned(facts_alone(s, arch));
        Subject {
            files: &scheduled.files,
            loops: scheduled.loops.iter().map(|s| (s, facts(s))).collect(),
            program: None,
            others: &[],
        }
    }

    /// The loops, each with what is known of it besides its schedule.
    pub fn loops(&self) -> impl Iterator<Item = (&ModuloSchedule, &LoopFacts)> {
        self.loops.iter().map(|(s, facts)| (*s, facts.as_ref()))
    }

    /// The loop with this name.
    fn find(&self, kernel: &str) -> Option<(&ModuloSchedule, &LoopFacts)> {
        self.loops().find(|(s, _)| s.dfg.name == kernel)
    }

    /// The loop with this name that the array could not run.
    fn refused(&self, kernel: &str) -> Option<&Dfg> {
        let refused = self.program?.refused;
        refused.iter().find(|dfg| dfg.name == kernel)
    }

    /// The loop with this name, as it would be if pointers that may alias were `restrict`.
    fn relaxed(&self, dfg: &Dfg) -> Option<Dfg> {
        Some(Dfg {
            order: self.program?.relaxed.get(&dfg.name)?.clone(),
            ..dfg.clone()
        })
    }
}

/// Reads schedules without a program, as `srp map` writes them; `None` where the text is of another
/// form. Messages know it by `name`.
///
/// # Errors
///
/// The text is wrong, or a schedule breaks the rules of the machine.
pub fn read_scheduled(
    name: &str,
    text: &str,
    arch: &Arch,
) -> Result<Option<ScheduledLoops>, Error> {
    if !text.contains("<scheduled-loops") {
        return Ok(None);
    }
    let file = Source::new(name, text);
    let told = |diagnostics| {
        let sources = vec![file.clone()];
        Error::Toolchain(srp_toolchain::Error::Messages(Messages {
            diagnostics,
            sources,
        }))
    };
    let wrong = |e: dre::DreError| told(vec![e.diagnostic(name)]);
    let scheduled = dre::read_loops(text, arch).map_err(wrong)?;
    let broken = check::check_loops(&scheduled.loops, &arch.srp);
    if broken.is_empty() {
        return Ok(Some(scheduled));
    }
    let describe = |violation: &check::Violation| {
        let kernel = violation
            .at
            .kernel()
            .and_then(|k| scheduled.loops.get(k.index()));
        let name = kernel.map_or("", |schedule| &schedule.dfg.name);
        let (message, rule) = (&violation.message, violation.rule);
        format!("kernel `{name}`: {message} ({rule:?})")
    };
    Err(told(check::diagnostics(&broken, &file, arch, &describe)))
}

/// Reports on loops. Where the watch ends the work, the report says that it is not complete.
///
/// # Errors
///
/// No loop has the name that the options ask for.
pub fn report(
    subject: &Subject<'_>,
    arch: &Arch,
    options: &Options,
    session: &Session<'_>,
) -> Result<Report, Error> {
    let mut report = measured(subject, arch);
    report.complete = !session.watch.cancelled();
    if let Some(kernel) = &options.kernel {
        report.keep_only(kernel, subject.others)?;
    }
    if let (true, Some(program)) = (options.times, subject.program) {
        for l in &mut report.loops {
            let time = program.times.items.get(&l.kernel);
            l.seconds = time.map(|time| time.as_secs_f64());
        }
        let stages = program.times.stages.iter();
        report.stages = stages
            .map(|(&name, time)| StageTime::of(name, *time))
            .collect();
    }
    if options.restrict {
        trial::try_restrict(&mut report, subject, arch, session);
    }
    if options.what_if {
        trial::try_changes(
            &mut report,
            subject,
            Machine {
                arch,
                text: options.machine.as_deref(),
            },
            session,
        );
    }
    for l in &mut report.loops {
        if let Some((_, facts)) = subject.find(&l.kernel) {
            l.hint = hint::of(l, facts, &arch.srp);
        }
    }
    Ok(report)
}

/// Returns the report of schedules and the facts known of them.
fn measured(subject: &Subject<'_>, arch: &Arch) -> Report {
    let view = View {
        names: Names(subject.files),
        arch,
        remarks: subject.program.map_or(&[], |p| p.remarks),
        relaxed: subject.program.map(|p| p.relaxed),
    };
    let not_pipelined = subject.program.map_or(&[][..], |p| p.not_pipelined);
    let functions = subject.program.map_or(&[][..], |p| p.functions);
    Report {
        machine: Named::machine(arch),
        array: ArrayShape {
            rows: arch.srp.rows,
            columns: arch.srp.cols,
            contexts: arch.srp.contexts,
        },
        complete: true,
        loops: subject
            .loops()
            .map(|(s, facts)| view.of_loop(s, facts))
            .collect(),
        not_pipelined: self::not_pipelined(not_pipelined, subject.files),
        functions: functions.iter().map(function).collect(),
        advice: Vec::new(),
        stages: Vec::new(),
    }
}

fn function(facts: &FunctionFacts) -> FunctionReport {
    FunctionReport {
        function: facts.name.clone(),
        operations: facts.operations,
        bundles: facts.bundles,
        least: facts.least,
        frame: facts.frame,
        spilled: facts.spilled,
    }
}

/// The loops of a program with these files that stay in the control code, with what is in their way.
pub fn not_pipelined<'a>(
    loops: impl IntoIterator<Item = &'a srp_toolchain::NotPipelined>,
    files: &EntityMap<SourceFile, String>,
) -> Vec<NotPipelined> {
    let names = Names(files);
    let of = |n: &srp_toolchain::NotPipelined| NotPipelined {
        kernel: n.name.clone(),
        at: names.position(n.pos),
        reason: n.reason.to_string(),
        reason_at: names.position(n.at),
        required: n.required,
        what_if: None,
    };
    loops.into_iter().map(of).collect()
}
