//! The tree as the T&I unit reads it: pairs of sibling nodes and triangle records in leaf order.
//!
//! A node takes 32 bytes (or more, padded): 6 words of box and 2 words that say where its children
//! or triangles are. Siblings are neighbours, so a pair shares a 64-byte line; a visit of an inner
//! node reads the pair of its children. The root has no record: a register of the unit refers to it.

use super::Bvh;
use crate::scene::Triangle;

/// Bytes of the words of a node.
pub const NODE_BYTES: u32 = 32;

/// Bytes of the words of a triangle record.
pub const TRIANGLE_BYTES: u32 = 48;

/// Sizes of the records; what is more than their words need is padding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Bytes of a node, at least [`NODE_BYTES`].
    pub node_bytes: u32,
    /// Bytes of a triangle record, at least [`TRIANGLE_BYTES`].
    pub triangle_bytes: u32,
}

/// A node, as its parent's record or the root register names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct NodeRef {
    /// Of an inner node: index of the first of its two children. Of a leaf: index of its first
    /// triangle record.
    pub index: u32,
    /// Triangles of a leaf; 0 for an inner node.
    pub count: u32,
}

impl NodeRef {
    /// Whether it is a leaf.
    pub const fn is_leaf(self) -> bool {
        self.count != 0
    }
}

/// Two siblings: boxes and references.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct PairRecord {
    /// Lowest corners.
    pub min: [[f32; 3]; 2],
    /// Highest corners.
    pub max: [[f32; 3]; 2],
    /// The nodes.
    pub child: [NodeRef; 2],
}

impl PairRecord {
    /// Reads a pair whose second node starts `node_bytes` after the first, at least
    /// [`NODE_BYTES`]. `bytes` holds both.
    #[inline]
    pub fn read(bytes: &[u8], node_bytes: usize) -> PairRecord {
        let mut pair = PairRecord::default();
        for side in 0..2 {
            let words = read_words::<8>(&bytes[side * node_bytes..]);
            for axis in 0..3 {
                pair.min[side][axis] = f32::from_bits(words[axis]);
                pair.max[side][axis] = f32::from_bits(words[3 + axis]);
            }
            pair.child[side] = NodeRef {
                index: words[6],
                count: words[7],
            };
        }
        pair
    }
}

/// A triangle as the intersection unit tests it: Wald's projection (2001/2004) relative to one
/// vertex, the anchor, instead of relative to the origin. The same words and operations, but no
/// cancellation far from the origin.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct TriangleRecord {
    /// The axis along which the triangle is projected, the longest of its normal; 3 for a triangle
    /// that cannot be hit: of no area, or too thin for binary32.
    pub axis: u32,
    /// The normal's other two components over that of `axis`, in the order of the axes after it.
    pub normal: [f32; 2],
    /// Vertex 0 along `axis` and the two axes after it.
    pub anchor: [f32; 3],
    /// What the two projected coordinates relative to the anchor give to the weight of vertex 1.
    pub row_u: [f32; 2],
    /// The same for vertex 2.
    pub row_v: [f32; 2],
    /// The triangle's index in the scene.
    pub primitive: u32,
    /// 2^-23 times the larger sum of magnitudes of `row_u` and `row_v`, rounded up: how far a
    /// weight can be off per unit of coordinate.
    pub slack: f32,
}

/// Unit roundoff of binary32.
const U: f64 = 1.0 / (1 << 24) as f64;

