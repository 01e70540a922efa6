//! Units alone without a clock, or with an estimate of it.

use crate::cli::Tni;
use crate::failure::Failure;
use crate::{document, interrupt, talk};
use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::arch::Arch;
use srp_studies::fidelity::Fidelity;
use srp_studies::tni::Measure;
use srp_studies::views::Job;
use srp_toolchain::envelope::{About, Contents};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Units alone without a clock.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Counts {
    /// The kind of rays.
    rays: &'static str,
    /// The level of simulation.
    fidelity: &'static str,
    /// Figures of all units and views together, by their names.
    all: BTreeMap<&'static str, f64>,
}

impl Contents for Counts {
    const FORMAT: &'static str = "srp-tni-counts";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp tni --fidelity functional --json` and `analytic`";
}

/// Counts, and with `analytic` rates, for people or for programs.
pub(super) fn print(args: &Tni, arch: &Arch, job: &Job<'_>) -> Result<(), Failure> {
    let level = args.level.fidelity;
    let estimated = level == Fidelity::Analytic;
    let outcomes = interrupt::looked_for(|| job.count())?;
    let all = Measure::of(&outcomes, job.units, job.spec);
    let hits = all.counters.unit.hits;
    let mut figures: Vec<(&'static str, f64)> = vec![
        ("rays", all.rays as f64),
        ("hits", hits as f64),
        ("inner nodes a ray", all.inner_visits),
        ("leaves a ray", all.leaf_visits),
        ("triangle tests a ray", all.triangle_tests),
    ];
    if estimated {
        figures.extend([
            ("Mrays/s", all.mrays_per_second),
            ("cycles", all.cycles as f64),
            ("cycles of a ray in the unit", all.residence),
            ("TRV L1 hits %", 100.0 * all.trv_l1),
            ("TRV L2 hits %", 100.0 * all.trv_l2),
            ("IST L1 hits %", 100.0 * all.ist_l1),
            ("GB/s", all.gigabytes_per_second),
        ]);
    }
    if args.json {
        let counts = Counts {
            rays: job.rays.name(),
            fidelity: level.name(),
            all: figures.into_iter().collect(),
        };
        let about = About::scene(arch, job.scene);
        return Ok(talk::print(document::json(about, &counts)?)?);
    }
    let mut out = format!(
        "{}: {} rays of {} view(s), {}\n",
        job.scene.name,
        job.rays.name(),
        outcomes.len(),
        level.name()
    );
    for (name, value) in figures {
        let digits = if value.fract() == 0.0 { 0 } else { 3 };
        let _ = writeln!(out, "{name:28} {value:>14.digits$}");
    }
    Ok(talk::print(out)?)
}
