//! The reports as text.

use super::{marks, shown};
use srp_studies::kernel::{Costs, Measure, Origins, Report, Trial};
use std::fmt::Write as _;

/// A number in few characters.
pub(super) fn short(x: f64) -> String {
    match x.abs() {
        0.0 => "0".to_owned(),
        1e-3..1e5 => {
            let digits = (3 - x.abs().log10().floor() as i32).clamp(0, 6) as usize;
            format!("{x:.digits$}")
        }
        _ => format!("{x:.2e}"),
    }
}

/// The largest error in units in the last place.
pub(super) fn ulps(error: &Measure) -> String {
    error.ulps.map_or_else(|| "none".to_owned(), short)
}

/// The bound of the relative error, or of the absolute one where there is none.
pub(super) fn bound(trial: &Trial) -> String {
    match trial.bound {
        Some(bound) => match bound.relative {
            Some(relative) => short(relative),
            None => format!("{} abs", short(bound.absolute)),
        },
        None => "-".to_owned(),
    }
}

/// IIs of the loops.
pub(super) fn intervals(costs: &Costs) -> String {
    match costs.ii.as_slice() {
        [] => "-".to_owned(),
        loops => {
            let loops: Vec<String> = loops.iter().map(|(_, ii)| ii.to_string()).collect();
            loops.join(",")
        }
    }
}

/// Says which settings a trial has, or that it has none.
pub(super) fn words(trial: &Trial) -> &str {
    match trial.words.is_empty() {
        true => "as it is",
        false => &trial.words,
    }
}

/// Says whether better settings may exist.
pub(super) fn search_in_words(report: &Report) -> String {
    let count = report.trials.len();
    match (report.complete, report.exhaustive, report.closed) {
        (false, ..) => {
            format!("Interrupted after {count} settings: say it again, and it goes on from here.")
        }
        (_, true, _) => format!("All {count} combinations were tried."),
        (_, _, true) => format!(
            "{count} settings were tried. Every setting that differs from one of the fronts in one knob was tried or is \
             predicted to be worse: no setting found is better."
        ),
        _ => format!(
            "{count} settings were tried, which is all that --trials allows; better ones may exist."
        ),
    }
}

/// All reports.
pub(super) fn text(reports: &[Report]) -> String {
    let all: Vec<String> = reports.iter().map(report).collect();
    all.join("\n")
}

/// The ranges in one line.
pub(super) fn ranges(report: &Report) -> String {
    let ranges = report.ranges.iter().map(|r| {
        let elements = if r.length > 1 {
            format!("[{}]", r.length)
        } else {
            String::new()
        };
        format!("{}{elements} = {}:{}", r.name, r.low, r.high)
    });
    ranges.collect::<Vec<_>>().join(", ")
}

fn report(report: &Report) -> String {
    let mut text = format!(
        "{} ({}), machine `{}`: {}\n{} points; target {}\n",
        report.name,
        report.file,
        report.machine,
        ranges(report),
        report.points,
        report.target
    );
    for note in &report.notes {
        let _ = writeln!(text, "{note}");
    }
    let shown = shown(report);
    let width = shown
        .iter()
        .map(|&i| words(&report.trials[i]).chars().count())
        .max();
    let width = width.unwrap_or(0).clamp(8, 60);
    let _ = writeln!(
        text,
        "\n{:width$}  {:>6} {:>9} {:>9} {:>12} {:>5} {:>8} {:>8} {:>8}",
        "setting", "bits", "ulps", "relative", "bound", "II", "cycles", "mm2", "pJ"
    );
    for &i in &shown {
        let t = &report.trials[i];
        let _ = writeln!(
            text,
            "{:width$}  {:>6.2} {:>9} {:>9} {:>12} {:>5} {:>8.1} {:>8.4} {:>8.1} {}",
            words(t),
            t.error.bits,
            ulps(&t.error),
            short(t.error.relative),
            bound(t),
            intervals(&t.costs),
            t.costs.cycles,
            t.costs.area,
            t.costs.energy,
            marks(report, i)
        );
    }
    let _ = writeln!(
        text,
        "\nbits: lost on average; ulps, relative: the largest error found; bound: of the relative error over all of the\n\
         ranges; cycles, pJ: of an evaluation. On the front of error and c cycles, a area, e energy; < cheapest that\n\
         keeps to the target.\n\n{}",
        search_in_words(report)
    );
    if let Some(base) = report.trials.first() {
        details(&mut text, base);
        rewrites(&mut text, report, base);
    }
    origins(&mut text, "as it is", &report.origins);
    if let Some(i) = report.cheapest {
        let trial = &report.trials[i];
        match trial.how.is_empty() {
            true => text += "\nNothing cheaper than the machine as it is keeps to the target.\n",
            false => {
                let _ = writeln!(text, "\nCheapest that keeps to the target: {}", trial.how);
            }
        }
        if let Some(found) = &report.cheapest_origins {
            origins(&mut text, "with the cheapest", found);
        }
    } else {
        text += "\nNo setting that was tried keeps to the target.\n";
    }
    unexercised(&mut text, report);
    text
}

