//! The report as one self-contained page: no script, no network.

use super::{Cell, LoopReport, NotPipelined, Report};
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = "
:root { color-scheme: light dark; --line: #8884; --op: #2f6fab; --move: #b7791f; --faint: #8882; }
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 76rem; padding: 0 1rem; }
h1 { font-size: 1.4rem; } h2 { font-size: 1.15rem; margin: 2.5rem 0 .3rem; }
code, td, th { font-variant-numeric: tabular-nums; }
code { font-family: ui-monospace, monospace; font-size: .92em; }
table { border-collapse: collapse; } th, td { padding: .2rem .6rem; text-align: right; }
th { font-weight: 600; border-bottom: 1px solid var(--line); } th:first-child, td:first-child { text-align: left; }
.scroll { overflow-x: auto; }
table.slots td, table.slots th { border: 1px solid var(--line); padding: .15rem .35rem; text-align: left;
  min-width: 4.6rem; vertical-align: top; font-size: .8rem; line-height: 1.25; }
table.slots td.op { background: color-mix(in srgb, var(--op) 22%, transparent); }
table.slots td.move { background: color-mix(in srgb, var(--move) 20%, transparent); font-style: italic; }
table.slots small { opacity: .7; display: block; }
.bar { display: inline-block; height: .7em; background: var(--op); }
.bar.move { background: var(--move); }
.units { display: grid; grid-template-columns: repeat(auto-fill, minmax(15rem, 1fr)); gap: 0 1.5rem; font-size: .85rem; }
.units div { display: grid; grid-template-columns: 5rem 1fr 3rem; align-items: center; }
.units span.track { background: var(--faint); line-height: 0; }
.above { color: #c0392b; font-weight: 600; }
p { margin: .3rem 0; }
";

/// The page.
pub(crate) fn page(report: &Report) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "Initiation intervals on " (report.machine) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "Initiation intervals on " code { (report.machine) } }
                (summary(report))
                @for l in &report.loops { (details(l)) }
                @if !report.not_pipelined.is_empty() {
                    h2 { "Loops that are not on the array" }
                    @for n in &report.not_pipelined { (not_pipelined(n)) }
                }
            }
        }
    }
    .into_string()
}

fn summary(report: &Report) -> Markup {
    html! {
        div.scroll { table {
            tr {
                th { "kernel" } th { "operations" } th { "moves" } th { "II" } th { "ResMII" }
                th { "RecMII" } th { "stages" } th { "cycles/ray" }
            }
            @for l in &report.loops {
                tr {
                    td { a href={ "#" (l.kernel) } { (l.kernel) } }
                    td { (l.operations) } td { (l.moves) }
                    td.above[l.ii > bound(l)] { (l.ii) }
                    td { (l.res_mii) } td { (l.rec_mii) } td { (l.stages) }
                    td { (format!("{:.2}", l.cycles_per_ray)) }
                }
            }
        } }
    }
}

fn bound(l: &LoopReport) -> u32 {
    l.res_mii.max(l.rec_mii)
}

fn details(l: &LoopReport) -> Markup {
    html! {
        h2 id=(l.kernel) { (l.kernel) ": II = " (l.ii) }
        p { code { (l.at) } ", " (l.stages) " stages, " (l.length) " cycles an iteration, "
            (l.contexts) " contexts, " (l.preloads) " registers set at entry" }
        p { "ResMII " (l.res_mii) ": " (l.res_mii_why) }
        @if l.recurrence.is_empty() {
            p { "RecMII 1: no recurrence" }
        } @else {
            p { "RecMII " (l.rec_mii) ", set by the recurrence" }
            ul { @for step in &l.recurrence {
                li { code { (step.op) } ", " (step.latency) " cycles, " code { (step.at) } }
            } }
        }
        @if let Some(why) = &l.why_not_lower { p.above { "Not lower: " (why) } }
        (utilisation(l))
        (slots(l))
    }
}

fn utilisation(l: &LoopReport) -> Markup {
    let percent = |n: u32| 100.0 * f64::from(n) / f64::from(l.ii);
    html! {
        div.units { @for u in &l.utilisation {
            div {
                code { (u.unit) }
                span.track {
                    span.bar style=(format!("width:{:.1}%", percent(u.operations))) {}
                    span.bar.move style=(format!("width:{:.1}%", percent(u.moves))) {}
                }
                span { (format!("{:.0} %", percent(u.operations + u.moves))) }
            }
        } }
    }
}

/// The modulo reservation table: a column a unit, a row a slot.
fn slots(l: &LoopReport) -> Markup {
    html! {
        p { "Modulo reservation table: what each unit issues in each cycle of the II; the stage and the "
            "source line below; moves in italics." }
        div.scroll { table.slots {
            tr { th { "slot" } @for u in &l.utilisation { th { (u.unit) } } }
            @for (slot, row) in l.table.iter().enumerate() {
                tr { th { (slot) } @for cell in row { (slot_cell(cell.as_ref())) } }
            }
        } }
    }
}

fn slot_cell(cell: Option<&Cell>) -> Markup {
    let Some(cell) = cell else {
        return html! { td {} };
    };
    let title = format!(
        "n{} = {} {}  ({})",
        cell.node,
        cell.op,
        cell.operands.join(", "),
        cell.at
    );
    let class = if cell.is_move { "move" } else { "op" };
    html! {
        td class=(class) title=(title) {
            (cell.op)
            small { "s" (cell.stage) @if cell.at.line > 0 { " · " (cell.at.line) } }
        }
    }
}

fn not_pipelined(n: &NotPipelined) -> Markup {
    html! { p { code { (n.at) } " " (n.kernel) ": " (n.reason) " (" code { (n.reason_at) } ")" } }
}
