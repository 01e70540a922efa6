//! Memory orders that say nothing new are left out.

use crate::dfg::{Node, NodeData, Order};
use srp_archdesc::entity::{Entity, EntityMap};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Work, in edges looked at, beyond which all orders are kept.
const MAX_WORK: usize = 40_000_000;

/// Edges to the nodes behind one, with their distances; those that are orders with their number.
type Edges = EntityMap<Node, Vec<(Node, u64, Option<usize>)>>;

/// The orders without those that follow from others and from the operands: where a path leads from
/// the one access to the other with no more iterations in between. All delays on it are at least
/// zero, and the first is at least that of the order, so nothing is lost.
pub(super) fn without_implied(
    nodes: &EntityMap<Node, NodeData>,
    mut orders: Vec<Order>,
) -> Vec<Order> {
    // The loosest are tried first.
    orders.sort_by_key(|o| (Reverse(o.distance), o.from, o.to));
    orders.dedup();
    let mut edges: Edges = EntityMap::filled(nodes.len(), Vec::new());
    let mut count = orders.len();
    for (to, data) in nodes.iter() {
        for (from, distance) in data.producers() {
            edges[from].push((to, u64::from(distance), None));
            count += 1;
        }
    }
    for (i, o) in orders.iter().enumerate() {
        edges[o.from].push((o.to, u64::from(o.distance), Some(i)));
    }
    let mut kept = vec![true; orders.len()];
    if orders.len().saturating_mul(count) <= MAX_WORK {
        for i in 0..orders.len() {
            kept[i] = false;
            kept[i] = !leads(&edges, orders[i], &kept);
        }
    }
    let mut orders: Vec<Order> = orders
        .into_iter()
        .zip(kept)
        .filter_map(|(o, kept)| kept.then_some(o))
        .collect();
    orders.sort();
    orders
}

/// True if the remaining edges lead from one end of the order to the other within its distance.
fn leads(edges: &Edges, order: Order, kept: &[bool]) -> bool {
    let mut best: EntityMap<Node, u64> = EntityMap::filled(edges.len(), u64::MAX);
    let mut open = BinaryHeap::from([Reverse((0, order.from.index()))]);
    while let Some(Reverse((distance, node))) = open.pop() {
        for &(to, further, id) in &edges[Node::new(node)] {
            let reached = distance + further;
            let usable = id.is_none_or(|i| kept[i]);
            if !usable || reached > u64::from(order.distance) || reached >= best[to] {
                continue;
            }
            if to == order.to {
                return true;
            }
            best[to] = reached;
            open.push(Reverse((reached, to.index())));
        }
    }
    false
}
