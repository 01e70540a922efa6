//! The arithmetic of the T&I unit: ray–box and ray–triangle tests in binary32.
//!
//! Hits come from here and nowhere else. Each operation is one rounding, in the order written:
//! Rust never contracts, and no library function is called.
//!
//! The box test subtracts first, `(plane − origin) · reciprocal`, and uses a wider reciprocal for
//! the far planes: a ray that meets a box in exact arithmetic is never said to miss it. (The form
//! `plane · r − origin · r` cancels far from the origin and loses flat boxes there.) A zero of the
//! direction is decided by comparing the origin with the planes, so that no NaN decides anything.
//!
//! The triangle test is Wald's projection relative to a vertex ([`TriangleRecord`]), with the
//! weights compared against an epsilon that scales with what rounding can do to them. On a closed
//! mesh no aimed ray has been found that slips through.

use srp_archdesc::arch::Approx;
use srp_archdesc::ops::semantics;

use crate::bvh::TriangleRecord;

/// Unit roundoff of binary32.
const U: f32 = 1.0 / (1 << 24) as f32;

/// What a reciprocal of precision `rcp` is multiplied by to cover all errors of a far plane's
/// distance against that of a near one: twice that of the reciprocal, twice those of subtraction
/// and multiplication, and its own.
pub fn widening(rcp: Approx) -> f32 {
    let of_reciprocal = match rcp {
        Approx::Exact => U,
        // A step leaves at best a few units in the last place, and squares what it starts from.
        Approx::Table { bits, steps } => {
            let first = exp2(-(bits as i32) + 1);
            let improved = (0..steps).fold(first, |e, _| 2.0 * e * e);
            improved.max(4.0 * U)
        }
    };
    1.0 + 2.0 * of_reciprocal + 16.0 * U
}

/// 2^n, exactly, for -126 ≤ n ≤ 127.
fn exp2(n: i32) -> f32 {
    f32::from_bits(((n.clamp(-126, 127) + 127) as u32) << 23)
}

/// A ray as the kernels write it (words of `srp_ray` in `kernels/scene.h`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: [f32; 3],
    /// Hits count from beyond this distance.
    pub tmin: f32,
    /// Where it goes; of any length.
    pub direction: [f32; 3],
    /// Hits count up to this distance.
    pub tmax: f32,
    /// 1 over each part of the direction, to the precision of the SRP.
    pub reciprocal: [f32; 3],
    /// Any word; not looked at.
    pub payload: u32,
    /// The reciprocal times [`widening`].
    pub far: [f32; 3],
    /// Bit 0: any hit will do.
    pub flags: u32,
}

/// Flag of a ray for which any hit will do.
pub const ANY_HIT: u32 = 1;

impl Ray {
    /// A ray with exact reciprocals.
    pub fn new(origin: [f32; 3], direction: [f32; 3], tmin: f32, tmax: f32, flags: u32) -> Ray {
        let reciprocal = direction.map(|d| 1.0 / d);
        let factor = widening(Approx::Exact);
        Ray {
            origin,
            tmin,
            direction,
            tmax,
            reciprocal,
            payload: 0,
            far: reciprocal.map(|r| r * factor),
            flags,
        }
    }

    /// The 16 words of the record.
    pub fn words(&self) -> [u32; 16] {
        let [ox, oy, oz] = self.origin.map(f32::to_bits);
        let [dx, dy, dz] = self.direction.map(f32::to_bits);
        let [rx, ry, rz] = self.reciprocal.map(f32::to_bits);
        let [fx, fy, fz] = self.far.map(f32::to_bits);
        let (tmin, tmax) = (self.tmin.to_bits(), self.tmax.to_bits());
        let (payload, flags) = (self.payload, self.flags);
        [
            ox, oy, oz, tmin, dx, dy, dz, tmax, rx, ry, rz, payload, fx, fy, fz, flags,
        ]
    }

