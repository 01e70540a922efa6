//! The search for the best combinations of settings.
//!
//! A [`Point`] chooses a value of every knob; value 0 leaves a knob as it is. Every trial is dear, so the
//! search tries each setting alone first and takes it that settings change things independently: errors
//! add, and costs multiply. What that predicts orders the candidates; only trials decide. The candidates
//! of a round are the *neighbours* of the winners so far, which differ from one of them in a single knob
//! (Pareto local search: Paquete, Chiarandini and Stützle, 2004). The search is *closed* when every neighbour
//! of every winner has been tried or is predicted not to be worth it; only then may a report say that nothing
//! better was found.

use std::collections::{BTreeMap, BTreeSet};

/// Points that a grid may have.
pub(crate) const MOST_OF_GRID: usize = 100_000;

/// A value of every knob, by its number; 0 as it is.
pub(crate) type Point = Vec<usize>;

/// How an objective of a combination follows from those of its settings alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Combined {
    /// The differences that the settings make alone are added.
    Added,
    /// The factors by which they change it alone are multiplied.
    Multiplied,
}

/// Chooses among trials.
pub(crate) type Winners<'a, T> = dyn Fn(&[(Point, T)]) -> Vec<usize> + 'a;

/// Judges objectives that are predicted, beside the trials that were made.
pub(crate) type Promising<'a, T> = dyn Fn(&[(Point, T)], &[f64]) -> bool + 'a;

/// The space that is searched.
pub(crate) struct Space<'a, T> {
    /// How many values each knob has, the one as it is among them.
    pub(crate) sizes: Vec<usize>,
    /// Trials that may be made.
    pub(crate) budget: usize,
    /// Trials that are made between two looks at what is known.
    pub(crate) batch: usize,
    /// How objectives combine; all are the better the smaller they are.
    pub(crate) combined: Vec<Combined>,
    /// The objectives of a trial.
    pub(crate) objectives: &'a dyn Fn(&T) -> Vec<f64>,
    /// The trials whose neighbours are to be tried, by their numbers.
    pub(crate) winners: &'a Winners<'a, T>,
    /// True when a point that is predicted to have these objectives is worth a trial.
    pub(crate) promising: &'a Promising<'a, T>,
}

/// The outcome of a search.
#[derive(Clone, Debug)]
pub(crate) struct Findings<T> {
    /// All trials in the order in which they were made.
    pub(crate) tried: Vec<(Point, T)>,
    /// True when no neighbour of a winner is left that is worth a trial.
    pub(crate) closed: bool,
    /// True when everything was tried.
    pub(crate) exhaustive: bool,
}

impl<T> Space<'_, T> {
    /// How many points there are.
    pub(crate) fn points(&self) -> usize {
        let product = |n: usize, &size: &usize| n.saturating_mul(size);
        self.sizes.iter().fold(1, product)
    }

    /// The points that differ from one in one knob.
    fn neighbours(&self, of: &Point) -> impl Iterator<Item = Point> {
        let knobs = self.sizes.iter().enumerate();
        let moves = knobs.flat_map(|(knob, &size)| (0..size).map(move |value| (knob, value)));
        moves
            .filter(|&(knob, value)| of[knob] != value)
            .map(|(knob, value)| {
                let mut point = of.clone();
                point[knob] = value;
                point
            })
    }
}

/// Searches. `evaluate` makes trials, none of those that were cancelled; a search ends where one was.
pub(crate) fn search<T, E>(
    space: &Space<'_, T>,
    mut evaluate: impl FnMut(&[Point]) -> Result<Vec<Option<T>>, E>,
) -> Result<Findings<T>, E> {
    let base = vec![0; space.sizes.len()];
    let exhaustive = space.points() <= space.budget;
    let mut first = vec![base.clone()];
    first.extend(space.neighbours(&base));
    if exhaustive {
        let known: BTreeSet<Point> = first.iter().cloned().collect();
        first.extend(all(&space.sizes).into_iter().filter(|p| !known.contains(p)));
    }
    let mut findings = Findings {
        tried: Vec::new(),
        closed: false,
        exhaustive,
    };
    let mut left = space.budget.max(1);
    let mut next = first;
    loop {
        let cut = next.len() > left;
        next.truncate(left);
        left -= next.len();
        let trials = evaluate(&next)?;
        let cancelled = trials.iter().any(Option::is_none);
        let made = next.into_iter().zip(trials);
        findings
            .tried
            .extend(made.filter_map(|(p, t)| Some((p, t?))));
        findings.exhaustive &= !cancelled;
        if cancelled || cut {
            return Ok(findings);
        }
        next = candidates(space, &findings.tried);
        if next.is_empty() {
            findings.closed = true;
            return Ok(findings);
        }
        if left == 0 {
            return Ok(findings);
        }
        next.truncate(space.batch);
    }
}

/// All points, in order.
fn all(sizes: &[usize]) -> Vec<Point> {
    let extended = |points: Vec<Point>, &size: &usize| {
        let with = |point: &Point, value| [point.as_slice(), &[value]].concat();
        let points = points.iter();
        points
            .flat_map(|point| (0..size).map(move |value| with(point, value)))
            .collect()
    };
    sizes.iter().fold(vec![Vec::new()], extended)
}

