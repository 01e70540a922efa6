//! The order in which nodes are placed.
//!
//! Both orders put recurrences first, the tightest one first, because they have the least freedom.
//! *By height* then goes from sources to sinks along the critical path (Rau 1994); *swinging* goes
//! on with whatever touches the placed part and has the least slack (Llosa et al. 1996), which
//! keeps values short. Attempts alternate between them.

use super::noise::noise;
use super::problem::Problem;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_ir::dfg::Node;

/// Cycles by which a node is put forward at most.
const MOST_FORCED: u32 = 40;

/// Earliest and latest start of each node at one II if units and routes were free, relative to the
/// earliest start of all.
pub(super) struct Freedom {
    pub(super) earliest: EntityMap<Node, i32>,
    pub(super) latest: EntityMap<Node, i32>,
}

/// An edge of the constraint graph: `t(to) ≥ t(from) + weight`.
pub(super) struct Constraint {
    pub(super) from: Node,
    pub(super) to: Node,
    pub(super) weight: i32,
}

/// All constraints at an II.
pub(super) fn constraints(problem: &Problem<'_>, ii: u32) -> Vec<Constraint> {
    let ii = ii as i32;
    let values = problem.edges.iter().filter_map(|e| {
        let weight = problem.min_latency(e.from) as i32 - ii * e.distance as i32;
        Some(Constraint {
            from: e.from,
            to: e.to()?,
            weight,
        })
    });
    let orders = problem.orders.iter().map(|o| {
        let weight = o.delay as i32 - ii * o.distance as i32;
        Constraint {
            from: o.from,
            to: o.to,
            weight,
        }
    });
    values.chain(orders).collect()
}

impl Freedom {
    /// True if some node has no cycle.
    pub(super) fn is_empty(&self) -> bool {
        let mut bounds = self.earliest.values().zip(self.latest.values());
        bounds.any(|(earliest, latest)| earliest > latest)
    }

    /// Longest paths at `ii`, which must not be below the recurrence bound.
    pub(super) fn at(problem: &Problem<'_>, ii: u32) -> Freedom {
        let constraints = constraints(problem, ii);
        let count = problem.dfg.nodes.len();
        let mut earliest = EntityMap::filled(count, 0);
        for _ in 0..=count {
            let mut changed = false;
            for c in &constraints {
                let least: i32 = earliest[c.from] + c.weight;
                if earliest[c.to] < least {
                    earliest[c.to] = least;
                    changed = true;
                }
            }
            if !changed {
                break;
            }
        }
        let end = earliest.values().copied().max().unwrap_or(0);
        let mut latest = EntityMap::filled(count, end);
        for _ in 0..=count {
            let mut changed = false;
            for c in &constraints {
                let most: i32 = latest[c.to] - c.weight;
                if latest[c.from] > most {
                    latest[c.from] = most;
                    changed = true;
                }
            }
            if !changed {
                break;
            }
        }
        Freedom { earliest, latest }
    }
}

/// The order of placement for one attempt.
///
/// Nodes that were forced before come earlier, by one cycle for each time.
pub(super) fn order(
    problem: &Problem<'_>,
    freedom: &Freedom,
    attempt: u32,
    times_forced: &EntityMap<Node, u32>,
) -> Vec<Node> {
    let recurrence = recurrences(problem);
    let slack = |n: Node| freedom.latest[n] - freedom.earliest[n];
    let scarcity = |n: Node| problem.units[n].len();
    let jitter = |n: Node| {
        let jitter = noise(u64::from(attempt / 2), n.index() as u64, 1) % 3;
        jitter as i32 - times_forced[n].min(MOST_FORCED) as i32
    };
    let mut rest: Vec<Node> = problem.nodes().collect();
    if attempt.is_multiple_of(2) {
        rest.sort_by_key(|&n| (recurrence[n], freedom.latest[n] + jitter(n), scarcity(n), n));
        return rest;
    }
    let mut order: Vec<Node> = Vec::with_capacity(rest.len());
    let mut touched = EntityMap::filled(rest.len(), false);
    while !rest.is_empty() {
        let key = |&(_, &n): &(usize, &Node)| {
            let apart = !touched[n];
            (
                recurrence[n].min(u32::from(apart) + 1),
                apart,
                slack(n) + jitter(n),
                scarcity(n),
                n,
            )
        };
        let (index, &node) = rest
            .iter()
            .enumerate()
            .min_by_key(key)
            .expect("the loop runs while nodes are left");
        rest.remove(index);
        order.push(node);
        for &e in &problem.edges_of[node] {
            let edge = &problem.edges[e];
            touched[edge.from] = true;
            if let Some(to) = edge.to() {
                touched[to] = true;
            }
        }
    }
    order
}

/// 0 for nodes on a cycle of the dependence graph, 2 for others.
fn recurrences(problem: &Problem<'_>) -> EntityMap<Node, u32> {
    let graph = problem.dfg.graph();
    let mut on_cycle = EntityMap::filled(problem.dfg.nodes.len(), 2);
    for component in petgraph::algo::tarjan_scc(&graph) {
        let own = |i| graph.contains_edge(i, i);
        if component.len() > 1 || own(component[0]) {
            component.iter().for_each(|&i| on_cycle[graph[i]] = 0);
        }
    }
    on_cycle
}
