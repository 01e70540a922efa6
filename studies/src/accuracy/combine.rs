//! Combinations of settings: which are tried, and what is known when the search ends.

use super::setting::{self, Setting};
use super::target::{quality, relative_cost, relative_costs};
use super::trial::Trial;
use super::{Bench, Report, Shown};
use crate::Error;
use crate::search::{self, Combined, MOST_OF_GRID, Point, Space};
use std::collections::{BTreeMap, BTreeSet};

/// Combinations that are tried between two looks at what is known.
const BATCH: usize = 8;

/// The part by which a cost must be lower to count as lower.
const LEAST_GAIN: f64 = 1e-3;

/// The part by which a predicted cost may be worse than one that is known, for costs do not quite multiply.
const SLACK: f64 = 0.01;

/// dB by which a prediction may be wrong: what is predicted to miss the target by more is not tried.
const DOUBT: f64 = 3.0;

/// Settings of one knob that may be combined with those of others, by their numbers among the trials.
struct Knob {
    trials: Vec<usize>,
}

/// Tries combinations of settings, and adds them to the report and to the settings of its trials. A grid is all of them. A search takes settings
/// that meet the target each, and tries neighbours of those that are on a front of error and cycles, area or energy
/// or have the least product, until none is left that is predicted to be better.
pub(super) fn combine(
    bench: &Bench<'_>,
    report: &mut Report,
    settings: &mut Vec<Setting>,
    shown: &Shown<'_>,
) -> Result<(), Error> {
    let (grid, budget) = (bench.options.grid, bench.options.combinations);
    let Some(base) = report.trials.first().cloned() else {
        return Ok(());
    };
    let knobs = knobs(report, grid);
    let sizes: Vec<usize> = knobs.iter().map(|k| k.trials.len() + 1).collect();
    let points = sizes
        .iter()
        .fold(1, |n: usize, &size| n.saturating_mul(size));
    if grid && points > MOST_OF_GRID {
        return Err(Error::invalid(format_args!(
            "there are {points} combinations, and a grid may have {MOST_OF_GRID}: choose fewer knobs with --knob"
        )));
    }
    // Cycles as they are: what differs by less than the noise is told apart no better later, but leads on.
    let target = report.target.clone();
    let costs = |t: &Trial| relative_costs(t, &base, 0.0);
    let objectives = |t: &Option<Trial>| match t {
        Some(t) => {
            let [cycles, area, energy] = costs(t);
            // The mean squared error, which adds where errors are independent.
            vec![10f64.powf(-quality(t) / 10.0), cycles, area, energy]
        }
        None => vec![f64::INFINITY; 4],
    };
    let keeps = |t: &Option<Trial>| t.as_ref().is_some_and(|t| target.met_by(t));
    let product = |objectives: &[f64]| objectives[1..].iter().product::<f64>();
    let winners = |tried: &[(Point, Option<Trial>)]| {
        let met: Vec<usize> = (0..tried.len()).filter(|&i| keeps(&tried[i].1)).collect();
        let known: Vec<Vec<f64>> = met.iter().map(|&i| objectives(&tried[i].1)).collect();
        let mut winners = BTreeSet::new();
        for axis in 1..4 {
            let of_axis: Vec<Vec<f64>> = known.iter().map(|o| vec![o[0], o[axis]]).collect();
            winners.extend(search::front(&of_axis).into_iter().map(|i| met[i]));
        }
        let least =
            (0..met.len()).min_by(|&a, &b| product(&known[a]).total_cmp(&product(&known[b])));
        winners.extend(least.map(|i| met[i]));
        winners.into_iter().collect()
    };
    let promising = |tried: &[(Point, Option<Trial>)], predicted: &[f64]| {
        let db = -10.0 * predicted[0].max(f64::MIN_POSITIVE).log10();
        let known = || {
            tried
                .iter()
                .filter(|(_, t)| keeps(t))
                .map(|(_, t)| objectives(t))
        };
        // It must be better than all that is known on a front, or in the product.
        let better = |axis: usize| {
            let beats =
                |o: &Vec<f64>| o[0] <= predicted[0] && o[axis] * (1.0 + SLACK) <= predicted[axis];
            !known().any(|o| beats(&o))
        };
        let least = known().map(|o| product(&o)).fold(f64::INFINITY, f64::min);
        let may_meet = target.least_psnr().is_none_or(|least| db >= least - DOUBT);
        may_meet && (product(predicted) < least * (1.0 - LEAST_GAIN) || (1..4).any(better))
    };
    let of_one: usize = knobs.iter().map(|k| k.trials.len()).sum();
    let space = Space {
        sizes,
        budget: match grid {
            true => points,
            false => 1 + of_one + budget,
        },
        batch: BATCH,
        combined: vec![
            Combined::Added,
            Combined::Multiplied,
            Combined::Multiplied,
            Combined::Multiplied,
        ],
        objectives: &objectives,
        winners: &winners,
        promising: &promising,
    };
    let (known, alone) = (report.trials.clone(), settings.clone());
    let mut made = Vec::new();
    let mut refused = 0;
    let found = search::search(&space, |points| {
        let mut trials: Vec<Option<Option<Trial>>> = vec![None; points.len()];
        let (mut open, mut combinations) = (Vec::new(), Vec::new());
        for (i, point) in points.iter().enumerate() {
            let turned: Vec<usize> = (knobs.iter().zip(point))
                .filter(|&(_, &value)| value > 0)
                .map(|(knob, &value)| knob.trials[value - 1])
                .collect();
            match turned.as_slice() {
                [] => trials[i] = Some(Some(base.clone())),
                [one] => trials[i] = Some(Some(known[*one].clone())),
                several => {
                    let parts: Vec<&Setting> = several.iter().map(|&i| &alone[i]).collect();
                    open.push(i);
                    combinations.push(Setting::together(&parts));
                }
            }
        }
        if !open.is_empty() {
            let results = bench.all(&combinations, !grid, shown);
            for ((i, setting), result) in open.into_iter().zip(combinations).zip(results) {
                match result? {
                    super::Tried::Trial(trial) => {
                        made.push((setting, (*trial).clone()));
                        trials[i] = Some(Some(*trial));
                    }
                    super::Tried::Refused => {
                        refused += 1;
                        trials[i] = Some(None);
                    }
                    super::Tried::Cancelled => {}
                }
            }
        }
        Ok::<_, Error>(trials)
    })?;
    for (setting, trial) in made {
        settings.push(setting);
        report.trials.push(trial);
    }
    report.screened = refused;
    report.exhaustive = grid && found.exhaustive;
    report.closed = found.closed || found.exhaustive;
    Ok(())
}

/// The settings that are exercised, and, but for a `grid`, meet the target alone, knob by knob.
fn knobs(report: &Report, grid: bool) -> Vec<Knob> {
    let mut knobs: Vec<Knob> = Vec::new();
    let mut places: BTreeMap<&str, usize> = BTreeMap::new();
    for (i, trial) in report.trials.iter().enumerate().skip(1) {
        let chosen = grid || report.target.met_by(trial);
        if setting::is_sampling(&trial.knob) || trial.not_exercised || !chosen {
            continue;
        }
        let place = *places.entry(&trial.knob).or_insert(knobs.len());
        if place == knobs.len() {
            knobs.push(Knob { trials: Vec::new() });
        }
        knobs[place].trials.push(i);
    }
    knobs
}

/// The cost of a trial that the cheapest is chosen by.
pub(super) fn cost(report: &Report, trial: &Trial) -> f64 {
    let base = report.trials.first();
    base.map_or(1.0, |base| relative_cost(trial, base, report.cycle_noise))
}
