//! The figures of a frame from batches of its units.

use srp_archdesc::Arch;

use super::super::figures::{Figure, table};
use super::super::ledger::Tally;
use super::Batch;
use crate::survey::{Estimate, Population, Sample, relative_error};

/// What the drawing of units does not know of a figure: how far off it may be with all of them, because caches are
/// warmed by a look that is not exact, and units begin and end among other tiles than in the frame. Parts of the
/// value, or of 100 % for rates; what is rare, and may be in no unit that is drawn, is in them too. They are what was seen, rounded up, of five scenes of which all units were run
/// (docs/fidelity.md).
fn beyond_drawing(figure: &Figure) -> f64 {
    let points = figure.unit == "%";
    let part = match figure.name.as_str() {
        "frame" | "frame time" | "rate" | "residence of a ray" => 0.007,
        "wait" => 0.035,
        "memory stall" | "bytes read" => 0.025,
        "texture stall" | "memory" | "latency of reads" | "bytes written" => 0.01,
        "VLIW" | "mode switch" => 0.003,
        "TRV L1 hits" | "IST L1 hits" => 0.012,
        "TRV L2 hits" => 0.045,
        _ if points => 0.003,
        _ => 0.002,
    };
    match points {
        true => 100.0 * part,
        false => part * figure.estimate.value.abs(),
    }
}

/// The figures of a frame from some batches of it, and the relative error that drawing leaves its cycles.
pub(super) fn figures(
    population: &Population,
    batches: &[Batch],
    arch: &Arch,
    kernel_names: &[String],
) -> (Vec<Figure>, f64) {
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
    let mut figures = table(
        &|columns| {
            let total = sample.total(&values(columns));
            Estimate {
                value: total.value + around(columns),
                ..total
            }
        },
        &|above, below| {
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
        0.0,
        latency,
        arch,
        kernel_names,
    );
    let error = figures.first().map_or(0.0, |f| f.estimate.relative());
    for figure in &mut figures {
        figure.estimate.half_width += beyond_drawing(figure);
    }
    (figures, error)
}
