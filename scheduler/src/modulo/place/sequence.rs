//! One after the other: a schedule for when there is time enough, but nothing else works.

use super::{Attempt, Placement};
use crate::modulo::problem::Problem;
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::EntityMap;
use srp_ir::dfg::Node;

/// Positions that are tried for a node in one cycle, those nearest to its operands first, and in all.
const POSITIONS: usize = 16;
const MOST_POSITIONS: usize = 2000;
/// Cycles that a value may take longer for each node that a unit has less: where nodes crowd, no value gets away.
const CROWDING: u32 = 4;

impl Attempt<'_, '_> {
    /// Places every node after those whose values it takes in the same iteration, as soon as these can
    /// be routed to it; `None` where one finds no position within an II, or the router has made so many steps.
    pub(in crate::modulo) fn in_sequence(&mut self, steps: u64) -> Option<Placement> {
        let limit = self.router.expanded.saturating_add(steps);
        let mut loads: EntityMap<Fu, u32> = EntityMap::filled(self.problem.srp.fus.len(), 0);
        for node in operands_first(self.problem) {
            let earliest = self.earliest(node);
            let mut left = MOST_POSITIONS;
            let mut times = earliest..earliest + self.table.ii as i32;
            loop {
                let is_hopeless = left == 0 || self.router.expanded > limit;
                let time = times.next().filter(|_| !is_hopeless)?;
                if !self.keeps_orders(node, time) {
                    continue;
                }
                let units = self.nearest(node, time, &loads);
                left = left.saturating_sub(units.len());
                let mut units = units.into_iter();
                if let Some(fu) = units.find(|&fu| self.try_position(node, fu, time).is_some()) {
                    loads[fu] += 1;
                    break;
                }
            }
        }
        self.placement()
    }

    /// Free units to which the operands of a node can come by a cycle, those that are near and run few nodes first.
    fn nearest(&self, node: Node, time: i32, loads: &EntityMap<Fu, u32>) -> Vec<Fu> {
        let units = self.problem.units[node].iter();
        let free = units.filter(|&&fu| self.is_free(node, fu, time));
        let mut near: Vec<(u32, Fu)> = free
            .filter_map(|&fu| Some((self.distance(node, fu, time)? + CROWDING * loads[fu], fu)))
            .collect();
        near.sort_unstable();
        near.truncate(POSITIONS);
        near.into_iter().map(|(_, fu)| fu).collect()
    }

    /// The first cycle in which what a node takes in the same iteration can be there.
    fn earliest(&self, node: Node) -> i32 {
        let problem = self.problem;
        let values = problem.edges_of[node].iter().map(|&e| &problem.edges[e]);
        let values = values.filter(|e| e.to() == Some(node) && e.distance == 0);
        let orders = problem.orders_of[node].iter().map(|&o| &problem.orders[o]);
        let orders = orders.filter(|o| o.to == node && o.distance == 0);
        let arrives = |from: Node, delay: Option<i32>| {
            let (fu, time) = self.at[from]?;
            let latency = problem.timing(from, fu).latency as i32;
            Some(time + delay.unwrap_or(latency))
        };
        let values = values.filter_map(|e| arrives(e.from, None));
        let orders = orders.filter_map(|o| arrives(o.from, Some(o.delay as i32)));
        values.chain(orders).max().unwrap_or(0)
    }
}

/// All nodes, each after those that it depends on in the same iteration.
fn operands_first(problem: &Problem<'_>) -> Vec<Node> {
    let count = problem.dfg.nodes.len();
    let mut needs = EntityMap::filled(count, 0u32);
    let mut users: EntityMap<Node, Vec<Node>> = EntityMap::filled(count, Vec::new());
    let values = problem.edges.iter().filter(|e| e.distance == 0);
    let values = values.filter_map(|e| Some((e.from, e.to()?)));
    let orders = problem.orders.iter().filter(|o| o.distance == 0);
    for (from, to) in values.chain(orders.map(|o| (o.from, o.to))) {
        needs[to] += 1;
        users[from].push(to);
    }
    let mut order: Vec<Node> = problem.nodes().filter(|&n| needs[n] == 0).collect();
    let mut next = 0;
    while let Some(&node) = order.get(next) {
        next += 1;
        for &user in &users[node] {
            needs[user] -= 1;
            if needs[user] == 0 {
                order.push(user);
            }
        }
    }
    order
}
