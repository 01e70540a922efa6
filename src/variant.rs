//! Variants of the kernels: programs that are built for some effects and in some forms, and where
//! they are kept.

use crate::cli::{self, Source as SourceArgs};
use crate::failure::Failure;
use crate::pipeline::{self, Compiled, Effort, FrontEnd, Input};
use crate::{compile, files, kernels};
use srp_archdesc::arch::Arch;
use srp_ir::program::Program;
use srp_kernels::form::Forms;
use srp_runtime::effect::Effects;
use srp_scheduler::Known;
use std::path::{Path, PathBuf};

/// What the program of a frame is built for, besides the machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Build {
    /// Effects that the kernels have.
    pub(crate) effects: Effects,
    /// Secondary rays in a row that there is room for.
    pub(crate) bounces: u32,
    /// How the kernels compute what can be computed in several ways.
    pub(crate) forms: Forms,
    /// What the compiler may do besides (`-f`).
    pub(crate) features: Vec<cli::Feature>,
}

impl Build {
    /// Kernels in their usual forms, compiled as usual.
    pub(crate) fn new(effects: Effects, bounces: u32) -> Build {
        Build {
            effects,
            bounces,
            forms: Forms::default(),
            features: Vec::new(),
        }
    }

    /// The same as the command line says.
    pub(crate) fn asked(self, args: &cli::Building) -> Result<Build, Failure> {
        let choose = |forms: Forms, choice: &String| forms.with(choice).map_err(Failure::message);
        Ok(Build {
            forms: args.form.iter().try_fold(self.forms, choose)?,
            features: args.feature.clone(),
            ..self
        })
    }

    /// All of it as text.
    fn text(&self) -> String {
        let features: Vec<String> = self.features.iter().map(cli::Feature::name).collect();
        let (effects, bounces, forms) = (self.effects, self.bounces, self.forms);
        format!("{effects} {bounces} {forms} {}", features.join(","))
    }
}

/// Names a simulator: another for another build, another machine and another version of the tools.
pub(crate) fn key(build: &Build, arch: &Arch) -> String {
    let machine = srp_archdesc::xml::write(arch);
    hash(&format!(
        "{} {} {machine}",
        env!("CARGO_PKG_VERSION"),
        build.text()
    ))
}

/// A name for a text, by FNV-1a.
pub(crate) fn hash(text: &str) -> String {
    let hash = text.bytes().fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{hash:016x}")
}

/// When the tools were made, as a name; `None` where they do not know.
pub(crate) fn tools() -> Option<String> {
    let tools = std::env::current_exe().and_then(std::fs::metadata).ok()?;
    let made = tools.modified().ok()?;
    let made = made.duration_since(std::time::UNIX_EPOCH).ok()?.as_nanos();
    Some(format!("{made:x}"))
}

/// The same for the kernels that come along, scheduled: as soon as it is known, what a simulator is
/// generated from is read and not looked for again. Whoever builds the tools anew has other ones.
pub(crate) fn kept(arch: &Arch, build: &Build, known: &Known) -> Result<Compiled, Failure> {
    let Some(path) = place(build, arch) else {
        return compile_kernels(None, arch, build, known);
    };
    if path.is_file()
        && let Ok(input) = pipeline::read(std::slice::from_ref(&path), arch)
        && let Ok(compiled) = compile_input(input, arch, build, known)
    {
        return Ok(compiled);
    }
    let compiled = compile_kernels(None, arch, build, known)?;
    if compiled.not_pipelined.is_empty() {
        let text = srp_ir::dre::write_scheduled(&compiled.schedule.program, arch);
        // What cannot be kept is made again.
        let folder = path.parent().unwrap_or(Path::new(""));
        let _ = files::make_folder(folder).and_then(|()| files::write(&path, text.as_bytes()));
    }
    Ok(compiled)
}

/// Where the program is kept; nowhere, where the tools do not know when they were made.
fn place(build: &Build, arch: &Arch) -> Option<PathBuf> {
    let name = format!("{}-{}.sched.xml", key(build, arch), tools()?);
    Some(files::cache_folder().join("frame").join(name))
}

/// Compiles the kernels that come along, or all C files of a folder. Loops that are known are not scheduled again.
pub(crate) fn compile_kernels(
    folder: Option<&Path>,
    arch: &Arch,
    build: &Build,
    known: &Known,
) -> Result<Compiled, Failure> {
    let input = match folder {
        None => Input::C(kernels::sources()),
        Some(folder) => pipeline::read(&c_files(folder)?, arch)?,
    };
    compile_input(input, arch, build, known)
}

/// The kernels that come along, as they are before they are divided and scheduled: what they mean,
/// and not when.
pub(crate) fn program(arch: &Arch, build: &Build) -> Result<Program, Failure> {
    let source = source(build);
    let front_end = FrontEnd::new(&source, arch);
    let program = front_end.compile(&kernels::sources())?;
    Ok(front_end.optimise(program))
}

/// What the command line of a build would be.
fn source(build: &Build) -> SourceArgs {
    let defines = build.effects.defines().chain(build.forms.defines());
    let mut define: Vec<String> = defines.map(|(n, v)| format!("{n}={v}")).collect();
    define.push(format!("SRP_BOUNCES={}", build.bounces.max(1)));
    SourceArgs {
        include: Vec::new(),
        define,
        no_auto_kernel: true,
        double: cli::Double::Soft,
        feature: build.features.clone(),
        warnings: Vec::new(),
        remarks: Vec::new(),
        error_format: cli::ErrorFormat::Human,
    }
}

fn compile_input(
    input: Input,
    arch: &Arch,
    build: &Build,
    known: &Known,
) -> Result<Compiled, Failure> {
    let source = source(build);
    let front_end = FrontEnd::new(&source, arch);
    let compiled = pipeline::compile_knowing(input, &front_end, Effort::Steps, known)?;
    compile::say_not_pipelined(&compiled, arch, &source);
    Ok(compiled)
}

/// The C files of a folder, by name.
fn c_files(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let error = |e: std::io::Error| {
        Failure::Message(format!("cannot read the folder {}: {e}", folder.display()))
    };
    let entries: Result<Vec<_>, _> = std::fs::read_dir(folder).map_err(error)?.collect();
    let mut paths: Vec<PathBuf> = entries.map_err(error)?.iter().map(|e| e.path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == "c"));
    paths.sort();
    if paths.is_empty() {
        return Err(Failure::Message(format!(
            "there is no C file in {}",
            folder.display()
        )));
    }
    Ok(paths)
}
