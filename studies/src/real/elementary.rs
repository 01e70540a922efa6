//! Operations on [`Wide`] numbers. Each function is reduced to a series that converges quickly.

use super::{Number, Operation, Relation, Undefined, Wide};
use std::cmp::Ordering;
use std::sync::OnceLock;

/// The result of an operation.
pub(super) fn apply(op: Operation, args: &[Wide]) -> Wide {
    use Operation::*;
    let a = &args[0];
    let b = args.get(1).unwrap_or(a);
    match op {
        Add => a.plus(b),
        Sub => a.minus(b),
        Mul => a.times(b),
        Div => a.over(b),
        Fma => a.times(b).plus(args.get(2).unwrap_or(a)),
        Neg => a.negated(),
        Abs => a.absolute(),
        Min | Max => lesser_or_greater(op == Max, a, b),
        Rcp => one().over(a),
        Rsqrt => one().over(&a.root()),
        Sqrt => a.root(),
        Exp => exp(a),
        Exp2 => exp(&a.times(ln2())),
        Expm1 => exp(a).minus(&one()),
        Log => log(a),
        Log2 => log(a).over(ln2()),
        Log10 => log(a).over(&log(&Wide::of(10.0))),
        Log1p => log(&a.plus(&one())),
        Sin => sine_and_cosine(a).0,
        Cos => sine_and_cosine(a).1,
        Tan => {
            let (sine, cosine) = sine_and_cosine(a);
            sine.over(&cosine)
        }
        Asin => angle(a, &one().minus(&a.times(a)).root()),
        Acos => angle(&one().minus(&a.times(a)).root(), a),
        Atan => angle(a, &one()),
        Atan2 => angle(a, b),
        Sinh => exp(a).minus(&exp(&a.negated())).scaled(0.5),
        Cosh => exp(a).plus(&exp(&a.negated())).scaled(0.5),
        Tanh => tanh(a),
        Asinh => {
            let x = a.absolute();
            let y = log(&x.plus(&x.times(&x).plus(&one()).root()));
            with_sign(&y, a)
        }
        Acosh => log(&a.plus(&a.times(a).minus(&one()).root())),
        Atanh => log(&one().plus(a).over(&one().minus(a))).scaled(0.5),
        Pow => power(a, b),
        Cbrt => cube_root(a),
        Hypot => a.times(a).plus(&b.times(b)).root(),
        Fmod => remainder(a, b),
        Floor => a.floor(),
        Ceil => a.negated().floor().negated(),
        Trunc => a.truncated(),
        Round => with_sign(&a.absolute().plus(&Wide::of(0.5)).floor(), a),
        Rint => nearest_even(a),
        Copysign => with_sign(&a.absolute(), b),
        Fdim => match a.minus(b).sign() {
            Ordering::Greater => a.minus(b),
            _ => Wide::of(0.0),
        },
    }
}

fn one() -> Wide {
    Wide::of(1.0)
}

fn with_sign(magnitude: &Wide, of: &Wide) -> Wide {
    match of.is_negative() {
        true => magnitude.negated(),
        false => magnitude.clone(),
    }
}

/// As IEEE 754 has them: a NaN gives way to a number.
fn lesser_or_greater(greater: bool, a: &Wide, b: &Wide) -> Wide {
    if a.value().is_nan() || b.value().is_nan() {
        return if a.value().is_nan() { b } else { a }.clone();
    }
    let first = match a.is_finite() && b.is_finite() {
        true => a.minus(b).sign() == Ordering::Greater,
        false => a.value() > b.value(),
    };
    if first == greater { a } else { b }.clone()
}

/// ln 2 = Σ 1 / (k 2^k).
fn ln2() -> &'static Wide {
    static LN2: OnceLock<Wide> = OnceLock::new();
    LN2.get_or_init(|| {
        let term = |k: i32| Wide::of(2f64.powi(-k)).over(&Wide::of(f64::from(k)));
        (1..280)
            .rev()
            .fold(Wide::of(0.0), |sum, k| sum.plus(&term(k)))
    })
}

