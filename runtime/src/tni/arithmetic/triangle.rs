//! The ray–triangle tests: one function for each [`Intersection`], each with the operations that
//! [`Intersection::operations`] counts.

use srp_archdesc::arch::Approx;
use srp_archdesc::datapath::Intersection;
use srp_archdesc::ops::semantics;

use super::{Hit, Prepared, Ray, exp2, larger, smaller};
use crate::bvh::TriangleRecord;

/// The two axes after each.
pub(super) const NEXT: [usize; 3] = [1, 2, 0];

/// Distance and weights of vertices 1 and 2.
type Meeting = (f32, f32, f32);

/// The shear of Woop's test for a ray: its slopes along its longest axis, and the reciprocal there.
pub(super) fn shear(ray: &Ray, longest: usize) -> [f32; 3] {
    let (x, y) = (NEXT[longest], NEXT[NEXT[longest]]);
    let inverse = ray.reciprocal[longest];
    [
        ray.direction[x] * inverse,
        ray.direction[y] * inverse,
        inverse,
    ]
}

/// A quotient: one rounding where the unit divides exactly, else a product by a reciprocal.
#[inline]
pub(super) fn quotient(above: f32, below: f32, rcp: Approx) -> f32 {
    match rcp {
        Approx::Exact => above / below,
        Approx::Table { .. } => above * reciprocal(below, rcp),
    }
}

#[inline]
pub(super) fn reciprocal(x: f32, rcp: Approx) -> f32 {
    match rcp {
        Approx::Exact => 1.0 / x,
        Approx::Table { .. } => {
            let (bits, steps) = rcp.arguments();
            f32::from_bits(semantics::elementary::rcp(x.to_bits(), bits, steps))
        }
    }
}

/// 2^-⌊log2 |x|⌋: what the exponent alone says of 1/|x|, at least that.
#[inline]
fn exponent_reciprocal(x: f32) -> f32 {
    let exponent = (x.to_bits() >> 23) & 0xff;
    f32::from_bits(254u32.saturating_sub(exponent).max(1) << 23)
}

/// The error of a reciprocal over the rounding that the slack of a triangle stands for, 2^-23, as a
/// power of two not below it: its multiplication adds to an exponent. 0 for an exact division.
fn coarseness(rcp: Approx) -> f32 {
    match rcp {
        Approx::Exact => 0.0,
        coarse => {
            let error = coarse.error_bound() as f32;
            exp2(1 + 23 - 127 + (error.to_bits() >> 23) as i32)
        }
    }
}

impl Prepared {
    /// Where the ray meets the triangle, whatever was hit before, for distances beyond the ray's
    /// `tmin`. The record is one for this test.
    #[inline]
    pub fn intersect(
        &self,
        triangle: &TriangleRecord,
        test: Intersection,
        rcp: Approx,
    ) -> Option<Hit> {
        let (t, u, v) = match test {
            Intersection::Wald => self.wald(triangle, rcp),
            Intersection::AnchorWald => self.anchored(triangle, rcp, false),
            Intersection::AnchorWaldScaled => self.anchored(triangle, rcp, true),
            Intersection::Woop => self.woop(triangle, rcp),
            Intersection::WoopWide => self.woop_wide(triangle, rcp),
        }?;
        Some(Hit {
            t,
            u,
            v,
            primitive: triangle.primitive(),
        })
    }

    /// True if something can be hit at this distance; not at an infinite one, nor at a NaN from a ray in the
    /// triangle's plane.
    #[inline]
    fn reaches(&self, t: f32) -> bool {
        t > self.tmin && t <= f32::MAX
    }

