//! `srp paper`: the figures of the SGRT paper's Tables 3 to 6, ours, and their ratios.
//!
//! The paper's figures are only printed and compared with; nothing in the model knows them.

mod figures;
mod frames;
mod sheet;

use crate::cli;
use crate::failure::Failure;
use crate::scenes;
use crate::talk;
use crate::tni::{self, Job, Rays, measure_at};
use figures::{Figures, PAPER, PaperScene, Table5};
use sheet::Sheet;
use srp_archdesc::arch::Arch;
use srp_runtime::bvh::Builder;
use srp_runtime::bvh::Bvh;
use srp_runtime::scene::{Camera, Scene};
use srp_studies::fidelity::Fidelity;
use srp_studies::rays::{Kind, Order};
use srp_studies::tni::{Measure, Memories};
use srp_toolchain::scene::Views;
use srp_toolchain::{Session, machine};
use std::path::{Path, PathBuf};

/// Secondary rays a pixel, as in the paper.
const SAMPLES: u32 = 32;

/// One scene to compare on.
struct Case {
    scene: Scene,
    bvh: Bvh,
    cameras: Vec<Camera>,
    radius: f32,
    paper: Option<&'static PaperScene>,
}

/// Runs `srp paper`.
pub(crate) fn run(args: &cli::Paper) -> Result<(), Failure> {
    let level = args.level.fidelity;
    if level < Fidelity::Sampled {
        return Err(Failure::Usage(format!(
            "the tables are of cycles, which the level {} does not simulate: --fidelity sampled, cycle \
             or cycle+dram",
            level.name()
        )));
    }
    if level == Fidelity::Sampled && (args.sample.is_some() || args.sample_primary.is_some()) {
        return Err(Failure::Usage(
            "--fidelity sampled, which is what is used where nothing else is said, chooses for itself how \
             many rays it measures: leave out --sample and --sample-primary, or say --fidelity cycle+dram"
                .to_owned(),
        ));
    }
    let arch = level.machine(&machine::read(&args.machine.machine)?);
    machine::check_system(&arch.name, &arch)?;
    let session = &talk::session();
    let mut sheet = Sheet::new(args.json);
    for (i, path) in scenes(args)?.iter().enumerate() {
        let case = case(path.as_deref(), args, session)?;
        if i == 0 {
            head(args, &arch, &mut sheet)?;
        }
        sheet.scene(name(&case))?;
        match args.table {
            cli::Table::Table3 => frames::table3(&case, args, &arch, &mut sheet, session)?,
            cli::Table::Table4 => table4(&case, args, &arch, &mut sheet)?,
            cli::Table::Table5 => table5(&case, args, &arch, &mut sheet)?,
            cli::Table::Table6 => frames::table6(&case, args, &arch, &mut sheet, session)?,
        }
    }
    sheet.finish(args.table.name())
}

/// The scenes of the command line; without any, the default scene.
fn scenes(args: &cli::Paper) -> Result<Vec<Option<PathBuf>>, Failure> {
    if args.scenes.is_empty() {
        talk::say(format_args!(
            "note: no scene is given, so the default scene is used, which the paper has not"
        ));
        return Ok(vec![None]);
    }
    Ok(args.scenes.iter().cloned().map(Some).collect())
}

fn case(path: Option<&Path>, args: &cli::Paper, session: &Session<'_>) -> Result<Case, Failure> {
    let views = path.map_or(Ok(None), Views::beside)?;
    let first = views.as_ref().map(|v| v.camera(0)).transpose()?;
    let scene = scenes::read(path, first, session)?;
    let cameras = match &views {
        Some(views) => {
            let all = (0..views.points.views.len()).map(|n| views.camera(n));
            all.collect::<Result<_, _>>()?
        }
        None => vec![scene.camera],
    };
    let known = views.as_ref().and_then(|v| v.points.ao_radius);
    let stem = path.and_then(Path::file_stem).and_then(|n| n.to_str());
    Ok(Case {
        bvh: srp_toolchain::scene::build(&scene, &args.measuring.tree(Builder::Sweep), session),
        radius: known.unwrap_or_else(|| tni::ao_radius(&scene)),
        paper: stem.and_then(|stem| PAPER.iter().find(|p| p.name.eq_ignore_ascii_case(stem))),
        scene,
        cameras,
    })
}

fn name(case: &Case) -> String {
    let triangles = case.scene.triangles.len();
    let views = case.cameras.len();
    match case.paper {
        Some(_) => format!(
            "{}, {triangles} triangles, {views} view(s)",
            case.scene.name
        ),
        None => format!(
            "{}, {triangles} triangles, {views} view(s); not one of the paper's scenes",
            case.scene.name
        ),
    }
}

