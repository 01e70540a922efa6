//! Rays to measure a T&I unit with: those of Aila, Laine and Karras, "Understanding the efficiency
//! of ray traversal on GPUs – Kepler and Fermi addendum" (2012), which the SGRT paper uses.
//!
//! Primary rays go through pixel centres. Where they hit, secondary rays start, spread over the
//! hemisphere by a Halton sequence that is turned by an angle of the pixel's own: short ones that
//! end with any hit (ambient occlusion), or long ones (diffuse). The payload of every ray is its
//! pixel. All numbers come out the same on every host.

mod file;
mod order;
mod sample;

use glam::{DVec3, Vec3};

use crate::scene::angle::turn;
use crate::scene::{Camera, Triangle};
use crate::tni::Tracer;
use crate::tni::arithmetic::ANY_HIT;

pub use crate::tni::arithmetic::Ray;

pub use file::{MAX_RAYS, read};
pub use order::Order;
pub use sample::{MAX_RUN, Sampling};

/// Rays that are put in order together.
pub const BATCH: usize = 1 << 20;

/// How far secondary rays start in front of the surface, along the primary ray.
const SETBACK: f32 = 1e-4;

/// Longest distance of rays without an end of their own.
const FAR: f32 = f32::MAX;

/// What rays are for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Primary rays.
    Primary,
    /// Ambient occlusion: any hit up to `radius`, so many rays from each visible point.
    AmbientOcclusion {
        /// Samples a pixel.
        samples: u32,
        /// Length of the rays.
        radius: f32,
    },
    /// Diffuse reflection: the nearest hit, so many rays from each visible point.
    Diffuse {
        /// Samples a pixel.
        samples: u32,
    },
}

/// The rays of one view, made when they are wanted.
pub struct Source<'a> {
    primary: Vec<Ray>,
    kind: Kind,
    triangles: &'a [Triangle],
    tracer: Tracer<'a>,
    /// Primary rays that have been used.
    used: usize,
    order: Order,
    /// Rays that are made but not given yet.
    ready: Vec<Ray>,
}

impl<'a> Source<'a> {
    /// The rays of a view of `width`×`height` pixels in the scene of `triangles`, over which
    /// `tracer` traces.
    pub fn new(
        (camera, (width, height)): (&Camera, (u32, u32)),
        kind: Kind,
        triangles: &'a [Triangle],
        tracer: Tracer<'a>,
        order: Order,
    ) -> Source<'a> {
        Source {
            primary: primary(camera, width, height, order),
            kind,
            triangles,
            tracer,
            used: 0,
            order,
            ready: Vec::new(),
        }
    }

    /// The next [`BATCH`] rays, in their order; fewer at the end, and none after it.
    pub fn next_batch(&mut self) -> Vec<Ray> {
        while self.ready.len() < BATCH && self.used < self.primary.len() {
            let ray = self.primary[self.used];
            self.used += 1;
            self.spawn(&ray);
        }
        let rest = self.ready.split_off(self.ready.len().min(BATCH));
        let mut batch = std::mem::replace(&mut self.ready, rest);
        self.order.sort(&mut batch);
        batch
    }

    fn spawn(&mut self, ray: &Ray) {
        let (samples, end, flags) = match self.kind {
            Kind::Primary => {
                self.ready.push(*ray);
                return;
            }
            Kind::AmbientOcclusion { samples, radius } => (samples, radius, ANY_HIT),
            Kind::Diffuse { samples } => (samples, FAR, 0),
        };
        let hit = self.tracer.trace(ray).hit;
        if !hit.is_hit() {
            return;
        }
        let direction = Vec3::from(ray.direction);
        let origin = Vec3::from(ray.origin) + direction * (hit.t - SETBACK).max(0.0);
        let normal = self.triangles[hit.primitive as usize].geometric_normal();
        let normal = if normal.dot(direction) > 0.0 {
            -normal
        } else {
            normal
        };
        let frame = Frame::about(normal.as_dvec3(), ray.payload);
        for sample in 0..samples {
            let direction = frame.direction(sample).as_vec3();
            let mut ray = Ray::new(origin.to_array(), direction.to_array(), 0.0, end, flags);
            ray.payload = self.primary[self.used - 1].payload;
            self.ready.push(ray);
        }
    }
}

