//! A setting tried: compiled, scheduled and simulated, and its picture held against the reference.

use super::blame::Blame;
use super::compare::{Comparison, Difference};
use super::probe::{Edges, Leaks};
use super::setting::Subject;
use crate::failure::Failure;
use crate::interrupt;
use crate::tni::Energy;
use serde::{Deserialize, Serialize};
use srp_archdesc::arch::{Approx, Arch};
use srp_archdesc::area;
use srp_archdesc::certify::{Function, certify};
use srp_ir::dre::scheduled::ScheduledDre;
use srp_runtime::bvh::Bvh;
use srp_runtime::effect::Guard;
use srp_runtime::picture::Picture;
use srp_runtime::scene::Scene;
use srp_runtime::scene_image;
use srp_runtime::system::{self, Report};
use srp_toolchain::{Engine, Engines, Session, system_options};
use std::collections::BTreeMap;
use std::time::Instant;

/// Energy in nJ that a byte of system memory takes: 40 pJ a bit, as Malladi et al. (ISCA 2012) have
/// it of LPDDR2.
const MEMORY_BYTE: f64 = 0.32;

/// A pixel of which a channel is off by more levels has had another decision.
const DECIDED: u8 = 8;

/// What all trials share.
pub(super) struct Studio<'a> {
    pub(super) scene: &'a Scene,
    pub(super) bvh: &'a Bvh,
    pub(super) size: (u32, u32),
    pub(super) edges: Edges,
    pub(super) session: &'a Session<'a>,
}

/// A setting that was tried.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Trial {
    /// What was turned, nothing at the machine as it is.
    pub(super) knob: String,
    /// What to.
    pub(super) value: String,
    /// How a user says it.
    pub(super) how: String,
    /// Over all pixels.
    pub(super) all: Difference,
    /// Over those on which all decisions fall as in binary64.
    pub(super) agreeing: Difference,
    pub(super) leaks: Leaks,
    /// Where the errors come from, in the tiles that were looked into.
    pub(super) blame: Blame,
    /// Of the unit whose precision is set.
    pub(super) unit: Option<UnitError>,
    pub(super) costs: Costs,
}

/// How far a unit is off, in units of the last place, over all mantissas.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct UnitError {
    /// At most.
    pub(super) largest: f64,
    /// On average.
    pub(super) mean: f64,
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

/// What a setting costs.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Costs {
    /// Initiation intervals of the kernels by name.
    pub(super) ii: BTreeMap<String, u32>,
    /// Cycles in which cores had work, all of them together.
    pub(super) srp_cycles: u64,
    /// Cycles of the T&I clock in which units had rays, all of them together.
    pub(super) tni_cycles: u64,
    /// SRP cycles of the frame.
    pub(super) frame_cycles: u64,
    /// Bytes that the memory moved.
    pub(super) dram_bytes: u64,
    /// mJ of the frame, as far as what is done has a price.
    pub(super) energy: f64,
    /// mm² of all cores and their units, as far as they have a price.
    pub(super) area: f64,
    /// Seconds of the host for the simulation, without compiling.
    pub(super) host_seconds: f64,
}

/// A frame that was simulated.
pub(super) struct Frame {
    pub(super) picture: Picture,
    pub(super) leaks: Leaks,
    pub(super) costs: Costs,
}

impl Studio<'_> {
    /// The scene with a subject's light.
    pub(super) fn scene_of(&self, subject: &Subject) -> Scene {
        Scene {
            options: subject.options,
            ..self.scene.clone()
        }
    }

    /// Compiles, schedules and simulates a frame.
    pub(super) fn frame(&self, subject: &Subject) -> Result<Frame, Failure> {
        let arch = &subject.arch;
        let scene = &self.scene_of(subject);
        let compiled = subject.build.compile(None, arch, self.session)?;
        interrupt::end_if_requested()?;
        let program = compiled.runnable()?;
        let image = scene_image::build(scene, self.bvh, &scene.camera, arch, self.size)
            .map_err(Failure::message)?;
        let leaks = self.edges.probe(scene, &image, arch);
        let engines = Engines::of(program, Engine::Interpreter, self.session)?;
        let cores = engines.cores(arch.system.cores);
        let timing = system::Timing::Full;
        let options = system_options(program, Guard::default(), timing, self.session);
        let start = Instant::now();
        let rendered = system::render(image, cores, arch, options);
        let host_seconds = start.elapsed().as_secs_f64();
        let (picture, report) = rendered.map_err(Failure::message)?;
        interrupt::end_if_requested()?;
        Ok(Frame {
            picture,
            leaks,
            costs: Costs {
                host_seconds,
                ..costs(&report, program, arch)
            },
        })
    }
}

#[cfg(test)]
impl Trial {
    /// One of which nothing is known.
    pub(super) fn empty() -> Trial {
        Trial {
            knob: String::new(),
            value: String::new(),
            how: String::new(),
            all: Difference::default(),
            agreeing: Difference::default(),
            leaks: Leaks::default(),
            blame: Blame::default(),
            unit: None,
            costs: Costs {
                energy: 1.0,
                area: 1.0,
                ..Costs::default()
            },
        }
    }
}

impl Trial {
    /// What is to be said of a frame.
    pub(super) fn of(frame: &Frame, comparison: &Comparison) -> Trial {
        Trial {
            knob: String::new(),
            value: String::new(),
            how: String::new(),
            all: comparison.over(|_| true),
            agreeing: comparison.over(|i| comparison.levels[i] <= DECIDED),
            leaks: frame.leaks,
            blame: Blame::default(),
            unit: None,
            costs: frame.costs.clone(),
        }
    }
}

fn costs(report: &Report, program: &ScheduledDre, arch: &Arch) -> Costs {
    let ii = |k: &srp_ir::dre::scheduled::ModuloSchedule| (k.dfg.name.clone(), k.ii);
    let tni = report.tni();
    let working = |core: &system::CoreReport| {
        let array: u64 = core.array.iter().map(|k| k.cycles).sum();
        core.vliw + array + core.switch + core.memory_stall + core.texture_stall
    };
    let memory = &report.dram.counters;
    let moved = memory.bytes_read + memory.bytes_written;
    let cores = f64::from(arch.system.cores);
    let unit = area::area(&arch.system.tni, &arch.system.buffers).total;
    Costs {
        ii: program.kernels.values().map(ii).collect(),
        srp_cycles: report.cores.iter().map(working).sum(),
        tni_cycles: tni.unit.active_cycles,
        frame_cycles: report.cycles,
        dram_bytes: moved,
        energy: Energy::of(&arch.system.tni, &tni).total()
            + array_energy(report, program, arch)
            + moved as f64 * MEMORY_BYTE * 1e-6,
        area: cores * (unit + area::srp_area(arch)),
        host_seconds: 0.0,
    }
}

/// mJ of the operations on the arrays, as if every cycle were one of a full pipeline.
fn array_energy(report: &Report, program: &ScheduledDre, arch: &Arch) -> f64 {
    let mut energy = 0.0;
    for kernel in program.kernels.values() {
        let each: f64 = (kernel.dfg.nodes.values())
            .map(|node| area::operation_energy(node.op, &arch.precision))
            .sum();
        let cycles: u64 = (report.cores.iter().flat_map(|c| &c.array))
            .filter(|k| k.kernel == kernel.dfg.name)
            .map(|k| k.cycles)
            .sum();
        energy += each * cycles as f64 / f64::from(kernel.ii);
    }
    energy * 1e-6
}
