//! The horizon beyond which nothing new appears.

use crate::modulo::MAX_STAGES;
use crate::modulo::admit::places_of_values;
use crate::modulo::problem::{Goal, Problem, Tag};
use srp_archdesc::entity::EntityMap;
use srp_ir::dfg::{Node, Operand};

/// True if the timed formula with this slack misses no schedule: its horizon is beyond what any needs, and all
/// that it demands besides is necessary.
pub(in crate::modulo) fn is_complete(problem: &Problem<'_>, ii: u32, slack: u32) -> bool {
    u64::from(slack) >= farthest(problem, ii) && demands_no_more(problem)
}

/// The cycles beyond the critical path after which no schedule needs to issue anything.
///
/// No more than [`MAX_STAGES`] iterations overlap. And values have only so many places to be in, which bounds the
/// sum of their lives: in every II one of each is born, so that lives that add up to `n` IIs keep `n` places.
/// In a loop whose operations all hang together by values, the first and the last operation are joined by a path
/// of values, each of which takes its latency, its life, or its distance.
fn farthest(problem: &Problem<'_>, ii: u32) -> u64 {
    let ii = u64::from(ii);
    let stages = u64::from(MAX_STAGES) * ii;
    if !is_connected(problem) {
        return stages;
    }
    let latency = |node: Node| {
        let units = problem.units[node].iter();
        let latencies = units.map(|&fu| u64::from(problem.timing(node, fu).latency));
        latencies.max().unwrap_or(0)
    };
    let mut distances = EntityMap::filled(problem.dfg.nodes.len(), 0u64);
    for edge in &problem.edges {
        distances[edge.from] = distances[edge.from].max(edge.distance.into());
    }
    let latencies: u64 = problem.nodes().map(latency).sum();
    let distances: u64 = distances.values().sum();
    stages.min(latencies + ii * (distances + places_of_values(problem)))
}

/// True if all nodes hang together by the values that pass between them.
fn is_connected(problem: &Problem<'_>) -> bool {
    let mut seen = EntityMap::filled(problem.dfg.nodes.len(), false);
    let mut open: Vec<Node> = problem.nodes().take(1).collect();
    let mut reached = 0;
    while let Some(node) = open.pop() {
        if std::mem::replace(&mut seen[node], true) {
            continue;
        }
        reached += 1;
        for &e in &problem.edges_of[node] {
            let edge = &problem.edges[e];
            open.extend(std::iter::once(edge.from).chain(edge.to()));
        }
    }
    reached == problem.dfg.nodes.len()
}

/// True if the timed formula demands nothing that a schedule could do without: it has no registers that are set
/// before the loop, no live-outs, and no register that two units read at once.
fn demands_no_more(problem: &Problem<'_>) -> bool {
    let untagged = |tag: Option<Tag>| matches!(tag, None | Some(Tag::Plain));
    let plain = (problem.edges.iter())
        .all(|edge| untagged(edge.tag) && matches!(edge.goal, Goal::Operand(..)));
    let operands = problem.dfg.nodes.values().flat_map(|node| &node.operands);
    let computed = |operand: &Operand| matches!(operand, Operand::Node { .. });
    let mut files = problem.srp.files.values();
    plain && { operands }.all(computed) && files.all(|file| file.readers.len() < 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use srp_archdesc::diagnostic::Source;
    use srp_archdesc::xml::{StandardArray, standard};
    use srp_ir::graph::{Options, read_edges};

    #[test]
    fn the_horizon_is_beyond_the_lives_of_all_values() {
        let array = standard(&StandardArray::mesh(1, 2)).expect("a mesh there is");
        let arch = srp_archdesc::parse("mesh.xml", &array).expect("a machine");
        let complete = |edges: &str, ii: u32, slack: u32| {
            let (edges, ops) = (Source::new("g.edges", edges), "a add\nb add\nc add");
            let graph = read_edges(&edges, &Source::new("g.ops", ops), &Options::default());
            let graph = graph.expect("a graph");
            is_complete(&Problem::new(&graph.dfg, &arch.srp), ii, slack)
        };
        // 3 cycles of latency; in each of 2 cycles, 2 units with 8 registers, an output and a value of each type on
        // its way, and the 2 places of files; a distance of 4 iterations.
        let chain = "a b 0\nb c 4";
        let places = 2 * (8 + 1 + 3) + 2;
        assert!(complete(chain, 2, 3 + 2 * (4 + places)));
        assert!(!complete(chain, 2, 3 + 2 * (4 + places) - 1));
        // What does not hang together may wait for as long as iterations overlap.
        let apart = "a b 0\nc c 1";
        assert!(complete(apart, 2, 128) && !complete(apart, 2, 127));
    }
}
