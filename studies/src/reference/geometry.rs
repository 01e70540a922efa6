//! Rays and triangles in binary64: a tree divided at medians, and the test of Möller and Trumbore.

use glam::DVec3;
use srp_runtime::scene::Triangle;

/// A hit: distance in lengths of the direction, triangle, weights of its second and third vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub(crate) t: f64,
    pub(crate) triangle: usize,
    pub(crate) u: f64,
    pub(crate) v: f64,
}

enum Node {
    Leaf(Vec<usize>),
    Inner(Box<[(DVec3, DVec3, Node); 2]>),
}

/// The triangles of a scene.
pub(crate) struct Geometry {
    corners: Vec<[DVec3; 3]>,
    root: Node,
}

impl Geometry {
    pub(crate) fn of(triangles: &[Triangle]) -> Geometry {
        let corners: Vec<[DVec3; 3]> = triangles
            .iter()
            .map(|t| t.positions.map(|p| p.as_dvec3()))
            .collect();
        let root = divide((0..corners.len()).collect(), &corners);
        Geometry { corners, root }
    }

    /// The nearest hit beyond 0 and up to `end`.
    pub(crate) fn nearest(&self, origin: DVec3, direction: DVec3, end: f64) -> Option<Hit> {
        let mut hit = None;
        self.visit(&self.root, origin, direction, end, &mut hit);
        hit
    }

    fn visit(&self, node: &Node, origin: DVec3, direction: DVec3, end: f64, hit: &mut Option<Hit>) {
        match node {
            Node::Leaf(triangles) => {
                for &triangle in triangles {
                    let limit = hit.map_or(end, |h: Hit| h.t);
                    if let Some((t, u, v)) = meet(self.corners[triangle], origin, direction)
                        && t > 0.0
                        && (t < limit || t == limit && hit.is_none_or(|h| triangle < h.triangle))
                    {
                        *hit = Some(Hit { t, triangle, u, v });
                    }
                }
            }
            Node::Inner(sides) => {
                for (lo, hi, side) in sides.iter() {
                    let limit = hit.map_or(end, |h| h.t);
                    if enters(*lo, *hi, origin, direction, limit) {
                        self.visit(side, origin, direction, end, hit);
                    }
                }
            }
        }
    }
}

fn divide(mut triangles: Vec<usize>, corners: &[[DVec3; 3]]) -> Node {
    if triangles.len() <= 4 {
        return Node::Leaf(triangles);
    }
    let (lo, hi) = bounds(&triangles, corners);
    let axis = (hi - lo).max_position();
    let middle = |i: &usize| corners[*i].iter().map(|p| p[axis]).sum::<f64>();
    triangles.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
    let right = triangles.split_off(triangles.len() / 2);
    let side = |part: Vec<usize>| {
        let (lo, hi) = bounds(&part, corners);
        // Rays along a side of a box are in it.
        let margin = DVec3::splat(1e-9 * (1.0 + hi.abs().max(lo.abs()).max_element()));
        (lo - margin, hi + margin, divide(part, corners))
    };
    Node::Inner(Box::new([side(triangles), side(right)]))
}

fn bounds(triangles: &[usize], corners: &[[DVec3; 3]]) -> (DVec3, DVec3) {
    let all = triangles.iter().flat_map(|&i| corners[i]);
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    all.fold(none, |(lo, hi), p| (lo.min(p), hi.max(p)))
}

fn enters(lo: DVec3, hi: DVec3, origin: DVec3, direction: DVec3, limit: f64) -> bool {
    let (mut near, mut far) = (0.0f64, limit);
    for axis in 0..3 {
        if direction[axis] == 0.0 {
            if origin[axis] < lo[axis] || origin[axis] > hi[axis] {
                return false;
            }
            continue;
        }
        let a = (lo[axis] - origin[axis]) / direction[axis];
        let b = (hi[axis] - origin[axis]) / direction[axis];
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    near <= far
}

fn meet([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<(f64, f64, f64)> {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = origin - a;
    let q = s.cross(ab);
    let (u, v) = (s.dot(p) / determinant, direction.dot(q) / determinant);
    let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    inside.then_some((ac.dot(q) / determinant, u, v))
}
