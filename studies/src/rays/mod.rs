//! Rays to measure a T&I unit with: those of Aila, Laine and Karras, "Understanding the efficiency
//! of ray traversal on GPUs – Kepler and Fermi addendum" (2012), which the SGRT paper uses.
//!
//! Primary rays go through pixel centres. Where they hit, secondary rays start, spread over the
//! hemisphere by a Halton sequence that is turned by an angle of the pixel's own: short ones that
//! end with any hit (ambient occlusion), or long ones (diffuse). The payload of every ray is its
//! pixel. All numbers come out the same on every host.

mod file;
mod order;
mod pixels;
mod sample;

use std::borrow::Cow;
use std::ops::Range;

use glam::{DVec3, Vec3};

use serde::Serialize;
use srp_archdesc::arch::Precision;
use srp_archdesc::isa::Opcode;
use srp_archdesc::ops::{V4, eval};
use srp_runtime::scene::angle::turn;
use srp_runtime::scene::camera::RayFan;
use srp_runtime::scene::{Camera, Triangle};
use srp_runtime::tni::Tracer;
use srp_runtime::tni::arithmetic::ANY_HIT;

pub use srp_runtime::tni::arithmetic::Ray;

pub use file::{MAX_RAYS, read};
pub use order::Order;
use pixels::Pixels;
pub use sample::{MAX_RUN, Sampling};

/// A ray as the kernels make it on a machine, whose reciprocals and products those of box tests are; steps in code are
/// taken as a unit takes them.
pub(crate) fn kernel_ray(
    precision: &Precision,
    origin: [f32; 3],
    direction: [f32; 3],
    tmax: f32,
) -> Ray {
    let (widening, narrowing) = (precision.widening(), precision.narrowing());
    let precision = &precision.in_units();
    let computed = |op: Opcode, operands: &[f32]| {
        let operands: Vec<V4> = operands.iter().map(|x| V4::word(x.to_bits())).collect();
        let value = eval(op, &operands, 0, precision).ok().flatten();
        f32::from_bits(value.unwrap_or_default().as_word())
    };
    let reciprocal = direction.map(|d| computed(Opcode::Rcp, &[d]));
    let times = |factor: f32| reciprocal.map(|r| computed(Opcode::Fmul, &[r, factor]));
    Ray {
        reciprocal: match narrowing == 1.0 {
            true => reciprocal,
            false => times(narrowing),
        },
        far: times(widening),
        ..Ray::new(origin, direction, 0.0, tmax, 0)
    }
}

/// Rays that are put in order together.
pub const BATCH: usize = 1 << 20;

/// How far secondary rays start in front of the surface, along the primary ray.
const SETBACK: f32 = 1e-4;

/// Longest distance of rays without an end of their own.
const FAR: f32 = f32::MAX;

/// The purpose of rays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
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

/// Rays of one view, or given ones: each is made when it is wanted, in the order of the pixels, and has a place in
/// the [`Order`] of its [`BATCH`]. A view of any size takes a bit for each pixel at most.
pub struct Source<'a> {
    order: Order,
    made: Made<'a>,
}

/// The data that rays are made from.
enum Made<'a> {
    /// Nothing: they are there.
    Given(Cow<'a, [Ray]>),
    Primary(View),
    Secondary(Box<Secondary<'a>>),
}

/// The data that primary rays are made from.
#[derive(Clone, Copy)]
struct View {
    fan: RayFan,
    origin: [f32; 3],
    width: u32,
    height: u32,
    order: Order,
}

/// The data that secondary rays are made from.
struct Secondary<'a> {
    view: View,
    tracer: Tracer<'a>,
    triangles: &'a [Triangle],
    /// The primary rays that hit something, by their numbers.
    seen: Pixels,
    /// The directions of samples about a normal along z.
    samples: Vec<DVec3>,
    end: f32,
    flags: u32,
}

/// A surface at a pixel.
struct Seen {
    pixel: u32,
    origin: Vec3,
    normal: Vec3,
}

impl<'a> Source<'a> {
    /// Rays that are there.
    pub fn given(rays: impl Into<Cow<'a, [Ray]>>, order: Order) -> Source<'a> {
        Source {
            order,
            made: Made::Given(rays.into()),
        }
    }

    /// The rays of a view of `width`×`height` pixels in the scene of `triangles`, over which
    /// `tracer` traces.
    pub fn new(
        (camera, (width, height)): (&Camera, (u32, u32)),
        kind: Kind,
        triangles: &'a [Triangle],
        mut tracer: Tracer<'a>,
        order: Order,
    ) -> Source<'a> {
        let view = View {
            fan: camera.ray_fan(width, height),
            origin: camera.position.to_array(),
            width,
            height,
            order,
        };
        let (samples, end, flags) = match kind {
            Kind::Primary => {
                let made = Made::Primary(view);
                return Source { order, made };
            }
            Kind::AmbientOcclusion { samples, radius } => (samples, radius, ANY_HIT),
            Kind::Diffuse { samples } => (samples, FAR, 0),
        };
        let seen = Pixels::of(view.rays(), |number| {
            let hit = tracer.trace(&view.ray(number)).hit;
            (hit.primitive as usize) < triangles.len()
        });
        let secondary = Secondary {
            view,
            tracer,
            triangles,
            seen,
            samples: (0..samples).map(sample_of_hemisphere).collect(),
            end,
            flags,
        };
        Source {
            order,
            made: Made::Secondary(Box::new(secondary)),
        }
    }

