//! The report as one self-contained page: no script, no network.

use super::{Cell, LoopReport, NotPipelined, Report, Step, UnitLoad};
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("page.css");

/// Kinds of operations, as they are coloured: the kind's name, and the classes it is made of.
const KINDS: [(&str, &[&str]); 6] = [
    ("integer", &["alu", "imul", "pred", "branch"]),
    ("float", &["fadd", "fmul", "fma", "cvt"]),
    (
        "vector",
        &["valu", "vmul", "vfadd", "vfmul", "vfma", "vdot"],
    ),
    ("lanes", &["lane"]),
    ("special", &["sfu", "idiv", "fdiv"]),
    ("memory", &["load", "store", "cload", "cstore", "io"]),
];

/// The page.
pub(super) fn page(report: &Report) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "Initiation intervals on " (report.machine) }
                style { (PreEscaped(STYLE)) }
            }
            body { main {
                h1 { "Initiation intervals on " code { (report.machine) } }
                @if !report.complete {
                    p.above { "Interrupted: these IIs were reached until then." }
                }
                (summary(report))
                @for l in &report.loops { (details(l)) }
                @if !report.not_pipelined.is_empty() { (refused(&report.not_pipelined)) }
            } }
        }
    }
    .into_string()
}

fn summary(report: &Report) -> Markup {
    if report.loops.is_empty() {
        return html! { p { "No loop is on the array." } };
    }
    html! {
        div.summary.scroll { table {
            tr {
                th { "kernel" } th { "operations" } th { "moves" } th { "II" } th { "ResMII" }
                th { "RecMII" } th { "stages" } th { "busy" } th { "cycles/ray" }
            }
            @for l in &report.loops {
                tr {
                    td { a href={ "#" (l.kernel) } { (l.kernel) } }
                    td { (l.operations) } td { (l.moves) }
                    td.good[l.ii <= bound(l)].above[l.ii > bound(l)] { (l.ii) }
                    td { (l.res_mii) } td { (l.rec_mii) } td { (l.stages) }
                    td { (percent(busy(l))) }
                    td { (format!("{:.2}", l.cycles_per_ray)) }
                }
            }
        } }
    }
}

fn bound(l: &LoopReport) -> u32 {
    l.res_mii.max(l.rec_mii)
}

/// The part of the array's issue slots that is taken.
fn busy(l: &LoopReport) -> f64 {
    let taken: u32 = l.utilisation.iter().map(UnitLoad::busy).sum();
    f64::from(taken) / (f64::from(l.ii) * l.utilisation.len().max(1) as f64)
}

fn percent(part: f64) -> String {
    format!("{:.0} %", 100.0 * part)
}

fn details(l: &LoopReport) -> Markup {
    let facts = [
        ("operations", l.operations.to_string()),
        ("moves", l.moves.to_string()),
        ("stages", l.stages.to_string()),
        ("cycles an iteration", l.length.to_string()),
        ("contexts", l.contexts.to_string()),
        ("registers set at entry", l.preloads.to_string()),
        ("cycles/ray", format!("{:.2}", l.cycles_per_ray)),
    ];
    html! {
        section id=(l.kernel) {
            div.head {
                h2 { (l.kernel) }
                code.soft { (l.at) }
                @if l.ii > bound(l) {
                    span.ii.above { "II = " (l.ii) ", " (l.ii - bound(l)) " above the bound" }
                } @else {
                    span.ii.good { "II = " (l.ii) ", the bound" }
                }
            }
            dl { @for (what, figure) in &facts { div { dt { (what) } dd { (figure) } } } }
            div.sides {
                (bounds(l))
                div { h3 { "Issue slots taken" } (array(l)) }
            }
            (slots(l))
        }
    }
}

