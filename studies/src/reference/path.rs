//! The shading of `docs/shading.md` by straightforward recursion.

use super::geometry::Geometry;
use super::numbers::{Place, fraction, scrambled};
use super::pictures::Pictures;
use super::surface::{Surface, rgb, surface};
use glam::DVec3;
use srp_runtime::scene::{Light, Scene};
use std::f64::consts::TAU;

/// A ray that could bring less is not followed.
const LEAST_WEIGHT: f64 = 0.002;

/// Surfaces in a row that a shadow ray goes through.
const MOST_LAYERS: usize = 33;

/// A ray whose light is computed.
#[derive(Clone, Copy)]
pub(super) struct Ray {
    pub(super) origin: DVec3,
    /// Of length 1.
    pub(super) direction: DVec3,
    /// By which what it finds is multiplied.
    pub(super) weight: DVec3,
    /// Rays that led to it.
    pub(super) depth: u32,
    /// How many of these were diffuse reflections.
    pub(super) diffuse: u32,
    /// True if the last was one.
    pub(super) is_diffuse: bool,
    /// How wide its cone begins, and how much wider it gets in a unit of length.
    pub(super) width: f64,
    pub(super) spread: f64,
}

impl Ray {
    /// The word of `kernels/rgs.h`, from which random numbers are made.
    fn word(&self, pixel: u32) -> u32 {
        pixel | self.depth << 16 | self.diffuse << 24 | u32::from(self.is_diffuse) << 31
    }
}

/// A scene to be looked at.
pub(super) struct Paths<'a> {
    scene: &'a Scene,
    geometry: Geometry,
    pictures: Pictures<'a>,
    /// How much wider the cones of secondary rays get in a unit of length.
    spread: f64,
}

fn reflect(d: DVec3, n: DVec3) -> DVec3 {
    d - 2.0 * d.dot(n) * n
}

/// A direction of the hemisphere round a normal, more often near it (by the cosine), from two numbers
/// from 0 to 1; above the plane of `geometric`.
fn hemisphere(normal: DVec3, geometric: DVec3, turn: f64, rise: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(TAU * turn);
    let across = rise.sqrt();
    // Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017.
    let sign = if normal.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    let u = DVec3::new(
        1.0 + sign * normal.x * normal.x * a,
        sign * b,
        -sign * normal.x,
    );
    let v = DVec3::new(b, sign + normal.y * normal.y * a, -normal.y);
    let way = u * (across * cos) + v * (across * sin) + normal * (1.0 - rise).max(0.0).sqrt();
    let out = way.dot(geometric);
    if out < 0.0 {
        way - geometric * (2.0 * out)
    } else {
        way
    }
}

