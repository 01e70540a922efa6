//! Names of variables, for the comments of a formula that is written. Nodes are called as in listings (`n3`),
//! units, files, wires and outputs as in the expanded machine file, links by their number in it.

use crate::modulo::problem::{Problem, Tag};
use crate::modulo::table::{Item, Via};
use srp_archdesc::arch::Carrier;
use srp_archdesc::resource::PlaceKind;
use srp_ir::dfg::Node;

/// The name of a counter's variables: of the uses of something in a slot.
pub(super) fn slot(what: &str, of: &str, slot: usize) -> String {
    format!("{what} {of} {slot}")
}

/// The name of an item of a value.
pub(super) fn item(problem: &Problem<'_>, value: Node, item: Item) -> String {
    let place = |place| problem.graph.name(problem.srp, place);
    let unit = |fu| &problem.srp.fus[fu].name;
    match item {
        Item::Out(p, time) => format!("out {value} {} {time}", place(p)),
        Item::Held(p, time, tag) => format!("held {value} {} {time}{}", place(p), tagged(tag)),
        Item::Written(p, time, tag, via) => {
            let via = self::via(problem, via);
            format!("write {value} {} {via} {time}{}", place(p), tagged(tag))
        }
        Item::Read(p, time, tag, fu) => {
            format!(
                "read {value} {} {} {time}{}",
                place(p),
                unit(fu),
                tagged(tag)
            )
        }
        Item::Move(fu, time, ..) => format!("move {value} {} {time}", unit(fu)),
        Item::Wire(p, time, from) => {
            let hop = match problem.graph.places[p].kind {
                PlaceKind::Wire { hop, .. } => hop,
                _ => 0,
            };
            format!("wire {value} {} {hop} {} {time}", place(p), place(from))
        }
        Item::Kept(p, tag) => format!("kept {value} {}{}", place(p), tagged(tag)),
    }
}

/// How a value gets into a file: the unit whose result it is, or the link.
pub(super) fn via(problem: &Problem<'_>, via: Via) -> String {
    match via {
        Via::Result(fu) => problem.srp.fus[fu].name.clone(),
        Via::Over(Carrier::Link(link)) => format!("{link}"),
        Via::Over(Carrier::Wire(wire)) => problem.srp.wires[wire].name.clone(),
    }
}

/// The copy that a tag names, behind a blank.
fn tagged(tag: Tag) -> String {
    match tag {
        Tag::Plain => String::new(),
        Tag::Initial(list) => format!(" initial.{list}"),
        Tag::LiveOut(number) => format!(" out.{number}"),
    }
}
