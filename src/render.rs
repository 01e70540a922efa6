//! `srp render`

use crate::cli::{self, Render};
use crate::failure::Failure;
use crate::fidelity::{Shot, frame_text, sampled_text};
use crate::scenes::{self, Frame, Views};
use crate::talk;
use crate::{engine, files, interrupt, report, variant};
use srp_runtime::fidelity::Fidelity;
use srp_runtime::scene::camera::Camera;
use srp_runtime::scene_image;
use srp_runtime::system::{self, sampled::is_count};
use srp_scheduler::Known;

/// Most SRP cycles of a frame; far beyond any that ends.
pub(crate) const MAX_CYCLES: u64 = 1 << 44;

/// Runs `srp render`.
pub(crate) fn run(args: &Render) -> Result<(), Failure> {
    files::check_writable(&args.output)?;
    if let Some(report) = &args.report {
        files::check_writable(report)?;
    }
    let loops = report::Loops::to(&args.loops.loops)?;
    let frame = Frame::read(&args.frame)?;
    let (arch, scene, guard) = (frame.arch, frame.scene, frame.guard);
    let folder = args.kernels.as_deref();
    let build = variant::Build::new(frame.effects, scene.options.bounces).asked(&args.building)?;
    let bvh = scenes::build(&scene, args.bvh, None);
    // A frame that is refused is so before kernels are compiled for it.
    let image = scene_image::build(&scene, &bvh, &scene.camera, &arch, args.size)
        .map_err(Failure::message)?;
    let known = Known::default();
    // What was kept says nothing of how its loops were scheduled.
    let compiled = match folder {
        None if args.loops.loops.is_empty() => variant::kept(&arch, &build, &known)?,
        folder => variant::compile_kernels(folder, &arch, &build, &known)?,
    };
    loops.write(&compiled, &arch)?;

    let program = compiled.runnable()?;
    let factory = engine::Factory::of(program, &arch, args.engine)?;
    let level = args.level.fidelity;
    if level < Fidelity::Cycle {
        let shot = Shot {
            scene: &scene,
            camera: &scene.camera,
            arch: &arch,
            program,
            factory: &factory,
            image,
            effects: frame.effects,
            guard,
            size: args.size,
            threads: cli::threads(args.threads),
            recorded_hits: false,
        };
        return cheaply(&shot, args);
    }
    let arch = level.machine(&arch);
    let cores = factory.cores(arch.system.cores);
    let options = system::Options {
        guard,
        timing: system::Timing::Full,
        max_cycles: MAX_CYCLES,
        sram_image: &program.image,
        kernel_names: program
            .kernels
            .values()
            .map(|k| k.dfg.name.clone())
            .collect(),
        watch: &talk::CONSOLE,
    };
    let rendered = interrupt::looked_for(|| system::render(image, cores, &arch, options));
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

/// A frame at a level without an account of every cycle.
fn cheaply(shot: &Shot<'_>, args: &Render) -> Result<(), Failure> {
    let level = args.level.fidelity;
    let pretty =
        |value: serde_json::Result<String>| value.map(|text| text + "\n").map_err(Failure::message);
    let (json, text) = if level == Fidelity::Sampled {
        let (sampled, _) = shot.sampled(args.level.seed, args.level.error)?;
        let json = pretty(serde_json::to_string_pretty(&sampled))?;
        (json, sampled_text(&sampled, shot.size))
    } else {
        let whole = shot.whole(level)?;
        files::write(&args.output, &whole.picture.png())?;
        let shown = level == Fidelity::Analytic;
        let figures: Vec<_> = (whole.figures.iter())
            .filter(|f| shown || is_count(&f.name))
            .collect();
        let json = serde_json::json!({ "fidelity": level.name(), "figures": figures });
        let json = pretty(serde_json::to_string_pretty(&json))?;
        (json, frame_text(level, shot.size, &whole.figures))
    };
    if let Some(path) = &args.report {
        files::write(path, json.as_bytes())?;
    }
    talk::print(if args.json { json } else { text })?;
    match level {
        Fidelity::Sampled => {
            talk::say("note: a sample has no picture; --fidelity functional makes the whole one")
        }
        _ => talk::say(args.output.display()),
    }
    Ok(())
}

/// The camera that the command line asks for, if it does.
pub(crate) fn camera(own: &cli::Camera, cameras: Option<&str>) -> Result<Option<Camera>, Failure> {
    if let Some(text) = &own.camera {
        return Camera::parse(text).map(Some).map_err(Failure::message);
    }
    let Some(which) = cameras else {
        return Ok(None);
    };
    let Some((path, name, Some(number))) = scenes::parse_cameras(which) else {
        return Err(Failure::Message(format!(
            "--cameras {which}: write FILE.json:NAME/N"
        )));
    };
    Views::read(path, name)?.camera(number).map(Some)
}
