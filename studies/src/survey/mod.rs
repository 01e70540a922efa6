//! Totals and ratios of a finite population from a stratified random sample of it, with intervals.
//!
//! Nothing here knows what the units are. Each has a size and other auxiliary variables that are known in
//! advance, and, once it is drawn, values. The estimators are those of W. G. Cochran, *Sampling
//! Techniques*, 3rd edition (1977), and of C.-E. Särndal, B. Swensson and J. Wretman, *Model Assisted
//! Survey Sampling* (1992); each function names its formula.

mod population;
mod random;
mod regression;
mod sample;

use serde::Serialize;

pub use population::{Population, Stratum};
pub use random::Random;
pub use sample::{Sample, Variance};

/// A sample of so many units of a stratum is the least that shows its spread.
pub const LEAST_DRAWS: usize = 2;

/// More is drawn than the spread so far asks for: it is an estimate too.
const MARGIN: f64 = 1.1;

/// A figure of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// Half the width of its 95 % confidence interval; infinite where the sample is too small to
    /// know it.
    pub half_width: f64,
}

impl Estimate {
    /// A figure that is known.
    pub fn exact(value: f64) -> Estimate {
        Estimate {
            value,
            half_width: 0.0,
        }
    }

    /// Half the width over the value.
    pub fn relative(&self) -> f64 {
        match self.value == 0.0 {
            true if self.half_width == 0.0 => 0.0,
            _ => self.half_width / self.value.abs(),
        }
    }

    /// True if the interval holds `truth`, up to a rounding of sums.
    pub fn covers(&self, truth: f64) -> bool {
        (self.value - truth).abs() <= self.half_width + 1e-9 * truth.abs()
    }

    /// Times a constant.
    pub fn times(&self, factor: f64) -> Estimate {
        Estimate {
            value: self.value * factor,
            half_width: self.half_width * factor.abs(),
        }
    }

    /// A constant over it (to first order: the relative error stays).
    pub fn under(&self, numerator: f64) -> Estimate {
        let value = numerator / self.value;
        Estimate {
            value,
            half_width: value.abs() * self.relative(),
        }
    }
}

/// How many draws of each stratum a sample needs for half a width of `target`, relative to the value,
/// when `draws` of them gave `found`: in proportion to the square (Cochran 4.4), with a margin, so that
/// one more look is nearly always the last. Few looks keep the interval's promise, which stopping at
/// a lucky moment would break.
pub fn draws_needed(draws: usize, found: f64, target: f64) -> usize {
    if !found.is_finite() {
        return 2 * draws;
    }
    let factor = (found / target) * (found / target) * MARGIN;
    ((draws as f64 * factor).ceil() as usize).clamp(draws + 1, 2 * draws)
}

/// The 97.5 % point of Student's t: exact for 1 and 2 degrees of freedom, else its expansion in
/// 1/degrees (Abramowitz and Stegun 26.7.5).
pub fn student(freedom: f64) -> f64 {
    let z: f64 = 1.959_963_985;
    if freedom < 1.5 {
        return 12.706;
    }
    if freedom < 2.5 {
        return 4.303;
    }
    let g1 = (z.powi(3) + z) / 4.0;
    let g2 = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
    let g3 = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
    let g4 = (79.0 * z.powi(9) + 776.0 * z.powi(7) + 1482.0 * z.powi(5)
        - 1920.0 * z.powi(3)
        - 945.0 * z)
        / 92_160.0;
    let n = freedom;
    z + g1 / n + g2 / n.powi(2) + g3 / n.powi(3) + g4 / n.powi(4)
}

/// Estimates the quotient of two sums over a population from a simple random sample of it: Cochran 6.2 and
/// 6.4, without the correction for a population that is hardly larger.
pub fn ratio(numerators: &[f64], denominators: &[f64]) -> Estimate {
    let n = numerators.len().min(denominators.len()) as f64;
    let below: f64 = denominators.iter().sum();
    if n == 0.0 || below == 0.0 {
        return Estimate::exact(0.0);
    }
    let value = numerators.iter().sum::<f64>() / below;
    if n < 2.0 {
        return Estimate {
            value,
            half_width: f64::INFINITY,
        };
    }
    let squares = (numerators.iter().zip(denominators)).map(|(a, b)| (a - value * b).powi(2));
    let variance = squares.sum::<f64>() / (n - 1.0) / n;
    Estimate {
        value,
        half_width: student(n - 1.0) * variance.sqrt() / (below / n),
    }
}

/// Half the width of the 95 % interval of a mean, over the mean; `None` of fewer than two values or
/// of a mean that is not above 0 (Cochran 2.8).
pub fn relative_error(values: &[f64]) -> Option<f64> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    if values.len() < 2 || mean <= 0.0 {
        return None;
    }
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0);
    Some(student(n - 1.0) * (variance / n).sqrt() / mean)
}

#[cfg(test)]
mod tests;
