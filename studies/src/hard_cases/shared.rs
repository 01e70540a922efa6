//! Edges and vertices that triangles share, and checks that the mesh is closed round these as a ray sees it.
//!
//! Beside an edge with triangles on one side only a ray is right to go, whatever exact arithmetic says
//! of a point that is rounded: an outline, or the border of an open mesh, is nothing that can leak. With
//! triangles on both sides there is no such way out. A vertex is closed where all edges that end there are.

use crate::exact;
use glam::Vec3;
use srp_runtime::scene::Triangle;
use std::cmp::Ordering;
use std::collections::BTreeMap;

use super::meshes;

/// Triangles, and for each place of a corner those that have one there.
pub(crate) struct Shared<'a> {
    triangles: &'a [Triangle],
    at: BTreeMap<[u32; 3], Vec<u32>>,
}

/// A place; a zero is one, whatever its sign.
fn key(p: Vec3) -> [u32; 3] {
    p.to_array().map(|x| (x + 0.0).to_bits())
}

impl<'a> Shared<'a> {
    pub(crate) fn of(triangles: &'a [Triangle]) -> Shared<'a> {
        let mut at: BTreeMap<[u32; 3], Vec<u32>> = BTreeMap::new();
        for (i, triangle) in (0..).zip(triangles) {
            for p in triangle.positions {
                let there = at.entry(key(p)).or_default();
                if there.last() != Some(&i) {
                    there.push(i);
                }
            }
        }
        Shared { triangles, at }
    }

    /// The triangles that have a corner here.
    pub(crate) fn vertex(&self, a: Vec3) -> &[u32] {
        self.at.get(&key(a)).map_or(&[], Vec::as_slice)
    }

    /// The triangles that have a corner at both.
    pub(crate) fn edge(&self, a: Vec3, b: Vec3) -> Vec<u32> {
        let at_b = self.vertex(b);
        let both = self.vertex(a).iter().filter(|t| at_b.contains(t));
        both.copied().collect()
    }

    /// True if an edge, seen from a point, has triangles on both of its sides, in exact arithmetic.
    pub(crate) fn is_closed_edge(&self, from: Vec3, a: Vec3, b: Vec3) -> bool {
        let seen = meshes::triangle([from, a, b]);
        let ends = [key(a), key(b)];
        let side = |t: u32| {
            let corners = &self.triangles[t as usize].positions;
            let third = corners.iter().find(|p| !ends.contains(&key(**p)));
            third.map_or(Ordering::Equal, |p| exact::side(p.to_array(), &seen))
        };
        let sides: Vec<Ordering> = self.edge(a, b).into_iter().map(side).collect();
        sides.contains(&Ordering::Less) && sides.contains(&Ordering::Greater)
    }

    /// True if all edges that end at a vertex, seen from a point, have triangles on both sides.
    pub(crate) fn is_closed_vertex(&self, from: Vec3, a: Vec3) -> bool {
        let corners = |t: &u32| self.triangles[*t as usize].positions;
        let ends = self.vertex(a).iter().flat_map(corners);
        let mut others = ends.filter(|p| key(*p) != key(a));
        others.all(|b| self.is_closed_edge(from, a, b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron with a corner at the origin, and what is asked about it from where it shows the faces
    /// at y = 0 and x = 0.
    #[test]
    fn outlines_and_borders_are_not_closed() {
        let [o, x, y, z] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let faces = [[o, y, x], [o, x, z], [o, z, y], [x, y, z]].map(meshes::triangle);
        let from = Vec3::new(-2.0, -2.0, 0.25);
        let whole = Shared::of(&faces);
        assert!(whole.is_closed_edge(from, o, z) && whole.is_closed_edge(from, z, o));
        assert!(whole.is_closed_edge(from, x, y), "the one behind");
        for (a, b) in [(x, z), (z, y), (o, x), (o, y)] {
            assert!(!whole.is_closed_edge(from, a, b), "{a} {b}");
        }
        assert!(!whole.is_closed_vertex(from, z));
        let above = Vec3::new(0.3, 0.3, -4.0);
        assert!(Shared::of(&faces).is_closed_vertex(Vec3::new(-2.0, -2.0, -2.0), o));
        assert!(!whole.is_closed_vertex(above, o));
        // An open pair, the same triangle twice, and one whose corners are in a line.
        let line = meshes::triangle([o, z, 2.0 * z]);
        for more in [faces[1], line] {
            let open = [faces[1], more];
            assert!(!Shared::of(&open).is_closed_edge(from, o, z));
        }
    }
}
