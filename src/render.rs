//! `srp render`

use crate::cli::{self, Render};
use crate::failure::Failure;
use crate::fidelity::{Shot, frame_text, sampled_text};
use crate::{compile, files, interrupt, report, scenes, talk};
use srp_runtime::system;
use srp_studies::fidelity::Fidelity;
use srp_toolchain::{Engines, system_options};

/// Runs `srp render`.
pub(crate) fn run(args: &Render) -> Result<(), Failure> {
    files::check_writable(&args.output)?;
    if let Some(report) = &args.report {
        files::check_writable(report)?;
    }
    let loops = report::Loops::to(&args.loops.loops)?;
    let session = &talk::session();
    let frame = scenes::frame(
        &args.frame,
        Some(&args.building),
        args.bvh,
        args.size,
        session,
    )?;
    // A frame that is refused is so before kernels are compiled for it.
    let image = frame.image()?;
    let kernels = args.kernels.as_deref();
    let compiled = interrupt::looked_for(|| frame.build.compile(kernels, &frame.arch, session))?;
    talk::say_all(&compiled.messages.render(talk::colour()));
    compile::say_not_pipelined(&compiled, &frame.arch, false, session)?;
    loops.write(&compiled, &frame.arch, session)?;
    interrupt::end_if_requested()?;

    let program = compiled.runnable()?;
    let engines = Engines::of(program, args.engine, session)?;
    let level = args.level.fidelity;
    if level < Fidelity::Cycle {
        let shot = Shot {
            scene: &frame.scene,
            camera: &frame.scene.camera,
            arch: &frame.arch,
            program,
            engines: &engines,
            image,
            effects: frame.build.effects,
            guard: frame.guard.clone(),
            size: args.size,
            threads: cli::threads(args.threads),
            recorded_hits: false,
        };
        return cheaply(&shot, args);
    }
    let arch = level.machine(&frame.arch);
    let cores = engines.cores(arch.system.cores);
    let options = system_options(program, frame.guard.clone(), system::Timing::Full, session);
    let rendered = interrupt::looked_for(|| system::render(image, cores, &arch, options));
    let (picture, report) = rendered.map_err(Failure::message)?;
    talk::say_shares(&engines);

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
            .filter(|f| shown || f.quantity.is_count())
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
