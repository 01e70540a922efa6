//! `srp accuracy FILE.c` and `FILE.fpcore`: the error of a kernel over ranges of its inputs, and what
//! it costs.

mod page;
mod text;

use crate::cli::Accuracy as Args;
use crate::failure::Failure;
use crate::files::Kind;
use crate::{document, files, interrupt, talk};
use schemars::JsonSchema;
use serde::Serialize;
use srp_studies::kernel::{self, Report, Studied};
use srp_toolchain::Session;
use srp_toolchain::envelope::{About, Contents};
use std::collections::BTreeSet;
use std::path::Path;

/// The kernels of a file.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Kernels<'a> {
    /// Those that were studied.
    kernels: &'a [Report],
    /// Why the others were not.
    refused: &'a [String],
}

impl Contents for Kernels<'_> {
    const FORMAT: &'static str = "srp-kernel-accuracy";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp accuracy FILE.c --json` and `FILE.fpcore`";
}

/// Studies the kernels of a file.
pub(super) fn run(path: &Path, args: &Args, session: &Session<'_>) -> Result<(), Failure> {
    let arch = args.frame.machine.read()?;
    let about = About::machine(&arch);
    let study = args.study(arch)?;
    let source = files::read_source(path, Kind::Source)?;
    if let Some(folder) = &args.output {
        files::make_folder(folder)?;
        files::check_writable(&folder.join("report.html"))?;
    }
    let studied = interrupt::looked_for(|| kernel::study(&source, &study, session))?;
    let Studied { reports, refused } = studied;
    for why in &refused {
        talk::complain(format_args!("warning: {why}"));
    }
    if reports.is_empty() {
        return Err(Failure::Interrupted);
    }
    let found = Kernels {
        kernels: &reports,
        refused: &refused,
    };
    let json = document::json(about, &found)?;
    if let Some(folder) = &args.output {
        for report in &reports {
            write_machines(folder, report)?;
        }
        files::write(&folder.join("report.html"), page::page(&reports).as_bytes())?;
        files::write(&folder.join("report.json"), json.as_bytes())?;
        talk::say(folder.join("report.html").display());
    }
    talk::print(if args.json {
        json
    } else {
        text::text(&reports)
    })?;
    match reports.iter().all(|r| r.complete) {
        true => Ok(()),
        false => Err(Failure::Interrupted),
    }
}

/// The trials that are worth a line: the machine as it is, the fronts, and the cheapest.
fn shown(report: &Report) -> Vec<usize> {
    let fronts = [
        &report.front_cycles,
        &report.front_area,
        &report.front_energy,
    ];
    let all: BTreeSet<usize> = (fronts.into_iter().flatten().copied())
        .chain([0])
        .chain(report.cheapest)
        .collect();
    let mut shown: Vec<usize> = all.into_iter().collect();
    let bits = |i: usize| report.trials[i].error.bits;
    shown[1..].sort_by(|&a, &b| bits(a).total_cmp(&bits(b)).then(a.cmp(&b)));
    shown
}

/// The marks of a trial: the fronts that it is on, and whether it is the cheapest.
fn marks(report: &Report, i: usize) -> String {
    let fronts = [
        (&report.front_cycles, 'c'),
        (&report.front_area, 'a'),
        (&report.front_energy, 'e'),
    ];
    let on = fronts.into_iter().filter(|(front, _)| front.contains(&i));
    let mut marks: String = on.map(|(_, mark)| mark).collect();
    if report.cheapest == Some(i) {
        marks.push('<');
    }
    marks
}

/// The name of a trial's machine file.
fn machine_name(report: &Report, i: usize) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    let name: String = report.name.chars().map(letter).collect();
    format!("{name}-{i}.xml")
}

/// Writes the machine of every trial that is shown, ready for `--machine`.
fn write_machines(folder: &Path, report: &Report) -> Result<(), Failure> {
    for i in shown(report) {
        if let Some(arch) = report.trials[i].machine() {
            let text = srp_archdesc::xml::write(arch);
            files::write(&folder.join(machine_name(report, i)), text.as_bytes())?;
        }
    }
    Ok(())
}
