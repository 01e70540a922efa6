//! [`Bounded`]: intervals of real numbers, with a bound of the error that binary32 makes of any of them.
//!
//! An interval says where the *real* result lies for any operands in theirs, the error how far the computed
//! one may be from it. Rounding adds half a unit in the last place, units what their structure is off by,
//! functions of `math.h` what `kernels/libc/math.c` states; errors of operands go through by the
//! largest derivative. Intervals are computed in binary64 and widened.

use super::{Number, Operation, Relation, Undefined};
use srp_archdesc::arch::{Approx, Precision, Subnormals};
use srp_ir::pass::FastMath;

/// What operations are off by.
#[derive(Clone, Copy, Debug)]
pub struct Units {
    /// The units of the machine, with all steps taken.
    pub precision: Precision,
    /// Whether functions of the library keep to their stated bounds: units are exact, and nothing lets the
    /// compiler take others.
    pub library: bool,
    /// Whether quotients may be products with reciprocals.
    pub reciprocal: bool,
}

impl Units {
    /// The units of a machine, for a compiler with these permissions.
    pub fn of(precision: &Precision, fast_math: FastMath) -> Units {
        let precision = precision.in_units();
        let exact = Precision {
            subnormals: precision.subnormals,
            texture_weight_bits: precision.texture_weight_bits,
            ..Precision::EXACT
        };
        Units {
            precision,
            library: precision == exact && !fast_math.approximate,
            reciprocal: fast_math.reciprocal,
        }
    }

    /// What any operation may lose besides its rounding: results below the normal numbers.
    fn tiny(&self) -> f64 {
        match self.precision.subnormals {
            Subnormals::Keep => 2f64.powi(-150),
            Subnormals::Flush => 2f64.powi(-126),
        }
    }
}

/// Half a unit in the last place of 1: what rounding is off by, relatively.
const U: f64 = 1.0 / (1u32 << 24) as f64;

/// What binary64 may have lost of a bound.
const SLACK: f64 = 1.0 + 1e-12;

/// All that the real number may be, and how far the computed one may be from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounded {
    low: f64,
    high: f64,
    error: f64,
}

fn undefined(why: &str) -> Undefined {
    Undefined(why.to_owned())
}

impl Bounded {
    /// Any float of a range.
    pub fn between(low: f32, high: f32) -> Bounded {
        Bounded {
            low: f64::from(low),
            high: f64::from(high),
            error: 0.0,
        }
    }

    /// Where the real number lies.
    pub fn range(&self) -> (f64, f64) {
        (self.low, self.high)
    }

    /// How far the computed number may be from it.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Any number of either.
    pub fn or(&self, other: &Bounded) -> Bounded {
        Bounded {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            error: self.error.max(other.error),
        }
    }

    fn point(x: f64) -> Bounded {
        Bounded {
            low: x,
            high: x,
            error: 0.0,
        }
    }

    fn largest(&self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// The least magnitude of the real number.
    fn least(&self) -> f64 {
        match self.low <= 0.0 && self.high >= 0.0 {
            true => 0.0,
            false => self.low.abs().min(self.high.abs()),
        }
    }

    /// Where the computed number lies.
    fn computed(&self) -> (f64, f64) {
        (self.low - self.error, self.high + self.error)
    }

    /// The result of an operation with this range, whose operands' errors come to `carried`, and that is itself
    /// off by a relative and an absolute error.
    fn rounded(
        (low, high): (f64, f64),
        carried: f64,
        (relative, absolute): (f64, f64),
    ) -> Result<Bounded, Undefined> {
        let (low, high) = (down(low), up(high));
        let largest = low.abs().max(high.abs()) + carried;
        let error = (carried + relative * largest + absolute) * SLACK;
        if low.is_nan() || high.is_nan() || error.is_nan() || largest + error > f64::from(f32::MAX)
        {
            return Err(undefined("a result may overflow or be no number"));
        }
        Ok(Bounded { low, high, error })
    }
}

/// A little less, by more than a function of binary64 is off.
fn down(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x - x.abs() * 1e-15 }
}

fn up(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x + x.abs() * 1e-15 }
}

/// The least and the greatest of some numbers.
fn hull(values: &[f64]) -> (f64, f64) {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    (
        low,
        values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    )
}

