//! The modulo reservation table: a column a unit, a row a slot.

use maud::{Markup, html};
use srp_studies::loops::{Cell, LoopReport};

/// Kinds of operations, as they are coloured: the kind's name, and the classes it is made of.
const KINDS: [(&str, &[&str]); 6] = [
    ("integer", &["alu", "imul", "pred", "branch"]),
    ("float", &["fadd", "fmul", "fma", "cvt"]),
    (
        "vector",
        &["valu", "vmul", "vfadd", "vfmul", "vfma", "vdot"],
    ),
    ("lanes", &["lane"]),
    ("special", &["sfu", "fast", "idiv", "fdiv"]),
    ("memory", &["load", "store", "cload", "cstore", "tex", "io"]),
];

/// The table of a loop.
pub(super) fn table(l: &LoopReport) -> Markup {
    html! {
        h3 { "Modulo reservation table: what each unit issues in each cycle of the II, with stage and line" }
        div.legend {
            @for (kind, _) in KINDS { span { i class=(kind) {} (kind) } }
            span { i.moved {} "move" }
        }
        div.scroll { table.slots style=(format!("--units:{}", l.units.len())) {
            tr { th {} @for u in &l.units { th title=(u.unit) { (u.unit) } } }
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
        .find(|(_, classes)| classes.contains(&cell.class.as_str()));
    let kind = kind.map_or("integer", |(kind, _)| kind);
    let class = match cell {
        Cell { is_move: true, .. } => "moved".to_owned(),
        Cell { held: true, .. } => format!("held {kind}"),
        _ => format!("op {kind}"),
    };
    let (node, op, operands) = (cell.node, &cell.op, cell.operands.join(", "));
    html! {
        td class=(class) title=(format!("n{node} = {op} {operands}  ({})", cell.at)) {
            @if !cell.held {
                (op)
                small { "s" (cell.stage) @if cell.at.line > 0 { " · " (cell.at.line) } }
            }
        }
    }
}
