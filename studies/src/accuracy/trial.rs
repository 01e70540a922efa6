//! A setting tried: compiled, scheduled and simulated, and its picture held against the reference.

use super::compare::{Comparison, DECIDED, Difference};
use super::probe::{Edges, Leaks};
use super::setting::{Setting, Subject, is_sampling};
use super::summary::AttributionSummary;
use crate::energy::energy;
use crate::{Error, functional};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use srp_archdesc::arch::{Approx, Arch};
use srp_archdesc::area;
use srp_archdesc::certify::{Function, certify};
use srp_archdesc::chip;
use srp_archdesc::isa::Opcode;
use srp_archdesc::structure::Special;
use srp_archdesc::threads;
use srp_ir::dre::scheduled::ScheduledDre;
use srp_runtime::picture::Picture;
use srp_runtime::scene_image::SceneImage;
use srp_runtime::system::{self, Report, TileQueue};
use srp_toolchain::cache::Kind;
use srp_toolchain::{Engine, Engines, Frame, Session};
use std::collections::{BTreeMap, BTreeSet};

/// A setting that was tried.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Trial {
    /// The knob that was turned, none at the machine as it is.
    pub knob: String,
    /// The value that it was turned to.
    pub value: String,
    /// How a user says it.
    pub how: String,
    /// Over all pixels.
    pub all: Difference,
    /// Over those on which all decisions fall as in binary64.
    pub agreeing: Difference,
    /// Rays aimed at the scene's own edges.
    pub leaks: Leaks,
    /// Where the errors come from, in the tiles that were looked into.
    pub attribution: AttributionSummary,
    /// Of the unit whose precision is set.
    pub unit: Option<UnitError>,
    /// The cost of the setting.
    pub costs: Costs,
    /// SRP cycles of the frame in other orders of tiles; none where they were not looked at.
    pub cycles_in_other_orders: Vec<u64>,
    /// It is of a unit that the frame does not use: whatever differs has another cause.
    pub not_exercised: bool,
}

/// How far a unit is off, in units of the last place, over all mantissas.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct UnitError {
    /// At most.
    pub largest: f64,
    /// On average.
    pub mean: f64,
}

impl UnitError {
    /// Of the worst of some units.
    pub(super) fn of(units: &[(Function, Approx)]) -> Option<UnitError> {
        let each = units.iter().map(|&(function, approx)| {
            let certificate = certify(function, approx);
            UnitError {
                largest: certificate.worst_ulp,
                mean: certificate.mean_ulp,
            }
        });
        each.max_by(|a, b| a.largest.total_cmp(&b.largest))
    }
}

/// The cost of a setting.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct Costs {
    /// Initiation intervals of the kernels by name.
    pub ii: BTreeMap<String, u32>,
    /// Cycles in which cores had work, all of them together.
    pub srp_cycles: u64,
    /// Cycles of the T&I clock in which units had rays, all of them together.
    pub tni_cycles: u64,
    /// SRP cycles of the frame.
    pub frame_cycles: u64,
    /// Bytes that the memory moved.
    pub dram_bytes: u64,
    /// mJ of the frame, as far as what is done has a price.
    pub energy: f64,
    /// mm² of all cores and their units, as far as they have a price. Units that the frame does not use are
    /// priced as the machine has them that the study began with.
    pub area: f64,
    /// The special functions that the frame computes.
    pub used: Vec<Special>,
    /// True if texels are looked up.
    pub texels: bool,
    /// Seconds of the host for the simulation, without compiling.
    pub host_seconds: f64,
}

/// The pictures and counts that a trial has rendered.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Rendering {
    /// The picture.
    pub picture: Picture,
    /// The largest difference of a channel of each pixel from the picture in binary64, in levels.
    pub levels: Vec<u8>,
}

/// The measurements of a frame, whatever its setting is called.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Measured {
    all: Difference,
    agreeing: Difference,
    leaks: Leaks,
    attribution: AttributionSummary,
    costs: Costs,
    pub(super) rendering: Rendering,
}

