//! The array, drawn: what every unit does and every link and wire carries in a cycle of the II, and how busy
//! units and links are over all of it.

use crate::count::count;
use maud::{Markup, PreEscaped, html};
use srp_studies::loops::{
    Carried, Cell, FileLoad, LinkLoad, LoopReport, Taken, UnitLoad, WireLoad, part, percent,
};
use std::collections::BTreeMap;

/// Width and height of a unit, and the gap between units.
const UNIT: (f64, f64) = (104.0, 58.0);
const GAP: (f64, f64) = (38.0, 34.0);
/// Room round the array, and where links go round it.
const MARGIN: (f64, f64) = (18.0, 62.0);
/// How far links of opposite directions are apart from the middle.
const APART: f64 = 6.0;
/// Letters of a unit's name that fit.
const LETTERS: usize = 15;
/// Stages that the legend names, at most.
const LEGEND_STAGES: u32 = 12;
/// Panels that are drawn; a longer II has its table.
const MOST_PANELS: usize = 64;

/// Where units stand, in pixels.
struct Grid<'a> {
    size: (f64, f64),
    at: BTreeMap<&'a str, (f64, f64)>,
}

impl<'a> Grid<'a> {
    fn of(l: &'a LoopReport) -> Grid<'a> {
        let step = (UNIT.0 + GAP.0, UNIT.1 + GAP.1);
        let cell: BTreeMap<&str, (u32, u32)> = (l.units.iter())
            .map(|u| (u.unit.as_str(), (u.row, u.column)))
            .collect();
        let is_far = |from: &str, to: &str| match (cell.get(from), cell.get(to)) {
            (Some(a), Some(b)) => a.0.abs_diff(b.0).max(a.1.abs_diff(b.1)) > 1,
            _ => false,
        };
        let mut taken = l.wires.iter().flat_map(|wire| &wire.takes);
        let by_wire = taken.any(|t| t.to.iter().any(|to| is_far(&t.unit, to)));
        let by_link = l.links.iter().any(|link| is_far(&link.from, &link.to));
        let margin = match by_wire || by_link {
            true => MARGIN.1,
            false => MARGIN.0,
        };
        let corner = |u: &UnitLoad| {
            let (row, column) = (f64::from(u.row), f64::from(u.column));
            (margin + column * step.0, margin + row * step.1)
        };
        let last = |of: fn(&UnitLoad) -> u32| l.units.iter().map(of).max().unwrap_or(0) + 1;
        Grid {
            size: (
                2.0 * margin + f64::from(last(|u| u.column)) * step.0 - GAP.0,
                2.0 * margin + f64::from(last(|u| u.row)) * step.1 - GAP.1,
            ),
            at: l
                .units
                .iter()
                .map(|u| (u.unit.as_str(), corner(u)))
                .collect(),
        }
    }

    fn svg(&self, class: &str, label: &str, content: Markup) -> Markup {
        let (w, h) = self.size;
        html! {
            svg class=(class) viewBox=(format!("0 0 {w} {h}")) width=(w) height=(h) role="img"
                aria-label=(label) { (content) }
        }
    }

    /// The path from one unit to another: straight to a neighbour, bent round what is between else.
    fn path(&self, from: &str, to: &str) -> Option<String> {
        let middle = |name: &str| {
            let &(x, y) = self.at.get(name)?;
            Some((x + UNIT.0 / 2.0, y + UNIT.1 / 2.0))
        };
        let (a, b) = (middle(from)?, middle(to).filter(|_| from != to)?);
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let length = dx.hypot(dy).max(1.0);
        // To the right of the way, so that both directions can be seen.
        let side = (-dy / length, dx / length);
        let far = dx.abs() > 1.5 * (UNIT.0 + GAP.0) || dy.abs() > 1.5 * (UNIT.1 + GAP.1);
        let apart = |p: (f64, f64), by: f64| (p.0 + side.0 * by, p.1 + side.1 * by);
        let (a, b) = (apart(a, APART), apart(b, APART));
        if !far {
            let (from, to) = (edge(a, (dx, dy)), edge(b, (-dx, -dy)));
            let to = (to.0 - 3.0 * dx / length, to.1 - 3.0 * dy / length);
            return Some(format!(
                "M{:.1} {:.1}L{:.1} {:.1}",
                from.0, from.1, to.0, to.1
            ));
        }
        let bend = 1.15
            * if dx.abs() > dy.abs() {
                UNIT.1 + GAP.1
            } else {
                UNIT.0 + GAP.0
            };
        let control = apart(((a.0 + b.0) / 2.0, (a.1 + b.1) / 2.0), bend);
        let from = edge(a, (control.0 - a.0, control.1 - a.1));
        let to = edge(b, (control.0 - b.0, control.1 - b.1));
        Some(format!(
            "M{:.1} {:.1}Q{:.1} {:.1} {:.1} {:.1}",
            from.0, from.1, control.0, control.1, to.0, to.1
        ))
    }
}

/// Where a way from the middle of a unit leaves it.
fn edge(middle: (f64, f64), way: (f64, f64)) -> (f64, f64) {
    let reach = |half: f64, way: f64| {
        if way == 0.0 {
            f64::INFINITY
        } else {
            half / way.abs()
        }
    };
    let out = reach(UNIT.0 / 2.0, way.0).min(reach(UNIT.1 / 2.0, way.1));
    (middle.0 + out * way.0, middle.1 + out * way.1)
}

/// Elements that the drawings of all loops share: arrow heads, and the links that there are.
pub(super) fn shared(l: &LoopReport) -> Markup {
    let grid = Grid::of(l);
    let head = |id: &str| {
        html! {
            marker id=(id) viewBox="0 0 8 8" refX="6.5" refY="4" markerWidth="7" markerHeight="7"
                orient="auto-start-reverse" markerUnits="userSpaceOnUse" {
                path d="M0 .8L8 4L0 7.2z" {}
            }
        }
    };
    html! {
        svg.defs width="0" height="0" aria-hidden="true" { defs {
            @for id in ["to-op", "to-file", "to-pred", "step", "critical"] { (head(id)) }
            clipPath id="unit" { rect width=(UNIT.0) height=(UNIT.1) rx="6" {} }
            g id="links" { @for link in &l.links {
                @if let Some(d) = grid.path(&link.from, &link.to) { path d=(d) {} }
            } }
        } }
    }
}

/// True if the array is too wide for anything to stand beside it.
pub(super) fn is_wide(l: &LoopReport) -> bool {
    Grid::of(l).size.0 > 700.0
}

/// How busy units and links are over the whole II.
pub(super) fn whole(l: &LoopReport) -> Markup {
    let grid = Grid::of(l);
    let mut used: Vec<&LinkLoad> = l.links.iter().filter(|link| link.slots > 0).collect();
    used.sort_by_key(|link| link.slots);
    let line = |link: &LinkLoad| {
        let busy = part(link.slots, l.ii);
        let style = format!(
            "stroke-width:{:.1};opacity:{:.2}",
            1.5 + 4.5 * busy,
            0.35 + 0.65 * busy
        );
        let what = format!(
            "{}: {} of {}",
            link.name(),
            count(link.slots, "cycle"),
            l.ii
        );
        html! {
            @if let Some(d) = grid.path(&link.from, &link.to) { path.load d=(d) style=(style) { title { (what) } } }
        }
    };
    let content = html! {
        (PreEscaped("<use href=\"#links\" class=\"topology\"/>"))
        @for link in used { (line(link)) }
        @for u in &l.units { (unit_load(&grid, l, u)) }
    };
    grid.svg("whole", "how busy units and links are", content)
}

fn unit_load(grid: &Grid<'_>, l: &LoopReport, u: &UnitLoad) -> Markup {
    let (x, y) = grid.at[u.unit.as_str()];
    let width = |slots: u32| UNIT.0 * part(slots, l.ii);
    let own = u.operations + u.held;
    let what = format!(
        "{}: {}, {}, {} held by an operation before, of {}",
        u.unit,
        count(u.operations, "operation"),
        count(u.moves, "move"),
        count(u.held, "cycle"),
        l.ii
    );
    html! {
        g.unit.idle[u.busy() == 0] transform=(format!("translate({x} {y})")) {
            title { (what) }
            rect.back width=(UNIT.0) height=(UNIT.1) rx="6" {}
            g clip-path="url(#unit)" {
                rect.own width=(width(own)) height=(UNIT.1) {}
                rect.moves x=(width(own)) width=(width(u.moves)) height=(UNIT.1) {}
            }
            rect.frame width=(UNIT.0) height=(UNIT.1) rx="6" {}
            text.name x="8" y="14" { (short(&u.unit)) }
            text.big x="8" y="39" { (percent(part(u.busy(), l.ii))) }
        }
    }
}

fn short(name: &str) -> String {
    match name.chars().count() > LETTERS {
        true => name.chars().take(LETTERS - 1).chain(['…']).collect(),
        false => name.to_owned(),
    }
}

/// The array in each cycle of the II.
pub(super) fn cycles(l: &LoopReport) -> Markup {
    let grid = Grid::of(l);
    let all = l.table.len();
    let stages = l.stages.min(LEGEND_STAGES);
    let shown: Vec<u32> = (0..stages).map(|i| spread(i, stages, l.stages)).collect();
    html! {
        h3 { "The array in each cycle of the II" }
        div.legend {
            @for stage in shown { span { i.stage style=(hue(stage, l.stages)) {} "stage " (stage) } }
            span { i.moving {} "routing move" }
            span { i.holding {} "held by the operation before" }
            span.to-op { (key("to-op")) "to an operand" }
            span.to-file { (key("to-file")) "into a register file" }
            span.to-pred { (key("to-pred")) "predicate" }
            span { i.filled {} "registers that hold something" }
        }
        div.cycles.scroll style=(format!("--wide:{}px", grid.size.0)) {
            @for slot in 0..all.min(MOST_PANELS) {
                figure {
                    figcaption { "cycle " b { (slot) } " of " (all) }
                    (panel(&grid, l, slot))
                }
            }
        }
        @if all > MOST_PANELS {
            p.soft { "Cycles " (MOST_PANELS) " to " (all - 1) " are in the table below." }
        }
    }
}

/// The `i`-th of `n` numbers spread evenly from 0 to below `all`.
fn spread(i: u32, n: u32, all: u32) -> u32 {
    if n < 2 { 0 } else { i * (all - 1) / (n - 1) }
}

fn key(class: &str) -> Markup {
    html! {
        svg width="26" height="10" aria-hidden="true" { path class=(class) d="M1 5L22 5" {} }
    }
}

/// The colour of a stage, from the first to the last.
fn hue(stage: u32, stages: u32) -> String {
    let along = part(stage, stages.saturating_sub(1));
    format!("--hue:{:.0}", 225.0 - 205.0 * along)
}

fn panel(grid: &Grid<'_>, l: &LoopReport, slot: usize) -> Markup {
    let here = |c: &&Carried| c.slot as usize == slot;
    let content = html! {
        (PreEscaped("<use href=\"#links\" class=\"topology\"/>"))
        @for link in &l.links {
            @for carried in link.carries.iter().filter(here) { (arrow(grid, l, link, carried)) }
        }
        @for wire in &l.wires {
            @for taken in wire.takes.iter().filter(|t| t.slot as usize == slot) {
                @for to in &taken.to { (way(grid, l, wire, taken, to)) }
            }
        }
        @for (u, cell) in l.units.iter().zip(&l.table[slot]) {
            (unit(grid, l, u, cell.as_ref(), slot))
        }
    };
    grid.svg("panel", &format!("cycle {slot}"), content)
}

fn arrow(grid: &Grid<'_>, l: &LoopReport, link: &LinkLoad, carried: &Carried) -> Markup {
    let class = match &carried.file {
        Some(_) => "to-file",
        None if is_predicate(l, carried.node, link.width) => "to-pred",
        None => "to-op",
    };
    let to = match &carried.file {
        Some(file) => format!("register file {file}"),
        None => "an operand".to_owned(),
    };
    let what = format!("n{} over {} to {to}", carried.node, link.name());
    html! {
        @if let Some(d) = grid.path(&link.from, &link.to) {
            path class=(class) d=(d) { title { (what) } }
        }
    }
}

/// True if what a node gives is a predicate, by the width of what carries it or by its class.
fn is_predicate(l: &LoopReport, node: u32, width: u32) -> bool {
    let cells = l.table.iter().flatten().flatten();
    let mut own = cells.filter(|c| c.node == node && !c.is_move);
    width == 1 || own.any(|c| c.class == "pred")
}

/// The way of a value from the unit at the other end of all wires to a unit that takes it from one.
fn way(grid: &Grid<'_>, l: &LoopReport, wire: &WireLoad, taken: &Taken, to: &str) -> Markup {
    let file = l.files.iter().find(|file| file.file == to);
    let unit = match file {
        Some(file) => file.unit.as_deref(),
        None => Some(to),
    };
    let class = match file {
        Some(_) => "to-file",
        None if is_predicate(l, taken.node, wire.width) => "to-pred",
        None => "to-op",
    };
    let what = format!("n{} over {} to {to}", taken.node, wire.wire);
    html! {
        // Another wire goes on to where it leads by itself.
        @if let Some(d) = unit.and_then(|unit| grid.path(&taken.unit, unit)) {
            path class=(class) d=(d) { title { (what) } }
        }
    }
}

fn unit(grid: &Grid<'_>, l: &LoopReport, u: &UnitLoad, cell: Option<&Cell>, slot: usize) -> Markup {
    let (x, y) = grid.at[u.unit.as_str()];
    let place = format!("translate({x} {y})");
    let files = l
        .files
        .iter()
        .filter(|f| f.unit.as_deref() == Some(&u.unit));
    let files: Vec<&FileLoad> = files.collect();
    let class = match cell {
        None => "unit idle",
        Some(Cell { held: true, .. }) => "unit held",
        Some(Cell { is_move: true, .. }) => "unit moving",
        Some(_) => "unit busy",
    };
    let style = cell.map(|c| hue(c.stage, l.stages));
    html! {
        g class=(class) transform=(place) style=[style] {
            title { (unit_in_words(u, cell, &files, slot)) }
            rect.back width=(UNIT.0) height=(UNIT.1) rx="6" {}
            rect.frame width=(UNIT.0) height=(UNIT.1) rx="6" {}
            text.name x="8" y="13" { (short(&u.unit)) }
            @if let Some(cell) = cell {
                text.op x="8" y="30" { (short(&cell.op)) }
                text.meta x="8" y="45" {
                    "s" (cell.stage) " · n" (cell.node)
                    @if cell.at.line > 0 { " · :" (cell.at.line) }
                }
            }
            (registers(&files, slot))
        }
    }
}

/// A bar of the registers that hold something in a cycle.
fn registers(files: &[&FileLoad], slot: usize) -> Markup {
    let live: u32 = files.iter().map(|f| f.live_by_slot[slot]).sum();
    let capacity = files.iter().map(|f| f.capacity).sum();
    let width = UNIT.0 - 16.0;
    html! {
        @if capacity > 0 {
            rect.empty x="8" y=(UNIT.1 - 8.0) width=(width) height="3" rx="1.5" {}
            rect.filled x="8" y=(UNIT.1 - 8.0) width=(format!("{:.1}", width * part(live, capacity)))
                height="3" rx="1.5" {}
        }
    }
}

fn unit_in_words(u: &UnitLoad, cell: Option<&Cell>, files: &[&FileLoad], slot: usize) -> String {
    let mut words = match cell {
        None => format!("{} is idle", u.unit),
        Some(c) => {
            let (node, op, operands) = (c.node, &c.op, c.operands.join(", "));
            let held = if c.held { " (issued before)" } else { "" };
            format!(
                "{}: n{node} = {op} {operands}{held}\nstage {}, {}",
                u.unit, c.stage, c.at
            )
        }
    };
    for f in files {
        words.push_str(&format!(
            "\n{}: {} of {} live",
            f.file, f.live_by_slot[slot], f.capacity
        ));
    }
    words
}
