//! Repair of a placement in which some edges have no route yet: nodes around them are moved, one at a
//! time, as long as that leaves fewer edges without.
//!
//! A min-conflicts search (Minton et al. 1992) that sometimes takes a step for the worse. An edge
//! weighs the more the longer it stays without a route, which leads out of local minima (breakout,
//! Morris 1993). All nodes keep a place all the time: a displaced node takes the place that became
//! free, or the best other.

use super::{Attempt, Placement};
use crate::modulo::noise::noise;
use crate::modulo::problem::Position;
use crate::modulo::route::Route;
use crate::modulo::table::Item;
use srp_archdesc::Watch;
use srp_ir::dfg::Node;
use std::collections::BTreeSet;

/// The number of best positions of a node from which one is drawn.
const BEST: usize = 12;
/// The cost of an edge without a route, in moves of values.
const UNROUTED: i64 = 8;
/// Percent of the moves that are those of a neighbour of an edge's end.
const NEIGHBOURS: usize = 50;
/// Effort of one move beside its routes.
const MOVE_EFFORT: u64 = 40;
/// A share of the edges that is too large to begin with when they have no routes: one in so many.
const HOPELESS: usize = 5;
/// Effort after which a search that got no better is given up.
const PATIENCE: u64 = 1_000_000;

/// Changes of a move: positions and routes as they were before.
#[derive(Default)]
pub(super) struct Journal {
    pub(super) nodes: Vec<(Node, Position)>,
    pub(super) routes: Vec<(usize, Route)>,
}

/// A draw of numbers, the same for the same attempt and step.
struct Dice {
    seed: u64,
    step: u64,
}

impl Dice {
    fn roll(&self, what: u64) -> u32 {
        noise(self.seed << 32 | 0x4e9, self.step, what)
    }

    fn below(&self, what: u64, limit: usize) -> usize {
        ((u64::from(self.roll(what)) * limit as u64) >> 32) as usize
    }
}

impl Attempt<'_, '_> {
    /// Moves nodes until every edge has a route; `None` where the router has no effort left, or it
    /// does not get better.
    pub(super) fn repair(&mut self, limit: u64, watch: &dyn Watch) -> Option<Placement> {
        self.place_the_rest()?;
        if self.unrouted().count() > self.routes.len() / HOPELESS + 1 {
            return None;
        }
        let mut weights = vec![1; self.routes.len()];
        let mut fewest = usize::MAX;
        let mut give_up = limit;
        for step in 0.. {
            let unrouted: Vec<usize> = self.unrouted().collect();
            if unrouted.is_empty() {
                return self.placement();
            }
            if unrouted.len() < fewest {
                fewest = unrouted.len();
                give_up = limit.min(self.router.expanded + PATIENCE);
            }
            if self.router.expanded >= give_up || step % 64 == 63 && watch.cancelled() {
                break;
            }
            let dice = Dice {
                seed: u64::from(self.seed),
                step,
            };
            let e = unrouted[dice.below(0, unrouted.len())];
            if self.route(e).is_none() {
                weights[e] += 1;
                self.router.expanded += MOVE_EFFORT;
                self.move_around(e, &dice, &weights);
            }
        }
        None
    }

    /// Puts the nodes that have no place yet where they can be.
    fn place_the_rest(&mut self) -> Option<()> {
        for node in self.problem.nodes() {
            if self.at[node].is_none() {
                let &(_, fu, time) = self.positions(node, false).first()?;
                self.occupy(node, fu, time).then_some(())?;
            }
        }
        Some(())
    }

    fn unrouted(&self) -> impl Iterator<Item = usize> {
        let routes = self.routes.iter().enumerate();
        routes.filter(|(_, route)| route.is_none()).map(|(e, _)| e)
    }