/// Rays through the pixel centres, of length 1; along the order's curve through the picture.
fn primary(camera: &Camera, width: u32, height: u32, order: Order) -> Vec<Ray> {
    let fan = camera.ray_fan(width, height);
    let rays = order.pixels(width, height).into_iter().map(|(x, y)| {
        let (right, down) = (
            fan.right.as_dvec3() * f64::from(x),
            fan.down.as_dvec3() * f64::from(y),
        );
        let direction = (fan.corner.as_dvec3() + right + down).normalize().as_vec3();
        let origin = camera.position.to_array();
        let mut ray = Ray::new(origin, direction.to_array(), 0.0, FAR, 0);
        ray.payload = y * width + x;
        ray
    });
    rays.collect()
}

/// A normal and two tangents, turned about it by an angle of the pixel's own.
struct Frame {
    axes: [DVec3; 3],
}

impl Frame {
    fn about(normal: DVec3, pixel: u32) -> Frame {
        // Duff et al. (2017): right for every direction.
        let sign = 1f64.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        let tangent = DVec3::new(
            1.0 + sign * normal.x * normal.x * a,
            sign * b,
            -sign * normal.x,
        );
        let other = DVec3::new(b, sign + normal.y * normal.y * a, -normal.y);
        let (cos, sin) = turn(f64::from(scramble(pixel)) / 4_294_967_296.0);
        Frame {
            axes: [
                tangent * cos + other * sin,
                other * cos - tangent * sin,
                normal,
            ],
        }
    }

    /// Sample `n` of the hemisphere, denser towards the normal by the cosine.
    fn direction(&self, n: u32) -> DVec3 {
        let (x, y) = (halton(n + 1, 2), halton(n + 1, 3));
        let radius = x.sqrt();
        let (cos, sin) = turn(y);
        let up = (1.0 - x).max(0.0).sqrt();
        let [tangent, other, normal] = self.axes;
        (tangent * (radius * cos) + other * (radius * sin) + normal * up).normalize()
    }
}

/// A number that looks random, of another.
fn scramble(n: u32) -> u32 {
    let mut x = n.wrapping_add(0x9e37_79b9);
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// Element `n` ≥ 1 of the Halton sequence in a base, in (0, 1).
fn halton(mut n: u32, base: u32) -> f64 {
    let (mut value, mut scale) = (0.0, 1.0);
    while n > 0 {
        scale /= f64::from(base);
        value += f64::from(n % base) * scale;
        n /= base;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halton_sequences() {
        let of = |base| [1, 2, 3, 4].map(|n| halton(n, base));
        assert_eq!(of(2), [0.5, 0.25, 0.75, 0.125]);
        for (got, expected) in of(3).into_iter().zip([1.0 / 3.0, 2.0 / 3.0, 1.0 / 9.0]) {
            assert!((got - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn samples_are_on_the_hemisphere_with_a_mean_cosine_of_two_thirds() {
        for normal in [DVec3::Z, -DVec3::Z, DVec3::new(0.6, -0.48, 0.64)] {
            for pixel in 0..10 {
                let frame = Frame::about(normal, pixel);
                let cosines: Vec<f64> = (0..512)
                    .map(|n| {
                        let direction = frame.direction(n);
                        assert!((direction.length() - 1.0).abs() < 1e-12);
                        direction.dot(normal)
                    })
                    .collect();
                assert!(cosines.iter().all(|&c| c > 0.0));
                let mean = cosines.iter().sum::<f64>() / 512.0;
                assert!((mean - 2.0 / 3.0).abs() < 0.01, "{mean}");
            }
        }
    }
}
