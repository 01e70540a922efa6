//! When nodes are looked for first: as early as their operands allow, with room for moves.

use crate::modulo::problem::Problem;
use srp_archdesc::entity::EntityMap;
use srp_ir::dfg::Node;

/// A cycle for each node: each value has `room` cycles more than it needs, but on recurrences, which
/// have none to spare.
pub(super) fn times(problem: &Problem<'_>, ii: u32, room: i32) -> EntityMap<Node, i32> {
    let graph = problem.dfg.graph();
    let mut component = EntityMap::filled(problem.dfg.nodes.len(), 0);
    for (i, nodes) in petgraph::algo::tarjan_scc(&graph).iter().enumerate() {
        nodes.iter().for_each(|&n| component[graph[n]] = i);
    }
    let ii = ii as i32;
    let values = problem.edges.iter().filter_map(|e| {
        let to = e.to()?;
        let room = if component[e.from] == component[to] {
            0
        } else {
            room
        };
        let weight = problem.min_latency(e.from) as i32 + room - ii * e.distance as i32;
        Some((e.from, to, weight))
    });
    let orders = problem.orders.iter().map(|o| {
        let weight = o.delay as i32 - ii * o.distance as i32;
        (o.from, o.to, weight)
    });
    let constraints: Vec<(Node, Node, i32)> = values.chain(orders).collect();
    let mut times = EntityMap::filled(problem.dfg.nodes.len(), 0);
    // Longest paths; an II below the recurrence bound would have none.
    for _ in 0..=problem.dfg.nodes.len() {
        let mut changed = false;
        for &(from, to, weight) in &constraints {
            let least: i32 = times[from] + weight;
            if times[to] < least {
                times[to] = least;
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    times
}
