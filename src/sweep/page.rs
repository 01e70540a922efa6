//! The report of a sweep as one self-contained page.

use super::Report;
use super::text::{figure, heading};
use super::{parallel, search};
use crate::count::count;
use crate::page;
use maud::{Markup, PreEscaped, html};
use srp_studies::sweep::rows::{figures, settings};
use srp_studies::sweep::{Analysis, Outcome, Row};

const STYLE: &str = include_str!("page.css");

/// Sorts a table by the column whose heading is clicked.
const SORT: &str = "
document.querySelectorAll('.rows').forEach(table => table.querySelectorAll('th').forEach((head, column) => {
  let down = false;
  head.onclick = () => {
    const body = table.tBodies[0], value = row => row.cells[column] ? row.cells[column].textContent : '';
    const rows = [...body.rows].sort((a, b) => {
      const x = parseFloat(value(a)), y = parseFloat(value(b));
      return isNaN(x) || isNaN(y) ? value(a).localeCompare(value(b)) : x - y;
    });
    if (down) rows.reverse();
    down = !down;
    rows.forEach(row => body.append(row));
  };
}));";

/// Most rows of a table on the page.
const MOST: usize = 2000;
/// Size of a plot and its margins.
const WIDTH: f64 = 320.0;
const HEIGHT: f64 = 220.0;
const LEFT: f64 = 56.0;
const BELOW: f64 = 26.0;
const ROUND: f64 = 10.0;

/// The page.
pub(super) fn page(report: &Report) -> String {
    let machine = report.plan.machine.as_deref().unwrap_or("sgrt");
    let title = format!("Sweep of {machine}");
    let body = html! {
        main {
            h1 { (title) }
            p.soft {
                (count(report.rows.len() as u64, "row"))
                @if report.rows.len() < report.planned { " of " (report.planned) ", so far" }
                ". Orange: no other point is as good in all figures and better in one."
            }
            @if let Some(progress) = &report.search { (search::section(progress)) }
            @for analysis in &report.analyses { (subject(report, analysis)) }
        }
        script { (PreEscaped(SORT)) }
    };
    page::page(&title, STYLE, &body)
}

fn subject(report: &Report, analysis: &Analysis) -> Markup {
    let rows: Vec<&Row> = report
        .rows
        .iter()
        .filter(|r| r.subject == analysis.subject)
        .collect();
    let names = settings(&report.rows);
    html! {
        section {
            h2 { (analysis.subject) }
            div.scroll { (parallel::svg(analysis, &names, &rows)) }
            div.plots { (plots(analysis, &rows)) }
            (sensitivities(analysis))
        }
        div.summary.scroll { (table(report, analysis, &names, &rows)) }
    }
}

/// Every pair of objectives that differ between rows against each other.
fn plots(analysis: &Analysis, rows: &[&Row]) -> Markup {
    let differs = |column: &&String| {
        let mut figures = rows.iter().filter_map(|row| row.figure(column));
        let first = figures.next();
        figures.any(|figure| Some(figure) != first)
    };
    let objectives: Vec<&String> = analysis.objectives.iter().filter(differs).collect();
    let pairs = (0..objectives.len()).flat_map(|a| (a + 1..objectives.len()).map(move |b| (a, b)));
    html! {
        @for (a, b) in pairs { (plot(analysis, objectives[b], objectives[a], rows)) }
    }
}

