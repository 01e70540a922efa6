//! Exact arithmetic for rays and triangles whose numbers are binary32: sums of binary64 numbers
//! that do not overlap (Shewchuk, "Adaptive precision floating-point arithmetic", 1997). No
//! rounding, so no doubt.

use std::cmp::Ordering;

use srp_runtime::scene::Triangle;
use srp_runtime::tni::arithmetic::Ray;

/// A number: the sum of its parts, which grow in magnitude and do not overlap.
#[derive(Clone, Debug)]
struct Exact(Vec<f64>);

/// `a + b` and what rounding took from it.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let from_b = sum - a;
    (sum, (a - (sum - from_b)) + (b - from_b))
}

impl Exact {
    fn of(x: f32) -> Exact {
        Exact(vec![f64::from(x)])
    }

    fn plus_number(&self, mut b: f64) -> Exact {
        let mut parts = Vec::with_capacity(self.0.len() + 1);
        for &a in &self.0 {
            let (sum, rest) = two_sum(b, a);
            if rest != 0.0 {
                parts.push(rest);
            }
            b = sum;
        }
        parts.push(b);
        Exact(parts)
    }

    fn plus(&self, other: &Exact) -> Exact {
        other
            .0
            .iter()
            .fold(self.clone(), |sum, &b| sum.plus_number(b))
    }

    fn minus(&self, other: &Exact) -> Exact {
        other
            .0
            .iter()
            .fold(self.clone(), |sum, &b| sum.plus_number(-b))
    }

    fn times(&self, other: &Exact) -> Exact {
        let mut sum = Exact(vec![0.0]);
        for &a in &self.0 {
            for &b in &other.0 {
                let product = a * b;
                sum = sum.plus_number(a.mul_add(b, -product)).plus_number(product);
            }
        }
        sum
    }

    fn sign(&self) -> Ordering {
        let largest = self.0.iter().rev().find(|part| **part != 0.0);
        largest.map_or(Ordering::Equal, |part| part.total_cmp(&0.0))
    }
}

type Vector = [Exact; 3];

fn triple(a: &Vector, b: &Vector, c: &Vector) -> Exact {
    let minor = |i: usize, j: usize| b[i].times(&c[j]).minus(&b[j].times(&c[i]));
    let x = a[0].times(&minor(1, 2));
    let y = a[1].times(&minor(2, 0));
    x.plus(&y).plus(&a[2].times(&minor(0, 1)))
}

/// Whether the ray, without its ends but for the origin, meets the closed triangle in exact
/// arithmetic. A ray in the triangle's plane meets nothing.
pub(crate) fn meets(ray: &Ray, triangle: &Triangle) -> bool {
    let direction = ray.direction.map(Exact::of);
    let [a, b, c] = triangle.positions.map(|p| {
        let p = p.to_array();
        [0, 1, 2].map(|i| Exact::of(p[i]).minus(&Exact::of(ray.origin[i])))
    });
    let weights = [
        triple(&direction, &c, &b),
        triple(&direction, &a, &c),
        triple(&direction, &b, &a),
    ];
    let signs = weights.each_ref().map(Exact::sign);
    let sum = weights[0].plus(&weights[1]).plus(&weights[2]).sign();
    if signs.contains(&Ordering::Less) && signs.contains(&Ordering::Greater) {
        return false;
    }
    // The distance is a·(b×c) over minus the sum of the weights.
    sum != Ordering::Equal && triple(&a, &b, &c).sign() == sum.reverse()
}

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
