//! A ray that is resident in the unit: everything that travels with it.

use super::arithmetic::{Hit, Prepared};
use super::fetch::Need;
use super::walk::{Next, Walk};
use crate::bvh::NodeRef;
use serde::{Deserialize, Serialize};

/// The task of a resident ray at the moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Phase {
    /// It visits the node of its walk.
    Visit,
    /// It comes back from the intersection unit and takes the next node off its stack.
    Pop,
}

/// A resident ray.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct RayState {
    pub(super) ray: Prepared,
    pub(super) flags: u32,
    pub(super) hit: Hit,
    pub(super) walk: Walk,
    pub(super) phase: Phase,
    /// Results of TRV_AABB: the children and where the ray enters them.
    pub(super) children: [NodeRef; 2],
    pub(super) enter: [Option<f32>; 2],
    /// True if TRV_AABB knows what comes next, so that TRV_POST has nothing to do.
    pub(super) direct: bool,
    /// The decision of TRV_POST.
    pub(super) next: Next,
    /// Lines still to be read: the next, and the last.
    pub(super) line: u32,
    pub(super) last_line: u32,
    /// Triangle to be tested, and how many of the leaf there are from it on.
    pub(super) triangle: u32,
    pub(super) triangles: u32,
    /// Position of its submission in the order of all, and its own in it.
    pub(super) submission: u64,
    pub(super) index: u32,
    /// Cycle in which it was dispatched, and in which it went to an intersection unit.
    pub(super) since: u64,
    pub(super) ist_since: u64,
    /// Nodes visited, and triangles tested.
    pub(super) visits: u32,
    pub(super) tests: u32,
}

impl RayState {
    pub(super) fn new(stack_depth: u32) -> RayState {
        RayState {
            ray: Prepared::default(),
            flags: 0,
            hit: Hit::none(0.0),
            walk: Walk::new(stack_depth),
            phase: Phase::Visit,
            children: [NodeRef::default(); 2],
            enter: [None; 2],
            direct: false,
            next: Next::Finished,
            line: 1,
            last_line: 0,
            triangle: 0,
            triangles: 0,
            submission: 0,
            index: 0,
            since: 0,
            ist_since: 0,
            visits: 0,
            tests: 0,
        }
    }

    /// Needs the lines of 2^`shift` bytes that hold `bytes` bytes from `address` on.
    #[inline]
    pub(super) fn need(&mut self, address: u32, bytes: u32, shift: u32) {
        self.line = address >> shift;
        self.last_line = (address + bytes - 1) >> shift;
    }

    /// Needs nothing.
    pub(super) fn need_nothing(&mut self) {
        (self.line, self.last_line) = (1, 0);
    }

    /// The next line it needs.
    pub(super) fn needs(&self) -> Need {
        if self.line <= self.last_line {
            Need::Line(self.line)
        } else {
            Need::Nothing
        }
    }

    /// Has got a line; says whether that was all.
    pub(super) fn got_line(&mut self) -> bool {
        if self.line <= self.last_line {
            self.line += 1;
        }
        self.line > self.last_line
    }
}
