//! The report as one self-contained page without network. Its one script only pages through the
//! cycles of the array, all of which are there without it.

mod array;
mod recurrence;
mod slots;
mod takes;

use super::text::{lowered, recurrence as recurrence_in_words, standing};
use crate::count::count;
use crate::page as shell;
use crate::proof;
use maud::{Markup, PreEscaped, html};
use srp_studies::loops::{
    FunctionReport, LoopReport, NotPipelined, Position, Report, Resource, Status, part, percent,
};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The page.
pub(super) fn page(report: &Report) -> String {
    let title = format!("Initiation intervals on {}", report.machine.name);
    let body = html! {
        @if let Some(first) = report.loops.first() { (array::shared(first)) }
        main {
            h1 { "Initiation intervals on " code { (report.machine.name) }
                small.soft { " " (report.array.rows) "×" (report.array.columns) " units" } }
            @if !report.complete {
                p.above { "Interrupted: these IIs were reached until then." }
            }
            (summary(report))
            @for (i, l) in report.loops.iter().enumerate() {
                (details(i, l, report.array.contexts))
            }
            @if !report.not_pipelined.is_empty() { (refused(&report.not_pipelined)) }
            @if !report.functions.is_empty() { (functions(&report.functions)) }
        }
        script { (PreEscaped(SCRIPT)) }
    };
    shell::page(&title, STYLE, &body)
}

fn summary(report: &Report) -> Markup {
    html! {
        div.summary.scroll {
            @if report.loops.is_empty() {
                p { "No loop is on the array." }
            } @else {
                (table(report))
            }
            @for n in report.not_pipelined.iter().filter(|n| n.required) {
                p.above { a href="#refused" { (n.kernel) } " is not on the array: " (n.reason) }
            }
            @if !report.advice.is_empty() {
                h3 { "Changes that were tried and help" }
                ul.advice { @for a in &report.advice {
                    li { b { (a.in_words()) } ": " (lowered(a)) }
                } }
            }
        }
    }
}

/// One row a loop.
fn table(report: &Report) -> Markup {
    html! {
        table {
            tr {
                th { "kernel" } th { "II" } th { "ResMII" } th { "RecMII" } th { "" }
                th { "operations" } th { "moves" } th { "stages" } th { "busy" } th { "cycles/ray" }
                th.words { "for a lower II" }
            }
            @for (i, l) in report.loops.iter().enumerate() {
                tr {
                    td { a href=(format!("#loop-{i}")) { (l.kernel) } }
                    td.good[l.status != Status::Open].above[l.status == Status::Open] { b { (l.ii) } }
                    td { (l.res_mii) } td { (l.rec_mii) } td.soft { (l.status.name()) }
                    td { (l.operations) } td { (l.moves) } td { (l.stages) }
                    td { (percent(l.busy())) }
                    td { (format!("{:.2}", l.cycles_per_ray)) }
                    td.words { (l.hint) }
                }
            }
        }
    }
}

fn details(number: usize, l: &LoopReport, contexts: u32) -> Markup {
    let seconds = l.seconds.map(|s| ("seconds of search", format!("{s:.3}")));
    let facts = [
        ("operations", l.operations.to_string()),
        ("moves", l.moves.to_string()),
        ("stages", l.stages.to_string()),
        ("cycles an iteration", l.length.to_string()),
        (
            "cycles of any schedule at this II, at least",
            l.least_length.to_string(),
        ),
        ("contexts", format!("{} of {contexts}", l.contexts)),
        ("registers set at entry", l.preloads.to_string()),
        ("cycles/ray", format!("{:.2}", l.cycles_per_ray)),
    ];
    html! {
        section id=(format!("loop-{number}")) {
            div.head {
                h2 { (l.kernel) }
                code.soft { (l.at) }
                span.ii.good[l.status != Status::Open].above[l.status == Status::Open] {
                    "II = " (l.ii) ", " (standing(l))
                }
            }
            @if l.software > 0 {
                p { (l.software) " of its " (l.operations) " operations stand in for units that the machine lacks." }
            }
            p.hint { b { "For a lower II: " } (l.hint)
                @for change in l.what_if.iter().flat_map(|w| w.changes.iter().skip(1)) {
                    span.or { "or " (change.in_words()) ": " b { (change.result()) } }
                }
            }
            dl { @for (what, figure) in facts.iter().chain(&seconds) {
                div { dt { (what) } dd { (figure) } }
            } }
            div.sides.wide[array::is_wide(l)] {
                (bounds(l))
                div { h3 { "How busy units and links are" } div.scroll { (array::whole(l)) } }
            }
            @if !l.recurrence.is_empty() {
                h3 { "The recurrence: operations, lines, and cycles until the next can issue" }
                (recurrence::drawing(l))
            }
            (array::cycles(l))
            (takes::files(l))
            (takes::links(l))
            (slots::table(l))
        }
    }
}

