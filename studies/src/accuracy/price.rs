//! The price of a dB: for each step of quality the least cycles, area and energy of a trial that has it.

use super::target::{quality, relative_costs};
use super::trial::Trial;
use schemars::JsonSchema;
use serde::Serialize;

/// Steps of quality, dB.
const STEPS: [f64; 9] = [60.0, 55.0, 50.0, 45.0, 40.0, 35.0, 30.0, 25.0, 20.0];

/// The least costs of a quality, each beside the machine as it is.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Price {
    /// PSNR at least, dB.
    pub decibels: f64,
    /// Cycles of the frame, over those of the machine as it is; 1 where they differ by noise.
    pub cycles: f64,
    /// Area, over that of the machine as it is.
    pub area: f64,
    /// Energy of the frame, over that of the machine as it is.
    pub energy: f64,
    /// The trials that cost so much, by their numbers: cycles, area, energy.
    pub trials: [usize; 3],
}

/// The prices of each step that a trial reaches. Only trials without leaks count, with the light of the machine
/// as it is and units that the frame uses.
pub(super) fn prices(trials: &[Trial], noise: f64) -> Vec<Price> {
    let Some(base) = trials.first() else {
        return Vec::new();
    };
    let counts = |t: &Trial| !t.is_sampling() && !t.not_exercised && t.leaks.leaks == 0;
    let price = |decibels: f64| {
        let reached: Vec<usize> = (0..trials.len())
            .filter(|&i| counts(&trials[i]) && quality(&trials[i]) >= decibels)
            .collect();
        let least = |axis: usize| {
            let cost = |i: usize| relative_costs(&trials[i], base, noise)[axis];
            let best = reached
                .iter()
                .copied()
                .min_by(|&a, &b| cost(a).total_cmp(&cost(b)))?;
            Some((best, cost(best)))
        };
        let [cycles, area, energy] = [least(0)?, least(1)?, least(2)?];
        Some(Price {
            decibels,
            cycles: cycles.1,
            area: area.1,
            energy: energy.1,
            trials: [cycles.0, area.0, energy.0],
        })
    };
    let mut prices: Vec<Price> = STEPS.into_iter().filter_map(price).collect();
    // A step at which nothing gets cheaper is no news.
    prices.dedup_by(|next, before| next.trials == before.trials);
    prices
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn less_quality_never_costs_more() {
        let trial = |psnr, cycles, area| {
            let mut trial = Trial::empty();
            trial.all.psnr = Some(psnr);
            (trial.costs.frame_cycles, trial.costs.area) = (cycles, area);
            trial
        };
        let mut unused = trial(58.0, 10, 0.1);
        unused.not_exercised = true;
        let trials = [
            trial(57.0, 1000, 1.0),
            trial(51.0, 995, 0.8),
            trial(42.0, 700, 0.9),
            unused,
        ];
        let prices = prices(&trials, 0.01);
        let levels: Vec<f64> = prices.iter().map(|p| p.decibels).collect();
        assert_eq!(levels, [55.0, 50.0, 40.0]);
        // Half a percent of cycles is the noise of orders.
        assert_eq!(prices[1].cycles, 1.0);
        assert_eq!(prices[2].cycles, 0.7);
        assert!(prices.is_sorted_by(|a, b| a.area >= b.area && a.cycles >= b.cycles));
    }
}
