//! `srp tni`: T&I units alone, fed with rays.

mod document;
mod heat;
mod hits;
mod levels;
mod replay;
mod text;

pub(crate) use document::Document;
pub(crate) use levels::Counts;
pub(crate) use replay::RayDocument;

use crate::cli::{self, HeatOf, RayKind, Tni, TniMemory};
use crate::failure::Failure;
use crate::scenes;
use crate::{files, interrupt, talk};
use srp_archdesc::arch::Arch;
use srp_archdesc::datapath::Latencies;
use srp_archdesc::diagnostic;
use srp_archdesc::system;
use srp_runtime::scene::{Camera, Scene};
use srp_studies::fidelity::Fidelity;
use srp_studies::rays::{self, Kind};
use srp_studies::tni::{Measure, Memories};
use srp_studies::views::{Job, Measured, Rays, ao_radius};
use srp_toolchain::envelope::About;
use srp_toolchain::scene::Views;
use srp_toolchain::{Session, machine};
use std::path::Path;

/// Runs `srp tni`.
pub(crate) fn run(args: &Tni) -> Result<(), Failure> {
    check_arguments(args)?;
    for path in [&args.heat, &args.hits].into_iter().flatten() {
        files::check_writable(path)?;
    }
    let arch = machine_for(args)?;
    let session = &talk::session();
    let views = views(args, session)?;
    let scene = scenes::read(args.scene.as_deref(), first_camera(args, &views)?, session)?;
    let cameras = cameras(args, &views, &scene)?;
    let bvh = srp_toolchain::scene::build(&scene, &args.measuring.tree(args.bvh), session);
    let rays = rays_of(args, &views, &scene)?;
    let job = Job {
        scene: &scene,
        bvh: &bvh,
        spec: &arch.system,
        cameras: &cameras,
        size: args.size,
        rays: &rays,
        order: args.order,
        level: args.level.plain(),
        one_in: args.sample.unwrap_or(1),
        units: args.units.unwrap_or(arch.system.cores),
        memories: match (args.memory, arch.system.dram.shared) {
            (Some(TniMemory::Shared | TniMemory::Both), _) | (None, true) => Memories::Shared,
            (Some(TniMemory::Private), _) | (None, false) => Memories::Private,
        },
        threads: cli::threads(args.measuring.threads),
        costs: args.heat.is_some(),
        keeps_rays: args.hits.is_some(),
        watch: session.watch,
    };
    if let Some(pixel) = args.ray {
        return Ok(talk::print(replay::explain(
            &arch, &job, pixel, args.json,
        )?)?);
    }
    let level = args.level.fidelity;
    if level < Fidelity::Sampled {
        return levels::print(args, &arch, &job);
    }
    let measured = interrupt::looked_for(|| job.measure())?;
    let private = match args.memory {
        Some(TniMemory::Both) => Some(measure_private(&job)?),
        _ => None,
    };
    if let Some(path) = &args.heat {
        let png = heat::picture(&measured.outcomes[0], args.size, args.heat_of)?;
        files::write(path, &png)?;
        talk::say(path.display());
    }
    if let Some(path) = &args.hits {
        files::write(path, hits::table(&measured.outcomes).as_bytes())?;
        talk::say(path.display());
    }
    print_measure(args, &arch, &job, &measured, private.as_ref())
}

/// Refuses arguments that say nothing together.
fn check_arguments(args: &Tni) -> Result<(), Failure> {
    let level = args.level.fidelity;
    let name = level.name();
    let is_file = args.rays == RayKind::File;
    let wrong = match level {
        _ if args.ray_file.is_some() && !is_file => {
            Some("--ray-file is read with --rays file".to_owned())
        }
        _ if args.ray_file.is_none() && is_file => {
            Some("--rays file takes the rays from --ray-file FILE".to_owned())
        }
        _ if args.heat_of != HeatOf::Cycles && args.heat.is_none() => {
            Some("--heat-of says what --heat FILE shows: give a file".to_owned())
        }
        Fidelity::Sampled if args.sample.is_some() => Some(format!(
            "--fidelity {name} chooses for itself how many rays it measures: leave out --sample"
        )),
        Fidelity::Sampled if args.heat.is_some() => Some(format!(
            "--heat shows what every pixel costs, and --fidelity {name} runs some rays: leave one out"
        )),
        Fidelity::Sampled | Fidelity::Functional | Fidelity::Analytic if args.hits.is_some() => {
            Some(format!(
                "--hits writes the cycles of every ray, which --fidelity {name} does not simulate: leave one out"
            ))
        }
        Fidelity::Functional | Fidelity::Analytic if args.heat.is_some() => Some(format!(
            "--heat shows what rays cost, which --fidelity {name} does not simulate: leave one out"
        )),
        Fidelity::Functional | Fidelity::Analytic if args.sample.is_some() => Some(format!(
            "--fidelity {name} takes all rays: leave out --sample"
        )),
        Fidelity::Functional | Fidelity::Analytic if args.memory.is_some() => Some(format!(
            "--fidelity {name} has no memory with units that wait for each other: leave out --memory"
        )),
        _ => None,
    };
    wrong.map_or(Ok(()), |why| Err(Failure::Usage(why)))
}