fn bounds(l: &LoopReport) -> Markup {
    html! {
        div.bounds {
            h3 { "What sets the bound" }
            p { "ResMII " b { (l.res_mii) } ": " (l.res_mii_why) }
            (resources(l))
            @if l.recurrence.is_empty() {
                p { "RecMII " b { "1" } ": no recurrence" }
            } @else {
                p { "RecMII " b { (l.rec_mii) } ": " (recurrence_in_words(l)) }
            }
            @if let Some(obstacle) = &l.why_not_lower {
                p.above { "Not lower: " (obstacle.text) }
                ul { @for o in &obstacle.operations { li { code { (o.op) } " at " code { (o.at) } } } }
            }
            @for proved in proof::proved(&l.impossible) {
                p { "Proved: " (proved) }
            }
            @if let Some(search) = proof::searched(&l.search) {
                details {
                    summary { "Exact search" }
                    p { (search) }
                }
            }
            @if !l.ordered.is_empty() {
                details {
                    summary { (count(l.ordered.len() as u32, "pair")) " of memory accesses kept in order" }
                    ul { @for o in &l.ordered {
                        li { code { (o.first) } " and " code { (o.second) } ": " (o.why) }
                    } }
                }
            }
        }
    }
}

/// The bound of each resource, as bars up to the II.
fn resources(l: &LoopReport) -> Markup {
    let width = |r: &Resource| format!("width:{:.0}%", 100.0 * part(r.bound, l.ii).min(1.0));
    let offer = |r: &Resource| match r.shared {
        true => format!("{}, {} a cycle", count(r.uses, "use"), r.offered),
        false => format!(
            "{} on {}",
            count(r.uses, "issue cycle"),
            count(r.offered, "unit")
        ),
    };
    html! {
        table.resources { @for r in &l.resources {
            tr.tight[r.bound == l.res_mii] {
                td { (r.resource) } td.soft { (offer(r)) }
                td { div.bar { i style=(width(r)) {} } } td { (r.bound) }
            }
        } }
    }
}

/// A position, without the file where it is that of the loop.
fn place(at: &Position, l: &LoopReport) -> String {
    match at.file == l.at.file && at.line > 0 {
        true => format!("{}:{}", at.line, at.column),
        false if at.line > 0 => {
            let name = at.file.rsplit('/').next().unwrap_or_default();
            format!("{name}:{}:{}", at.line, at.column)
        }
        false => String::new(),
    }
}

fn refused(loops: &[NotPipelined]) -> Markup {
    html! {
        section id="refused" {
            div.head { h2 { "Loops that are not on the array" } }
            div.scroll { table.refused { @for n in loops {
                tr {
                    td { code { (n.at) } } td { (n.kernel) } td { (n.reason) }
                    td { code.soft { (n.reason_at) } }
                }
            } } }
        }
    }
}

fn functions(functions: &[FunctionReport]) -> Markup {
    html! {
        section id="control" {
            div.head { h2 { "Control code on the VLIW engine" } }
            div.scroll { table {
                tr {
                    th { "function" } th { "operations" } th { "bundles" } th { "least" }
                    th { "spilled" } th { "frame" }
                }
                @for f in functions { tr {
                    td { (f.function) } td { (f.operations) }
                    td.good[f.bundles == f.least] { (f.bundles) } td { (f.least) }
                    td.above[f.spilled > 0] { (f.spilled) } td { (f.frame) }
                } }
            } }
        }
    }
}