    /// Moves one of the ends of an edge, or a neighbour of theirs, to one of its best positions.
    fn move_around(&mut self, e: usize, dice: &Dice, weights: &[i64]) {
        let edge = &self.problem.edges[e];
        let mut node = match edge.to() {
            Some(to) if dice.below(1, 2) == 0 => to,
            _ => edge.from,
        };
        if dice.below(2, 100) < NEIGHBOURS {
            let edges = &self.problem.edges_of[node];
            let next = &self.problem.edges[edges[dice.below(3, edges.len())]];
            let other = if next.from == node {
                next.to()
            } else {
                Some(next.from)
            };
            node = other.unwrap_or(node);
        }
        let Some(to) = self.target(node, dice) else {
            return;
        };
        // The longer the row of zeros, the larger the step for the worse that is taken.
        let tolerance = 3 * i64::from((dice.roll(6) | 1).leading_zeros());
        self.shift(node, to, tolerance, weights);
    }

    /// One of the best positions of a node, another than its own.
    fn target(&self, node: Node, dice: &Dice) -> Option<Position> {
        let old = self.at[node]?;
        let mut positions = self.positions(node, true);
        positions.retain(|&(_, fu, time)| (fu, time) != old);
        let choice = dice.below(4, BEST).min(dice.below(5, BEST));
        let last = positions.len().checked_sub(1)?;
        let (_, fu, time) = positions[choice.min(last)];
        Some((fu, time))
    }

    /// Moves a node, unless the total is worse by more than is tolerated.
    fn shift(&mut self, node: Node, to: Position, tolerance: i64, weights: &[i64]) {
        let Some(old) = self.at[node] else { return };
        self.journal = Some(Journal::default());
        let mut displaced = BTreeSet::new();
        self.remove(node);
        self.clear(node, to.0, to.1, &mut displaced);
        displaced.remove(&node);
        let placed =
            self.occupy(node, to.0, to.1) && displaced.iter().all(|&other| self.settle(other, old));
        let journal = self.journal.take().expect("it was set above");
        let moved: Vec<Node> = displaced.into_iter().chain([node]).collect();
        let edges = moved
            .iter()
            .flat_map(|&n| &self.problem.edges_of[n])
            .copied();
        let ripped = journal.routes.iter().map(|(e, _)| *e);
        let affected: BTreeSet<usize> = edges.chain(ripped).collect();
        if placed {
            let all: i64 = affected.iter().map(|&e| UNROUTED * weights[e]).sum();
            let gain = |(e, route): &(usize, Route)| UNROUTED * weights[*e] - moves(route);
            let before = all - journal.routes.iter().map(gain).sum::<i64>();
            self.route_all(affected.iter().copied());
            let cost = |&e: &usize| self.routes[e].as_ref().map_or(UNROUTED * weights[e], moves);
            let after: i64 = affected.iter().map(cost).sum();
            if after <= before + tolerance {
                return;
            }
        }
        self.undo(&moved, &affected, journal);
    }

    /// Puts a displaced node where another was, or at the best free position.
    fn settle(&mut self, node: Node, (fu, time): Position) -> bool {
        let free = self.positions(node, false);
        let slot = self.table.slot(time);
        let there = |&&(_, f, t): &&(u32, _, i32)| f == fu && self.table.slot(t) == slot;
        match free.iter().find(there).or(free.first()) {
            Some(&(_, fu, time)) => self.occupy(node, fu, time),
            None => false,
        }
    }

    /// Puts everything back as it was before a move.
    fn undo(&mut self, moved: &[Node], affected: &BTreeSet<usize>, journal: Journal) {
        affected.iter().for_each(|&e| self.unroute(e));
        moved.iter().for_each(|&node| self.remove(node));
        for (node, (fu, time)) in journal.nodes {
            self.occupy(node, fu, time);
        }
        for (e, route) in journal.routes {
            // Registers can be packed otherwise by now: then the edge is left without a route.
            let _ = self.take_route(e, route);
        }
    }
}

/// Moves of a route.
fn moves(route: &Route) -> i64 {
    let is_move = |item: &&Item| matches!(item, Item::Move(..));
    route.items.iter().filter(is_move).count() as i64
}
