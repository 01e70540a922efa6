//! A sample of a population: totals and quotients of the whole, with intervals.

use super::population::{Population, Stratum};
use super::regression::{Fit, Regression};
use super::{Estimate, LEAST_DRAWS, student};

/// Drawn units of one stratum.
#[derive(Clone, Debug)]
struct Drawn {
    /// Units of the stratum.
    of: f64,
    units: Vec<usize>,
}

/// Variance of the auxiliary variables' totals that is left by not having looked at all units.
#[derive(Clone, Debug)]
struct Unlooked {
    covariances: Vec<Vec<f64>>,
    freedom: f64,
}

impl Unlooked {
    /// Σ N_h (N_h − n_h) / n_h times the covariances of the stratum (Cochran 5.3); `None` where all were looked at.
    fn of(population: &Population) -> Option<Unlooked> {
        let partly = population
            .strata
            .iter()
            .filter(|s| s.of > s.looked.len() as f64);
        let columns = population.auxiliaries.first().map_or(0, Vec::len);
        let mut unlooked = Unlooked {
            covariances: vec![vec![0.0; columns]; columns],
            freedom: 0.0,
        };
        for Stratum { of, looked } in partly {
            let n = looked.len() as f64;
            let rows = || looked.iter().map(|&u| &population.auxiliaries[u as usize]);
            let mean = |k: usize| rows().map(|row| row[k]).sum::<f64>() / n;
            let means: Vec<f64> = (0..columns).map(mean).collect();
            let scale = of * (of - n) / n / (n - 1.0).max(1.0);
            for (a, sums) in unlooked.covariances.iter_mut().enumerate() {
                for (b, sum) in sums.iter_mut().enumerate() {
                    let products = rows().map(|row| (row[a] - means[a]) * (row[b] - means[b]));
                    *sum += scale * products.sum::<f64>();
                }
            }
            unlooked.freedom += n - 1.0;
        }
        (unlooked.freedom > 0.0).then_some(unlooked)
    }

    /// The variance of a total with these slopes.
    fn variance(&self, slopes: &[f64]) -> f64 {
        let row = |(sums, a): (&Vec<f64>, &f64)| {
            a * sums.iter().zip(slopes).map(|(s, b)| s * b).sum::<f64>()
        };
        self.covariances.iter().zip(slopes).map(row).sum()
    }
}

/// A sample: units drawn from a population.
#[derive(Clone, Debug)]
pub struct Sample {
    strata: Vec<Drawn>,
    regression: Regression,
    /// Sums of the auxiliary variables over the population.
    totals: Vec<f64>,
    unlooked: Option<Unlooked>,
    complete: bool,
}

/// The variance of an estimate by its parts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Variance {
    /// From what drawing leaves of the residuals.
    pub drawn: f64,
    /// From not having looked at all units.
    pub unlooked: f64,
}

impl Sample {
    /// The sample of these units; values are given in their order.
    pub fn new(population: &Population, units: &[u32]) -> Sample {
        let mut stratum_of = vec![0; population.len()];
        for (h, stratum) in population.strata.iter().enumerate() {
            let looked = stratum.looked.iter();
            looked.for_each(|&u| stratum_of[u as usize] = h);
        }
        let mut strata: Vec<Drawn> = (population.strata.iter())
            .map(|s| Drawn {
                of: s.of,
                units: Vec::new(),
            })
            .collect();
        for (i, &unit) in units.iter().enumerate() {
            strata[stratum_of[unit as usize]].units.push(i);
        }
        let columns = population.auxiliaries.first().map_or(0, Vec::len);
        let rows = |s: &Stratum, k: usize| -> f64 {
            let of = s
                .looked
                .iter()
                .map(|&u| population.auxiliaries[u as usize][k]);
            s.of / s.looked.len().max(1) as f64 * of.sum::<f64>()
        };
        let sum = |k: usize| population.strata.iter().map(|s| rows(s, k)).sum();
        // A unit stands for N/n of its stratum, and for as much of the error of a total.
        let weight = |unit: u32| {
            let stratum = &strata[stratum_of[unit as usize]];
            (stratum.of / stratum.units.len() as f64).powi(2)
        };
        let rows = units
            .iter()
            .map(|&u| &population.auxiliaries[u as usize][..]);
        let weights: Vec<f64> = units.iter().map(|&u| weight(u)).collect();
        Sample {
            complete: strata.iter().all(|s| s.units.len() as f64 == s.of),
            unlooked: Unlooked::of(population),
            regression: Regression::of(rows.collect(), &weights),
            totals: (0..columns).map(sum).collect(),
            strata,
        }
    }

