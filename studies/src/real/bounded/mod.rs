//! [`Bounded`]: intervals of real numbers, with a bound of the error that binary32 makes of any of them.
//!
//! An interval says where the *real* result lies for any operands in theirs, the error how far the computed
//! one may be from it. Rounding adds half a unit in the last place, units what their structure is off by,
//! functions of `math.h` what `kernels/libc/math.c` states; errors of operands go through by the
//! largest derivative. Intervals are computed in binary64 and widened.

mod function;

use self::function::{function, library_ulps, product, quotient, root};
use super::{Number, Operation, Relation, Undefined};
use srp_archdesc::arch::{Approx, Precision, Subnormals, U};
use srp_archdesc::format::{Format, Formats};
use srp_archdesc::structure::Special;
use srp_ir::pass::FastMath;
use std::sync::atomic::{AtomicU64, Ordering};

/// The errors of operations.
#[derive(Clone, Copy, Debug)]
pub struct Units {
    /// The units of the machine, with all steps taken.
    pub precision: Precision,
    /// True when functions of the library keep to their stated bounds: units are exact, and nothing lets the
    /// compiler take others.
    pub library: bool,
    /// True when quotients may be products with reciprocals.
    pub reciprocal: bool,
    /// The errors of a reciprocal, a root and the reciprocal of one, with steps that the program takes in narrow formats.
    roots: [f64; 3],
    /// The least range of the formats that such steps are taken in.
    steps: Option<Format>,
}

impl Units {
    /// The units of a machine, for a compiler with these permissions.
    pub fn of(precision: &Precision, fast_math: FastMath) -> Units {
        let roots = [Special::Rcp, Special::Sqrt, Special::Rsqrt];
        let errors = roots.map(|special| precision.error_in_code(special));
        let is_in_code = |special: Special| {
            let unit = precision.of(special).error_bound();
            precision.error_in_code(special) > unit
        };
        let all = precision.formats.all().into_iter();
        let least = all.min_by_key(|format| format.exponent);
        let steps = least.filter(|_| roots.into_iter().any(is_in_code));
        let precision = precision.in_units();
        let exact = Precision {
            subnormals: precision.subnormals,
            formats: precision.formats,
            // No function of the library is computed by them.
            fast: precision.fast,
            texture_weight_bits: precision.texture_weight_bits,
            ..Precision::EXACT
        };
        Units {
            precision,
            library: precision == exact
                && precision.formats == Formats::SINGLE
                && !fast_math.approximate,
            reciprocal: fast_math.reciprocal,
            roots: errors,
            steps,
        }
    }

    /// The narrow format that sums, products, or both at once are made in. Products and sums may also be those of a dot
    /// product, or become one operation, which are made in the format of such.
    fn format(&self, op: Operation) -> Option<Format> {
        let formats = &self.precision.formats;
        let coarser = |own: Format| Format {
            exponent: own.exponent.min(formats.fused.exponent),
            significand: own.significand.min(formats.fused.significand),
        };
        let format = match op {
            Operation::Add | Operation::Sub => coarser(formats.add),
            Operation::Mul => coarser(formats.multiply),
            Operation::Fma => formats.fused,
            _ => Format::SINGLE,
        };
        (format != Format::SINGLE).then_some(format)
    }

    /// The error of any operation besides its rounding: results below the normal numbers.
    fn tiny(&self) -> f64 {
        match self.precision.subnormals {
            Subnormals::Keep => 2f64.powi(-150),
            Subnormals::Flush => 2f64.powi(-126),
        }
    }
}

/// The factor that makes up for what binary64 may have lost of a bound.
const SLACK: f64 = 1.0 + 1e-12;

/// All that the real number may be, and how far the computed one may be from it.
///
/// A number knows which it is: its product with itself is a square, which is not negative, whatever its sign is.
#[derive(Clone, Copy, Debug)]
pub struct Bounded {
    low: f64,
    high: f64,
    error: f64,
    /// True when the computed number is not below zero either, however far it is off.
    is_nonnegative: bool,
    /// The number itself: copies have the same.
    identity: u64,
}

/// The number of the next number.
static NEXT: AtomicU64 = AtomicU64::new(0);

fn undefined(why: &str) -> Undefined {
    Undefined(why.to_owned())
}

impl Bounded {
    /// Any float of a range.
    pub fn between(low: f32, high: f32) -> Bounded {
        Bounded::new(f64::from(low), f64::from(high), 0.0)
    }

    /// Another number of the same range and error.
    pub fn another(&self) -> Bounded {
        Bounded::new(self.low, self.high, self.error).nonnegative(self.is_nonnegative)
    }

    fn new(low: f64, high: f64, error: f64) -> Bounded {
        Bounded {
            low,
            high,
            error,
            is_nonnegative: low - error >= 0.0,
            identity: NEXT.fetch_add(1, Ordering::Relaxed),
        }
    }

