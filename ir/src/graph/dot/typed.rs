//! Graphs that [`dfg::dot`](crate::dfg::dot()) wrote: whole loops, whose nodes say in attributes what
//! the XML form says of them. The drawn edges must agree with that.

use super::{Attributes, DotEdge, DotNode, Tree};
use crate::dfg::{DepKind, Dfg, Node};
use crate::dre::{self, Part};
use crate::graph::raw::shortened;
use crate::graph::{At, Found, Graph};
use srp_archdesc::diagnostic::{Source, Span};
use srp_archdesc::entity::EntityMap;
use std::collections::BTreeMap;

/// True if a graph is a loop with a trip count.
pub(super) fn is_loop(tree: &Tree) -> bool {
    tree.attributes.contains_key("trip")
}

pub(super) fn read(source: &Source, tree: &Tree, found: &mut Found) -> Option<Graph> {
    let at = |span: Span| At {
        file: &source.name,
        span,
    };
    let list = |name: &str| tree.attributes.get(name).into_iter().flat_map(words);
    let mut children: Vec<Part<'_>> = Vec::new();
    for (word, span) in list("live_ins") {
        let mut parts = word.splitn(3, '@');
        let mut part = Part::new("live-in", span);
        for name in ["id", "type", "at"] {
            part.attributes
                .extend(parts.next().map(|text| (name, text, span)));
        }
        children.push(part);
    }
    children.extend(tree.nodes.iter().map(node));
    let is_order = |edge: &&DotEdge| edge.attributes.get("kind").is_some_and(|k| k.0 == "order");
    children.extend(tree.edges.iter().filter(is_order).map(order));
    for (word, span) in list("live_outs") {
        let mut part = Part::new("live-out", span);
        part.attributes.push(("node", word, span));
        children.push(part);
    }
    let mut kernel = Part::new("kernel", tree.span);
    let name = plain(tree.name.as_deref().unwrap_or_default());
    kernel.attributes.push(("name", &name, tree.span));
    kernel
        .attributes
        .extend(copied(&tree.attributes, &["trip", "at"]));
    let mut files = EntityMap::new();
    while let Some((name, _)) = tree.attributes.get(&format!("file{}", files.len())) {
        files.push(plain(name));
    }
    match dre::read_kernel(kernel, children, &files) {
        Ok(dfg) => {
            disagreement(tree, &dfg, &at, found);
            Some(Graph {
                names: tree.nodes.iter().map(|n| n.name.clone()).collect(),
                dfg,
                files,
                latencies: Vec::new(),
                carried: Vec::new(),
            })
        }
        Err((span, message)) => {
            found.error("G0210", &at(span), message);
            None
        }
    }
}

/// Text in which a backslash was doubled.
fn plain(text: &str) -> String {
    text.replace("\\\\", "\\")
}

/// The words of an attribute's value, each with the place of the whole.
fn words((text, span): &(String, Span)) -> impl Iterator<Item = (&str, Span)> {
    text.split_whitespace().map(|word| (word, *span))
}

/// The attributes of these names, as they are.
fn copied<'x>(
    attributes: &'x Attributes,
    names: &'static [&'static str],
) -> impl Iterator<Item = (&'static str, &'x str, Span)> {
    names.iter().filter_map(|name| {
        let (text, span) = attributes.get(*name)?;
        Some((*name, text.as_str(), *span))
    })
}

fn node(node: &DotNode) -> Part<'_> {
    let mut part = Part::new("node", node.span);
    part.attributes.push(("id", &node.name, node.span));
    let said = copied(&node.attributes, &["op", "args", "imm", "at"]);
    part.attributes.extend(said);
    part
}

fn order(edge: &DotEdge) -> Part<'_> {
    let mut part = Part::new("order", edge.span);
    part.attributes.push(("from", &edge.from, edge.span));
    part.attributes.push(("to", &edge.to, edge.span));
    let distance = edge.attributes.get("distance");
    let (text, span) = distance.map_or(("0", edge.span), |(text, span)| (text, *span));
    part.attributes.push(("distance", text, span));
    part
}

/// Reports drawn edges that are none of the operands, and the other way round.
fn disagreement<'f>(tree: &Tree, dfg: &Dfg, at: &dyn Fn(Span) -> At<'f>, found: &mut Found) {
    let by_name: BTreeMap<&str, Node> = (dfg.nodes.keys().zip(&tree.nodes))
        .map(|(node, dot)| (dot.name.as_str(), node))
        .collect();
    // Ends, operand and distance of each edge that carries a value; how often it is drawn.
    let mut drawn: BTreeMap<(Node, Node, u32, u32), i32> = BTreeMap::new();
    for (from, to, dep) in dfg.deps() {
        if let DepKind::Operand(operand) = dep.kind {
            *drawn.entry((from, to, operand, dep.distance)).or_default() -= 1;
        }
    }
    for edge in &tree.edges {
        let number = |name: &str, default| match edge.attributes.get(name) {
            Some((text, _)) => text.parse().ok(),
            None => default,
        };
        let is_value = edge.attributes.get("kind").is_none_or(|k| k.0 != "order");
        let ends = (by_name[edge.from.as_str()], by_name[edge.to.as_str()]);
        let (Some(operand), Some(distance)) =
            (number("operand", Some(0)), number("distance", Some(0)))
        else {
            found.error(
                "G0105",
                &at(edge.span),
                "`operand` and `distance` are numbers",
            );
            continue;
        };
        let times = drawn
            .entry((ends.0, ends.1, operand, distance))
            .or_default();
        *times += i32::from(is_value);
        if *times > 0 {
            let (from, to) = (shortened(&edge.from), shortened(&edge.to));
            let message = format!("`{to}` has no such operand of `{from}` in its `args`");
            found.error("G0210", &at(edge.span), message);
            return;
        }
    }
    if let Some((&(from, to, operand, _), _)) = drawn.iter().find(|(_, times)| **times < 0) {
        let place = tree
            .nodes
            .iter()
            .zip(dfg.nodes.keys())
            .find(|(_, n)| *n == to);
        let span = place.map_or(tree.span, |(node, _)| node.span);
        let message = format!("operand {operand}, of {from}, is drawn by no edge");
        found.error("G0210", &at(span), message);
    }
}
