//! The order in which rays come.

use std::ops::Range;

use super::pixels::on_curve;
use super::scramble;
use serde::Serialize;
use srp_runtime::tni::arithmetic::Ray;

/// Orders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Order {
    /// By a Morton key of six dimensions, origin and direction, in each batch. Pixels along a
    /// Z-curve where that decides nothing.
    Morton,
    /// As they are made: pixels along a Z-curve, a pixel's rays together.
    Pixels,
    /// As they are made, pixels row by row.
    Rows,
    /// Shuffled in each batch.
    Random,
}

/// Bits of the key for each dimension.
const BITS: u32 = 21;

impl Order {
    /// All of them.
    pub const ALL: [Order; 4] = [Order::Morton, Order::Pixels, Order::Rows, Order::Random];

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Order::Morton => "morton",
            Order::Pixels => "pixels",
            Order::Rows => "rows",
            Order::Random => "random",
        }
    }

    /// The pixel with this number in a picture, column and row.
    pub(super) fn pixel(self, number: u64, width: u32, height: u32) -> (u32, u32) {
        match self {
            // Both are smaller than the sides of the picture.
            Order::Rows => (
                (number % u64::from(width)) as u32,
                (number / u64::from(width)) as u32,
            ),
            _ => on_curve(number, width, height),
        }
    }

    /// Puts the rays of a batch in this order.
    pub fn sort(self, rays: &mut Vec<Ray>) {
        if matches!(self, Order::Morton | Order::Random) {
            let all = 0..rays.len();
            let numbers = self.numbers(rays, &[all]);
            *rays = numbers.into_iter().map(|i| rays[i as usize]).collect();
        }
    }

    /// The numbers of the rays of a batch in this order, those at the places that are asked for; elsewhere any may
    /// stand. The ranges of places go up and have nothing in common.
    pub(super) fn numbers(self, rays: &[Ray], places: &[Range<usize>]) -> Vec<u32> {
        match self {
            Order::Morton => {
                let mut keys = keys(rays);
                settle(&mut keys, 0, places);
                keys.into_iter().map(|(_, i)| i).collect()
            }
            Order::Random => {
                let mut numbers: Vec<u32> = (0..rays.len() as u32).collect();
                // Fisher and Yates, with numbers that are the same every time.
                for i in (1..rays.len()).rev() {
                    let j = (u64::from(scramble(i as u32)) * (i as u64 + 1)) >> 32;
                    numbers.swap(i, j as usize);
                }
                numbers
            }
            Order::Pixels | Order::Rows => (0..rays.len() as u32).collect(),
        }
    }
}

/// Sorts keys, of which the first has the place `start`, as far as these places need it.
fn settle(keys: &mut [(u128, u32)], start: usize, places: &[Range<usize>]) {
    let (Some(first), Some(last)) = (places.first(), places.last()) else {
        return;
    };
    if places.len() == 1 {
        let (from, to) = (first.start - start, last.end - start);
        if from > 0 && from < keys.len() {
            keys.select_nth_unstable(from);
        }
        let keys = &mut keys[from..];
        if to - from < keys.len() {
            keys.select_nth_unstable(to - from);
        }
        keys[..to - from].sort_unstable();
        return;
    }
    let (before, after) = places.split_at(places.len() / 2);
    let middle = after[0].start - start;
    if middle < keys.len() {
        keys.select_nth_unstable(middle);
    }
    let (lower, upper) = keys.split_at_mut(middle.min(keys.len()));
    settle(lower, start, before);
    settle(upper, start + middle, after);
}

