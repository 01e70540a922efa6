//! Graphs in the language of Graphviz.

mod lex;
mod tree;
mod typed;

pub(super) use tree::{Attributes, DotEdge, DotNode, Tree};

use super::raw::{Lines, Raw, RawEdge, shortened};
use super::{At, Found, Graph, MAX_EDGES, MAX_NODES, Options, names};
use crate::program::SourceFile;
use srp_archdesc::diagnostic::{Source, Span};
use srp_archdesc::entity::Entity;

pub(super) fn read(source: &Source, options: &Options, found: &mut Found) -> Option<Graph> {
    let file = &source.name;
    let tree = match tree::parse(&source.text) {
        Ok(tree) => tree,
        Err((code, span, message)) => {
            found.error(code, &At { file, span }, message);
            return None;
        }
    };
    if typed::is_loop(&tree) && tree.nodes.len() <= MAX_NODES && tree.edges.len() <= MAX_EDGES {
        return typed::read(source, &tree, found);
    }
    let lines = || Lines::of(source, SourceFile::new(0));
    let name = tree.name.as_deref().filter(|name| !name.is_empty());
    let mut raw = Raw::new(name.unwrap_or(super::stem(file)), lines(), lines());
    for node in &tree.nodes {
        let number = raw.node(&node.name, node.span, !node.stated, found)?;
        if let Some((op, span)) = operation(&node.attributes) {
            raw.set_op(number, &op, span);
        }
    }
    for edge in &tree.edges {
        let number = |name: &str, raw: &mut Raw<'_>, found: &mut Found| {
            raw.node(name, edge.span, true, found)
        };
        let order = is_order(edge, file, found);
        let edge = RawEdge {
            from: number(&edge.from, &mut raw, found)?,
            to: number(&edge.to, &mut raw, found)?,
            operand: operand(edge),
            distance: count(edge, &["distance", "dist"], file, found).unwrap_or(0),
            latency: count(edge, &["latency"], file, found),
            order,
            span: edge.span,
        };
        raw.edge(edge, found);
    }
    raw.build(options, found)
}

/// Returns a node's operation and its span: from an attribute, or a word of the label.
fn operation(attributes: &Attributes) -> Option<(String, Span)> {
    let said = ["op", "opcode", "operation"];
    if let Some((op, span)) = said.iter().find_map(|name| attributes.get(*name)) {
        return Some((op.trim().to_owned(), *span));
    }
    let (label, span) = attributes.get("label")?;
    let label = label
        .replace("\\n", " ")
        .replace("\\l", " ")
        .replace("\\r", " ");
    let part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '.');
    let words = || label.split(|c| !part(c)).filter(|word| !word.is_empty());
    // A number behind an operation tells nodes apart: add_12, mul3.
    let bare = |word: &str| {
        let word = word.trim_end_matches(|c: char| c.is_ascii_digit() || c == '_');
        word.to_owned()
    };
    let known = |word: &str| names::opcode(word).is_some();
    let exact = words().find(|word| known(word)).map(str::to_owned);
    let numbered = || words().map(bare).find(|word| known(word));
    let any = || words().next().map(str::to_owned);
    let op = exact.or_else(numbered).or_else(any)?;
    Some((op, *span))
}

/// The operand that an edge brings, if it says which.
fn operand(edge: &DotEdge) -> Option<u32> {
    let (text, _) = edge.attributes.get("operand")?;
    match text.as_str() {
        // As CGRA-ME has them.
        "LHS" => Some(0),
        "RHS" => Some(1),
        other => other.parse().ok(),
    }
}

/// True if an edge only orders its ends.
fn is_order(edge: &DotEdge, file: &str, found: &mut Found) -> bool {
    match edge.attributes.get("kind") {
        Some((kind, _)) if kind == "order" => true,
        Some((kind, span)) if kind != "value" => {
            let message = format!("`{}` is neither `value` nor `order`", shortened(kind));
            found.error("G0107", &At { file, span: *span }, message);
            false
        }
        _ => false,
    }
}

/// The number in an attribute that may have several names.
fn count(edge: &DotEdge, names: &[&str], file: &str, found: &mut Found) -> Option<u32> {
    let (text, span) = names.iter().find_map(|name| edge.attributes.get(*name))?;
    let number = text.parse().ok();
    if number.is_none() {
        let message = format!("`{}` is not a number below 2^32", shortened(text));
        found.error("G0105", &At { file, span: *span }, message);
    }
    number
}
