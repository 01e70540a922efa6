//! Totals and ratios of a finite population from a stratified random sample of it, with intervals.
//!
//! Nothing here knows what the units are. Each has a size and other auxiliary variables that are known in
//! advance, and, once it is drawn, values. The estimators are those of W. G. Cochran, *Sampling
//! Techniques*, 3rd edition (1977), and of C.-E. Särndal, B. Swensson and J. Wretman, *Model Assisted
//! Survey Sampling* (1992); each function names its formula.

mod regression;

use serde::Serialize;

use regression::Regression;

/// Bits of a binary64 number below those that size classes share: two classes an octave.
const CLASS_BITS: u32 = 51;

/// A sample of so many units of a stratum is the least that shows its spread.
pub const LEAST_DRAWS: usize = 2;

/// More is drawn than the spread so far asks for: it is an estimate too.
const MARGIN: f64 = 1.1;

/// Random numbers, the same on every host: `SplitMix64` (Steele, Lea and Flood 2014).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    /// The next number.
    pub fn draw(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `n` ≥ 1.
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.draw()) * n as u128) >> 64) as usize
    }

    /// Puts things into a random order (Fisher and Yates).
    pub fn shuffle<T>(&mut self, things: &mut [T]) {
        for i in (1..things.len()).rev() {
            things.swap(i, self.below(i + 1));
        }
    }
}

/// A population of units 0, 1, 2 …, each with a known size, in strata.
#[derive(Clone, Debug)]
pub struct Population {
    sizes: Vec<f64>,
    /// Of each unit the auxiliary variables, the most telling first.
    auxiliaries: Vec<Vec<f64>>,
    strata: Vec<Vec<u32>>,
}

impl Population {
    /// Units with one auxiliary variable besides the 1 of each: their size.
    pub fn sized(sizes: Vec<f64>, count: usize) -> Population {
        let auxiliaries = sizes.iter().map(|&x| vec![1.0, x]).collect();
        Population::of(sizes, auxiliaries, count)
    }

    /// At most about `count` strata. Units are numbered so that neighbours are alike. A stratum is a
    /// run of neighbours of about one size; strata have about the same sum of roots of sizes, so that a
    /// draw from each takes more of the large units. What units vary by, and what they cost, is taken to
    /// go with their size (Cochran 5.5: allocation in proportion to N·S/√c).
    pub fn of(sizes: Vec<f64>, auxiliaries: Vec<Vec<f64>>, count: usize) -> Population {
        let smallest = sizes.iter().copied().fold(f64::INFINITY, f64::min);
        let smallest = smallest.max(f64::MIN_POSITIVE);
        let class = |x: f64| (x / smallest).to_bits() >> CLASS_BITS;
        let mut units: Vec<u32> = (0..sizes.len() as u32).collect();
        units.sort_by_key(|&u| (class(sizes[u as usize]), u));
        let share = sizes.iter().map(|&x| x.sqrt()).sum::<f64>() / count.max(1) as f64;
        let mut strata: Vec<Vec<u32>> = Vec::new();
        let (mut open, mut last) = (share, None);
        for unit in units {
            let x = sizes[unit as usize];
            // A new class begins a stratum where the one before has its draws.
            let enough = strata.last().is_some_and(|s| s.len() >= 2 * LEAST_DRAWS);
            let other = last.is_some_and(|c| c != class(x)) && open >= share / 2.0;
            if strata.is_empty() || (enough && (open >= share || other)) {
                strata.push(Vec::new());
                open = 0.0;
            }
            open += x.sqrt();
            last = Some(class(x));
            strata.last_mut().expect("one is open").push(unit);
        }
        Population {
            sizes,
            auxiliaries,
            strata,
        }
    }

    /// Number of units.
    pub fn len(&self) -> usize {
        self.sizes.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.sizes.is_empty()
    }

    /// Number of strata.
    pub fn strata(&self) -> usize {
        self.strata.len()
    }

    /// The whole population in random batches: each takes one more unit of every stratum that has
    /// units left, so the first k batches are a stratified random sample without replacement.
    pub fn batches(&self, seed: u64) -> Vec<Vec<u32>> {
        let mut random = Random::new(seed);
        let mut shuffled = self.strata.clone();
        shuffled.iter_mut().for_each(|s| random.shuffle(s));
        let most = shuffled.iter().map(Vec::len).max().unwrap_or(0);
        let batch = |i: usize| {
            let drawn = shuffled.iter().filter_map(|s| s.get(i).copied());
            let mut drawn: Vec<u32> = drawn.collect();
            drawn.sort_unstable();
            drawn
        };
        (0..most).map(batch).collect()
    }
}

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

    /// Whether the interval holds `truth`, up to a rounding of sums.
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

/// Drawn units of one stratum.
#[derive(Clone, Debug)]
struct Drawn {
    /// Units of the stratum.
    of: f64,
    units: Vec<usize>,
}

/// A sample: units drawn from a population.
#[derive(Clone, Debug)]
pub struct Sample {
    strata: Vec<Drawn>,
    regression: Regression,
    /// Sums of the auxiliary variables over the population.
    totals: Vec<f64>,
    complete: bool,
}

impl Sample {
    /// The sample of these units; values are given in their order.
    pub fn new(population: &Population, units: &[u32]) -> Sample {
        let mut stratum_of = vec![0; population.len()];
        for (h, stratum) in population.strata.iter().enumerate() {
            stratum.iter().for_each(|&u| stratum_of[u as usize] = h);
        }
        let mut strata: Vec<Drawn> = (population.strata.iter())
            .map(|s| Drawn {
                of: s.len() as f64,
                units: Vec::new(),
            })
            .collect();
        for (i, &unit) in units.iter().enumerate() {
            strata[stratum_of[unit as usize]].units.push(i);
        }
        let columns = population.auxiliaries.first().map_or(0, Vec::len);
        let sum = |k: usize| population.auxiliaries.iter().map(|row| row[k]).sum();
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
            complete: units.len() == population.len(),
            regression: Regression::of(rows.collect(), &weights),
            totals: (0..columns).map(sum).collect(),
            strata,
        }
    }

    /// The sum of a value over the population: the generalised regression estimator (Särndal 6.4), its
    /// variance that of a stratified sample of the residuals (Cochran 5.3).
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
            half_width: self.half_width(&self.unseen(&fit.residuals)),
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

    /// Student's t times the root of the variance (Cochran 5.3), with Satterthwaite's degrees of
    /// freedom (Cochran 5.4).
    fn half_width(&self, residuals: &[f64]) -> f64 {
        let unknown = |s: &Drawn| s.units.len() < LEAST_DRAWS && (s.units.len() as f64) < s.of;
        if self.strata.iter().any(unknown) {
            return f64::INFINITY;
        }
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
        if variance <= 0.0 {
            return 0.0;
        }
        student((variance * variance / fourth).max(1.0)) * variance.sqrt()
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

/// The quotient of two sums over a population, of a simple random sample of it: Cochran 6.2 and 6.4,
/// without the correction for a population that is hardly larger.
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