    /// The ray of a record.
    pub fn from_words(words: [u32; 16]) -> Ray {
        let vector = |i: usize| [0, 1, 2].map(|k| f32::from_bits(words[i + k]));
        Ray {
            origin: vector(0),
            tmin: f32::from_bits(words[3]),
            direction: vector(4),
            tmax: f32::from_bits(words[7]),
            reciprocal: vector(8),
            payload: words[11],
            far: vector(12),
            flags: words[15],
        }
    }
}

/// What the dispatch unit makes of a ray, once, before it is traversed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Prepared {
    origin: [f32; 3],
    direction: [f32; 3],
    near: [f32; 3],
    far: [f32; 3],
    /// Bit of each axis along which the ray goes down.
    negative: [bool; 3],
    /// Bit of each axis along which it does not move.
    parallel: [bool; 3],
    tmin: f32,
    /// Largest part of the direction.
    reach: f32,
}

impl Prepared {
    /// The ray made ready, or `None` where it can hit nothing: a NaN in it, an infinite origin or
    /// direction, a direction of length 0, `tmax < tmin`.
    pub fn of(ray: &Ray) -> Option<Prepared> {
        let finite = ray
            .origin
            .iter()
            .chain(&ray.direction)
            .all(|x| x.is_finite());
        let nan = ray.reciprocal.iter().chain(&ray.far).any(|x| x.is_nan());
        let reach = ray
            .direction
            .iter()
            .fold(0.0, |r: f32, d| larger(r, d.abs()));
        // A comparison with a NaN is false, so this refuses them too.
        let reaches = ray.tmin <= ray.tmax && ray.tmax >= 0.0;
        if !finite || nan || reach == 0.0 || !reaches {
            return None;
        }
        let mut prepared = Prepared {
            origin: ray.origin,
            direction: ray.direction,
            near: ray.reciprocal,
            far: ray.far,
            tmin: larger(ray.tmin, 0.0),
            reach,
            ..Prepared::default()
        };
        for axis in 0..3 {
            prepared.parallel[axis] = ray.direction[axis] == 0.0;
            prepared.negative[axis] = ray.reciprocal[axis].is_sign_negative();
            // The reciprocal of a denormal is infinite. A near plane may come nearer, never go
            // farther; a far plane goes to infinity, or to a NaN that is ignored.
            if ray.reciprocal[axis].is_infinite() {
                prepared.near[axis] = f32::MAX.copysign(ray.reciprocal[axis]);
            }
        }
        Some(prepared)
    }

    /// Where the ray enters the box, if it meets it no farther than `limit`. Closed: touching
    /// counts. 6 subtractions, 6 multiplications, 11 comparisons.
    #[inline]
    pub fn meets(&self, min: &[f32; 3], max: &[f32; 3], limit: f32) -> Option<f32> {
        let mut enter = self.tmin;
        let mut leave = limit;
        for axis in 0..3 {
            let origin = self.origin[axis];
            if self.parallel[axis] {
                if origin < min[axis] || origin > max[axis] {
                    return None;
                }
                continue;
            }
            let (near, far) = if self.negative[axis] {
                (max[axis], min[axis])
            } else {
                (min[axis], max[axis])
            };
            let near = (near - origin) * self.near[axis];
            let far = (far - origin) * self.far[axis];
            // Written so that a NaN changes nothing.
            if near > enter {
                enter = near;
            }
            if far < leave {
                leave = far;
            }
        }
        (enter <= leave).then_some(enter)
    }

