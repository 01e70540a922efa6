//! Verdicts on answers: right, or within the error that is allowed.

use super::catalogue::Case;
use super::settings::Setting;
use serde::{Deserialize, Serialize};
use srp_archdesc::arch::{Approx, Arch, NARROWED, Precision, Subnormals, U};
use srp_archdesc::datapath::Intersection;
use srp_runtime::tni::arithmetic::Hit;
use std::fmt::Write;

/// The verdict on a case in a place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Verdict {
    /// It is right.
    Right,
    /// It is wrong, as it must be in this setting, and keeps the bound that is stated.
    Bounded(String),
    /// The same of a number, which is off by so much where so much is allowed.
    Off {
        /// How far it is off, not 0.
        by: f64,
        /// How far it may be.
        most: f64,
    },
    /// It is wrong.
    Wrong(String),
    /// It is another than the right one, and nothing bounds how far it may be off in this setting: the answer, and why.
    Unbounded(String),
}

/// Levels of a byte that the curve from light to bytes reaches at 1, before it is shifted to end there: errors are a part of
/// these.
const LEVELS: f64 = 255.0 * 1.055;

/// A bound of the error of an approximate function: relative for reciprocal, roots and exponential,
/// absolute for the others. 0 where it is exact.
pub(super) fn error(approx: Approx) -> f64 {
    match approx {
        Approx::Exact => 0.0,
        approx => approx.error_bound(),
    }
}

/// The part by which a distance may be off: that of the T&I unit's reciprocal; Woop's test takes the slopes of a ray
/// and its distances from the SRP's, narrowed.
pub(super) fn distance_error(arch: &Arch) -> f64 {
    let of_ray = match arch.system.tni.intersection {
        Intersection::Woop if arch.precision.rcp != Approx::Exact => {
            let precision = &arch.precision;
            2.0 * (precision.reciprocal_error() + 3.0 * precision.product_rounding()) + NARROWED
        }
        _ => 0.0,
    };
    error(arch.system.tni.rcp) + of_ray
}

/// The same for the unit that the catalogue calls so: at the operands of the call where they are known, else at all.
fn unit_error(setting: &Setting, unit: &str) -> f64 {
    let precision = &setting.arch.precision;
    let at_operands = setting.at_operands.and_then(|errors| errors.of(unit));
    let at_all = match unit {
        "rcp" => error(precision.rcp),
        "rsqrt" => error(precision.rsqrt),
        "sqrt" => error(precision.sqrt),
        "div" => error(precision.div),
        "exp2" => error(precision.exp2),
        "log2" => error(precision.log2),
        "sincos" => error(precision.sincos),
        "tni" => distance_error(&setting.arch),
        // The middle of a step, along both axes.
        "weight" => 2f64.powi(-(precision.texture_weight_bits as i32)),
        _ => f64::NAN,
    };
    at_operands.map_or(at_all, |error| error.min(at_all))
}

/// True if a setting computes a function that has no approximate unit.
pub(super) fn is_exact(precision: &Precision) -> bool {
    let Precision {
        texture_weight_bits,
        ..
    } = *precision;
    *precision
        == Precision {
            texture_weight_bits,
            ..Precision::EXACT
        }
}

/// Returns the error that the approximate units of a setting may add to a result whose largest part is
/// `size`.
pub(super) fn allowance(case: &Case, setting: &Setting, size: f64) -> f64 {
    let (mut absolute, mut relative) = (0.0, 0.0);
    for (unit, times) in &case.costs {
        let part = if unit == "weight" {
            &mut absolute
        } else {
            &mut relative
        };
        *part += times * unit_error(setting, unit);
    }
    // Factors of 1 + e each, and powers of 2 whose exponents are off by e.
    size * libm::expm1(relative) + absolute
}

/// One unit of the last place of a number.
pub(super) fn ulp(x: f64) -> f64 {
    let exponent = (x.abs().max(f64::from(f32::MIN_POSITIVE)).to_bits() >> 52) as i32 - 1023;
    2f64.powi(exponent.max(-126) - 23)
}

/// Numbers against those of the catalogue. The same bits, any NaN for any other, where nothing is
/// allowed; else the difference counts in units of the last place of the largest number.
pub(super) fn numbers(case: &Case, setting: &Setting, found: &[u32]) -> Verdict {
    // A machine that flushes subnormals takes them for zeros, so there they are the same number.
    let flushes = setting.arch.precision.subnormals == Subnormals::Flush;
    let as_taken = |x: f32| match flushes && x.is_subnormal() {
        true => 0f32.copysign(x),
        false => x,
    };
    let expected: Vec<f32> = case
        .numbers_on(&setting.arch.precision)
        .into_iter()
        .map(as_taken)
        .collect();
    let found: Vec<f32> = found.iter().map(|&w| as_taken(f32::from_bits(w))).collect();
    // `nan` stands for all of them; other bits of one, which are no number, for themselves.
    let any = |x: f32| x.to_bits() == f32::NAN.to_bits();
    let same = |(a, b): (&f32, &f32)| a.to_bits() == b.to_bits() || (a.is_nan() && any(*b));
    let pairs = || found.iter().zip(&expected);
    if pairs().all(same) {
        return Verdict::Right;
    }
    let (mut size, mut off) = (0f64, 0f64);
    for (&a, &b) in pairs() {
        size = size.max(f64::from(b).abs());
        off = off.max(match same((&a, &b)) {
            true => 0.0,
            false => match f64::from(a) - f64::from(b) {
                difference if difference.is_finite() => difference.abs(),
                _ => f64::INFINITY,
            },
        });
    }
    if off == 0.0 && case.within > 0.0 {
        // Zeros of another sign.
        return Verdict::Right;
    }
    within(case, setting, off, size, || {
        format!("{found:?}, not {expected:?}")
    })
}

