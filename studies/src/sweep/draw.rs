//! Drawing the points of a plan that can be told before any is measured: all of a grid, a list, or random ones.

use super::point::{MAX_POINTS, Parameter, Point};
use super::search::Budget;
use crate::Error;
use crate::survey::Random;

/// The way in which points are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sample {
    /// Every combination.
    Grid,
    /// Those that are listed.
    List,
    /// So many, each parameter by itself.
    Random(usize),
    /// So many by a Latin hypercube (McKay, Beckman and Conover 1979): each parameter takes all parts of its range
    /// equally often.
    LatinHypercube(usize),
    /// Those that a search proposes, one generation after the other.
    Search(Budget),
}

impl Sample {
    /// Reads `grid`, `list`, `random:N`, `lhs:N`, `search:N` or `search:N:P`; where nothing is said, a list if there is one.
    pub(super) fn parse(text: Option<&str>, listed: bool) -> Result<Sample, Error> {
        let wrong = || {
            let text = text.unwrap_or_default();
            Error::Invalid(format!(
                "sample `{text}`: write grid, list, random:N, lhs:N, search:N or search:N:P (P points a generation), N up to \
                 {MAX_POINTS}"
            ))
        };
        let number = |text: &str| {
            let number = text.parse().ok();
            let number = number.filter(|n| (1..=MAX_POINTS).contains(n));
            number.ok_or_else(wrong)
        };
        match text.map(|text| text.split_once(':').unwrap_or((text, ""))) {
            None if listed => Ok(Sample::List),
            None | Some(("grid", "")) => Ok(Sample::Grid),
            Some(("list", "")) => Ok(Sample::List),
            Some(("random", count)) => Ok(Sample::Random(number(count)?)),
            Some(("lhs", count)) => Ok(Sample::LatinHypercube(number(count)?)),
            Some(("search", budget)) => {
                Ok(Sample::Search(Budget::parse(budget).ok_or_else(wrong)?))
            }
            Some(_) => Err(wrong()),
        }
    }

    /// The points, each once; none of a search.
    pub(super) fn points(
        self,
        parameters: &[Parameter],
        listed: Vec<Point>,
        seed: u64,
    ) -> Result<Vec<Point>, Error> {
        let points = match self {
            Sample::Grid => grid(parameters)?,
            Sample::List if listed.is_empty() => {
                return Err(Error::Invalid(
                    "a list needs [[point]]s in the plan".to_owned(),
                ));
            }
            Sample::List => listed,
            Sample::Random(count) => random(parameters, count, seed),
            Sample::LatinHypercube(count) => latin(parameters, count, seed),
            Sample::Search(_) => Vec::new(),
        };
        let mut once: Vec<Point> = Vec::with_capacity(points.len());
        let mut known = std::collections::BTreeSet::new();
        for point in points {
            if known.insert(point.0.clone()) {
                once.push(point);
            }
        }
        Ok(once)
    }
}

/// Every combination; the last parameter changes first.
fn grid(parameters: &[Parameter]) -> Result<Vec<Point>, Error> {
    let mut count: usize = 1;
    for parameter in parameters {
        let Some(values) = parameter.values.count() else {
            return Err(Error::Invalid(format!(
                "`{}` has a range, and a grid needs values: write FROM:TO:STEP, or sample by random:N, lhs:N or \
                 search:N",
                parameter.name
            )));
        };
        count = count.saturating_mul(values);
    }
    if count > MAX_POINTS {
        return Err(Error::Invalid(format!(
            "this grid has {count} points, and {MAX_POINTS} are possible: sample by random:N, lhs:N or search:N"
        )));
    }
    let point = |mut number: usize| {
        let mut settings = Vec::new();
        for parameter in parameters.iter().rev() {
            let values = parameter.values.count().unwrap_or(1);
            let part = ((number % values) as f64 + 0.5) / values as f64;
            settings.push((parameter.name.clone(), parameter.values.at(part)));
            number /= values;
        }
        Point(settings.into_iter().collect())
    };
    Ok((0..count).map(point).collect())
}

/// A number from 0 to below 1.
fn part(random: &mut Random) -> f64 {
    (random.draw() >> 11) as f64 / (1u64 << 53) as f64
}

fn random(parameters: &[Parameter], count: usize, seed: u64) -> Vec<Point> {
    let mut random = Random::new(seed);
    let point = |_| {
        let settings = parameters.iter();
        let settings = settings.map(|p| (p.name.clone(), p.values.at(part(&mut random))));
        Point(settings.collect())
    };
    (0..count).map(point).collect()
}

fn latin(parameters: &[Parameter], count: usize, seed: u64) -> Vec<Point> {
    let mut random = Random::new(seed);
    let mut points = vec![Point(Default::default()); count];
    for parameter in parameters {
        let mut strata: Vec<usize> = (0..count).collect();
        random.shuffle(&mut strata);
        for (point, stratum) in points.iter_mut().zip(strata) {
            let part = (stratum as f64 + part(&mut random)) / count as f64;
            point
                .0
                .insert(parameter.name.clone(), parameter.values.at(part));
        }
    }
    points
}
