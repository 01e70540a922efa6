//! The figures of a frame, from the tallies of all its tiles or of some.

use serde::Serialize;
use srp_archdesc::Arch;

use srp_runtime::system::Report;

use super::ledger::{COLUMNS, Column, Part, Tally};
use crate::survey::Estimate;

/// A figure of a frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// What it is.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// Its value and interval.
    #[serde(flatten)]
    pub estimate: Estimate,
}

/// How long reads took on average.
pub(super) fn read_ns(report: &Report, arch: &Arch) -> f64 {
    let dram = &report.dram.counters;
    dram.read_cycles as f64 / dram.reads.max(1) as f64 * 1e3 / f64::from(arch.system.dram.mhz)
}

/// The figures of a frame that was run as a whole, from the tallies of all its tiles.
pub fn known(part: &Part, arch: &Arch, kernel_names: &[String]) -> Vec<Figure> {
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
    table(
        &|columns| Estimate::exact(sum(columns)),
        &ratio,
        idle as f64,
        Estimate::exact(read_ns(&part.report, arch)),
        arch,
        kernel_names,
    )
}

/// The figures of a frame, without values.
pub fn names(arch: &Arch, kernel_names: &[String]) -> Vec<Figure> {
    let none = Estimate::exact(0.0);
    table(&|_| none, &|_, _| none, 0.0, none, arch, kernel_names)
}

/// Whether a figure counts what is done, and so needs no clock.
pub fn is_count(name: &str) -> bool {
    let counts = ["rays", "texture samples"];
    counts.contains(&name) || (name.ends_with(" a ray") && !name.starts_with("residence"))
}

type Total<'a> = dyn Fn(&[usize]) -> Estimate + 'a;
type Ratio<'a> = dyn Fn(&[usize], &[usize]) -> Estimate + 'a;

/// The figures, in their order. `idle` are the cycles of all cores for which they have nothing to do while others have.
pub(super) fn table(
    total: &Total<'_>,
    ratio: &Ratio<'_>,
    idle: f64,
    latency: Estimate,
    arch: &Arch,
    kernel_names: &[String],
) -> Vec<Figure> {
    use Column as C;
    let mut figures = Vec::new();
    let mut put = |name: &str, unit: &'static str, estimate: Estimate| {
        figures.push(Figure {
            name: name.to_owned(),
            unit,
            estimate,
        });
    };
    let one = |column: C| [column as usize];
    let cores = f64::from(arch.system.cores);
    let mhz = f64::from(arch.system.srp_mhz);
    let at_work = total(&one(C::Cycles));
    let cycles = Estimate {
        value: (at_work.value + idle) / cores,
        half_width: at_work.half_width / cores,
    };
    // What is measured in cycles of tiles, for cycles of the frame.
    let share = at_work.value / (at_work.value + idle).max(1.0) * cores;
    let per_cycle = |above: &[usize]| ratio(above, &one(C::Cycles)).times(share);
    put("frame", "cycles", cycles);
    put("frame time", "ms", cycles.times(1e-3 / mhz));
    put("rays", "", total(&one(C::Rays)));
    put("rate", "Mrays/s", per_cycle(&one(C::Rays)).times(mhz));
    let work = [
        ("VLIW", C::Vliw),
        ("mode switch", C::Switch),
        ("memory stall", C::MemoryStall),
        ("texture stall", C::TextureStall),
        ("wait", C::Wait),
    ];
    for (name, column) in work {
        put(name, "cycles", total(&one(column)));
    }
    for (i, name) in kernel_names.iter().enumerate() {
        put(&format!("array: {name}"), "cycles", total(&[COLUMNS + i]));
    }
    let a_ray = [
        ("hits a ray", "", C::Hits),
        ("inner nodes a ray", "", C::InnerVisits),
        ("leaves a ray", "", C::LeafVisits),
        ("triangle tests a ray", "", C::Tests),
        ("residence of a ray", "T&I cycles", C::Resident),
    ];
    for (name, unit, column) in a_ray {
        put(name, unit, ratio(&one(column), &one(C::Rays)));
    }
    let caches = [
        ("TRV L1 hits", C::TrvL1Hits, C::TrvL1Misses),
        ("TRV L2 hits", C::TrvL2Hits, C::TrvL2Misses),
        ("IST L1 hits", C::IstL1Hits, C::IstL1Misses),
        ("data cache hits", C::DataHits, C::DataMisses),
        ("texture cache hits", C::TextureHits, C::TextureMisses),
    ];
    for (name, hits, misses) in caches {
        let rate = ratio(&one(hits), &[hits as usize, misses as usize]);
        put(name, "%", rate.times(100.0));
    }
    let accesses = [
        (
            "data cache accesses",
            [C::DataHits as usize, C::DataMisses as usize],
        ),
        (
            "texture cache accesses",
            [C::TextureHits as usize, C::TextureMisses as usize],
        ),
    ];
    for (name, columns) in accesses {
        put(name, "", total(&columns));
    }
    put("texture samples", "", total(&one(C::Samples)));
    let read = [C::TniBytes as usize, C::BytesRead as usize];
    let moved = [read[0], read[1], C::BytesWritten as usize];
    put("bytes read", "", total(&read));
    put("bytes written", "", total(&one(C::BytesWritten)));
    put("memory", "GB/s", per_cycle(&moved).times(mhz * 1e-3));
    put("latency of reads", "ns", latency);
    figures
}
