//! Facts about a loop that hold in schedules of any length: the issue slots that moves find, the node that starts
//! the clock, and how far apart nodes of a recurrence are.

use crate::modulo::order::constraints;
use crate::modulo::problem::Problem;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::Ty;
use srp_ir::dfg::Node;
use std::collections::{BTreeMap, BTreeSet};

/// The moves for which issue slots are left when every operation has its own.
pub(super) fn spare(problem: &Problem<'_>, ii: u32) -> u32 {
    let interval = |node: Node| {
        let units = problem.units[node].iter();
        let intervals = units.map(|&fu| problem.timing(node, fu).interval);
        intervals.min().unwrap_or(0)
    };
    let taken: u32 = problem.nodes().map(interval).sum();
    let moves = problem.srp.fus.keys().flat_map(|fu| {
        let of_type = move |&ty: &Ty| Some(problem.move_timing(fu, ty)?.interval);
        Ty::ALL.iter().filter_map(of_type)
    });
    let slots = problem.srp.fus.len() as u32 * ii;
    match moves.min() {
        Some(interval) => slots.saturating_sub(taken) / interval.max(1),
        None => 0,
    }
}

/// The node whose issue is cycle 0 of the clock: the one of the most values, the first of these.
pub(super) fn anchor(problem: &Problem<'_>) -> Option<Node> {
    let mut ends = EntityMap::filled(problem.dfg.nodes.len(), 0u32);
    for edge in &problem.edges {
        ends[edge.from] += 1;
        if let Some(to) = edge.to() {
            ends[to] += 1;
        }
    }
    problem
        .nodes()
        .max_by_key(|&node| (ends[node], std::cmp::Reverse(node)))
}

/// How many cycles the second node is issued after the first, at least and at most: of any two nodes of one
/// recurrence of which one depends on the other at once.
pub(super) fn windows(problem: &Problem<'_>, ii: u32) -> BTreeMap<(Node, Node), (i64, i64)> {
    let mut windows = BTreeMap::new();
    let all = constraints(problem, ii);
    let graph = problem.dfg.graph();
    for component in petgraph::algo::tarjan_scc(&graph) {
        let nodes: BTreeSet<Node> = component.iter().map(|&i| graph[i]).collect();
        let within = |from: Node, to: Node| nodes.contains(&from) && nodes.contains(&to);
        let inner: Vec<(Node, Node, i64)> = (all.iter())
            .filter(|c| c.from != c.to && within(c.from, c.to))
            .map(|c| (c.from, c.to, i64::from(c.weight)))
            .collect();
        let mut longest: BTreeMap<Node, BTreeMap<Node, i64>> = BTreeMap::new();
        for &node in &nodes {
            longest.insert(node, longest_from(node, nodes.len(), &inner));
        }
        for &(from, to, _) in &inner {
            let (there, back) = (longest[&from][&to], longest[&to][&from]);
            windows.insert((from, to), (there, -back));
            windows.insert((to, from), (back, -there));
        }
    }
    windows
}

/// The longest paths from a node to each of a component of so many; there is no cycle of positive weight.
fn longest_from(
    node: Node,
    count: usize,
    constraints: &[(Node, Node, i64)],
) -> BTreeMap<Node, i64> {
    let mut longest = BTreeMap::from([(node, 0)]);
    for _ in 0..count {
        for &(from, to, weight) in constraints {
            let Some(&reached) = longest.get(&from) else {
                continue;
            };
            let most = longest.entry(to).or_insert(reached + weight);
            *most = (reached + weight).max(*most);
        }
    }
    debug_assert_eq!(longest[&node], 0, "node {}", node.index());
    longest
}
