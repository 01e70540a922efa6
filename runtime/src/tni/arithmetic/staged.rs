//! The ray–triangle tests stage by stage: what they give where the first stages round as the unit
//! does and the others do not.
//!
//! A sum or a product of two binary32 numbers in binary64, rounded to binary32, is what binary32
//! gives; so with all stages rounding this is the unit, and the difference that each stage makes is
//! its share of the error.

use srp_archdesc::arch::Approx;
use srp_archdesc::datapath::Intersection;

use super::triangle::{NEXT, Wide, quotient, reciprocal};
use super::{Ray, longest};
use crate::bvh::TriangleRecord;

/// The stages of a test, in order. Before the first, only the record of the triangle is rounded.
pub fn stages(test: Intersection) -> &'static [&'static str] {
    match test {
        Intersection::Wald | Intersection::AnchorWald | Intersection::AnchorWaldScaled => {
            &["plane", "reciprocal", "hit point", "weights"]
        }
        Intersection::Woop => &["shear", "edge functions", "distance", "reciprocal"],
        Intersection::WoopWide => &["edge functions", "distance", "reciprocal"],
    }
}

/// Which stages round.
#[derive(Clone, Copy)]
struct Rounding {
    stages: usize,
}

impl Rounding {
    /// A number that a stage makes.
    #[inline]
    fn of(self, stage: usize, x: f64) -> f64 {
        match stage < self.stages {
            true => f64::from(x as f32),
            false => x,
        }
    }

    /// A sum of two products.
    #[inline]
    fn products(self, stage: usize, [a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
        let (ab, cd) = (self.of(stage, a * b), self.of(stage, c * d));
        self.of(stage, ab + cd)
    }
}

/// Distance and weights of vertices 1 and 2 where a ray meets a triangle, whether or not that is
/// inside, the first `rounding` [stages] rounding.
pub fn staged(
    ray: &Ray,
    triangle: &TriangleRecord,
    test: Intersection,
    rcp: Approx,
    rounding: usize,
) -> [f64; 3] {
    let r = Rounding { stages: rounding };
    match test {
        Intersection::Wald => projected(ray, Words::wald(triangle), rcp, r),
        Intersection::AnchorWald | Intersection::AnchorWaldScaled => {
            projected(ray, Words::anchored(triangle), rcp, r)
        }
        Intersection::Woop => woop(ray, triangle, rcp, r),
        Intersection::WoopWide => woop_wide(ray, triangle, rcp, r),
    }
}

/// The words that all projections use: a plane through an anchor, and two rows.
struct Words {
    axis: usize,
    normal: [f64; 2],
    anchor: [f64; 3],
    distance: f64,
    rows: [[f64; 3]; 2],
}

impl Words {
    fn wald(triangle: &TriangleRecord) -> Words {
        let w = triangle.wald();
        Words {
            axis: w.axis as usize % 3,
            normal: w.normal.map(f64::from),
            anchor: [0.0; 3],
            distance: f64::from(w.distance),
            rows: [w.row_u, w.row_v].map(|row| row.map(f64::from)),
        }
    }

