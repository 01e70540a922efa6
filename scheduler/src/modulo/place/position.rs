//! Where a node could go: the cycles that its neighbours leave it, and what each position is worth.

use super::{Attempt, Conflict};
use crate::modulo::noise::noise;
use crate::modulo::table::Item;
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::Entity;
use srp_ir::dfg::Node;

/// Extra cycles beyond one II in which a place is looked for: room for routes.
const ROUTING_SLACK: i32 = 6;

/// Cycles that are looked at, at most, however large the II.
const WIDEST: i32 = 40;

impl Attempt<'_, '_> {
    /// The cycles in which a node may be issued, the best first.
    fn window(&self, node: Node) -> Vec<i32> {
        let mut cycles = self.window_between_neighbours(node);
        if self.deadline.is_some() {
            let whole = self.freedom.earliest[node]..=self.freedom.latest[node];
            cycles.retain(|time| whole.contains(time));
        }
        cycles
    }

    /// The cycles that a node's placed neighbours leave it.
    fn window_between_neighbours(&self, node: Node) -> Vec<i32> {
        let ii = self.table.ii as i32;
        let (mut earliest, mut latest) = (None::<i32>, None::<i32>);
        let mut after = |t: i32| earliest = Some(earliest.map_or(t, |e| e.max(t)));
        let mut before = |t: i32| latest = Some(latest.map_or(t, |l| l.min(t)));
        let own_latency = self.problem.min_latency(node) as i32;
        for &e in &self.problem.edges_of[node] {
            let edge = &self.problem.edges[e];
            let Some(to) = edge.to().filter(|&to| to != edge.from) else {
                continue;
            };
            let span = ii * edge.distance as i32;
            if to == node {
                if let Some((fu, t)) = self.at[edge.from] {
                    after(t + self.problem.timing(edge.from, fu).latency as i32 - span);
                }
            } else if let Some((_, t)) = self.at[to] {
                before(t + span - own_latency);
            }
        }
        for &o in &self.problem.orders_of[node] {
            let order = &self.problem.orders[o];
            let span = ii * order.distance as i32;
            if order.to == node && order.from != node {
                if let Some((_, t)) = self.at[order.from] {
                    after(t + order.delay as i32 - span);
                }
            } else if let Some((_, t)) = self.at[order.to] {
                before(t + span - order.delay as i32);
            }
        }
        let reach = ii.min(WIDEST) + ROUTING_SLACK;
        match (earliest, latest) {
            (Some(e), Some(l)) => (e..=l.min(e + reach - 1)).collect(),
            (None, Some(l)) => (l - reach + 1..=l).rev().collect(),
            (Some(e), None) => (e..e + reach).collect(),
            (None, None) => {
                let e = self.freedom.earliest[node];
                (e..e + ii).collect()
            }
        }
    }

    /// True if a node that issues in a cycle keeps its memory orders with all placed nodes.
    pub(super) fn keeps_orders(&self, node: Node, time: i32) -> bool {
        let issued = |n: Node| match n == node {
            true => Some(time),
            false => self.at[n].map(|(_, t)| t),
        };
        self.problem.orders_of[node].iter().all(|&o| {
            let order = &self.problem.orders[o];
            let span = self.table.ii as i32 * order.distance as i32;
            match (issued(order.from), issued(order.to)) {
                (Some(from), Some(to)) => to + span >= from + order.delay as i32,
                _ => true,
            }
        })
    }

    /// Positions of a node with an estimate of their cost, cheapest first. Positions whose unit is
    /// taken are left out unless `occupied` asks for them.
    pub(super) fn positions(&self, node: Node, occupied: bool) -> Vec<(u32, Fu, i32)> {
        let mut positions = Vec::new();
        for (late, &time) in self.window(node).iter().enumerate() {
            for &fu in &self.problem.units[node] {
                if !occupied && !self.is_free(node, fu, time) {
                    continue;
                }
                let lands = time + self.problem.timing(node, fu).latency as i32;
                if self.deadline.is_some_and(|deadline| lands > deadline) {
                    continue;
                }
                let Some(distance) = self.distance(node, fu, time) else {
                    continue;
                };
                let jitter = noise(
                    u64::from(self.seed),
                    node.index() as u64,
                    (fu.index() * 977 + late) as u64,
                );
                let mut cost = 10 * distance + 3 * late as u32 + self.scarcity[fu] + jitter % 8;
                if occupied {
                    cost += 25 * u32::from(!self.is_free(node, fu, time));
                    let key = (node, fu, self.table.slot(time));
                    cost += 40 * self.forced.get(&key).copied().unwrap_or(0);
                }
                positions.push((cost, fu, time));
            }
        }
        positions.sort_unstable();
        positions
    }

    /// The conflict of a node without a position: the one that is left where it comes furthest.
    pub(super) fn why_nowhere(&self, node: Node) -> Conflict {
        let cycles = self.window(node);
        let positions = || {
            let units = &self.problem.units[node];
            (cycles.iter()).flat_map(|&time| units.iter().map(move |&fu| (fu, time)))
        };
        let issues = |(fu, time)| {
            let timing = self.problem.timing(node, fu);
            self.table.issues(fu, time, timing)
        };
        let is_free = |(fu, time)| self.is_free(node, fu, time);
        if cycles.is_empty() || positions().any(is_free) {
            Conflict::Reach(node)
        } else if positions().any(issues) {
            Conflict::Output(node)
        } else {
            Conflict::Unit(node)
        }
    }

    pub(super) fn result_item(&self, node: Node, fu: Fu, time: i32) -> Option<Item> {
        let op = self.problem.dfg.nodes[node].op;
        let place = self.problem.graph.result_place(fu, op)?;
        Some(Item::Out(
            place,
            time + self.problem.timing(node, fu).latency as i32,
        ))
    }

    pub(super) fn is_free(&self, node: Node, fu: Fu, time: i32) -> bool {
        self.table.issues(fu, time, self.problem.timing(node, fu))
            && self
                .result_item(node, fu, time)
                .is_none_or(|i| self.table.fits(node, i, None))
    }

    /// How far a position is from the placed neighbours, in cycles that routes need at least;
    /// `None` where one of them cannot be reached in time.
    pub(super) fn distance(&self, node: Node, fu: Fu, time: i32) -> Option<u32> {
        let problem = self.problem;
        let mut sum = 0;
        for &e in &problem.edges_of[node] {
            let edge = &problem.edges[e];
            let Some(to) = edge.to().filter(|&to| to != edge.from) else {
                continue;
            };
            let (from, target) = if to == node {
                (self.at[edge.from], Some((fu, time)))
            } else {
                (Some((fu, time)), self.at[to])
            };
            let (Some((from_fu, from_time)), Some((to_fu, to_time))) = (from, target) else {
                continue;
            };
            let op = problem.dfg.nodes[edge.from].op;
            let place = problem.graph.result_place(from_fu, op)?;
            let ready = from_time + problem.timing(edge.from, from_fu).latency as i32;
            let reach = problem.reach(edge.ty, place, to_fu);
            let arrival = to_time + self.table.ii as i32 * edge.distance as i32;
            if ready + reach as i32 > arrival {
                return None;
            }
            sum += reach;
        }
        Some(sum)
    }
}
