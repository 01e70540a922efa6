//! `srp report`

use super::{diff, html, text};
use crate::cli;
use crate::compile::{compile_and_say, say_remarks};
use crate::failure::Failure;
use crate::files::Kind;
use crate::proof::{self, Proved};
use crate::{diagnostics, document, files, interrupt, scenes, talk};
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::Source;
use srp_archdesc::entity::EntityMap;
use srp_ir::dfg::Dfg;
use srp_ir::dre::scheduled::ScheduledLoops;
use srp_ir::program::SourceFile;
use srp_studies::loops::{self, Report, Subject};
use srp_toolchain::envelope::About;
use srp_toolchain::{
    Build, FrameOptions, Input, LeastIi, Options, Session, compile_loops, input, least_iis,
};
use std::path::{Path, PathBuf};

/// Runs `srp report`; 1 where two reports are compared and something got worse. Interrupted, it
/// reports what the loops had reached.
pub(crate) fn run(args: &cli::Report) -> Result<i32, Failure> {
    if let Some([old, new]) = args.diff.as_deref() {
        let read = |path: &Path| -> Result<Source, Failure> {
            let text = files::read_text(path, Kind::Report)?;
            Ok(Source::new(path.display().to_string(), text))
        };
        return compare(&read(old)?, &read(new)?, args.json);
    }
    if let Some(path) = &args.html {
        files::check_writable(path)?;
    }
    if let Some(path) = &args.proof {
        proof::check_writable(path)?;
    }
    let of = &args.of;
    let arch = of.compilation.machine.read()?;
    let session = &talk::session();
    let asked = Asked {
        options: loops::Options {
            kernel: of.kernel.clone(),
            times: args.times,
            what_if: args.what_if,
            machine: args
                .what_if
                .then(|| of.compilation.machine.text())
                .transpose()?,
            restrict: true,
        },
        proof: args.proof.as_deref(),
        bounds: None,
    };
    let report = match scheduled_loops(&of.files, &arch)? {
        Some(scheduled) => asked.report(&Subject::of_loops(&scheduled, &arch), &arch, session)?,
        None => of_program(of, &asked, &arch, session)?,
    };
    if let Some(path) = &args.html {
        files::write(path, html::page(&report).as_bytes())?;
    }
    talk::print(match args.json {
        true => document::json(About::machine(&arch), &report)?,
        false => text::text(&report),
    })?;
    interrupt::end_if_requested()?;
    Ok(0)
}

/// The report of a program's loops. Where only some of them are asked for, no others are scheduled.
pub(super) fn of_program(
    of: &cli::Reported,
    asked: &Asked<'_>,
    arch: &Arch,
    session: &Session<'_>,
) -> Result<Report, Failure> {
    let source = &of.compilation.source;
    let (input, options) = match &of.frame {
        Some(scene) => frame(scene, of, session)?,
        None if of.files.is_empty() => (Input::C(input::kernels()), of.compilation.options()?),
        None => (input::read(&of.files, arch)?, of.compilation.options()?),
    };
    let of_files = of.frame.is_some() && !of.files.is_empty();
    let wanted = |dfg: &Dfg, files: &EntityMap<SourceFile, String>| {
        let file = files.get(dfg.pos.file).map(Path::new);
        let is_of_file = || of.files.iter().any(|path| Some(path.as_path()) == file);
        of.kernel.as_ref().is_none_or(|name| *name == dfg.name) && (!of_files || is_of_file())
    };
    if let (Some(told), Input::C(sources)) = (asked.bounds, &input) {
        // What is wrong with the sources is told with the report.
        if let Ok(bounds) = least_iis(sources, &wanted, arch, &options) {
            told(&bounds);
        }
    }
    let sources = match input {
        Input::C(sources) if of_files || of.kernel.is_some() => sources,
        input => {
            let compiled = compile_and_say(input, arch, &options, source, session)?;
            return asked.report(&Subject::of_program(&compiled), arch, session);
        }
    };
    let compiled =
        interrupt::looked_for(|| compile_loops(&sources, &wanted, arch, &options, session));
    let compiled = compiled.map_err(|e| diagnostics::failure(e, source.error_format))?;
    talk::say_all(&diagnostics::show(&compiled.messages, source.error_format));
    say_remarks(&compiled.files, &compiled.pass_remarks, source)?;
    let mut report = asked.report(&Subject::of_some(&compiled), arch, session)?;
    if of_files {
        let is_of_file = |file: &str| of.files.iter().any(|path| path == Path::new(file));
        report.not_pipelined.retain(|n| is_of_file(&n.at.file));
    }
    Ok(report)
}

/// The kernels of a frame, with files in the place of those of the same name, and how they are compiled.
fn frame(
    scene: &str,
    of: &cli::Reported,
    session: &Session<'_>,
) -> Result<(Input, Options), Failure> {
    let options = of.compilation.options()?;
    let frame = FrameOptions {
        scene: (!scene.is_empty()).then(|| PathBuf::from(scene)),
        fast_math: options.fast_math,
        prefetch: options.prefetch,
        ..FrameOptions::default()
    };
    let (_, build, _) = Build::of_scene(&frame, &mut scenes::say, session)?;
    // Headers beside the files are those of all kernels.
    let folders = of.files.iter().filter_map(|file| file.parent());
    let include = options.include.iter().cloned();
    let include = include.chain(folders.map(Path::to_owned)).collect();
    let of_frame = build.options();
    let defines = of_frame.defines.into_iter().chain(options.defines);
    let options = Options {
        defines: defines.collect(),
        auto_kernel: of_frame.auto_kernel,
        include,
        ..options
    };
    Ok((Input::C(input::kernels_with(&of.files)?), options))
}

/// Who is told the least IIs of loops.
type Told<'a> = &'a dyn Fn(&[LeastIi]);

/// The questions asked about loops.
pub(super) struct Asked<'a> {
    pub(super) options: loops::Options,
    /// Where a certificate goes.
    pub(super) proof: Option<&'a Path>,
    /// Before any is scheduled.
    pub(super) bounds: Option<Told<'a>>,
}

impl Asked<'_> {
    /// The report of scheduled loops, and the certificate that is asked for.
    fn report(
        &self,
        subject: &Subject<'_>,
        arch: &Arch,
        session: &Session<'_>,
    ) -> Result<Report, Failure> {
        if let Some(path) = self.proof {
            let kernel = self.options.kernel.as_deref();
            let loops = subject.loops();
            let wanted = loops.filter(|(s, _)| kernel.is_none_or(|name| s.dfg.name == name));
            let proved = wanted.map(|(schedule, facts)| Proved {
                dfg: &schedule.dfg,
                names: None,
                ii: schedule.ii,
                impossible: &facts.impossible,
            });
            proof::write(path, &proved.collect::<Vec<_>>(), arch, session)?;
        }
        let report = interrupt::looked_for(|| loops::report(subject, arch, &self.options, session));
        Ok(report?)
    }
}

/// Compares two reports; 1 where something got worse.
pub(crate) fn compare(old: &Source, new: &Source, json: bool) -> Result<i32, Failure> {
    let differences = loops::diff(&Report::read(old)?, &Report::read(new)?);
    talk::print(match json {
        true => document::json(About::default(), &differences)?,
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
    let text = files::read_text(path, Kind::Scheduled)?;
    Ok(loops::read_scheduled(&name, &text, arch)?)
}