/// The same with a memory for every unit.
fn measure_private(job: &Job<'_>) -> Result<Measure, Failure> {
    let job = Job {
        memories: Memories::Private,
        costs: false,
        keeps_rays: false,
        ..*job
    };
    Ok(interrupt::looked_for(|| job.measure())?.all)
}

fn print_measure(
    args: &Tni,
    arch: &Arch,
    job: &Job<'_>,
    measured: &Measured,
    private: Option<&Measure>,
) -> Result<(), Failure> {
    if !args.json {
        let text = text::report(arch, job, measured, private);
        return Ok(talk::print(text)?);
    }
    let found = Document::of(args, arch, job, measured, private);
    let about = About::scene(arch, job.scene);
    Ok(talk::print(crate::document::json(about, &found)?)?)
}

/// The machine, with what the command line changes of it.
fn machine_for(args: &Tni) -> Result<Arch, Failure> {
    let mut arch = args.machine.read()?;
    if let Some(pipeline) = args.pipeline {
        arch.system.tni.set_pipeline(match pipeline {
            cli::Pipeline::Single => system::Pipeline::Single,
            cli::Pipeline::Parallel => system::Pipeline::Parallel,
        });
    }
    if let Some(latencies) = args.latencies {
        let latencies = match latencies {
            cli::Latencies::Calibrated => Latencies::Calibrated,
            cli::Latencies::Synthesis65nm => Latencies::Synthesis65nm,
        };
        latencies.apply(&mut arch.system.tni);
    }
    machine::check_system(&arch.name, &arch)?;
    Ok(args.level.fidelity.machine(&arch))
}

/// The viewpoints that the command line names, or that lie beside the scene.
fn views(args: &Tni, session: &Session<'_>) -> Result<Option<Views>, Failure> {
    if args.camera.camera.is_some() {
        return Ok(None);
    }
    let Some(which) = &args.cameras else {
        let beside = |scene| Views::beside(scene, session.outside);
        return Ok(args.scene.as_deref().map_or(Ok(None), beside)?);
    };
    match cli::parse_cameras(which) {
        Some((path, name, None)) => Ok(Some(Views::read(path, name)?)),
        _ => Err(Failure::Usage(format!(
            "--cameras {which}: write FILE.json:NAME, and the view as --views N"
        ))),
    }
}

fn first_camera(args: &Tni, views: &Option<Views>) -> Result<Option<Camera>, Failure> {
    if let Some(text) = &args.camera.camera {
        return Camera::parse(text).map(Some).map_err(Failure::usage);
    }
    Ok(views.as_ref().map(|v| v.camera(0)).transpose()?)
}

/// The cameras to run, one after another.
fn cameras(args: &Tni, views: &Option<Views>, scene: &Scene) -> Result<Vec<Camera>, Failure> {
    match (views, args.views) {
        (None, None | Some(0)) => Ok(vec![scene.camera]),
        (None, Some(n)) => Err(Failure::Message(format!(
            "there is no view {n}: no file of cameras names this scene (see --cameras)"
        ))),
        (Some(views), Some(n)) => Ok(vec![views.camera(n)?]),
        (Some(views), None) => {
            let all = (0..views.points.views.len()).map(|n| views.camera(n));
            Ok(all.collect::<Result<_, _>>()?)
        }
    }
}

/// Returns the rays to trace.
fn rays_of(args: &Tni, views: &Option<Views>, scene: &Scene) -> Result<Rays, Failure> {
    let samples = args.spp;
    Ok(match args.rays {
        RayKind::Primary => Rays::Of(Kind::Primary),
        RayKind::Diffuse => Rays::Of(Kind::Diffuse { samples }),
        RayKind::Ao => {
            let known = views.as_ref().and_then(|v| v.points.ao_radius);
            let radius = args.radius.or(known).unwrap_or_else(|| ao_radius(scene));
            Rays::Of(Kind::AmbientOcclusion { samples, radius })
        }
        RayKind::File => {
            let path = args.ray_file.as_deref().unwrap_or(Path::new(""));
            Rays::Given(read_rays(path)?)
        }
    })
}

fn read_rays(path: &Path) -> Result<Vec<rays::Ray>, Failure> {
    let text = files::read_text(path, files::Kind::Rays)?;
    rays::read(&path.display().to_string(), &text)
        .map_err(|e| Failure::Reported(diagnostic::render(&e, &text, talk::colour())))
}
