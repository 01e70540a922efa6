//! The recurrence that bounds a loop, drawn: its operations in order with their lines and latencies,
//! and whatever else is in circles with them.

use crate::count::count;
use maud::{Markup, html};
use srp_studies::loops::{Edge, LoopReport, Operation, Position, Step};
use std::collections::{BTreeMap, BTreeSet};

/// Width and height of an operation, and the gaps between them.
const BOX: (f64, f64) = (128.0, 42.0);
const GAP: (f64, f64) = (58.0, 34.0);
/// Room round the drawing, for ways back.
const MARGIN: f64 = 30.0;
/// Operations of a recurrence that stand in a row.
const IN_A_ROW: usize = 7;
/// Operations that are drawn beside the recurrence itself, at most.
const MOST_NODES: usize = 14;

/// A finished drawing.
struct Drawing<'a> {
    size: (f64, f64),
    boxes: Vec<Placed<'a>>,
    ways: Vec<Way>,
}

/// An operation in its place.
struct Placed<'a> {
    at: (f64, f64),
    op: &'a str,
    node: u32,
    from: &'a Position,
    critical: bool,
}

/// A dependence in its place.
struct Way {
    path: String,
    label: String,
    label_at: (f64, f64),
    critical: bool,
    back: bool,
}

/// The drawing of a loop's recurrence, if it has one.
pub(super) fn drawing(l: &LoopReport) -> Markup {
    if l.recurrence.is_empty() {
        return html! {};
    }
    let alone = l.recurrence_graph.nodes.len() == l.recurrence.len();
    let drawing = match alone || l.recurrence_graph.nodes.len() > MOST_NODES {
        true => snake(&l.recurrence),
        false => layers(l),
    };
    let (w, h) = drawing.size;
    let others = l.recurrence_graph.nodes.len() - drawing.boxes.len();
    html! {
        div.scroll { svg.recurrence viewBox=(format!("0 0 {w} {h}")) width=(w) height=(h) role="img"
            aria-label="the recurrence" {
            @for way in drawing.ways.iter().filter(|w| !w.critical) { (line(way)) }
            @for way in drawing.ways.iter().filter(|w| w.critical) { (line(way)) }
            @for placed in &drawing.boxes { (operation(placed, l)) }
            @for way in &drawing.ways {
                text.latency.critical[way.critical] x=(way.label_at.0) y=(way.label_at.1) { (way.label) }
            }
        } }
        @if others > 0 {
            p.soft { (count(others as u32, "other operation")) " in circles with these: "
                code { "recurrence_graph" } " in the JSON." }
        }
    }
}

fn line(way: &Way) -> Markup {
    let head = if way.critical {
        "url(#critical)"
    } else {
        "url(#step)"
    };
    let class = match (way.critical, way.back) {
        (true, false) => "way critical",
        (true, true) => "way critical back",
        (false, false) => "way",
        (false, true) => "way back",
    };
    html! { path class=(class) d=(way.path) marker-end=(head) {
        title { (way.label) }
    } }
}

fn operation(placed: &Placed<'_>, l: &LoopReport) -> Markup {
    let (x, y) = placed.at;
    html! {
        g.step.critical[placed.critical] transform=(format!("translate({x:.1} {y:.1})")) {
            title { "n" (placed.node) " = " (placed.op) "\n" (placed.from) }
            rect width=(BOX.0) height=(BOX.1) rx="6" {}
            text.op x="10" y="18" { (placed.op) }
            text.meta x="10" y="33" { (super::place(placed.from, l)) }
        }
    }
}

/// The label of a dependence.
fn label(latency: u32, distance: u32) -> String {
    let cycles = count(latency, "cycle");
    match distance {
        0 => cycles,
        n => format!("{cycles}, {} later", count(n, "iteration")),
    }
}

