//! Exact arithmetic for rays, boxes and triangles whose numbers are binary32, by [`expansion`]. No
//! rounding, so no doubt; for products of up to six of them, as binary64 has the exponents.
//!
//! [`expansion`]: crate::expansion

use std::cmp::Ordering;

use crate::expansion::Expansion as Exact;
use srp_runtime::scene::Triangle;
use srp_runtime::tni::arithmetic::Ray;

type Vector = [Exact; 3];

fn vector(v: [f32; 3]) -> Vector {
    v.map(Exact::of)
}

/// `v`, seen from `from`.
fn relative(v: [f32; 3], from: [f32; 3]) -> Vector {
    [0, 1, 2].map(|i| Exact::of(v[i]).minus(&Exact::of(from[i])))
}

fn triple(a: &Vector, b: &Vector, c: &Vector) -> Exact {
    let minor = |i: usize, j: usize| b[i].times(&c[j]).minus(&b[j].times(&c[i]));
    let x = a[0].times(&minor(1, 2));
    let y = a[1].times(&minor(2, 0));
    x.plus(&y).plus(&a[2].times(&minor(0, 1)))
}

/// The distance at which a ray meets a triangle, as a quotient whose denominator is above 0.
#[derive(Clone, Debug)]
pub struct Distance {
    above: Exact,
    below: Exact,
}

impl Distance {
    /// Orders it against another, exactly.
    pub fn compare(&self, other: &Distance) -> Ordering {
        let (a, b) = (
            self.above.times(&other.below),
            other.above.times(&self.below),
        );
        a.minus(&b).sign()
    }

    /// Orders it against a number. NaN is taken for +∞.
    pub fn compare_number(&self, number: f32) -> Ordering {
        if !number.is_finite() {
            return match number == f32::NEG_INFINITY {
                true => Ordering::Greater,
                false => Ordering::Less,
            };
        }
        let number = self.below.times(&Exact::of(number));
        self.above.minus(&number).sign()
    }

    /// About as much in binary64.
    pub fn value(&self) -> f64 {
        self.above.value() / self.below.value()
    }
}

/// Where the line of a ray meets the closed triangle in exact arithmetic, before its origin too. A
/// ray in the triangle's plane meets nothing.
pub fn distance(ray: &Ray, triangle: &Triangle) -> Option<Distance> {
    let direction = vector(ray.direction);
    let [a, b, c] = triangle
        .positions
        .map(|p| relative(p.to_array(), ray.origin));
    let weights = [
        triple(&direction, &c, &b),
        triple(&direction, &a, &c),
        triple(&direction, &b, &a),
    ];
    let signs = weights.each_ref().map(Exact::sign);
    if signs.contains(&Ordering::Less) && signs.contains(&Ordering::Greater) {
        return None;
    }
    let sum = weights[0].plus(&weights[1]).plus(&weights[2]);
    // The distance is a·(b×c) over minus the sum of the weights.
    let (volume, zero) = (triple(&a, &b, &c), Exact::of(0.0));
    match sum.sign() {
        Ordering::Equal => None,
        Ordering::Less => Some(Distance {
            above: volume,
            below: zero.minus(&sum),
        }),
        Ordering::Greater => Some(Distance {
            above: zero.minus(&volume),
            below: sum,
        }),
    }
}

/// True if the ray, without its ends but for the origin, meets the closed triangle in exact arithmetic. A ray
/// in the triangle's plane meets nothing.
pub fn meets(ray: &Ray, triangle: &Triangle) -> bool {
    distance(ray, triangle).is_some_and(|t| t.above.sign() == Ordering::Greater)
}

/// Of the triangles those that the ray meets nearest, beyond its `tmin` and up to its `tmax`, all at
/// the same distance; and that distance.
pub fn nearest(ray: &Ray, triangles: &[Triangle]) -> Option<(Distance, Vec<u32>)> {
    let mut best: Option<(Distance, Vec<u32>)> = None;
    for (i, triangle) in (0..).zip(triangles) {
        let Some(t) = distance(ray, triangle) else {
            continue;
        };
        let begins = t.compare_number(ray.tmin.max(0.0)) == Ordering::Greater;
        if !begins || t.compare_number(ray.tmax) == Ordering::Greater {
            continue;
        }
        match &mut best {
            Some((nearest, found)) => match t.compare(nearest) {
                Ordering::Less => best = Some((t, vec![i])),
                Ordering::Equal => found.push(i),
                Ordering::Greater => {}
            },
            None => best = Some((t, vec![i])),
        }
    }
    best
}