impl<'a> Paths<'a> {
    pub(super) fn of(scene: &'a Scene, spread: f64) -> Paths<'a> {
        Paths {
            geometry: Geometry::of(&scene.triangles),
            pictures: Pictures::of(scene),
            scene,
            spread,
        }
    }

    /// Returns the light that a ray finds, times its weight.
    pub(super) fn seen(&self, ray: Ray, place: Place) -> DVec3 {
        let Ray {
            origin,
            direction,
            weight,
            ..
        } = ray;
        let Some(hit) = self.geometry.nearest(origin, direction, 1e30) else {
            return weight * rgb(self.scene.background);
        };
        let options = &self.scene.options;
        let width = ray.width + ray.spread * hit.t;
        let s = surface(self.scene, &self.pictures, (&hit, width), direction);
        let there = s.optics.there;
        let mut light = DVec3::ZERO;
        if !ray.is_diffuse || !self.scene.lights.iter().any(Light::emits) {
            light += weight * rgb(s.material.emission) * there;
        }
        let bounces = ray.depth < options.bounces;
        let reflects = bounces && ray.diffuse < options.inter_reflections;
        if options.occlusion > 0 {
            light += self.open(&s, &ray, place);
        } else if !reflects {
            light += weight * rgb(self.scene.ambient) * s.optics.diffuse * there;
        }
        for lamp in &self.scene.lights {
            let position = lamp.position.as_dvec3();
            let l = (position - s.point).normalize();
            let cosine = l.dot(s.normal);
            if cosine <= 0.0 || l.dot(s.geometric) <= 0.0 {
                continue;
            }
            let along = reflect(-l, s.normal).dot(-direction).clamp(0.0, 1.0);
            let highlight = libm::pow(along, f64::from(s.material.exponent.max(0.0)));
            let brought = s.optics.diffuse * cosine + s.optics.highlight * highlight;
            let brought = weight * there * rgb(lamp.colour) * brought;
            light += self.arriving(s.point + s.geometric * s.off, position, brought, s.width);
        }
        if bounces {
            light += self.onward(&s, ray, place);
        }
        if reflects {
            light += self.reflected(&s, ray, place);
        }
        light
    }

    /// Ambient light that reaches a surface: as much as its occlusion rays find nothing.
    fn open(&self, s: &Surface<'_>, ray: &Ray, place: Place) -> DVec3 {
        let count = self.scene.options.occlusion;
        let reach = f64::from(self.scene.options.occlusion_radius);
        let bits = scrambled(
            place
                .seed
                .wrapping_mul(0x9e37_79b9)
                .wrapping_add(ray.word(place.pixel)),
        );
        let (turn, fan) = (fraction(bits), fraction(bits.wrapping_mul(0x2545_f491)));
        let mut open = 0;
        for sample in 0..count {
            let x = fraction(sample.reverse_bits()) + turn;
            let y = f64::from(sample) / f64::from(count) + fan;
            let way = hemisphere(s.normal, s.geometric, x.fract(), y.fract());
            let from = s.point + s.geometric * s.off;
            open += u32::from(self.geometry.nearest(from, way, reach).is_none());
        }
        let share = f64::from(open) / f64::from(count);
        ray.weight * rgb(self.scene.ambient) * s.optics.diffuse * s.optics.there * share
    }

    /// Returns the light that the diffuse reflection ray finds.
    fn reflected(&self, s: &Surface<'_>, ray: Ray, place: Place) -> DVec3 {
        let weight = ray.weight * s.optics.diffuse * s.optics.there;
        if weight.max_element() <= LEAST_WEIGHT {
            return DVec3::ZERO;
        }
        let bits = scrambled(
            place
                .seed
                .wrapping_mul(0x9e37_79b9)
                .wrapping_add(ray.word(place.pixel)),
        );
        let rise = fraction(bits.wrapping_mul(0x2545_f491));
        let next = Ray {
            origin: s.point + s.geometric * s.off,
            direction: hemisphere(s.normal, s.geometric, fraction(bits), rise),
            weight,
            depth: ray.depth + 1,
            diffuse: ray.diffuse + 1,
            is_diffuse: true,
            width: s.width,
            spread: self.spread,
        };
        self.seen(next, place)
    }

    /// Mirror ray and ray through the surface.
    fn onward(&self, s: &Surface<'_>, ray: Ray, place: Place) -> DVec3 {
        let Ray {
            direction, weight, ..
        } = ray;
        let next = |origin, direction, weight| Ray {
            origin,
            direction,
            weight,
            depth: ray.depth + 1,
            is_diffuse: false,
            width: s.width,
            spread: self.spread,
            ..ray
        };
        let o = &s.optics;
        let cosine = (-direction.dot(s.normal)).clamp(0.0, 1.0);
        let mut mirror = o.mirror;
        if o.rises {
            let flat = 1.0 - cosine;
            mirror += (DVec3::ONE - mirror) * (flat * flat * flat * flat * flat);
        }
        let mut filter = o.through;
        let mut onwards = direction;
        if o.index != 1.0 {
            if s.inside && filter.max_element() > 0.0 {
                filter = DVec3::ONE;
            }
            let eta = if s.inside { o.index } else { 1.0 / o.index };
            let square = 1.0 - eta * eta * (1.0 - cosine * cosine);
            if square <= 0.0 {
                mirror = if o.glass {
                    DVec3::ONE
                } else {
                    mirror.max(filter)
                };
                filter = DVec3::ZERO;
            } else {
                let behind = square.sqrt();
                if o.glass {
                    let s_wave = (eta * cosine - behind) / (eta * cosine + behind);
                    let p_wave = (cosine - eta * behind) / (cosine + eta * behind);
                    let share = (s_wave * s_wave + p_wave * p_wave) / 2.0;
                    mirror *= share;
                    filter *= 1.0 - share;
                }
                onwards = eta * direction + (eta * cosine - behind) * s.normal;
                let up = onwards.dot(s.geometric);
                if up >= 0.0 {
                    onwards -= 2.0 * up * s.geometric;
                }
            }
        } else if o.glass {
            mirror = DVec3::ZERO;
        }
        let away = s.geometric * s.off;
        let mut light = DVec3::ZERO;
        let rest = weight * (filter * o.there + DVec3::splat(1.0 - o.there));
        if rest.max_element() > LEAST_WEIGHT {
            light += self.seen(next(s.point - away, onwards, rest), place);
        }
        let mirrored = weight * mirror * o.there;
        if mirrored.max_element() > LEAST_WEIGHT {
            let mut back = reflect(direction, s.normal);
            if back.dot(s.geometric) <= 0.0 {
                back = reflect(direction, s.geometric);
            }
            light += self.seen(next(s.point + away, back, mirrored), place);
        }
        light
    }

    /// Returns the rest of a light behind all surfaces between it and a point, from which a cone so wide
    /// narrows to the light.
    fn arriving(&self, mut from: DVec3, light: DVec3, mut brought: DVec3, mut width: f64) -> DVec3 {
        for _ in 0..MOST_LAYERS {
            let way = light - from;
            let Some(hit) = self.geometry.nearest(from, way, 1.0) else {
                return brought;
            };
            width *= 1.0 - hit.t;
            let s = surface(self.scene, &self.pictures, (&hit, width), way);
            let o = &s.optics;
            let leaves = s.inside && o.index != 1.0 && o.through.max_element() > 0.0;
            let passed = if leaves { DVec3::ONE } else { o.through };
            brought *= passed * o.there + DVec3::splat(1.0 - o.there);
            if brought.max_element() <= LEAST_WEIGHT {
                break;
            }
            from = s.point - s.geometric * s.off;
        }
        DVec3::ZERO
    }
}
