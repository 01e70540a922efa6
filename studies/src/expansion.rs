//! Numbers without rounding: sums of binary64 numbers that do not overlap (Shewchuk, "Adaptive precision
//! floating-point arithmetic", 1997).

use std::cmp::Ordering;

/// A number: the sum of its parts, which grow in magnitude and do not overlap.
#[derive(Clone, Debug)]
pub(crate) struct Expansion(Vec<f64>);

/// `a + b` and what rounding took from it.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let from_b = sum - a;
    (sum, (a - (sum - from_b)) + (b - from_b))
}

impl Expansion {
    pub(crate) fn of(x: f32) -> Expansion {
        Expansion::of_double(f64::from(x))
    }

    pub(crate) fn of_double(x: f64) -> Expansion {
        Expansion(vec![x])
    }

    /// The parts, of which the last is the largest.
    pub(crate) fn parts(&self) -> &[f64] {
        &self.0
    }

    /// The same number times a power of two, where nothing under- or overflows.
    pub(crate) fn scaled(&self, factor: f64) -> Expansion {
        Expansion(self.0.iter().map(|part| part * factor).collect())
    }

    /// About the same number in at most `most` parts: each carries what the larger ones leave of it to 53
    /// bits (Shewchuk's *compress*), and what is beyond them is cut off.
    pub(crate) fn rounded(&self, most: usize) -> Expansion {
        let mut from_top = Vec::with_capacity(self.0.len());
        let mut carried = 0.0;
        for &part in self.0.iter().rev() {
            let (sum, rest) = two_sum(carried, part);
            if rest == 0.0 {
                carried = sum;
            } else {
                from_top.push(sum);
                carried = rest;
            }
        }
        from_top.push(carried);
        let mut parts = Vec::with_capacity(from_top.len());
        let mut above = 0.0;
        for &part in from_top.iter().rev() {
            let (sum, rest) = two_sum(part, above);
            if rest != 0.0 {
                parts.push(rest);
            }
            above = sum;
        }
        parts.push(above);
        let first = parts.len().saturating_sub(most);
        Expansion(parts.split_off(first))
    }

    pub(crate) fn plus_number(&self, mut b: f64) -> Expansion {
        let mut parts = Vec::with_capacity(self.0.len() + 1);
        for &a in &self.0 {
            let (sum, rest) = two_sum(b, a);
            if rest != 0.0 {
                parts.push(rest);
            }
            b = sum;
        }
        parts.push(b);
        Expansion(parts)
    }

    pub(crate) fn plus(&self, other: &Expansion) -> Expansion {
        other
            .0
            .iter()
            .fold(self.clone(), |sum, &b| sum.plus_number(b))
    }

    pub(crate) fn minus(&self, other: &Expansion) -> Expansion {
        other
            .0
            .iter()
            .fold(self.clone(), |sum, &b| sum.plus_number(-b))
    }

    pub(crate) fn times(&self, other: &Expansion) -> Expansion {
        let mut sum = Expansion(vec![0.0]);
        for &a in &self.0 {
            for &b in &other.0 {
                let product = a * b;
                sum = sum.plus_number(a.mul_add(b, -product)).plus_number(product);
            }
        }
        sum
    }

    pub(crate) fn value(&self) -> f64 {
        self.0.iter().sum()
    }

    pub(crate) fn sign(&self) -> Ordering {
        let largest = self.0.iter().rev().find(|part| **part != 0.0);
        largest.map_or(Ordering::Equal, |part| part.total_cmp(&0.0))
    }
}