/// True if a triangle has no area: its corners are on a line.
pub fn is_degenerate(triangle: &Triangle) -> bool {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut sides = axes.into_iter().map(|axis| leans(axis, triangle));
    sides.all(|side| side == Ordering::Equal)
}

/// On which side of a triangle's plane a point lies: greater on the side of its normal.
pub fn side(point: [f32; 3], triangle: &Triangle) -> Ordering {
    let [a, b, c] = triangle.positions.map(|p| relative(p.to_array(), point));
    // Seen from the normal's side the vertices run counter-clockwise, and the volume is negative.
    triple(&a, &b, &c).sign().reverse()
}

/// Returns `Greater` if a direction leads to the side of a triangle's normal, `Less` if away from it, and
/// `Equal` if along its plane.
pub fn leans(direction: [f32; 3], triangle: &Triangle) -> Ordering {
    let [a, b, c] = triangle.positions.map(|p| p.to_array());
    triple(&vector(direction), &relative(b, a), &relative(c, a)).sign()
}

/// True if the ray, within its ends, meets the closed box.
pub fn meets_box(ray: &Ray, low: [f32; 3], high: [f32; 3]) -> bool {
    // Each bound as a quotient whose denominator is above 0.
    let end = |plane: f32, axis: usize| {
        let (plane, origin) = (Exact::of(plane), Exact::of(ray.origin[axis]));
        let direction = Exact::of(ray.direction[axis].abs());
        let way = match ray.direction[axis] < 0.0 {
            true => origin.minus(&plane),
            false => plane.minus(&origin),
        };
        Distance {
            above: way,
            below: direction,
        }
    };
    let one = |number: f32| Distance {
        above: Exact::of(number),
        below: Exact::of(1.0),
    };
    let (mut enters, mut leaves) = (vec![one(ray.tmin.max(0.0))], Vec::new());
    if ray.tmax.is_finite() {
        leaves.push(one(ray.tmax));
    }
    for axis in 0..3 {
        let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
        if direction == 0.0 {
            if origin < low[axis] || origin > high[axis] {
                return false;
            }
            continue;
        }
        let (near, far) = match direction < 0.0 {
            true => (high[axis], low[axis]),
            false => (low[axis], high[axis]),
        };
        enters.push(end(near, axis));
        leaves.push(end(far, axis));
    }
    let reaches = |enter: &Distance| {
        let mut leaves = leaves.iter();
        leaves.all(|leave| enter.compare(leave) != Ordering::Greater)
    };
    enters.iter().all(reaches)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};

    #[test]
    fn small_differences_are_not_lost() {
        let number = |x: f32| Exact::of(x);
        let tiny = number(1e-30);
        let sum = number(1e30).plus(&tiny).minus(&number(1e30));
        assert_eq!(sum.minus(&tiny).sign(), Ordering::Equal);
        // (1 + e)(1 - e) - 1 = -e².
        let e = 2f32.powi(-23);
        let product = number(1.0 + e).times(&number(1.0 - e));
        let rest = product.minus(&number(1.0)).plus(&number(e * e));
        assert_eq!(rest.sign(), Ordering::Equal);
    }

    #[test]
    fn a_triangle_is_met_at_a_third() {
        let triangle = Triangle {
            positions: [Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: [Vec3::Z; 3],
            uvs: [Vec2::ZERO; 3],
            material: 0,
        };
        let ray = Ray::new([0.0, 0.0, 1.0], [0.75, 0.75, -3.0], 0.0, 1.0, 0);
        let (t, found) = nearest(&ray, &[triangle, triangle]).expect("it is met");
        assert_eq!(found, [0, 1]);
        assert_eq!(t.compare_number(1.0 / 3.0), Ordering::Less);
        assert_eq!(
            side([0.5, 0.5, f32::MIN_POSITIVE], &triangle),
            Ordering::Greater
        );
        assert_eq!(side([9.0, -9.0, 0.0], &triangle), Ordering::Equal);
        // Within a box up to its side, and not beyond.
        let within = |tmin, tmax| {
            let ray = Ray::new([0.0, 0.0, 1.0], [0.75, 0.75, -3.0], tmin, tmax, 0);
            meets_box(&ray, [0.25; 3], [1.0; 3])
        };
        // It is in the slab of x from 1/3 on, and leaves that of z at 1/4.
        assert!(!within(0.0, 1.0));
        assert!(meets_box(&ray, [0.0; 3], [0.0, 0.0, 1.0]));
    }
}