fn head(args: &cli::Paper, arch: &Arch, sheet: &mut Sheet) -> Result<(), Failure> {
    let (width, height) = args.size();
    if matches!(args.table, cli::Table::Table3 | cli::Table::Table6) {
        let name = &arch.name;
        return sheet.heading(format!("machine `{name}`, {width}x{height} pixels"));
    }
    if args.level.fidelity == Fidelity::Sampled {
        return sheet.heading(format!(
            "machine `{}`, {}x{} pixels, {SAMPLES} samples, sampled until drawing leaves cycles {} %",
            arch.name,
            width,
            height,
            100.0 * args.level.error
        ));
    }
    let (secondary, primary) = args.one_in();
    sheet.heading(format!(
        "machine `{}`, {}x{} pixels, {SAMPLES} samples, primary rays one run in {}, others one in {}",
        arch.name, width, height, primary, secondary
    ))
}

/// The three kinds of rays.
fn kinds(case: &Case) -> [Kind; 3] {
    [
        Kind::Primary,
        Kind::AmbientOcclusion {
            samples: SAMPLES,
            radius: case.radius,
        },
        Kind::Diffuse { samples: SAMPLES },
    ]
}

/// The settings that vary between measurements.
#[derive(Clone, Copy)]
struct How {
    units: u32,
    memories: Memories,
    order: Order,
}

/// Measures one kind of rays over all views.
fn run_kind(
    case: &Case,
    kind: Kind,
    args: &cli::Paper,
    arch: &Arch,
    how: How,
) -> Result<Measure, Failure> {
    let one_in = match kind {
        Kind::Primary => args.one_in().1,
        _ => args.one_in().0,
    };
    let job = Job {
        scene: &case.scene,
        bvh: &case.bvh,
        spec: &arch.system,
        cameras: &case.cameras,
        size: args.size(),
        rays: &Rays::Of(kind),
        order: how.order,
        one_in,
        units: how.units,
        memories: how.memories,
        threads: cli::threads(args.measuring.threads),
        costs: false,
    };
    Ok(measure_at(&job, &args.level)?.all)
}

fn title(kind: Kind) -> &'static str {
    match kind {
        Kind::Primary => "primary",
        Kind::AmbientOcclusion { .. } => "AO",
        Kind::Diffuse { .. } => "diffuse",
    }
}

/// The paper's figures for a kind of rays.
fn paper(case: &Case, kind: Kind) -> Option<&'static Figures> {
    case.paper.map(|p| match kind {
        Kind::Primary => &p.primary,
        Kind::AmbientOcclusion { .. } => &p.ao,
        Kind::Diffuse { .. } => &p.diffuse,
    })
}

/// Table 4: one unit, both forms of the traversal unit.
fn table4(case: &Case, args: &cli::Paper, arch: &Arch, sheet: &mut Sheet) -> Result<(), Failure> {
    let mut gains = Vec::new();
    let how = How {
        units: 1,
        memories: Memories::Private,
        order: args.order,
    };
    for kind in kinds(case) {
        let of = |pipeline| {
            let mut arch = arch.clone();
            tni::set_pipeline(&mut arch.system, Some(pipeline));
            run_kind(case, kind, args, &arch, how)
        };
        let single = of(cli::Pipeline::Single)?;
        let parallel = of(cli::Pipeline::Parallel)?;
        let p = paper(case, kind);
        sheet.group(title(kind), parallel.relative_error)?;
        sheet.line(
            "steps a ray, single: sub-pipelines",
            p.map(|p| p.steps_sp),
            single.passes,
        )?;
        sheet.line(
            "steps a ray, parallel: node visits",
            p.map(|p| p.steps_pp),
            parallel.inner_visits + parallel.leaf_visits,
        )?;
        sheet.line(
            "Mrays/s, single",
            p.map(|p| p.mrays_sp),
            single.mrays_per_second,
        )?;
        sheet.line(
            "Mrays/s, parallel",
            p.map(|p| p.mrays_pp),
            parallel.mrays_per_second,
        )?;
        let gain = parallel.mrays_per_second / single.mrays_per_second;
        sheet.line(
            "parallel over single",
            p.map(|p| p.mrays_pp / p.mrays_sp),
            gain,
        )?;
        sheet.line(
            "cycles a node visit, parallel",
            None,
            parallel.cycles_per_visit,
        )?;
        explain(sheet, p.map(|p| (p.steps_pp, p.mrays_pp)), &parallel)?;
        let table5 = p.and_then(|p| p.table5);
        unsorted(
            sheet,
            case,
            kind,
            args,
            arch,
            how,
            (p.map(|p| p.mrays_pp), table5),
        )?;
        gains.push(gain);
    }
    sheet.note(format!(
        "mean of parallel over single: {:.3} (the paper's mean over its scenes 1.26)",
        gains.iter().sum::<f64>() / gains.len() as f64
    ))?;
    Ok(())
}

