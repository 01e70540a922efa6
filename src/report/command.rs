//! `srp report`

use super::model::Report;
use super::{diff, html, output, report, report_loops, text, trial};
use crate::cli;
use crate::compile::compile_and_say;
use crate::failure::Failure;
use crate::proof::{self, Proved};
use crate::{files, interrupt, talk};
use srp_archdesc::arch::Arch;
use srp_archdesc::entity::EntityMap;
use srp_ir::dfg::Dfg;
use srp_ir::dre;
use srp_ir::dre::scheduled::{ModuloSchedule, ScheduledLoops};
use srp_scheduler::modulo::Impossible;
use srp_toolchain::{Compiled, Input, facts_alone, input, machine};
use std::path::{Path, PathBuf};

/// Runs `srp report`; 1 where two reports are compared and something got worse. Interrupted, it
/// reports what the loops had reached.
pub(crate) fn run(args: &cli::Report) -> Result<i32, Failure> {
    if let Some([old, new]) = args.diff.as_deref() {
        return compare(old, new, args.json);
    }
    if let Some(path) = &args.html {
        files::check_writable(path)?;
    }
    let arch = machine::read(&args.compilation.machine.machine)?;
    let subject = Subject::of(args, &arch)?;
    if let Some(path) = &args.proof {
        prove(path, args.kernel.as_deref(), &subject, &arch)?;
    }
    let mut report = subject.report(&arch);
    if let Some(kernel) = &args.kernel {
        report.keep_only(kernel)?;
    }
    if let (Subject::Program(compiled), true) = (&subject, args.times) {
        for l in &mut report.loops {
            l.seconds = compiled.times.items.get(&l.kernel).map(|t| t.as_secs_f64());
        }
    }
    if args.what_if {
        trial::try_changes(&mut report, &subject.schedules(), subject.refused(), &arch);
    }
    if let Some(path) = &args.html {
        files::write(path, html::page(&report).as_bytes())?;
    }
    talk::print(match args.json {
        true => output::json(&report)?,
        false => text::text(&report),
    })?;
    interrupt::end_if_requested()?;
    Ok(0)
}

/// Compares two reports; 1 where something got worse.
fn compare(old: &Path, new: &Path, json: bool) -> Result<i32, Failure> {
    let differences = diff::diff(&diff::read(old)?, &diff::read(new)?);
    talk::print(match json {
        true => output::json(&differences)?,
        false => diff::text(&differences),
    })?;
    Ok(i32::from(differences.is_worse()))
}

/// What is reported on.
enum Subject {
    /// A program's loops.
    Program(Box<Compiled>),
    /// Schedules without a program.
    Loops(ScheduledLoops),
}

impl Subject {
    fn of(args: &cli::Report, arch: &Arch) -> Result<Subject, Failure> {
        if let Some(loops) = scheduled_loops(&args.files, arch)? {
            return Ok(Subject::Loops(loops));
        }
        let input = if args.files.is_empty() {
            Input::C(input::kernels())
        } else {
            input::read(&args.files, arch)?
        };
        let options = args.compilation.options()?;
        let source = &args.compilation.source;
        let compiled = compile_and_say(input, arch, &options, source, &talk::session())?;
        Ok(Subject::Program(Box::new(compiled)))
    }

    fn report(&self, arch: &Arch) -> Report {
        match self {
            Subject::Program(compiled) => report(compiled, arch),
            Subject::Loops(loops) => {
                let facts = loops.loops.iter().map(|s| facts_alone(s, arch));
                report_loops(loops, &facts.collect::<EntityMap<_, _>>(), arch)
            }
        }
    }

    /// Loops that the array could not run.
    fn refused(&self) -> &[Dfg] {
        match self {
            Subject::Program(compiled) => &compiled.refused,
            Subject::Loops(_) => &[],
        }
    }

    fn schedules(&self) -> Vec<&ModuloSchedule> {
        match self {
            Subject::Program(compiled) => compiled.schedule.program.kernels.values().collect(),
            Subject::Loops(loops) => loops.loops.iter().collect(),
        }
    }
}

/// The schedules of a file that `srp map` has written, if it is one.
fn scheduled_loops(paths: &[PathBuf], arch: &Arch) -> Result<Option<ScheduledLoops>, Failure> {
    let [path] = paths else {
        return Ok(None);
    };
    let name = path.display().to_string();
    if !name.ends_with(".sched.xml") {
        return Ok(None);
    }
    let text = files::read_text(path)?;
    if !text.contains("<scheduled-loops") {
        return Ok(None);
    }
    let loops = dre::read_loops(&text, arch)
        .map_err(|e| Failure::Message(format!("{name}:{}:{}: {}", e.line, e.column, e.message)))?;
    for schedule in &loops.loops {
        let wrong = srp_ir::check::check_loop(schedule, &arch.srp);
        if let Some(first) = wrong.first() {
            let kernel = &schedule.dfg.name;
            return Err(Failure::Message(format!("{name}: {kernel}: {first}")));
        }
    }
    Ok(Some(loops))
}

/// Writes the certificate that a loop's II cannot be lower.
fn prove(path: &Path, kernel: Option<&str>, subject: &Subject, arch: &Arch) -> Result<(), Failure> {
    let impossible: Vec<&[Impossible]> = match subject {
        Subject::Program(compiled) => {
            let facts = compiled.schedule.loops.values();
            facts.map(|facts| facts.impossible.as_slice()).collect()
        }
        Subject::Loops(loops) => vec![&[]; loops.loops.len()],
    };
    let schedules = subject.schedules();
    let proved: Vec<Proved<'_>> = (schedules.into_iter().zip(impossible))
        .filter(|(s, _)| kernel.is_none_or(|name| s.dfg.name == name))
        .map(|(s, impossible)| Proved {
            dfg: &s.dfg,
            ii: s.ii,
            impossible,
        })
        .collect();
    proof::write(path, &proved, arch)
}
