//! The figures of a frame, from the tallies of all its tiles or of some.

use std::fmt;

use srp_archdesc::Arch;
use srp_runtime::system::Report;

use super::ledger::{COLUMNS, Column, Part, Tally};
use crate::figure::{self, Quantity, Unit};
use crate::survey::Estimate;

/// A quantity that is measured of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FrameQuantity {
    /// Cycles of the SRP clock.
    Cycles,
    /// Simulated time.
    Time,
    /// Rays.
    Rays,
    /// Rays over the time.
    Rate,
    /// Cycles of all cores with VLIW bundles.
    Vliw,
    /// Cycles of changes between VLIW engine and array.
    ModeSwitch,
    /// Cycles of stalls because of data caches.
    MemoryStall,
    /// Cycles of stalls because of texture caches.
    TextureStall,
    /// Cycles of waiting for ports.
    Wait,
    /// Cycles of a kernel on the array.
    Array {
        /// Its number.
        kernel: usize,
        /// Its name.
        name: String,
    },
    /// Rays that hit something, over all.
    HitsPerRay,
    /// Visits of inner nodes over rays.
    InnerNodesPerRay,
    /// Visits of leaves over rays.
    LeavesPerRay,
    /// Ray–triangle tests over rays.
    TestsPerRay,
    /// Cycles that a ray is in the T&I unit.
    Residence,
    /// Hit rate of the traversal units' level-1 caches.
    TrvL1Hits,
    /// Hit rate of their level-2 cache.
    TrvL2Hits,
    /// Hit rate of the intersection units' caches.
    IstL1Hits,
    /// Hit rate of the data caches.
    DataCacheHits,
    /// Hit rate of the texture caches.
    TextureCacheHits,
    /// Accesses to the data caches.
    DataCacheAccesses,
    /// Accesses to the texture caches.
    TextureCacheAccesses,
    /// Samples of textures.
    TextureSamples,
    /// Bytes read from memory.
    BytesRead,
    /// Bytes written to memory.
    BytesWritten,
    /// Bytes moved over the time.
    Bandwidth,
    /// Mean time of a read.
    ReadLatency,
}

/// A figure of a frame.
pub type FrameFigure = figure::Figure<FrameQuantity>;

use FrameQuantity as Q;

impl fmt::Display for FrameQuantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self {
            Q::Cycles => "frame",
            Q::Time => "frame time",
            Q::Rays => "rays",
            Q::Rate => "rate",
            Q::Vliw => "VLIW",
            Q::ModeSwitch => "mode switch",
            Q::MemoryStall => "memory stall",
            Q::TextureStall => "texture stall",
            Q::Wait => "wait",
            Q::Array { name, .. } => return f.pad(&format!("array: {name}")),
            Q::HitsPerRay => "hits a ray",
            Q::InnerNodesPerRay => "inner nodes a ray",
            Q::LeavesPerRay => "leaves a ray",
            Q::TestsPerRay => "triangle tests a ray",
            Q::Residence => "residence of a ray",
            Q::TrvL1Hits => "TRV L1 hits",
            Q::TrvL2Hits => "TRV L2 hits",
            Q::IstL1Hits => "IST L1 hits",
            Q::DataCacheHits => "data cache hits",
            Q::TextureCacheHits => "texture cache hits",
            Q::DataCacheAccesses => "data cache accesses",
            Q::TextureCacheAccesses => "texture cache accesses",
            Q::TextureSamples => "texture samples",
            Q::BytesRead => "bytes read",
            Q::BytesWritten => "bytes written",
            Q::Bandwidth => "memory",
            Q::ReadLatency => "latency of reads",
        };
        f.pad(name)
    }
}

