//! The progress of a search: what its points cost, and how far its front has come with each generation.

use super::front::{dominates, own_volume};
use super::objective::Objective;
use super::rows::Row;
use super::search::Search;
use libm::{exp, log};
use schemars::JsonSchema;
use serde::Serialize;

/// Most objectives whose hypervolume is told: it takes too long for more.
const MOST_OBJECTIVES: usize = 4;

/// How far a search has come.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Progress {
    /// Points that the plan allows.
    pub budget: usize,
    /// Points that are measured in the end: fewer where the parameters have no more.
    pub points: usize,
    /// Points of a generation.
    pub generation: usize,
    /// The columns that are made small or large. With several subjects a point's figure is the geometric mean over them, of
    /// PSNR the mean.
    pub objectives: Vec<String>,
    /// Those of them that are the better the larger they are.
    pub larger_is_better: Vec<String>,
    /// The generations that are known.
    pub generations: Vec<Generation>,
}

/// What is known after a generation.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Generation {
    /// Points so far.
    pub points: usize,
    /// Those of them that have all figures.
    pub valid: usize,
    /// Points of the front so far, points with the same figures once.
    pub front: usize,
    /// The best figure so far in each objective.
    pub best: Vec<f64>,
    /// The part of the box between the best and the worst figures of all generations that the front so far dominates (the
    /// hypervolume), of two to four objectives.
    pub hypervolume: Option<f64>,
}

/// The figures of a point, whose rows these are; `None` if one of them failed, or an objective has no figure.
pub(super) fn figures_of(objectives: &[Objective], rows: &[&Row]) -> Option<Vec<f64>> {
    let of = |objective: &Objective| combined(objective, rows);
    let able = rows.iter().all(|row| row.has_figures());
    able.then(|| objectives.iter().map(of).collect())?
}

/// The figure of a point, over all subjects that have it.
fn combined(objective: &Objective, rows: &[&Row]) -> Option<f64> {
    let known = rows.iter().filter_map(|row| row.figure(&objective.column));
    let known: Vec<f64> = known.collect();
    let mean = |figures: &mut dyn Iterator<Item = f64>| figures.sum::<f64>() / known.len() as f64;
    match known[..] {
        [] => None,
        [one] => Some(one),
        // Decibels are logarithms already.
        _ if objective.column == "psnr" => Some(mean(&mut known.iter().copied())),
        _ => Some(exp(mean(&mut known.iter().map(|f| log(*f))))),
    }
}

impl Progress {
    /// A sentence about the search.
    pub fn in_words(&self) -> String {
        let known = self
            .generations
            .last()
            .map_or(0, |generation| generation.points);
        let so_far = if known < self.points {
            format!("{known} of ")
        } else {
            String::new()
        };
        let end = match self.points < self.budget {
            true => format!(
                ", all that the parameters have; {} were allowed",
                self.budget
            ),
            false => String::new(),
        };
        let aim = |column: &String| match self.larger_is_better.contains(column) {
            true => format!("largest {column}"),
            false => format!("least {column}"),
        };
        let aims: Vec<String> = self.objectives.iter().map(aim).collect();
        format!(
            "search for {}: {so_far}{} points, {} a generation{end}",
            aims.join(", "),
            self.points,
            self.generation
        )
    }

    /// Of the rows of a search, by point and subject.
    pub(super) fn of(
        search: &Search,
        objectives: &[Objective],
        rows: &[Row],
        subjects: usize,
    ) -> Progress {
        let rows: Vec<&Row> = rows.iter().collect();
        let points = rows.chunk_by(|a, b| a.point == b.point).enumerate();
        // A point after one that is not known belongs to a generation that is under way.
        let whole =
            |(number, rows): &(usize, &[&Row])| rows[0].point == *number && rows.len() == subjects;
        let of_point = |rows: &[&Row]| Some(costs(objectives, &figures_of(objectives, rows)?));
        let costs: Vec<Option<Vec<f64>>> = points
            .take_while(whole)
            .map(|(_, rows)| of_point(rows))
            .collect();
        Progress {
            budget: search.budget(),
            points: search.points(),
            generation: search.generation(),
            objectives: objectives.iter().map(|o| o.column.clone()).collect(),
            larger_is_better: (objectives.iter().filter(|o| o.largest))
                .map(|o| o.column.clone())
                .collect(),
            generations: generations(objectives, &costs, search.generation()),
        }
    }
}

/// Figures so that smaller ones are better.
pub(super) fn costs(objectives: &[Objective], figures: &[f64]) -> Vec<f64> {
    let pairs = objectives.iter().zip(figures);
    pairs
        .map(|(objective, figure)| objective.cost(*figure))
        .collect()
}

fn generations(
    objectives: &[Objective],
    costs: &[Option<Vec<f64>>],
    size: usize,
) -> Vec<Generation> {
    let ends = |objective: usize| {
        let known = costs.iter().flatten().map(|costs| costs[objective]);
        known.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), c| {
            (l.min(c), m.max(c))
        })
    };
    let box_ends: Vec<(f64, f64)> = (0..objectives.len()).map(ends).collect();
    // An objective that is the same everywhere takes no part.
    let placed = |costs: &Vec<f64>| -> Vec<f64> {
        let places = costs
            .iter()
            .zip(&box_ends)
            .filter(|(_, (least, most))| most > least);
        places
            .map(|(cost, (least, most))| (cost - least) / (most - least))
            .collect()
    };
    let mut front: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    let (mut valid, mut volume) = (0, 0.0);
    let has_volume = (2..=MOST_OBJECTIVES).contains(&objectives.len());
    let mut all = Vec::new();
    for (number, own) in costs.iter().enumerate() {
        if let Some(own) = own {
            valid += 1;
            let beaten = front
                .iter()
                .any(|(other, _)| other == own || dominates(other, own));
            if !beaten {
                let place = placed(own);
                if has_volume {
                    let others: Vec<Vec<f64>> =
                        front.iter().map(|(_, place)| place.clone()).collect();
                    volume += own_volume(&place, &others);
                }
                front.retain(|(other, _)| !dominates(own, other));
                front.push((own.clone(), place));
            }
        }
        if (number + 1) % size == 0 || number + 1 == costs.len() {
            let best = |objective: usize| {
                let least = front.iter().map(|(own, _)| own[objective]);
                objectives[objective].cost(least.fold(f64::INFINITY, f64::min))
            };
            all.push(Generation {
                points: number + 1,
                valid,
                front: front.len(),
                best: match front.is_empty() {
                    true => Vec::new(),
                    false => (0..objectives.len()).map(best).collect(),
                },
                hypervolume: (has_volume && valid > 0).then_some(volume),
            });
        }
    }
    all
}
