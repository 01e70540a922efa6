//! The progress of a search on the page: a curve and a table by generation.

use super::text::{figure, heading, shown};
use maud::{Markup, html};
use srp_studies::sweep::{Generation, Progress};

/// Size of the curve and its margins.
const WIDTH: f64 = 420.0;
const HEIGHT: f64 = 200.0;
const LEFT: f64 = 56.0;
const BELOW: f64 = 26.0;
const ROUND: f64 = 12.0;

/// The section about a search.
pub(super) fn section(progress: &Progress) -> Markup {
    html! {
        section {
            h2 { "Search" }
            p.soft { (progress.in_words()) }
            div.plots {
                (curve(progress))
                div.scroll { (table(progress)) }
            }
        }
    }
}

/// A figure that tells how good a generation is: the hypervolume, or the best of a single objective.
fn goodness(progress: &Progress, generation: &Generation) -> Option<f64> {
    match progress.objectives[..] {
        [_] => generation.best.first().copied(),
        _ => generation.hypervolume,
    }
}

fn curve(progress: &Progress) -> Markup {
    let known = progress.generations.iter();
    let known: Vec<(f64, f64)> = known
        .filter_map(|g| Some((g.points as f64, goodness(progress, g)?)))
        .collect();
    let (title, column) = match &progress.objectives[..] {
        [one] => (heading(one), one.as_str()),
        _ => ("hypervolume".to_owned(), ""),
    };
    let (least, most) = known
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), (_, f)| {
            (l.min(*f), m.max(*f))
        });
    let last = known.last().map_or(1.0, |(points, _)| *points);
    let x = |points: f64| LEFT + points / last * (WIDTH - LEFT - ROUND);
    let y = |f: f64| {
        let part = if most > least {
            (f - least) / (most - least)
        } else {
            0.5
        };
        HEIGHT - BELOW - part * (HEIGHT - BELOW - ROUND)
    };
    let places = known
        .iter()
        .map(|(points, f)| format!("{:.1},{:.1}", x(*points), y(*f)));
    let places: Vec<String> = places.collect();
    html! {
        @if !known.is_empty() {
            figure {
                figcaption { (title) " against points" }
                svg.plot viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } role="img" {
                    line.axis x1=(LEFT) y1=(HEIGHT - BELOW) x2=(WIDTH - ROUND) y2=(HEIGHT - BELOW) {}
                    line.axis x1=(LEFT) y1=(HEIGHT - BELOW) x2=(LEFT) y2=(ROUND) {}
                    text x=(LEFT) y=(HEIGHT - BELOW + 15.0) { "0" }
                    text x=(WIDTH - ROUND) y=(HEIGHT - BELOW + 15.0) text-anchor="end" { (last) }
                    text x=(LEFT - 5.0) y=(y(least) + 3.0) text-anchor="end" { (figure(column, least)) }
                    @if most > least {
                        text x=(LEFT - 5.0) y=(y(most) + 3.0) text-anchor="end" { (figure(column, most)) }
                    }
                    polyline.curve points=(places.join(" ")) {}
                }
            }
        }
    }
}

fn table(progress: &Progress) -> Markup {
    html! {
        table.bars {
            tr {
                th { "points" } th { "with figures" } th { "front" }
                @if progress.objectives.len() > 1 { th { "hypervolume" } }
                @for column in &progress.objectives { th { "best " (heading(column)) } }
            }
            @for generation in shown(&progress.generations) {
                tr {
                    td.number { (generation.points) }
                    td.number { (generation.valid) }
                    td.number { (generation.front) }
                    @if progress.objectives.len() > 1 {
                        td.number { @if let Some(v) = generation.hypervolume { (format!("{v:.4}")) } }
                    }
                    @for (column, best) in progress.objectives.iter().zip(&generation.best) {
                        td.number { (figure(column, *best)) }
                    }
                }
            }
        }
    }
}
