//! The findings in the rows of a sweep: which points nothing beats, and which parameter moves what.

use super::measure::Measure;
use super::rows::{self, Row};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// The columns by which points are compared, in this order, where rows have them.
const OBJECTIVES: [&str; 5] = ["cycles", "ii", "energy", "area", "psnr"];

/// Fronts and sensitivities of the rows of one subject.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Analysis {
    /// The subject.
    pub subject: String,
    /// The columns by which points are compared.
    pub objectives: Vec<String>,
    /// The rows that no other beats in one objective without being beaten in another: their points.
    pub front: Vec<usize>,
    /// How far each parameter moves each objective, the strongest first.
    pub sensitivities: Vec<Sensitivity>,
}

/// The effect of a parameter on an objective, over all rows.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Sensitivity {
    /// The parameter.
    pub parameter: String,
    /// The objective.
    pub objective: String,
    /// The mean of the objective for each value, over all settings of the others; numbers in order.
    pub means: Vec<(String, f64)>,
    /// The largest mean over the smallest, less 1.
    pub spread: f64,
    /// The part of the objective's variance that the means explain (η²), from 0 to 1.
    pub explained: f64,
}

/// The analysis of every subject of some rows.
pub fn analyse(rows: &[Row]) -> Vec<Analysis> {
    let mut subjects: Vec<&str> = rows.iter().map(|r| r.subject.as_str()).collect();
    subjects.sort_unstable();
    subjects.dedup();
    subjects
        .into_iter()
        .map(|subject| Analysis::of(subject, rows))
        .collect()
}

impl Analysis {
    fn of(subject: &str, rows: &[Row]) -> Analysis {
        let rows: Vec<&Row> = rows.iter().filter(|r| r.subject == subject).collect();
        let known = |column: &&str| rows.iter().any(|r| r.figure(column).is_some());
        let mut objectives: Vec<&str> = OBJECTIVES.into_iter().filter(known).collect();
        // Where there are cycles, IIs are a reason for them and no aim of their own.
        if objectives.contains(&"cycles") {
            objectives.retain(|o| *o != "ii");
        }
        let mut sensitivities: Vec<Sensitivity> = (rows::settings(&copied(&rows)).iter())
            .flat_map(|parameter| {
                let of = |objective: &&str| sensitivity(parameter, objective, &rows);
                objectives.iter().filter_map(of).collect::<Vec<_>>()
            })
            .collect();
        sensitivities.sort_by(|a, b| {
            let objective = |s: &Sensitivity| objectives.iter().position(|o| *o == s.objective);
            (objective(a).cmp(&objective(b))).then(b.explained.total_cmp(&a.explained))
        });
        Analysis {
            subject: subject.to_owned(),
            front: front(&rows, &objectives),
            objectives: objectives.into_iter().map(str::to_owned).collect(),
            sensitivities,
        }
    }
}

fn copied(rows: &[&Row]) -> Vec<Row> {
    rows.iter().map(|r| (*r).clone()).collect()
}

/// The points that nothing beats.
fn front(rows: &[&Row], objectives: &[&str]) -> Vec<usize> {
    let figures = |row: &Row| -> Option<Vec<f64>> {
        let of = |objective: &&str| {
            let figure = row.figure(objective)?;
            Some(if Measure::is_better_larger(objective) {
                -figure
            } else {
                figure
            })
        };
        objectives.iter().map(of).collect()
    };
    let all: Vec<(usize, Vec<f64>)> = (rows.iter())
        .filter_map(|row| Some((row.point, figures(row)?)))
        .collect();
    let beats = |a: &[f64], b: &[f64]| {
        let pairs = || a.iter().zip(b);
        pairs().all(|(a, b)| a <= b) && pairs().any(|(a, b)| a < b)
    };
    let stays = |(_, figures): &&(usize, Vec<f64>)| !all.iter().any(|(_, o)| beats(o, figures));
    all.iter().filter(stays).map(|(point, _)| *point).collect()
}