fn bounds(l: &LoopReport) -> Markup {
    html! {
        div.bounds {
            h3 { "What sets the bound" }
            p { "ResMII " b { (l.res_mii) } ": " (l.res_mii_why) }
            @if l.recurrence.is_empty() {
                p { "RecMII " b { "1" } ": no recurrence" }
            } @else {
                p { "RecMII " b { (l.rec_mii) } ": the recurrence, with cycles and lines" }
                ul.cycle { @for step in &l.recurrence { (recurrence_step(l, step)) } }
            }
            @if let Some(why) = &l.why_not_lower { p.above { "Not lower: " (why) } }
            @for change in &l.what_if {
                p { "With " (change.what) ": II = " b { (change.ii) } }
            }
            @if !l.ordered.is_empty() {
                details {
                    summary { (l.ordered.len()) " pairs of memory accesses are kept in order" }
                    ul { @for o in &l.ordered {
                        li { code { (o.first) } " and " code { (o.second) } ": " (o.why) }
                    } }
                }
            }
            @for i in &l.impossible {
                p { "Proved: no schedule at II = " (i.ii) " up to " (i.slack)
                    " cycles beyond the critical path" }
            }
        }
    }
}

fn recurrence_step(l: &LoopReport, step: &Step) -> Markup {
    let place = match step.at.file == l.at.file && step.at.line > 0 {
        true => format!("{}:{}", step.at.line, step.at.column),
        false => step.at.to_string(),
    };
    html! { li title=(step.at) { code { (step.op) } " " (step.latency) small { (place) } } }
}

/// How busy the units are, where they stand.
fn array(l: &LoopReport) -> Markup {
    let columns = l.utilisation.iter().map(|u| u.column + 1).max();
    let columns = format!(
        "grid-template-columns:repeat({},auto)",
        columns.unwrap_or(1)
    );
    let part = |slots: u32| f64::from(slots) / f64::from(l.ii);
    let width = |slots: u32| format!("width:{:.1}%", 100.0 * part(slots));
    html! {
        div.scroll { div.array style=(columns) { @for u in &l.utilisation {
            @let place = format!("grid-area:{}/{}", u.row + 1, u.column + 1);
            @let own = u.operations + u.held;
            div.idle[u.busy() == 0] style=(place) title=(unit_title(u)) {
                i style=(width(own)) {}
                @if u.moves > 0 {
                    i.move style=(format!("left:{:.1}%;{}", 100.0 * part(own), width(u.moves))) {}
                }
                code { (u.unit) }
                b { (percent(part(u.busy()))) }
            }
        } } }
    }
}

fn unit_title(u: &UnitLoad) -> String {
    format!(
        "{}: {} operations, {} moves, {} slots held by an operation before",
        u.unit, u.operations, u.moves, u.held
    )
}

/// The modulo reservation table: a column a unit, a row a slot.
fn slots(l: &LoopReport) -> Markup {
    html! {
        h3 { "Modulo reservation table: what each unit issues in each cycle of the II, with stage and line" }
        div.legend {
            @for (kind, _) in KINDS { span { i class=(kind) {} (kind) } }
            span { i.moved {} "move" }
        }
        div.scroll { table.slots style=(format!("--units:{}", l.utilisation.len())) {
            tr { th {} @for u in &l.utilisation { th title=(u.unit) { (u.unit) } } }
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
    let kind = KINDS
        .iter()
        .find(|(_, classes)| classes.contains(&cell.class));
    let kind = kind.map_or("integer", |(kind, _)| kind);
    let class = match cell {
        Cell { is_move: true, .. } => "moved".to_owned(),
        Cell { held: true, .. } => format!("held {kind}"),
        _ => format!("op {kind}"),
    };
    let (node, op, operands) = (cell.node, cell.op, cell.operands.join(", "));
    html! {
        td class=(class) title=(format!("n{node} = {op} {operands}  ({})", cell.at)) {
            @if !cell.held {
                (op)
                small { "s" (cell.stage) @if cell.at.line > 0 { " · " (cell.at.line) } }
            }
        }
    }
}

fn refused(loops: &[NotPipelined]) -> Markup {
    html! {
        section {
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
