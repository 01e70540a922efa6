//! The rules of a [`Dfg`], checked.

use super::{Dfg, Initial, Node, NodeData, Operand};
use crate::program::Pos;
use petgraph::graph::DiGraph;
use petgraph::visit::EdgeRef;
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Effect, Ty};

/// A rule that a graph breaks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// The node, if it is one node's fault.
    pub node: Option<Node>,
    /// Where the node comes from, or the loop.
    pub pos: Pos,
    /// The rule, and what was found.
    pub message: String,
}

impl std::fmt::Display for Violation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.node {
            Some(node) => write!(f, "{node}: {}", self.message),
            None => f.write_str(&self.message),
        }
    }
}

/// Lists all broken rules:
/// * there is a node; every operation may run on the array (no ports);
/// * each node has the operands that the opcode table asks for, in number and type, and no
///   immediate where the opcode has none;
/// * live-ins, nodes and initial values that are named exist, initial values have the type of the
///   value they stand in for;
/// * the trip count is a live-in word;
/// * orders are between memory accesses and from a node to itself only across iterations;
/// * live-outs have a result;
/// * within an iteration, no value or order leads in a circle.
///
/// Of a bare graph, operands need only exist, with initial values of their type, and orders may be
/// between any nodes.
pub(super) fn verify(dfg: &Dfg) -> Result<(), Vec<Violation>> {
    let mut check = Check {
        dfg,
        found: Vec::new(),
    };
    if dfg.nodes.is_empty() {
        check.graph("it has no nodes".to_owned());
    }
    if let Some(trip) = dfg.trip {
        match dfg.live_ins.get(trip as usize) {
            None => check.graph(format!("the trip count is live-in {trip}, which is none")),
            Some(l) if l.ty != Ty::Word => check.graph("the trip count is not a word".to_owned()),
            Some(_) => {}
        }
    }
    for (node, data) in dfg.nodes.iter() {
        check.node(node, data);
    }
    check.orders();
    for &node in &dfg.live_outs {
        match dfg.nodes.get(node) {
            None => check.graph(format!("live-out {node} does not exist")),
            Some(data) if data.op.result().is_none() => {
                check.at(node, "is a live-out but has no result".to_owned());
            }
            Some(_) => {}
        }
    }
    check.circles();
    if check.found.is_empty() {
        Ok(())
    } else {
        Err(check.found)
    }
}

struct Check<'a> {
    dfg: &'a Dfg,
    found: Vec<Violation>,
}

impl Check<'_> {
    fn graph(&mut self, message: String) {
        self.found.push(Violation {
            node: None,
            pos: self.dfg.pos,
            message,
        });
    }

    fn at(&mut self, node: Node, message: String) {
        self.found.push(Violation {
            node: Some(node),
            pos: self.dfg.nodes[node].pos,
            message,
        });
    }

    fn node(&mut self, node: Node, data: &NodeData) {
        let info = data.op.info();
        let (expected, found) = (info.operands.len(), data.operands.len());
        if expected != found && !self.dfg.is_bare() {
            self.at(
                node,
                format!("`{}` takes {expected} operands, not {found}", data.op),
            );
        }
        if info.effect == Effect::Io {
            self.at(node, format!("`{}` cannot run on the array", data.op));
        }
        if !info.immediate && data.imm != 0 {
            self.at(node, format!("`{}` has no immediate", data.op));
        }
        for (i, operand) in data.operands.iter().enumerate() {
            let ty = self.wanted(data, i);
            if let Err(what) = ty.map_or(Ok(()), |ty| self.operand(operand, ty)) {
                self.at(node, format!("operand {i}: {what}"));
            }
        }
    }

    /// The type that operand `i` must have: the table's, or in a bare graph the one it has.
    fn wanted(&self, data: &NodeData, i: usize) -> Option<Ty> {
        if self.dfg.is_bare() {
            let own = self.dfg.operand_ty(&data.operands[i]);
            return Some(own.unwrap_or(Ty::Word));
        }
        data.op.info().operands.get(i).map(|kind| kind.ty())
    }

    fn operand(&self, operand: &Operand, ty: Ty) -> Result<(), String> {
        match operand {
            Operand::Const(bits) => same(ty, bits.ty()),
            Operand::LiveIn(i) => self.live_in(*i, ty),
            Operand::Node { node, init } => {
                let Some(data) = self.dfg.nodes.get(*node) else {
                    return Err(format!("{node} does not exist"));
                };
                let Some(result) = data.op.result() else {
                    return Err(format!("{node} has no result"));
                };
                same(ty, result)?;
                init.iter().try_for_each(|initial| match initial {
                    Initial::Const(bits) => same(ty, bits.ty()),
                    Initial::LiveIn(i) => self.live_in(*i, ty),
                    Initial::Any => Ok(()),
                })
            }
        }
    }

    fn live_in(&self, i: u32, ty: Ty) -> Result<(), String> {
        match self.dfg.live_ins.get(i as usize) {
            Some(live_in) => same(ty, live_in.ty),
            None => Err(format!("live-in {i} does not exist")),
        }
    }

    fn orders(&mut self) {
        for order in &self.dfg.order {
            for end in [order.from, order.to] {
                match self.dfg.nodes.get(end) {
                    None => self.graph(format!("an order names {end}, which does not exist")),
                    Some(data) if data.op.space().is_none() && !self.dfg.is_bare() => {
                        self.at(end, "is in an order but accesses no memory".to_owned());
                    }
                    Some(_) => {}
                }
            }
        }
    }

    /// Circles of edges at distance 0.
    fn circles(&mut self) {
        let exists = |n: Node| n.index() < self.dfg.nodes.len();
        let mut graph = DiGraph::<Node, ()>::new();
        let index: Vec<_> = self.dfg.nodes.keys().map(|n| graph.add_node(n)).collect();
        for (from, to, dep) in self.dfg.deps() {
            if dep.distance == 0 && exists(from) && exists(to) {
                graph.add_edge(index[from.index()], index[to.index()], ());
            }
        }
        for component in petgraph::algo::tarjan_scc(&graph) {
            let alone = component.len() == 1;
            let to_itself = |n| graph.edges(n).any(|e| e.target() == n);
            if alone && !component.iter().any(|n| to_itself(*n)) {
                continue;
            }
            let mut nodes: Vec<Node> = component.iter().map(|n| graph[*n]).collect();
            nodes.sort();
            let list: Vec<String> = nodes.iter().map(Node::to_string).collect();
            let message = format!("depends on itself in one iteration: {}", list.join(", "));
            self.at(nodes[0], message);
        }
    }
}

fn same(expected: Ty, found: Ty) -> Result<(), String> {
    if expected == found {
        Ok(())
    } else {
        Err(format!("a `{expected}` is needed, this is a `{found}`"))
    }
}
