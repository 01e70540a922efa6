//! Combinations of settings: which are tried, and what is known when the search ends.

use super::setting::{self, Setting};
use super::target::{quality, relative_cost, relative_costs};
use super::trial::Trial;
use super::{Bench, Report, Shown};
use crate::Error;
use crate::search::{self, Combined, Point, Space};
use std::collections::{BTreeMap, BTreeSet};

/// Combinations that are tried between two looks at what is known.
const BATCH: usize = 8;

/// The part by which a cost must be lower to count as lower.
const LEAST_GAIN: f64 = 1e-3;

/// The cost that a trial's objectives come to.
type Axis<'a> = dyn Fn(&[f64]) -> f64 + 'a;

/// Settings of one knob that may be combined with those of others, by their numbers among the trials.
struct Knob {
    trials: Vec<usize>,
}

/// Tries combinations of settings that meet the target each, and adds them to the report: neighbours of those
/// that are best in cycles, area, energy and their product, until none is left that is predicted to be better.
pub(super) fn combine(
    bench: &Bench<'_>,
    report: &mut Report,
    settings: &[Setting],
    budget: usize,
    shown: &Shown<'_>,
) -> Result<(), Error> {
    let Some(base) = report.trials.first().cloned() else {
        return Ok(());
    };
    let knobs = knobs(report);
    let (noise, target) = (report.cycle_noise, report.target.clone());
    let costs = |t: &Trial| relative_costs(t, &base, noise);
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
        let mut winners = BTreeSet::new();
        let axes: [&Axis<'_>; 4] = [&|o| o[1], &|o| o[2], &|o| o[3], &product];
        for axis in axes {
            let met = (0..tried.len()).filter(|&i| keeps(&tried[i].1));
            let cost = |i: usize| {
                let o = objectives(&tried[i].1);
                (axis(&o), product(&o))
            };
            winners.extend(met.min_by(|&a, &b| {
                let (a, b) = (cost(a), cost(b));
                a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
            }));
        }
        winners.into_iter().collect()
    };
    let promising = |tried: &[(Point, Option<Trial>)], predicted: &[f64]| {
        let met = || tried.iter().filter(|(_, t)| keeps(t));
        let least = |of: &Axis<'_>| {
            met()
                .map(|(_, t)| of(&objectives(t)))
                .fold(f64::INFINITY, f64::min)
        };
        let better = |of: &Axis<'_>| of(predicted) < least(of) * (1.0 - LEAST_GAIN);
        better(&product) || (1..4).any(|i| better(&|o| o[i]))
    };
    let alone: usize = knobs.iter().map(|k| k.trials.len()).sum();
    let space = Space {
        sizes: knobs.iter().map(|k| k.trials.len() + 1).collect(),
        budget: 1 + alone + budget,
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
    let known: Vec<Trial> = report.trials.clone();
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
                    let parts: Vec<&Setting> = several.iter().map(|&i| &settings[i]).collect();
                    open.push(i);
                    combinations.push(Setting::together(&parts));
                }
            }
        }
        if !open.is_empty() {
            let results = bench.all(&combinations, true, shown);
            for (i, result) in open.into_iter().zip(results) {
                match result? {
                    super::Tried::Trial(trial) => {
                        made.push((*trial).clone());
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
    report.trials.extend(made);
    report.screened = refused;
    report.closed = found.closed || found.exhaustive;
    Ok(())
}

/// The settings that meet the target alone and are exercised, knob by knob.
fn knobs(report: &Report) -> Vec<Knob> {
    let mut knobs: Vec<Knob> = Vec::new();
    let mut places: BTreeMap<&str, usize> = BTreeMap::new();
    for (i, trial) in report.trials.iter().enumerate().skip(1) {
        if setting::is_sampling(&trial.knob) || trial.not_exercised || !report.target.met_by(trial)
        {
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
