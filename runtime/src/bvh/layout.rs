//! The tree as the T&I unit reads it: pairs of sibling nodes and triangle records in leaf order.
//!
//! A node takes 32 bytes (or less in other [formats](super::node), or more, padded): 6 words of box
//! and 2 words that say where its children or triangles are. Siblings are neighbours, so a pair of 32
//! bytes each shares a 64-byte line; a visit of an inner node reads the pair of its children. The root
//! has no record: a register of the unit refers to it.

use srp_archdesc::datapath::Intersection;
use srp_archdesc::system::{NodeFormat, TniSpec};

use super::Bvh;
use super::node::{Corners, NodeRef, pack, reference_word, rounded, union};
use super::record::TriangleRecord;
use crate::scene::Triangle;

/// Sizes of the records, padded beyond the words that they need, and the tests and formats they serve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// How boxes are stored.
    pub node_format: NodeFormat,
    /// Bytes of a node, at least [`NodeFormat::bytes`].
    pub node_bytes: u32,
    /// Bytes of a triangle record, at least [`TRIANGLE_BYTES`](super::TRIANGLE_BYTES).
    pub triangle_bytes: u32,
    /// The test that the triangle records are for.
    pub intersection: Intersection,
}

impl Layout {
    /// The layout that a unit reads.
    pub fn of(spec: &TniSpec) -> Layout {
        Layout {
            node_format: spec.node_format,
            node_bytes: spec.node_bytes,
            triangle_bytes: spec.triangle_bytes,
            intersection: spec.intersection,
        }
    }
}

/// A tree in the T&I unit's layout.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TreeImage {
    /// The nodes; node `i` at `i * node_bytes`.
    pub nodes: Vec<u8>,
    /// The triangle records in leaf order; record `i` at `i * triangle_bytes`.
    pub triangles: Vec<u8>,
    /// The root; `None` for a scene without triangles.
    pub root: Option<NodeRef>,
    /// Sizes of the records.
    pub layout: Layout,
}

/// Lays out `bvh`, built over `triangles`. Each pair of siblings is followed by all that is below
/// the first of them.
pub fn lay_out(bvh: &Bvh, triangles: &[Triangle], layout: Layout) -> TreeImage {
    let tree = &bvh.tree;
    let mut image = TreeImage {
        nodes: Vec::new(),
        triangles: Vec::new(),
        root: None,
        layout,
    };
    if tree.nodes.is_empty() {
        return image;
    }
    let boxes = boxes(bvh, layout.node_format);
    let word = 4 * reference_word(layout.node_format);
    let mut next_pair = 0;
    let mut next_triangle = 0;
    // Where the reference to a node goes (`None`: the root register), and the node.
    let mut open = vec![(None, 0usize)];
    while let Some((slot, node)) = open.pop() {
        let source = &tree.nodes[node];
        let reference = if source.is_leaf() {
            let first = source.first_index as usize;
            for &p in &tree.primitive_indices[first..first + source.prim_count as usize] {
                let record = TriangleRecord::of(&triangles[p as usize], p, layout.intersection);
                push(&mut image.triangles, record.words(), layout.triangle_bytes);
            }
            let index = next_triangle;
            next_triangle += source.prim_count;
            NodeRef {
                index,
                count: source.prim_count,
            }
        } else {
            let index = next_pair;
            next_pair += 2;
            let first = source.first_index as usize;
            for words in pack([boxes[first], boxes[first + 1]], layout.node_format) {
                push(&mut image.nodes, &words, layout.node_bytes);
            }
            for side in [1, 0] {
                open.push((Some(index + side), (source.first_index + side) as usize));
            }
            NodeRef { index, count: 0 }
        };
        match slot {
            None => image.root = Some(reference),
            Some(slot) => {
                let at = (slot * layout.node_bytes) as usize + word;
                image.nodes[at..at + 4].copy_from_slice(&reference.index.to_le_bytes());
                image.nodes[at + 4..at + 8].copy_from_slice(&reference.count.to_le_bytes());
            }
        }
    }
    image
}

/// The boxes to store of all nodes. That of an inner node holds its children's as they read back, so that
/// no box reaches beyond that of its parent.
fn boxes(bvh: &Bvh, format: NodeFormat) -> Vec<Corners> {
    let nodes = &bvh.tree.nodes;
    let corners = |aabb: &obvhs::aabb::Aabb| [aabb.min.to_array(), aabb.max.to_array()];
    let mut boxes: Vec<Corners> = nodes.iter().map(|n| corners(n.aabb())).collect();
    if format == NodeFormat::F32 {
        return boxes;
    }
    // Parents before children, then backwards.
    let mut order = vec![0];
    let mut next = 0;
    while let Some(&node) = order.get(next) {
        next += 1;
        if !nodes[node].is_leaf() {
            let first = nodes[node].first_index as usize;
            order.extend([first, first + 1]);
        }
    }
    for &node in order.iter().rev().filter(|&&node| !nodes[node].is_leaf()) {
        let first = nodes[node].first_index as usize;
        boxes[node] = union(rounded([boxes[first], boxes[first + 1]], format));
    }
    boxes
}

fn push(bytes: &mut Vec<u8>, words: &[u32], size: u32) {
    let end = bytes.len() + size as usize;
    bytes.extend(words.iter().flat_map(|w| w.to_le_bytes()));
    bytes.resize(end, 0);
}
