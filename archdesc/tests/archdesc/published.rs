//! The model of costs beside units that were built. `docs/costs.md` has this table, with sources; the
//! test keeps the model within what it says there.

use srp_archdesc::arch::Approx;
use srp_archdesc::cost::special::{Build, Unit, unit};
use srp_archdesc::cost::{memory, operator};
use srp_archdesc::structure::{Special, Structure};

/// One figure of a unit: what was published, what the model says, how far it may be off in %.
type Figure = (&'static str, &'static str, f64, f64, f64);

fn recurrence(radix: u32, unrolled: bool) -> Structure {
    Structure::Recurrence { radix, unrolled }
}

/// At 1 GHz.
fn cost(special: Special, structure: Structure, bits: u32) -> Unit {
    unit(
        special,
        Approx::built(structure, bits),
        &Build::default(),
        1000,
    )
}

fn latency(radix: u32, bits: u32) -> f64 {
    let latency = cost(Special::Div, recurrence(radix, false), bits).latency;
    latency.map_or(0.0, f64::from)
}

fn table(special: Special, degree: u32, bits: u32) -> (f64, f64) {
    let segments = special.segments(degree, bits);
    let structure = Structure::Polynomial { degree, segments };
    let entries = f64::from(1u32 << segments) * special.curves().len() as f64;
    (entries, special.table_bits(structure, bits) as f64)
}

fn figures() -> Vec<Figure> {
    let trax = cost(Special::Rcp, recurrence(2, true), 24);
    let trax_latency = trax.latency.map_or(0.0, f64::from);
    let small = cost(Special::Div, recurrence(16, false), 24);
    let (rcp, rcp_bits) = table(Special::Rcp, 2, 23);
    let (rsqrt, rsqrt_bits) = table(Special::Rsqrt, 2, 22);
    let (exp2, exp2_bits) = table(Special::Exp2, 2, 22);
    let (log2, log2_bits) = table(Special::Log2, 2, 22);
    let (sine, sine_bits) = table(Special::Sincos, 2, 21);
    // 45 nm against 65: area × 0.66.
    let horowitz = |um2: f64| um2 / 0.66;
    vec![
        ("SimTRaX reciprocal", "µm²", 112_000.0, trax.area_um2, 3.0),
        ("", "pJ", 156.3, trax.energy_pj, 3.0),
        ("", "cycles", 16.0, trax_latency, 7.0),
        (
            "cv32e40p division",
            "µm²",
            7000.0 * 1.44,
            small.area_um2,
            15.0,
        ),
        ("", "cycles, full", 8.0, latency(16, 24), 0.0),
        ("", "cycles, 12 bits", 5.0, latency(16, 12), 0.0),
        ("Cortex-M4 division", "cycles", 14.0, latency(4, 24), 1.0),
        (
            "HardFloat divSqrtSmall",
            "cycles",
            26.0,
            latency(2, 24),
            5.0,
        ),
        ("G80 1/x", "segments", 128.0, rcp, 0.0),
        ("", "ROM bits", 6656.0, rcp_bits, 35.0),
        ("G80 1/√x", "segments", 128.0, rsqrt, 0.0),
        ("", "ROM bits", 6656.0, rsqrt_bits, 35.0),
        ("G80 2^x", "segments", 64.0, exp2, 50.0),
        ("", "ROM bits", 3328.0, exp2_bits, 50.0),
        ("G80 log2", "segments", 64.0, log2, 0.0),
        ("", "ROM bits", 3328.0, log2_bits, 35.0),
        ("G80 sine", "segments", 64.0, sine, 0.0),
        ("", "ROM bits", 3328.0, sine_bits, 35.0),
        (
            "Horowitz fp32 multiplier",
            "µm²",
            horowitz(7700.0),
            operator::float_mul(24).area_um2,
            20.0,
        ),
        (
            "Horowitz fp16 multiplier",
            "µm²",
            horowitz(1640.0),
            operator::float_mul(11).area_um2,
            25.0,
        ),
        (
            "Horowitz fp32 adder",
            "µm²",
            horowitz(4184.0),
            operator::float_add(24).area_um2,
            60.0,
        ),
        (
            "CACTI 64×32, 2r1w",
            "µm²",
            8000.0,
            memory::file_area(64, 32, 3),
            5.0,
        ),
        (
            "CACTI 64×32, 8r4w",
            "µm²",
            76_500.0,
            memory::file_area(64, 32, 12),
            5.0,
        ),
        (
            "CACTI 240 KB RAM",
            "mm²",
            1.65,
            memory::SRAM_BIT * 240.0 * 8192.0 * 1e-6,
            10.0,
        ),
    ]
}

#[test]
fn the_model_is_near_published_units() {
    for (name, what, theirs, ours, most) in figures() {
        let off = 100.0 * (ours / theirs - 1.0);
        println!("{name:26} {what:16} {theirs:10.1} {ours:10.1} {off:+6.1} %");
        assert!(
            off.abs() <= most + 1e-9,
            "{name} {what}: {ours} for {theirs}"
        );
    }
}

/// Whatever the structure, more bits take no less of anything, and a faster clock no fewer cycles.
#[test]
fn more_bits_cost_no_less() {
    for special in Special::ALL {
        let mut last = None::<[Vec<f64>; 4]>;
        for bits in 4..=23 {
            let polynomial = |degree| Structure::Polynomial {
                degree,
                segments: special.segments(degree, bits),
            };
            let all = [
                Structure::Table,
                Structure::Offsets { tables: 1 },
                Structure::Offsets { tables: 2 },
                polynomial(1),
                polynomial(2),
                polynomial(3),
                recurrence(4, false),
                recurrence(2, true),
                Structure::Cordic,
            ];
            let can = all
                .into_iter()
                .filter(|&structure| special.can_be(structure));
            let units: Vec<_> = can
                .map(|structure| cost(special, structure, bits))
                .collect();
            let of = |f: fn(&Unit) -> f64| units.iter().map(f).collect();
            let now: [Vec<f64>; 4] = [
                of(|unit| unit.area_um2),
                of(|unit| unit.energy_pj),
                of(|unit| unit.latency.map_or(0.0, f64::from)),
                of(|unit| unit.interval.map_or(0.0, f64::from)),
            ];
            if let Some(last) = last {
                for (less, more) in last.iter().flatten().zip(now.iter().flatten()) {
                    // A polynomial with twice the segments has narrower multipliers.
                    assert!(*more >= 0.8 * less, "{special:?} {bits}: {less} to {more}");
                }
            }
            last = Some(now);
        }
    }
}

/// Steps take cycles, area and energy; and what a step of a plain table buys is cheaper than as many
/// bits of table.
#[test]
fn steps_cost_and_are_worth_it() {
    for special in [Special::Rcp, Special::Rsqrt, Special::Sqrt, Special::Div] {
        let with = |steps| unit(special, Approx::table(8, steps), &Build::default(), 1000);
        for steps in 0..3 {
            let (less, more) = (with(steps), with(steps + 1));
            assert!(more.latency > less.latency && more.interval > less.interval);
            assert!(more.energy_pj > less.energy_pj);
        }
        let table = unit(special, Approx::table(16, 0), &Build::default(), 1000);
        assert!(with(1).area_um2 < table.area_um2 / 4.0);
    }
    let slow = unit(Special::Rcp, Approx::table(12, 1), &Build::default(), 500);
    let quick = unit(Special::Rcp, Approx::table(12, 1), &Build::default(), 1000);
    assert!(slow.latency < quick.latency);
}
