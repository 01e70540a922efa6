//! A tree in a memory of its own, for units without a scene.

use srp_archdesc::system::SystemSpec;

use super::Tree;
use crate::bvh::{Layout, TreeImage};
use crate::memory::{BASE, SystemMemory};

/// A tree that is laid out for a machine, in a memory of its own.
pub fn place_for(spec: &SystemSpec, tree: &TreeImage) -> (SystemMemory, Tree) {
    assert!(
        tree.layout == Layout::of(&spec.tni),
        "the tree is laid out for the machine"
    );
    place(tree)
}

/// A tree in a memory of its own.
pub(super) fn place(tree: &TreeImage) -> (SystemMemory, Tree) {
    let mut bytes = tree.nodes.clone();
    bytes.resize(bytes.len().next_multiple_of(64), 0);
    let triangles = BASE + bytes.len() as u32;
    bytes.extend_from_slice(&tree.triangles);
    let placed = Tree {
        root: tree.root,
        nodes: BASE,
        triangles,
    };
    (SystemMemory::new(bytes), placed)
}
