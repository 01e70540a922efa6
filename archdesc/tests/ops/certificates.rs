//! Certificates of units: the figures that were measured for this design before it was written, by
//! programs of their own, and an oracle in exact arithmetic.

use srp_archdesc::arch::{Approx, Refine};
use srp_archdesc::certify::{Function, certify};
use srp_archdesc::ops::semantics::elementary::rcp;
use srp_archdesc::structure::Structure;

fn approx(bits: u32, steps: u32, fused: bool) -> Approx {
    Approx::Table {
        structure: Structure::Table,
        bits,
        steps,
        fused,
        refine: Refine::Unit,
    }
}

/// Largest error in units in the last place, and share of results that are the nearest float.
#[test]
fn reciprocals_have_the_errors_that_such_units_have() {
    for (approx, worst, rounded) in [
        (approx(12, 1, false), 2.3, 0.55..0.70),
        (approx(12, 2, false), 1.6, 0.65..0.80),
        (approx(12, 1, true), 1.0, 0.95..0.99),
        (approx(12, 2, true), 0.5001, 0.9999..1.1),
        (Approx::Exact, 0.5, 1.0..1.1),
    ] {
        let found = certify(Function::Rcp, approx);
        println!("{found:?}");
        assert!(found.worst_ulp <= worst, "{found:?}");
        assert!(rounded.contains(&found.rounded), "{found:?}");
        assert!(found.mean_ulp <= found.worst_ulp && found.mean_ulp > 0.2);
        assert_eq!(found.powers_exact, Some(true));
    }
    // The value of the first interval stands at its beginning, so its end is off by all of it.
    for (bits, least, most) in [(5, 260_000.0, 524_288.0), (12, 2_000.0, 4_096.0)] {
        let found = certify(Function::Rcp, approx(bits, 0, true));
        println!("{found:?}");
        assert!((least..=most).contains(&found.worst_ulp), "{found:?}");
        assert!(found.correct_bits >= f64::from(bits) && found.monotone == Some(true));
    }
    // A step without fused operations loses the order of neighbours.
    let separate = certify(Function::Rcp, approx(12, 1, false));
    assert_eq!(separate.monotone, Some(false));
}

/// |m · y − 2^47| in units of m, for the mantissas m and y of a reciprocal: no rounding anywhere.
#[test]
fn the_worst_operand_is_worst_in_exact_arithmetic() {
    for approx in [approx(8, 1, true), approx(8, 1, false)] {
        let found = certify(Function::Rcp, approx);
        let (bits, steps) = approx.arguments();
        let error = |x: u32| {
            let m = u64::from(x & 0x7f_ffff | 0x80_0000);
            let y = rcp(x, bits, steps);
            // 2^(exponent − 150) · mantissa, as a multiple of 2^-24, the place of results below 1.
            let shift = (y >> 23) + 24 - 150;
            let y = u64::from(y & 0x7f_ffff | 0x80_0000) << shift;
            // 1/x is 2^47 / m multiples of 2^-24.
            (m * y).abs_diff(1 << 47) as f64 / m as f64
        };
        let close = (error(found.worst_at) - found.worst_ulp).abs();
        assert!(close < 1e-6 * found.worst_ulp, "{found:?}");
        let sample = (0x3f80_0001..0x4000_0000).step_by(997);
        assert!(sample.map(error).all(|e| e <= found.worst_ulp * 1.000_001));
    }
}

#[test]
fn the_other_functions_have_certificates_too() {
    for (function, approx, worst, bits) in [
        (Function::Rsqrt, approx(12, 1, false), 2.3, 22.0),
        (Function::Rsqrt, approx(12, 1, true), 1.2, 22.9),
        (Function::Sqrt, approx(12, 1, true), 1.8, 22.4),
        (Function::Div, approx(12, 1, true), 1.7, 22.4),
        (Function::Exp2, approx(12, 0, true), 2_100.0, 12.0),
        (Function::Log2, approx(12, 0, true), f64::INFINITY, 12.0),
        (Function::Sin, approx(12, 0, true), f64::INFINITY, 12.0),
        (Function::Cos, approx(12, 0, true), f64::INFINITY, 12.0),
        (Function::Exp2, Approx::Exact, 0.501, 23.9),
    ] {
        let found = certify(function, approx);
        println!("{found:?}");
        assert!(found.worst_ulp <= worst, "{found:?}");
        assert!(found.correct_bits >= bits, "{found:?}");
        assert_ne!(found.powers_exact, Some(false));
        assert_eq!(found.monotone.is_none(), function == Function::Div);
    }
}
