//! Table 4, one T&I unit with either form of its traversal unit, and Table 5, the four units of a system.

use super::figures::{Figures, Table5};
use super::{Case, Options, SAMPLES, Sheet, Subject, Table};
use crate::Error;
use crate::rays::{Kind, Order};
use crate::tni::{Measure, Memories};
use crate::views::{Job, Rays};
use serde::Serialize;
use srp_archdesc::arch::Arch;
use srp_archdesc::system::Pipeline;
use srp_runtime::bvh::{self, Layout};
use srp_toolchain::BUILD_ID;
use srp_toolchain::cache::{Key, Kind as Kept, Shared};

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

/// A measurement: the rays of a kind over all views.
#[derive(Clone, Copy, PartialEq, Serialize)]
struct Piece {
    kind: Kind,
    units: u32,
    memories: Memories,
    order: Order,
    /// The form of the traversal unit, where it is not the machine's own.
    pipeline: Option<Pipeline>,
}

impl Piece {
    /// The same rays in the order of their pixels, where they are secondary ones that are sorted.
    fn unsorted(self) -> Option<Piece> {
        let sorted = self.kind != Kind::Primary && self.order == Order::Morton;
        sorted.then_some(Piece {
            order: Order::Pixels,
            ..self
        })
    }
}

/// The measurements of one kind of rays in Table 4: of a single and of parallel pipelines.
fn of_table4(options: &Options, kind: Kind) -> [Piece; 2] {
    [Pipeline::Single, Pipeline::Parallel].map(|pipeline| Piece {
        kind,
        units: 1,
        memories: Memories::Private,
        order: options.order,
        pipeline: Some(pipeline),
    })
}

/// The measurements of one kind of rays in Table 5: with a memory for each unit and with one for all.
fn of_table5(options: &Options, arch: &Arch, kind: Kind) -> [Piece; 2] {
    [Memories::Private, Memories::Shared].map(|memories| Piece {
        kind,
        units: arch.system.cores,
        memories,
        order: options.order,
        pipeline: None,
    })
}

/// All measurements of a table, in the order in which the sheet has them.
fn pieces(subject: Subject<'_>) -> Vec<Piece> {
    let Subject {
        case,
        options,
        arch,
        ..
    } = subject;
    let of_kind = |kind| match options.table {
        Table::Table4 => {
            let [single, parallel] = of_table4(options, kind);
            [Some(single), Some(parallel), parallel.unsorted()]
        }
        _ => {
            let [private, shared] = of_table5(options, arch, kind);
            [Some(private), Some(shared), private.unsorted()]
        }
    };
    kinds(case)
        .into_iter()
        .flat_map(of_kind)
        .flatten()
        .collect()
}

/// The measurements of a scene. Where processes share them, all are made before the first is asked for; else each is made when it
/// is.
pub(super) struct Measures<'a> {
    subject: Subject<'a>,
    known: Vec<(Piece, Measure)>,
}

impl<'a> Measures<'a> {
    fn new(subject: Subject<'a>) -> Measures<'a> {
        let known = Vec::new();
        Measures { subject, known }
    }

    pub(super) fn of(subject: Subject<'a>) -> Result<Measures<'a>, Error> {
        let mut measures = Measures::new(subject);
        let Some(shared) = &subject.session.shared else {
            return Ok(measures);
        };
        let (pieces, keys) = measures.keys();
        let make = |(): &mut (), i: usize| measures.run(pieces[i]);
        let made = shared.pieces(&keys, 1, subject.session.watch, || (), make)?;
        let made = made.ok_or_else(Error::cancelled)?;
        measures.known = pieces.into_iter().zip(made).collect();
        Ok(measures)
    }

    /// Makes what nobody has begun, and waits for nobody.
    pub(super) fn begin(subject: Subject<'a>, shared: &Shared) -> Result<(), Error> {
        let measures = Measures::new(subject);
        let (pieces, keys) = measures.keys();
        let make = |(): &mut (), i: usize| measures.run(pieces[i]);
        let begun = shared.begin(&keys, 1, subject.session.watch, || (), make)?;
        begun.map(drop).ok_or_else(Error::cancelled)
    }

    /// All pieces, with keys of all that they depend on.
    fn keys(&self) -> (Vec<Piece>, Vec<Key>) {
        let Subject {
            case,
            options,
            arch,
            ..
        } = self.subject;
        let tree = bvh::lay_out(
            &case.bvh,
            &case.scene.triangles,
            Layout::of(&arch.system.tni),
        );
        let about = Key::of(Kept::Frames)
            .text(BUILD_ID)
            .value(arch)
            .value(&case.scene)
            .value(&case.cameras)
            .value(&tree.nodes)
            .value(&tree.triangles)
            .value(&(options.size, options.level))
            .value(&(options.one_in, options.one_in_of_primary))
            .finish();
        let key = |piece: &Piece| {
            let key = Key::of(Kept::Frames).bytes(about.digest());
            key.text("rays of a table").value(piece).finish()
        };
        let pieces = pieces(self.subject);
        let keys = pieces.iter().map(key).collect();
        (pieces, keys)
    }

    fn get(&self, piece: Piece) -> Result<Measure, Error> {
        let known = self.known.iter().find(|(known, _)| *known == piece);
        known.map_or_else(|| self.run(piece), |(_, measure)| Ok(measure.clone()))
    }

    /// Measures the rays of a piece.
    fn run(&self, piece: Piece) -> Result<Measure, Error> {
        let Subject {
            case,
            options,
            arch,
            session,
        } = self.subject;
        let mut spec = arch.system.clone();
        if let Some(pipeline) = piece.pipeline {
            spec.tni.set_pipeline(pipeline);
        }
        let one_in = match piece.kind {
            Kind::Primary => options.one_in_of_primary,
            _ => options.one_in,
        };
        let job = Job {
            scene: &case.scene,
            bvh: &case.bvh,
            spec: &spec,
            cameras: &case.cameras,
            size: options.size,
            rays: &Rays::Of(piece.kind),
            order: piece.order,
            level: options.level,
            one_in,
            units: piece.units,
            memories: piece.memories,
            threads: options.threads,
            costs: false,
            keeps_rays: false,
            watch: session.watch,
        };
        Ok(job.measure()?.all)
    }
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
    let measures = Measures::of(subject)?;
    let mut gains = Vec::new();
    for kind in kinds(case) {
        let [of_single, of_parallel] = of_table4(subject.options, kind);
        let single = measures.get(of_single)?;
        let parallel = measures.get(of_parallel)?;
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
        unsorted(
            sheet,
            &measures,
            of_parallel,
            (p.map(|p| p.mrays_pp), table5),
        )?;
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
    let measures = Measures::of(subject)?;
    for kind in kinds(case) {
        let [of_private, of_shared] = of_table5(subject.options, subject.arch, kind);
        let private = measures.get(of_private)?;
        let shared = measures.get(of_shared)?;
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
            p.map(|p| (p.trv_steps, p.mrays / f64::from(of_private.units))),
            m,
        );
        unsorted(sheet, &measures, of_private, (p.map(|p| p.mrays), p))?;
    }
    Ok(())
}

/// Secondary rays once more, in the order of their pixels where they were sorted: what caches hit
/// depends on it, and the paper does not state it.
fn unsorted(
    sheet: &mut Sheet<'_>,
    measures: &Measures<'_>,
    sorted: Piece,
    (mrays, paper): (Option<f64>, Option<Table5>),
) -> Result<(), Error> {
    let Some(unsorted) = sorted.unsorted() else {
        return Ok(());
    };
    let m = measures.get(unsorted)?;
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
