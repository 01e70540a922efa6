//! [`Dfg`]: one loop body as a dataflow graph, the form that the modulo scheduler places.

use crate::program::{Bits, Pos};
use petgraph::graph::DiGraph;
use serde::{Deserialize, Serialize};
use srp_archdesc::entity;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Effect, Opcode, Ty};
use std::collections::BTreeSet;

mod assumed;
mod dot;
mod recurrence;
mod run;
mod verify;

pub use assumed::Watched;
pub use dot::dot;
pub use run::run;
pub use verify::Violation;

entity! {
    /// An operation of a loop body.
    Node = "n";
}

/// How many iterations of a loop can be under way at once, at most.
pub const MAX_OVERLAP: u32 = 1 << 16;

/// A loop body. The loop runs a number of times that is known when it is entered, at least once;
/// there is no control flow inside.
///
/// Always holds: operands fit the opcode table; edges of distance 0 form no cycle; an operand at
/// distance `d` has `d` initial values, the value before iteration 0 first.
///
/// A graph without a trip count is *bare*: it can be scheduled but not launched. Only class and
/// result of its operations count. They take any number of operands, each of its producer's type,
/// and orders may be between any two of them. Graphs that come without a program are bare
/// ([`graph`](crate::graph)).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Dfg {
    /// The kernel's name.
    pub name: String,
    /// The loop statement.
    pub pos: Pos,
    /// Values that come from outside and do not change, by number. The launch brings them.
    pub live_ins: Vec<LiveIn>,
    /// The live-in word that holds the trip count; 0 stands for 2³². `None` in a bare graph.
    pub trip: Option<u32>,
    /// The operations, in source order.
    pub nodes: EntityMap<Node, NodeData>,
    /// Order between memory accesses that no value carries. Accesses that meet only after
    /// [`MAX_OVERLAP`] iterations or more are not listed.
    pub order: Vec<Order>,
    /// Statements of the source about accesses that could meet. Only those are in an order yet of which it
    /// is known how many iterations apart they meet.
    #[serde(default)]
    pub assumed: Vec<Assumed>,
    /// Values of the last iteration that the control code uses afterwards; the launch returns them
    /// in this order.
    pub live_outs: Vec<Node>,
}

impl Dfg {
    /// Returns the graph without its name and its places in sources: the parts that a schedule may
    /// depend on.
    pub fn anonymous(&self) -> Dfg {
        let Dfg {
            name: _,
            pos: _,
            live_ins,
            trip,
            nodes,
            order,
            assumed: _,
            live_outs,
        } = self.clone();
        let live_in = |live_in: LiveIn| LiveIn {
            pos: Pos::nowhere(),
            ..live_in
        };
        let node = |node: NodeData| NodeData {
            pos: Pos::nowhere(),
            ..node
        };
        Dfg {
            name: String::new(),
            pos: Pos::nowhere(),
            live_ins: live_ins.into_iter().map(live_in).collect(),
            trip,
            nodes: nodes.into_values().map(node).collect(),
            order,
            assumed: Vec::new(),
            live_outs,
        }
    }
}

/// A value that comes from outside the loop.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LiveIn {
    /// Its storage.
    pub ty: Ty,
    /// Where it is first used in the loop, for messages.
    pub pos: Pos,
}

/// One operation of a loop body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NodeData {
    /// The opcode.
    pub op: Opcode,
    /// Its operands, as the opcode table has them.
    pub operands: Vec<Operand>,
    /// The immediate, 0 where the opcode has none.
    pub imm: i32,
    /// Where it comes from.
    pub pos: Pos,
}

impl NodeData {
    /// The nodes that it takes its operands from, with the distances.
    pub fn producers(&self) -> impl Iterator<Item = (Node, u32)> + '_ {
        self.operands.iter().filter_map(Operand::producer)
    }
}

/// An operand of a node.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Operand {
    /// A constant.
    Const(Bits),
    /// A live-in value.
    LiveIn(u32),
    /// The result of `node` `init.len()` iterations ago.
    Node {
        /// The producer.
        node: Node,
        /// Values standing in for the iterations before the first: `init[k]` for the value of
        /// iteration `-1 - k`. Its length is the distance.
        init: Vec<Initial>,
    },
}

impl Operand {
    /// The producer and the distance, if it is a node.
    pub fn producer(&self) -> Option<(Node, u32)> {
        match self {
            Operand::Node { node, init } => Some((*node, init.len() as u32)),
            Operand::Const(_) | Operand::LiveIn(_) => None,
        }
    }
}

/// A value from before the first iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Initial {
    /// A constant.
    Const(Bits),
    /// A live-in value.
    LiveIn(u32),
    /// Nothing depends on it: whatever happens to be found will do, and no register has to be set.
    Any,
}