/// π by Machin's formula, 16 arctan(1/5) − 4 arctan(1/239).
fn pi() -> &'static Wide {
    static PI: OnceLock<Wide> = OnceLock::new();
    PI.get_or_init(|| {
        let arctangent = |n: f64| {
            let square = Wide::of(n * n);
            let mut power = one().over(&Wide::of(n));
            let mut sum = Wide::of(0.0);
            for k in 0..120 {
                let term = power.over(&Wide::of(f64::from(2 * k + 1)));
                sum = if k % 2 == 0 {
                    sum.plus(&term)
                } else {
                    sum.minus(&term)
                };
                power = power.over(&square);
            }
            sum
        };
        let parts = (arctangent(5.0).scaled(16.0), arctangent(239.0).scaled(4.0));
        parts.0.minus(&parts.1)
    })
}

/// Largest exponent beyond which binary64 has no power of e.
const MOST_EXPONENT: f64 = 700.0;

/// e^x = 2^k (e^(r/256))^256 with x = k ln 2 + r, and Taylor's series for the power.
fn exp(x: &Wide) -> Wide {
    let plain = x.value();
    if plain.is_nan() || plain.abs() > MOST_EXPONENT {
        return Wide::of(libm::exp(plain));
    }
    let k = (plain / std::f64::consts::LN_2).round();
    let r = x.minus(&ln2().times(&Wide::of(k))).scaled(1.0 / 256.0);
    let mut sum = one();
    for n in (1..=26).rev() {
        sum = one().plus(&sum.times(&r).over(&Wide::of(f64::from(n))));
    }
    let power = (0..8).fold(sum, |power, _| power.times(&power));
    power.scaled(2f64.powi(k as i32))
}

/// ln x by Newton's steps from binary64's: y + x e^-y − 1 doubles the digits.
fn log(x: &Wide) -> Wide {
    let plain = libm::log(x.value());
    if !plain.is_finite() {
        return Wide::of(plain);
    }
    let step = |y: Wide| {
        let factor = x.times(&exp(&y.negated()));
        y.plus(&factor).minus(&one())
    };
    (0..3).fold(Wide::of(plain), |y, _| step(y))
}

/// Largest angle that is reduced exactly.
const MOST_ANGLE: f64 = 1e15;

/// Sine and cosine: the angle is taken to at most π/4, where Taylor's series are short.
fn sine_and_cosine(x: &Wide) -> (Wide, Wide) {
    let plain = x.value();
    if !plain.is_finite() || plain.abs() > MOST_ANGLE {
        return (Wide::of(libm::sin(plain)), Wide::of(libm::cos(plain)));
    }
    let quarter = pi().scaled(0.5);
    let turns = (plain / quarter.value()).round();
    let r = x.minus(&quarter.times(&Wide::of(turns)));
    let square = r.times(&r);
    let series = |first: i32| {
        let mut sum = one();
        for n in (1..=24).rev() {
            let (a, b) = (2 * n + first - 1, 2 * n + first);
            let below = Wide::of(f64::from(a * b));
            sum = one().minus(&sum.times(&square).over(&below));
        }
        sum
    };
    let (sine, cosine) = (r.times(&series(1)), series(0));
    match (turns as i64).rem_euclid(4) {
        0 => (sine, cosine),
        1 => (cosine, sine.negated()),
        2 => (sine.negated(), cosine.negated()),
        _ => (cosine.negated(), sine),
    }
}

/// The angle of the point (x, y): binary64's, turned back by it, leaves an angle d whose tangent t is small,
/// and d = t − t³/3 + t⁵/5.
fn angle(y: &Wide, x: &Wide) -> Wide {
    let plain = libm::atan2(y.value(), x.value());
    if !plain.is_finite() || !y.is_finite() || !x.is_finite() || y.value() == 0.0 && x.value() > 0.0
    {
        return Wide::of(plain);
    }
    if y.value() == 0.0 {
        return with_sign(pi(), y);
    }
    let start = Wide::of(plain);
    let (sine, cosine) = sine_and_cosine(&start);
    let across = y.times(&cosine).minus(&x.times(&sine));
    let along = x.times(&cosine).plus(&y.times(&sine));
    let t = across.over(&along);
    let (square, third) = (t.times(&t), Wide::of(3.0));
    let cube = square.times(&t);
    let fifth = cube.times(&square).over(&Wide::of(5.0));
    start.plus(&t).minus(&cube.over(&third)).plus(&fifth)
}

fn tanh(x: &Wide) -> Wide {
    if x.value().abs() > 300.0 {
        return with_sign(&one(), x);
    }
    let square = exp(&x.scaled(2.0));
    square.minus(&one()).over(&square.plus(&one()))
}

