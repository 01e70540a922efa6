//! The figures of a frame from batches of its units.

use srp_archdesc::Arch;

use super::super::figures::{FrameFigure, FrameQuantity as Q, Measured};
use super::super::ledger::Tally;
use super::Batch;
use crate::figure::{Quantity, Unit, estimate_of};
use crate::survey::{Estimate, Population, Sample, relative_error};

/// How far off a figure may be with all units drawn, because caches are warmed by a first pass that is not exact, and
/// units begin and end among other tiles than in the frame: parts of the value, or of 100 % for rates. What is
/// rare, and may be in no unit that is drawn, is in them too. They are what was seen, rounded up, of five scenes
/// of which all units were run (docs/fidelity.md).
fn beyond_drawing(figure: &FrameFigure) -> f64 {
    let part = match &figure.quantity {
        Q::Cycles | Q::Time | Q::Rate | Q::Residence => 0.007,
        Q::Wait => 0.035,
        Q::MemoryStall | Q::BytesRead => 0.025,
        Q::TextureStall | Q::Bandwidth | Q::ReadLatency | Q::BytesWritten => 0.01,
        Q::Vliw | Q::ModeSwitch => 0.003,
        Q::TrvL1Hits | Q::IstL1Hits => 0.012,
        Q::TrvL2Hits => 0.045,
        Q::DataCacheHits | Q::TextureCacheHits => 0.003,
        Q::Rays
        | Q::Array { .. }
        | Q::HitsPerRay
        | Q::InnerNodesPerRay
        | Q::LeavesPerRay
        | Q::TestsPerRay
        | Q::DataCacheAccesses
        | Q::TextureCacheAccesses
        | Q::TextureSamples => 0.002,
    };
    match figure.quantity.unit() {
        Unit::Percent => 100.0 * part,
        _ => part * figure.estimate.value.abs(),
    }
}

/// The figures of a frame from some batches of it, and the relative error that drawing leaves its cycles.
pub(super) fn figures(
    population: &Population,
    batches: &[Batch],
    arch: &Arch,
    kernel_names: &[String],
) -> (Vec<FrameFigure>, f64) {
    let units: Vec<u32> = batches.iter().flat_map(|b| b.units.clone()).collect();
    let tallies: Vec<&Tally> = batches.iter().flat_map(|b| &b.tallies).collect();
    let sample = Sample::new(population, &units);
    let values = |columns: &[usize]| -> Vec<f64> {
        let sum = |t: &&Tally| columns.iter().map(|&c| t[c]).sum::<u64>() as f64;
        tallies.iter().map(sum).collect()
    };
    let mean = |of: &dyn Fn(&Batch) -> f64| {
        batches.iter().map(of).sum::<f64>() / batches.len().max(1) as f64
    };
    let around = |columns: &[usize]| {
        let of = |b: &Batch| columns.iter().map(|&c| b.around[c]).sum::<u64>() as f64;
        mean(&of)
    };
    let latencies: Vec<f64> = batches.iter().map(|b| b.read_ns).collect();
    let latency = Estimate {
        value: mean(&|b| b.read_ns),
        half_width: match relative_error(&latencies) {
            Some(error) => error * mean(&|b| b.read_ns),
            None => f64::INFINITY,
        },
    };
    let measured = Measured {
        total: &|columns| {
            let total = sample.total(&values(columns));
            Estimate {
                value: total.value + around(columns),
                ..total
            }
        },
        ratio: &|above, below| {
            let ratio = sample.ratio(&values(above), &values(below));
            let (of, more) = (sample.total(&values(below)).value, around(below));
            match of + more {
                0.0 => ratio,
                all => Estimate {
                    value: (ratio.value * of + around(above)) / all,
                    half_width: ratio.half_width * of / all,
                },
            }
        },
        idle: 0.0,
        latency,
    };
    let mut figures = measured.figures(arch, kernel_names);
    let cycles = estimate_of(&figures, &Q::Cycles);
    let error = cycles.map_or(0.0, |cycles| cycles.relative());
    for figure in &mut figures {
        figure.estimate.half_width += beyond_drawing(figure);
    }
    (figures, error)
}
