//! `srp report`

use super::{diff, html, output, text};
use crate::cli;
use crate::compile::compile_and_say;
use crate::failure::Failure;
use crate::proof::{self, Proved};
use crate::{files, interrupt, talk};
use srp_archdesc::arch::Arch;
use srp_ir::dre::scheduled::ScheduledLoops;
use srp_studies::loops::{self, Options, Report, Subject};
use srp_toolchain::{Input, Session, input, machine};
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
    let session = &talk::session();
    let report = match scheduled_loops(&args.files, &arch)? {
        Some(scheduled) => report(&Subject::of_loops(&scheduled, &arch), args, &arch, session)?,
        None => {
            let input = match args.files.is_empty() {
                true => Input::C(input::kernels()),
                false => input::read(&args.files, &arch)?,
            };
            let options = args.compilation.options()?;
            let source = &args.compilation.source;
            let compiled = compile_and_say(input, &arch, &options, source, session)?;
            report(&Subject::of_program(&compiled), args, &arch, session)?
        }
    };
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

/// The report of scheduled loops, and the certificate that is asked for.
fn report(
    subject: &Subject<'_>,
    args: &cli::Report,
    arch: &Arch,
    session: &Session<'_>,
) -> Result<Report, Failure> {
    if let Some(path) = &args.proof {
        let kernel = args.kernel.as_deref();
        let loops = subject.loops();
        let wanted = loops.filter(|(s, _)| kernel.is_none_or(|name| s.dfg.name == name));
        let proved = wanted.map(|(schedule, facts)| Proved {
            dfg: &schedule.dfg,
            ii: schedule.ii,
            impossible: &facts.impossible,
        });
        proof::write(path, &proved.collect::<Vec<_>>(), arch, session)?;
    }
    let options = Options {
        kernel: args.kernel.clone(),
        times: args.times,
        what_if: args.what_if,
    };
    let report = interrupt::looked_for(|| loops::report(subject, arch, &options, session));
    Ok(report?)
}

/// Compares two reports; 1 where something got worse.
fn compare(old: &Path, new: &Path, json: bool) -> Result<i32, Failure> {
    let read = |path: &Path| -> Result<Report, Failure> {
        let text = files::read_text(path)?;
        Ok(Report::read(&path.display().to_string(), &text)?)
    };
    let differences = loops::diff(&read(old)?, &read(new)?);
    talk::print(match json {
        true => output::json(&differences)?,
        false => diff::text(&differences),
    })?;
    Ok(i32::from(differences.is_worse()))
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
    Ok(loops::read_scheduled(&name, &text, arch)?)
}
