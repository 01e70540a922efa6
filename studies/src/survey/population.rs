//! The population that samples are drawn from: units in strata, and their auxiliary variables.

use super::{LEAST_DRAWS, Random};

/// Bits of a binary64 number below those that size classes share: two classes an octave.
const CLASS_BITS: u32 = 51;

/// A population in strata. Units 0, 1, 2 … have been looked at: all, or a random sample of each stratum
/// (double sampling, Cochran 12).
#[derive(Clone, Debug)]
pub struct Population {
    /// The auxiliary variables of each unit, the most telling first.
    pub(super) auxiliaries: Vec<Vec<f64>>,
    pub(super) strata: Vec<Stratum>,
}

/// A stratum.
#[derive(Clone, Debug)]
pub struct Stratum {
    /// How many units it has.
    pub of: f64,
    /// Those that have been looked at.
    pub looked: Vec<u32>,
}

impl Population {
    /// Units with one auxiliary variable besides the 1 of each: their size.
    pub fn sized(sizes: Vec<f64>, count: usize) -> Population {
        let auxiliaries = sizes.iter().map(|&x| vec![1.0, x]).collect();
        Population::of(sizes, auxiliaries, count)
    }

    /// Units with these auxiliary variables, each in one of the strata.
    pub fn looked_at(auxiliaries: Vec<Vec<f64>>, strata: Vec<Stratum>) -> Population {
        Population {
            auxiliaries,
            strata,
        }
    }

    /// Divides units into at most about `count` strata. Units are numbered so that neighbours are alike. A
    /// stratum is a run of neighbours of about one size; strata have about the same sum of roots of sizes, so
    /// that a draw from each takes more of the large units. Variance and cost are taken to grow with size
    /// (Cochran 5.5: allocation in proportion to N·S/√c).
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
        let all = |looked: Vec<u32>| Stratum {
            of: looked.len() as f64,
            looked,
        };
        Population {
            auxiliaries,
            strata: strata.into_iter().map(all).collect(),
        }
    }

    /// Number of units that have been looked at.
    pub fn len(&self) -> usize {
        self.auxiliaries.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.auxiliaries.is_empty()
    }

    /// Number of strata.
    pub fn strata(&self) -> usize {
        self.strata.len()
    }

    /// Returns the units that were looked at, in random batches: each takes one more unit of every stratum
    /// that has units left, so the first k batches are a stratified random sample without replacement.
    pub fn batches(&self, seed: u64) -> Vec<Vec<u32>> {
        let mut random = Random::new(seed);
        let mut shuffled: Vec<Vec<u32>> = self.strata.iter().map(|s| s.looked.clone()).collect();
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