    /// Wald (2004), as in the paper.
    #[inline]
    fn wald(&self, triangle: &TriangleRecord, rcp: Approx) -> Option<Meeting> {
        let w = triangle.wald();
        let k = w.axis as usize;
        if k > 2 {
            return None;
        }
        let (u, v) = (NEXT[k], NEXT[NEXT[k]]);
        let [nu, nv] = w.normal;
        let (ok, ou, ov) = (self.origin[k], self.origin[u], self.origin[v]);
        let (dk, du, dv) = (self.direction[k], self.direction[u], self.direction[v]);
        let along = dk + (nu * du + nv * dv);
        let above = w.distance - (ok + (nu * ou + nv * ov));
        let t = quotient(above, along, rcp);
        if !self.reaches(t) {
            return None;
        }
        let (hu, hv) = (ou + t * du, ov + t * dv);
        let weight = |row: [f32; 3]| hu * row[0] + hv * row[1] + row[2];
        inside(t, weight(w.row_u), weight(w.row_v), 0.0)
    }

    /// The projection relative to a vertex, with or without an epsilon.
    #[inline]
    fn anchored(&self, triangle: &TriangleRecord, rcp: Approx, scaled: bool) -> Option<Meeting> {
        let w = triangle.anchored();
        let k = w.axis as usize;
        if k > 2 {
            return None;
        }
        let (u, v) = (NEXT[k], NEXT[NEXT[k]]);
        let [nu, nv] = w.normal;
        let [ak, au, av] = w.anchor;
        let (pk, pu, pv) = (
            self.origin[k] - ak,
            self.origin[u] - au,
            self.origin[v] - av,
        );
        let (dk, du, dv) = (self.direction[k], self.direction[u], self.direction[v]);
        let along = dk + (nu * du + nv * dv);
        let above = -(pk + (nu * pu + nv * pv));
        let t = quotient(above, along, rcp);
        if !self.reaches(t) {
            return None;
        }
        let (hu, hv) = (pu + t * du, pv + t * dv);
        let weight_u = hu * w.row_u[0] + hv * w.row_u[1];
        let weight_v = hu * w.row_v[0] + hv * w.row_v[1];
        let epsilon = if scaled {
            let way = t * self.reach;
            let size = way + larger(larger(pk.abs(), pu.abs()), pv.abs());
            let grazing = larger(1.0, exponent_reciprocal(along) * self.reach);
            // Rounding errors of the operations, and the way that a coarse reciprocal moves the point along
            // the ray.
            let off = size * grazing + way * coarseness(rcp);
            // Never more than the triangle's own size, or a ray along its plane would hit anywhere.
            smaller(w.slack * off, 1.0)
        } else {
            0.0
        };
        inside(t, weight_u, weight_v, epsilon)
    }

    /// Woop, Benthin and Wald (2013): an edge gives both its triangles the same number with opposite signs, and a
    /// zero counts for both. Its sign is that of the exact difference of products: where each product is
    /// rounded, the signs of the edges of slivers may be those of no point at all, and every triangle of a
    /// closed mesh refuses the ray.
    #[inline]
    fn woop(&self, triangle: &TriangleRecord, rcp: Approx) -> Option<Meeting> {
        let w = triangle.woop();
        if w.void {
            return None;
        }
        let z = self.longest;
        let (x, y) = (NEXT[z], NEXT[NEXT[z]]);
        let [slope_x, slope_y, slope_z] = self.shear;
        let [a, b, c] = w.vertices.map(|vertex| {
            let along = vertex[z] - self.origin[z];
            (
                (vertex[x] - self.origin[x]) - slope_x * along,
                (vertex[y] - self.origin[y]) - slope_y * along,
                slope_z * along,
            )
        });
        let weight_a = cross(c, b);
        let weight_b = cross(a, c);
        let weight_c = cross(b, a);
        if differ([weight_a, weight_b, weight_c]) {
            return None;
        }
        let inverse = reciprocal(weight_a + weight_b + weight_c, rcp);
        let t = (weight_a * a.2 + weight_b * b.2 + weight_c * c.2) * inverse;
        // All weights zero: the ray lies in the plane, t is a NaN, and there is no hit. (Rounded slopes may tilt such a ray.)
        if !self.reaches(t) {
            return None;
        }
        Some(moved_inside(t, weight_b * inverse, weight_c * inverse))
    }

