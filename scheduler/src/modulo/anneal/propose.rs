//! Where a node might go: mostly next to a neighbour, in time for all of them.

use super::super::problem::Position;
use super::Anneal;
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::Entity;
use srp_ir::dfg::Node;

/// Cycles beyond the least in which a node without consumers may be put.
const SPREAD: i32 = 3;

impl Anneal<'_, '_> {
    /// The first and last cycle in which a node on this unit is in time, so far as its neighbours
    /// say.
    fn window(&self, node: Node, fu: Fu) -> (Option<i32>, Option<i32>) {
        let (mut first, mut last) = (None::<i32>, None::<i32>);
        let latency = self.timing(node, fu).latency as i32;
        let mut not_before = |t: i32| first = Some(first.map_or(t, |f| f.max(t)));
        let mut not_after = |t: i32| last = Some(last.map_or(t, |l| l.min(t)));
        let units = self.problem.srp.fus.len();
        for &w in &self.wires_of[node] {
            let wire = &self.wires[w as usize];
            let reach = |from: Fu, to: Fu| {
                let way = self.ways[wire.ty as usize][from.index() * units + to.index()];
                way.reach.min(units as u32) as i32
            };
            if wire.to == node {
                let (from, t) = self.at[wire.from];
                let ready = t + self.timing(wire.from, from).latency as i32;
                not_before(ready + reach(from, fu) - wire.span);
            } else {
                let (to, t) = self.at[wire.to];
                not_after(t + wire.span - reach(fu, to) - latency);
            }
        }
        for &o in &self.problem.orders_of[node] {
            let order = &self.problem.orders[o];
            let span = self.ii * order.distance as i32;
            if order.to == node && order.from != node {
                not_before(self.at[order.from].1 + order.delay as i32 - span);
            } else if order.to != node {
                not_after(self.at[order.to].1 + span - order.delay as i32);
            }
        }
        (first, last)
    }

    /// A unit for a node: mostly one next to a neighbour of the node's.
    fn propose_unit(&mut self, node: Node) -> Fu {
        let count = self.wires_of[node].len() as u32;
        if count > 0 && self.draw(4) > 0 {
            let drawn = self.draw(count) as usize;
            let wire = &self.wires[self.wires_of[node][drawn] as usize];
            let other = if wire.to == node { wire.from } else { wire.to };
            let (unit, _) = self.at[other];
            let drawn = self.draw(self.near[unit].len() as u32) as usize;
            let fu = self.near[unit][drawn];
            if self.problem.units[node].binary_search(&fu).is_ok() {
                return fu;
            }
        }
        let drawn = self.draw(self.problem.units[node].len() as u32) as usize;
        self.problem.units[node][drawn]
    }

    pub(super) fn propose(&mut self, node: Node) -> Position {
        let fu = self.propose_unit(node);
        let ii = self.ii;
        let (from, to) = match self.window(node, fu) {
            (Some(first), Some(last)) if first <= last => (first, last.min(first + ii - 1)),
            (Some(first), Some(last)) => (last, first),
            (Some(first), None) => (first, first + (ii - 1).min(SPREAD)),
            (None, Some(last)) => (last - (ii - 1).min(SPREAD), last),
            (None, None) => (self.at[node].1, self.at[node].1 + ii - 1),
        };
        let width = (to - from + 1).min(2 * ii + 2) as u32;
        (fu, from + self.draw(width) as i32)
    }
}
