//! `srp render`

use crate::cli::{BvhBuilder, Render, Source as SourceArgs};
use crate::failure::Failure;
use crate::pipeline::{self, Compiled, FrontEnd, Input};
use crate::talk::{self, Progress};
use crate::{compile, engine, files, kernels, machine};
use srp_archdesc::arch::Arch;
use srp_runtime::bvh::{self, Builder};
use srp_runtime::scene::camera::{Camera, Viewpoints};
use srp_runtime::scene::{self, Scene};
use srp_runtime::scene_image;
use srp_runtime::system::{self, SystemError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Most SRP cycles of a frame; far beyond any that ends.
const MAX_CYCLES: u64 = 1 << 44;

/// Runs `srp render`.
pub(crate) fn run(args: &Render) -> Result<(), Failure> {
    files::check_writable(&args.output)?;
    if let Some(report) = &args.report {
        files::check_writable(report)?;
    }
    let arch = machine::read(&args.machine.machine)?;
    let camera = camera(args)?;
    let scene = read_scene(args.scene.as_deref(), camera)?;
    let compiled = compile_kernels(args.kernels.as_deref(), &arch)?;

    let builder = match args.bvh {
        BvhBuilder::Sweep => Builder::Sweep,
        BvhBuilder::SweepReinsertion => Builder::SweepReinsertion,
        BvhBuilder::Ploc => Builder::Ploc,
    };
    let spinner = Progress::spinner("building the BVH");
    let options = bvh::Options {
        builder,
        ..bvh::Options::default()
    };
    let bvh = bvh::build(&scene.triangles, &options);
    drop(spinner);
    if bvh.fell_back {
        eprintln!("note: the tree was too deep for the T&I unit; the sweep's is used instead");
    }
    eprintln!(
        "{} triangles, BVH by {}: SAH cost {:.1}, {} levels",
        scene.triangles.len(),
        builder.name(),
        bvh.sah_cost(options.traversal_cost),
        bvh.depth()
    );

    let program = &compiled.schedule.program;
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
        cancelled: &talk::interrupted,
    };
    let rendered = system::render(image, cores, &arch, options);
    drop(progress);
    let (picture, report) = match rendered {
        Ok(rendered) => rendered,
        Err(SystemError::Cancelled) => return Err(Failure::Interrupted),
        Err(error) => return Err(Failure::message(error)),
    };

    files::write(&args.output, &picture.png())?;
    let json = || serde_json::to_string_pretty(&report).map_err(Failure::message);
    if let Some(path) = &args.report {
        files::write(path, format!("{}\n", json()?).as_bytes())?;
    }
    if args.json {
        println!("{}", json()?);
    } else {
        print!("{}", report.text());
    }
    eprintln!("{}", args.output.display());
    Ok(())
}

/// The camera that the command line asks for, if it does.
fn camera(args: &Render) -> Result<Option<Camera>, Failure> {
    if let Some(text) = &args.camera {
        return Camera::parse(text).map(Some).map_err(Failure::message);
    }
    let Some(which) = &args.cameras else {
        return Ok(None);
    };
    let form = || Failure::Message(format!("--cameras {which}: write FILE.json:NAME/N"));
    let (path, view) = which.rsplit_once(':').ok_or_else(form)?;
    let (name, number) = view.rsplit_once('/').ok_or_else(form)?;
    let number: usize = number.parse().map_err(|_| form())?;
    let text = files::read_text(Path::new(path))?;
    let at =
        |e: serde_json::Error| Failure::Message(format!("{path}:{}:{}: {e}", e.line(), e.column()));
    let scenes: BTreeMap<String, serde_json::Value> = serde_json::from_str(&text).map_err(at)?;
    let Some(scene) = scenes.get(name) else {
        let known: Vec<&str> = scenes
            .iter()
            .filter(|(_, v)| v.is_object())
            .map(|(k, _)| k.as_str())
            .collect();
        return Err(Failure::Message(format!(
            "{path}: there is no scene `{name}`; there are {}",
            known.join(", ")
        )));
    };
    let views: Viewpoints = serde_json::from_value(scene.clone())
        .map_err(|e| Failure::Message(format!("{path}: scene `{name}`: {e}")))?;
    views
        .camera(number)
        .map(Some)
        .map_err(|e| Failure::Message(format!("{path}: {name}: {e}")))
}

fn read_scene(path: Option<&Path>, camera: Option<Camera>) -> Result<Scene, Failure> {
    let Some(path) = path else {
        let mut scene = scene::demo::demo();
        if let Some(camera) = camera {
            scene.camera = camera;
        }
        return Ok(scene);
    };
    let spinner = Progress::spinner("reading the scene");
    let loaded = scene::read(path, camera, &mut |path| std::fs::read(path));
    drop(spinner);
    match loaded {
        Ok(loaded) => {
            eprint!("{}", loaded.warnings.render(talk::colour()));
            Ok(loaded.scene)
        }
        Err(messages) => Err(Failure::Reported(messages.render(talk::colour()))),
    }
}

/// Compiles the kernels that come along, or all C files of a folder.
fn compile_kernels(folder: Option<&Path>, arch: &Arch) -> Result<Compiled, Failure> {
    let none = SourceArgs {
        include: Vec::new(),
        define: Vec::new(),
        no_auto_kernel: true,
    };
    let front_end = FrontEnd::new(&none, arch);
    let input = match folder {
        None => Input::C(kernels::sources()),
        Some(folder) => pipeline::read(&c_files(folder)?, arch)?,
    };
    let compiled = pipeline::compile(input, &front_end)?;
    compile::say_not_pipelined(&compiled, arch);
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