/// Measures a frame, or finds what was measured before. Its picture is held against one in binary64 of
/// a subject; errors are attributed in one tile of so many.
///
/// # Errors
///
/// The frame cannot be simulated, or the work was cancelled.
pub(super) fn measured(
    frame: &Frame,
    (subject, reference): (&Subject, &[DVec3]),
    edges: &Edges,
    one_in: u32,
    session: &Session<'_>,
) -> Result<Measured, Error> {
    let image = frame.image()?;
    let key = frame.key(Kind::Trials, &image);
    // The reference is of the same scene with the subject's options, in its order of samples.
    let key = key.value(&subject.arch).value(&subject.options);
    let key = key.value(&one_in).finish();
    if let Some(known) = session.cache.get(key, session.watch) {
        return Ok(known);
    }
    let leaks = edges.probe(&frame.scene, &image, &frame.arch);
    let (picture, costs) = simulated(frame, &subject.arch, image.clone(), session)?;
    let comparison = Comparison::of(&picture, reference);
    let attribution = AttributionSummary::of(frame, &image, one_in, &comparison, session)?;
    let measured = Measured {
        all: comparison.over(|_| true),
        agreeing: comparison.over(|i| comparison.levels[i] <= DECIDED),
        leaks,
        attribution,
        costs,
        rendering: Rendering {
            picture,
            levels: comparison.levels,
        },
    };
    session.cache.put(key, &measured, session.watch);
    Ok(measured)
}

/// The picture of a frame without a schedule and a clock, which is the same to the bit, held against the
/// reference.
///
/// # Errors
///
/// The program does not fit the machine, or the work was cancelled.
pub(super) fn screened(
    frame: &Frame,
    reference: &[DVec3],
    session: &Session<'_>,
) -> Result<Difference, Error> {
    let picture = picture_without_clock(frame, session)?;
    Ok(Comparison::of(&picture, reference).over(|_| true))
}

/// The picture of a frame without a schedule and a clock.
///
/// # Errors
///
/// The program does not fit the machine, or the work was cancelled.
pub(crate) fn picture_without_clock(
    frame: &Frame,
    session: &Session<'_>,
) -> Result<Picture, Error> {
    let (program, _) = frame.build.program(&frame.arch)?;
    let options = functional::Options {
        guard: &frame.guard,
        threads: 1,
        tiles: None,
        steps: functional::MAX_STEPS,
        watch: session.watch,
    };
    let rendered = functional::render(&frame.image()?, &program, &frame.arch, options)?;
    session.check()?;
    Ok(rendered.picture)
}

/// Compiles, schedules and simulates a frame.
fn simulated(
    frame: &Frame,
    base: &Arch,
    image: SceneImage,
    session: &Session<'_>,
) -> Result<(Picture, Costs), Error> {
    let kernels = frame.build.scheduled(&frame.arch, session)?;
    session.check()?;
    let program = kernels.program()?;
    let engines = Engines::of(program, Engine::Interpreter, session)?;
    let start = session.watch.elapsed();
    let (picture, report) = frame.render(image, program, &engines, session)?;
    let host_seconds = (session.watch.elapsed() - start).as_secs_f64();
    session.check()?;
    let costs = Costs {
        host_seconds,
        ..costs(&report, program, &frame.arch, base)
    };
    Ok((picture, costs))
}

/// SRP cycles of a frame whose tiles are taken in other orders: each begins at another tile, and goes round.
/// Neighbours remain neighbours, which caches need; but other tiles meet on the cores, and another is the last.
/// No setting deserves what these cycles differ by.
///
/// # Errors
///
/// The frame cannot be simulated, or the work was cancelled.
pub(super) fn cycles_in_other_orders(
    frame: &Frame,
    orders: u64,
    threads: usize,
    session: &Session<'_>,
) -> Result<Vec<u64>, Error> {
    let image = frame.image()?;
    let key = frame
        .key(Kind::Trials, &image)
        .text("tiles that begin elsewhere");
    let key = key.value(&orders).finish();
    if let Some(known) = session.cache.get(key, session.watch) {
        return Ok(known);
    }
    let kernels = frame.build.scheduled(&frame.arch, session)?;
    let program = kernels.program()?;
    let engines = Engines::of(program, Engine::Interpreter, session)?;
    let cycles = |number: u64| -> Result<u64, Error> {
        session.check()?;
        let blocks = system::frame_blocks(&image, &frame.arch.system);
        let (mut tiles, longest) = (blocks.concat(), blocks[0].len());
        tiles.rotate_left((number * u64::from(image.tiles) / (orders + 1)) as usize);
        let blocks = tiles.chunks(longest).map(<[u32]>::to_vec).collect();
        let order = Some(TileQueue::of_blocks(blocks));
        let (_, report) =
            frame.render_in_order(order, image.clone(), program, &engines, session)?;
        session.check()?;
        Ok(report.cycles)
    };
    let one = |(): &mut (), i: usize| Some(cycles(i as u64 + 1));
    let cycles = threads::some(threads, orders as usize, || (), one);
    let cycles = cycles
        .into_iter()
        .flatten()
        .collect::<Result<Vec<u64>, _>>()?;
    session.cache.put(key, &cycles, session.watch);
    Ok(cycles)
}

