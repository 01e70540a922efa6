//! Dataflow graphs from elsewhere: loop bodies without a program, as other mappers exchange them.
//!
//! Three forms are read, all of them into a bare [`Dfg`] (`docs/graphs.md` is their reference):
//! [Graphviz](read_dot), [JSON](read_json), and [lists of edges and operations](read_edges). A graph
//! that [`dfg::dot`](crate::dfg::dot()) wrote reads back to the very loop that it was.
//!
//! Each reader reports all that it finds. What the forms share is in [`raw`]: names become nodes,
//! operations opcodes ([`names`]), and edges operands in their order.
//!
//! Values of a bare graph are words, or vectors where our vector opcodes are named. First values of
//! loop-carried operands are [`Initial::Any`](crate::dfg::Initial::Any).

mod dot;
mod edges;
mod json;
mod names;
mod raw;

pub use names::{Aliases, aliases, stands_for};

use crate::dfg::{Dfg, Node};
use crate::program::SourceFile;
use srp_archdesc::Diagnostic;
use srp_archdesc::diagnostic::{Source, Span};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Class;

/// Most nodes of a graph.
pub const MAX_NODES: usize = 4096;
/// Most edges of a graph.
pub const MAX_EDGES: usize = 32_768;
/// Most operands of one node.
pub const MAX_OPERANDS: usize = 64;
/// Largest distance of an edge that carries a value, in iterations.
pub const MAX_DISTANCE: u32 = 1024;
/// Longest file in bytes.
pub const MAX_BYTES: usize = 16 << 20;
/// Most mistakes that are listed.
const MAX_MISTAKES: usize = 20;

/// How to read the parts that a graph leaves open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The class of operations with unknown names; `None` makes them errors.
    pub any_op: Option<Class>,
}

/// A graph, and the other contents of its file.
#[derive(Clone, Debug, PartialEq)]
pub struct Graph {
    /// The loop body. Positions are those in the graph's own files, unless these name others.
    pub dfg: Dfg,
    /// Files that positions name.
    pub files: EntityMap<SourceFile, String>,
    /// The name of each node in the file.
    pub names: EntityMap<Node, String>,
    /// Edges with a latency of their own: the producer, and the cycles. The machine's latencies hold;
    /// these are for whoever wants to compare.
    pub latencies: Vec<(Node, u32)>,
    /// Nodes with an edge to themselves that had no distance: it is taken to be 1.
    pub carried: Vec<Node>,
}

/// Errors in a file: at least one diagnostic, at most 21.
pub type Mistakes = Vec<Diagnostic>;

/// Reads a graph in the language of Graphviz.
///
/// # Errors
///
/// `G01xx`: the text is not of this form; `G02xx`: its content is no graph of operations.
pub fn read_dot(source: &Source, options: &Options) -> Result<Graph, Mistakes> {
    let mut found = Found::of(source)?;
    let graph = dot::read(source, options, &mut found);
    found.result(graph)
}

/// Reads a graph in JSON. Errors are those of [`read_dot`].
pub fn read_json(source: &Source, options: &Options) -> Result<Graph, Mistakes> {
    let mut found = Found::of(source)?;
    let graph = json::read(source, options, &mut found);
    found.result(graph)
}

/// Reads a list of edges, `source target [distance [latency]]` a line, and the operations of its
/// nodes, `node operation` a line. Errors are those of [`read_dot`].
pub fn read_edges(edges: &Source, ops: &Source, options: &Options) -> Result<Graph, Mistakes> {
    let mut found = Found::of(edges)?;
    Found::of(ops)?;
    let graph = edges::read(edges, ops, options, &mut found);
    found.result(graph)
}

/// The mistakes of a file as they are found.
struct Found {
    list: Vec<Diagnostic>,
    /// Mistakes that are not listed.
    more: usize,
}

impl Found {
    /// Nothing yet, about a file that is not too long.
    fn of(source: &Source) -> Result<Found, Mistakes> {
        if source.text.len() > MAX_BYTES {
            let message = format!("the file is longer than {} MiB", MAX_BYTES >> 20);
            return Err(vec![Diagnostic::error("G0101", &source.name, message)]);
        }
        Ok(Found {
            list: Vec::new(),
            more: 0,
        })
    }

    fn push(&mut self, diagnostic: Diagnostic) {
        if self.list.len() < MAX_MISTAKES {
            self.list.push(diagnostic);
        } else {
            self.more += 1;
        }
    }

    /// Reports a mistake at a place.
    fn error(&mut self, code: &'static str, at: &At<'_>, message: impl Into<String>) {
        self.push(at.error(code, message));
    }

    fn result(mut self, graph: Option<Graph>) -> Result<Graph, Mistakes> {
        if self.more > 0 {
            let (file, more) = (self.list[0].file.clone(), self.more);
            let message = format!("{more} more mistakes are not listed");
            self.list.push(Diagnostic::error("G0102", &file, message));
        }
        match graph {
            Some(graph) if self.list.is_empty() => Ok(graph),
            _ => Err(self.list),
        }
    }
}

/// The name of a file without folders and endings.
fn stem(path: &str) -> &str {
    let name = path.rsplit(['/', '\\']).next().unwrap_or(path);
    match name.split_once('.') {
        Some((stem, _)) if !stem.is_empty() => stem,
        _ => name,
    }
}

/// A place in a file, for messages.
struct At<'a> {
    file: &'a str,
    span: Span,
}

impl At<'_> {
    fn error(&self, code: &'static str, message: impl Into<String>) -> Diagnostic {
        Diagnostic::error(code, self.file, message).at(self.span, "")
    }
}