    /// Estimates the sum of a value over the population with the generalised regression estimator (Särndal
    /// 6.4). Its variance is that of a stratified sample of the residuals (Cochran 5.3), and of the totals of
    /// the units that were looked at (Särndal 9.7).
    pub fn total(&self, values: &[f64]) -> Estimate {
        if self.complete {
            return Estimate::exact(self.expand(values));
        }
        let fit = self.regression.fit(values);
        let explained: f64 = (self.totals.iter().zip(&fit.slopes))
            .map(|(x, b)| x * b)
            .sum();
        Estimate {
            value: explained + self.expand(&fit.residuals),
            half_width: self.half_width(&fit),
        }
    }

    /// The variance of a total by its parts.
    pub fn variance(&self, values: &[f64]) -> Variance {
        let fit = self.regression.fit(values);
        Variance {
            drawn: self.drawn(&self.unseen(&fit.residuals)).0,
            unlooked: self.unlooked(&fit.slopes),
        }
    }

    fn unlooked(&self, slopes: &[f64]) -> f64 {
        let variance = self.unlooked.as_ref().map(|u| u.variance(slopes));
        variance.unwrap_or(0.0).max(0.0)
    }

    /// The quotient of the sums of two auxiliary variables: nothing of it is left to drawing.
    pub fn known(&self, numerator: usize, denominator: usize) -> Estimate {
        let below = self.totals.get(denominator).copied().unwrap_or(0.0);
        if below == 0.0 {
            return Estimate::exact(0.0);
        }
        let value = self.totals[numerator] / below;
        let mut slopes = vec![0.0; self.totals.len()];
        slopes[numerator] += 1.0 / below;
        slopes[denominator] -= value / below;
        let freedom = self.unlooked.as_ref().map_or(1.0, |u| u.freedom);
        Estimate {
            value,
            half_width: student(freedom) * self.unlooked(&slopes).sqrt(),
        }
    }

    /// The quotient of two sums: the ratio of their estimates, with the variance of its linear form
    /// (Särndal 5.6.2).
    pub fn ratio(&self, numerators: &[f64], denominators: &[f64]) -> Estimate {
        let below = self.total(denominators).value;
        if below == 0.0 {
            return Estimate::exact(0.0);
        }
        let value = self.total(numerators).value / below;
        let residuals: Vec<f64> = (numerators.iter().zip(denominators))
            .map(|(a, b)| (a - value * b) / below)
            .collect();
        Estimate {
            value,
            half_width: self.total(&residuals).half_width,
        }
    }

    /// Σ N_h ȳ_h (Cochran 5.1).
    fn expand(&self, values: &[f64]) -> f64 {
        let drawn = self.strata.iter().filter(|s| !s.units.is_empty());
        drawn
            .map(|s| s.of * s.units.iter().map(|&i| values[i]).sum::<f64>() / s.units.len() as f64)
            .sum()
    }

    /// Student's t times the root of the variance, with Satterthwaite's degrees of freedom (Cochran 5.4).
    fn half_width(&self, fit: &Fit) -> f64 {
        let unknown = |s: &Drawn| s.units.len() < LEAST_DRAWS && (s.units.len() as f64) < s.of;
        if self.strata.iter().any(unknown) {
            return f64::INFINITY;
        }
        let (mut variance, mut fourth) = self.drawn(&self.unseen(&fit.residuals));
        if let Some(unlooked) = &self.unlooked {
            let part = self.unlooked(&fit.slopes);
            variance += part;
            fourth += part * part / unlooked.freedom;
        }
        if variance <= 0.0 {
            return 0.0;
        }
        student((variance * variance / fourth).max(1.0)) * variance.sqrt()
    }

    /// The variance of a total of residuals (Cochran 5.3), and the sum of the squares of its parts over their degrees
    /// of freedom.
    fn drawn(&self, residuals: &[f64]) -> (f64, f64) {
        let (mut variance, mut fourth) = (0.0, 0.0);
        for stratum in &self.strata {
            let n = stratum.units.len() as f64;
            if n < 2.0 || n >= stratum.of {
                continue;
            }
            let mean = stratum.units.iter().map(|&i| residuals[i]).sum::<f64>() / n;
            let squares = stratum.units.iter().map(|&i| (residuals[i] - mean).powi(2));
            let part = stratum.of * (stratum.of - n) / n * squares.sum::<f64>() / (n - 1.0);
            variance += part;
            fourth += part * part / (n - 1.0);
        }
        (variance, fourth)
    }

    /// The residuals that units would have had, had the slopes been found without them: what slopes explain
    /// of a sample by chance is not explained of the rest.
    fn unseen(&self, residuals: &[f64]) -> Vec<f64> {
        let left = self.regression.left();
        residuals
            .iter()
            .zip(left)
            .map(|(r, left)| r / left)
            .collect()
    }
}
