//! Where the time of a frame went.

mod text;

use schemars::JsonSchema;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use srp_archdesc::Arch;

use super::code::ContextCounters;
use super::core_unit::CoreUnit;
use super::sharing::SharedWords;
use super::simulation::{Simulation, port_name};
use crate::core::{Activity, Run};
use crate::memory::cache::CacheCounters;
use crate::memory::dram::{DramCounters, DramReport};
use crate::memory::path::{BusReport, Clock};
use crate::tni::TniCounters;

/// The cycles of one core by activity.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Account {
    /// Issued VLIW bundles.
    pub vliw: u64,
    /// The operations of those.
    pub vliw_operations: u64,
    /// Ran a kernel on the array, by its number.
    pub array: BTreeMap<u32, u64>,
    /// The operations of the iterations that began in those.
    pub array_operations: BTreeMap<u32, u64>,
    /// Changed between VLIW engine and array.
    pub switch: u64,
    /// Stood still because of its data cache.
    pub memory_stall: u64,
    /// Stood still because of its texture cache alone.
    pub texture_stall: u64,
    /// Stood still because of its instruction cache.
    pub instruction_stall: u64,
    /// Stood still because of a kernel's contexts.
    pub context_stall: u64,
    /// Stood still because accesses met in a bank of its SRAM, or the T&I unit had all of them.
    pub sram_stall: u64,
    /// Of the first two, while it ran a kernel, by its number.
    pub kernel_stalls: BTreeMap<u32, u64>,
    /// Of those for banks, while it ran a kernel, by its number.
    pub kernel_sram_stalls: BTreeMap<u32, u64>,
    /// Waited for a port.
    pub wait: BTreeMap<u32, u64>,
}

impl Account {
    pub(super) fn add(&mut self, run: Run) {
        match run.activity {
            Activity::Vliw => {
                self.vliw += run.cycles;
                self.vliw_operations += run.operations;
            }
            Activity::Array(kernel) => {
                *self.array.entry(kernel).or_default() += run.cycles;
                *self.array_operations.entry(kernel).or_default() += run.operations;
            }
            Activity::Switch => self.switch += run.cycles,
            Activity::Wait(port) => *self.wait.entry(port).or_default() += run.cycles,
            Activity::Halted(_) => {}
        }
    }

    /// All of them.
    pub fn total(&self) -> u64 {
        self.vliw
            + self.array.values().sum::<u64>()
            + self.switch
            + self.memory_stall
            + self.texture_stall
            + self.instruction_stall
            + self.context_stall
            + self.sram_stall
            + self.wait.values().sum::<u64>()
    }
}

/// The work of the array for one kernel.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct KernelRuns {
    /// Its name.
    pub kernel: String,
    /// SRP cycles.
    pub cycles: u64,
    /// Operations of the iterations that began in them, without moves of values.
    pub operations: u64,
}

/// Cycles of one kernel.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct KernelCycles {
    /// Its name.
    pub kernel: String,
    /// SRP cycles.
    pub cycles: u64,
}

/// Cycles of waiting for one port.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PortCycles {
    /// The port that the core waits for, in words.
    pub port: String,
    /// SRP cycles.
    pub cycles: u64,
}

/// One core. `vliw`, `array`, `switch`, `memory_stall`, `texture_stall`, `instruction_stall`,
/// `context_stall`, `sram_stall`, `wait` and `idle` sum to the cycles of the frame.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CoreReport {
    /// SRP cycles in which VLIW bundles were issued.
    pub vliw: u64,
    /// Operations of these bundles, control transfers included.
    pub vliw_operations: u64,
    /// SRP cycles on the array.
    pub array: Vec<KernelRuns>,
    /// SRP cycles of changes between VLIW engine and array.
    pub switch: u64,
    /// SRP cycles in which the core stood still because of its data cache.
    pub memory_stall: u64,
    /// SRP cycles in which it stood still because of its texture cache alone.
    pub texture_stall: u64,
    /// SRP cycles in which it stood still because a bundle was not in its instruction cache.
    pub instruction_stall: u64,
    /// SRP cycles in which it stood still because the contexts of a kernel were not in its configuration memory.
    pub context_stall: u64,
    /// SRP cycles in which it stood still because accesses met in a bank of its SRAM, or a packet went through the banks.
    pub sram_stall: u64,
    /// Of stalls for data and textures, those while a kernel was on the array; the rest is control code's.
    pub kernel_stalls: Vec<KernelCycles>,
    /// Of stalls for banks of the SRAM, those while a kernel was on the array.
    pub kernel_sram_stalls: Vec<KernelCycles>,
    /// SRP cycles of waiting for ports.
    pub wait: Vec<PortCycles>,
    /// SRP cycles after its program had ended; in a part of a frame, those that were not simulated
    /// yet, too.
    pub idle: u64,
    /// The data cache.
    pub data_cache: CacheCounters,
    /// The texture cache: an access for each line that a sample needs.
    pub texture_cache: CacheCounters,
    /// The instruction cache, where the core has one: an access for each line that the VLIW engine goes to.
    pub instruction_cache: Option<CacheCounters>,
    /// The configuration memory, where kernels share it.
    pub contexts: Option<ContextCounters>,
    /// Bytes that the texture cache has read from memory.
    pub texture_bytes: u64,
    /// Samples that the texture unit has filtered.
    pub texture_samples: u64,
    /// The T&I unit.
    pub tni: TniCounters,
    /// The status that the program returned.
    pub exit_status: i32,
    /// Output of the program.
    pub output: String,
}

