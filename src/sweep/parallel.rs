//! Parallel coordinates (Inselberg 1985): an axis for every parameter and objective, a line for every row.

use super::text::{figure, heading};
use maud::{Markup, html};
use srp_studies::sweep::{Analysis, Row, number, order};

/// Size of the drawing and its margins.
const STEP: f64 = 130.0;
const HEIGHT: f64 = 300.0;
const ABOVE: f64 = 34.0;
const BELOW: f64 = 14.0;
const BESIDE: f64 = 60.0;
/// Most values of an axis that are written.
const MOST_TICKS: usize = 12;

/// An axis: its title, and the place of every row on it, from 0 below to 1 above.
struct Axis {
    title: String,
    ticks: Vec<(f64, String)>,
    places: Vec<Option<f64>>,
}

impl Axis {
    /// The axis of a parameter: its values at equal distances.
    fn of_parameter(name: &str, rows: &[&Row]) -> Axis {
        let mut values: Vec<&str> = rows
            .iter()
            .filter_map(|r| r.settings.get(name))
            .map(String::as_str)
            .collect();
        values.sort_by(|a, b| order(a, b));
        values.dedup();
        let last = values.len().saturating_sub(1).max(1) as f64;
        let numbers: Option<Vec<f64>> = values.iter().map(|v| number(v)).collect();
        // Many numbers lie where their sizes put them.
        let place = |value: &str| match (&numbers, values.len() > MOST_TICKS) {
            (Some(numbers), true) => {
                let (least, most) = (numbers[0], numbers[numbers.len() - 1]);
                (number(value).unwrap_or(least) - least) / (most - least).max(f64::MIN_POSITIVE)
            }
            _ => values.iter().position(|v| *v == value).unwrap_or(0) as f64 / last,
        };
        let every = values.len().div_ceil(MOST_TICKS).max(1);
        Axis {
            title: name.to_owned(),
            ticks: (values.iter().step_by(every))
                .map(|v| (place(v), (*v).to_owned()))
                .collect(),
            places: rows
                .iter()
                .map(|r| r.settings.get(name).map(|v| place(v)))
                .collect(),
        }
    }

    /// The axis of an objective, from its least to its largest figure.
    fn of_objective(column: &str, rows: &[&Row]) -> Axis {
        let figures: Vec<Option<f64>> = rows.iter().map(|r| r.figure(column)).collect();
        let known = || figures.iter().flatten().copied();
        let (least, most) = (
            known().fold(f64::INFINITY, f64::min),
            known().fold(f64::NEG_INFINITY, f64::max),
        );
        let place = |f: f64| {
            if most > least {
                (f - least) / (most - least)
            } else {
                0.5
            }
        };
        let ticks = match most > least {
            true => [0.0, 0.25, 0.5, 0.75, 1.0]
                .map(|part| (part, figure(column, least + part * (most - least))))
                .to_vec(),
            false => vec![(0.5, figure(column, least))],
        };
        Axis {
            title: heading(column),
            ticks,
            places: figures.iter().map(|f| f.map(place)).collect(),
        }
    }
}

/// The drawing of the rows of a subject. Lines of the front stand out.
pub(super) fn svg(analysis: &Analysis, names: &[String], rows: &[&Row]) -> Markup {
    let parameters = names.iter().map(|name| Axis::of_parameter(name, rows));
    let objectives = analysis
        .objectives
        .iter()
        .map(|o| Axis::of_objective(o, rows));
    let axes: Vec<Axis> = parameters.chain(objectives).collect();
    let width = 2.0 * BESIDE + STEP * axes.len().saturating_sub(1) as f64;
    let x = |axis: usize| BESIDE + STEP * axis as f64;
    let y = |place: f64| HEIGHT - BELOW - place * (HEIGHT - ABOVE - BELOW);
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by_key(|&row| analysis.front.contains(&rows[row].point));
    let path = |row: usize| -> Option<String> {
        let points = axes.iter().enumerate().map(|(i, axis)| {
            let letter = if i == 0 { 'M' } else { 'L' };
            Some(format!("{letter}{:.1} {:.1}", x(i), y(axis.places[row]?)))
        });
        points.collect()
    };
    html! {
        svg.parallel viewBox={ "0 0 " (width) " " (HEIGHT) } style={ "min-width:" (width * 0.8) "px" } role="img" {
            @for &row in &order {
                @if let Some(path) = path(row) {
                    path.best[analysis.front.contains(&rows[row].point)] d=(path) {
                        title { "point " (rows[row].point) }
                    }
                }
            }
            @for (i, axis) in axes.iter().enumerate() {
                line.axis x1=(x(i)) x2=(x(i)) y1=(y(0.0)) y2=(y(1.0)) {}
                text x=(x(i)) y="14" text-anchor="middle" { (short(&axis.title)) title { (axis.title) } }
                @for (place, label) in &axis.ticks {
                    text.tick x=(x(i) + 5.0) y=(format!("{:.1}", y(*place) + 4.0)) { (label) }
                }
            }
        }
    }
}

/// A title that fits between two axes: its end tells more than its beginning.
fn short(title: &str) -> String {
    let letters = title.chars().count();
    match letters > 17 {
        true => format!("…{}", title.chars().skip(letters - 16).collect::<String>()),
        false => title.to_owned(),
    }
}