    /// Distance and weights where the ray meets the triangle, whatever was hit before, for
    /// distances beyond the ray's `tmin`. 12 additions, 10 multiplications and a division as in
    /// the paper, and for the epsilon 4 multiplications, 1 addition and 4 comparisons more.
    #[inline]
    pub fn intersect(&self, triangle: &TriangleRecord, rcp: Approx) -> Option<(f32, f32, f32)> {
        let k = triangle.axis as usize;
        if k > 2 {
            return None;
        }
        let (u, v) = (NEXT[k], NEXT[NEXT[k]]);
        let [nu, nv] = triangle.normal;
        let [ak, au, av] = triangle.anchor;
        let (pk, pu, pv) = (
            self.origin[k] - ak,
            self.origin[u] - au,
            self.origin[v] - av,
        );
        let (dk, du, dv) = (self.direction[k], self.direction[u], self.direction[v]);
        let along = dk + (nu * du + nv * dv);
        let above = -(pk + (nu * pu + nv * pv));
        let (inverse, t) = match rcp {
            Approx::Exact => (1.0 / along, above / along),
            Approx::Table { bits, steps } => {
                let inverse =
                    f32::from_bits(semantics::elementary::rcp(along.to_bits(), bits, steps));
                (inverse, above * inverse)
            }
        };
        // An infinite t, or a NaN from a ray in the plane, is no hit.
        if !(t > self.tmin && t <= f32::MAX) {
            return None;
        }
        let (hu, hv) = (pu + t * du, pv + t * dv);
        let weight_u = hu * triangle.row_u[0] + hv * triangle.row_u[1];
        let weight_v = hu * triangle.row_v[0] + hv * triangle.row_v[1];
        let size = t * self.reach + larger(larger(pk.abs(), pu.abs()), pv.abs());
        let grazing = larger(1.0, inverse.abs() * self.reach);
        // Never more than the triangle's own size, or a ray along its plane would hit anywhere.
        let epsilon = smaller(triangle.slack * size * grazing, 1.0);
        let inside =
            weight_u >= -epsilon && weight_v >= -epsilon && weight_u + weight_v <= 1.0 + epsilon;
        inside.then(|| {
            let (weight_u, weight_v) = clamp_weights(weight_u, weight_v);
            (t, weight_u, weight_v)
        })
    }
}

const NEXT: [usize; 3] = [1, 2, 0];

/// Weights that epsilon let pass, moved into the triangle: not negative, and at most 1 together.
fn clamp_weights(u: f32, v: f32) -> (f32, f32) {
    let u = smaller(larger(u, 0.0), 1.0);
    (u, smaller(larger(v, 0.0), 1.0 - u))
}

