//! Operations that are issued before their operands are ready, and all that has to make room for them.
//!
//! A step moves one node. One that goes to where its operand is ready is too late for its consumers then, and to be too
//! late for several costs more than to be too early for one: it stays. So a chain is moved whole, its prices
//! notwithstanding: the consumer goes to later cycles, then those of its consumers that this makes too early, and so on,
//! or the producer and those before it go to earlier ones. What is taken too often afterwards is a matter of prices again, and
//! so are the memory orders of those that have moved, which say where each may go, but which no other node follows.

use super::Negotiation;
use super::survey::WIDEST;
use srp_archdesc::entity::Entity;
use srp_ir::dfg::Node;
use std::collections::BTreeSet;

/// Nodes that are moved at a time, at most: round a recurrence there would be no end.
const MOST_PUSHED: usize = 60;

/// Where a chain goes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Way {
    /// Consumers follow.
    Later,
    /// Producers go before.
    Earlier,
}

impl Negotiation<'_, '_> {
    /// Moves the chain behind or before one of the edges whose consumer is issued before the value is ready, if there are
    /// such, until it fits; where there is no room, or no end, the rest of it stays. Positions are drawn as in a step, `half`
    /// as there.
    pub(super) fn push(&mut self, half: i32) {
        let edges = 0..self.problem.edges.len();
        let early: Vec<usize> = edges.filter(|&e| self.is_early(e)).collect();
        if early.is_empty() {
            return;
        }
        let drawn = self.below(early.len() as u32) as usize;
        let edge = &self.problem.edges[early[drawn]];
        let way = match self.below(2) {
            0 => Way::Later,
            _ => Way::Earlier,
        };
        let first = match way {
            Way::Later => edge.to().unwrap_or(edge.from),
            Way::Earlier => edge.from,
        };
        // In the order of their cycles, so that most are moved once.
        let mut due = BTreeSet::from([self.due(first, way)]);
        for _ in 0..MOST_PUSHED {
            let Some((_, node)) = due.pop_first() else {
                return;
            };
            let node = Node::new(node);
            if !self.move_on(node, way, half) {
                return;
            }
            for &e in &self.problem.edges_of[node] {
                let edge = &self.problem.edges[e];
                let next = match way {
                    Way::Later => edge.to().filter(|&to| to != node),
                    Way::Earlier => Some(edge.from).filter(|&from| from != node),
                };
                due.extend(
                    next.filter(|_| self.is_early(e))
                        .map(|next| self.due(next, way)),
                );
            }
        }
    }

    /// True if an edge has no route and its consumer is issued before the value is ready.
    fn is_early(&self, e: usize) -> bool {
        let edge = &self.problem.edges[e];
        let Some(to) = edge.to().filter(|&to| to != edge.from) else {
            return false;
        };
        let read = self.state.at[to].1 + self.state.ii * edge.distance as i32;
        self.state.routes[e].is_none() && self.state.ready(edge.from) > read
    }

    /// A node, by its number, and when its turn is.
    fn due(&self, node: Node, way: Way) -> (i32, usize) {
        let (_, time) = self.state.at[node];
        match way {
            Way::Later => (time, node.index()),
            Way::Earlier => (-time, node.index()),
        }
    }

    /// Moves a node to where its operands are ready, or its result is for its consumers, the prices of other cycles
    /// notwithstanding; false if it has no room there.
    fn move_on(&mut self, node: Node, way: Way, half: i32) -> bool {
        self.steps += 1;
        let (first, last) = self.room(node, way);
        if first > last {
            return false;
        }
        let all_slots = self.state.ii.min(WIDEST) - 1;
        let cycles = match way {
            Way::Later => (first, last.min(first + all_slots)),
            Way::Earlier => (first.max(last - all_slots), last),
        };
        let old = self.state.at[node];
        self.take_out(node);
        self.survey.look_between(&self.state, node, cycles);
        let random = self.random();
        let Some(new) = self.survey.draw(half, random) else {
            self.put_back(node, old);
            return false;
        };
        self.put_in(node, new);
        let dropped = self.taken_out.drain(..);
        dropped.for_each(|(_, path)| self.state.drop_list(path.items));
        true
    }

    /// The cycles in which a node may be issued by those before it, or by those behind it.
    fn room(&self, node: Node, way: Way) -> (i32, i32) {
        // Where nothing bounds it, and far enough from overflows.
        let far = i32::MAX / 4;
        let (first, last) = self.within(node).unwrap_or((-far, far));
        match (way, self.state.between_neighbours(node)) {
            (Way::Later, (Some(time), _)) => (first.max(time), last),
            (Way::Earlier, (_, Some(time))) => (first, last.min(time)),
            _ => (first, last),
        }
    }
}
