//! Rays that are aimed at what is hard about a mesh, and what exact arithmetic says of them.

use super::mesh::{Form, Mesh};
use crate::exact;
use crate::survey::Random;
use glam::{DVec3, Vec3};
use schemars::JsonSchema;
use serde::Serialize;
use srp_runtime::scene::Triangle;
use srp_runtime::tni::arithmetic::Ray;

/// How rays are aimed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Aim {
    /// From inside, anywhere.
    Unaimed,
    /// From inside, at edges.
    InsideEdges,
    /// From inside, at vertices.
    InsideVertices,
    /// From just below the surface, along it.
    InsideGrazing,
    /// From outside, at edges.
    Edges,
    /// From outside, at vertices.
    Vertices,
    /// From outside, along the surface.
    Grazing,
    /// Past an edge of the outline at this part of the radius, across it: the ray meets nothing.
    Past(f32),
}

/// How far rays pass outlines.
pub const APART: [f32; 4] = [1e-6, 1e-5, 1e-4, 1e-3];

impl Aim {
    /// All that go with a mesh.
    pub(super) fn at(form: Form) -> Vec<Aim> {
        let inside = [Aim::InsideEdges, Aim::InsideVertices, Aim::InsideGrazing];
        let outside = [Aim::Edges, Aim::Vertices, Aim::Grazing];
        let past = APART.map(Aim::Past);
        match form {
            Form::Closed => [&[Aim::Unaimed], &inside[..], &outside, &past].concat(),
            Form::Tube(_) => [&[Aim::Unaimed][..], &past].concat(),
            Form::Ground => outside.to_vec(),
        }
    }

    /// Its words.
    pub fn name(self) -> String {
        match self {
            Aim::Unaimed => "inside, unaimed".to_owned(),
            Aim::InsideEdges => "inside, edges".to_owned(),
            Aim::InsideVertices => "inside, vertices".to_owned(),
            Aim::InsideGrazing => "inside, grazing".to_owned(),
            Aim::Edges => "outside, edges".to_owned(),
            Aim::Vertices => "outside, vertices".to_owned(),
            Aim::Grazing => "outside, grazing".to_owned(),
            Aim::Past(apart) => format!("past, {apart:e}"),
        }
    }

    /// True if they start inside.
    pub fn is_inside(self) -> bool {
        matches!(
            self,
            Aim::Unaimed | Aim::InsideEdges | Aim::InsideVertices | Aim::InsideGrazing
        )
    }
}

/// A ray, and whether it meets the mesh in exact arithmetic.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shot {
    /// The ray; it has no end.
    pub(super) ray: Ray,
    /// True if it meets a triangle. A ray in a triangle's plane does not meet that.
    pub(super) meets: bool,
}

/// So many rays, or fewer where that many would not pass the mesh.
pub(super) fn shots(mesh: &Mesh, aim: Aim, count: usize, random: &mut Random) -> Vec<Shot> {
    const TRIES: usize = 8;
    let mut shots = Vec::with_capacity(count);
    for _ in 0..count * TRIES {
        if shots.len() == count {
            break;
        }
        let (ray, round) = shot(mesh, aim, random);
        let meets = meets(&ray, &mesh.triangles, &round);
        let is_wanted = !matches!(aim, Aim::Past(_)) || !meets;
        if is_wanted && ray.direction != [0.0; 3] {
            shots.push(Shot { ray, meets });
        }
    }
    shots
}

