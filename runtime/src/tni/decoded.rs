//! The inner nodes of a tree, read once: for tracing without time, which would else unpack the same boxes
//! over and over.

use std::sync::Arc;

use srp_archdesc::system::TniSpec;

use super::Tree;
use super::function::Function;
use crate::bvh::{NodeRef, PairRecord};
use crate::memory::SystemMemory;

/// Two sibling boxes, side by side: of the lowest corners and of the highest, for each axis, that of the
/// first box and that of the second.
pub(super) type Corners = [[[f32; 2]; 3]; 2];

/// Two siblings.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pair {
    pub(super) corners: Corners,
    pub(super) child: [NodeRef; 2],
}

impl From<PairRecord> for Pair {
    fn from(record: PairRecord) -> Pair {
        let axes = [0, 1, 2];
        let side_by_side = |c: &[[f32; 3]; 2]| axes.map(|axis| [c[0][axis], c[1][axis]]);
        Pair {
            corners: [side_by_side(&record.min), side_by_side(&record.max)],
            child: record.child,
        }
    }
}

/// The pairs of siblings that can be reached from the root, by half the number of their first node.
#[derive(Clone, Debug, Default)]
pub(super) struct Decoded {
    pairs: Vec<Pair>,
    /// Inner nodes one below the other: no walk has more nodes on its stack.
    pub(super) depth: usize,
}

impl Decoded {
    /// Reads a tree.
    pub(super) fn of(function: &Function<'_>) -> Decoded {
        let mut decoded = Decoded::default();
        let Tree { root, .. } = *function.tree;
        let mut open: Vec<(NodeRef, usize)> = root.map(|root| (root, 0)).into_iter().collect();
        while let Some((node, depth)) = open.pop() {
            if node.is_leaf() {
                continue;
            }
            let place = node.index as usize / 2;
            if decoded.pairs.len() <= place {
                decoded.pairs.resize(place + 1, Pair::default());
            }
            let pair = Pair::from(function.pair(node));
            decoded.pairs[place] = pair;
            decoded.depth = decoded.depth.max(depth + 1);
            open.extend(pair.child.map(|child| (child, depth + 1)));
        }
        decoded
    }

    /// Reads a tree, for several tracers.
    pub(super) fn shared(spec: &TniSpec, tree: &Tree, memory: &SystemMemory) -> Arc<Decoded> {
        Arc::new(Decoded::of(&Function { spec, tree, memory }))
    }

    /// The children of an inner node.
    #[inline]
    pub(super) fn pair(&self, node: NodeRef) -> &Pair {
        &self.pairs[node.index as usize / 2]
    }
}
