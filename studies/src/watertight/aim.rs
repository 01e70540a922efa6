//! Rays that are aimed at what is hard about a mesh, and what exact arithmetic says of them.

use super::mesh::{Form, Mesh};
use super::oracle::Oracle;
use crate::hard_cases::shared::Shared;
use crate::survey::Random;
use glam::Vec3;
use schemars::JsonSchema;
use serde::Serialize;
use srp_runtime::bvh::Bvh;
use srp_runtime::tni::arithmetic::Ray;
use srp_toolchain::Session;

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
    /// At edges that have triangles on both sides as the ray sees them, from anywhere.
    ClosedEdges,
    /// At vertices all of whose edges have, from anywhere.
    ClosedVertices,
    /// From outside, at edges; of a mesh of one's own, from anywhere at edges that are an outline or a border.
    Edges,
    /// The same at vertices.
    Vertices,
    /// From outside, along the surface; of a mesh of one's own, from anywhere.
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
            Form::Any => {
                let closed = [Aim::ClosedEdges, Aim::ClosedVertices];
                [&closed[..], &outside, &past].concat()
            }
        }
    }

    /// Its words.
    pub fn name(self) -> String {
        match self {
            Aim::Unaimed => "inside, unaimed".to_owned(),
            Aim::InsideEdges => "inside, edges".to_owned(),
            Aim::InsideVertices => "inside, vertices".to_owned(),
            Aim::InsideGrazing => "inside, grazing".to_owned(),
            Aim::ClosedEdges => "closed edges".to_owned(),
            Aim::ClosedVertices => "closed vertices".to_owned(),
            Aim::Edges => "outside, edges".to_owned(),
            Aim::Vertices => "outside, vertices".to_owned(),
            Aim::Grazing => "outside, grazing".to_owned(),
            Aim::Past(apart) => format!("past, {apart:e}"),
        }
    }

    /// True if a lost ray is a hole: it starts inside, or there are triangles on both sides of its aim.
    pub fn finds_holes(self) -> bool {
        self.is_inside() || self.is_closed()
    }

    fn is_inside(self) -> bool {
        matches!(
            self,
            Aim::Unaimed | Aim::InsideEdges | Aim::InsideVertices | Aim::InsideGrazing
        )
    }

    fn is_closed(self) -> bool {
        matches!(self, Aim::ClosedEdges | Aim::ClosedVertices)
    }

    /// True if they are aimed at vertices.
    fn is_at_vertices(self) -> bool {
        matches!(
            self,
            Aim::InsideVertices | Aim::ClosedVertices | Aim::Vertices
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

/// So many tries are made for each ray that is to be of its kind.
const TRIES: usize = 8;

/// Triangles at a vertex, at most, for it to be asked whether it is closed: each is asked about each.
const MOST_AT_VERTEX: usize = 256;

/// A mesh that is aimed at.
pub(super) struct Target<'a> {
    mesh: &'a Mesh,
    oracle: Oracle<'a>,
    shared: Shared<'a>,
}

impl<'a> Target<'a> {
    pub(super) fn new(mesh: &'a Mesh, tree: &'a Bvh) -> Target<'a> {
        Target {
            mesh,
            oracle: Oracle::new(&mesh.triangles, tree),
            shared: Shared::of(&mesh.triangles),
        }
    }

    /// So many rays, or fewer where that many are not found of their kind; nothing where the user ends the work.
    pub(super) fn shots(
        &self,
        aim: Aim,
        count: usize,
        random: &mut Random,
        session: &Session<'_>,
    ) -> Option<Vec<Shot>> {
        let mut shots = Vec::with_capacity(count);
        for _ in 0..count * TRIES {
            if shots.len() == count {
                break;
            }
            if session.watch.cancelled() {
                return None;
            }
            let Some(ray) = self.ray(aim, random) else {
                continue;
            };
            let meets = self.oracle.meets(&ray);
            if !matches!(aim, Aim::Past(_)) || !meets {
                shots.push(Shot { ray, meets });
            }
        }
        Some(shots)
    }

    /// A ray; nothing where it has no direction, or what it is aimed at is not of the kind.
    fn ray(&self, aim: Aim, random: &mut Random) -> Option<Ray> {
        let mesh = self.mesh;
        let size = mesh.size;
        let i = random.below(mesh.triangles.len());
        let corner = random.below(3);
        let [a, b, c] = [0, 1, 2].map(|k| mesh.triangles[i].positions[(corner + k) % 3]);
        let to = match aim.is_at_vertices() {
            true => a,
            false => a.lerp(b, random.unit()),
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
        let is_finite = from.is_finite() && way.is_finite();
        let is_of_kind = || mesh.form != Form::Any || self.is_of_kind(aim, from, a, b);
        (is_finite && way != Vec3::ZERO && is_of_kind())
            .then(|| Ray::new(from.to_array(), way.to_array(), 0.0, f32::MAX, 0))
    }

    /// True if a corner, or the edge that begins there, is closed as the aim wants it, seen from a point.
    fn is_of_kind(&self, aim: Aim, from: Vec3, a: Vec3, b: Vec3) -> bool {
        if !(aim.is_closed() || matches!(aim, Aim::Edges | Aim::Vertices)) {
            return true;
        }
        let few = |p: Vec3| self.shared.vertex(p).len() <= MOST_AT_VERTEX;
        let is_closed = match aim.is_at_vertices() {
            true => few(a) && self.shared.is_closed_vertex(from, a),
            false => few(a) && few(b) && self.shared.is_closed_edge(from, a, b),
        };
        is_closed == aim.is_closed()
    }
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

fn slope(random: &mut Random) -> f32 {
    [1e-1, 1e-2, 1e-3, 1e-4][random.below(4)]
}

/// A vector of length 1, or 0 for one of no length.
fn unit_vector(v: Vec3) -> Vec3 {
    v.normalize_or_zero()
}