/// Checks the bytes of a word. Where units may be off, a byte may be so by the next level beyond.
pub(super) fn bytes(case: &Case, setting: &Setting, found: &[u32]) -> Verdict {
    let expected = case.numbers_on(&setting.arch.precision);
    let expected = expected.first().map_or(0, |word| word.to_bits());
    let levels = found[0]
        .to_le_bytes()
        .into_iter()
        .zip(expected.to_le_bytes());
    let off = levels
        .map(|(a, b)| f64::from(a.abs_diff(b)))
        .fold(0.0, f64::max);
    let bound = match allowance(case, setting, LEVELS) {
        0.0 => 0.0,
        bound => bound + 1.0,
    };
    match off {
        0.0 => Verdict::Right,
        off if off <= bound => Verdict::Off {
            by: off,
            most: bound,
        },
        off => Verdict::Wrong(format!(
            "{:08x}, not {expected:08x}: off by {off} levels, more than {bound:.1}",
            found[0]
        )),
    }
}

/// Checks that an error is one that the case allows, or one that its units bring.
pub(super) fn within(
    case: &Case,
    setting: &Setting,
    off: f64,
    size: f64,
    what: impl FnOnce() -> String,
) -> Verdict {
    let own = case.within * ulp(size);
    if off <= own {
        return Verdict::Right;
    }
    let bound = own + allowance(case, setting, size) + setting.narrow.unwrap_or(0.0);
    match off <= bound {
        true if setting.narrow.is_some() && size > 0.0 && bound >= size => {
            let mut text = what();
            let _ = write!(
                text,
                "; roundings to narrow formats may come to {bound:.1e}, as much as the answer"
            );
            Verdict::Unbounded(text)
        }
        true => Verdict::Off {
            by: off,
            most: bound,
        },
        false => {
            let mut text = what();
            let _ = write!(text, ": off by {off:.1e}, more than {bound:.1e}");
            Verdict::Wrong(text)
        }
    }
}

/// Checks that two vectors are of length 1 and at right angles to each other and to a third.
pub(super) fn basis(case: &Case, setting: &Setting, found: &[u32]) -> Verdict {
    let vector = |words: &[u32]| [0, 1, 2].map(|i| f64::from(f32::from_bits(words[i])));
    let normal = vector(&case.words::<3>("of"));
    let (u, v) = (vector(found), vector(&found[4..]));
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    // The normal is of length 1 but for its own rounding.
    let length = dot(normal, normal).sqrt();
    let off = [
        dot(u, u) - 1.0,
        dot(v, v) - 1.0,
        dot(u, v),
        dot(u, normal) / length,
        dot(v, normal) / length,
    ];
    let off = off.iter().fold(0f64, |m, x| match x.is_finite() {
        true => m.max(x.abs()),
        false => f64::INFINITY,
    });
    // A product of two vectors of length 1 whose numbers are off by e is so by 2√3 e + 3e² at most.
    let setting = &Setting {
        narrow: setting.narrow.map(|e| 4.0 * e + 3.0 * e * e),
        ..setting.clone()
    };
    within(case, setting, off, 1.0, || format!("{u:?} and {v:?}"))
}

/// A hit, or that there is none, against what the catalogue says: `miss`; `hit`, by any of the
/// triangles named or by any at all; and `t` with the distance.
pub(super) fn hit(case: &Case, setting: &Setting, found: Option<Hit>) -> Verdict {
    let Some(hit) = found else {
        return Verdict::Wrong("the unit gave no answer".to_owned());
    };
    let is_coarse = distance_error(&setting.arch) > 0.0;
    let coarse = is_coarse && case.may_lose("coarse").is_some();
    if case.gives("miss") {
        return match hit.is_hit() {
            true if coarse => {
                let what =
                    "beside the edge, or the end, by less than a coarse reciprocal may be off";
                Verdict::Bounded(what.to_owned())
            }
            true => Verdict::Wrong(format!("a hit: {hit:?}")),
            false => Verdict::Right,
        };
    }
    let test = setting.arch.system.tni.intersection.name();
    if !hit.is_hit() {
        return match case.may_lose(test) {
            Some(_) => Verdict::Bounded(format!("lost by {test}, and nothing else is hit")),
            None if coarse => {
                Verdict::Bounded("at the end, by what a coarse reciprocal is off".to_owned())
            }
            None => Verdict::Wrong("a miss".to_owned()),
        };
    }
    let inside =
        hit.u >= 0.0 && hit.v >= 0.0 && f64::from(hit.u) + f64::from(hit.v) <= 1.0 + 2.0 * U;
    if !inside || !hit.t.is_finite() {
        return Verdict::Wrong(format!("no place in a triangle: {hit:?}"));
    }
    let words = case.gives.split(|w| w == "t");
    let mut words = words.map(|part| part.iter().filter_map(|w| super::catalogue::number(w)));
    let mut allowed = words
        .next()
        .into_iter()
        .flatten()
        .map(f32::from_bits)
        .peekable();
    if allowed.peek().is_some() && !allowed.any(|p| p as u32 == hit.primitive) {
        return Verdict::Wrong(format!("another triangle: {hit:?}"));
    }
    let Some(distance) = words.next().and_then(|mut t| t.next()) else {
        return Verdict::Right;
    };
    let t = f64::from(f32::from_bits(distance));
    let off = (f64::from(hit.t) - t).abs();
    if case.may_lose(test).is_some() && off > case.within * ulp(t) && off <= 0.5 * t {
        let text = format!("{test} says {}, not {t}: off by less than a half", hit.t);
        return Verdict::Bounded(text);
    }
    within(case, setting, off, t, || format!("t = {}, not {t}", hit.t))
}