/// The untried neighbours of the winners that are worth a trial, the most promising first.
fn candidates<T>(space: &Space<'_, T>, tried: &[(Point, T)]) -> Vec<Point> {
    let model = Model::of(space, tried);
    let known: BTreeSet<&Point> = tried.iter().map(|(point, _)| point).collect();
    let mut found: BTreeMap<Point, Vec<f64>> = BTreeMap::new();
    for winner in (space.winners)(tried) {
        for point in space.neighbours(&tried[winner].0) {
            if known.contains(&point) || found.contains_key(&point) {
                continue;
            }
            let predicted = model.predict(&tried[winner], &point);
            if (space.promising)(tried, &predicted) {
                found.insert(point, predicted);
            }
        }
    }
    let mut ranked: Vec<(usize, f64, Point)> = found
        .iter()
        .map(|(point, predicted)| {
            let beats = |other: &&Vec<f64>| dominates(other, predicted);
            let beaten = found.values().filter(beats).count();
            (beaten, predicted[1..].iter().product(), point.clone())
        })
        .collect();
    ranked.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    ranked.into_iter().map(|(_, _, point)| point).collect()
}

/// The change that each setting makes alone.
struct Model<'a, T> {
    space: &'a Space<'a, T>,
    base: Vec<f64>,
    alone: BTreeMap<(usize, usize), Vec<f64>>,
}

impl<'a, T> Model<'a, T> {
    fn of(space: &'a Space<'a, T>, tried: &[(Point, T)]) -> Model<'a, T> {
        let mut model = Model {
            space,
            base: Vec::new(),
            alone: BTreeMap::new(),
        };
        for (point, trial) in tried {
            let mut turned = (0..point.len()).filter(|&knob| point[knob] != 0);
            match (turned.next(), turned.next()) {
                (None, _) => model.base = (space.objectives)(trial),
                (Some(knob), None) => {
                    let objectives = (space.objectives)(trial);
                    model.alone.insert((knob, point[knob]), objectives);
                }
                _ => {}
            }
        }
        model
    }

    /// The objectives of a setting alone; those of the base where it is as it is.
    fn alone(&self, knob: usize, value: usize) -> &[f64] {
        self.alone.get(&(knob, value)).unwrap_or(&self.base)
    }

    /// The objectives of a point that differs from a trial in some knobs.
    fn predict(&self, (from, trial): &(Point, T), point: &Point) -> Vec<f64> {
        let mut objectives = (self.space.objectives)(trial);
        for knob in (0..point.len()).filter(|&knob| point[knob] != from[knob]) {
            let (old, new) = (self.alone(knob, from[knob]), self.alone(knob, point[knob]));
            for (i, objective) in objectives.iter_mut().enumerate() {
                match self.space.combined[i] {
                    Combined::Added => *objective = (*objective + new[i] - old[i]).max(0.0),
                    Combined::Multiplied if old[i] != 0.0 => *objective *= new[i] / old[i],
                    Combined::Multiplied => {}
                }
            }
        }
        objectives
    }
}

/// True when objectives are nowhere worse than others and somewhere better.
pub(crate) fn dominates(a: &[f64], b: &[f64]) -> bool {
    let pairs = || a.iter().zip(b);
    pairs().all(|(a, b)| a <= b) && pairs().any(|(a, b)| a < b)
}

/// The numbers of those that no other dominates; of equal ones the first.
pub(crate) fn front(objectives: &[Vec<f64>]) -> Vec<usize> {
    let beaten = |i: usize| {
        let mut others = objectives.iter().enumerate();
        others
            .any(|(j, other)| dominates(other, &objectives[i]) || j < i && *other == objectives[i])
    };
    (0..objectives.len()).filter(|&i| !beaten(i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors that add and costs that multiply, but for one pair of settings that go badly together.
    fn trial(point: &Point) -> Vec<f64> {
        let sum: usize = point.iter().map(|v| v * v).sum();
        let clash = if point[0] == 2 && point[1] == 2 {
            50.0
        } else {
            0.0
        };
        let cost = point.iter().fold(1.0, |cost, &v| cost / (1.0 + v as f64));
        vec![sum as f64 + clash, cost]
    }

    fn run(sizes: &[usize], budget: usize) -> Findings<Vec<f64>> {
        let objectives = |t: &Vec<f64>| t.clone();
        let winners = |tried: &[(Point, Vec<f64>)]| {
            let all: Vec<Vec<f64>> = tried.iter().map(|(_, t)| t.clone()).collect();
            front(&all)
        };
        let promising = |tried: &[(Point, Vec<f64>)], predicted: &[f64]| {
            !tried.iter().any(|(_, t)| dominates(t, predicted))
        };
        let space = Space {
            sizes: sizes.to_vec(),
            budget,
            batch: 8,
            combined: vec![Combined::Added, Combined::Multiplied],
            objectives: &objectives,
            winners: &winners,
            promising: &promising,
        };
        let evaluate =
            |points: &[Point]| Ok::<_, ()>(points.iter().map(|p| Some(trial(p))).collect());
        search(&space, evaluate).expect("nothing fails")
    }

    #[test]
    fn a_part_of_the_grid_has_its_front() {
        let sizes = [4, 4, 4, 4];
        let (grid, found) = (run(&sizes, 256), run(&sizes, 130));
        assert!(grid.exhaustive && grid.tried.len() == 256);
        assert!(!found.exhaustive && found.closed, "{}", found.tried.len());
        let best = |findings: &Findings<Vec<f64>>| {
            let all: Vec<Vec<f64>> = findings.tried.iter().map(|(_, t)| t.clone()).collect();
            let mut best: Vec<Vec<f64>> = front(&all).into_iter().map(|i| all[i].clone()).collect();
            best.sort_by(|a, b| a[0].total_cmp(&b[0]));
            best
        };
        assert_eq!(best(&grid), best(&found));
    }

    #[test]
    fn a_search_that_runs_out_says_so() {
        let found = run(&[4, 4, 4, 4, 4, 4], 40);
        assert!(!found.closed && found.tried.len() == 40);
    }
}