    fn anchored(triangle: &TriangleRecord) -> Words {
        let w = triangle.anchored();
        let row = |row: [f32; 2]| [f64::from(row[0]), f64::from(row[1]), 0.0];
        Words {
            axis: w.axis as usize % 3,
            normal: w.normal.map(f64::from),
            anchor: w.anchor.map(f64::from),
            distance: 0.0,
            rows: [row(w.row_u), row(w.row_v)],
        }
    }
}

fn projected(ray: &Ray, w: Words, rcp: Approx, r: Rounding) -> [f64; 3] {
    let axes = [w.axis, NEXT[w.axis], NEXT[NEXT[w.axis]]];
    let from: [f64; 3] =
        std::array::from_fn(|i| r.of(0, f64::from(ray.origin[axes[i]]) - w.anchor[i]));
    let d = axes.map(|axis| f64::from(ray.direction[axis]));
    let along = |x: [f64; 3]| {
        let rest = r.products(0, [w.normal[0], x[1]], [w.normal[1], x[2]]);
        r.of(0, x[0] + rest)
    };
    let above = r.of(0, w.distance - along(from));
    let t = match r.stages > 1 {
        true => f64::from(quotient(above as f32, along(d) as f32, rcp)),
        false => above / along(d),
    };
    let at = |i: usize| r.of(2, from[i] + r.of(2, t * d[i]));
    let (hu, hv) = (at(1), at(2));
    let weight = |row: [f64; 3]| r.of(3, r.products(3, [hu, row[0]], [hv, row[1]]) + row[2]);
    [t, weight(w.rows[0]), weight(w.rows[1])]
}

fn woop(ray: &Ray, triangle: &TriangleRecord, rcp: Approx, r: Rounding) -> [f64; 3] {
    let z = longest(ray.direction);
    let axes = [NEXT[z], NEXT[NEXT[z]]];
    let inverse = match r.stages > 0 {
        true => f64::from(ray.reciprocal[z]),
        false => 1.0 / f64::from(ray.direction[z]),
    };
    let slopes = axes.map(|axis| r.of(0, f64::from(ray.direction[axis]) * inverse));
    let corners = triangle.woop().vertices.map(|vertex| {
        let from = |axis: usize| r.of(1, f64::from(vertex[axis]) - f64::from(ray.origin[axis]));
        let along = from(z);
        let across = |i: usize| r.of(1, from(axes[i]) - r.of(1, slopes[i] * along));
        [across(0), across(1), r.of(2, inverse * along)]
    });
    let [a, b, c] = corners;
    let edge = |p: [f64; 3], q: [f64; 3]| r.of(1, p[0] * q[1] - p[1] * q[0]);
    let weights = [edge(c, b), edge(a, c), edge(b, a)];
    let sum = r.of(1, r.of(1, weights[0] + weights[1]) + weights[2]);
    let part = |i: usize| r.of(2, weights[i] * corners[i][2]);
    let above = r.of(2, r.of(2, part(0) + part(1)) + part(2));
    let over = match r.stages > 3 {
        true => f64::from(reciprocal(sum as f32, rcp)),
        false => 1.0 / sum,
    };
    [above, weights[1], weights[2]].map(|x| r.of(3, x * over))
}

/// Before the first stage nothing is rounded that binary32 could tell.
fn woop_wide(ray: &Ray, triangle: &TriangleRecord, rcp: Approx, r: Rounding) -> [f64; 3] {
    let vertices = triangle.woop().vertices;
    let wide = Wide::of(ray.origin, ray.direction, longest(ray.direction), vertices);
    let [below, above, u, v] = wide.quotients();
    let [below, u, v] = [below, u, v].map(|x| r.of(0, x));
    let over = match r.stages > 2 {
        true => f64::from(reciprocal(below as f32, rcp)),
        false => 1.0 / below,
    };
    [r.of(1, above), u, v].map(|x| r.of(2, x * over))
}

#[cfg(test)]
mod tests {
    use super::super::Prepared;
    use super::*;
    use crate::scene::demo::demo;

    #[test]
    fn with_all_stages_it_is_the_unit() {
        let triangles = demo().triangles;
        let mut tried = 0;
        for test in Intersection::ALL {
            for rcp in [Approx::Exact, Approx::table(12, 1)] {
                for (i, triangle) in triangles.iter().enumerate() {
                    let record = TriangleRecord::of(triangle, i as u32, test);
                    let middle = triangle.positions.iter().sum::<glam::Vec3>() / 3.0;
                    let origin = glam::Vec3::new(0.4, 1.1, 3.7);
                    let way = (middle - origin).to_array();
                    let ray = Ray::new(origin.to_array(), way, 0.0, f32::MAX, 0);
                    let prepared = Prepared::of(&ray).expect("a proper ray");
                    let Some(hit) = prepared.intersect(&record, test, rcp) else {
                        continue;
                    };
                    let all = staged(&ray, &record, test, rcp, stages(test).len());
                    let expected = [hit.t, hit.u, hit.v].map(f64::from);
                    assert_eq!(all, expected, "{}: triangle {i}", test.name());
                    let none = staged(&ray, &record, test, rcp, 0);
                    assert!((none[0] - 1.0).abs() < 1e-2, "{}: {none:?}", test.name());
                    tried += 1;
                }
            }
        }
        assert!(tried > 1000);
    }
}
