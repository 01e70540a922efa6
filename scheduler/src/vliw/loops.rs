//! Loop nesting, from which spill costs come.

use petgraph::algo::dominators;
use petgraph::graph::{DiGraph, NodeIndex};
use std::collections::BTreeMap;

/// How many natural loops are round each node of a flow graph of `count` nodes; `None` for nodes
/// that cannot be reached from `entry`.
pub(super) fn depths(
    count: usize,
    entry: usize,
    targets: impl Fn(usize) -> Vec<usize>,
) -> Vec<Option<u32>> {
    let mut graph = DiGraph::<(), ()>::with_capacity(count, 2 * count);
    for _ in 0..count {
        graph.add_node(());
    }
    for from in 0..count {
        for to in targets(from) {
            graph.add_edge(NodeIndex::new(from), NodeIndex::new(to), ());
        }
    }
    let dominators = dominators::simple_fast(&graph, NodeIndex::new(entry));
    let dominates = |a: NodeIndex, b| {
        dominators
            .dominators(b)
            .is_some_and(|mut above| above.any(|d| d == a))
    };
    let reachable = |n: NodeIndex| n.index() == entry || dominators.dominators(n).is_some();
    let mut loops: BTreeMap<NodeIndex, Vec<NodeIndex>> = BTreeMap::new();
    for edge in graph.edge_indices() {
        let (from, to) = graph.edge_endpoints(edge).expect("an edge has ends");
        if reachable(from) && dominates(to, from) {
            loops.entry(to).or_default().push(from);
        }
    }
    let mut depth: Vec<Option<u32>> = (0..count)
        .map(|n| reachable(NodeIndex::new(n)).then_some(0))
        .collect();
    for (header, latches) in loops {
        let mut inside = vec![false; count];
        inside[header.index()] = true;
        let mut work = latches;
        while let Some(node) = work.pop() {
            if !std::mem::replace(&mut inside[node.index()], true) {
                let before = graph.neighbors_directed(node, petgraph::Incoming);
                work.extend(before.filter(|&n| reachable(n)));
            }
        }
        for (depth, inside) in depth.iter_mut().zip(inside) {
            if let (Some(depth), true) = (depth, inside) {
                *depth += 1;
            }
        }
    }
    depth
}
