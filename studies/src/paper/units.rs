//! Table 4, one T&I unit with either form of its traversal unit, and Table 5, the four units of a system.

use super::figures::{Figures, Table5};
use super::{Case, SAMPLES, Sheet, Subject};
use crate::Error;
use crate::rays::{Kind, Order};
use crate::tni::{Measure, Memories};
use crate::views::{Job, Rays};
use srp_archdesc::system::Pipeline;

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
fn run_kind(subject: Subject<'_>, kind: Kind, how: How) -> Result<Measure, Error> {
    let Subject {
        case,
        options,
        arch,
        session,
    } = subject;
    let one_in = match kind {
        Kind::Primary => options.one_in_of_primary,
        _ => options.one_in,
    };
    let job = Job {
        scene: &case.scene,
        bvh: &case.bvh,
        spec: &arch.system,
        cameras: &case.cameras,
        size: options.size,
        rays: &Rays::Of(kind),
        order: how.order,
        level: options.level,
        one_in,
        units: how.units,
        memories: how.memories,
        threads: options.threads,
        costs: false,
        keeps_rays: false,
        watch: session.watch,
    };
    Ok(job.measure()?.all)
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
pub(super) fn table4(subject: Subject<'_>, sheet: &mut Sheet<'_>) -> Result<(), Error> {
    let case = subject.case;
    let mut gains = Vec::new();
    let how = How {
        units: 1,
        memories: Memories::Private,
        order: subject.options.order,
    };
    for kind in kinds(case) {
        let of = |pipeline| {
            let mut arch = subject.arch.clone();
            arch.system.tni.set_pipeline(pipeline);
            run_kind(
                Subject {
                    arch: &arch,
                    ..subject
                },
                kind,
                how,
            )
        };
        let single = of(Pipeline::Single)?;
        let parallel = of(Pipeline::Parallel)?;
        let p = paper(case, kind);
        sheet.group(title(kind), parallel.relative_error);
        sheet.line(
            "steps a ray, single: sub-pipelines",
            p.map(|p| p.steps_sp),
            single.passes,
        );
        sheet.line(
            "steps a ray, parallel: node visits",
            p.map(|p| p.steps_pp),
            parallel.inner_visits + parallel.leaf_visits,
        );
        sheet.line(
            "Mrays/s, single",
            p.map(|p| p.mrays_sp),
            single.mrays_per_second,
        );
        sheet.line(
            "Mrays/s, parallel",
            p.map(|p| p.mrays_pp),
            parallel.mrays_per_second,
        );
        let gain = parallel.mrays_per_second / single.mrays_per_second;
        sheet.line(
            "parallel over single",
            p.map(|p| p.mrays_pp / p.mrays_sp),
            gain,
        );
        sheet.line(
            "cycles a node visit, parallel",
            None,
            parallel.cycles_per_visit,
        );
        explain(sheet, p.map(|p| (p.steps_pp, p.mrays_pp)), &parallel);
        let table5 = p.and_then(|p| p.table5);
        unsorted(sheet, subject, kind, how, (p.map(|p| p.mrays_pp), table5))?;
        gains.push(gain);
    }
    sheet.note(format!(
        "mean of parallel over single: {:.3} (the paper's mean over its scenes 1.26)",
        gains.iter().sum::<f64>() / gains.len() as f64
    ));
    Ok(())
}

/// Table 5: four units, with a memory each and with one memory.
pub(super) fn table5(subject: Subject<'_>, sheet: &mut Sheet<'_>) -> Result<(), Error> {
    let case = subject.case;
    let units = subject.arch.system.cores;
    let each = How {
        units,
        memories: Memories::Private,
        order: subject.options.order,
    };
    let one = How {
        memories: Memories::Shared,
        ..each
    };
    for kind in kinds(case) {
        let private = run_kind(subject, kind, each)?;
        let shared = run_kind(subject, kind, one)?;
        let figures = paper(case, kind);
        let p = figures.and_then(|p| p.table5);
        sheet.group(title(kind), private.relative_error);
        let m = &private;
        sheet.line(
            "Mrays/s, a memory each",
            p.map(|p| p.mrays),
            m.mrays_per_second,
        );
        sheet.line(
            "Mrays/s, one memory",
            p.map(|p| p.mrays),
            shared.mrays_per_second,
        );
        sheet.line("TRV busy %", p.map(|p| p.trv_util), 100.0 * m.trv_busy);
        sheet.line("IST busy %", p.map(|p| p.ist_util), 100.0 * m.ist_busy);
        sheet.line(
            "TRV steps: node visits",
            p.map(|p| p.trv_steps),
            m.inner_visits + m.leaf_visits,
        );
        sheet.line(
            "IST steps: triangle tests",
            p.map(|p| p.ist_steps),
            m.triangle_tests,
        );
        sheet.line("TRV L1 hits %", p.map(|p| p.trv_l1), 100.0 * m.trv_l1);
        sheet.line("TRV L2 hits %", p.map(|p| p.trv_l2), 100.0 * m.trv_l2);
        sheet.line("IST L1 hits %", p.map(|p| p.ist_l1), 100.0 * m.ist_l1);
        sheet.line("GB/s", p.map(|p| p.gb_s), m.gigabytes_per_second);
        sheet.line("cycles a node visit", None, m.cycles_per_visit);
        sheet.line("lines outstanding a unit", None, m.outstanding);
        explain(
            sheet,
            p.map(|p| (p.trv_steps, p.mrays / f64::from(units))),
            m,
        );
        unsorted(sheet, subject, kind, each, (p.map(|p| p.mrays), p))?;
    }
    Ok(())
}

/// Secondary rays once more, in the order of their pixels where they were sorted: what caches hit
/// depends on it, and the paper does not state it.
fn unsorted(
    sheet: &mut Sheet<'_>,
    subject: Subject<'_>,
    kind: Kind,
    how: How,
    (mrays, paper): (Option<f64>, Option<Table5>),
) -> Result<(), Error> {
    if kind == Kind::Primary || how.order != Order::Morton {
        return Ok(());
    }
    let order = Order::Pixels;
    let m = run_kind(subject, kind, How { order, ..how })?;
    sheet.note("  not sorted, in the order of the pixels:".to_owned());
    sheet.line("  Mrays/s", mrays, m.mrays_per_second);
    sheet.line("  TRV L1 hits %", paper.map(|p| p.trv_l1), 100.0 * m.trv_l1);
    sheet.line("  TRV L2 hits %", paper.map(|p| p.trv_l2), 100.0 * m.trv_l2);
    sheet.line("  IST L1 hits %", paper.map(|p| p.ist_l1), 100.0 * m.ist_l1);
    sheet.line("  cycles a node visit", None, m.cycles_per_visit);
    Ok(())
}

/// Explains why the rate differs from the paper's: splits up the cycles for which a ray is in the unit. The
/// paper's residence is that of 64 rays at 500 MHz by Little's law.
fn explain(sheet: &mut Sheet<'_>, paper: Option<(f64, f64)>, ours: &Measure) {
    let Some((steps, mrays)) = paper else {
        return;
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
    ));
}
