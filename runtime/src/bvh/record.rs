//! Triangle records: the words of a triangle that the intersection unit reads, 12 whose meaning is that
//! of the machine's ray–triangle test.

use glam::DVec3;
use srp_archdesc::arch::U;
use srp_archdesc::datapath::Intersection;

use super::{has_area, read_words};
use crate::scene::Triangle;

/// Bytes of the words of a triangle record.
pub const TRIANGLE_BYTES: u32 = 48;

/// A triangle in the words of some test. Word 10 is its index in the scene for all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TriangleRecord {
    words: [u32; 12],
}

/// Word of the triangle's index in the scene.
const PRIMITIVE: usize = 10;

/// The words of Wald's projection (2004), relative to the origin of coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaldWords {
    /// The axis along which the triangle is projected, the longest of its normal; 3 for a triangle
    /// that cannot be hit: of no area, or too thin for binary32.
    pub axis: u32,
    /// The normal's other two components over that of `axis`, in the order of the axes after it.
    pub normal: [f32; 2],
    /// Distance of its plane from the origin along `axis`.
    pub distance: f32,
    /// Coefficients of the two projected coordinates, and of 1, in the weight of vertex 1.
    pub row_u: [f32; 3],
    /// The same for vertex 2.
    pub row_v: [f32; 3],
}

/// The words of the projection relative to one vertex, the anchor: no cancellation far from the
/// origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnchorWords {
    /// As in [`WaldWords`].
    pub axis: u32,
    /// As in [`WaldWords`].
    pub normal: [f32; 2],
    /// Vertex 0 along `axis` and the two axes after it.
    pub anchor: [f32; 3],
    /// Coefficients of the two projected coordinates relative to the anchor, in the weight of vertex 1.
    pub row_u: [f32; 2],
    /// The same for vertex 2.
    pub row_v: [f32; 2],
    /// 2^-23 times the largest sum of magnitudes of `row_u`, `row_v` and their sum, rounded up: how far
    /// a weight can be off per unit of coordinate.
    pub slack: f32,
}

/// The words of Woop's tests: the vertices as they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WoopWords {
    /// The vertices.
    pub vertices: [[f32; 3]; 3],
    /// True if the triangle has no area and cannot be hit.
    pub void: bool,
}

/// A projection along the longest axis of the normal, in binary64.
struct Projection {
    axis: usize,
    normal: [f64; 2],
    row_u: [f64; 2],
    row_v: [f64; 2],
}

impl Projection {
    fn of(edges: [DVec3; 2]) -> Projection {
        let [b, c] = edges;
        let normal = b.cross(c);
        let size = normal.abs();
        let k = (0..3).fold(0, |k, i| if size[i] > size[k] { i } else { k });
        let (u, v) = ((k + 1) % 3, (k + 2) % 3);
        let det = normal[k];
        Projection {
            axis: k,
            normal: [normal[u] / det, normal[v] / det],
            row_u: [c[v] / det, -c[u] / det],
            row_v: [-b[v] / det, b[u] / det],
        }
    }

    /// Upper bound of the change of any of the three weights by one unit of a coordinate.
    fn reach(&self) -> f64 {
        let [(u0, u1), (v0, v1)] = [self.row_u, self.row_v].map(|row| (row[0], row[1]));
        let reach = |a: f64, b: f64| a.abs() + b.abs();
        let third = reach(u0 + v0, u1 + v1);
        reach(u0, u1).max(reach(v0, v1)).max(third)
    }
}

fn narrow<const N: usize>(values: [f64; N]) -> [f32; N] {
    values.map(|x| x as f32)
}

impl TriangleRecord {
    /// The record of a triangle for a test, computed in binary64.
    pub fn of(triangle: &Triangle, primitive: u32, test: Intersection) -> TriangleRecord {
        let mut words = match test {
            Intersection::Wald => wald(triangle),
            Intersection::AnchorWald | Intersection::AnchorWaldScaled => anchored(triangle),
            Intersection::Woop | Intersection::WoopWide => woop(triangle),
        };
        words[PRIMITIVE] = primitive;
        TriangleRecord { words }
    }

