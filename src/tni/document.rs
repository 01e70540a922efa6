//! What units did, as JSON.

use crate::cli::Tni;
use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::arch::Arch;
use srp_studies::tni::{Energy, Measure, UnitFigure};
use srp_studies::views::{Job, Measured};
use srp_toolchain::envelope::Contents;

/// T&I units alone, fed with rays.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Document<'a> {
    /// The kind of rays.
    rays: &'static str,
    /// The clock of the units.
    tni_mhz: u32,
    /// Width and height of the views in pixels.
    size: [u32; 2],
    /// The level of simulation.
    fidelity: &'static str,
    /// One in so many rays was run; null where the level chooses itself.
    sample: Option<u64>,
    /// The blocks of rays that were sampled, where they were.
    blocks: Option<Blocks>,
    /// Figures with intervals, where not all was measured.
    intervals: Vec<UnitFigure>,
    /// All units and views together.
    all: &'a Measure,
    /// The same with a memory for each unit, where that was asked for.
    all_with_private_memories: Option<&'a Measure>,
    /// The energy of the units.
    energy_mj: Energy,
    /// View by view; empty where blocks were sampled.
    views: Vec<Measure>,
}

impl Contents for Document<'_> {
    const FORMAT: &'static str = "srp-tni";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp tni --json` at a level with a clock";
}

/// The blocks of a sample.
#[derive(Serialize, JsonSchema)]
struct Blocks {
    /// How many there are.
    all: u64,
    /// Those that were looked at without time.
    looked_at: u64,
    /// Those that were run.
    run: u64,
    /// Rays that were run.
    rays: u64,
}

impl<'a> Document<'a> {
    pub(super) fn of(
        args: &Tni,
        arch: &Arch,
        job: &Job<'_>,
        measured: &'a Measured,
        private: Option<&'a Measure>,
    ) -> Document<'a> {
        let views = measured.outcomes.iter();
        let views = views.map(|o| Measure::of(std::slice::from_ref(o), job.units, job.spec));
        let sample = measured.sample.as_ref();
        Document {
            rays: job.rays.name(),
            tni_mhz: arch.system.tni_mhz,
            size: [job.size.0, job.size.1],
            fidelity: args.level.fidelity.name(),
            sample: sample.is_none().then_some(measured.one_in),
            blocks: sample.map(|s| Blocks {
                all: s.blocks,
                looked_at: s.looked,
                run: s.run,
                rays: s.rays,
            }),
            intervals: measured.intervals(job),
            all: &measured.all,
            all_with_private_memories: private,
            energy_mj: Energy::of(&arch.system.tni, &measured.all.counters),
            views: match sample {
                Some(_) => Vec::new(),
                None => views.collect(),
            },
        }
    }
}
