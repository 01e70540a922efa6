//! Moves of whole sets of nodes by iterations, which change no slot.

use super::{Anneal, Wire};
use srp_archdesc::entity::Entity;
use srp_ir::dfg::Node;

impl Anneal<'_, '_> {
    /// Tries to bring the ends of every value that waits for an II or more closer together: moves one
    /// of them, with all that has to go with it, to the next iteration or the one before. That
    /// changes no slot, so nothing is in the way.
    pub(super) fn restage(&mut self, temperature: u32) {
        for w in 0..self.wires.len() {
            for (later, whole) in [(true, false), (false, false), (true, true), (false, true)] {
                let wire = &self.wires[w];
                if self.slack(wire) >= self.ii {
                    let (start, end) = if later {
                        (wire.from, wire.to)
                    } else {
                        (wire.to, wire.from)
                    };
                    self.shift(start, end, later, whole, temperature);
                }
            }
        }
    }

    /// Cycles that a value has beyond those that its way takes.
    fn slack(&self, wire: &Wire) -> i32 {
        let ((from, issued), (to, read)) = (self.at[wire.from], self.at[wire.to]);
        let units = self.problem.srp.fus.len();
        let way = self.ways[wire.ty as usize][from.index() * units + to.index()];
        let latency = self.timing(wire.from, from).latency as i32;
        read + wire.span - issued - latency - way.reach.min(units as u32) as i32
    }

    /// Shifts a node by an II, later or earlier, and with it every node that would otherwise come
    /// too late or too early; not `end`.
    fn shift(&mut self, start: Node, end: Node, later: bool, whole: bool, temperature: u32) {
        let mut moved = vec![false; self.at.len()];
        let mut list = vec![start];
        moved[start.index()] = true;
        let mut next = 0;
        while let Some(&node) = list.get(next) {
            next += 1;
            let wires = self.wires_of[node].iter().map(|&w| {
                let wire = &self.wires[w as usize];
                (wire.from, wire.to, self.slack(wire))
            });
            let orders = self.problem.orders_of[node].iter().map(|&o| {
                let order = &self.problem.orders[o];
                let span = self.ii * order.distance as i32;
                let slack = self.at[order.to].1 + span - self.at[order.from].1 - order.delay as i32;
                (order.from, order.to, slack)
            });
            for (from, to, slack) in wires.chain(orders) {
                let (here, there) = if later { (from, to) } else { (to, from) };
                let other = if here == node { there } else { here };
                if (here == node || whole) && slack < self.ii && !moved[other.index()] {
                    moved[other.index()] = true;
                    list.push(other);
                }
            }
            if moved[end.index()] {
                return;
            }
        }
        let boundary: Vec<usize> = (0..self.wires.len())
            .filter(|&w| moved[self.wires[w].from.index()] != moved[self.wires[w].to.index()])
            .collect();
        let sum = |a: &Self| -> i64 {
            boundary
                .iter()
                .map(|&w| i64::from(a.price(&a.wires[w])))
                .sum()
        };
        let before = sum(self);
        let by = if later { self.ii } else { -self.ii };
        list.iter().for_each(|&n| self.at[n].1 += by);
        let change = sum(self) - before;
        if !self.accepts(change, temperature) {
            list.iter().for_each(|&n| self.at[n].1 -= by);
        }
    }
}