fn plot(analysis: &Analysis, across: &str, up: &str, rows: &[&Row]) -> Markup {
    let span = |column: &str| {
        let figures = rows.iter().filter_map(|r| r.figure(column));
        let (least, most) = figures.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), f| {
            (l.min(f), m.max(f))
        });
        let margin = ((most - least) * 0.06).max(most.abs() * 1e-3).max(1e-9);
        (least - margin, most + margin)
    };
    let (x, y) = (span(across), span(up));
    let place = |row: &Row| {
        let part = |value: f64, (from, to): (f64, f64)| (value - from) / (to - from);
        Some((
            LEFT + part(row.figure(across)?, x) * (WIDTH - LEFT - ROUND),
            HEIGHT - BELOW - part(row.figure(up)?, y) * (HEIGHT - BELOW - ROUND),
        ))
    };
    let (floor, ceiling) = (HEIGHT - BELOW, ROUND);
    html! {
        figure {
            figcaption { (heading(up)) " against " (heading(across)) }
            svg.plot viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } role="img" {
                line.axis x1=(LEFT) y1=(floor) x2=(WIDTH - ROUND) y2=(floor) {}
                line.axis x1=(LEFT) y1=(floor) x2=(LEFT) y2=(ceiling) {}
                text x=(LEFT) y=(floor + 15.0) { (figure(across, x.0)) }
                text x=(WIDTH - ROUND) y=(floor + 15.0) text-anchor="end" { (figure(across, x.1)) }
                text x=(LEFT - 5.0) y=(floor) text-anchor="end" { (figure(up, y.0)) }
                text x=(LEFT - 5.0) y=(ceiling + 8.0) text-anchor="end" { (figure(up, y.1)) }
                @for row in last_best(analysis, rows) {
                    @if let Some((x, y)) = place(row) {
                        circle.best[analysis.front.contains(&row.point)] cx=(format!("{x:.1}")) cy=(format!("{y:.1}")) r="4" {
                            title { "point " (row.point) ": " (in_words(row)) }
                        }
                    }
                }
            }
        }
    }
}

/// Rows with those of the front last, so that no other covers them.
fn last_best<'a>(analysis: &Analysis, rows: &[&'a Row]) -> Vec<&'a Row> {
    let mut ordered = rows.to_vec();
    ordered.sort_by_key(|row| analysis.front.contains(&row.point));
    ordered
}

/// The settings of a row.
fn in_words(row: &Row) -> String {
    let all = row
        .settings
        .iter()
        .map(|(name, value)| format!("{name}={value}"));
    all.collect::<Vec<_>>().join(", ")
}

/// Which parameter moves what, as bars.
fn sensitivities(analysis: &Analysis) -> Markup {
    html! {
        @for objective in &analysis.objectives {
            @let of: Vec<_> = analysis.sensitivities.iter().filter(|s| s.objective == *objective).collect();
            @if !of.is_empty() && of.iter().all(|s| s.spread == 0.0) {
                p.soft { "Nothing moves " (heading(objective)) ": it is the same at all points." }
            } @else if !of.is_empty() {
                h3 { "What moves " (heading(objective)) }
                div.scroll { table.bars {
                    tr { th { "parameter" } th { "part of the variance" } th {} th { "mean at each value" } }
                    @for s in of {
                        tr {
                            td { code { (s.parameter) } }
                            td { span.bar { i style={ "width:" (format!("{:.1}", 100.0 * s.explained)) "%" } {} } }
                            td.number { (format!("{:.0} %", 100.0 * s.explained)) }
                            td.soft { (means(objective, &s.means)) }
                        }
                    }
                } }
            }
        }
    }
}

/// The means of a parameter's values; of many, the first and the last.
fn means(objective: &str, means: &[(String, f64)]) -> String {
    let word = |(value, mean): &(String, f64)| format!("{value}: {}", figure(objective, *mean));
    match means.len() {
        0..=8 => means.iter().map(word).collect::<Vec<_>>().join(", "),
        n => format!("{}, … {}", word(&means[0]), word(&means[n - 1])),
    }
}

fn table(report: &Report, analysis: &Analysis, names: &[String], rows: &[&Row]) -> Markup {
    let columns = figures(&report.rows);
    html! {
        table.rows {
            thead { tr {
                th { "point" }
                @for name in names { th { (name) } }
                @for column in &columns { th { (heading(column)) } }
            } }
            tbody { @for row in rows.iter().take(MOST) {
                tr.best[analysis.front.contains(&row.point)] {
                    td { (row.point) }
                    @for name in names { td { (row.settings.get(name).map_or("", String::as_str)) } }
                    @match &row.outcome {
                        Outcome::Figures(_) => @for column in &columns {
                            td { @if let Some(f) = row.figure(column) { (figure(column, f)) } }
                        },
                        Outcome::Invalid(why) | Outcome::Failed(why) => td.why colspan=(columns.len()) { (why) },
                    }
                }
            } }
        }
        @if rows.len() > MOST { p.soft { "The other " (rows.len() - MOST) " rows are in results.csv." } }
    }
}
