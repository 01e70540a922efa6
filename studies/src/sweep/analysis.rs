//! The findings in the rows of a sweep: which points nothing beats, and which parameter moves what.

use super::front;
use super::objective::Objective;
use super::rows::{self, Row};
use super::values::order;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// Fronts and sensitivities of the rows of one subject.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Analysis {
    /// The subject.
    pub subject: String,
    /// The columns by which points are compared.
    pub objectives: Vec<String>,
    /// Those of them that are the better the larger they are.
    pub larger_is_better: Vec<String>,
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

/// The analysis of every subject of some rows, by these objectives; without any, by the usual ones that rows have.
pub fn analyse(rows: &[Row], objectives: &[Objective]) -> Vec<Analysis> {
    let mut subjects: Vec<&str> = rows.iter().map(|r| r.subject.as_str()).collect();
    subjects.sort_unstable();
    subjects.dedup();
    subjects
        .into_iter()
        .map(|subject| Analysis::of(subject, rows, objectives))
        .collect()
}

impl Analysis {
    fn of(subject: &str, rows: &[Row], stated: &[Objective]) -> Analysis {
        let rows: Vec<&Row> = rows.iter().filter(|r| r.subject == subject).collect();
        let has = |column: &str| rows.iter().any(|r| r.figure(column).is_some());
        let objectives: Vec<Objective> = match stated {
            [] => Objective::usual(&has),
            _ => stated.iter().filter(|o| has(&o.column)).cloned().collect(),
        };
        let columns: Vec<&str> = objectives.iter().map(|o| o.column.as_str()).collect();
        let mut sensitivities: Vec<Sensitivity> = (rows::settings(&copied(&rows)).iter())
            .flat_map(|parameter| {
                let of = |objective: &&str| sensitivity(parameter, objective, &rows);
                columns.iter().filter_map(of).collect::<Vec<_>>()
            })
            .collect();
        sensitivities.sort_by(|a, b| {
            let objective = |s: &Sensitivity| columns.iter().position(|o| *o == s.objective);
            (objective(a).cmp(&objective(b))).then(b.explained.total_cmp(&a.explained))
        });
        Analysis {
            subject: subject.to_owned(),
            front: best(&rows, &objectives),
            objectives: columns.iter().map(|o| (*o).to_owned()).collect(),
            larger_is_better: (objectives.iter().filter(|o| o.largest))
                .map(|o| o.column.clone())
                .collect(),
            sensitivities,
        }
    }
}

fn copied(rows: &[&Row]) -> Vec<Row> {
    rows.iter().map(|r| (*r).clone()).collect()
}

/// The points that nothing beats.
fn best(rows: &[&Row], objectives: &[Objective]) -> Vec<usize> {
    if objectives.is_empty() {
        return Vec::new();
    }
    let costs = |row: &Row| -> Option<Vec<f64>> {
        let of = |objective: &Objective| Some(objective.cost(row.figure(&objective.column)?));
        objectives.iter().map(of).collect()
    };
    let (points, all): (Vec<usize>, Vec<Vec<f64>>) = (rows.iter())
        .filter_map(|row| Some((row.point, costs(row)?)))
        .unzip();
    front::front(&all).into_iter().map(|i| points[i]).collect()
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
    // Of equal figures rounding alone makes a variance, which says nothing.
    let total: f64 = match all.iter().all(|f| *f == all[0]) {
        true => 0.0,
        false => all.iter().map(|f| (f - whole) * (f - whole)).sum(),
    };
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
        spread: if least > 0.0 && total > 0.0 {
            most / least - 1.0
        } else {
            0.0
        },
        explained: if total > 0.0 { explained / total } else { 0.0 },
        means,
    })
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
            subject_hash: String::new(),
            kernels_hash: String::new(),
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
        let analysis = &analyse(&rows, &[])[0];
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

    #[test]
    fn equal_figures_have_nothing_that_moves_them() {
        // Their mean is another number by rounding.
        let settings = |a: &'static str| [("a", a), ("b", "1")];
        let rows: Vec<Row> = (0..12)
            .map(|i| row(i, settings(["1", "2", "3"][i % 3]), 65.146_700_1, 0.1))
            .collect();
        let analysis = &analyse(&rows, &[])[0];
        for moving in &analysis.sensitivities {
            assert_eq!((moving.explained, moving.spread), (0.0, 0.0));
        }
    }
}
