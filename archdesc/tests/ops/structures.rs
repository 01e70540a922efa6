//! Units by every structure keep what their precision promises, on every mantissa. A run tries one precision of a function, and the
//! next run another; `SRP_STRUCTURES=all` tries all of them, `SRP_STRUCTURES=N` those of a run that printed N.

use srp_archdesc::arch::{Approx, Refine};
use srp_archdesc::certify::{Function, certify};
use srp_archdesc::isa::Opcode;
use srp_archdesc::ops::semantics::approximation::{Curve, rounded};
use srp_archdesc::structure::{Special, Structure};

fn special(function: Function) -> Special {
    let op = Opcode::parse(function.name()).filter(|op| *op != Opcode::Div);
    op.and_then(Special::of).unwrap_or(Special::Div)
}

fn polynomial(function: Function, degree: u32, bits: u32) -> Structure {
    let segments = special(function).segments(degree, bits);
    Structure::Polynomial { degree, segments }
}

/// One function for each curve that tables cover.
const CURVES: [Function; 5] = [
    Function::Rcp,
    Function::Rsqrt,
    Function::Exp2,
    Function::Log2,
    Function::Sin,
];

const RADIX_4: Structure = Structure::Recurrence {
    radix: 4,
    unrolled: false,
};

fn keeps(function: Function, structure: Structure, bits: u32) {
    if !special(function).can_be(structure) {
        return;
    }
    let found = certify(function, Approx::built(structure, bits));
    println!(
        "{:6} {structure} {bits}: {:.2} of {:.2} bits",
        function.name(),
        found.correct_bits,
        found.promised_bits
    );
    assert!(found.correct_bits >= found.promised_bits, "{found:?}");
    // Units with tables test for operands without a fraction.
    if structure.is_tabulated() && !matches!(function, Function::Rsqrt | Function::Sqrt) {
        assert_ne!(found.powers_exact, Some(false), "{found:?}");
    }
}

/// One of some precisions, for the function with this number; or all of them.
fn some<T: Copy>(all: &[T], function: usize) -> Vec<T> {
    let asked = std::env::var("SRP_STRUCTURES").unwrap_or_default();
    if asked == "all" {
        return all.to_vec();
    }
    let now = std::time::SystemTime::UNIX_EPOCH.elapsed();
    let turn = asked
        .parse()
        .unwrap_or(now.map_or(0, |since| since.as_secs() as usize));
    println!("SRP_STRUCTURES={turn}");
    vec![all[(turn + function) % all.len()]]
}

#[test]
fn tables_of_offsets_keep_their_bits() {
    for (number, function) in CURVES.into_iter().enumerate() {
        for (tables, bits) in some(&[(1, 4), (1, 9), (2, 12), (4, 23)], number) {
            keeps(function, Structure::Offsets { tables }, bits);
        }
    }
}

#[test]
fn polynomials_keep_their_bits() {
    for (number, function) in CURVES.into_iter().enumerate() {
        for (degree, bits) in some(&[(1, 12), (2, 16), (3, 23)], number) {
            keeps(function, polynomial(function, degree, bits), bits);
        }
    }
    for function in [Function::Sqrt, Function::Div] {
        keeps(function, polynomial(function, 2, 23), 23);
    }
}

#[test]
fn digit_recurrence_is_correctly_rounded() {
    for function in [
        Function::Rcp,
        Function::Rsqrt,
        Function::Sqrt,
        Function::Div,
    ] {
        for bits in [4, 11, 23] {
            keeps(function, RADIX_4, bits);
        }
        // With all bits it is the exact function.
        let exact = certify(function, Approx::built(RADIX_4, 24));
        assert!(exact.rounded > 0.999_999, "{exact:?}");
    }
}

#[test]
fn rotations_keep_their_bits() {
    for (number, function) in Function::ALL.into_iter().enumerate() {
        for bits in some(&[4, 23], number) {
            keeps(function, Structure::Cordic, bits);
        }
    }
}

#[test]
fn what_lies_between_is_rounded_to_even() {
    for p in [2, 11, 23] {
        let least = 1u32 << (p - 1);
        for number in [least, least + 1, 2 * least - 1] {
            let even = number + number % 2;
            for (beyond, expected) in [
                (0.0, number),
                (0.499, number),
                (0.5, even),
                (0.501, number + 1),
            ] {
                for scale in [-40, 0, 7] {
                    let scale = 2f64.powi(scale);
                    let found = rounded((f64::from(number) + beyond) * scale, p);
                    assert_eq!(
                        found,
                        f64::from(expected) * scale,
                        "{number} + {beyond}, {p}"
                    );
                }
            }
        }
    }
}

/// A seed by any structure is squared by a step.
#[test]
fn steps_improve_any_seed() {
    for structure in [
        Structure::Offsets { tables: 1 },
        polynomial(Function::Rsqrt, 2, 12),
    ] {
        for function in [Function::Rcp, Function::Rsqrt, Function::Div] {
            let approx = Approx::Table {
                structure,
                bits: 12,
                steps: 1,
                fused: true,
                refine: Refine::Unit,
            };
            let found = certify(function, approx);
            assert!(found.correct_bits >= found.promised_bits, "{found:?}");
            assert!(found.correct_bits > 21.0, "{found:?}");
        }
    }
}

/// Segments of polynomials follow from derivatives over factorials: here of closed forms, and by value.
#[test]
fn segments_follow_from_derivatives() {
    use std::f64::consts::{FRAC_PI_2, LN_2, LOG2_E};
    let near = |curve: Curve, n: u32, expected: f64| {
        let found = curve.taylor(n);
        assert!(
            (found / expected - 1.0).abs() < 1e-12,
            "{n}: {found} {expected}"
        );
    };
    let factorials = [1.0, 2.0, 6.0, 24.0];
    for (n, factorial) in (1..).zip(factorials) {
        near(Curve::Reciprocal, n, 1.0);
        near(Curve::Power, n, LN_2.powi(n as i32) / factorial);
        near(Curve::QuarterSine, n, FRAC_PI_2.powi(n as i32) / factorial);
        near(Curve::Logarithm, n, LOG2_E / f64::from(n));
    }
    // Binomials of −1/2.
    for (n, binomial) in [
        (1, 1.0 / 2.0),
        (2, 3.0 / 8.0),
        (3, 5.0 / 16.0),
        (4, 35.0 / 128.0),
    ] {
        near(Curve::InverseRoot, n, binomial);
        near(Curve::InverseRootOfTwice, n, binomial);
    }
}
