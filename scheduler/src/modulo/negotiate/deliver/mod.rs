//! The cheapest deliveries of a value: to everywhere from what it has, and from everywhere to where it
//! is wanted.
//!
//! A pass over the cycles computes both for all places at once, each cycle a few additions and minima
//! of vectors. [`Deliver::forward`] starts at no cost from every point that the value reaches already,
//! so that consumers share what leads to them. Costs are 16-bit integers: hosts agree, and vectors are
//! long.

mod backward;
mod forward;
mod map;

use super::lanes::{Lanes, Ways};
use super::market::Market;
use crate::modulo::rows::{NEVER, relax_by_all};
pub(super) use map::{Map, Own};
use srp_archdesc::arch::{Fu, FuOp};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Ty;

/// Where a value is wanted.
#[derive(Clone, Copy)]
pub(super) enum Goal {
    /// At the inputs of a unit in the last cycle.
    Operand(usize),
    /// In a register for good, by lane, at a price for all slots.
    Keep(usize, i32),
}

/// Deliveries on one machine at the prices of the moment.
pub(super) struct Deliver<'a> {
    pub(super) lanes: &'a Lanes,
    pub(super) market: &'a Market,
    /// True when the value may live longer than it can stay in a file that does not rotate.
    pub(super) lives_long: bool,
    /// The last cycle in which a move or a transfer may land.
    pub(super) deadline: i32,
}

impl Deliver<'_> {
    fn ways(&self, ty: Ty) -> &Ways {
        &self.lanes.ways[ty as usize]
    }

    /// Prices of standing where the value stood before, by lane.
    fn stay_row(&self, time: i32) -> &[i16] {
        let slot = self.market.slot(time);
        match self.lives_long {
            true => self.market.hold_long_row(slot),
            false => self.market.hold_row(slot),
        }
    }

    /// Adds the cost of all that a move holds besides an issue slot to the cost of one of its ends.
    fn odd_move(&self, ways: &Ways, fu: Fu, issue: i32, timing: &FuOp, cost: i16) -> i16 {
        let Some(landing) = ways.landing[fu.index()] else {
            return NEVER;
        };
        let lands = issue + landing.latency;
        let hold = self.market.hold_row(self.market.slot(lands))[landing.lane];
        let operation = self.market.operation(fu, issue, timing);
        let operation = operation.min(i32::from(NEVER)) as i16;
        cost.saturating_add(operation).saturating_add(hold)
    }
}

/// Lowers the costs of one end of moves by those of the other: what a move issues and where it lands.
#[inline(always)]
fn over_moves(
    ways: &Ways,
    to: &mut [i16],
    from: &[i16],
    (issue, mask): (&[i16], &[i16]),
    hold: &[i16],
) {
    if let Some(block) = ways.landing_block {
        relax_by_all(to, from, (issue, &hold[block..], mask));
        return;
    }
    for (unit, landing) in ways.landing.iter().enumerate() {
        if let Some(landing) = landing {
            let cost = from[unit].saturating_add(issue[unit]);
            let cost = cost.saturating_add(hold[landing.lane]);
            to[unit] = to[unit].min(cost.saturating_add(mask[unit]));
        }
    }
}
