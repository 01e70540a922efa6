//! A step: a node moves, and where that costs more, those whose places it took move on (*ejection chains*, Glover
//! 1996), so that a place changes hands without both prices being paid in between.

use super::{IN_CONFLICT, Search};
use crate::modulo::problem::Position;
use crate::modulo::scale::Scale;
use srp_archdesc::entity::Entity;
use srp_ir::dfg::Node;

impl Search<'_, '_> {
    /// Moves a node and, as long as that is not accepted, others that are in its way. Keeps it all, or nothing.
    pub(super) fn step(&mut self, half: i32) {
        let any = self.conflicts.is_empty() || self.below(100) >= IN_CONFLICT;
        let first = self.any_or_in_conflict(any);
        let Some(mut change) = self.redraw(first, half) else {
            self.state.undo();
            return;
        };
        let mut last = first;
        self.moved.clear();
        self.moved.push(first);
        for link in 0..=self.manner.links {
            let random = self.random();
            if Scale::of(half).accepts(change, random) {
                self.state.commit();
                return;
            }
            if link == self.manner.links {
                break;
            }
            let Some((slot, other)) = self.clash(last) else {
                break;
            };
            match self.state.slot(other) == slot {
                true if self.moved.contains(&other) => break,
                true => {
                    self.moved.push(other);
                    match self.redraw(other, half) {
                        Some(cost) => change += cost,
                        None => break,
                    }
                }
                false => change += self.reroute(other, slot),
            }
            last = other;
        }
        self.state.undo();
    }

    /// Draws a node: from all, or from those in conflict, if there are any.
    pub(super) fn any_or_in_conflict(&mut self, any: bool) -> Node {
        match any || self.conflicts.is_empty() {
            true => Node::new(self.below(self.problem.dfg.nodes.len() as u32) as usize),
            false => {
                let i = self.below(self.conflicts.len() as u32);
                self.conflicts[i as usize]
            }
        }
    }

    /// One that takes an issue slot that a node, its value or one that it reads takes too.
    fn clash(&mut self, node: Node) -> Option<(usize, Node)> {
        let mut clashes = std::mem::take(&mut self.clashes);
        self.state.clashes(node, &mut clashes);
        let drawn = match clashes.is_empty() {
            true => None,
            false => Some(clashes[self.below(clashes.len() as u32) as usize]),
        };
        self.clashes = clashes;
        drawn
    }

    /// Takes a node out and puts it where it is drawn to; returns by how much the cost rises.
    /// `None` where no unit runs it.
    fn redraw(&mut self, node: Node, half: i32) -> Option<i32> {
        let before = self.take_out(node);
        Some(self.put_anew(node, half)? - before)
    }

    /// Takes a node out with the ways to and from those that are placed; returns what they cost.
    pub(super) fn take_out(&mut self, node: Node) -> i32 {
        let mut cost = 0;
        for i in 0..self.state.nets_of[node].len() {
            let net = self.state.nets_of[node][i];
            if self.state.is_placed(net) {
                cost += self.state.release(net);
            }
        }
        cost + self.state.lift(node)
    }

    /// Puts a node that has been taken out where it is drawn to; returns the cost. `None` where no unit runs it.
    /// Neighbours that are out too count as where they were.
    pub(super) fn put_anew(&mut self, node: Node, half: i32) -> Option<i32> {
        self.steps += 1;
        let random = [self.random(), self.random()];
        let drawn = (self.survey).draw(&self.state, &self.horizon, node, half, random);
        Some(self.put_in(node, drawn?))
    }

    /// Puts a node somewhere and routes its nets from and to nodes that are placed; returns the cost.
    fn put_in(&mut self, node: Node, at: Position) -> i32 {
        let cost = self.state.put(node, at);
        let mut nets = std::mem::take(&mut self.to_route);
        nets.clone_from(&self.state.nets_of[node]);
        nets.retain(|&net| self.state.is_placed(net));
        let cost = cost + self.route_all(&mut nets);
        self.to_route = nets;
        cost
    }

    /// Takes the ways of a value through an issue slot away and routes them anew; returns by how much the cost rises.
    fn reroute(&mut self, node: Node, slot: usize) -> i32 {
        let mut nets = std::mem::take(&mut self.to_route);
        self.state.ways_through(node, slot, &mut nets);
        let ways = nets.iter().map(|&net| self.state.release(net));
        let before: i32 = ways.sum();
        let change = self.route_all(&mut nets) - before;
        self.to_route = nets;
        change
    }

    /// Routes nets, the shortest first; returns the cost.
    fn route_all(&mut self, nets: &mut [usize]) -> i32 {
        let state = &self.state;
        nets.sort_unstable_by_key(|&net| {
            let (ready, read) = state.ends(&state.nets[net]);
            (read - ready, net)
        });
        nets.iter().map(|&net| self.route(net)).sum()
    }
}
