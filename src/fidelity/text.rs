//! Figures and tables as text.

use srp_studies::fidelity::sampled::Sampled;
use srp_studies::fidelity::{Fidelity, Row, Table, TrialFigure, Trials};
use srp_studies::fidelity::{FrameFigure, FrameQuantity as Q};
use srp_studies::figure::{Quantity, Unit};
use std::fmt::Write as _;

/// The figures that are shown of every level.
const SHOWN: [Q; 8] = [
    Q::Cycles,
    Q::Rate,
    Q::TrvL1Hits,
    Q::TrvL2Hits,
    Q::IstL1Hits,
    Q::DataCacheHits,
    Q::BytesRead,
    Q::Bandwidth,
];

/// Figures of a frame at a level without an account of every cycle.
pub(crate) fn frame_text(level: Fidelity, size: (u32, u32), figures: &[FrameFigure]) -> String {
    let mut out = format!("{}x{} pixels, {}\n", size.0, size.1, level.name());
    let counts_only = level == Fidelity::Functional;
    let shown = figures
        .iter()
        .filter(|f| !counts_only || f.quantity.is_count());
    for figure in shown {
        let (name, unit) = (&figure.quantity, figure.quantity.unit());
        let _ = writeln!(
            out,
            "{name:28} {:>16} {unit}",
            number(figure.estimate.value)
        );
    }
    out
}

/// A sampled frame.
pub(crate) fn sampled_text(sampled: &Sampled, size: (u32, u32)) -> String {
    let (width, height) = size;
    let Sampled {
        tiles,
        measured,
        strata,
        seed,
        ..
    } = sampled;
    let part = 100.0 * *measured as f64 / (*tiles).max(1) as f64;
    let mut out = match strata {
        0 => format!(
            "{width}x{height} pixels, all {tiles} tiles: a sample that meets the error would take as long\n"
        ),
        _ => format!(
            "{width}x{height} pixels, sampled: {measured} of {tiles} tiles ({part:.1} %) of {strata} strata, \
             seed {seed}; intervals of 95 %\n"
        ),
    };
    for figure in &sampled.figures {
        let estimate = figure.estimate;
        let _ = writeln!(
            out,
            "{:28} {:>16} ± {:<12} {}",
            figure.quantity,
            number(estimate.value),
            number(estimate.half_width),
            figure.quantity.unit()
        );
    }
    out
}

/// A number with as many digits as it is good for.
fn number(value: f64) -> String {
    match value.abs() {
        a if !a.is_finite() => "unknown".to_owned(),
        a if a >= 1e4 => srp_runtime::digits::thousands(value.round() as u64),
        a if a >= 100.0 => format!("{value:.1}"),
        a if a >= 1.0 || a == 0.0 => format!("{value:.2}"),
        _ => format!("{value:.4}"),
    }
}

fn percent(part: f64) -> String {
    format!("{:.2}", 100.0 * part)
}

/// The rows of the table of levels, header first.
fn rows(table: &Table) -> Vec<Vec<String>> {
    let mut head: Vec<String> = ["level", "host s", "processor s", "speed-up", "measured %"]
        .map(String::from)
        .into();
    head.extend(SHOWN.map(|shown| format!("{shown} %")));
    let row = |row: &Row| {
        let mut cells = vec![
            row.level.to_owned(),
            format!("{:.2}", row.took.seconds),
            row.took
                .processor
                .map_or_else(|| "–".to_owned(), |s| format!("{s:.2}")),
            format!("{:.1}", row.speed_up),
            percent(row.measured),
        ];
        for shown in SHOWN {
            let cell = row.figures.iter().find(|c| c.quantity == shown);
            cells.push(match cell {
                None => "–".to_owned(),
                Some(c) if c.half_width.is_some() => {
                    let width = match (c.quantity.unit(), c.value) {
                        (Unit::Percent, _) => c.half_width.unwrap_or(0.0) / 100.0,
                        (_, 0.0) => 0.0,
                        (_, value) => c.half_width.unwrap_or(0.0) / value,
                    };
                    format!("{:+.2} ± {:.2}", 100.0 * c.error, 100.0 * width)
                }
                Some(c) => format!("{:+.2}", 100.0 * c.error),
            });
        }
        cells
    };
    std::iter::once(head)
        .chain(table.levels.iter().map(row))
        .collect()
}

/// Returns the facts that hold for all of a table.
fn about(table: &Table) -> String {
    format!(
        "{}, {} triangles, {}x{} pixels, machine `{}`",
        table.scene, table.triangles, table.size.0, table.size.1, table.machine
    )
}

fn about_trials(trials: &Trials) -> String {
    format!(
        "{} trials with a target of {} %: {} % of the tiles measured on average, {:.2} host s, speed-up {:.1}",
        trials.trials,
        percent(trials.target),
        percent(trials.measured),
        trials.took.seconds,
        trials.speed_up
    )
}

const TRIAL_HEAD: [&str; 5] = [
    "figure",
    "covered %",
    "mean error %",
    "largest %",
    "interval ± %",
];

fn trial_rows(trials: &Trials) -> Vec<Vec<String>> {
    let row = |f: &TrialFigure| {
        vec![
            f.quantity.to_string(),
            format!("{:.1}", 100.0 * f.covered),
            percent(f.mean_error),
            percent(f.largest_error),
            percent(f.mean_half_width),
        ]
    };
    let head = TRIAL_HEAD.map(String::from).to_vec();
    std::iter::once(head)
        .chain(trials.figures.iter().map(row))
        .collect()
}

/// For people: what each level is off by in %, of hit rates in points.
pub(super) fn table(table: &Table) -> String {
    let mut out = about(table) + "\n\n" + &aligned(&rows(table));
    if let Some(trials) = &table.trials {
        out += &format!(
            "\n{}\n\n{}",
            about_trials(trials),
            aligned(&trial_rows(trials))
        );
    }
    out
}

/// For documents.
pub(super) fn markdown(table: &Table) -> String {
    let mut out = format!("### {}\n\n{}", about(table), piped(&rows(table)));
    if let Some(trials) = &table.trials {
        out += &format!(
            "\n{}:\n\n{}",
            about_trials(trials),
            piped(&trial_rows(trials))
        );
    }
    out
}

fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.first().map_or(0, Vec::len);
    let width = |c: usize| rows.iter().map(|r| r[c].chars().count()).max().unwrap_or(0);
    let mut out = String::new();
    for row in rows {
        for (c, cell) in row.iter().enumerate().take(columns) {
            let width = width(c);
            let _ = match c {
                0 => write!(out, "{cell:width$}"),
                _ => write!(out, "  {cell:>width$}"),
            };
        }
        out.push('\n');
    }
    out
}

fn piped(rows: &[Vec<String>]) -> String {
    let mut out = String::new();
    for (i, row) in rows.iter().enumerate() {
        let _ = writeln!(out, "| {} |", row.join(" | "));
        if i == 0 {
            let _ = writeln!(out, "|{}", "---|".repeat(row.len()));
        }
    }
    out
}
