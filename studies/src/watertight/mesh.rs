//! Families of meshes that are hard to hit or to miss: slivers, needles, far from the origin, very small and very large.

use super::Made;
use crate::exact;
use crate::hard_cases::meshes::{sphere, triangle};
use glam::Vec3;
use srp_runtime::scene::{Triangle, bounds};
use std::collections::BTreeMap;
use std::f32::consts::TAU;

/// A mesh: of a family, or one's own.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Its name, which a file can have.
    pub(super) name: String,
    /// Its triangles.
    pub(super) triangles: Vec<Triangle>,
    /// Its middle.
    pub(super) centre: Vec3,
    /// About its radius.
    pub(super) size: f32,
    /// Its form.
    pub(super) form: Form,
}

/// The form of a mesh, which says how rays can be aimed at it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Form {
    /// Closed and nearly convex: from inside, every ray hits.
    Closed,
    /// A tube along z, open at its ends, so many times as long as it is wide.
    Tube(f32),
    /// An open ground, to be seen from above.
    Ground,
    /// Nothing is known of it.
    Any,
}

impl Mesh {
    fn new(name: &str, triangles: Vec<Triangle>, (centre, size): (Vec3, f32), form: Form) -> Mesh {
        Mesh {
            name: name.to_owned(),
            triangles,
            centre,
            size,
            form,
        }
    }

    /// A mesh of triangles of which nothing is known; nothing where there are none.
    pub fn of(name: &str, triangles: Vec<Triangle>) -> Option<Mesh> {
        let (low, high) = bounds(&triangles)?;
        // Halves first: the sum of large ones is infinite.
        let [low, high] = [low, high].map(|corner| 0.5 * corner);
        let (centre, size) = (low + high, (high - low).max_element());
        Some(Mesh::new(name, triangles, (centre, size), Form::Any))
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How it is made, if it is one's own.
    pub(super) fn made(&self) -> Option<Made> {
        (self.form == Form::Any).then(|| {
            let mut edges: BTreeMap<[[u32; 3]; 2], u64> = BTreeMap::new();
            let has_area = |t: &&Triangle| !exact::is_degenerate(t);
            let solid: Vec<&Triangle> = self.triangles.iter().filter(has_area).collect();
            for triangle in &solid {
                // A zero is one, whatever its sign.
                let [a, b, c] = triangle
                    .positions
                    .map(|p| p.to_array().map(|x| (x + 0.0).to_bits()));
                for [p, q] in [[a, b], [b, c], [c, a]] {
                    *edges.entry([p.min(q), p.max(q)]).or_default() += 1;
                }
            }
            Made {
                mesh: self.name.clone(),
                triangles: self.triangles.len() as u64,
                degenerate: (self.triangles.len() - solid.len()) as u64,
                borders: edges.values().filter(|&&count| count == 1).count() as u64,
            }
        })
    }

    /// As the text of an `.obj` file: every number is that of the triangle, to the bit.
    pub(super) fn obj(&self) -> String {
        let mut text = format!("# {}\n", self.name);
        for t in &self.triangles {
            for p in t.positions {
                text.push_str(&format!("v {:e} {:e} {:e}\n", p.x, p.y, p.z));
            }
            text.push_str("f -3 -2 -1\n");
        }
        text
    }
}

/// Far from the origin.
const FAR: Vec3 = Vec3::new(1e4, -3e3, 7e3);

/// All meshes.
pub(super) fn all() -> Vec<Mesh> {
    let ball = |name, quadrilaterals, radius, centre| {
        let triangles = sphere(quadrilaterals, radius, centre);
        Mesh::new(name, triangles, (centre, radius), Form::Closed)
    };
    let pipe = |name, (columns, rows), half| {
        let triangles = tube(columns, rows, half);
        Mesh::new(name, triangles, (Vec3::ZERO, 1.0), Form::Tube(half))
    };
    let ground = |name, rows, height, at| {
        let triangles = ground(12, rows, (1.0, height), at);
        Mesh::new(name, triangles, (at, 2.0), Form::Ground)
    };
    vec![
        ball("sphere", (24, 16), 1.0, Vec3::ZERO),
        ball("needles", (300, 5), 1.0, Vec3::ZERO),
        ball("slivers", (5, 900), 1.0, 0.5 * Vec3::ONE),
        ball("far-sphere", (24, 16), 1.0, FAR),
        ball("very-far-sphere", (24, 16), 1.0, 100.0 * FAR),
        ball("large-far-sphere", (64, 8), 1e3, 100.0 * FAR),
        ball("small-far-needles", (60, 4), 0.1, 0.1 * FAR),
        ball("tiny-sphere", (24, 16), 1e-15, Vec3::ZERO),
        ball("tiny-slivers", (5, 200), 1e-15, Vec3::ZERO),
        ball("huge-sphere", (24, 16), 1e9, Vec3::ZERO),
        ball("huge-needles", (300, 5), 1e9, Vec3::ZERO),
        pipe("prism", (5, 900), 1.0),
        pipe("tube", (900, 5), 1e4),
        ground("thin-ground", 300, 1e-3, Vec3::ONE),
        ground("far-ground", 20, 1.0, 0.1 * FAR),
    ]
}

/// A sine and a cosine that are the same on every host.
fn turn(angle: f32) -> (f32, f32) {
    (libm::sinf(angle), libm::cosf(angle))
}

/// A tube along z of so many quadrilaterals round and along, of radius 1 and from −`half` to `half`.
fn tube(columns: usize, rows: usize, half: f32) -> Vec<Triangle> {
    let point = |i: usize, j: usize| {
        let (sin, cos) = turn(TAU * (i % columns) as f32 / columns as f32);
        let along = 2.0 * j as f32 / rows as f32 - 1.0;
        Vec3::new(cos, sin, half * along)
    };
    let mut triangles = Vec::new();
    for i in 0..columns {
        for j in 0..rows {
            let [a, b] = [point(i, j), point(i + 1, j)];
            let [c, d] = [point(i + 1, j + 1), point(i, j + 1)];
            triangles.extend([triangle([a, b, c]), triangle([a, c, d])]);
        }
    }
    triangles
}

/// A bumpy ground whose quadrilaterals are `width` wide and `height` high.
fn ground(columns: usize, rows: usize, (width, height): (f32, f32), at: Vec3) -> Vec<Triangle> {
    let point = |i: usize, j: usize| {
        let bump = ((i * 7 + j * 13) % 5) as f32 * 0.11 * width.min(height);
        at + Vec3::new(i as f32 * width, bump, j as f32 * height)
    };
    let mut triangles = Vec::new();
    for i in 0..columns {
        for j in 0..rows {
            let [a, b] = [point(i, j), point(i, j + 1)];
            let [c, d] = [point(i + 1, j + 1), point(i + 1, j)];
            triangles.extend([triangle([a, b, c]), triangle([a, c, d])]);
        }
    }
    triangles
}