#[inline]
fn larger(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

#[inline]
fn smaller(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// What a ray has hit so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in lengths of the direction; `tmax` where nothing was hit.
    pub t: f32,
    /// Weight of vertex 1.
    pub u: f32,
    /// Weight of vertex 2.
    pub v: f32,
    /// The triangle, or [`NO_HIT`].
    pub primitive: u32,
}

/// The primitive of a ray that hit nothing.
pub const NO_HIT: u32 = u32::MAX;

impl Hit {
    /// No hit yet, for a ray that ends at `tmax`.
    pub fn none(tmax: f32) -> Hit {
        Hit {
            t: tmax,
            u: 0.0,
            v: 0.0,
            primitive: NO_HIT,
        }
    }

    /// Whether something was hit.
    pub fn is_hit(&self) -> bool {
        self.primitive != NO_HIT
    }

    /// Takes `other` where it is nearer; of equally near ones that with the smaller primitive, so
    /// that the order of traversal decides nothing. Says whether it did.
    pub fn take_nearer(&mut self, other: Hit) -> bool {
        let nearer = other.t < self.t || (other.t == self.t && other.primitive < self.primitive);
        if nearer {
            *self = other;
        }
        nearer
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether the ray meets the box within a distance that no limit cuts.
    fn meets(origin: [f32; 3], direction: [f32; 3], min: [f32; 3], max: [f32; 3]) -> bool {
        let ray = Ray::new(origin, direction, 0.0, f32::MAX, 0);
        let prepared = Prepared::of(&ray).expect("a proper ray");
        prepared.meets(&min, &max, f32::MAX).is_some()
    }

    #[test]
    fn boxes_that_fail_naive_tests() {
        // A zero direction with the origin on a plane: 0 · ∞.
        let flat = ([0.0, -1.0, -1.0], [0.0, 0.0, 0.0]);
        assert!(meets([0.0; 3], [0.0, -1.0, 0.0], flat.0, flat.1));
        let unit = ([0.0; 3], [1.0; 3]);
        assert!(meets([0.0, -2.0, 0.5], [-0.0, 1.0, 0.0], unit.0, unit.1));
        // Denormal directions, whose reciprocal is infinite.
        assert!(meets([-0.0, 1.0, -1.0], [1e-45, 0.0, 1.0], unit.0, unit.1));
        assert!(meets(
            [-2.0, -0.0, -1e-40],
            [1e-30, -0.0, 1.175_494_4e-38],
            unit.0,
            unit.1
        ));
        // Through an edge: 41 · (1/41) < 1 in binary32.
        assert!(meets(
            [-41.0, -1.0, 0.0],
            [41.0, 1.0, 0.0],
            [-1.0, 0.0, -1.0],
            [0.0, 1.0, 1.0]
        ));
        // The origin on an upper plane.
        assert!(meets(
            [1.0, -4.0, 1.0],
            [-7.0, 49.0, 0.0],
            [0.0, -1.0, -1.0],
            [0.0, 3.0, 1.0]
        ));
        assert!(!meets([2.0, -2.0, 0.5], [-0.0, 1.0, 0.0], unit.0, unit.1));
        assert!(!meets([0.5, 2.0, 0.5], [0.0, 1.0, 0.0], unit.0, unit.1));
    }

    #[test]
    fn rays_that_hit_nothing() {
        let good = Ray::new([0.0; 3], [0.0, 0.0, 1.0], 0.0, 1.0, 0);
        assert!(Prepared::of(&good).is_some());
        let with = |change: &dyn Fn(&mut Ray)| {
            let mut ray = good;
            change(&mut ray);
            Prepared::of(&ray).is_none()
        };
        assert!(with(&|r| r.origin[1] = f32::NAN));
        assert!(with(&|r| r.origin[1] = f32::INFINITY));
        assert!(with(&|r| r.direction[0] = f32::NEG_INFINITY));
        assert!(with(&|r| r.direction = [0.0, -0.0, 0.0]));
        assert!(with(&|r| r.reciprocal[2] = f32::NAN));
        assert!(with(&|r| r.tmax = f32::NAN));
        assert!(with(&|r| r.tmin = f32::NAN));
        assert!(with(&|r| (r.tmin, r.tmax) = (0.9, 0.5)));
        assert!(with(&|r| r.tmax = -1.0));
        assert!(!with(&|r| r.tmax = f32::INFINITY));
    }

    #[test]
    fn shared_edges_do_not_leak() {
        // Rays from one point to points on the edge of two triangles, that exact arithmetic says
        // hit at least one of them.
        use glam::{Vec2, Vec3};
        let triangle = |positions: [[f32; 3]; 3]| {
            let triangle = crate::scene::Triangle {
                positions: positions.map(Vec3::from),
                normals: [Vec3::Z; 3],
                uvs: [Vec2::ZERO; 3],
                material: 0,
            };
            TriangleRecord::of(&triangle, 0)
        };
        let (a, b) = ([1.0, -1.0, 1.0], [0.0, 0.0, -1.0]);
        let (c, e) = ([0.0, 1.0, 0.0], [-1.0, -1.0, 0.0]);
        let ray = Ray::new([0.0; 3], [1.0, -1.0, 1.0], 0.0, f32::MAX, 0);
        let ray = Prepared::of(&ray).expect("a proper ray");
        let hits = [triangle([a, b, c]), triangle([b, a, e])]
            .iter()
            .filter(|t| ray.intersect(t, Approx::Exact).is_some())
            .count();
        assert!(hits >= 1);
    }

    #[test]
    fn the_nearer_hit_counts_and_ties_go_to_the_smaller_primitive() {
        let hit = |t, primitive| Hit {
            t,
            u: 0.0,
            v: 0.0,
            primitive,
        };
        let mut best = Hit::none(2.0);
        assert!(!best.take_nearer(hit(2.5, 1)));
        assert!(best.take_nearer(hit(2.0, 7)));
        assert!(!best.take_nearer(hit(2.0, 8)));
        assert!(best.take_nearer(hit(2.0, 3)));
        assert!(best.take_nearer(hit(1.0, 9)));
        assert_eq!(best.primitive, 9);
    }
}
