//! Lists of edges and of operations: a line each, words between blanks, `#` before comments.

use super::raw::{Lines, Raw, RawEdge, shortened};
use super::{Found, Graph, Options};
use crate::program::SourceFile;
use srp_archdesc::diagnostic::{Source, Span};
use srp_archdesc::entity::Entity;

pub(super) fn read(
    edges: &Source,
    ops: &Source,
    options: &Options,
    found: &mut Found,
) -> Option<Graph> {
    let name = super::stem(&edges.name);
    let node_file = Lines::of(ops, SourceFile::new(0));
    let edge_file = Lines::of(edges, SourceFile::new(1));
    let mut raw = Raw::new(name, node_file, edge_file);
    for line in lines(&ops.text) {
        let [(node, at), (op, op_at)] = line[..] else {
            let message = "expected a node and its operation";
            found.error("G0103", &raw.node_file.at(all(&line)), message);
            continue;
        };
        let Some(number) = raw.node(node, at, false, found) else {
            break;
        };
        if let Some(first) = raw.op_of(number) {
            let message = format!("the operation of node `{}` again", shortened(node));
            let mistake = raw.node_file.at(at).error("G0104", message);
            found.push(mistake.also(first, "the first"));
            continue;
        }
        raw.set_op(number, op, op_at);
    }
    for line in lines(&edges.text) {
        if !read_edge(&mut raw, &line, found) {
            break;
        }
    }
    raw.build(options, found)
}

/// A word and where it stands.
type Word<'a> = (&'a str, Span);

/// Reads an edge; false where a limit is passed.
fn read_edge(raw: &mut Raw<'_>, line: &[Word<'_>], found: &mut Found) -> bool {
    if !(2..=4).contains(&line.len()) {
        let message = "expected `source target distance latency`, the last two if need be";
        found.error("G0103", &raw.edge_file.at(all(line)), message);
        return true;
    }
    let mut numbers = [None; 2];
    for (number, (word, span)) in numbers.iter_mut().zip(&line[2..]) {
        *number = word.parse().ok();
        if number.is_none() {
            let message = format!("`{}` is not a number below 2^32", shortened(word));
            found.error("G0105", &raw.edge_file.at(*span), message);
        }
    }
    let (from, to) = (line[0], line[1]);
    let Some(from) = raw.node(from.0, from.1, true, found) else {
        return false;
    };
    let Some(to) = raw.node(to.0, to.1, true, found) else {
        return false;
    };
    let edge = RawEdge {
        from,
        to,
        operand: None,
        distance: numbers[0].unwrap_or(0),
        latency: numbers[1],
        order: false,
        span: all(line),
    };
    raw.edge(edge, found);
    true
}

/// From the first word of a line to its last.
fn all(line: &[Word<'_>]) -> Span {
    line[0].1.to(line[line.len() - 1].1)
}

/// The words of each line that has some.
fn lines(text: &str) -> impl Iterator<Item = Vec<Word<'_>>> {
    let word = |word: &'_ str, text: &str| {
        let start = (word.as_ptr() as usize - text.as_ptr() as usize) as u32;
        Span::new(start, start + word.len() as u32)
    };
    text.lines()
        .map(move |line| {
            let said = line.split('#').next().unwrap_or_default();
            let words = said.split_whitespace();
            words.map(|w| (w, word(w, text))).collect::<Vec<_>>()
        })
        .filter(|words| !words.is_empty())
}