/// The recurrence alone: in rows, each in the other direction than the one above, and back round the
/// left side.
fn snake(steps: &[Step]) -> Drawing<'_> {
    let columns = steps.len().min(IN_A_ROW);
    let corner = |i: usize| {
        let (row, along) = (i / IN_A_ROW, i % IN_A_ROW);
        let column = if row % 2 == 0 {
            along
        } else {
            IN_A_ROW - 1 - along
        };
        (
            MARGIN + column as f64 * (BOX.0 + GAP.0),
            MARGIN / 2.0 + row as f64 * (BOX.1 + GAP.1),
        )
    };
    let (mut boxes, mut ways) = (Vec::new(), Vec::new());
    for (i, step) in steps.iter().enumerate() {
        boxes.push(Placed {
            at: corner(i),
            op: &step.op,
            node: step.node,
            from: &step.at,
            critical: true,
        });
        let (a, b) = (corner(i), corner((i + 1) % steps.len()));
        let way = match i + 1 == steps.len() {
            true => way_round(a, b, step),
            false => way_on(a, b, step),
        };
        ways.push(way);
    }
    let rows = steps.len().div_ceil(IN_A_ROW);
    let size = (
        2.0 * MARGIN + columns as f64 * (BOX.0 + GAP.0) - GAP.0,
        MARGIN / 2.0 + rows as f64 * (BOX.1 + GAP.1) + 22.0,
    );
    Drawing {
        size: (size.0.max(260.0), size.1),
        boxes,
        ways,
    }
}

/// To the next operation, beside or below.
fn way_on(a: (f64, f64), b: (f64, f64), step: &Step) -> Way {
    let middle = BOX.1 / 2.0;
    let (from, to) = if a.1 != b.1 {
        let x = a.0 + BOX.0 / 2.0;
        ((x, a.1 + BOX.1), (x, b.1))
    } else if a.0 < b.0 {
        ((a.0 + BOX.0, a.1 + middle), (b.0, b.1 + middle))
    } else {
        ((a.0, a.1 + middle), (b.0 + BOX.0, b.1 + middle))
    };
    let down = a.1 != b.1;
    let centre = ((from.0 + to.0) / 2.0, (from.1 + to.1) / 2.0);
    let short = match step.distance {
        0 => step.latency.to_string(),
        n => format!("{}, +{n}", step.latency),
    };
    Way {
        path: format!("M{:.1} {:.1}L{:.1} {:.1}", from.0, from.1, to.0, to.1),
        label: short,
        label_at: match down {
            true => (centre.0 + 14.0, centre.1 + 4.0),
            false => (centre.0, centre.1 - 6.0),
        },
        critical: true,
        back: false,
    }
}

/// From the last operation back to the first.
fn way_round(a: (f64, f64), b: (f64, f64), step: &Step) -> Way {
    let (x, bottom) = (a.0 + BOX.0 / 2.0, a.1 + BOX.1);
    let (low, left, top) = (bottom + 20.0, MARGIN / 3.0, b.1 + BOX.1 / 2.0);
    let path = format!(
        "M{x:.1} {bottom:.1}V{:.1}Q{x:.1} {low:.1} {:.1} {low:.1}H{:.1}Q{left:.1} {low:.1} {left:.1} {:.1}V{:.1}Q{left:.1} {top:.1} {:.1} {top:.1}H{:.1}",
        low - 8.0,
        x - 8.0,
        left + 8.0,
        low - 8.0,
        top + 8.0,
        left + 8.0,
        b.0
    );
    Way {
        path,
        label: label(step.latency, step.distance),
        label_at: (((x + left) / 2.0).max(left + 90.0), low + 14.0),
        critical: true,
        back: true,
    }
}

