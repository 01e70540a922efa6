//! Lower bounds on the costs of a placement's routes.

use super::super::problem::UNREACHABLE;
use super::super::route::{self, MOVE};
use super::ways::out_of;
use super::{Anneal, LATE, LATE_CYCLE, Wire};
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Ty;
use srp_ir::dfg::Node;

/// The price of a value that has no way to its consumer at all.
const NO_WAY: u32 = 100_000;
/// The price of a cycle in which a value waits in an output, where nothing else lands: less than the
/// router's, since a placement with time to spare is easier to route.
const STANDING: u32 = 4;

impl Anneal<'_, '_> {
    /// Returns a lower bound on the cost of a wire's route.
    #[inline]
    pub(super) fn price(&self, wire: &Wire) -> u32 {
        let ((from, issued), (to, read)) = (self.at[wire.from], self.at[wire.to]);
        let way =
            self.ways[wire.ty as usize][from.index() * self.problem.srp.fus.len() + to.index()];
        if way.reach == UNREACHABLE {
            return NO_WAY;
        }
        let ready = issued + self.timing(wire.from, from).latency as i32;
        let spare = read + wire.span - ready - way.reach as i32;
        if spare < 0 {
            return (LATE + LATE_CYCLE * spare.unsigned_abs() + way.direct) * wire.weight;
        }
        let gap = (spare + way.reach as i32) as u32;
        let waiting = if way.held_reach > gap {
            u32::MAX
        } else {
            way.held + route::holding_price(gap)
        };
        let mut price = way.direct;
        if spare > 0 {
            price = if self.stands(wire.from, ready, spare) {
                waiting.min(way.direct + STANDING * spare as u32)
            } else {
                waiting.min(way.direct + route::move_price(1))
            };
        }
        if (MOVE..2 * MOVE).contains(&price)
            && !self.has_room(wire.ty, from, to, ready, ready + gap as i32)
        {
            price += LATE;
        }
        price * wire.weight
    }

    /// True if a value can stay in its unit's output for some cycles after it lands there.
    #[inline]
    pub(super) fn stands(&self, node: Node, ready: i32, cycles: i32) -> bool {
        let Some(ty) = self.results[node] else {
            return false;
        };
        let lands = &self.lands[out_of(self.problem, ty, self.at[node].0)];
        cycles < self.ii && (1..=cycles).all(|k| lands[self.slot(ready + k)].is_none())
    }

    /// True if a unit can move a value that stands in an output from `ready` on to a consumer that
    /// reads it at `arrival`. The unit takes the value from that output while it stands there; its
    /// own value it can also take from its registers. It keeps the value in its own output until
    /// the consumer reads it; the consumer itself can also keep it in its registers.
    fn has_room(&self, ty: Ty, from: Fu, to: Fu, ready: i32, arrival: i32) -> bool {
        let gone = (ready..arrival).find(|&t| self.is_overwritten(ty, from, t + 1));
        let gone = gone.unwrap_or(arrival).min(arrival - 1);
        let between = &self.between[from.index() * self.problem.srp.fus.len() + to.index()];
        between.iter().any(|&fu| {
            let last = if fu == from { arrival - 1 } else { gone };
            for t in (ready.max(last - self.ii + 1)..=last).rev() {
                let free =
                    self.issue[fu][self.slot(t)].is_none() && !self.is_overwritten(ty, fu, t + 1);
                let kept =
                    || fu == to || (t + 2..=arrival).all(|t| !self.is_overwritten(ty, fu, t));
                if free && kept() {
                    return true;
                }
            }
            false
        })
    }

    /// True if a result lands in a unit's output in a cycle.
    #[inline]
    fn is_overwritten(&self, ty: Ty, fu: Fu, time: i32) -> bool {
        self.lands[out_of(self.problem, ty, fu)][self.slot(time)].is_some()
    }

    /// The price of everything around nodes, and of the values whose stay in an output they end.
    pub(super) fn price_around(&self, nodes: &[Node], beside: &[Option<Node>]) -> u32 {
        let mut sum = 0;
        let mut seen: [Option<Node>; 6] = [None; 6];
        let all = nodes
            .iter()
            .copied()
            .chain(beside.iter().flatten().copied());
        for (k, node) in all.enumerate() {
            if seen[..k].contains(&Some(node)) {
                continue;
            }
            seen[k] = Some(node);
            for &w in &self.wires_of[node] {
                let wire = &self.wires[w as usize];
                let other = if wire.from == node {
                    wire.to
                } else {
                    wire.from
                };
                if !seen[..k].contains(&Some(other)) {
                    sum += self.price(wire);
                }
            }
            if k < nodes.len() {
                for &o in &self.problem.orders_of[node] {
                    let order = &self.problem.orders[o];
                    let other = if order.from == node {
                        order.to
                    } else {
                        order.from
                    };
                    if !seen[..k].contains(&Some(other)) {
                        sum += self.order_price(o);
                    }
                }
            }
        }
        sum
    }

    fn order_price(&self, o: usize) -> u32 {
        let order = &self.problem.orders[o];
        let least = self.at[order.from].1 + order.delay as i32;
        let short = least - self.at[order.to].1 - self.ii * order.distance as i32;
        if short > 0 {
            LATE + LATE_CYCLE * short as u32
        } else {
            0
        }
    }
}
