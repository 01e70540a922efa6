//! Pairs of sibling nodes as they lie in memory: two boxes and two references, in one of the machine's
//! formats. Boxes that do not fit a format are rounded outward, and a box never reaches beyond that of
//! its parent, so no ray misses a box or a triangle that it would have met.
//!
//! * `f32`: 6 words of corners, 2 of reference.
//! * `f16`: 6 binary16 numbers, 2 words of reference. A corner beyond all numbers is infinite.
//! * `q8`: lowest and highest corner as multiples, 0 to 255, of a power of two for each axis from the
//!   lowest corner of both boxes. Bytes 3 and 7 of the first node and byte 3 of the second are these
//!   powers, as biased exponents of binary32; words 2 and 3 of the first node and word 2 of the second
//!   are the corner. The last two words are the reference.

use serde::{Deserialize, Serialize};
use srp_archdesc::system::NodeFormat;

use super::read_words;

/// A box: lowest and highest corner.
pub(super) type Corners = [[f32; 3]; 2];

/// A node, as its parent's record or the root register names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct NodeRef {
    /// Of an inner node: index of the first of its two children. Of a leaf: index of its first
    /// triangle record.
    pub index: u32,
    /// Triangles of a leaf; 0 for an inner node.
    pub count: u32,
}

impl NodeRef {
    /// True if it is a leaf.
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

/// Word of the reference in a node of this format.
pub(super) const fn reference_word(format: NodeFormat) -> usize {
    format.bytes() as usize / 4 - 2
}

impl PairRecord {
    /// Reads a pair whose second node starts `node_bytes` after the first, at least
    /// [`NodeFormat::bytes`]. `bytes` holds both.
    #[inline]
    pub fn read(bytes: &[u8], node_bytes: usize, format: NodeFormat) -> PairRecord {
        let nodes = [bytes, &bytes[node_bytes..]];
        match format {
            NodeFormat::F32 => {
                let mut pair = PairRecord::default();
                for (side, node) in nodes.into_iter().enumerate() {
                    let words = read_words::<8>(node);
                    for axis in 0..3 {
                        pair.min[side][axis] = f32::from_bits(words[axis]);
                        pair.max[side][axis] = f32::from_bits(words[3 + axis]);
                    }
                    pair.child[side] = reference([words[6], words[7]]);
                }
                pair
            }
            NodeFormat::F16 => {
                let mut pair = PairRecord::default();
                for (side, node) in nodes.into_iter().enumerate() {
                    let words = read_words::<5>(node);
                    let half = |i: usize| from_half((words[i / 2] >> (16 * (i % 2))) as u16);
                    pair.min[side] = [half(0), half(1), half(2)];
                    pair.max[side] = [half(3), half(4), half(5)];
                    pair.child[side] = reference([words[3], words[4]]);
                }
                pair
            }
            NodeFormat::Q8 => unpack_q8(nodes.map(read_words::<6>)),
        }
    }
}

fn reference([index, count]: [u32; 2]) -> NodeRef {
    NodeRef { index, count }
}

/// The words of two boxes, without their references, and the boxes that will be read from them.
pub(super) fn pack(boxes: [Corners; 2], format: NodeFormat) -> [Vec<u32>; 2] {
    match format {
        NodeFormat::F32 => boxes.map(|b| b.as_flattened().iter().map(|x| x.to_bits()).collect()),
        NodeFormat::F16 => boxes.map(|[min, max]| {
            let halves = min.map(half_below).into_iter().chain(max.map(half_above));
            let halves: Vec<u32> = halves.map(u32::from).collect();
            halves.chunks(2).map(|h| h[0] | h[1] << 16).collect()
        }),
        NodeFormat::Q8 => pack_q8(boxes),
    }
}

/// The boxes as they are read again.
pub(super) fn rounded(boxes: [Corners; 2], format: NodeFormat) -> [Corners; 2] {
    let mut bytes = Vec::new();
    for mut words in pack(boxes, format) {
        words.extend([0; 2]);
        bytes.extend(words.iter().flat_map(|w| w.to_le_bytes()));
    }
    let pair = PairRecord::read(&bytes, format.bytes() as usize, format);
    [0, 1].map(|side| [pair.min[side], pair.max[side]])
}

/// The smallest box that holds both.
pub(super) fn union([a, b]: [Corners; 2]) -> Corners {
    let axes = [0, 1, 2];
    [
        axes.map(|k| a[0][k].min(b[0][k])),
        axes.map(|k| a[1][k].max(b[1][k])),
    ]
}

/// The largest exponent of binary32 that steps of `q8` have.
const LARGEST_EXPONENT: u32 = 247;

/// `steps` of a size from `origin`.
#[inline]
fn stepped(origin: f32, steps: u32, exponent: u32) -> f32 {
    origin + steps as f32 * f32::from_bits(exponent << 23)
}

/// The numbers of steps from `origin` that hold an interval, as they are read again; `None` where
/// steps of this size are too small.
fn steps(origin: f32, lo: f32, hi: f32, exponent: u32) -> Option<[u32; 2]> {
    let size = f64::from(f32::from_bits(exponent << 23));
    let from = |x: f32| (f64::from(x) - f64::from(origin)) / size;
    let mut low = from(lo).floor().clamp(0.0, 255.0) as u32;
    while low > 0 && stepped(origin, low, exponent) > lo {
        low -= 1;
    }
    let mut high = from(hi).ceil().clamp(0.0, 256.0) as u32;
    while high <= 255 && stepped(origin, high, exponent) < hi {
        high += 1;
    }
    (high <= 255).then_some([low, high])
}

fn pack_q8(boxes: [Corners; 2]) -> [Vec<u32>; 2] {
    let [origin, end] = union(boxes);
    let mut corners = [[0u32; 2]; 2];
    let mut exponents = [0; 3];
    for axis in 0..3 {
        let fits = |exponent: u32| {
            let [a, b] = boxes.map(|[lo, hi]| steps(origin[axis], lo[axis], hi[axis], exponent));
            Some((exponent, [a?, b?]))
        };
        let least = ((end[axis] - origin[axis]) / 256.0).to_bits() >> 23;
        let found = (least.clamp(1, LARGEST_EXPONENT)..=LARGEST_EXPONENT).find_map(fits);
        // Coordinates of scenes are far below what the largest steps reach.
        let (exponent, boxes) = found.unwrap_or((LARGEST_EXPONENT, [[0, 255]; 2]));
        exponents[axis] = exponent;
        for (words, bounds) in corners.iter_mut().zip(boxes) {
            for (word, bound) in words.iter_mut().zip(bounds) {
                *word |= bound << (8 * axis);
            }
        }
    }
    let [first, second] = corners;
    let [x, y, z] = origin.map(f32::to_bits);
    let [ex, ey, ez] = exponents.map(|e| e << 24);
    [
        vec![first[0] | ex, first[1] | ey, x, y],
        vec![second[0] | ez, second[1], z, 0],
    ]
}

#[inline]
fn unpack_q8([first, second]: [[u32; 6]; 2]) -> PairRecord {
    let origin = [first[2], first[3], second[2]].map(f32::from_bits);
    let exponents = [first[0] >> 24, first[1] >> 24, second[0] >> 24];
    let corner = |word: u32| {
        [0, 1, 2].map(|k: usize| stepped(origin[k], (word >> (8 * k)) & 0xff, exponents[k]))
    };
    PairRecord {
        min: [corner(first[0]), corner(second[0])],
        max: [corner(first[1]), corner(second[1])],
        child: [
            reference([first[4], first[5]]),
            reference([second[4], second[5]]),
        ],
    }
}

/// The value of a binary16 number.
#[inline]
fn from_half(bits: u16) -> f32 {
    let (exponent, fraction) = (u32::from(bits >> 10) & 0x1f, u32::from(bits) & 0x3ff);
    let magnitude = match exponent {
        0 => fraction as f32 * (1.0 / 16_777_216.0),
        31 => f32::INFINITY,
        e => f32::from_bits((e + 112) << 23 | fraction << 13),
    };
    if bits >> 15 == 0 {
        magnitude
    } else {
        -magnitude
    }
}

/// The largest binary16 number that is not above `x`.
fn half_below(x: f32) -> u16 {
    const LARGEST: u16 = 0x7bff;
    let magnitude = x.abs();
    let toward_zero = if magnitude >= from_half(LARGEST) {
        LARGEST
    } else if magnitude < 1.0 / 16384.0 {
        (magnitude * 16_777_216.0) as u16
    } else {
        let bits = magnitude.to_bits();
        (((bits >> 23) - 112) << 10 | (bits & 0x7f_ffff) >> 13) as u16
    };
    if x >= 0.0 {
        toward_zero
    } else {
        // Away from zero where something was cut off; behind the largest number is infinity.
        (toward_zero + u16::from(from_half(toward_zero) < magnitude)) | 0x8000
    }
}

/// The least binary16 number that is not below `x`.
fn half_above(x: f32) -> u16 {
    half_below(-x) ^ 0x8000
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_enclose_every_number() {
        for bits in (0..u32::MAX).step_by(4099) {
            let x = f32::from_bits(bits);
            if !x.is_finite() {
                continue;
            }
            let (below, above) = (from_half(half_below(x)), from_half(half_above(x)));
            assert!(below <= x && x <= above, "{below} {x} {above}");
            if below.is_finite() && above.is_finite() {
                let place = (x.abs() / 1024.0).max(1.0 / 16_777_216.0);
                assert!(above - below <= place, "{below} {x} {above}");
            }
        }
        for half in 0..0x7c00u16 {
            let x = from_half(half);
            assert_eq!((half_below(x), from_half(half_above(x))), (half, x));
        }
    }

    #[test]
    fn packed_boxes_hold_theirs() {
        let coordinates = [
            -3.0e12f32, -65_505.0, -1000.03, -1.0e-3, -1.0e-40, 0.0, 1.0e-9, 0.1, 1.0, 255.5,
            4096.7, 1.0e6, 7.0e17,
        ];
        let count = coordinates.len();
        for format in NodeFormat::ALL {
            for i in 0..count * count * count {
                let at = |k: usize| coordinates[(i / count.pow(k as u32)) % count];
                let corners = |a: f32, b: f32| [[a.min(b); 3], [a.max(b); 3]];
                let mut boxes = [corners(at(0), at(1)), corners(at(1), at(2))];
                boxes[0][1][2] = boxes[0][0][2];
                for (exact, read) in boxes.iter().zip(rounded(boxes, format)) {
                    for axis in 0..3 {
                        assert!(read[0][axis] <= exact[0][axis], "{boxes:?} {format:?}");
                        assert!(read[1][axis] >= exact[1][axis], "{boxes:?} {format:?}");
                    }
                    assert!(format != NodeFormat::F32 || read == *exact);
                }
            }
        }
    }
}
