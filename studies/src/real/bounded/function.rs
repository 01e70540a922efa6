//! Range and carried error of each function on intervals. They are told apart from rounding, which
//! depends on the units.

use super::{Bounded, down, hull, undefined, up};
use crate::real::{Operation, Undefined};

/// Units in the last place that a function of `math.h` is off by on exact units, as `math.c` states.
pub(super) fn library_ulps(op: Operation) -> Option<f64> {
    use Operation::*;
    Some(match op {
        Exp2 | Log2 | Sin | Cos => 0.51,
        Exp => 1.1,
        Tan | Log | Expm1 => 1.6,
        Log10 => 1.7,
        Log1p => 2.0,
        Cbrt => 1.0,
        Hypot => 1.2,
        Atan | Atan2 | Asin | Acos | Sinh | Cosh | Tanh => 3.0,
        _ => return None,
    })
}

/// The extremes of the sine over an interval.
fn sine_range(low: f64, high: f64) -> (f64, f64) {
    use std::f64::consts::{FRAC_PI_2, TAU};
    if high - low >= TAU || low.abs().max(high.abs()) > 1e9 {
        return (-1.0, 1.0);
    }
    let reaches = |peak: f64| {
        let first = peak + TAU * ((low - peak) / TAU).ceil();
        first <= high + 1e-9 || first - TAU >= low - 1e-9
    };
    let (a, b) = hull(&[libm::sin(low), libm::sin(high)]);
    (
        if reaches(-FRAC_PI_2) { -1.0 } else { a },
        if reaches(FRAC_PI_2) { 1.0 } else { b },
    )
}

/// A way of bounding: where the result lies, and what the operands' errors come to.
pub(super) type Way = ((f64, f64), f64);

/// A function of one operand that rises with it, with its derivative's bound over what the operand may be.
fn rising(a: &Bounded, f: fn(f64) -> f64, slope: f64) -> Way {
    ((f(a.low), f(a.high)), slope * a.error)
}

pub(super) fn quotient(a: &Bounded, b: &Bounded) -> Result<Way, Undefined> {
    let least = b.least() - b.error;
    if least <= 0.0 {
        return Err(undefined("a divisor may be zero"));
    }
    let range = hull(&[
        a.low / b.low,
        a.low / b.high,
        a.high / b.low,
        a.high / b.high,
    ]);
    let largest = range.0.abs().max(range.1.abs());
    Ok((range, (a.error + largest * b.error) / least))
}

pub(super) fn root(a: &Bounded) -> Result<Way, Undefined> {
    if a.low < 0.0 {
        return Err(undefined("the root of a number that may be negative"));
    }
    let carried = match a.low > a.error {
        true => a.error / (a.low.sqrt() + (a.low - a.error).sqrt()),
        // A computed operand below zero is no number; else |√x − √y| is at most the root of |x − y|.
        false if a.error > 0.0 && !a.is_nonnegative => {
            return Err(undefined("the root of a number that may be negative"));
        }
        false => a.error.sqrt(),
    };
    Ok(((a.low.sqrt(), a.high.sqrt()), carried))
}

pub(super) fn product(a: &Bounded, b: &Bounded) -> Way {
    let range = match a.identity == b.identity {
        true => (a.least() * a.least(), a.largest() * a.largest()),
        false => hull(&[
            a.low * b.low,
            a.low * b.high,
            a.high * b.low,
            a.high * b.high,
        ]),
    };
    let carried = a.largest() * b.error + b.largest() * a.error + a.error * b.error;
    (range, carried)
}

fn logarithm(a: &Bounded, f: fn(f64) -> f64, per: f64) -> Result<Way, Undefined> {
    let least = a.low - a.error;
    if least <= 0.0 {
        return Err(undefined(
            "the logarithm of a number that may not be positive",
        ));
    }
    Ok(((f(a.low), f(a.high)), a.error / least * per))
}

/// e^a with the error that a's makes of it.
fn exponential(a: &Bounded) -> Way {
    let high = libm::exp(a.high);
    ((libm::exp(a.low), high), high * libm::expm1(a.error))
}

fn power(a: &Bounded, b: &Bounded) -> Result<Way, Undefined> {
    let n = b.low;
    if b.low == b.high && b.error == 0.0 && n == n.floor() && (1.0..=64.0).contains(&n) {
        let mut ends = vec![libm::pow(a.low, n), libm::pow(a.high, n)];
        if a.least() == 0.0 {
            ends.push(0.0);
        }
        let slope = n * libm::pow(a.largest() + a.error, n - 1.0);
        return Ok((hull(&ends), slope * a.error));
    }
    let (range, carried) = logarithm(a, libm::log, 1.0)?;
    let log = Bounded::new(down(range.0), up(range.1), carried);
    let (range, carried) = product(&log, b);
    let exponent = Bounded::new(down(range.0), up(range.1), carried);
    Ok(exponential(&exponent))
}