/// The operations that a frame may compute: those of the kernels that ran, and of control code.
fn operations(report: &Report, program: &ScheduledDre) -> BTreeSet<Opcode> {
    let ran = |number: usize| {
        let of_core = |core: &system::CoreReport| core.array.get(number).map_or(0, |k| k.cycles);
        report.cores.iter().map(of_core).sum::<u64>() > 0
    };
    let kernels = program
        .kernels
        .values()
        .enumerate()
        .filter(|(i, _)| ran(*i));
    let of_kernels = kernels.flat_map(|(_, k)| k.dfg.nodes.values().map(|node| node.op));
    let bundles = program.bundles.values();
    let of_control = bundles.flat_map(|bundle| bundle.ops.iter().map(|slot| slot.op));
    of_kernels.chain(of_control).collect()
}

impl Trial {
    /// The trial of a setting.
    pub(super) fn of(setting: &Setting, measured: &Measured) -> Trial {
        Trial {
            knob: setting.knob.clone(),
            value: setting.value.clone(),
            how: setting.how.clone(),
            all: measured.all,
            agreeing: measured.agreeing,
            leaks: measured.leaks,
            attribution: measured.attribution.clone(),
            unit: UnitError::of(&setting.units),
            not_exercised: setting.is_of_other_units(&measured.costs.used, measured.costs.texels),
            costs: measured.costs.clone(),
            cycles_in_other_orders: Vec::new(),
        }
    }

    /// True when it changes what is computed, not how exactly.
    pub fn is_sampling(&self) -> bool {
        is_sampling(&self.knob)
    }

    /// One of which nothing is known.
    #[cfg(test)]
    pub(super) fn empty() -> Trial {
        Trial {
            knob: String::new(),
            value: String::new(),
            how: String::new(),
            all: Difference::default(),
            agreeing: Difference::default(),
            leaks: Leaks::default(),
            attribution: AttributionSummary::default(),
            unit: None,
            not_exercised: false,
            cycles_in_other_orders: Vec::new(),
            costs: Costs {
                energy: 1.0,
                area: 1.0,
                ..Costs::default()
            },
        }
    }
}

fn costs(report: &Report, program: &ScheduledDre, arch: &Arch, base: &Arch) -> Costs {
    let operations = operations(report, program);
    let used: BTreeSet<Special> = operations.iter().copied().filter_map(Special::of).collect();
    let mut priced = arch.clone();
    for special in Special::ALL.into_iter().filter(|s| !used.contains(s)) {
        *priced.precision.of_mut(special) = base.precision.of(special);
    }
    priced.derive_cycles();
    let ii = |k: &srp_ir::dre::scheduled::ModuloSchedule| (k.dfg.name.clone(), k.ii);
    let tni = report.tni();
    let working = |core: &system::CoreReport| {
        let array: u64 = core.array.iter().map(|k| k.cycles).sum();
        let stalls = core.memory_stall + core.texture_stall;
        let of_code = core.instruction_stall + core.context_stall;
        core.vliw + array + core.switch + stalls + of_code + core.sram_stall
    };
    let memory = &report.dram.counters;
    let moved = memory.bytes_read + memory.bytes_written;
    let cores = f64::from(arch.system.cores);
    let system = &arch.system;
    let unit = area::area(&system.tni, &system.buffers, system.tni_mhz_at_65nm()).total;
    Costs {
        ii: program.kernels.values().map(ii).collect(),
        srp_cycles: report.cores.iter().map(working).sum(),
        tni_cycles: tni.unit.active_cycles,
        frame_cycles: report.cycles,
        dram_bytes: moved,
        energy: energy(report, program, arch).total_mj,
        area: cores * (unit + chip::srp(&priced).total_mm2),
        used: used.into_iter().collect(),
        texels: operations.contains(&Opcode::Tex),
        host_seconds: 0.0,
    }
}
