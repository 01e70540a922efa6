//! Records of single rays: their costs, and everything that happens to them.

use super::Slot;
use crate::bvh::NodeRef;

/// Notes about rays, where somebody asks for them.
#[derive(Clone, Debug, Default)]
pub(super) struct Recording {
    /// The cost of each ray, in the order of their return.
    pub(super) costs: Option<Vec<RayCost>>,
    /// The parts of the tree that rays have visited.
    pub(super) visits: Option<Vec<Visited>>,
    /// The events of each ray.
    pub(super) events: Option<Vec<Logged>>,
}

/// The cost of one ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayCost {
    /// Its submission, counted from 0 since the unit was made.
    pub submission: u64,
    /// Its position in the ray buffer.
    pub index: u32,
    /// Cycles from dispatch to result.
    pub cycles: u64,
    /// Nodes visited, inner ones and leaves.
    pub visits: u32,
    /// Triangles tested.
    pub tests: u32,
}

/// A part of the tree that a ray has visited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Visited {
    /// TRV_PRE begins with a node.
    Node(NodeRef),
    /// The intersection unit begins with a triangle, by the number of its record.
    Triangle(u32),
}

/// An event of a resident ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Logged {
    /// Cycle of the unit.
    pub cycle: u64,
    /// The ray's place: traversal unit times stacks, plus stack.
    pub slot: Slot,
    /// The event.
    pub event: Event,
}

/// An event of a resident ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// Ray dispatch gives it to a traversal unit.
    Dispatch {
        /// The unit.
        trv: u32,
    },
    /// TRV_PRE begins with a node; whatever had to be read of it is there.
    Visit {
        /// The node.
        node: NodeRef,
        /// Where the ray enters its box.
        enter: f32,
    },
    /// TRV_AABB begins with the boxes of a node's children.
    Boxes {
        /// The children.
        children: [NodeRef; 2],
        /// Where the ray enters them; `None` where it misses, or enters behind the nearest hit.
        enter: [Option<f32>; 2],
    },
    /// TRV_POST decides what comes next.
    Post {
        /// Entries taken off the stack.
        popped: u32,
        /// True if nothing comes next.
        finished: bool,
    },
    /// The intersection unit begins with a triangle.
    Triangle {
        /// Its index in the scene.
        primitive: u32,
        /// Where the ray meets it, if it does.
        t: Option<f32>,
        /// True if that is now the nearest hit.
        taken: bool,
    },
    /// The result goes back to the SRP.
    Result {
        /// The triangle that was hit, and where.
        hit: Option<(u32, f32)>,
    },
}
