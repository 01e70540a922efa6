//! Ways of the values of a loop on an array that does not lead everywhere: from some unit that runs an operation to some
//! unit that runs another, which takes its result. A value without any has no schedule, however long one is looked for.

use super::obstacle::{Destination, Operation, Unschedulable};
use super::problem::{Edge, Goal, Problem};
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::EntityMap;
use srp_ir::dfg::Node;

/// Units of the largest array that is looked at; on larger ones it would take longer than it saves.
const MOST_UNITS: usize = 256;

/// Refuses a loop with a value that has no way from any unit of its producer to any of its consumer.
///
/// Units without a way to or from any unit of a neighbour are left out until none is left to leave out (arc consistency,
/// Mackworth 1977). They stay in [`Problem::units`]: what has a way may still be found to have no room.
pub(super) fn exist(problem: &Problem<'_>) -> Result<(), Unschedulable> {
    if problem.srp.fus.len() > MOST_UNITS {
        return Ok(());
    }
    let mut units: EntityMap<Node, Vec<Fu>> = problem.units.clone();
    let mut changed = true;
    while std::mem::take(&mut changed) {
        for edge in &problem.edges {
            let (from, to) = ends(problem, edge, &units);
            if from.is_empty() {
                return Err(Unschedulable::NoWay {
                    from: Operation::of(problem.dfg, edge.from),
                    to: match edge.goal {
                        Goal::Operand(to, _) => {
                            Destination::Operation(Operation::of(problem.dfg, to))
                        }
                        Goal::LiveOut(index) => Destination::LiveOut(index),
                    },
                    in_register: edge.tag.is_some() && edge.to().is_some(),
                });
            }
            changed |= from.len() < units[edge.from].len();
            units[edge.from] = from;
            if let Some((node, to)) = edge.to().zip(to) {
                changed |= to.len() < units[node].len();
                units[node] = to;
            }
        }
    }
    Ok(())
}

/// The units of an edge's producer, and of its consumer if that is a node, that have a way to or from one of the other.
fn ends(
    problem: &Problem<'_>,
    edge: &Edge,
    units: &EntityMap<Node, Vec<Fu>>,
) -> (Vec<Fu>, Option<Vec<Fu>>) {
    let producers = units[edge.from].iter().copied();
    let Some(to) = edge.to() else {
        let kept = producers.filter(|&fu| problem.is_kept(edge.ty, fu));
        return (kept.collect(), None);
    };
    let has_way = |from: Fu, to: Fu| match edge.tag {
        None => problem.has_way(edge.ty, from, to),
        Some(_) => problem.has_way_by_file(edge.ty, from, to),
    };
    // A node's own value is taken where it is made.
    if to == edge.from {
        let own: Vec<Fu> = producers.filter(|&fu| has_way(fu, fu)).collect();
        return (own.clone(), Some(own));
    }
    let consumers = units[to].iter().copied();
    let from = producers
        .clone()
        .filter(|&from| consumers.clone().any(|to| has_way(from, to)));
    let reached = consumers
        .clone()
        .filter(|&to| producers.clone().any(|from| has_way(from, to)));
    (from.collect(), Some(reached.collect()))
}