/// Where the time of a frame went.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Report {
    /// Pixels in a row of the picture.
    pub width: u32,
    /// Rows of the picture.
    pub height: u32,
    /// True if the frame was finished; else this is the account of its first cycles.
    pub complete: bool,
    /// Tiles that cores have taken.
    pub tiles_taken: u32,
    /// Tiles of the frame.
    pub tiles: u32,
    /// SRP cycles of the frame.
    pub cycles: u64,
    /// Clock of the SRP, MHz.
    pub srp_mhz: u32,
    /// Clock of the T&I unit, MHz.
    pub tni_mhz: u32,
    /// Simulated time of the frame.
    pub milliseconds: f64,
    /// Rays traced.
    pub rays: u64,
    /// Million rays per second of simulated time.
    pub mrays_per_second: f64,
    /// The cores.
    pub cores: Vec<CoreReport>,
    /// The way to system memory.
    pub bus: BusReport,
    /// System memory.
    pub dram: DramReport,
    /// Words that cores share, though nothing keeps their caches coherent.
    pub shared_words: SharedWords,
}

impl Report {
    pub(super) fn of(
        simulation: &Simulation<'_>,
        cycles: u64,
        arch: &Arch,
        names: &[String],
    ) -> Report {
        let name = |kernel: &u32| match names.get(*kernel as usize) {
            Some(name) => name.clone(),
            None => format!("kernel {kernel}"),
        };
        let of_kernels = |cycles: &BTreeMap<u32, u64>| -> Vec<KernelCycles> {
            let of_kernel = |(kernel, &cycles): (&u32, &u64)| KernelCycles {
                kernel: name(kernel),
                cycles,
            };
            cycles.iter().map(of_kernel).collect()
        };
        let core = |CoreUnit {
                        periphery: core, ..
                    }: &CoreUnit| CoreReport {
            vliw: core.account.vliw,
            vliw_operations: core.account.vliw_operations,
            array: (core.account.array.iter())
                .map(|(kernel, &cycles)| KernelRuns {
                    kernel: name(kernel),
                    cycles,
                    operations: core.account.array_operations[kernel],
                })
                .collect(),
            switch: core.account.switch,
            memory_stall: core.account.memory_stall,
            texture_stall: core.account.texture_stall,
            instruction_stall: core.account.instruction_stall,
            context_stall: core.account.context_stall,
            sram_stall: core.account.sram_stall,
            kernel_stalls: of_kernels(&core.account.kernel_stalls),
            kernel_sram_stalls: of_kernels(&core.account.kernel_sram_stalls),
            wait: (core.account.wait.iter())
                .map(|(&port, &cycles)| PortCycles {
                    port: port_name(port).to_owned(),
                    cycles,
                })
                .collect(),
            idle: cycles - core.account.total(),
            data_cache: core.data.cache.counters,
            texture_cache: core.texture.lines.cache.counters,
            instruction_cache: core.code.instruction_counters(),
            contexts: core.code.context_counters(),
            texture_bytes: core.texture.lines.cache.counters.misses
                * u64::from(arch.system.texture_cache.line),
            texture_samples: core.texture.samples,
            tni: core.tni.counters(),
            exit_status: core.ports.exit.unwrap_or(0),
            output: String::from_utf8_lossy(&core.ports.output).into_owned(),
        };
        let cores: Vec<CoreReport> = simulation.cores.iter().map(core).collect();
        let seconds = cycles as f64 / (f64::from(arch.system.srp_mhz) * 1e6);
        let rays = cores.iter().map(|c| c.tni.unit.rays).sum();
        let mut dram = DramCounters::default();
        for path in &simulation.paths {
            dram.add(&path.counters());
        }
        let spec = &arch.system.dram;
        let end = Clock::new(arch.system.srp_mhz).start(cycles);
        let dram_cycles = Clock::new(spec.mhz).cycle_from(end);
        let per_second = |n: u64| if cycles == 0 { 0.0 } else { n as f64 / seconds };
        Report {
            width: simulation.frame.width,
            height: simulation.frame.height,
            complete: simulation.is_over(),
            tiles_taken: simulation.shared.tiles.taken(),
            tiles: simulation.shared.tiles.count(),
            cycles,
            srp_mhz: arch.system.srp_mhz,
            tni_mhz: arch.system.tni_mhz,
            milliseconds: seconds * 1e3,
            rays,
            mrays_per_second: per_second(rays) / 1e6,
            cores,
            bus: BusReport::of(&arch.system.bus, &simulation.paths, end),
            dram: DramReport::of(spec, simulation.paths.len() as u32, dram_cycles, dram),
            shared_words: simulation.shared.sharing.found,
        }
    }

    /// The T&I units together.
    pub fn tni(&self) -> TniCounters {
        let mut sum = TniCounters::default();
        for core in &self.cores {
            sum.add(&core.tni);
        }
        sum
    }
}
