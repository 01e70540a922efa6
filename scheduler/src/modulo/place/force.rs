//! Forcing: puts a node for which nothing fits somewhere all the same, and takes out the nodes and
//! routes in its way.

use super::{Attempt, Conflict};
use crate::modulo::route::Route;
use crate::modulo::table::{Issuer, Item, Table};
use srp_archdesc::arch::{Fu, FuOp};
use srp_ir::dfg::Node;
use std::collections::BTreeSet;

impl Attempt<'_, '_> {
    /// Puts a node somewhere and takes out the nodes and routes in its way. Returns the nodes to be
    /// placed again, or `None` if there is no position at all.
    pub(super) fn force(&mut self, node: Node) -> Option<Vec<Node>> {
        let mut displaced = BTreeSet::new();
        let mut positions = self.positions(node, true);
        // Where neighbours leave no room, consumers give way first, then producers.
        for neighbours in [self.consumers(node), self.producers(node)] {
            if !positions.is_empty() {
                break;
            }
            for neighbour in neighbours {
                self.remove(neighbour);
                displaced.insert(neighbour);
            }
            positions = self.positions(node, true);
        }
        let &(_, fu, time) = positions.first()?;
        *self
            .forced
            .entry((node, fu, self.table.slot(time)))
            .or_insert(0) += 1;
        let mut ripped = self.clear(node, fu, time, &mut displaced);
        if !self.occupy(node, fu, time) {
            displaced.insert(node);
            return Some(displaced.into_iter().collect());
        }
        ripped.extend(self.edges_by_slack(node));
        for e in ripped {
            let edge = &self.problem.edges[e];
            let ends = [Some(edge.from), edge.to()];
            if ends.iter().flatten().any(|&n| self.at[n].is_none()) || self.routes[e].is_some() {
                continue;
            }
            if self.route(e).is_none() {
                self.count_conflict(Conflict::Route(e));
                let victim = if edge.from == node {
                    edge.to().unwrap_or(node)
                } else {
                    edge.from
                };
                self.remove(victim);
                displaced.insert(victim);
            }
        }
        if self.at[node].is_none() {
            displaced.insert(node);
        }
        Some(
            displaced
                .into_iter()
                .filter(|&n| self.at[n].is_none())
                .collect(),
        )
    }

    /// Placed nodes that must come after a node.
    fn consumers(&self, node: Node) -> BTreeSet<Node> {
        let edges = self.problem.edges_of[node]
            .iter()
            .map(|&e| &self.problem.edges[e]);
        let values = edges.filter(|e| e.from == node).filter_map(|e| e.to());
        let orders = self.problem.orders_of[node]
            .iter()
            .map(|&o| &self.problem.orders[o]);
        let orders = orders.filter(|o| o.from == node).map(|o| o.to);
        values
            .chain(orders)
            .filter(|&n| n != node && self.at[n].is_some())
            .collect()
    }

    /// Placed nodes that must come before a node.
    fn producers(&self, node: Node) -> BTreeSet<Node> {
        let edges = self.problem.edges_of[node]
            .iter()
            .map(|&e| &self.problem.edges[e]);
        let values = edges.filter(|e| e.to() == Some(node)).map(|e| e.from);
        let orders = self.problem.orders_of[node]
            .iter()
            .map(|&o| &self.problem.orders[o]);
        let orders = orders.filter(|o| o.to == node).map(|o| o.from);
        values
            .chain(orders)
            .filter(|&n| n != node && self.at[n].is_some())
            .collect()
    }

    /// Makes room for a node: displaces nodes that hold its unit, and rips up routes that hold its
    /// unit or its output; these edges come back.
    pub(super) fn clear(
        &mut self,
        node: Node,
        fu: Fu,
        time: i32,
        displaced: &mut BTreeSet<Node>,
    ) -> Vec<usize> {
        let timing = self.problem.timing(node, fu);
        let mut ripped = Vec::new();
        for k in 0..timing.interval as i32 {
            match self.table.issuer(fu, time + k) {
                Some(Issuer::Node(other)) => {
                    self.remove(other);
                    displaced.insert(other);
                }
                Some(Issuer::Move(value)) => {
                    // A move holds as many slots as its interval, of which this may be any.
                    let slot = self.table.slot(time + k);
                    let problem = self.problem;
                    let ty = problem.dfg.ty(value).expect("only values are moved");
                    let interval = (problem.move_timing(fu, ty)).map_or(1, |t| t.interval as i32);
                    self.rip(value, &mut ripped, |table, item| match item {
                        Item::Move(unit, t, ..) if unit == fu => {
                            (0..interval).any(|held| table.slot(t + held) == slot)
                        }
                        _ => false,
                    });
                }
                None => {}
            }
        }
        if let Some(Item::Out(place, lands)) = self.result_item(node, fu, time)
            && let Some(value) = self.table.standing(place, lands)
        {
            let slot = self.table.slot(lands);
            self.rip(value, &mut ripped, |table, item| match item {
                Item::Out(p, t) => p == place && table.slot(t) == slot,
                _ => false,
            });
            if self.table.standing(place, lands) == Some(value) {
                self.remove(value);
                displaced.insert(value);
            }
        }
        self.clear_shared(fu, time, timing, displaced);
        ripped
    }

    /// Displaces nodes until the shared resources of an operation are free.
    fn clear_shared(&mut self, fu: Fu, time: i32, timing: &FuOp, displaced: &mut BTreeSet<Node>) {
        for other in self.problem.nodes() {
            if self.table.issues(fu, time, timing) {
                return;
            }
            let Some((unit, t)) = self.at[other] else {
                continue;
            };
            let theirs = self.problem.timing(other, unit);
            let overlap = (0..timing.interval as i32).any(|k| {
                (0..theirs.interval as i32)
                    .any(|l| self.table.slot(time + k) == self.table.slot(t + l))
            });
            if overlap && theirs.uses.iter().any(|r| timing.uses.contains(r)) {
                self.remove(other);
                displaced.insert(other);
            }
        }
    }

    /// Takes up the routes of a value that have an item in the way.
    fn rip(&mut self, value: Node, ripped: &mut Vec<usize>, hit: impl Fn(&Table, Item) -> bool) {
        for i in 0..self.problem.edges_of[value].len() {
            let e = self.problem.edges_of[value][i];
            if self.problem.edges[e].from != value {
                continue;
            }
            let hits = |route: &Route| route.items.iter().any(|&item| hit(&self.table, item));
            if self.routes[e].as_ref().is_some_and(hits) {
                self.unroute(e);
                ripped.push(e);
            }
        }
    }
}
