//! [`Level`]: the state of the search at one II, and what its attempts have learned there.

use super::order::Freedom;
use super::place::{Conflict, LIGHTEST};
use super::problem::Problem;
use srp_archdesc::entity::EntityMap;
use srp_ir::dfg::Node;

/// The state of the search at one II.
pub(super) struct Level {
    pub(super) freedom: Freedom,
    /// Attempts so far, by way.
    pub(super) attempts: [u32; 4],
    pub(super) times_forced: EntityMap<Node, u32>,
    /// Negotiations that were given up.
    pub(super) hopeless: u32,
    /// Weights of the edges.
    pub(super) weights: Vec<u32>,
    /// The most frequent conflict of the first attempt that failed; `Some(None)` where that was
    /// nothing in particular.
    pub(super) failed: Option<Option<Conflict>>,
}

impl Level {
    pub(super) fn new(problem: &Problem<'_>, ii: u32) -> Level {
        Level {
            freedom: Freedom::at(problem, ii),
            attempts: [0; 4],
            times_forced: EntityMap::filled(problem.dfg.nodes.len(), 0),
            hopeless: 0,
            weights: vec![LIGHTEST; problem.edges.len()],
            failed: None,
        }
    }
}
