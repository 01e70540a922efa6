//! `srp report`

use super::{Change, Report, page, report, text};
use crate::cli;
use crate::failure::Failure;
use crate::pipeline::{self, Compiled, Effort, FrontEnd, Input};
use crate::proof::{self, Proved};
use crate::talk::Progress;
use crate::{files, interrupt, kernels, machine, talk};
use srp_archdesc::arch::Arch;
use srp_scheduler::what_if::what_if;
use std::path::Path;

/// Runs `srp report`. Interrupted, it reports what the loops had reached.
pub(crate) fn run(args: &cli::Report) -> Result<(), Failure> {
    if let Some(path) = &args.html {
        files::check_writable(path)?;
    }
    let arch = machine::read(&args.compilation.machine.machine)?;
    let front_end = FrontEnd::new(&args.compilation.source, &arch);
    let input = if args.files.is_empty() {
        Input::C(kernels::sources())
    } else {
        pipeline::read(&args.files, &arch)?
    };
    let compiled = pipeline::compile(input, &front_end, Effort::of(&args.compilation.search))?;
    if let Some(path) = &args.proof {
        prove(path, args.kernel.as_deref(), &compiled, &arch)?;
    }
    let mut report = report(&compiled, &arch);
    if let Some(kernel) = &args.kernel {
        report.keep_only(kernel)?;
    }
    if args.what_if {
        try_changes(&mut report, &compiled, &arch);
    }
    if let Some(path) = &args.html {
        files::write(path, page(&report).as_bytes())?;
    }
    if args.json {
        let text = serde_json::to_string_pretty(&report).map_err(Failure::message)?;
        talk::print(format!("{text}\n"))?;
    } else {
        talk::print(text(&report))?;
    }
    interrupt::end_if_requested()
}

/// Writes the certificate that a loop's II cannot be lower.
fn prove(
    path: &Path,
    kernel: Option<&str>,
    compiled: &Compiled,
    arch: &Arch,
) -> Result<(), Failure> {
    let schedule = &compiled.schedule;
    let schedules = schedule.program.kernels.values();
    let proved: Vec<Proved<'_>> = schedules
        .zip(schedule.loops.values())
        .filter(|(s, _)| kernel.is_none_or(|name| s.dfg.name == name))
        .map(|(s, facts)| Proved {
            dfg: &s.dfg,
            ii: s.ii,
            impossible: &facts.impossible,
        })
        .collect();
    proof::write(path, &proved, arch)
}

/// Tries changes of the machine for every loop of the report.
fn try_changes(report: &mut Report, compiled: &Compiled, arch: &Arch) {
    let progress = Progress::steps("what if", report.loops.len() as u64);
    for (done, l) in report.loops.iter_mut().enumerate() {
        progress.at(done as u64);
        let kernels = &compiled.schedule.program.kernels;
        let Some(schedule) = kernels.values().find(|s| s.dfg.name == l.kernel) else {
            continue;
        };
        let changes =
            Effort::Steps.with(|options| what_if(&schedule.dfg, arch, schedule.ii, &options));
        let change = |c: srp_scheduler::what_if::Change| Change {
            what: c.what,
            ii: c.ii,
        };
        l.what_if = changes.into_iter().map(change).collect();
    }
}
