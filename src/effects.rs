//! `srp effects`: which effects a scene calls for, why, and what they cost.

mod costs;
mod output;

use crate::cli::{Effects as Args, Source as SourceArgs};
use crate::failure::Failure;
use crate::pipeline::{self, Compiled, Effort, FrontEnd, Input};
use crate::{cli, compile, files, kernels, machine, render, scenes, talk};
use serde::Serialize;
use srp_archdesc::arch::Arch;
use srp_runtime::effect::{self, Effects};
use srp_runtime::scene::Scene;
use srp_scheduler::Known;
use std::path::{Path, PathBuf};

/// What there is to say of a scene.
#[derive(Serialize)]
struct Report {
    /// Its name.
    scene: String,
    /// Its triangles.
    triangles: usize,
    /// Key of the simulator that is built for what the scene calls for.
    key: String,
    /// Names of the effects that it is built for.
    built: Vec<&'static str>,
    effects: Vec<Line>,
    /// Pixels of the frames that were measured.
    size: (u32, u32),
    /// Simulators by what they are built for, where they were measured.
    simulators: Vec<costs::Measured>,
}

/// One effect.
#[derive(Serialize)]
struct Line {
    effect: &'static str,
    what: &'static str,
    /// Whether the scene calls for it.
    on: bool,
    /// Whether the simulator is built for it.
    built: bool,
    /// The witness.
    why: String,
    /// What it costs in a frame, where that was measured.
    cost: Option<costs::Cost>,
}

/// Runs `srp effects`.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    if let Some(html) = &args.html {
        files::check_writable(html)?;
    }
    let arch = machine::read(&args.machine.machine)?;
    let camera = render::camera(&args.camera, args.cameras.as_deref())?;
    let mut scene = scenes::read(args.scene.as_deref(), camera)?;
    scenes::set_up(&mut scene, &args.shading)?;
    let (built, _) = scenes::effects(&scene, args.shading.effects.as_deref())?;
    let mut report = Report {
        scene: scene.name.clone(),
        triangles: scene.triangles.len(),
        key: key(built, scene.options.bounces, &arch),
        built: built.iter().map(effect::Effect::name).collect(),
        effects: lines(&scene, built),
        size: args.size,
        simulators: Vec::new(),
    };
    if !args.no_costs {
        costs::measure(&mut report, &scene, built, &arch, args)?;
    }
    if let Some(html) = &args.html {
        files::write(html, output::page(&report).as_bytes())?;
        talk::say(html.display());
    }
    match args.json {
        true => {
            let text = serde_json::to_string_pretty(&report).map_err(Failure::message)?;
            talk::print(format!("{text}\n"))?;
        }
        false => talk::print(output::text(&report))?,
    }
    Ok(())
}

fn lines(scene: &Scene, built: Effects) -> Vec<Line> {
    let findings = effect::find(scene).into_iter();
    let line = |finding: effect::Finding| Line {
        effect: finding.effect.name(),
        what: finding.effect.entry().what,
        on: finding.on,
        built: built.contains(finding.effect),
        why: finding.why,
        cost: None,
    };
    findings.map(line).collect()
}

/// Names a simulator: another for other effects, another room for rays, another machine and another
/// version of the tools (FNV-1a of all that).
fn key(built: Effects, bounces: u32, arch: &Arch) -> String {
    let machine = srp_archdesc::xml::write(arch);
    let text = format!("{} {built} {bounces} {machine}", env!("CARGO_PKG_VERSION"));
    let hash = text.bytes().fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{hash:016x}")
}

/// Compiles the kernels that come along, or all C files of a folder, for some effects and for so
/// many secondary rays in a row. Loops that are known are not scheduled again.
pub(crate) fn compile_kernels(
    folder: Option<&Path>,
    arch: &Arch,
    built: Effects,
    bounces: u32,
    known: &Known,
) -> Result<Compiled, Failure> {
    let mut define: Vec<String> = built.defines().map(|(n, v)| format!("{n}={v}")).collect();
    define.push(format!("SRP_BOUNCES={}", bounces.max(1)));
    let source = SourceArgs {
        include: Vec::new(),
        define,
        no_auto_kernel: true,
        double: cli::Double::Soft,
        feature: Vec::new(),
        warnings: Vec::new(),
        remarks: Vec::new(),
        error_format: cli::ErrorFormat::Human,
    };
    let front_end = FrontEnd::new(&source, arch);
    let input = match folder {
        None => Input::C(kernels::sources()),
        Some(folder) => pipeline::read(&c_files(folder)?, arch)?,
    };
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
