//! A smaller II from a short schedule.
//!
//! Where most slots are taken, searches that start from anywhere fail at IIs at which there are schedules. One that has
//! been made short at the next larger II is a better start: its operations are near those that they give values to, and
//! these live for a short time. It goes on at the smaller II with its units and its cycles, which are pressed or stretched
//! to somewhat more than its length.

use super::times::press;
use super::{Bound, Lanes, Negotiation};
use crate::modulo::MAX_STAGES;
use crate::modulo::place::Placement;
use crate::modulo::problem::Problem;
use srp_archdesc::Watch;
use srp_ir::dre::scheduled::Reg;

/// How a negotiation goes about it: the stage that it starts from, the part of the length that it has beyond it, one in
/// so many, and its changes for each node.
struct Try {
    stage: u32,
    room: u32,
    steps: u64,
}

/// These have their turns.
const TRIES: [Try; 4] = [
    Try {
        stage: 14,
        room: 5,
        steps: 300,
    },
    Try {
        stage: 10,
        room: 16,
        steps: 300,
    },
    Try {
        stage: 17,
        room: 5,
        steps: 200,
    },
    Try {
        stage: 12,
        room: 5,
        steps: 300,
    },
];

/// A placement with the next smaller II, if one is found with so much effort.
pub(in crate::modulo) fn tighten(
    problem: &Problem<'_>,
    fixed: &[Reg],
    placement: &Placement,
    effort: u64,
    watch: &dyn Watch,
) -> Option<Placement> {
    let lanes = Lanes::of(problem);
    let (start, length) = (placement.start(), placement.length(problem));
    let was = Bound::at(problem, placement.ii, length).freedom(start, start + length as i32);
    let ii = placement.ii - 1;
    // No path is longer than all that there is.
    let bound = Bound::at(problem, ii, u32::MAX / 4);
    let mut left = effort;
    for seed in 0.. {
        if left == 0 || watch.cancelled() {
            return None;
        }
        let Try { stage, room, steps } = TRIES[seed % TRIES.len()];
        let deadline = start + (length + length / room).max(bound.length) as i32;
        let freedom = bound.freedom(start, deadline);
        if freedom.is_empty() {
            return None;
        }
        let times = press(problem, placement, &was, &freedom);
        let (from, by) = ((placement, &times), (&freedom, deadline));
        let mut run = Negotiation::from(problem, &lanes, from, by, fixed, ii, seed as u32);
        let found = run.shorten(stage, steps, left, watch);
        left = left.saturating_sub(run.effort().max(1));
        let found = found.ok();
        if let Some(found) = found.filter(|found| found.stages(problem) <= MAX_STAGES) {
            return Some(found);
        }
    }
    None
}
