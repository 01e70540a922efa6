//! The report as text.

use super::{LoopReport, NotPipelined, Report};
use std::fmt::Write;

/// Pairs of accesses that are shown of a loop.
const MOST_ORDERED: usize = 4;

/// The whole report.
pub(crate) fn text(report: &Report) -> String {
    let mut out = String::new();
    summary(&mut out, report);
    for l in &report.loops {
        details(&mut out, l);
    }
    for n in &report.not_pipelined {
        out.push('\n');
        out.push_str(&not_pipelined(n));
    }
    out
}

/// One line a loop.
fn summary(out: &mut String, report: &Report) {
    let width = report
        .loops
        .iter()
        .map(|l| l.kernel.len())
        .max()
        .unwrap_or(0)
        .max(6);
    line(out, format_args!("machine {}", report.machine));
    if !report.complete {
        let text = "interrupted: these IIs were reached until then";
        line(out, format_args!("{text}"));
    }
    if report.loops.is_empty() {
        return line(out, format_args!("no loop is on the array"));
    }
    line(
        out,
        format_args!(
            "{:width$}  {:>4} {:>5} {:>4} {:>6} {:>6} {:>6} {:>10}",
            "kernel", "ops", "moves", "II", "ResMII", "RecMII", "stages", "cycles/ray"
        ),
    );
    for l in &report.loops {
        line(
            out,
            format_args!(
                "{:width$}  {:>4} {:>5} {:>4} {:>6} {:>6} {:>6} {:>10.2}",
                l.kernel,
                l.operations,
                l.moves,
                l.ii,
                l.res_mii,
                l.rec_mii,
                l.stages,
                l.cycles_per_ray
            ),
        );
    }
}

fn details(out: &mut String, l: &LoopReport) {
    line(
        out,
        format_args!("\n{}: {} at II = {}", l.at, l.kernel, l.ii),
    );
    line(
        out,
        format_args!("  ResMII {}: {}", l.res_mii, l.res_mii_why),
    );
    if l.recurrence.is_empty() {
        line(out, format_args!("  RecMII 1: no recurrence"));
    } else {
        line(out, format_args!("  RecMII {}: the recurrence", l.rec_mii));
        for step in &l.recurrence {
            line(
                out,
                format_args!("    {:8} {}  {}", step.op, cycles(step.latency), step.at),
            );
        }
    }
    if let Some(why) = &l.why_not_lower {
        line(out, format_args!("  not lower: {why}"));
    }
    for change in &l.what_if {
        line(
            out,
            format_args!("  with {}: II = {}", change.what, change.ii),
        );
    }
    for o in l.ordered.iter().take(MOST_ORDERED) {
        line(
            out,
            format_args!("  {} and {}: {}", o.first, o.second, o.why),
        );
    }
    if let more @ 1.. = l.ordered.len().saturating_sub(MOST_ORDERED) {
        line(
            out,
            format_args!("  and {more} more such pairs of accesses"),
        );
    }
    for i in &l.impossible {
        line(
            out,
            format_args!(
                "  proved: no schedule at II = {} up to {} cycles beyond the critical path",
                i.ii, i.slack
            ),
        );
    }
    line(
        out,
        format_args!(
            "  {}, {} an iteration, {}, {} set at entry",
            count(l.stages, "stage"),
            cycles(l.length),
            count(l.contexts, "context"),
            count(l.preloads as u32, "register")
        ),
    );
    let busy = |load: &super::UnitLoad| {
        let percent = 100 * load.busy() / l.ii;
        format!("{} {percent}%", load.unit)
    };
    let loads: Vec<String> = l.utilisation.iter().map(busy).collect();
    for row in loads.chunks(8) {
        line(out, format_args!("  {}", row.join("  ")));
    }
}

/// Why a loop is not on the array.
pub(crate) fn not_pipelined(n: &NotPipelined) -> String {
    format!(
        "{}: {} is not on the array: {}\n  {}\n",
        n.at, n.kernel, n.reason, n.reason_at
    )
}

fn cycles(n: u32) -> String {
    count(n, "cycle")
}

fn count(n: u32, what: &str) -> String {
    let plural = if n == 1 { "" } else { "s" };
    format!("{n} {what}{plural}")
}

fn line(out: &mut String, text: std::fmt::Arguments<'_>) {
    writeln!(out, "{text}").expect("writing to a string cannot fail");
}