/// Remarks on the machine as it is beyond its line.
fn details(text: &mut String, base: &Trial) {
    if let (Some(_), [_, ..]) = (base.error.ulps, base.error.worst.as_slice()) {
        let at = base
            .error
            .worst
            .iter()
            .map(|(name, x)| format!("{name} = {x:?}"));
        let (computed, real) = base.error.worst_result;
        let _ = writeln!(
            text,
            "Largest error as it is: {computed:?} for {real:?} at {}",
            at.collect::<Vec<_>>().join(", ")
        );
    }
    if base.error.not_finite > 0 {
        let _ = writeln!(
            text,
            "{} of {} results are no numbers and should be.",
            base.error.not_finite, base.error.compared
        );
    }
    if let Some(why) = &base.unbounded {
        let _ = writeln!(text, "No bound: {why}.");
    }
    for why in &base.costs.not_pipelined {
        let _ = writeln!(text, "On the VLIW engine: {why}");
    }
}

/// Rewrites of single expressions, each with its numbers beside those of the text as it stands.
fn rewrites(text: &mut String, report: &Report, base: &Trial) {
    if report.rewrites.is_empty() {
        return;
    }
    let names = report.rewrites.iter().map(|r| r.name.chars().count());
    let width = names.max().unwrap_or(0).max("as it is".len());
    let _ = writeln!(
        text,
        "\nRewrites, each alone (--rewrite NAME of compile, run and report makes it)\n{:width$}  {:>6} {:>9} {:>5} {:>8} {:>8}",
        "", "bits", "ulps", "II", "cycles", "pJ"
    );
    let mut line = |name: &str, error: &Measure, costs: &Costs, said: String| {
        let _ = writeln!(
            text,
            "{name:width$}  {:>6.2} {:>9} {:>5} {:>8.1} {:>8.1}  {said}",
            error.bits,
            ulps(error),
            intervals(costs),
            costs.cycles,
            costs.energy,
        );
    };
    line("as it is", &base.error, &base.costs, String::new());
    for found in &report.rewrites {
        let said = match &found.failed {
            Some(why) => format!("cannot be tried: {why}"),
            None => format!("{}: {}", found.gain.words(), found.what),
        };
        line(&found.name, &found.error, &found.costs, said);
    }
}

fn origins(text: &mut String, when: &str, found: &Origins) {
    if found.origins.is_empty() {
        return;
    }
    let _ = writeln!(
        text,
        "\nWhere the error comes from, {when} (parts of the squared error)"
    );
    for origin in found.origins.iter().take(10) {
        let _ = writeln!(
            text,
            "{:>6.1}%  {} {}",
            100.0 * origin.share,
            origin.at,
            origin.operation
        );
    }
    if found.flips > 0 {
        let _ = writeln!(
            text,
            "Decisions that binary64 makes otherwise: {}.",
            found.flips
        );
    }
}

fn unexercised(text: &mut String, report: &Report) {
    let failed = report.trials.iter().filter(|t| t.failed.is_some());
    for trial in failed {
        let why = trial.failed.as_deref().unwrap_or_default();
        let _ = writeln!(text, "\n{} cannot be tried: {why}", words(trial));
    }
    let count = report
        .trials
        .iter()
        .filter(|t| !t.not_exercised.is_empty())
        .count();
    if count > 0 {
        let _ = writeln!(
            text,
            "\n{count} settings are of units that the program does not use then (not exercised); they count nowhere."
        );
    }
}