fn sensitivity(parameter: &str, objective: &str, rows: &[&Row]) -> Option<Sensitivity> {
    let mut groups: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for row in rows {
        if let (Some(value), Some(figure)) = (row.settings.get(parameter), row.figure(objective)) {
            groups.entry(value).or_default().push(figure);
        }
    }
    let mean = |figures: &[f64]| figures.iter().sum::<f64>() / figures.len() as f64;
    let all: Vec<f64> = groups.values().flatten().copied().collect();
    if groups.len() < 2 {
        return None;
    }
    let whole = mean(&all);
    let total: f64 = all.iter().map(|f| (f - whole) * (f - whole)).sum();
    let between = |figures: &Vec<f64>| {
        let off = mean(figures) - whole;
        figures.len() as f64 * off * off
    };
    let explained: f64 = groups.values().map(between).sum();
    let mut means: Vec<(String, f64)> = groups
        .iter()
        .map(|(value, figures)| ((*value).to_owned(), mean(figures)))
        .collect();
    means.sort_by(|(a, _), (b, _)| order(a, b));
    let least = means.iter().map(|(_, m)| *m).fold(f64::INFINITY, f64::min);
    let most = means
        .iter()
        .map(|(_, m)| *m)
        .fold(f64::NEG_INFINITY, f64::max);
    Some(Sensitivity {
        parameter: parameter.to_owned(),
        objective: objective.to_owned(),
        spread: if least > 0.0 { most / least - 1.0 } else { 0.0 },
        explained: if total > 0.0 { explained / total } else { 0.0 },
        means,
    })
}

/// Orders values: numbers with their sizes, others by their letters.
pub fn order(a: &str, b: &str) -> std::cmp::Ordering {
    match (number(a), number(b)) {
        (Some(x), Some(y)) => x.total_cmp(&y),
        _ => a.cmp(b),
    }
}

/// The number that a value is, sizes as `16K` too.
pub fn number(text: &str) -> Option<f64> {
    let (digits, unit) = match text.strip_suffix(['K', 'M']) {
        Some(digits) if text.ends_with('K') => (digits, 1024.0),
        Some(digits) => (digits, 1024.0 * 1024.0),
        None => (text, 1.0),
    };
    digits.parse().ok().map(|number: f64| number * unit)
}

#[cfg(test)]
mod tests {
    use super::super::rows::Outcome;
    use super::*;

    fn row(point: usize, settings: [(&str, &str); 2], cycles: f64, area: f64) -> Row {
        let own = |(a, b): (&str, &str)| (a.to_owned(), b.to_owned());
        let figures = [("cycles".to_owned(), cycles), ("area".to_owned(), area)];
        Row {
            key: point.to_string(),
            point,
            subject: "s".to_owned(),
            settings: settings.map(own).into(),
            outcome: Outcome::Figures(figures.into()),
            machine: String::new(),
            build: String::new(),
            host: String::new(),
            seconds: 0.0,
        }
    }

    #[test]
    fn fronts_and_sensitivities_are_those_of_the_table() {
        // Cycles follow `a` alone, area follows `b` alone.
        let rows = [
            row(0, [("a", "1"), ("b", "1")], 100.0, 10.0),
            row(1, [("a", "1"), ("b", "2")], 100.0, 20.0),
            row(2, [("a", "10"), ("b", "1")], 50.0, 10.0),
            row(3, [("a", "10"), ("b", "2")], 50.0, 20.0),
        ];
        let analysis = &analyse(&rows)[0];
        assert_eq!(analysis.objectives, ["cycles", "area"]);
        assert_eq!(analysis.front, [2]);
        let of = |parameter: &str, objective: &str| {
            let mut all = analysis.sensitivities.iter();
            all.find(|s| s.parameter == parameter && s.objective == objective)
                .expect("one")
        };
        assert_eq!(
            (of("a", "cycles").explained, of("a", "cycles").spread),
            (1.0, 1.0)
        );
        assert_eq!(of("b", "cycles").explained, 0.0);
        assert_eq!(
            of("b", "area").means,
            [("1".to_owned(), 10.0), ("2".to_owned(), 20.0)]
        );
        assert_eq!(analysis.sensitivities[0].parameter, "a");
    }
}