/// Two memory accesses, one of which writes at least, that the source says never to meet: not in
/// different iterations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Assumed {
    /// The one that comes first in the loop.
    pub first: Node,
    /// The other.
    pub second: Node,
    /// They do not meet in one iteration either.
    pub together: bool,
}

/// `to` of iteration `i + distance` must come after `from` of iteration `i`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Order {
    /// The earlier access.
    pub from: Node,
    /// The later access.
    pub to: Node,
    /// Iterations between them.
    pub distance: u32,
}

/// An edge of the dependence graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Dep {
    /// The kind of dependence.
    pub kind: DepKind,
    /// Iterations between producer and consumer.
    pub distance: u32,
}

/// Kinds of dependence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DepKind {
    /// The value of the source is this operand of the target.
    Operand(u32),
    /// A memory order.
    Order,
}

impl Dfg {
    /// All dependences: operands in node order, then memory order.
    pub fn deps(&self) -> impl Iterator<Item = (Node, Node, Dep)> + '_ {
        let operands = self.nodes.iter().flat_map(|(to, data)| {
            data.operands
                .iter()
                .enumerate()
                .filter_map(move |(i, operand)| {
                    let (from, distance) = operand.producer()?;
                    Some((
                        from,
                        to,
                        Dep {
                            kind: DepKind::Operand(i as u32),
                            distance,
                        },
                    ))
                })
        });
        let order = self.order.iter().map(|o| {
            (
                o.from,
                o.to,
                Dep {
                    kind: DepKind::Order,
                    distance: o.distance,
                },
            )
        });
        operands.chain(order)
    }

    /// The dependence graph; node indices are those of [`Node`].
    pub fn graph(&self) -> DiGraph<Node, Dep> {
        let mut graph = DiGraph::with_capacity(self.nodes.len(), 2 * self.nodes.len());
        let index: Vec<_> = self.nodes.keys().map(|n| graph.add_node(n)).collect();
        for (from, to, dep) in self.deps() {
            graph.add_edge(index[from.index()], index[to.index()], dep);
        }
        graph
    }

    /// Cycles that must pass from the issue of `from` to the issue of `to`, given the latency of
    /// `from`: the latency along an operand; along a memory order 1 after a store (it writes at the
    /// end of its cycle) and 0 after a load (it reads at the start of its cycle).
    pub fn delay(&self, from: Node, dep: Dep, latency: u32) -> u32 {
        match dep.kind {
            DepKind::Operand(_) => latency,
            DepKind::Order => match self.nodes[from].op.info().effect {
                Effect::Load => 0,
                Effect::Pure | Effect::Store | Effect::Prefetch | Effect::Io => 1,
            },
        }
    }

    /// Checks the invariants; returns all violations, if there are any.
    pub fn verify(&self) -> Result<(), Vec<Violation>> {
        verify::verify(self)
    }

    /// The smallest initiation interval that the recurrences allow, at least 1, and a cycle that
    /// sets it: each node depends on the one before, and the first on the last. No nodes if nothing
    /// depends on an earlier iteration. `latency` is that of each node's operation.
    ///
    /// Exact: the maximum over all cycles of [`delay`](Self::delay) over distance, rounded up.
    pub fn rec_mii(&self, latency: impl Fn(Node) -> u32) -> (u32, Vec<Node>) {
        recurrence::rec_mii(self, latency)
    }

    /// The nodes in an order in which each comes after those it depends on in its own iteration:
    /// their own order wherever that is one. Nodes in a circle are left out.
    pub fn topological(&self) -> Vec<Node> {
        let mut waits_for = EntityMap::filled(self.nodes.len(), 0u32);
        let mut leads_to = EntityMap::filled(self.nodes.len(), Vec::new());
        for (from, to, dep) in self.deps() {
            if dep.distance == 0 {
                waits_for[to] += 1;
                leads_to[from].push(to);
            }
        }
        let free = self.nodes.keys().filter(|n| waits_for[*n] == 0);
        let mut free: BTreeSet<Node> = free.collect();
        let mut order = Vec::with_capacity(self.nodes.len());
        while let Some(node) = free.pop_first() {
            order.push(node);
            for &to in &leads_to[node] {
                waits_for[to] -= 1;
                if waits_for[to] == 0 {
                    free.insert(to);
                }
            }
        }
        order
    }

    /// True if the trip count is unknown, so that only dependences matter.
    pub fn is_bare(&self) -> bool {
        self.trip.is_none()
    }

    /// Returns the type of an operand; `None` if it names nothing.
    pub fn operand_ty(&self, operand: &Operand) -> Option<Ty> {
        match operand {
            Operand::Const(bits) => Some(bits.ty()),
            Operand::LiveIn(i) => self.live_ins.get(*i as usize).map(|l| l.ty),
            Operand::Node { node, .. } => self.nodes.get(*node)?.op.result(),
        }
    }

    /// The storage of a node's result.
    pub fn ty(&self, node: Node) -> Option<Ty> {
        self.nodes[node].op.result()
    }
}