impl Quantity for FrameQuantity {
    fn unit(&self) -> Unit {
        match self {
            Q::Cycles | Q::Vliw | Q::ModeSwitch | Q::MemoryStall | Q::TextureStall | Q::Wait => {
                Unit::Cycles
            }
            Q::Array { .. } => Unit::Cycles,
            Q::Time => Unit::Milliseconds,
            Q::Rate => Unit::MraysPerSecond,
            Q::Residence => Unit::TniCycles,
            Q::TrvL1Hits | Q::TrvL2Hits | Q::IstL1Hits | Q::DataCacheHits | Q::TextureCacheHits => {
                Unit::Percent
            }
            Q::Bandwidth => Unit::GigabytesPerSecond,
            Q::ReadLatency => Unit::Nanoseconds,
            Q::Rays
            | Q::HitsPerRay
            | Q::InnerNodesPerRay
            | Q::LeavesPerRay
            | Q::TestsPerRay
            | Q::DataCacheAccesses
            | Q::TextureCacheAccesses
            | Q::TextureSamples
            | Q::BytesRead
            | Q::BytesWritten => Unit::Number,
        }
    }
}

impl FrameQuantity {
    /// The quantities of a frame by a program with these kernels, in the order of figures.
    pub fn all(kernel_names: &[String]) -> Vec<FrameQuantity> {
        let before = [
            Q::Cycles,
            Q::Time,
            Q::Rays,
            Q::Rate,
            Q::Vliw,
            Q::ModeSwitch,
            Q::MemoryStall,
            Q::TextureStall,
            Q::Wait,
        ];
        let arrays = (0..).zip(kernel_names).map(|(kernel, name)| Q::Array {
            kernel,
            name: name.clone(),
        });
        let behind = [
            Q::HitsPerRay,
            Q::InnerNodesPerRay,
            Q::LeavesPerRay,
            Q::TestsPerRay,
            Q::Residence,
            Q::TrvL1Hits,
            Q::TrvL2Hits,
            Q::IstL1Hits,
            Q::DataCacheHits,
            Q::TextureCacheHits,
            Q::DataCacheAccesses,
            Q::TextureCacheAccesses,
            Q::TextureSamples,
            Q::BytesRead,
            Q::BytesWritten,
            Q::Bandwidth,
            Q::ReadLatency,
        ];
        before.into_iter().chain(arrays).chain(behind).collect()
    }

    /// True if it counts events, and so needs no clock.
    pub fn is_count(&self) -> bool {
        matches!(
            self,
            Q::Rays
                | Q::TextureSamples
                | Q::HitsPerRay
                | Q::InnerNodesPerRay
                | Q::LeavesPerRay
                | Q::TestsPerRay
        )
    }
}

/// How long reads took on average.
pub(super) fn read_ns(report: &Report, arch: &Arch) -> f64 {
    let dram = &report.dram.counters;
    dram.read_cycles as f64 / dram.reads.max(1) as f64 * 1e3 / f64::from(arch.system.dram.mhz)
}

/// The figures of a frame that was run as a whole, from the tallies of all its tiles.
pub fn known(part: &Part, arch: &Arch, kernel_names: &[String]) -> Vec<FrameFigure> {
    let sum = |columns: &[usize]| -> f64 {
        let of = |t: &Tally| {
            columns
                .iter()
                .map(|&c| t.get(c).copied().unwrap_or(0))
                .sum::<u64>()
        };
        (part.tallies.iter().map(of).sum::<u64>() + of(&part.around)) as f64
    };
    let idle: u64 = part.report.cores.iter().map(|c| c.idle).sum();
    let ratio = |above: &[usize], below: &[usize]| match sum(below) {
        0.0 => Estimate::exact(0.0),
        below => Estimate::exact(sum(above) / below),
    };
    let measured = Measured {
        total: &|columns| Estimate::exact(sum(columns)),
        ratio: &ratio,
        idle: idle as f64,
        latency: Estimate::exact(read_ns(&part.report, arch)),
    };
    measured.figures(arch, kernel_names)
}

