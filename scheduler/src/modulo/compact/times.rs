//! Where nodes lie when a negotiation of a shorter length begins: the cycles of a placement, brought between those
//! in which nodes may issue.

use crate::modulo::order::Freedom;
use crate::modulo::place::Placement;
use crate::modulo::problem::Problem;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Ty;
use srp_ir::dfg::Node;

/// Cycles between a predicate and its use.
const ROOM: i32 = 1;

/// The cycles of a placement, where these are allowed. What lies outside is put where it is allowed next, in its slot
/// if possible.
pub(super) fn cut(placement: &Placement, freedom: &Freedom) -> EntityMap<Node, i32> {
    let ii = placement.ii as i32;
    let allowed = |(node, &(_, time)): (Node, &(_, i32))| {
        let (first, last) = (freedom.earliest[node], freedom.latest[node]);
        let whole = |by: i32| by.div_euclid(ii) * ii;
        match time {
            _ if time < first => (time - whole(time - first)).min(last),
            _ if time > last => (time + whole(last - time)).max(first),
            _ => time,
        }
    };
    placement.at.iter().map(allowed).collect()
}

/// The cycles of a placement, pressed together: where a node lies between its earliest cycle and its latest is the same
/// part of the way as it was. Along a path whose nodes had the same room all keep their distances, while cutting
/// would leave the early ones and their values' consumers, which have to come along, ever further apart from each
/// other. What computes predicates goes to its consumers.
pub(super) fn press(
    problem: &Problem<'_>,
    placement: &Placement,
    was: &Freedom,
    freedom: &Freedom,
) -> EntityMap<Node, i32> {
    let pressed = |(node, &(_, time)): (Node, &(_, i32))| {
        let (first, last) = (freedom.earliest[node], freedom.latest[node]);
        let room = i64::from(was.latest[node] - was.earliest[node]).max(1);
        let part = i64::from(time - was.earliest[node]) * i64::from(last - first) / room;
        (first + part as i32).clamp(first, last)
    };
    let mut times: EntityMap<Node, i32> = placement.at.iter().map(pressed).collect();
    delay_predicates(problem, placement.ii, freedom, &mut times);
    times
}

/// Delays predicates until they are used: few registers hold them, and in many machines none that rotate, so that no
/// route keeps one for long. One after the other their operations would hardly get there, for each would first leave
/// the operands behind that are predicates too.
fn delay_predicates(
    problem: &Problem<'_>,
    ii: u32,
    freedom: &Freedom,
    times: &mut EntityMap<Node, i32>,
) {
    let mut order: Vec<Node> = problem.nodes().collect();
    order.sort_by_key(|&node| (std::cmp::Reverse(times[node]), node));
    for node in order {
        let used = problem.edges_of[node].iter().filter_map(|&e| {
            let edge = &problem.edges[e];
            let to = edge.to().filter(|&to| edge.from == node && to != node)?;
            let is_predicate = edge.ty == Ty::Pred;
            is_predicate.then(|| times[to] + (ii * edge.distance) as i32)
        });
        let latency = problem.min_latency(node) as i32;
        if let Some(used) = used.min() {
            times[node] = times[node].max((used - latency - ROOM).min(freedom.latest[node]));
        }
    }
}
