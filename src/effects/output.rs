//! The report as text and as a page.

use super::{Line, Report};
use maud::{DOCTYPE, Markup, html};
use srp_runtime::digits::thousands;
use std::fmt::Write as _;

/// `on`, `off`, or what the command line makes of it.
fn state(line: &Line) -> &'static str {
    match (line.on, line.built) {
        (true, true) => "on",
        (false, false) => "off",
        (true, false) => "left out",
        (false, true) => "put in",
    }
}

fn cycles(line: &Line) -> String {
    let Some(cost) = line.cost else {
        return String::new();
    };
    let sign = if cost.cycles < 0 { "-" } else { "+" };
    format!("{sign}{}", thousands(cost.cycles.unsigned_abs()))
}

fn seconds(line: &Line) -> String {
    let cost = line.cost.map(|c| format!("{:+.3} s", c.host_seconds));
    cost.unwrap_or_default()
}

/// What the picture says of it.
fn picture(line: &Line) -> &'static str {
    match line.cost {
        Some(cost) if cost.same_picture => "same",
        Some(_) => "other",
        None => "",
    }
}

fn heading(report: &Report) -> String {
    format!(
        "{}: {} triangles, {} of {} effects, simulator {}",
        report.scene,
        thousands(report.triangles as u64),
        report.built.len(),
        report.effects.len(),
        report.key
    )
}

/// The sentences behind the table.
fn remarks(report: &Report) -> Vec<String> {
    let mut remarks = report.lacks.clone();
    let [own, all] = &report.simulators[..] else {
        return remarks;
    };
    let (width, height) = report.size;
    remarks.extend([
        format!(
            "Costs are those of a frame of {width}x{height} pixels with the effect, less the frame \
             without it and all that need it."
        ),
        format!(
            "This simulator takes {} cycles and {:.3} s, the universal one {} and {:.3} s: {:.2} \
             times the cycles and {:.2} times the seconds, for {} picture.",
            thousands(own.cycles),
            own.host_seconds,
            thousands(all.cycles),
            all.host_seconds,
            all.cycles as f64 / own.cycles as f64,
            all.host_seconds / own.host_seconds,
            if all.same_picture {
                "the same"
            } else {
                "another"
            }
        ),
    ]);
    remarks
}

/// The report as text.
pub(super) fn text(report: &Report) -> String {
    let mut text = heading(report);
    let measured = report.effects.iter().any(|l| l.cost.is_some());
    text.push_str("\n\neffect             state   ");
    if measured {
        text.push_str("       cycles        host  picture");
    }
    text.push_str("  why\n");
    for line in &report.effects {
        let _ = write!(text, "{:18} {:8}", line.effect, state(line));
        if measured {
            let (cycles, seconds) = (cycles(line), seconds(line));
            let _ = write!(text, "{cycles:>13} {seconds:>11}  {:7}", picture(line));
        }
        let _ = writeln!(text, "  {}", line.why);
    }
    for remark in remarks(report) {
        let _ = write!(text, "\n{remark}\n");
    }
    text
}

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;max-width:70rem;margin:2rem auto;\
padding:0 1rem;color:#222;background:#fff}table{border-collapse:collapse;width:100%}\
th,td{text-align:left;padding:.3rem .7rem;border-bottom:1px solid #ddd;vertical-align:top}\
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}\
tr.off td{color:#888}small{color:#777}\
@media(prefers-color-scheme:dark){body{color:#ddd;background:#181818}\
th,td{border-color:#333}tr.off td{color:#777}}";

/// The report as one page without network.
pub(super) fn page(report: &Report) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "Effects of " (report.scene) }
                style { (STYLE) }
            }
            body {
                h1 { "Effects of " (report.scene) }
                p { (heading(report)) }
                (table(report))
                @for remark in remarks(report) { p { (remark) } }
            }
        }
    }
    .into_string()
}

fn table(report: &Report) -> Markup {
    html! {
        table {
            tr {
                th { "Effect" } th { "State" } th.n { "Cycles" } th.n { "Host" }
                th { "Picture" } th { "Why" }
            }
            @for line in &report.effects {
                tr class=(if line.built { "on" } else { "off" }) {
                    td { code { (line.effect) } br; small { (line.what) } }
                    td { (state(line)) }
                    td.n { (cycles(line)) }
                    td.n { (seconds(line)) }
                    td { (picture(line)) }
                    td { (line.why) }
                }
            }
        }
    }
}
