//! A graph as its file has it, and its conversion.

use super::{At, Found, Graph, MAX_DISTANCE, MAX_EDGES, MAX_NODES, MAX_OPERANDS, Options, names};
use crate::dfg::{Dfg, Initial, Node, NodeData, Operand, Order};
use crate::program::{Pos, SourceFile};
use srp_archdesc::diagnostic::{Source, Span};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Effect, Opcode};
use srp_archdesc::nearest::nearest;
use std::collections::BTreeMap;

/// A graph by names.
pub(super) struct Raw<'a> {
    /// The graph's name.
    pub(super) name: String,
    /// Where nodes are listed.
    pub(super) node_file: Lines<'a>,
    /// Where edges are listed; may be the same.
    pub(super) edge_file: Lines<'a>,
    nodes: EntityMap<Node, RawNode>,
    by_name: BTreeMap<String, Node>,
    edges: Vec<RawEdge>,
    /// True if a limit was passed and reported.
    full: bool,
}

/// A text whose offsets become lines and columns.
pub(super) struct Lines<'a> {
    pub(super) source: &'a Source,
    file: SourceFile,
    /// Where each line starts.
    starts: Vec<u32>,
}

impl<'a> Lines<'a> {
    pub(super) fn of(source: &'a Source, file: SourceFile) -> Lines<'a> {
        let breaks = source.text.bytes().enumerate().filter(|(_, b)| *b == b'\n');
        let starts = breaks.map(|(i, _)| i as u32 + 1);
        Lines {
            source,
            file,
            starts: std::iter::once(0).chain(starts).collect(),
        }
    }

    fn pos(&self, span: Span) -> Pos {
        let line = self.starts.partition_point(|start| *start <= span.start);
        let start = self.starts[line - 1] as usize;
        let before = &self.source.text[start..span.start as usize];
        Pos {
            file: self.file,
            line: line as u32,
            column: 1 + before.chars().count() as u32,
        }
    }

    pub(super) fn at(&self, span: Span) -> At<'a> {
        At {
            file: &self.source.name,
            span,
        }
    }
}

struct RawNode {
    name: String,
    /// Where it is first named.
    span: Span,
    /// True if `span` lies in the list of edges.
    in_edge: bool,
    op: Option<(String, Span)>,
}

/// An edge by the numbers of its ends.
pub(super) struct RawEdge {
    pub(super) from: Node,
    pub(super) to: Node,
    pub(super) operand: Option<u32>,
    pub(super) distance: u32,
    pub(super) latency: Option<u32>,
    /// True if it only orders its ends and carries no value.
    pub(super) order: bool,
    pub(super) span: Span,
}