/// ∛x: Newton's steps from binary64's.
fn cube_root(x: &Wide) -> Wide {
    let plain = libm::cbrt(x.value());
    if !plain.is_finite() || plain == 0.0 {
        return Wide::of(plain);
    }
    let step = |root: Wide| {
        let other = x.over(&root.times(&root));
        root.scaled(2.0).plus(&other).over(&Wide::of(3.0))
    };
    (0..3).fold(Wide::of(plain), |root, _| step(root))
}

/// x^y as e^(y ln x); whole powers of any number by squaring.
fn power(x: &Wide, y: &Wide) -> Wide {
    let plain = libm::pow(x.value(), y.value());
    let is_whole = y.is_finite() && y.floor().minus(y).sign() == Ordering::Equal;
    if !plain.is_finite() || plain == 0.0 || !x.is_finite() || !y.is_finite() {
        return Wide::of(plain);
    }
    if is_whole && y.value().abs() <= 4096.0 {
        let mut left = y.value().abs() as u32;
        let (mut result, mut square) = (one(), x.clone());
        while left > 0 {
            if left & 1 == 1 {
                result = result.times(&square);
            }
            left >>= 1;
            if left > 0 {
                square = square.times(&square);
            }
        }
        let result = match y.is_negative() {
            true => one().over(&result),
            false => result,
        };
        if result.is_finite() {
            return result;
        }
        return Wide::of(plain);
    }
    let magnitude = exp(&y.times(&log(&x.absolute())));
    match plain < 0.0 {
        true => magnitude.negated(),
        false => magnitude,
    }
}

/// x − n y with n the whole part of x / y.
fn remainder(x: &Wide, y: &Wide) -> Wide {
    let quotient = x.over(y);
    if !quotient.is_finite() || quotient.value().abs() > 1e60 {
        return Wide::of(libm::fmod(x.value(), y.value()));
    }
    let rest = x.minus(&quotient.truncated().times(y));
    // The quotient may have been rounded to the next whole number.
    match rest.sign() != Ordering::Equal && rest.is_negative() != x.is_negative() {
        true => rest.plus(&with_sign(&y.absolute(), x)),
        false => rest,
    }
}

fn nearest_even(x: &Wide) -> Wide {
    let below = x.floor();
    let rest = x.minus(&below).minus(&Wide::of(0.5)).sign();
    let is_odd = {
        let half = below.scaled(0.5);
        half.floor().minus(&half).sign() != Ordering::Equal
    };
    match rest {
        Ordering::Less => below,
        Ordering::Equal if !is_odd => below,
        _ => below.plus(&one()),
    }
}

impl Number for Wide {
    type Context = ();

    fn of_float(x: f32) -> Wide {
        Wide::of(f64::from(x))
    }

    fn of_integer(n: i64, (): &()) -> Wide {
        let high = (n >> 32) as f64 * 4_294_967_296.0;
        Wide::of(high).plus(&Wide::of(f64::from(n as u32)))
    }

    fn of_decimal(digits: &str, exponent: i32, (): &()) -> Wide {
        let ten = Wide::of(10.0);
        let digit = |sum: Wide, c: char| {
            let digit = f64::from(c.to_digit(10).unwrap_or(0));
            sum.times(&ten).plus(&Wide::of(digit))
        };
        let whole = digits.chars().fold(Wide::of(0.0), digit);
        // Beyond binary64's exponents there is nothing but zero and infinity.
        let times = exponent.unsigned_abs().min(700);
        let power = (0..times).fold(Wide::of(1.0), |power, _| power.times(&ten));
        match exponent < 0 {
            true => whole.over(&power),
            false => whole.times(&power),
        }
    }

    fn apply(op: Operation, args: &[Wide], (): &()) -> Result<Wide, Undefined> {
        Ok(apply(op, args))
    }

    fn relate(&self, other: &Wide) -> Relation {
        let (a, b) = (self.value(), other.value());
        if a.is_nan() || b.is_nan() {
            return Relation::Unordered;
        }
        let order = match self.both_finite(other) {
            true => self.minus(other).sign(),
            false => a.partial_cmp(&b).unwrap_or(Ordering::Equal),
        };
        match order {
            Ordering::Less => Relation::Less,
            Ordering::Equal => Relation::Equal,
            Ordering::Greater => Relation::Greater,
        }
    }

