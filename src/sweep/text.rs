//! The report of a sweep as text.

use super::Report;
use crate::count::count;
use srp_studies::sweep::rows::{figures, settings};
use srp_studies::sweep::{Analysis, Generation, Outcome, Progress};
use std::fmt::Write as _;

/// Most rows that the text shows of each subject.
const MOST: usize = 200;
/// Parts of the variance below which a parameter is not worth a line.
const LEAST: f64 = 0.005;

/// Most generations of a search that are shown.
const MOST_GENERATIONS: usize = 12;

/// The report: the table of each subject with the front marked, what moves what, and how a search went.
pub(super) fn text(report: &Report) -> String {
    let mut out = String::new();
    write_all(&mut out, report).expect("writing to a String does not fail");
    out
}

fn write_all(out: &mut String, report: &Report) -> std::fmt::Result {
    if report.rows.len() < report.planned {
        writeln!(
            out,
            "{} of {} known so far",
            report.rows.len(),
            count(report.planned as u64, "row")
        )?;
    }
    for analysis in &report.analyses {
        writeln!(out, "\n{}", analysis.subject)?;
        table(out, report, analysis)?;
        sensitivities(out, analysis)?;
    }
    match &report.search {
        Some(progress) => generations(out, progress),
        None => Ok(()),
    }
}

/// How far a search came with its generations.
fn generations(out: &mut String, progress: &Progress) -> std::fmt::Result {
    let several = progress.objectives.len() > 1;
    writeln!(out, "\n{}", progress.in_words())?;
    let mut head = vec![
        "points".to_owned(),
        "with figures".to_owned(),
        "front".to_owned(),
    ];
    head.extend(several.then(|| "hypervolume".to_owned()));
    head.extend(
        progress
            .objectives
            .iter()
            .map(|c| format!("best {}", heading(c))),
    );
    let mut lines = vec![head];
    for generation in shown(&progress.generations) {
        let mut line = vec![generation.points, generation.valid, generation.front]
            .into_iter()
            .map(|n| n.to_string())
            .collect::<Vec<_>>();
        let volume = generation
            .hypervolume
            .map_or_else(String::new, |v| format!("{v:.4}"));
        line.extend(several.then_some(volume));
        let best = progress.objectives.iter().zip(&generation.best);
        line.extend(best.map(|(column, best)| figure(column, *best)));
        lines.push(line);
    }
    write_columns(out, &lines, 0)?;
    if several {
        writeln!(
            out,
            "hypervolume: the part of the box between best and worst figures that the front so far dominates"
        )?;
    }
    Ok(())
}

/// Of many generations some at equal distances, the last among them.
pub(super) fn shown(generations: &[Generation]) -> impl Iterator<Item = &Generation> {
    let every = generations.len().div_ceil(MOST_GENERATIONS).max(1);
    let last = generations.len();
    let numbered = (1..).zip(generations);
    numbered
        .filter(move |(n, _)| (last - n).is_multiple_of(every))
        .map(|(_, generation)| generation)
}

fn table(out: &mut String, report: &Report, analysis: &Analysis) -> std::fmt::Result {
    let names = settings(&report.rows);
    let columns: Vec<String> = figures(&report.rows)
        .into_iter()
        .filter(|c| !c.contains('.'))
        .collect();
    let mut lines: Vec<Vec<String>> = vec![
        ["", "point"]
            .map(str::to_owned)
            .into_iter()
            .chain(names.iter().cloned())
            .chain(columns.iter().map(|c| heading(c)))
            .collect(),
    ];
    let mut failed = Vec::new();
    let rows = report
        .rows
        .iter()
        .filter(|row| row.subject == analysis.subject);
    let total = rows.clone().count();
    for row in rows.take(MOST) {
        let best = if analysis.front.contains(&row.point) {
            "*"
        } else {
            ""
        };
        let mut line = vec![best.to_owned(), row.point.to_string()];
        let setting = |name: &String| row.settings.get(name).cloned().unwrap_or_default();
        line.extend(names.iter().map(setting));
        match &row.outcome {
            Outcome::Figures(_) => line.extend(columns.iter().map(|column| {
                row.figure(column)
                    .map_or_else(String::new, |f| figure(column, f))
            })),
            Outcome::Invalid(why) => failed.push((row.point, "no machine", why)),
            Outcome::Failed(why) => failed.push((row.point, "failed", why)),
        }
        lines.push(line);
    }
    write_columns(out, &lines, 2 + names.len())?;
    if total > MOST {
        writeln!(out, "… and {} more, in results.csv", total - MOST)?;
    }
    for (point, how, why) in failed {
        writeln!(
            out,
            "point {point}, {how}: {}",
            why.lines().next().unwrap_or_default()
        )?;
    }
    match &analysis.objectives[..] {
        _ if analysis.front.is_empty() => Ok(()),
        [one] => writeln!(out, "* no other is better in {one}"),
        all => writeln!(
            out,
            "* no other is as good in {} and better in one",
            listed(all)
        ),
    }
}

/// Names as a list in words.
fn listed(names: &[String]) -> String {
    match names {
        [one] => one.clone(),
        [some @ .., last] => format!("{} and {last}", some.join(", ")),
        [] => String::new(),
    }
}

fn sensitivities(out: &mut String, analysis: &Analysis) -> std::fmt::Result {
    for objective in &analysis.objectives {
        let of = analysis
            .sensitivities
            .iter()
            .filter(|s| s.objective == *objective);
        let moving: Vec<_> = of.filter(|s| s.explained >= LEAST).collect();
        if moving.is_empty() {
            continue;
        }
        writeln!(out, "\nwhat moves {}:", heading(objective))?;
        for s in moving {
            let (first, last) = (&s.means[0], &s.means[s.means.len() - 1]);
            writeln!(
                out,
                "  {:28} {:>3.0} % of the variance; {} at {}, {} at {}",
                s.parameter,
                100.0 * s.explained,
                figure(objective, first.1),
                first.0,
                figure(objective, last.1),
                last.0
            )?;
        }
    }
    Ok(())
}

/// A column with its unit.
pub(super) fn heading(column: &str) -> String {
    match column {
        "energy" => "mJ".to_owned(),
        "area" => "mm²".to_owned(),
        "psnr" => "dB".to_owned(),
        other => other.to_owned(),
    }
}

/// A figure, with as many digits as it deserves.
pub(super) fn figure(column: &str, value: f64) -> String {
    match column.split('.').next().unwrap_or(column) {
        "cycles" => format!("{value:.0}"),
        "ii" if value.fract() == 0.0 => format!("{value:.0}"),
        "ms" | "energy" => format!("{value:.3}"),
        _ => format!("{value:.2}"),
    }
}

/// Writes lines in columns: so many to the left, the others to the right.
fn write_columns(out: &mut String, lines: &[Vec<String>], left: usize) -> std::fmt::Result {
    let columns = lines.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        let cells = lines.iter().filter_map(|line| line.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    for line in lines {
        let mut text = String::new();
        for (column, cell) in line.iter().enumerate() {
            let width = widths[column];
            match column < left {
                true => write!(text, "{cell:<width$}  ")?,
                false => write!(text, "{cell:>width$}  ")?,
            }
        }
        writeln!(out, "{}", text.trim_end())?;
    }
    Ok(())
}