impl<'a> Raw<'a> {
    pub(super) fn new(name: &str, node_file: Lines<'a>, edge_file: Lines<'a>) -> Raw<'a> {
        Raw {
            name: name.to_owned(),
            node_file,
            edge_file,
            nodes: EntityMap::new(),
            by_name: BTreeMap::new(),
            edges: Vec::new(),
            full: false,
        }
    }

    /// The node of this name, new where it was not named before; `None` beyond the limit.
    pub(super) fn node(
        &mut self,
        name: &str,
        span: Span,
        in_edge: bool,
        found: &mut Found,
    ) -> Option<Node> {
        if let Some(&node) = self.by_name.get(name) {
            return Some(node);
        }
        if self.nodes.len() == MAX_NODES {
            if !self.full {
                self.full = true;
                let file = if in_edge {
                    &self.edge_file
                } else {
                    &self.node_file
                };
                let message = format!("the graph has more than {MAX_NODES} nodes");
                found.error("G0201", &file.at(span), message);
            }
            return None;
        }
        let node = self.nodes.push(RawNode {
            name: name.to_owned(),
            span,
            in_edge,
            op: None,
        });
        self.by_name.insert(name.to_owned(), node);
        Some(node)
    }

    /// Sets the operation of a node.
    pub(super) fn set_op(&mut self, node: Node, op: &str, span: Span) {
        let raw = &mut self.nodes[node];
        if raw.in_edge {
            (raw.span, raw.in_edge) = (span, false);
        }
        raw.op = Some((op.to_owned(), span));
    }

    /// Where a node's operation is said, if it is.
    pub(super) fn op_of(&self, node: Node) -> Option<Span> {
        self.nodes[node].op.as_ref().map(|(_, span)| *span)
    }

    pub(super) fn edge(&mut self, edge: RawEdge, found: &mut Found) {
        if self.edges.len() == MAX_EDGES {
            if !self.full {
                self.full = true;
                let message = format!("the graph has more than {MAX_EDGES} edges");
                found.error("G0202", &self.edge_file.at(edge.span), message);
            }
            return;
        }
        if edge.distance > MAX_DISTANCE && !edge.order {
            let message = format!(
                "a distance of {} iterations; values are carried over {MAX_DISTANCE} at most",
                edge.distance
            );
            found.error("G0203", &self.edge_file.at(edge.span), message);
            return;
        }
        self.edges.push(edge);
    }

    fn name_of(&self, node: Node) -> &str {
        &self.nodes[node].name
    }

    /// Where a node stands.
    fn at(&self, node: Node) -> At<'a> {
        let raw = &self.nodes[node];
        let file = if raw.in_edge {
            &self.edge_file
        } else {
            &self.node_file
        };
        file.at(raw.span)
    }

    /// The graph of operations, if it is one.
    pub(super) fn build(mut self, options: &Options, found: &mut Found) -> Option<Graph> {
        if self.nodes.is_empty() {
            let message = "the graph has no nodes";
            found.error("G0204", &self.node_file.at(Span::point(0)), message);
            return None;
        }
        let ops = self.opcodes(options, found);
        let carried = self.carry();
        self.refuse_cycle(found);
        let (operands, order) = self.operands(found);
        let mut data = EntityMap::new();
        for ((op, operands), raw) in ops.zip(operands).zip(self.nodes.values()) {
            let file = if raw.in_edge {
                &self.edge_file
            } else {
                &self.node_file
            };
            data.push(NodeData {
                op,
                operands,
                imm: 0,
                pos: file.pos(raw.span),
            });
        }
        let mut latencies: Vec<(Node, u32)> = (self.edges.iter())
            .filter_map(|e| Some((e.from, e.latency?)))
            .collect();
        latencies.sort();
        latencies.dedup();
        let mut files = EntityMap::new();
        files.push(self.node_file.source.name.clone());
        if self.edge_file.file != self.node_file.file {
            files.push(self.edge_file.source.name.clone());
        }
        Some(Graph {
            dfg: Dfg {
                name: self.name.clone(),
                pos: self.node_file.pos(Span::point(0)),
                live_ins: Vec::new(),
                trip: None,
                nodes: data,
                order,
                assumed: Vec::new(),
                live_outs: Vec::new(),
            },
            files,
            names: self.nodes.values().map(|n| n.name.clone()).collect(),
            latencies,
            carried,
        })
    }

    /// Gives edges from a node to itself the distance 1 if they have none: no other can be meant.
    /// Returns the nodes with these edges.
    fn carry(&mut self) -> Vec<Node> {
        let mut carried = Vec::new();
        for edge in &mut self.edges {
            if edge.from == edge.to && edge.distance == 0 {
                edge.distance = 1;
                carried.push(edge.from);
            }
        }
        carried.sort();
        carried.dedup();
        carried
    }

    /// Returns the opcode of each node. A store that passes a value on becomes a load, which takes
    /// the same ports and has a result.
    fn opcodes(
        &self,
        options: &Options,
        found: &mut Found,
    ) -> impl Iterator<Item = Opcode> + use<> {
        let mut passes_on = EntityMap::filled(self.nodes.len(), false);
        for edge in self.edges.iter().filter(|e| !e.order) {
            passes_on[edge.from] = true;
        }
        let mut ops = Vec::with_capacity(self.nodes.len());
        for (node, raw) in self.nodes.iter() {
            let op = match &raw.op {
                Some((name, span)) => self.opcode(name, *span, options, found),
                None => {
                    let message = format!("node `{}` has no operation", raw.name);
                    found.error("G0205", &self.at(node), message);
                    None
                }
            };
            ops.push(match op.unwrap_or(Opcode::Mov) {
                op if passes_on[node] && op.info().effect == Effect::Store => passing(op),
                op => op,
            });
        }
        ops.into_iter()
    }

    fn opcode(
        &self,
        name: &str,
        span: Span,
        options: &Options,
        found: &mut Found,
    ) -> Option<Opcode> {
        let any = || options.any_op.and_then(names::stands_for);
        let op = names::opcode(name).or_else(any);
        if op.is_none() {
            let message = format!("there is no operation `{}`", shortened(name));
            let mistake = self.node_file.at(span).error("G0206", message);
            let near = nearest(name, names::known());
            let help = near.map_or(String::new(), |near| format!("did you mean `{near}`? "));
            let help = format!("{help}`--any-op CLASS` says how to treat unknown operations");
            found.push(mistake.help(help));
        }
        op
    }

    /// The operands of each node, in order, and the orders.
    fn operands(&self, found: &mut Found) -> (Vec<Vec<Operand>>, Vec<Order>) {
        let mut inputs: EntityMap<Node, Vec<&RawEdge>> =
            EntityMap::filled(self.nodes.len(), Vec::new());
        let mut order = Vec::new();
        for edge in &self.edges {
            if edge.order {
                order.push(Order {
                    from: edge.from,
                    to: edge.to,
                    distance: edge.distance,
                });
            } else {
                inputs[edge.to].push(edge);
            }
        }
        let mut all = Vec::with_capacity(self.nodes.len());
        for (to, edges) in inputs.iter() {
            if edges.len() > MAX_OPERANDS {
                let name = self.name_of(to);
                let message = format!("node `{name}` has more than {MAX_OPERANDS} operands");
                found.error("G0207", &self.at(to), message);
            }
            all.push(self.in_order(to, edges, found));
        }
        (all, order)
    }

    /// The operands that edges bring: those with a number in its place, the others where there is
    /// room, as they come.
    fn in_order(&self, to: Node, edges: &[&RawEdge], found: &mut Found) -> Vec<Operand> {
        let mut places: BTreeMap<u32, &RawEdge> = BTreeMap::new();
        for edge in edges {
            let Some(operand) = edge.operand else {
                continue;
            };
            if let Some(first) = places.insert(operand, edge) {
                let message = format!("a second operand {operand} of `{}`", self.name_of(to));
                let mistake = self.edge_file.at(edge.span).error("G0208", message);
                found.push(mistake.also(first.span, "the first"));
            }
        }
        let mut next = 0;
        for edge in edges.iter().filter(|e| e.operand.is_none()) {
            while places.contains_key(&next) {
                next += 1;
            }
            places.insert(next, edge);
        }
        let operand = |edge: &RawEdge| Operand::Node {
            node: edge.from,
            init: vec![Initial::Any; edge.distance as usize],
        };
        places.values().map(|edge| operand(edge)).collect()
    }

    /// Reports a cycle of distance 0, if there is one: a node that waits for itself.
    fn refuse_cycle(&self, found: &mut Found) {
        let mut waits_for = EntityMap::filled(self.nodes.len(), 0u32);
        let mut leaving: EntityMap<Node, Vec<usize>> =
            EntityMap::filled(self.nodes.len(), Vec::new());
        for (i, edge) in self.edges.iter().enumerate() {
            if edge.distance == 0 {
                waits_for[edge.to] += 1;
                leaving[edge.from].push(i);
            }
        }
        let mut free: Vec<Node> = self.nodes.keys().filter(|n| waits_for[*n] == 0).collect();
        while let Some(node) = free.pop() {
            for &edge in &leaving[node] {
                let to = self.edges[edge].to;
                waits_for[to] -= 1;
                if waits_for[to] == 0 {
                    free.push(to);
                }
            }
        }
        // Each node that still waits has an edge from another that does: back along these.
        let Some(start) = self.nodes.keys().find(|n| waits_for[*n] > 0) else {
            return;
        };
        let mut came_by: EntityMap<Node, Option<usize>> = EntityMap::filled(self.nodes.len(), None);
        for (i, edge) in self.edges.iter().enumerate() {
            if edge.distance == 0 && waits_for[edge.from] > 0 && waits_for[edge.to] > 0 {
                came_by[edge.to] = Some(i);
            }
        }
        let before = |node: Node| came_by[node].map_or(node, |e| self.edges[e].from);
        let mut on_cycle = start;
        for _ in 0..self.nodes.len() {
            on_cycle = before(on_cycle);
        }
        let mut cycle = vec![on_cycle];
        while before(cycle[cycle.len() - 1]) != on_cycle {
            cycle.push(before(cycle[cycle.len() - 1]));
        }
        cycle.reverse();
        self.report_cycle(&cycle, came_by[cycle[0]].unwrap_or(0), found);
    }

    fn report_cycle(&self, cycle: &[Node], edge: usize, found: &mut Found) {
        const SHOWN: usize = 12;
        let mut names: Vec<&str> = cycle.iter().map(|n| self.name_of(*n)).collect();
        if names.len() > SHOWN {
            names.truncate(SHOWN);
            names.push("…");
        }
        names.push(self.name_of(cycle[0]));
        let message = format!("a cycle within one iteration: {}", names.join(" → "));
        let mistake = self
            .edge_file
            .at(self.edges[edge].span)
            .error("G0209", message);
        found.push(mistake.help("one of its edges needs a distance of at least 1"));
    }
}

/// The load of the memory that a store goes to.
fn passing(store: Opcode) -> Opcode {
    let load = |op: &&Opcode| {
        op.info().effect == Effect::Load
            && op.space() == store.space()
            && op.access_bytes() == store.access_bytes()
    };
    *Opcode::ALL
        .iter()
        .find(load)
        .expect("every store has a load of its size")
}

/// The start of a name that may be long.
pub(super) fn shortened(name: &str) -> String {
    const SHOWN: usize = 64;
    match name.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name.to_owned(),
    }
}