/// The estimates that figures are computed from.
pub(super) struct Measured<'a> {
    /// The sum of some columns over all tiles.
    pub(super) total: &'a dyn Fn(&[usize]) -> Estimate,
    /// The sum of some columns over that of others.
    pub(super) ratio: &'a dyn Fn(&[usize], &[usize]) -> Estimate,
    /// Cycles of all cores for which they have nothing to do while others have.
    pub(super) idle: f64,
    /// Mean time of reads in ns.
    pub(super) latency: Estimate,
}

impl Measured<'_> {
    /// The figures of a frame on a machine.
    pub(super) fn figures(&self, arch: &Arch, kernel_names: &[String]) -> Vec<FrameFigure> {
        let at_work = (self.total)(&[Column::Cycles as usize]);
        let all = FrameQuantity::all(kernel_names).into_iter();
        let figure = |quantity| FrameFigure {
            estimate: self.estimate(&quantity, at_work, arch),
            quantity,
        };
        all.map(figure).collect()
    }

    /// A figure of a frame in which cores have been at work for so many cycles.
    fn estimate(&self, quantity: &FrameQuantity, at_work: Estimate, arch: &Arch) -> Estimate {
        use Column as C;
        let cores = f64::from(arch.system.cores);
        let mhz = f64::from(arch.system.srp_mhz);
        let cycles = Estimate {
            value: (at_work.value + self.idle) / cores,
            half_width: at_work.half_width / cores,
        };
        let total = |column: C| (self.total)(&[column as usize]);
        let per_ray = |column: C| (self.ratio)(&[column as usize], &[C::Rays as usize]);
        // Converts rates per cycle of tiles to rates per cycle of the frame.
        let share = at_work.value / (at_work.value + self.idle).max(1.0) * cores;
        let per_cycle = |above: &[usize]| (self.ratio)(above, &[C::Cycles as usize]).times(share);
        let both = |hits: C, misses: C| [hits as usize, misses as usize];
        let rate =
            |hits: C, misses: C| (self.ratio)(&[hits as usize], &both(hits, misses)).times(100.0);
        match *quantity {
            Q::Cycles => cycles,
            Q::Time => cycles.times(1e-3 / mhz),
            Q::Rays => total(C::Rays),
            Q::Rate => per_cycle(&[C::Rays as usize]).times(mhz),
            Q::Vliw => total(C::Vliw),
            Q::ModeSwitch => total(C::Switch),
            Q::MemoryStall => total(C::MemoryStall),
            Q::TextureStall => total(C::TextureStall),
            Q::Wait => total(C::Wait),
            Q::Array { kernel, .. } => (self.total)(&[COLUMNS + kernel]),
            Q::HitsPerRay => per_ray(C::Hits),
            Q::InnerNodesPerRay => per_ray(C::InnerVisits),
            Q::LeavesPerRay => per_ray(C::LeafVisits),
            Q::TestsPerRay => per_ray(C::Tests),
            Q::Residence => per_ray(C::Resident),
            Q::TrvL1Hits => rate(C::TrvL1Hits, C::TrvL1Misses),
            Q::TrvL2Hits => rate(C::TrvL2Hits, C::TrvL2Misses),
            Q::IstL1Hits => rate(C::IstL1Hits, C::IstL1Misses),
            Q::DataCacheHits => rate(C::DataHits, C::DataMisses),
            Q::TextureCacheHits => rate(C::TextureHits, C::TextureMisses),
            Q::DataCacheAccesses => (self.total)(&both(C::DataHits, C::DataMisses)),
            Q::TextureCacheAccesses => (self.total)(&both(C::TextureHits, C::TextureMisses)),
            Q::TextureSamples => total(C::Samples),
            Q::BytesRead => (self.total)(&both(C::TniBytes, C::BytesRead)),
            Q::BytesWritten => total(C::BytesWritten),
            Q::Bandwidth => {
                let moved = [C::TniBytes, C::BytesRead, C::BytesWritten].map(|c| c as usize);
                per_cycle(&moved).times(mhz * 1e-3)
            }
            Q::ReadLatency => self.latency,
        }
    }
}