    /// Reads a record from its first [`TRIANGLE_BYTES`] bytes.
    #[inline]
    pub fn read(bytes: &[u8]) -> TriangleRecord {
        TriangleRecord {
            words: read_words(bytes),
        }
    }

    /// The words.
    pub fn words(&self) -> &[u32; 12] {
        &self.words
    }

    /// The triangle's index in the scene.
    #[inline]
    pub fn primitive(&self) -> u32 {
        self.words[PRIMITIVE]
    }

    #[inline]
    fn floats<const N: usize>(&self, first: usize) -> [f32; N] {
        std::array::from_fn(|i| f32::from_bits(self.words[first + i]))
    }

    /// The words of a record made for [`Intersection::Wald`].
    #[inline]
    pub fn wald(&self) -> WaldWords {
        WaldWords {
            axis: self.words[0],
            normal: self.floats(1),
            distance: f32::from_bits(self.words[3]),
            row_u: self.floats(4),
            row_v: self.floats(7),
        }
    }

    /// The words of a record made for one of the tests relative to a vertex.
    #[inline]
    pub fn anchored(&self) -> AnchorWords {
        AnchorWords {
            axis: self.words[0],
            normal: self.floats(1),
            anchor: self.floats(3),
            row_u: self.floats(6),
            row_v: self.floats(8),
            slack: f32::from_bits(self.words[11]),
        }
    }

    /// The words of a record made for [`Intersection::Woop`] or [`Intersection::WoopWide`].
    #[inline]
    pub fn woop(&self) -> WoopWords {
        WoopWords {
            vertices: [self.floats(0), self.floats(3), self.floats(6)],
            void: self.words[9] != 0,
        }
    }
}

/// The words of `axis` and `floats` from word 1 on; those of a triangle that cannot be hit where a
/// float does not fit.
fn projected(axis: usize, floats: &[f32], slack: f32) -> [u32; 12] {
    let mut words = [0; 12];
    if floats.iter().all(|x| x.is_finite()) && slack.is_finite() {
        words[0] = axis as u32;
        for (word, value) in words[1..].iter_mut().zip(floats) {
            *word = value.to_bits();
        }
        words[11] = slack.to_bits();
    } else {
        words[0] = 3;
    }
    words
}

fn wald(triangle: &Triangle) -> [u32; 12] {
    let [a, b, c] = triangle.positions.map(|p| p.as_dvec3());
    let p = Projection::of([b - a, c - a]);
    let k = p.axis;
    let (u, v) = ((k + 1) % 3, (k + 2) % 3);
    let distance = a[k] + p.normal[0] * a[u] + p.normal[1] * a[v];
    let row = |row: [f64; 2]| [row[0], row[1], -(row[0] * a[u] + row[1] * a[v])];
    let mut floats = narrow(p.normal).to_vec();
    floats.push(distance as f32);
    floats.extend(narrow(row(p.row_u)));
    floats.extend(narrow(row(p.row_v)));
    projected(k, &floats, 0.0)
}

fn anchored(triangle: &Triangle) -> [u32; 12] {
    let [a, b, c] = triangle.positions.map(|p| p.as_dvec3());
    let p = Projection::of([b - a, c - a]);
    let slack = 2.0 * U * p.reach() * (1.0 + 4.0 * U);
    let k = p.axis;
    let mut floats = narrow(p.normal).to_vec();
    floats.extend([k, (k + 1) % 3, (k + 2) % 3].map(|i| triangle.positions[0][i]));
    floats.extend(narrow(p.row_u));
    floats.extend(narrow(p.row_v));
    projected(k, &floats, slack as f32)
}

fn woop(triangle: &Triangle) -> [u32; 12] {
    let mut words = [0; 12];
    let floats = triangle.positions.iter().flat_map(|p| p.to_array());
    for (word, value) in words.iter_mut().zip(floats) {
        *word = value.to_bits();
    }
    words[9] = u32::from(!has_area(triangle));
    words
}