/// Units in the last place that a function of `math.h` is off by on exact units, as `math.c` states.
fn library_ulps(op: Operation) -> Option<f64> {
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
type Way = ((f64, f64), f64);

/// A function of one operand that rises with it, with its derivative's bound over what the operand may be.
fn rising(a: &Bounded, f: fn(f64) -> f64, slope: f64) -> Way {
    ((f(a.low), f(a.high)), slope * a.error)
}

fn quotient(a: &Bounded, b: &Bounded) -> Result<Way, Undefined> {
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

fn root(a: &Bounded) -> Result<Way, Undefined> {
    if a.low < 0.0 {
        return Err(undefined("the root of a number that may be negative"));
    }
    let carried = match a.low > a.error {
        true => a.error / (a.low.sqrt() + (a.low - a.error).sqrt()),
        // |√x − √y| is at most the root of |x − y|; a computed operand below zero is no number.
        false if a.error > 0.0 => {
            return Err(undefined("the root of a number that may be negative"));
        }
        false => 0.0,
    };
    Ok(((a.low.sqrt(), a.high.sqrt()), carried))
}

fn product(a: &Bounded, b: &Bounded) -> Way {
    let range = hull(&[
        a.low * b.low,
        a.low * b.high,
        a.high * b.low,
        a.high * b.high,
    ]);
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
    let log = Bounded {
        low: down(range.0),
        high: up(range.1),
        error: carried,
    };
    let (range, carried) = product(&log, b);
    Ok(exponential(&Bounded {
        low: down(range.0),
        high: up(range.1),
        error: carried,
    }))
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
fn function(op: Operation, a: &Bounded, b: &Bounded) -> Result<Way, Undefined> {
    use Operation::*;
    let largest = a.largest() + a.error;
    Ok(match op {
        Exp => exponential(a),
        Exp2 => {
            let scaled = Bounded {
                low: a.low * std::f64::consts::LN_2,
                high: a.high * std::f64::consts::LN_2,
                error: a.error * std::f64::consts::LN_2,
            };
            exponential(&scaled)
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

/// What a function to a whole number makes of what it is given.
fn whole(a: &Bounded, f: impl Fn(f64) -> f64) -> Bounded {
    let (low, high) = a.computed();
    let (first, last) = (f(a.low), f(a.high));
    let error = match f(low) == f(high) {
        true => 0.0,
        false => a.error.floor() + 1.0,
    };
    Bounded {
        low: first,
        high: last,
        error,
    }
}

impl Number for Bounded {
    type Context = Units;

    fn of_float(x: f32) -> Bounded {
        Bounded::point(f64::from(x))
    }

    fn of_integer(n: i64, _: &Units) -> Bounded {
        let error = (n as f64 - f64::from(n as f32)).abs();
        Bounded {
            error,
            ..Bounded::point(n as f64)
        }
    }

    fn of_decimal(digits: &str, exponent: i32, _: &Units) -> Bounded {
        let exact: f64 = format!("{digits}e{exponent}").parse().unwrap_or(f64::NAN);
        let error = (exact - f64::from(exact as f32)).abs() * SLACK;
        // Binary64 has rounded it too.
        Bounded {
            low: if error > 0.0 { down(exact) } else { exact },
            high: if error > 0.0 { up(exact) } else { exact },
            error,
        }
    }

    fn apply(op: Operation, args: &[Bounded], units: &Units) -> Result<Bounded, Undefined> {
        use Operation::*;
        let a = &args[0];
        let b = args.get(1).unwrap_or(a);
        let rounding = (U, units.tiny());
        let by_unit = |approx: Approx| match units.precision.subnormals {
            // A table takes any result below the normal numbers as it comes.
            _ if approx == Approx::Exact => rounding,
            _ => (approx.error_bound(), 2f64.powi(-125)),
        };
        let precision = &units.precision;
        let (way, off) = match op {
            Add => (
                (((a.low + b.low), (a.high + b.high)), a.error + b.error),
                rounding,
            ),
            Sub => (
                (((a.low - b.high), (a.high - b.low)), a.error + b.error),
                rounding,
            ),
            Mul => (product(a, b), rounding),
            Fma => {
                let (range, carried) = product(a, b);
                let c = args.get(2).unwrap_or(a);
                let range = (down(range.0) + c.low, up(range.1) + c.high);
                ((range, carried + c.error), rounding)
            }
            Div if units.reciprocal => {
                let plain = Units {
                    reciprocal: false,
                    ..*units
                };
                let quotient = Bounded::apply(Div, args, &plain)?;
                let inverse = Bounded::apply(Rcp, &[*b], &plain)?;
                let product = Bounded::apply(Mul, &[*a, inverse], &plain)?;
                return Ok(Bounded {
                    error: quotient.error.max(product.error),
                    ..quotient
                });
            }
            Div => (quotient(a, b)?, by_unit(precision.div)),
            Rcp => (quotient(&Bounded::point(1.0), a)?, by_unit(precision.rcp)),
            Sqrt => (root(a)?, by_unit(precision.sqrt)),
            Rsqrt => {
                let (range, carried) = root(a)?;
                let below = Bounded {
                    low: down(range.0),
                    high: up(range.1),
                    error: carried,
                };
                (
                    quotient(&Bounded::point(1.0), &below)?,
                    by_unit(precision.rsqrt),
                )
            }
            Neg => {
                return Ok(Bounded {
                    low: -a.high,
                    high: -a.low,
                    error: a.error,
                });
            }
            Abs => {
                return Ok(Bounded {
                    low: a.least(),
                    high: a.largest(),
                    error: a.error,
                });
            }
            Min | Max => {
                let pick = if op == Min { f64::min } else { f64::max };
                return Ok(Bounded {
                    low: pick(a.low, b.low),
                    high: pick(a.high, b.high),
                    error: a.error.max(b.error),
                });
            }
            Floor => return Ok(whole(a, f64::floor)),
            Ceil => return Ok(whole(a, f64::ceil)),
            Trunc => return Ok(whole(a, f64::trunc)),
            Round => return Ok(whole(a, f64::round)),
            Rint => return Ok(whole(a, f64::round_ties_even)),
            Copysign => {
                let (low, high) = b.computed();
                let (least, largest) = (a.least(), a.largest());
                let (low, high) = match (low > 0.0, high < 0.0) {
                    (true, _) => (least, largest),
                    (_, true) => (-largest, -least),
                    _ => return Err(undefined("a sign that may be either")),
                };
                return Ok(Bounded {
                    low,
                    high,
                    error: a.error,
                });
            }
            Fdim => {
                let difference = Bounded::apply(Sub, args, units)?;
                return Bounded::apply(Max, &[difference, Bounded::point(0.0)], units);
            }
            _ if !units.library => {
                return Err(undefined(
                    "functions of math.h have stated bounds on exact units only",
                ));
            }
            _ => {
                let way = function(op, a, b)?;
                let ulps = match op {
                    Pow => 20.0 + b.largest() / 12.0,
                    _ => library_ulps(op)
                        .ok_or_else(|| undefined("a function without a stated bound"))?,
                };
                (way, (2.0 * U * ulps, 2.0 * units.tiny()))
            }
        };
        Bounded::rounded(way.0, way.1, off)
    }

    fn of_unit(op: Operation, args: &[Bounded], units: &Units) -> Result<Bounded, Undefined> {
        let precision = &units.precision;
        let (approx, is_relative) = match op {
            Operation::Exp2 => (precision.exp2, true),
            Operation::Log2 => (precision.log2, false),
            Operation::Sin | Operation::Cos => (precision.sincos, false),
            _ => return Bounded::apply(op, args, units),
        };
        let (range, carried) = function(op, &args[0], &args[0])?;
        let off = match (approx, is_relative) {
            // Binary64 rounded once.
            (Approx::Exact, _) => (2.0 * U * 0.51, 2.0 * units.tiny()),
            (_, true) => (approx.error_bound(), 2f64.powi(-125)),
            // Absolute below 1; of a larger logarithm, the rounding of the result besides.
            (_, false) => (2.0 * U, approx.error_bound()),
        };
        Bounded::rounded(range, carried, off)
    }

    fn relate(&self, other: &Bounded) -> Relation {
        let ((a, b), (c, d)) = (self.computed(), other.computed());
        match (b < c, a > d) {
            (true, _) => Relation::Less,
            (_, true) => Relation::Greater,
            _ if a == b && c == d && a == c => Relation::Equal,
            _ => Relation::Unknown,
        }
    }

    fn nearest(&self) -> Option<f32> {
        (self.low == self.high && self.error == 0.0).then_some(self.low as f32)
    }

    fn whole(&self) -> Option<i64> {
        let (low, high) = self.computed();
        (low.trunc() == high.trunc()).then_some(low as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_sums_and_products_are_bounded() {
        let units = Units::of(&Precision::EXACT, FastMath::default());
        let x = Bounded::between(1.0, 2.0);
        let square = Bounded::apply(Operation::Mul, &[x, x], &units).expect("a product");
        assert!(
            square.error() >= 4.0 * U && square.error() < 4.1 * U,
            "{square:?}"
        );
        let one = Bounded::point(1.0);
        let sum = Bounded::apply(Operation::Add, &[square, one], &units).expect("a sum");
        assert!(sum.error() >= 9.0 * U && sum.error() < 9.1 * U, "{sum:?}");
        let zero = Bounded::between(-1.0, 1.0);
        assert!(Bounded::apply(Operation::Div, &[one, zero], &units).is_err());
        assert_eq!(one.relate(&x), Relation::Unknown);
        assert_eq!(zero.relate(&square), Relation::Unknown);
        assert_eq!(sum.relate(&one), Relation::Greater);
    }

    #[test]
    fn a_coarse_unit_is_in_the_bound() {
        let mut precision = Precision::EXACT;
        precision.div = Approx::table(8, 0);
        let units = Units::of(&precision, FastMath::default());
        let (one, x) = (Bounded::point(1.0), Bounded::between(1.0, 2.0));
        let quotient = Bounded::apply(Operation::Div, &[one, x], &units).expect("a quotient");
        assert!(quotient.error() > 1.0 / 257.0 && quotient.error() < 1.0 / 250.0);
        assert!(!units.library);
    }
}
