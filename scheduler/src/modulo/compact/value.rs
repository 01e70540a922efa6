//! The worth of a schedule beside its II.

use crate::modulo::place::Placement;
use crate::modulo::problem::Problem;
use crate::modulo::table::Item;

/// The price of a placement, in the order in which its parts count: less is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Value {
    /// Cycles of an iteration. A launch of n iterations takes (n − 1) · II + length of them, whatever n is.
    pub(super) length: u32,
    /// Times that modulo variable expansion repeats the kernel: contexts are the II times these.
    pub(super) copies: u32,
    /// Routing moves: each takes an issue slot, and energy.
    pub(super) moves: u32,
    /// Cycles for which values stand in registers, of all values of an iteration together.
    pub(super) held: u32,
}

impl Value {
    pub(super) fn of(problem: &Problem<'_>, placement: &Placement) -> Value {
        let files = problem.graph.file.values();
        let stays = files.flat_map(|&place| placement.registers.stays(place));
        let mut value = Value {
            length: placement.length(problem),
            // Rings are powers of two, so the longest is a multiple of all.
            copies: stays.map(|stay| stay.ring).max().unwrap_or(1).max(1),
            moves: 0,
            held: 0,
        };
        for item in problem
            .nodes()
            .flat_map(|node| placement.table.items_of(node))
        {
            match item {
                Item::Move(..) => value.moves += 1,
                Item::Held(..) => value.held += 1,
                _ => {}
            }
        }
        value
    }
}
