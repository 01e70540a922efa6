//! The recurrence-constrained minimum initiation interval: the maximum cycle ratio of the
//! dependence graph, exactly.
//!
//! An interval `λ` can be kept if no cycle has `Σ delay − λ · Σ distance > 0`. Starting from a ratio
//! that is too low, a cycle that breaks it is found by Bellman and Ford's method and its own ratio
//! is tried next, until none is left (Dinkelbach's method on cycles: Dasdan, "Experimental analysis
//! of the fastest optimum cycle ratio and mean algorithms", 2004). All arithmetic is in integers.

use super::{Dfg, Node};
use petgraph::visit::EdgeRef;
use srp_archdesc::entity::Entity;

/// An edge inside a strongly connected component.
struct Edge {
    from: usize,
    to: usize,
    delay: i128,
    distance: i128,
}

/// The smallest interval that the recurrences allow, at least 1, and the nodes of a cycle that sets
/// it, each the producer of the next; no nodes where there is no cycle.
pub(super) fn rec_mii(dfg: &Dfg, latency: impl Fn(Node) -> u32) -> (u32, Vec<Node>) {
    let graph = dfg.graph();
    let latencies: Vec<u32> = dfg.nodes.keys().map(latency).collect();
    let mut best: Option<(i128, i128, Vec<usize>)> = None;
    for component in petgraph::algo::tarjan_scc(&graph) {
        let mut place = vec![usize::MAX; dfg.nodes.len()];
        for (i, node) in component.iter().enumerate() {
            place[node.index()] = i;
        }
        let mut edges = Vec::new();
        for from in &component {
            for e in graph.edges(*from) {
                if place[e.target().index()] != usize::MAX {
                    let (node, dep) = (graph[*from], *e.weight());
                    edges.push(Edge {
                        from: place[from.index()],
                        to: place[e.target().index()],
                        delay: dfg.delay(node, dep, latencies[node.index()]).into(),
                        distance: dep.distance.into(),
                    });
                }
            }
        }
        let ratio = best.as_ref().map_or((0, 1), |(p, q, _)| (*p, *q));
        if let Some((p, q, cycle)) = steepest_cycle(component.len(), &edges, ratio) {
            let nodes = cycle.iter().map(|i| component[*i].index()).collect();
            best = Some((p, q, nodes));
        }
    }
    match best {
        None => (1, Vec::new()),
        Some((delay, distance, nodes)) => {
            let ii = (delay + distance - 1) / distance;
            let ii = u32::try_from(ii).unwrap_or(u32::MAX).max(1);
            (ii, first_first(nodes))
        }
    }
}

/// The cycle as nodes, the lowest first.
fn first_first(mut nodes: Vec<usize>) -> Vec<Node> {
    let lowest = (0..nodes.len()).min_by_key(|i| nodes[*i]).unwrap_or(0);
    nodes.rotate_left(lowest);
    nodes.into_iter().map(Node::new).collect()
}

/// The cycle of the largest ratio above `ratio`, if any: its delay, its distance and its nodes.
fn steepest_cycle(
    nodes: usize,
    edges: &[Edge],
    mut ratio: (i128, i128),
) -> Option<(i128, i128, Vec<usize>)> {
    let mut best = None;
    while let Some(cycle) = positive_cycle(nodes, edges, ratio) {
        let delay: i128 = cycle.iter().map(|e| edges[*e].delay).sum();
        let distance: i128 = cycle.iter().map(|e| edges[*e].distance).sum();
        if distance == 0 {
            // Broken rules; no interval will do.
            return Some((i128::from(u32::MAX), 1, sources(&cycle, edges)));
        }
        ratio = (delay, distance);
        best = Some((delay, distance, sources(&cycle, edges)));
    }
    best
}

fn sources(cycle: &[usize], edges: &[Edge]) -> Vec<usize> {
    cycle.iter().map(|e| edges[*e].from).collect()
}

/// A cycle with `Σ delay · q > Σ distance · p`, as edges in order, for the ratio `p / q`.
fn positive_cycle(nodes: usize, edges: &[Edge], (p, q): (i128, i128)) -> Option<Vec<usize>> {
    let mut longest = vec![0i128; nodes];
    let mut via: Vec<Option<usize>> = vec![None; nodes];
    for _ in 0..nodes {
        let mut changed = false;
        for (i, e) in edges.iter().enumerate() {
            let through = longest[e.from] + e.delay * q - e.distance * p;
            if through > longest[e.to] {
                longest[e.to] = through;
                via[e.to] = Some(i);
                changed = true;
            }
        }
        if !changed {
            return None;
        }
        // A circle of predecessors is a cycle that is too steep.
        if let Some(cycle) = circle(&via, edges) {
            return Some(cycle);
        }
    }
    None
}

/// A circle in the graph of predecessors, as edges in order.
fn circle(via: &[Option<usize>], edges: &[Edge]) -> Option<Vec<usize>> {
    // The walk in which each node was first met.
    let mut walk = vec![usize::MAX; via.len()];
    for start in 0..via.len() {
        let mut at = start;
        while walk[at] == usize::MAX {
            walk[at] = start;
            match via[at] {
                Some(e) => at = edges[e].from,
                None => break,
            }
        }
        if walk[at] == start && via[at].is_some() {
            let mut cycle = Vec::new();
            let mut node = at;
            loop {
                let e = via[node].expect("on a circle");
                cycle.push(e);
                node = edges[e].from;
                if node == at {
                    cycle.reverse();
                    return Some(cycle);
                }
            }
        }
    }
    None
}
