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
//! The triangle test is one of several ([`Intersection`](srp_archdesc::datapath::Intersection)).
//! Of the hits that it finds the nearest counts, of equally near ones that of the triangle with the
//! smaller number; and no hit is nearer than its leaf's box ([`Hit::take_nearer`]). So what a ray
//! hits does not depend on the order in which its triangles are tested.

mod staged;
mod triangle;

use serde::{Deserialize, Serialize};
use srp_archdesc::arch::Precision;

pub use staged::{staged, stages};

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
    /// The reciprocal times [the widening](Precision::widening) of far planes.
    pub far: [f32; 3],
    /// Bit 0: a shadow ray, for which any hit will do; bit 1: but the nearest is wanted.
    pub flags: u32,
}

/// Flag of a ray for which any hit will do.
pub const ANY_HIT: u32 = 1;

/// Flag of a shadow ray that wants the nearest hit all the same: it may go on behind it.
pub const NEAREST: u32 = 2;

impl Ray {
    /// A ray with exact reciprocals.
    pub fn new(origin: [f32; 3], direction: [f32; 3], tmin: f32, tmax: f32, flags: u32) -> Ray {
        let reciprocal = direction.map(|d| 1.0 / d);
        let factor = Precision::EXACT.widening();
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

/// The axis along which a direction is longest, the first of equals.
fn longest(direction: [f32; 3]) -> usize {
    let size = direction.map(f32::abs);
    (0..3).fold(0, |k, i| if size[i] > size[k] { i } else { k })
}

/// A ray as the dispatch unit prepares it, once, before it is traversed.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
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
    /// Largest part of the direction, and its axis.
    reach: f32,
    longest: usize,
    /// Slopes of the ray along `longest`, for the two axes after it, and the reciprocal there.
    shear: [f32; 3],
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
        let longest = longest(ray.direction);
        let reach = ray.direction[longest].abs();
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
            longest,
            shear: triangle::shear(ray, longest),
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

    /// [`meets`](Self::meets) of two boxes: their lowest and highest corners, axis by axis, side by side.
    #[inline]
    pub fn meets_both(&self, corners: &[[[f32; 2]; 3]; 2], limit: f32) -> [Option<f32>; 2] {
        let mut enter = [self.tmin; 2];
        let mut leave = [limit; 2];
        let mut outside = [false; 2];
        let [lowest, highest] = corners;
        for (axis, (low, high)) in lowest.iter().zip(highest).enumerate() {
            let origin = self.origin[axis];
            if self.parallel[axis] {
                for side in 0..2 {
                    outside[side] |= origin < low[side] || origin > high[side];
                }
                continue;
            }
            let (near, far) = match self.negative[axis] {
                true => (high, low),
                false => (low, high),
            };
            for side in 0..2 {
                let near = (near[side] - origin) * self.near[axis];
                let far = (far[side] - origin) * self.far[axis];
                enter[side] = larger(enter[side], near);
                leave[side] = smaller(leave[side], far);
            }
        }
        [0, 1].map(|side| {
            let met = enter[side] <= leave[side] && !outside[side];
            met.then_some(enter[side])
        })
    }
}

#[inline]
fn larger(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

#[inline]
fn smaller(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// The nearest hit of a ray so far.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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

    /// True if something was hit.
    pub fn is_hit(&self) -> bool {
        self.primitive != NO_HIT
    }

    /// Takes `other` where it is nearer; of equally near ones that with the smaller primitive.
    /// Says whether it did.
    ///
    /// `enter` is where the ray enters the box of the triangle's leaf. A test may be off by more
    /// than a box is, so a distance before it counts as that of the box: then no box that is left
    /// out because it begins behind the nearest hit can hold a nearer one.
    #[inline]
    pub fn take_nearer(&mut self, other: Hit, enter: f32) -> bool {
        let other = Hit {
            t: larger(other.t, enter),
            ..other
        };
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

    /// True if the ray meets the box within a distance that no limit cuts.
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
    fn two_boxes_are_met_as_each_of_them() {
        let special = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            0.5,
            41.0,
            1e-45,
            -1e-40,
            3e38,
            -3e38,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::NAN,
        ];
        let mut state = 1u32;
        let mut any = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            special[(state >> 8) as usize % special.len()]
        };
        let (mut met, mut missed) = (0, 0);
        for _ in 0..200_000 {
            let mut vector = || [any(), any(), any()];
            let ray = Ray::new(vector(), vector(), 0.0, 1e30, 0);
            let boxes = [[vector(), vector()], [vector(), vector()]];
            let Some(prepared) = Prepared::of(&ray) else {
                continue;
            };
            let limit = any();
            let alone = boxes.map(|[min, max]| prepared.meets(&min, &max, limit));
            let corners = [0, 1].map(|end: usize| {
                [0, 1, 2].map(|axis: usize| [boxes[0][end][axis], boxes[1][end][axis]])
            });
            let both = prepared.meets_both(&corners, limit);
            let bits = |m: [Option<f32>; 2]| m.map(|enter| enter.map(f32::to_bits));
            assert_eq!(bits(both), bits(alone), "{ray:?} {boxes:?} {limit}");
            met += alone.iter().flatten().count();
            missed += 2 - alone.iter().flatten().count();
        }
        assert!(met > 1000 && missed > 1000, "{met} {missed}");
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
    fn the_nearer_hit_counts_and_ties_go_to_the_smaller_primitive() {
        let hit = |t, primitive| Hit {
            t,
            u: 0.0,
            v: 0.0,
            primitive,
        };
        let mut best = Hit::none(2.0);
        assert!(!best.take_nearer(hit(2.5, 1), 0.5));
        assert!(best.take_nearer(hit(2.0, 7), 0.5));
        assert!(!best.take_nearer(hit(2.0, 8), 0.5));
        assert!(best.take_nearer(hit(2.0, 3), 0.5));
        assert!(best.take_nearer(hit(1.0, 9), 0.5));
        assert_eq!(best.primitive, 9);
        // Before its box no triangle is hit.
        assert!(best.take_nearer(hit(0.25, 1), 0.75));
        assert_eq!(best.t, 0.75);
        assert!(!best.take_nearer(hit(0.25, 2), 0.75));
    }
}