    /// Woop's test by numbers of 53 digits and exponents of 11 bits. No reciprocal takes part in the decision, and what
    /// rounds moves neither ray nor vertices by as much as can be told in binary32, while the triangle is larger than some
    /// parts of 2^-53 of how far it is away: it is hit where its box is met.
    #[inline]
    fn woop_wide(&self, triangle: &TriangleRecord, rcp: Approx) -> Option<Meeting> {
        let w = triangle.woop();
        if w.void {
            return None;
        }
        let wide = Wide::of(self.origin, self.direction, self.longest, w.vertices);
        // All weights zero: the ray lies in the plane.
        if differ(wide.edges) || wide.below == 0.0 {
            return None;
        }
        let [below, above, u, v] = wide.quotients().map(|x| x as f32);
        let inverse = reciprocal(below, rcp);
        let t = above * inverse;
        if !self.reaches(t) {
            return None;
        }
        Some(moved_inside(t, u * inverse, v * inverse))
    }
}

/// The numbers that Woop's test makes of a ray and a triangle in 53 digits.
pub(super) struct Wide {
    /// The edge functions: the weights of the vertices, times what is common to them.
    edges: [f64; 3],
    /// Along the ray's longest axis, the vertices by their weights, and the direction by their sum: the distance is
    /// the first over the second.
    above: f64,
    below: f64,
    /// The direction there.
    along: f64,
}

impl Wide {
    /// With the vertices relative to the origin, and sheared by the direction as it is: scaled by it, where Woop divides
    /// by it. No product is too large or too small for an exponent of 11 bits.
    #[inline]
    pub(super) fn of(
        origin: [f32; 3],
        direction: [f32; 3],
        longest: usize,
        vertices: [[f32; 3]; 3],
    ) -> Wide {
        let [origin, direction] = [origin, direction].map(|v| v.map(f64::from));
        let z = longest;
        let (x, y) = (NEXT[z], NEXT[NEXT[z]]);
        let corners = vertices.map(|vertex| {
            let from = |axis: usize| f64::from(vertex[axis]) - origin[axis];
            let sheared = |axis: usize| from(axis) * direction[z] - from(z) * direction[axis];
            [sheared(x), sheared(y), from(z)]
        });
        let [a, b, c] = corners;
        let edge = |p: [f64; 3], q: [f64; 3]| p[0] * q[1] - p[1] * q[0];
        let edges = [edge(c, b), edge(a, c), edge(b, a)];
        Wide {
            edges,
            above: edges[0] * a[2] + edges[1] * b[2] + edges[2] * c[2],
            below: (edges[0] + edges[1] + edges[2]) * direction[z],
            along: direction[z],
        }
    }

    /// The divisor of distance and weights of vertices 1 and 2, and these three before it divides them: all by the power
    /// of two that makes the first one at least 1 and less than 2, so that the others fit into binary32 if their
    /// quotients do.
    #[inline]
    pub(super) fn quotients(&self) -> [f64; 4] {
        let exponent = (self.below.to_bits() >> 52) & 0x7ff;
        let scale = f64::from_bits((2046 - exponent) << 52);
        let [_, u, v] = self.edges;
        [self.below, self.above, u * self.along, v * self.along].map(|x| x * scale)
    }
}

/// True if of these one is negative and one positive.
#[inline]
fn differ<T: PartialOrd + Default + Copy>(weights: [T; 3]) -> bool {
    let zero = T::default();
    weights.iter().any(|&w| w < zero) && weights.iter().any(|&w| w > zero)
}

/// p₀·q₁ − p₁·q₀ by an adder of 53 digits, then to binary32: both products are exact, and so is the sign.
#[inline]
fn cross(p: (f32, f32, f32), q: (f32, f32, f32)) -> f32 {
    let wide = f64::from;
    (wide(p.0) * wide(q.1) - wide(p.1) * wide(q.0)) as f32
}

#[inline]
fn inside(t: f32, u: f32, v: f32, epsilon: f32) -> Option<Meeting> {
    let inside = u >= -epsilon && v >= -epsilon && u + v <= 1.0 + epsilon;
    inside.then(|| moved_inside(t, u, v))
}

