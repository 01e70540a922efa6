//! Exact arithmetic over all triangles of a mesh, by the boxes of its tree.

use crate::exact;
use glam::{DVec3, Vec3};
use srp_runtime::bvh::Bvh;
use srp_runtime::scene::Triangle;
use srp_runtime::tni::arithmetic::Ray;

/// The decision whether a ray meets a mesh.
pub(super) struct Oracle<'a> {
    triangles: &'a [Triangle],
    tree: &'a Bvh,
    /// Triangles that are not in the tree, for binary64 finds no area in them.
    beside: Vec<u32>,
}

impl<'a> Oracle<'a> {
    pub(super) fn new(triangles: &'a [Triangle], tree: &'a Bvh) -> Oracle<'a> {
        let mut is_inside = vec![false; triangles.len()];
        for &triangle in &tree.tree.primitive_indices {
            is_inside[triangle as usize] = true;
        }
        let beside = (0..).zip(is_inside).filter(|(_, is_inside)| !is_inside);
        Oracle {
            triangles,
            tree,
            beside: beside.map(|(triangle, _)| triangle).collect(),
        }
    }

    /// True if a ray meets any triangle in exact arithmetic.
    pub(super) fn meets(&self, ray: &Ray) -> bool {
        let nodes = &self.tree.tree.nodes;
        let mut open: Vec<u32> = (!nodes.is_empty()).then_some(0).into_iter().collect();
        while let Some(node) = open.pop() {
            let node = &nodes[node as usize];
            let bounds = node.aabb();
            if !may_enter(ray, bounds.min.into(), bounds.max.into()) {
                continue;
            }
            if !node.is_leaf() {
                open.extend([node.first_index, node.first_index + 1]);
                continue;
            }
            let first = node.first_index as usize;
            let of_leaf = &self.tree.tree.primitive_indices[first..][..node.prim_count as usize];
            if of_leaf.iter().any(|&triangle| self.is_met(ray, triangle)) {
                return true;
            }
        }
        let mut beside = self.beside.iter();
        beside.any(|&triangle| self.is_met(ray, triangle))
    }

    fn is_met(&self, ray: &Ray, triangle: u32) -> bool {
        let triangle = &self.triangles[triangle as usize];
        !surely_passes(ray, triangle) && exact::meets(ray, triangle)
    }
}

/// False if binary64 is enough to say that a ray passes a box.
fn may_enter(ray: &Ray, low: Vec3, high: Vec3) -> bool {
    // A difference and a quotient, each off by half a unit of the last place.
    const SLACK: f64 = 4.0 * f64::EPSILON;
    let (mut enter, mut leave) = (0f64, f64::INFINITY);
    for axis in 0..3 {
        let [low, high] = [low, high].map(|bound| f64::from(bound[axis]));
        let origin = f64::from(ray.origin[axis]);
        let direction = f64::from(ray.direction[axis]);
        if direction == 0.0 {
            if origin < low || origin > high {
                return false;
            }
            continue;
        }
        let [one, other] = [low, high].map(|bound| (bound - origin) / direction);
        let (near, far) = (one.min(other), one.max(other));
        enter = enter.max(near - SLACK * near.abs());
        leave = leave.min(far + SLACK * far.abs());
    }
    enter <= leave
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hard_cases::meshes::{sphere, triangle};
    use crate::survey::Random;
    use srp_runtime::bvh;

    /// The tree leaves out no triangle that a ray meets, near, far, tiny and huge, with triangles without area and one
    /// whose area binary64 does not see.
    #[test]
    fn the_tree_answers_as_all_triangles_do() {
        let tiny = f32::from_bits(1);
        let thin = [
            Vec3::splat(0.0),
            Vec3::new(1e30, 1e30, 1e30),
            Vec3::new(1e30, 1e30, 1e30 + tiny),
        ];
        let line = [Vec3::ZERO, Vec3::X, 2.0 * Vec3::X];
        let seen = Vec3::new(1.0, 1.0 + f32::EPSILON, 0.0);
        let unseen = triangle([Vec3::ZERO, seen, Vec3::new(1.0, 1.0, 0.0) * 2.0]);
        let mut random = Random::new(7);
        for (size, centre) in [
            (1.0, Vec3::ZERO),
            (1.0, Vec3::splat(1e5)),
            (1e-15, Vec3::ZERO),
        ] {
            let mut mesh = sphere((9, 6), size, centre);
            mesh.extend([triangle(thin), triangle(line), unseen]);
            let tree = bvh::build(&mesh, &bvh::Options::default());
            let oracle = Oracle::new(&mesh, &tree);
            assert!(!oracle.beside.is_empty());
            let mut met = 0;
            for _ in 0..400 {
                let [a, b, _] = mesh[random.below(mesh.len())].positions;
                let to = a.lerp(b, random.unit());
                let from = to + 3.0 * size * random.direction();
                let ray = Ray::new(from.into(), (to - from).into(), 0.0, f32::MAX, 0);
                let expected = mesh.iter().any(|t| exact::meets(&ray, t));
                assert_eq!(oracle.meets(&ray), expected, "{ray:?}");
                met += usize::from(expected);
            }
            assert!((50..390).contains(&met), "{met}");
        }
    }
}