impl TriangleRecord {
    /// The record of a triangle, computed in binary64.
    pub fn of(triangle: &Triangle, primitive: u32) -> TriangleRecord {
        let [a, b, c] = triangle.positions.map(|p| p.as_dvec3());
        let (b, c) = (b - a, c - a);
        let normal = b.cross(c);
        let size = normal.abs();
        let k = (0..3).fold(0, |k, i| if size[i] > size[k] { i } else { k });
        let (u, v) = ((k + 1) % 3, (k + 2) % 3);
        let det = normal[k];
        let row_u = [c[v] / det, -c[u] / det];
        let row_v = [-b[v] / det, b[u] / det];
        let reach = |row: [f64; 2]| row[0].abs() + row[1].abs();
        let slack = 2.0 * U * reach(row_u).max(reach(row_v)) * (1.0 + 4.0 * U);
        let narrow = |pair: [f64; 2]| pair.map(|x| x as f32);
        let record = TriangleRecord {
            axis: k as u32,
            normal: narrow([normal[u] / det, normal[v] / det]),
            anchor: [k, u, v].map(|i| triangle.positions[0][i]),
            row_u: narrow(row_u),
            row_v: narrow(row_v),
            primitive,
            slack: slack as f32,
        };
        let all = [record.normal, record.row_u, record.row_v];
        if all.as_flattened().iter().all(|x| x.is_finite()) && record.slack.is_finite() {
            record
        } else {
            TriangleRecord {
                axis: 3,
                primitive,
                ..TriangleRecord::default()
            }
        }
    }

    /// Reads a record from its first [`TRIANGLE_BYTES`] bytes.
    #[inline]
    pub fn read(bytes: &[u8]) -> TriangleRecord {
        let words = read_words::<12>(bytes);
        let float = |i: usize| f32::from_bits(words[i]);
        TriangleRecord {
            axis: words[0],
            normal: [float(1), float(2)],
            anchor: [float(3), float(4), float(5)],
            row_u: [float(6), float(7)],
            row_v: [float(8), float(9)],
            primitive: words[10],
            slack: float(11),
        }
    }

    fn words(&self) -> [u32; 12] {
        let mut words = [0; 12];
        words[0] = self.axis;
        let floats = [
            &self.normal[..],
            &self.anchor[..],
            &self.row_u[..],
            &self.row_v[..],
        ];
        for (word, value) in words[1..10].iter_mut().zip(floats.into_iter().flatten()) {
            *word = value.to_bits();
        }
        words[10] = self.primitive;
        words[11] = self.slack.to_bits();
        words
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
    let mut next_pair = 0;
    let mut next_triangle = 0;
    // Where the reference to a node goes (`None`: the root register), and the node.
    let mut open = vec![(None, 0usize)];
    while let Some((slot, node)) = open.pop() {
        let source = &tree.nodes[node];
        let reference = if source.is_leaf() {
            let first = source.first_index as usize;
            for &p in &tree.primitive_indices[first..first + source.prim_count as usize] {
                let record = TriangleRecord::of(&triangles[p as usize], p);
                push(&mut image.triangles, &record.words(), layout.triangle_bytes);
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
            for side in 0..2 {
                let aabb = tree.nodes[source.first_index as usize + side].aabb();
                let corners = [aabb.min.to_array(), aabb.max.to_array()];
                let mut words = [0; 8];
                for (word, x) in words.iter_mut().zip(corners.as_flattened()) {
                    *word = x.to_bits();
                }
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
                let at = (slot * layout.node_bytes) as usize;
                image.nodes[at + 24..at + 28].copy_from_slice(&reference.index.to_le_bytes());
                image.nodes[at + 28..at + 32].copy_from_slice(&reference.count.to_le_bytes());
            }
        }
    }
    image
}

fn push(bytes: &mut Vec<u8>, words: &[u32], size: u32) {
    let end = bytes.len() + size as usize;
    bytes.extend(words.iter().flat_map(|w| w.to_le_bytes()));
    bytes.resize(end, 0);
}

#[inline]
fn read_words<const N: usize>(bytes: &[u8]) -> [u32; N] {
    let mut words = [0; N];
    for (word, bytes) in words.iter_mut().zip(bytes[..4 * N].chunks_exact(4)) {
        *word = u32::from_le_bytes(bytes.try_into().expect("chunks of 4 bytes"));
    }
    words
}