/// Keys of the rays with their positions. Origins count within their bounds, directions
/// within the unit cube.
fn keys(rays: &[Ray]) -> Vec<(u128, u32)> {
    let (mut lo, mut hi) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for ray in rays {
        for axis in 0..3 {
            lo[axis] = lo[axis].min(ray.origin[axis]);
            hi[axis] = hi[axis].max(ray.origin[axis]);
        }
    }
    let key = |ray: &Ray| {
        let d = ray.direction.map(f64::from);
        let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        let mut key = 0;
        for axis in 0..3 {
            let size = f64::from(hi[axis]) - f64::from(lo[axis]);
            let origin = (f64::from(ray.origin[axis]) - f64::from(lo[axis])) / size;
            let direction = (d[axis] / length + 1.0) / 2.0;
            key |= spread(quantise(origin)) << axis;
            key |= spread(quantise(direction)) << (3 + axis);
        }
        key
    };
    (0..).zip(rays).map(|(i, ray)| (key(ray), i)).collect()
}

/// A number of 0 to 1 in [`BITS`] bits; 0 for a NaN.
fn quantise(x: f64) -> u32 {
    let steps = f64::from(1u32 << BITS);
    ((x * steps) as u32).min((1 << BITS) - 1)
}

/// Dimensions of a key.
const DIMENSIONS: u32 = 6;

/// The low [`BITS`] bits of a number, [`DIMENSIONS`] places apart.
fn spread(n: u32) -> u128 {
    (0..BITS / CHUNK).fold(0, |key, i| {
        let chunk = (n >> (i * CHUNK)) & ((1 << CHUNK) - 1);
        key | u128::from(SPREAD[chunk as usize]) << (i * CHUNK * DIMENSIONS)
    })
}

/// Bits that are spread at once.
const CHUNK: u32 = 7;

static SPREAD: [u64; 1 << CHUNK] = spread_chunks();

const fn spread_chunks() -> [u64; 1 << CHUNK] {
    let mut table = [0; 1 << CHUNK];
    let mut n = 0;
    while n < table.len() {
        let mut bit = 0;
        while bit < CHUNK {
            table[n] |= ((n as u64 >> bit) & 1) << (bit * DIMENSIONS);
            bit += 1;
        }
        n += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_keep_every_ray_and_morton_keeps_neighbours_together() {
        let mut rays: Vec<Ray> = (0..4096u32)
            .map(|i| {
                let at = |bits: u32| (scramble(i + 77 * bits) & 0xff) as f32;
                let mut ray = Ray::new([at(1), at(2), 0.0], [0.0, 0.0, 1.0], 0.0, 1.0, 0);
                ray.payload = i;
                ray
            })
            .collect();
        let apart = |rays: &[Ray]| -> f32 {
            let steps = rays.windows(2).map(|w| {
                (w[0].origin[0] - w[1].origin[0]).abs() + (w[0].origin[1] - w[1].origin[1]).abs()
            });
            steps.sum()
        };
        let before = apart(&rays);
        for order in Order::ALL {
            order.sort(&mut rays);
            let mut seen: Vec<u32> = rays.iter().map(|r| r.payload).collect();
            seen.sort_unstable();
            assert!(seen.into_iter().eq(0..4096), "{}", order.name());
            if order == Order::Morton {
                assert!(apart(&rays) < before / 10.0);
            }
            let (mut all, some) = (rays.clone(), [3..3, 17..40, 40..41, 4000..4096]);
            order.sort(&mut all);
            let numbers = order.numbers(&rays, &some);
            for place in some.into_iter().flatten() {
                assert_eq!(all[place].payload, rays[numbers[place] as usize].payload);
            }
        }
        assert!(apart(&rays) > before / 2.0, "shuffled last");
    }

    #[test]
    fn pixels_follow_a_z() {
        let pixels = |order: Order, w, h| -> Vec<(u32, u32)> {
            (0..u64::from(w * h))
                .map(|n| order.pixel(n, w, h))
                .collect()
        };
        let z = pixels(Order::Pixels, 4, 2);
        let curve = [
            (0, 0),
            (1, 0),
            (0, 1),
            (1, 1),
            (2, 0),
            (3, 0),
            (2, 1),
            (3, 1),
        ];
        assert_eq!(z, curve);
        let rows = pixels(Order::Rows, 2, 2);
        assert_eq!(rows, [(0, 0), (1, 0), (0, 1), (1, 1)]);
    }
}