/// All that is in circles with the recurrence: in columns, each operation after those it depends on
/// in its own iteration, the recurrence in the first row.
fn layers(l: &LoopReport) -> Drawing<'_> {
    let graph = &l.recurrence_graph;
    let column = columns(&graph.nodes, &graph.edges);
    let critical: BTreeSet<u32> = l.recurrence.iter().map(|s| s.node).collect();
    let mut taken: BTreeMap<u32, u32> = BTreeMap::new();
    let mut order: Vec<&Operation> = graph.nodes.iter().collect();
    order.sort_by_key(|o| !critical.contains(&o.node));
    let mut row: BTreeMap<u32, u32> = BTreeMap::new();
    for operation in order {
        let first = u32::from(!critical.contains(&operation.node));
        let next = taken.entry(column[&operation.node]).or_insert(0);
        let own = (*next).max(first);
        row.insert(operation.node, own);
        *next = own + 1;
    }
    let rows = row.values().max().map_or(1, |r| r + 1);
    let above = 44.0;
    let corner = |node: u32| {
        (
            MARGIN + f64::from(column[&node]) * (BOX.0 + GAP.0),
            above + f64::from(row[&node]) * (BOX.1 + GAP.1 / 2.0),
        )
    };
    let floor = above + f64::from(rows) * (BOX.1 + GAP.1 / 2.0);
    let mut backs = 0;
    let ways: Vec<Way> = (graph.edges.iter())
        .map(|e| {
            let forward = column[&e.from] < column[&e.to];
            backs += u32::from(!forward && !e.critical);
            match forward {
                true => forward_way(corner(e.from), corner(e.to), e),
                false => back_way(
                    corner(e.from),
                    corner(e.to),
                    e,
                    floor + 12.0 * f64::from(backs),
                ),
            }
        })
        .collect();
    let boxes = graph.nodes.iter().map(|o| Placed {
        at: corner(o.node),
        op: &o.op,
        node: o.node,
        from: &o.at,
        critical: critical.contains(&o.node),
    });
    let widest = column.values().max().map_or(1, |c| c + 1);
    Drawing {
        size: (
            2.0 * MARGIN + f64::from(widest) * (BOX.0 + GAP.0) - GAP.0,
            floor + 12.0 * f64::from(backs) + 16.0,
        ),
        boxes: boxes.collect(),
        ways,
    }
}

/// The column of each operation: after all that it depends on in its own iteration.
fn columns(nodes: &[Operation], edges: &[Edge]) -> BTreeMap<u32, u32> {
    let mut column: BTreeMap<u32, u32> = nodes.iter().map(|o| (o.node, 0)).collect();
    // Dependences within an iteration have no circles, so this ends.
    for _ in nodes {
        let mut changed = false;
        for e in edges.iter().filter(|e| e.distance == 0) {
            let after = column[&e.from] + 1;
            if column[&e.to] < after {
                column.insert(e.to, after);
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    column
}

fn forward_way(a: (f64, f64), b: (f64, f64), e: &Edge) -> Way {
    let (from, to) = ((a.0 + BOX.0, a.1 + BOX.1 / 2.0), (b.0, b.1 + BOX.1 / 2.0));
    let far = to.0 - from.0 > GAP.0 + 1.0 && from.1 == to.1 && !e.critical;
    let (half, low) = ((to.0 - from.0) / 2.0, if far { BOX.1 } else { 0.0 });
    Way {
        path: format!(
            "M{:.1} {:.1}C{:.1} {:.1} {:.1} {:.1} {:.1} {:.1}",
            from.0,
            from.1,
            from.0 + half,
            from.1 + low,
            to.0 - half,
            to.1 + low,
            to.0,
            to.1
        ),
        label: e.latency.to_string(),
        label_at: (from.0 + half, (from.1 + to.1) / 2.0 + 0.75 * low - 6.0),
        critical: e.critical,
        back: false,
    }
}

/// A dependence on an earlier column: over the top along the recurrence, else below everything.
fn back_way(a: (f64, f64), b: (f64, f64), e: &Edge, floor: f64) -> Way {
    let (from, to) = (a.0 + 0.6 * BOX.0, b.0 + 0.4 * BOX.0);
    let middle = (from + to) / 2.0;
    let name = label(e.latency, e.distance);
    if e.critical {
        let top = 12.0;
        let path = format!(
            "M{from:.1} {:.1}C{from:.1} {top:.1} {to:.1} {top:.1} {to:.1} {:.1}",
            a.1, b.1
        );
        return Way {
            path,
            label: name,
            label_at: (middle, 14.0),
            critical: true,
            back: true,
        };
    }
    let (start, end) = (a.1 + BOX.1, b.1 + BOX.1);
    Way {
        path: format!(
            "M{from:.1} {start:.1}C{from:.1} {floor:.1} {to:.1} {floor:.1} {to:.1} {end:.1}"
        ),
        label: format!("{}, +{}", e.latency, e.distance),
        label_at: (middle, (start + end) / 8.0 + 0.75 * floor - 2.0),
        critical: false,
        back: true,
    }
}
