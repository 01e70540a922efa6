//! The issue slots, outputs and shared resources that a placement takes.

use super::super::problem::Position;
use super::Anneal;
use super::ways::out_of;
use srp_archdesc::arch::{Fu, FuOp, Resource};
use srp_archdesc::resource::Place;
use srp_ir::dfg::Node;

impl<'p> Anneal<'_, 'p> {
    #[inline]
    pub(super) fn slot(&self, time: i32) -> usize {
        time.rem_euclid(self.ii) as usize
    }

    #[inline]
    pub(super) fn timing(&self, node: Node, fu: Fu) -> &'p FuOp {
        self.problem.timing(node, fu)
    }

    /// Cycles in which a node holds its unit.
    fn holds(&self, node: Node, (fu, time): Position) -> impl Iterator<Item = usize> + use<> {
        let ii = self.ii;
        let interval = self.timing(node, fu).interval as i32;
        (0..interval).map(move |k| (time + k).rem_euclid(ii) as usize)
    }

    #[inline]
    pub(super) fn is_free(&self, node: Node, fu: Fu, time: i32) -> bool {
        let timing = self.timing(node, fu);
        timing.interval <= self.ii as u32
            && self.holds(node, (fu, time)).all(|slot| {
                let room =
                    |&r: &Resource| self.shared[r][slot] < self.problem.srp.resources[r].count;
                self.issue[fu][slot].is_none() && timing.uses.iter().all(room)
            })
            && self
                .landing(node, (fu, time))
                .is_none_or(|(place, slot)| self.lands[place][slot].is_none())
    }

    /// The output and the slot in which a node's result lands.
    #[inline]
    pub(super) fn landing(&self, node: Node, (fu, time): Position) -> Option<(Place, usize)> {
        let place = self.results[node].map(|ty| out_of(self.problem, ty, fu))?;
        Some((
            place,
            self.slot(time + self.timing(node, fu).latency as i32),
        ))
    }

    /// Whose value stands in the output in which a node's result lands, when it does: nobody, or
    /// the last that landed there before.
    pub(super) fn predecessor(&self, node: Node) -> Option<Node> {
        let (place, slot) = self.landing(node, self.at[node])?;
        let slots = self.ii as usize;
        (1..slots).find_map(|k| self.lands[place][(slot + slots - k) % slots])
    }

    pub(super) fn put(&mut self, node: Node, position: Position) {
        self.at[node] = position;
        self.mark(node, position, Some(node), 1);
    }

    pub(super) fn lift(&mut self, node: Node) {
        self.mark(node, self.at[node], None, u32::MAX);
    }

    /// Sets who holds the slots of a position, and adds `by` (modulo 2^32) to what it shares.
    fn mark(&mut self, node: Node, position: Position, holder: Option<Node>, by: u32) {
        if let Some((place, slot)) = self.landing(node, position) {
            self.lands[place][slot] = holder;
        }
        for slot in self.holds(node, position) {
            self.issue[position.0][slot] = holder;
            for &r in &self.timing(node, position.0).uses {
                self.shared[r][slot] = self.shared[r][slot].wrapping_add(by);
            }
        }
    }

    /// Whose slot the position takes, where it is exactly one node's.
    pub(super) fn occupant(&self, node: Node, position: Position) -> Option<Node> {
        let mut found = None;
        for slot in self.holds(node, position) {
            match (self.issue[position.0][slot], found) {
                (Some(other), None) => found = Some(other),
                (Some(other), Some(before)) if other != before => return None,
                _ => {}
            }
        }
        found
    }
}
