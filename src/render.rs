//! `srp render`

use crate::cli::{self, Render, Source as SourceArgs};
use crate::failure::Failure;
use crate::pipeline::{self, Compiled, Effort, FrontEnd, Input};
use crate::scenes::{self, Views};
use crate::talk::{self, Progress};
use crate::{compile, engine, files, interrupt, kernels, machine, report};
use srp_archdesc::arch::Arch;
use srp_runtime::scene::camera::Camera;
use srp_runtime::scene_image;
use srp_runtime::system;
use std::path::{Path, PathBuf};

/// Most SRP cycles of a frame; far beyond any that ends.
const MAX_CYCLES: u64 = 1 << 44;

/// Runs `srp render`.
pub(crate) fn run(args: &Render) -> Result<(), Failure> {
    files::check_writable(&args.output)?;
    if let Some(report) = &args.report {
        files::check_writable(report)?;
    }
    let loops = report::Loops::to(&args.loops.loops)?;
    let arch = machine::read(&args.machine.machine)?;
    let camera = camera(args)?;
    let scene = scenes::read(args.scene.as_deref(), camera)?;
    let compiled = compile_kernels(args.kernels.as_deref(), &arch)?;
    loops.write(&compiled, &arch)?;

    let bvh = scenes::build(&scene, args.bvh, None);
    let program = compiled.runnable()?;
    let cores = engine::cores(program, &arch, args.engine, arch.system.cores)?;
    let image = scene_image::build(&scene, &bvh, &scene.camera, &arch, args.size)
        .map_err(Failure::message)?;
    let progress = Progress::steps("rendering", u64::from(image.tiles));
    let options = system::Options {
        max_cycles: MAX_CYCLES,
        sram_image: &program.image,
        kernel_names: program
            .kernels
            .values()
            .map(|k| k.dfg.name.clone())
            .collect(),
        progress: &mut |p| progress.at(u64::from(p.tiles)),
        cancelled: &interrupt::requested,
    };
    let rendered = interrupt::looked_for(|| system::render(image, cores, &arch, options));
    drop(progress);
    let (picture, report) = rendered.map_err(Failure::message)?;

    if report.complete {
        files::write(&args.output, &picture.png())?;
    }
    let json = || match serde_json::to_string_pretty(&report) {
        Ok(text) => Ok(format!("{text}\n")),
        Err(e) => Err(Failure::message(e)),
    };
    if let Some(path) = &args.report {
        files::write(path, json()?.as_bytes())?;
    }
    talk::print(if args.json { json()? } else { report.text() })?;
    if !report.complete {
        return Err(Failure::Interrupted);
    }
    talk::say(args.output.display());
    Ok(())
}

/// The camera that the command line asks for, if it does.
fn camera(args: &Render) -> Result<Option<Camera>, Failure> {
    if let Some(text) = &args.camera.camera {
        return Camera::parse(text).map(Some).map_err(Failure::message);
    }
    let Some(which) = &args.cameras else {
        return Ok(None);
    };
    let Some((path, name, Some(number))) = scenes::parse_cameras(which) else {
        return Err(Failure::Message(format!(
            "--cameras {which}: write FILE.json:NAME/N"
        )));
    };
    Views::read(path, name)?.camera(number).map(Some)
}

/// Compiles the kernels that come along, or all C files of a folder.
fn compile_kernels(folder: Option<&Path>, arch: &Arch) -> Result<Compiled, Failure> {
    let none = SourceArgs {
        include: Vec::new(),
        define: Vec::new(),
        no_auto_kernel: true,
        double: cli::Double::Soft,
        feature: Vec::new(),
        warnings: Vec::new(),
        remarks: Vec::new(),
        error_format: cli::ErrorFormat::Human,
    };
    let front_end = FrontEnd::new(&none, arch);
    let input = match folder {
        None => Input::C(kernels::sources()),
        Some(folder) => pipeline::read(&c_files(folder)?, arch)?,
    };
    let compiled = pipeline::compile(input, &front_end, Effort::Steps)?;
    compile::say_not_pipelined(&compiled, arch, &none);
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