    /// How many rays there are.
    pub fn rays(&self) -> usize {
        match &self.made {
            Made::Given(rays) => rays.len(),
            Made::Primary(view) => view.rays() as usize,
            Made::Secondary(made) => made.seen.len() as usize * made.samples.len(),
        }
    }

    /// How many batches.
    pub fn batches(&self) -> usize {
        self.rays().div_ceil(BATCH)
    }

    /// How many rays a batch has: all but the last have [`BATCH`].
    pub fn rays_of(&self, batch: usize) -> usize {
        self.rays().saturating_sub(batch * BATCH).min(BATCH)
    }

    /// A batch in its order.
    pub fn batch(&self, batch: usize) -> Vec<Ray> {
        let mut rays = self.made(batch);
        self.order.sort(&mut rays);
        rays
    }

    /// The rays of a batch as they are made.
    fn made(&self, batch: usize) -> Vec<Ray> {
        let first = batch * BATCH;
        self.numbered(first..first + self.rays_of(batch))
    }

    /// The rays with these numbers, of which there are none beyond [`rays`](Self::rays).
    fn numbered(&self, numbers: Range<usize>) -> Vec<Ray> {
        match &self.made {
            Made::Given(rays) => rays[numbers].to_vec(),
            Made::Primary(view) => numbers.map(|number| view.ray(number as u64)).collect(),
            Made::Secondary(made) => made.rays(numbers),
        }
    }

    /// Which rays of a batch are at these places of its order, by their numbers as they are made. The ranges of
    /// places go up and have nothing in common.
    pub fn numbers(&self, batch: usize, places: &[Range<usize>]) -> Vec<Vec<u32>> {
        let numbers = match self.order {
            Order::Pixels | Order::Rows => (0..self.rays_of(batch) as u32).collect(),
            _ => self.order.numbers(&self.made(batch), places),
        };
        places.iter().map(|p| numbers[p.clone()].to_vec()).collect()
    }

    /// The ray of a batch with this number.
    pub fn ray(&self, batch: usize, number: u32) -> Ray {
        let number = batch * BATCH + number as usize;
        self.numbered(number..number + 1)[0]
    }
}

impl View {
    /// How many rays there are.
    fn rays(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// The ray with this number along the order's curve through the picture: through a pixel's centre, of length 1.
    fn ray(&self, number: u64) -> Ray {
        let (x, y) = self.order.pixel(number, self.width, self.height);
        let RayFan {
            corner,
            right,
            down,
        } = self.fan;
        let (right, down) = (
            right.as_dvec3() * f64::from(x),
            down.as_dvec3() * f64::from(y),
        );
        let direction = (corner.as_dvec3() + right + down).normalize().as_vec3();
        let mut ray = Ray::new(self.origin, direction.to_array(), 0.0, FAR, 0);
        ray.payload = y * self.width + x;
        ray
    }
}

impl Secondary<'_> {
    fn ray(&self, seen: &Seen, frame: &Frame, sample: usize) -> Ray {
        let direction = frame.direction(self.samples[sample]).as_vec3();
        let origin = seen.origin.to_array();
        let mut ray = Ray::new(origin, direction.to_array(), 0.0, self.end, self.flags);
        ray.payload = seen.pixel;
        ray
    }

    fn rays(&self, numbers: Range<usize>) -> Vec<Ray> {
        let samples = self.samples.len();
        let mut rays = Vec::with_capacity(numbers.len());
        if numbers.is_empty() {
            return rays;
        }
        let mut next = numbers.start;
        let mut tracer = self.tracer.clone();
        for seen in self.seen.from((next / samples) as u64) {
            let primary = self.view.ray(seen);
            let hit = tracer.trace(&primary).hit;
            let seen = Seen::at(&primary, hit.t, &self.triangles[hit.primitive as usize]);
            let frame = seen.frame();
            let end = numbers.end.min((next / samples + 1) * samples);
            rays.extend((next..end).map(|n| self.ray(&seen, &frame, n % samples)));
            next = end;
            if next == numbers.end {
                break;
            }
        }
        rays
    }
}

impl Seen {
    /// Returns the surface that a primary ray has hit.
    fn at(ray: &Ray, t: f32, triangle: &Triangle) -> Seen {
        let direction = Vec3::from(ray.direction);
        let normal = triangle.geometric_normal();
        Seen {
            pixel: ray.payload,
            origin: Vec3::from(ray.origin) + direction * (t - SETBACK).max(0.0),
            normal: match normal.dot(direction) > 0.0 {
                true => -normal,
                false => normal,
            },
        }
    }

    fn frame(&self) -> Frame {
        Frame::about(self.normal.as_dvec3(), self.pixel)
    }
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

    /// A direction about z, about the normal.
    fn direction(&self, about_z: DVec3) -> DVec3 {
        let [tangent, other, normal] = self.axes;
        (tangent * about_z.x + other * about_z.y + normal * about_z.z).normalize()
    }
}

/// Sample `n` of the hemisphere about z, denser towards it by the cosine.
fn sample_of_hemisphere(n: u32) -> DVec3 {
    let (x, y) = (halton(n + 1, 2), halton(n + 1, 3));
    let radius = x.sqrt();
    let (cos, sin) = turn(y);
    DVec3::new(radius * cos, radius * sin, (1.0 - x).max(0.0).sqrt())
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
                        let direction = frame.direction(sample_of_hemisphere(n));
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
