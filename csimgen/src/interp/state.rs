//! The interpreter's steps, and the state that they work on.

use crate::preamble::border::{Border, Fault};
use crate::preamble::ops::V4;
use srp_runtime::core::Bus;
use std::ops::Range;

/// A cell: its index in [`State::cells`].
pub(super) type Index = u32;

/// Carries out a step: reads its operands from the state and writes its result there.
pub(super) type Runner =
    for<'a, 'b> fn(&mut State, &Micro, &mut Border<'a, dyn Bus + 'b>) -> Result<(), Box<Fault>>;

/// One step.
#[derive(Clone, Copy)]
pub(super) struct Micro {
    pub(super) run: Runner,
    pub(super) operands: [Index; 3],
    /// The first two cells written; twice the same if there is but one.
    pub(super) dests: [Index; 2],
    /// Further cells, a range of [`State::dests`].
    pub(super) more: (u32, u32),
    /// Offset, immediate, or precision.
    pub(super) extra: [u32; 2],
    pub(super) at: u32,
}

/// A rotating file. Its registers are moved when an iteration begins, so that a name is always the
/// same cell.
#[derive(Clone)]
pub(super) struct Rotating {
    pub(super) cells: Range<usize>,
    /// How far they are from their physical order.
    pub(super) advanced: usize,
}

/// The state that changes while a program runs, and the tables that are read with it.
#[derive(Clone)]
pub(super) struct State {
    /// The registers, then constants, then one for results under way.
    pub(super) cells: Vec<V4>,
    pub(super) dests: Vec<Index>,
    pub(super) rotating: Vec<Rotating>,
    pub(super) result: Index,
}
