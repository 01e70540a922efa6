//! Families of meshes that are hard to hit or to miss: slivers, needles, far from the origin, very small and very large.

use crate::hard_cases::meshes::{sphere, triangle};
use glam::Vec3;
use srp_runtime::scene::Triangle;
use std::collections::BTreeMap;
use std::f32::consts::TAU;

/// A mesh of a family.
pub(super) struct Mesh {
    /// Its name, which a file can have.
    pub(super) name: &'static str,
    /// Its triangles.
    pub(super) triangles: Vec<Triangle>,
    /// For each corner of each triangle the triangles that share its vertex.
    pub(super) sharing: Vec<[Vec<u32>; 3]>,
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
}

impl Mesh {
    fn new(
        name: &'static str,
        triangles: Vec<Triangle>,
        (centre, size): (Vec3, f32),
        form: Form,
    ) -> Mesh {
        let mut at: BTreeMap<[u32; 3], Vec<u32>> = BTreeMap::new();
        let key = |p: Vec3| p.to_array().map(f32::to_bits);
        for (i, t) in (0..).zip(&triangles) {
            for p in t.positions {
                at.entry(key(p)).or_default().push(i);
            }
        }
        let sharing = triangles
            .iter()
            .map(|t| t.positions.map(|p| at[&key(p)].clone()));
        Mesh {
            name,
            sharing: sharing.collect(),
            triangles,
            centre,
            size,
            form,
        }
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