/// Table 5: four units, with a memory each and with one memory.
fn table5(case: &Case, args: &cli::Paper, arch: &Arch, sheet: &mut Sheet) -> Result<(), Failure> {
    let units = arch.system.cores;
    let each = How {
        units,
        memories: Memories::Private,
        order: args.order,
    };
    let one = How {
        memories: Memories::Shared,
        ..each
    };
    for kind in kinds(case) {
        let private = run_kind(case, kind, args, arch, each)?;
        let shared = run_kind(case, kind, args, arch, one)?;
        let figures = paper(case, kind);
        let p = figures.and_then(|p| p.table5);
        sheet.group(title(kind), private.relative_error)?;
        let m = &private;
        sheet.line(
            "Mrays/s, a memory each",
            p.map(|p| p.mrays),
            m.mrays_per_second,
        )?;
        sheet.line(
            "Mrays/s, one memory",
            p.map(|p| p.mrays),
            shared.mrays_per_second,
        )?;
        sheet.line("TRV busy %", p.map(|p| p.trv_util), 100.0 * m.trv_busy)?;
        sheet.line("IST busy %", p.map(|p| p.ist_util), 100.0 * m.ist_busy)?;
        sheet.line(
            "TRV steps: node visits",
            p.map(|p| p.trv_steps),
            m.inner_visits + m.leaf_visits,
        )?;
        sheet.line(
            "IST steps: triangle tests",
            p.map(|p| p.ist_steps),
            m.triangle_tests,
        )?;
        sheet.line("TRV L1 hits %", p.map(|p| p.trv_l1), 100.0 * m.trv_l1)?;
        sheet.line("TRV L2 hits %", p.map(|p| p.trv_l2), 100.0 * m.trv_l2)?;
        sheet.line("IST L1 hits %", p.map(|p| p.ist_l1), 100.0 * m.ist_l1)?;
        sheet.line("GB/s", p.map(|p| p.gb_s), m.gigabytes_per_second)?;
        sheet.line("cycles a node visit", None, m.cycles_per_visit)?;
        sheet.line("lines outstanding a unit", None, m.outstanding)?;
        explain(
            sheet,
            p.map(|p| (p.trv_steps, p.mrays / f64::from(units))),
            m,
        )?;
        unsorted(sheet, case, kind, args, arch, each, (p.map(|p| p.mrays), p))?;
    }
    Ok(())
}

/// Secondary rays once more, in the order of their pixels where they were sorted: what caches hit
/// depends on it, and the paper does not state it.
fn unsorted(
    sheet: &mut Sheet,
    case: &Case,
    kind: Kind,
    args: &cli::Paper,
    arch: &Arch,
    how: How,
    (mrays, paper): (Option<f64>, Option<Table5>),
) -> Result<(), Failure> {
    if kind == Kind::Primary || how.order != Order::Morton {
        return Ok(());
    }
    let order = Order::Pixels;
    let m = run_kind(case, kind, args, arch, How { order, ..how })?;
    sheet.note("  not sorted, in the order of the pixels:".to_owned())?;
    sheet.line("  Mrays/s", mrays, m.mrays_per_second)?;
    sheet.line("  TRV L1 hits %", paper.map(|p| p.trv_l1), 100.0 * m.trv_l1)?;
    sheet.line("  TRV L2 hits %", paper.map(|p| p.trv_l2), 100.0 * m.trv_l2)?;
    sheet.line("  IST L1 hits %", paper.map(|p| p.ist_l1), 100.0 * m.ist_l1)?;
    sheet.line("  cycles a node visit", None, m.cycles_per_visit)
}

/// Explains why the rate differs from the paper's: splits up the cycles for which a ray is in the unit. The
/// paper's residence is that of 64 rays at 500 MHz by Little's law.
fn explain(sheet: &mut Sheet, paper: Option<(f64, f64)>, ours: &Measure) -> Result<(), Failure> {
    let Some((steps, mrays)) = paper else {
        return Ok(());
    };
    let theirs = 64.0 * 500.0 / mrays;
    let visits = ours.inner_visits + ours.leaf_visits;
    let walking = visits * ours.cycles_per_visit;
    sheet.note(format!(
        "  a ray is in the unit for {:.0} cycles (the paper: {theirs:.0}): {:.0} for the paper's {steps} \
         steps,\n    {:+.0} for {:+.2} visits more than these, {:.0} at the IST",
        ours.residence,
        steps * ours.cycles_per_visit,
        walking - steps * ours.cycles_per_visit,
        visits - steps,
        ours.residence - walking
    ))
}
