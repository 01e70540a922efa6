//! The report as text and as a page.

use super::{Line, Report};
use maud::{Markup, html};
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

/// The pixels that differ without the effect.
fn pixels(line: &Line) -> String {
    let pixels = line.cost.map(|cost| thousands(cost.pixels));
    pixels.unwrap_or_default()
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
    remarks.push(report.readiness.clone());
    let [own, all] = &report.simulators[..] else {
        return remarks;
    };
    let (width, height) = report.size;
    remarks.extend([
        format!(
            "Costs are those of a frame of {width}x{height} pixels with the effect, less the frame \
             without it and all that need it; pixels are those that differ."
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
        text.push_str("       cycles        host     pixels");
    }
    text.push_str("  why\n");
    for line in &report.effects {
        let _ = write!(text, "{:18} {:8}", line.effect, state(line));
        if measured {
            let (cycles, seconds) = (cycles(line), seconds(line));
            let _ = write!(text, "{cycles:>13} {seconds:>11} {:>10}", pixels(line));
        }
        let _ = writeln!(text, "  {}", line.why);
    }
    for remark in remarks(report) {
        let _ = write!(text, "\n{remark}\n");
    }
    text
}

const STYLE: &str = "td.why{white-space:normal;min-width:18rem}tr.off td{color:var(--soft)}";

/// The report as one page without network.
pub(super) fn page(report: &Report) -> String {
    let title = format!("Effects of {}", report.scene);
    let body = html! {
        main {
            h1 { (title) }
            p { (heading(report)) }
            div.summary.scroll { (table(report)) }
            @for remark in remarks(report) { p { (remark) } }
        }
    };
    crate::page::page(&title, STYLE, &body)
}

fn table(report: &Report) -> Markup {
    html! {
        table {
            tr {
                th { "Effect" } th { "State" } th { "Cycles" } th { "Host" }
                th { "Pixels" } th.words { "Why" }
            }
            @for line in &report.effects {
                tr class=(if line.built { "on" } else { "off" }) {
                    td { code { (line.effect) } br; small { (line.what) } }
                    td { (state(line)) }
                    td { (cycles(line)) }
                    td { (seconds(line)) }
                    td { (pixels(line)) }
                    td.words.why { (line.why) }
                }
            }
        }
    }
}