    /// The same, known not to be computed below zero if that `holds`.
    fn nonnegative(self, holds: bool) -> Bounded {
        Bounded {
            is_nonnegative: self.is_nonnegative || holds,
            ..self
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
        let (low, high) = (self.low.min(other.low), self.high.max(other.high));
        Bounded::new(low, high, self.error.max(other.error))
            .nonnegative(self.is_nonnegative && other.is_nonnegative)
    }

    fn point(x: f64) -> Bounded {
        Bounded::new(x, x, 0.0)
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

    /// The number rounded to a format.
    fn narrowed(&self, format: Format, subnormals: Subnormals) -> Result<Bounded, Undefined> {
        let largest = self.largest() + self.error;
        if largest > format.largest() {
            return Err(undefined(
                "a number may be too large for the format of a unit",
            ));
        }
        let error = self.error + format.rounding() * largest + below(format, subnormals);
        Ok(Bounded {
            error: error * SLACK,
            ..*self
        })
    }

    /// Where the computed number lies.
    pub fn computed(&self) -> (f64, f64) {
        let low = self.low - self.error;
        let low = if self.is_nonnegative {
            low.max(0.0)
        } else {
            low
        };
        (low, self.high + self.error)
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
        Ok(Bounded::new(low, high, error))
    }
}

/// The error of rounding numbers below the normal ones of a format.
fn below(format: Format, subnormals: Subnormals) -> f64 {
    match subnormals {
        Subnormals::Keep => format.least_normal() * format.rounding(),
        Subnormals::Flush => format.least_normal(),
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

/// Bounds a function whose results are whole numbers.
fn whole(a: &Bounded, f: impl Fn(f64) -> f64) -> Bounded {
    let (low, high) = a.computed();
    let (first, last) = (f(a.low), f(a.high));
    let error = match f(low) == f(high) {
        true => 0.0,
        false => a.error.floor() + 1.0,
    };
    Bounded::new(first, last, error)
}

impl Number for Bounded {
    type Context = Units;

    fn of_float(x: f32) -> Bounded {
        Bounded::point(f64::from(x))
    }

    fn half(&self) -> Result<Bounded, Undefined> {
        self.narrowed(Format::HALF, Subnormals::Keep)
    }

    fn of_integer(n: i64, _: &Units) -> Bounded {
        let error = (n as f64 - f64::from(n as f32)).abs();
        Bounded::new(n as f64, n as f64, error)
    }

    fn of_decimal(digits: &str, exponent: i32, _: &Units) -> Bounded {
        let exact: f64 = format!("{digits}e{exponent}").parse().unwrap_or(f64::NAN);
        let error = (exact - f64::from(exact as f32)).abs() * SLACK;
        // Binary64 has rounded it too.
        let low = if error > 0.0 { down(exact) } else { exact };
        let high = if error > 0.0 { up(exact) } else { exact };
        Bounded::new(low, high, error)
    }

    fn apply(op: Operation, args: &[Bounded], units: &Units) -> Result<Bounded, Undefined> {
        use Operation::*;
        let subnormals = units.precision.subnormals;
        let format = units.format(op);
        let mut narrow = Vec::new();
        if let Some(format) = format {
            for arg in args {
                narrow.push(arg.narrowed(format, subnormals)?);
            }
        }
        let args = if narrow.is_empty() { args } else { &narrow };
        let a = &args[0];
        let b = args.get(1).unwrap_or(a);
        let rounding = match format {
            // To binary32, and then to the format.
            Some(format) => (
                U + format.rounding(),
                units.tiny() + below(format, subnormals),
            ),
            None => (U, units.tiny()),
        };
        let by_unit = |approx: Approx, error: f64| match approx {
            Approx::Exact => rounding,
            // A table takes any result below the normal numbers as it comes.
            _ => (error, 2f64.powi(-125)),
        };
        let [of_reciprocal, of_root, of_inverse_root] = units.roots;
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
                let error = quotient.error.max(product.error);
                return Ok(Bounded::new(quotient.low, quotient.high, error));
            }
            Div => (
                quotient(a, b)?,
                by_unit(precision.div, precision.div.error_bound()),
            ),
            Rcp => (
                quotient(&Bounded::point(1.0), a)?,
                by_unit(precision.rcp, of_reciprocal),
            ),
            Sqrt => (root(a)?, by_unit(precision.sqrt, of_root)),
            Rsqrt => {
                let (range, carried) = root(a)?;
                let below = Bounded::new(down(range.0), up(range.1), carried);
                (
                    quotient(&Bounded::point(1.0), &below)?,
                    by_unit(precision.rsqrt, of_inverse_root),
                )
            }
            Neg => {
                return Ok(Bounded::new(-a.high, -a.low, a.error));
            }
            Abs => {
                return Ok(Bounded::new(a.least(), a.largest(), a.error).nonnegative(true));
            }
            Min | Max => {
                let pick = if op == Min { f64::min } else { f64::max };
                let nonnegative = match op {
                    Min => a.is_nonnegative && b.is_nonnegative,
                    _ => a.is_nonnegative || b.is_nonnegative,
                };
                let (low, high) = (pick(a.low, b.low), pick(a.high, b.high));
                return Ok(Bounded::new(low, high, a.error.max(b.error)).nonnegative(nonnegative));
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
                return Ok(Bounded::new(low, high, a.error));
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
        // Rounding keeps signs, and so do sums and products of what is not negative.
        let both = a.is_nonnegative && b.is_nonnegative;
        let c = args.get(2);
        let nonnegative = match op {
            Add | Div => both,
            Mul => both || a.identity == b.identity,
            Fma => (both || a.identity == b.identity) && c.is_some_and(|c| c.is_nonnegative),
            Sqrt | Rsqrt => true,
            _ => false,
        };
        let result = Bounded::rounded(way.0, way.1, off)?.nonnegative(nonnegative);
        if let (Some(steps), Rcp | Sqrt | Rsqrt) = (units.steps, op) {
            let is_normal = |x: &Bounded| {
                let (low, high) = x.computed();
                let least = if low > 0.0 { low } else { -high };
                least >= steps.least_normal() && low.abs().max(high.abs()) <= steps.largest()
            };
            if !is_normal(a) || !is_normal(&result) {
                return Err(undefined("a step in code may leave the range of a format"));
            }
        }
        match format {
            Some(format) if result.largest() + result.error > format.largest() => Err(undefined(
                "a result may be too large for the format of a unit",
            )),
            _ => Ok(result),
        }
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

    fn of_fast_unit(op: Operation, args: &[Bounded], units: &Units) -> Result<Bounded, Undefined> {
        let precision = units.precision;
        let of = |special| precision.of(special);
        let fast = Units {
            precision: Precision {
                rcp: of(Special::RcpFast),
                rsqrt: of(Special::RsqrtFast),
                sqrt: of(Special::SqrtFast),
                div: of(Special::DivFast),
                ..precision
            },
            reciprocal: false,
            // They take their steps themselves.
            roots: [Special::RcpFast, Special::SqrtFast, Special::RsqrtFast]
                .map(|special| of(special).error_bound()),
            steps: None,
            ..*units
        };
        Bounded::apply(op, args, &fast)
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
    fn a_narrow_format_is_in_the_bound() {
        let mut precision = Precision::EXACT;
        precision.formats.multiply = Format::BFLOAT16;
        let units = Units::of(&precision, FastMath::default());
        let (x, y) = (Bounded::between(1.0, 2.0), Bounded::between(1.0, 2.0));
        let product = Bounded::apply(Operation::Mul, &[x, y], &units).expect("a product");
        // Both operands and the product are off by half a unit of 2⁻⁷.
        assert!(product.error() > 4.0 * 3.0 / 256.0 && product.error() < 4.1 * 3.0 / 256.0);
        let sum = Bounded::apply(Operation::Add, &[x, y], &units).expect("a sum");
        assert!(sum.error() < 4.1 * U);
        precision.formats.add = Format::HALF;
        let units = Units::of(&precision, FastMath::default());
        let large = Bounded::between(0.0, 40_000.0);
        assert!(Bounded::apply(Operation::Add, &[large, large], &units).is_err());
    }

    #[test]
    fn a_square_is_not_negative() {
        let units = Units::of(&Precision::EXACT, FastMath::default());
        let apply = |op, args: &[Bounded]| Bounded::apply(op, args, &units);
        let x = Bounded::between(-1.0, 1.0);
        let y = x.another();
        let d = apply(Operation::Sub, &[x, y]).expect("a difference");
        let square = apply(Operation::Mul, &[d, d]).expect("a square");
        let norm = apply(Operation::Fma, &[x, x, square]).expect("a sum of squares");
        assert!(norm.range().0 >= 0.0 && norm.error() > 0.0, "{norm:?}");
        let root = apply(Operation::Sqrt, &[norm]).expect("a root");
        assert!(root.error() < 2e-3, "{root:?}");
        let product = apply(Operation::Mul, &[x, y]).expect("a product");
        assert!(product.range().0 <= -1.0, "{product:?}");
        assert!(apply(Operation::Sqrt, &[product]).is_err());
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

    #[test]
    fn a_fast_unit_has_a_bound_of_its_own() {
        let mut precision = Precision::EXACT;
        precision.fast.div = Some(Approx::table(8, 0));
        let units = Units::of(&precision, FastMath::default());
        let args = [Bounded::point(1.0), Bounded::between(1.0, 2.0)];
        let exact = Bounded::apply(Operation::Div, &args, &units).expect("a quotient");
        let fast = Bounded::of_fast_unit(Operation::Div, &args, &units).expect("a quotient");
        assert!(exact.error() < 1e-6 && fast.error() > 1.0 / 257.0);
        assert!(units.library);
    }
}