/// A ray, and the triangles round what it is aimed at.
fn shot(mesh: &Mesh, aim: Aim, random: &mut Random) -> (Ray, Vec<u32>) {
    let size = mesh.size;
    let i = random.below(mesh.triangles.len());
    let corner = random.below(3);
    let [a, b, c] = [0, 1, 2].map(|k| mesh.triangles[i].positions[(corner + k) % 3]);
    let [at_a, at_b] = [0, 1].map(|k| &mesh.sharing[i][(corner + k) % 3]);
    let both = || at_a.iter().filter(|t| at_b.contains(t)).copied().collect();
    let (to, round) = match aim {
        Aim::Vertices | Aim::InsideVertices => (a, at_a.clone()),
        _ => (a.lerp(b, random.unit()), both()),
    };
    let (from, way) = match aim {
        Aim::Unaimed => unaimed(mesh, random),
        Aim::InsideGrazing => {
            // Far away, no point is nearer to the surface than a rounding and still inside.
            let least = 8.0 * f32::EPSILON * mesh.centre.abs().max_element() / size;
            let middle = (a + b + c) / 3.0;
            let from = middle.lerp(mesh.centre, slope(random).max(least));
            (from, to - from)
        }
        Aim::Grazing => {
            let [side, other] = [b - a, c - a].map(|side| side / size);
            let along = unit_vector(side.lerp(other, random.unit()));
            let up = unit_vector(side.cross(other));
            let from = to + 2.0 * size * (along + slope(random) * up);
            (from, to - from)
        }
        Aim::Past(apart) => past(mesh, to, apart, random),
        _ if aim.is_inside() => {
            let from = mesh.centre + 0.5 * size * random.direction();
            (from, to - from)
        }
        _ => {
            let from = to + 2.0 * size * (0.2 + random.unit()) * random.direction();
            (from, to - from)
        }
    };
    let ray = Ray::new(from.to_array(), way.to_array(), 0.0, f32::MAX, 0);
    (ray, round)
}

/// A ray from inside, which does not leave through an open end.
fn unaimed(mesh: &Mesh, random: &mut Random) -> (Vec3, Vec3) {
    match mesh.form {
        Form::Tube(half) => {
            let across = 0.3 * random.direction() * Vec3::new(1.0, 1.0, 0.0);
            let from = across + 1.6 * half * (random.unit() - 0.5) * Vec3::Z;
            (from, half.max(1.0) * random.direction())
        }
        _ => {
            let from = mesh.centre + 0.3 * mesh.size * random.direction();
            (from, mesh.size * random.direction())
        }
    }
}

/// A ray past a point of the outline, at a part of the radius.
fn past(mesh: &Mesh, to: Vec3, apart: f32, random: &mut Random) -> (Vec3, Vec3) {
    let axis = match mesh.form {
        Form::Tube(_) => Vec3::new(1.0, 1.0, 0.0),
        _ => Vec3::ONE,
    };
    let out = unit_vector((to - mesh.centre) * axis / mesh.size);
    let along = match mesh.form {
        Form::Tube(_) => Vec3::Z.cross(out),
        _ => unit_vector(random.direction().cross(out)),
    };
    let edge = to + apart * mesh.size * out;
    let from = edge - (2.0 + random.unit()) * mesh.size * along;
    (from, edge - from)
}

/// True if a ray meets any of the triangles in exact arithmetic; those round its aim are asked first.
fn meets(ray: &Ray, triangles: &[Triangle], round: &[u32]) -> bool {
    let met = |t: &u32| exact::meets(ray, &triangles[*t as usize]);
    let mut may_be_met = triangles.iter().filter(|t| !surely_passes(ray, t));
    round.iter().any(met) || may_be_met.any(|t| exact::meets(ray, t))
}

/// True if binary64 is enough to say that a ray's line passes a triangle: it has one edge on its left and one
/// on its right, by more than the rounding of these products can be.
fn surely_passes(ray: &Ray, triangle: &Triangle) -> bool {
    let origin = Vec3::from(ray.origin).as_dvec3();
    let direction = Vec3::from(ray.direction).as_dvec3();
    let [a, b, c] = triangle.positions.map(|p| p.as_dvec3() - origin);
    // Sums of coordinates are no less than lengths, and need no roots.
    let size = |v: DVec3| v.abs().element_sum();
    let scale = 64.0 * f64::EPSILON * size(direction);
    let (mut left, mut right) = (false, false);
    for (p, q) in [(c, b), (a, c), (b, a)] {
        let product = direction.dot(p.cross(q));
        let rounding = scale * size(p) * size(q);
        left |= product > rounding;
        right |= product < -rounding;
    }
    left && right
}

fn slope(random: &mut Random) -> f32 {
    [1e-1, 1e-2, 1e-3, 1e-4][random.below(4)]
}

/// A vector of length 1, or 0 for one of no length.
fn unit_vector(v: Vec3) -> Vec3 {
    v.normalize_or_zero()
}