/// Moves a hit into the triangle that an epsilon let pass, or that a coarse reciprocal took beyond an edge:
/// its weights are not negative, and at most 1 together.
#[inline]
fn moved_inside(t: f32, u: f32, v: f32) -> Meeting {
    let u = smaller(larger(u, 0.0), 1.0);
    (t, u, smaller(larger(v, 0.0), 1.0 - u))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};

    fn record(positions: [[f32; 3]; 3], test: Intersection) -> TriangleRecord {
        let triangle = crate::scene::Triangle {
            positions: positions.map(Vec3::from),
            normals: [Vec3::Z; 3],
            uvs: [Vec2::ZERO; 3],
            material: 0,
        };
        TriangleRecord::of(&triangle, 0, test)
    }

    /// How many of the triangles a ray through their shared edge hits, by each test.
    fn hits(ray: &Ray, triangles: [[[f32; 3]; 3]; 2]) -> [usize; 5] {
        let ray = Prepared::of(ray).expect("a proper ray");
        Intersection::ALL.map(|test| {
            let hit = |t: &[[f32; 3]; 3]| ray.intersect(&record(*t, test), test, Approx::Exact);
            triangles.iter().filter_map(hit).count()
        })
    }

    #[test]
    fn walds_test_loses_a_ray_between_two_triangles() {
        // By exact arithmetic the ray meets both.
        let (a, b) = ([1.0, -1.0, 1.0], [0.0, 0.0, -1.0]);
        let (c, e) = ([0.0, 1.0, 0.0], [-1.0, -1.0, 0.0]);
        let ray = Ray::new([0.0; 3], [1.0, -1.0, 1.0], 0.0, f32::MAX, 0);
        let [wald, _, others @ ..] = hits(&ray, [[a, b, c], [b, a, e]]);
        assert_eq!(wald, 0);
        assert!(others.iter().all(|&hits| hits >= 1), "{others:?}");
    }

    #[test]
    fn all_tests_agree_on_a_ray_through_the_middle() {
        let triangle = [[1.0, 0.0, 2.0], [-1.0, 1.0, 2.5], [-1.0, -1.0, 3.0]];
        let ray = Ray::new([0.1, 0.05, -1.0], [-0.05, 0.0, 1.0], 0.0, f32::MAX, 0);
        let prepared = Prepared::of(&ray).expect("a proper ray");
        for rcp in [Approx::Exact, Approx::table(20, 1)] {
            let found = Intersection::ALL.map(|test| {
                let hit = prepared.intersect(&record(triangle, test), test, rcp);
                hit.expect("it goes through")
            });
            for hit in found {
                assert!((hit.t - found[0].t).abs() < 1e-5, "{found:?}");
                assert!((hit.u - found[0].u).abs() < 1e-5, "{found:?}");
                assert!((hit.v - found[0].v).abs() < 1e-5, "{found:?}");
            }
        }
    }

    #[test]
    fn triangles_of_no_area_and_rays_in_their_plane() {
        let line = [[0.0; 3], [1.0; 3], [2.0; 3]];
        let flat = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let across = Ray::new([1.0, 1.0, 0.0], [0.0, 0.0, 1.0], 0.0, f32::MAX, 0);
        let within = Ray::new([-1.0, 0.25, 0.0], [1.0, 0.0, 0.0], 0.0, f32::MAX, 0);
        for (ray, triangle) in [(across, line), (within, flat)] {
            let ray = Prepared::of(&ray).expect("a proper ray");
            for test in Intersection::ALL {
                let hit = ray.intersect(&record(triangle, test), test, Approx::Exact);
                assert_eq!(hit, None, "{}", test.name());
            }
        }
    }

    #[test]
    fn an_exponent_bounds_a_reciprocal() {
        for x in [1.0f32, 1.5, -3.0, 1e-30, 1e-45, 0.0, 1e38] {
            let bound = exponent_reciprocal(x);
            assert!(bound.is_finite() && bound > 0.0);
            let exact = 1.0 / x.abs();
            assert!(
                bound >= exact.min(f32::MAX / 4.0) && (bound <= 2.0 * exact || x.abs() < 1e-38)
            );
        }
    }
}