fn angle(y: &Bounded, x: &Bounded) -> Result<Way, Undefined> {
    let away = libm::hypot(y.least(), x.least()) - libm::hypot(y.error, x.error);
    let crosses = y.low - y.error <= 0.0 && y.high + y.error >= 0.0 && x.low - x.error <= 0.0;
    if away <= 0.0 || crosses {
        return Err(undefined("an angle that may jump from π to −π"));
    }
    let corners = [
        (y.low, x.low),
        (y.low, x.high),
        (y.high, x.low),
        (y.high, x.high),
    ];
    let mut ends = corners.map(|(y, x)| libm::atan2(y, x)).to_vec();
    if x.low <= 0.0 && x.high >= 0.0 {
        let up = std::f64::consts::FRAC_PI_2;
        ends.push(if y.low > 0.0 { up } else { -up });
    }
    let carried = libm::hypot(y.error, x.error) / away;
    Ok((hull(&ends), carried))
}

/// Range and carried error of a function of `math.h`, or of a unit.
pub(super) fn function(op: Operation, a: &Bounded, b: &Bounded) -> Result<Way, Undefined> {
    use Operation::*;
    let largest = a.largest() + a.error;
    Ok(match op {
        Exp => exponential(a),
        Exp2 => {
            let scaled = |x: f64| x * std::f64::consts::LN_2;
            exponential(&Bounded::new(
                scaled(a.low),
                scaled(a.high),
                scaled(a.error),
            ))
        }
        Expm1 => rising(a, libm::expm1, libm::exp(a.high + a.error)),
        Log => logarithm(a, libm::log, 1.0)?,
        Log2 => logarithm(a, libm::log2, std::f64::consts::LOG2_E)?,
        Log10 => logarithm(a, libm::log10, std::f64::consts::LOG10_E)?,
        Log1p => {
            let least = 1.0 + a.low - a.error;
            if least <= 0.0 {
                return Err(undefined(
                    "the logarithm of a number that may not be positive",
                ));
            }
            rising(a, libm::log1p, 1.0 / least)
        }
        Sin => (sine_range(a.low, a.high), a.error.min(2.0)),
        Cos => {
            let quarter = std::f64::consts::FRAC_PI_2;
            (
                sine_range(a.low + quarter, a.high + quarter),
                a.error.min(2.0),
            )
        }
        Tan => {
            let turn = |x: f64| (x / std::f64::consts::PI + 0.5).floor();
            let (low, high) = a.computed();
            if turn(low) != turn(high) {
                return Err(undefined("a tangent may have a pole"));
            }
            let most = libm::tan(low).abs().max(libm::tan(high).abs());
            rising(a, libm::tan, 1.0 + most * most)
        }
        Asin | Acos if largest >= 1.0 => {
            return Err(undefined(
                "the arcsine or arccosine of a number that may reach 1",
            ));
        }
        Asin => rising(a, libm::asin, 1.0 / (1.0 - largest * largest).sqrt()),
        Acos => {
            let slope = 1.0 / (1.0 - largest * largest).sqrt();
            ((libm::acos(a.high), libm::acos(a.low)), slope * a.error)
        }
        Atan => rising(a, libm::atan, 1.0),
        Atan2 => angle(a, b)?,
        Sinh => rising(a, libm::sinh, libm::cosh(largest)),
        Cosh => {
            let ends = (libm::cosh(a.least()), libm::cosh(a.largest()));
            (ends, libm::sinh(largest) * a.error)
        }
        Tanh => rising(a, libm::tanh, 1.0),
        Asinh => rising(a, libm::asinh, 1.0),
        // |∛x − ∛y| is at most ∛(4 |x − y|).
        Cbrt => {
            let least = a.least() - a.error;
            let carried = match least > 0.0 {
                true => a.error / (3.0 * libm::pow(least, 2.0 / 3.0)),
                false => libm::cbrt(4.0 * a.error),
            };
            ((libm::cbrt(a.low), libm::cbrt(a.high)), carried)
        }
        Hypot => {
            let ends = (
                libm::hypot(a.least(), b.least()),
                libm::hypot(a.largest(), b.largest()),
            );
            (ends, libm::hypot(a.error, b.error))
        }
        Pow => power(a, b)?,
        _ => return Err(undefined("a function that this study does not bound")),
    })
}