    fn nearest(&self) -> Option<f32> {
        Some(self.to_float())
    }

    fn whole(&self) -> Option<i64> {
        let whole = self.truncated().value();
        // As conversions of the machine: toward zero, saturating, 0 of NaN.
        Some(whole as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(op: Operation, args: &[f64]) -> Wide {
        let args: Vec<Wide> = args.iter().map(|&x| Wide::of(x)).collect();
        apply(op, &args)
    }

    /// |a − b| relative to b is below 2^-180.
    fn close(a: &Wide, b: &Wide) -> bool {
        (a.minus(b).value() / b.value()).abs() < 2f64.powi(-180)
    }

    #[test]
    fn inverse_functions_undo_each_other() {
        use Operation::*;
        let pairs = [
            (Exp, Log),
            (Exp2, Log2),
            (Sinh, Asinh),
            (Expm1, Log1p),
            (Tan, Atan),
            (Tanh, Atanh),
        ];
        for (there, back) in pairs {
            for x in [0.1, 0.7, 1.3, -0.4] {
                let y = of(there, &[x]);
                let again = apply(back, &[y]);
                assert!(close(&again, &Wide::of(x)), "{there:?} {x} {again:?}");
            }
        }
        let three = of(Sqrt, &[3.0]);
        assert!(close(&three.times(&three), &Wide::of(3.0)));
        let (sine, cosine) = (of(Sin, &[100.0]), of(Cos, &[100.0]));
        let one = sine.times(&sine).plus(&cosine.times(&cosine));
        assert!(close(&one, &Wide::of(1.0)));
        assert!(close(&of(Cbrt, &[-27.0]), &Wide::of(-3.0)));
        assert!(close(&of(Pow, &[-2.0, 5.0]), &Wide::of(-32.0)));
    }

    #[test]
    fn functions_agree_with_binary64() {
        for &(op, name, operands, _) in Operation::NAMED {
            for x in [0.25, 0.5, 0.9] {
                let args = [
                    x + if op == Operation::Acosh { 1.0 } else { 0.0 },
                    0.75,
                    0.1,
                ];
                let plain: f64 = match op {
                    Operation::Exp => libm::exp(x),
                    Operation::Exp2 => libm::exp2(x),
                    Operation::Expm1 => libm::expm1(x),
                    Operation::Log => libm::log(x),
                    Operation::Log2 => libm::log2(x),
                    Operation::Log10 => libm::log10(x),
                    Operation::Log1p => libm::log1p(x),
                    Operation::Sin => libm::sin(x),
                    Operation::Cos => libm::cos(x),
                    Operation::Tan => libm::tan(x),
                    Operation::Asin => libm::asin(x),
                    Operation::Acos => libm::acos(x),
                    Operation::Atan => libm::atan(x),
                    Operation::Atan2 => libm::atan2(x, 0.75),
                    Operation::Sinh => libm::sinh(x),
                    Operation::Cosh => libm::cosh(x),
                    Operation::Tanh => libm::tanh(x),
                    Operation::Asinh => libm::asinh(x),
                    Operation::Acosh => libm::acosh(x + 1.0),
                    Operation::Atanh => libm::atanh(x),
                    Operation::Pow => libm::pow(x, 0.75),
                    Operation::Cbrt => libm::cbrt(x),
                    Operation::Hypot => libm::hypot(x, 0.75),
                    Operation::Fmod => libm::fmod(x, 0.75),
                    _ => continue,
                };
                let ours = of(op, &args[..operands]).value();
                assert!(
                    (ours - plain).abs() <= 4e-16 * plain.abs().max(0.1),
                    "{name} {x}: {ours} {plain}"
                );
            }
        }
    }

    #[test]
    fn cancellation_leaves_digits() {
        let a = Wide::of(1e30).plus(&Wide::of(1e-30));
        assert_eq!(a.minus(&Wide::of(1e30)).value(), 1e-30);
        let third = Wide::of(1.0).over(&Wide::of(3.0));
        let rest = third.times(&Wide::of(3.0)).minus(&Wide::of(1.0));
        assert!(rest.value().abs() < 1e-60);
        assert_eq!(Wide::of_decimal("1", -1, &()).to_float(), 0.1);
        let half = Wide::of(2.5).minus(&Wide::of(1e-40));
        assert_eq!(apply(Operation::Round, &[half]).value(), 2.0);
    }
}
