//! The shading of `docs/shading.md` by straightforward recursion in binary64.

use super::geometry::{Geometry, Hit};
use glam::{DVec2, DVec3};
use srp_runtime::scene::{Map, Material, Scene, Texture};

/// A ray that could bring less is not followed.
const LEAST_WEIGHT: f64 = 0.002;

/// Surfaces in a row that a shadow ray goes through.
const MOST_LAYERS: usize = 33;

/// A scene to be looked at.
pub(crate) struct Renderer<'a> {
    scene: &'a Scene,
    geometry: Geometry,
}

/// What a material does, after the table of the document.
struct Optics {
    diffuse: DVec3,
    highlight: DVec3,
    mirror: DVec3,
    through: DVec3,
    index: f64,
    rises: bool,
    glass: bool,
    /// How much of it is there.
    there: f64,
}

fn rgb(c: [f32; 3]) -> DVec3 {
    DVec3::from(c.map(f64::from))
}

fn reflect(d: DVec3, n: DVec3) -> DVec3 {
    d - 2.0 * d.dot(n) * n
}

impl Optics {
    fn of(m: &Material) -> Optics {
        let (d, ks) = (f64::from(m.dissolve), rgb(m.specular));
        let none = DVec3::ZERO;
        let veil = DVec3::splat(1.0 - d);
        let paint = if m.dissolve < 1.0 { 1.0 - d } else { 1.0 };
        let glass = rgb(m.filter) * paint;
        let (highlight, mirror, through) = match m.illumination {
            0 | 1 => (none, none, veil),
            3 | 5 => (ks * d, ks, veil),
            4 | 6 => (ks, ks, glass),
            7 => (ks, DVec3::ONE, glass),
            9 => (ks, none, glass),
            _ => (ks * d, none, veil),
        };
        let bends = matches!(m.illumination, 6 | 7);
        Optics {
            diffuse: rgb(m.diffuse) * d,
            highlight,
            mirror,
            through,
            index: if bends {
                f64::from(m.refraction_index)
            } else {
                1.0
            },
            rises: m.illumination == 5,
            glass: m.illumination == 7,
            there: 1.0,
        }
    }
}

/// The texel at a coordinate, bilinear: linear rgb, and alpha.
fn sample(texture: &Texture, clamp: bool, uv: DVec2) -> (DVec3, f64) {
    let size = [texture.width, texture.height];
    let mut near = [[0; 2]; 2];
    let mut share = [0.0; 2];
    for axis in 0..2 {
        let n = f64::from(size[axis]);
        let c = if clamp {
            uv[axis].clamp(-1.0, 2.0)
        } else {
            uv[axis]
        };
        let position = c * n - 0.5;
        share[axis] = position - position.floor();
        for (k, texel) in near[axis].iter_mut().enumerate() {
            let i = position.floor() + k as f64;
            *texel = if clamp {
                i.clamp(0.0, n - 1.0)
            } else {
                i.rem_euclid(n)
            } as u32;
        }
    }
    let (mut colour, mut alpha) = (DVec3::ZERO, 0.0);
    for (j, &y) in near[1].iter().enumerate() {
        for (i, &x) in near[0].iter().enumerate() {
            let [r, g, b, a] = texture
                .texel(x, y)
                .to_le_bytes()
                .map(|c| f64::from(c) / 255.0);
            let part = |k: usize, f: f64| if k == 1 { f } else { 1.0 - f };
            let weight = part(i, share[0]) * part(j, share[1]);
            colour += weight * DVec3::new(linear(r), linear(g), linear(b));
            alpha += weight * a;
        }
    }
    (colour, alpha)
}

fn linear(s: f64) -> f64 {
    if s <= 0.04045 {
        s / 12.92
    } else {
        ((s + 0.055) / 1.055).powf(2.4)
    }
}

/// What a ray meets.
struct Surface<'a> {
    material: &'a Material,
    optics: Optics,
    point: DVec3,
    /// On the side of the ray.
    geometric: DVec3,
    normal: DVec3,
    /// Whether the ray comes from behind.
    inside: bool,
    off: f64,
}

impl<'a> Renderer<'a> {
    pub(crate) fn of(scene: &'a Scene) -> Renderer<'a> {
        Renderer {
            geometry: Geometry::of(&scene.triangles),
            scene,
        }
    }

    /// The picture as sRGB from 0 to 255, not yet rounded, row by row.
    pub(crate) fn picture(&self, (width, height): (u32, u32)) -> Vec<DVec3> {
        let camera = &self.scene.camera;
        let forward = camera.forward.as_dvec3().normalize();
        let right = forward.cross(camera.up.as_dvec3()).normalize();
        let down = forward.cross(right);
        let step =
            2.0 * (f64::from(camera.fov).to_radians() / 2.0).tan() / f64::from(width.min(height));
        let mut picture = Vec::new();
        for y in 0..height {
            for x in 0..width {
                let x = (f64::from(x) + 0.5 - f64::from(width) / 2.0) * step;
                let y = (f64::from(y) + 0.5 - f64::from(height) / 2.0) * step;
                let direction = (forward + right * x + down * y).normalize();
                let light = self.seen(camera.position.as_dvec3(), direction, DVec3::ONE, 0);
                picture.push(light.to_array().map(shown).into());
            }
        }
        picture
    }

    /// What a ray finds, times its weight.
    fn seen(&self, origin: DVec3, direction: DVec3, weight: DVec3, depth: u32) -> DVec3 {
        let Some(hit) = self.geometry.nearest(origin, direction, 1e30) else {
            return weight * rgb(self.scene.background);
        };
        let s = self.surface(&hit, direction);
        let there = s.optics.there;
        let own =
            rgb(s.material.emission) * there + rgb(self.scene.ambient) * s.optics.diffuse * there;
        let mut light = weight * own;
        for lamp in &self.scene.lights {
            let position = lamp.position.as_dvec3();
            let l = (position - s.point).normalize();
            let cosine = l.dot(s.normal);
            if cosine <= 0.0 || l.dot(s.geometric) <= 0.0 {
                continue;
            }
            let along = reflect(-l, s.normal).dot(-direction).clamp(0.0, 1.0);
            let highlight = along.powf(f64::from(s.material.exponent.max(0.0)));
            let brought = s.optics.diffuse * cosine + s.optics.highlight * highlight;
            let brought = weight * there * rgb(lamp.colour) * brought;
            light += self.arriving(s.point + s.geometric * s.off, position, brought);
        }
        if depth < self.scene.options.bounces {
            light += self.onward(&s, direction, weight, depth);
        }
        light
    }

    /// Mirror ray and ray through the surface.
    fn onward(&self, s: &Surface<'_>, direction: DVec3, weight: DVec3, depth: u32) -> DVec3 {
        let o = &s.optics;
        let cosine = (-direction.dot(s.normal)).clamp(0.0, 1.0);
        let mut mirror = o.mirror;
        if o.rises {
            mirror += (DVec3::ONE - mirror) * (1.0 - cosine).powi(5);
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
            light += self.seen(s.point - away, onwards, rest, depth + 1);
        }
        let mirrored = weight * mirror * o.there;
        if mirrored.max_element() > LEAST_WEIGHT {
            let mut back = reflect(direction, s.normal);
            if back.dot(s.geometric) <= 0.0 {
                back = reflect(direction, s.geometric);
            }
            light += self.seen(s.point + away, back, mirrored, depth + 1);
        }
        light
    }

    /// What is left of a light behind all that is between it and a point.
    fn arriving(&self, mut from: DVec3, light: DVec3, mut brought: DVec3) -> DVec3 {
        for _ in 0..MOST_LAYERS {
            let way = light - from;
            let Some(hit) = self.geometry.nearest(from, way, 1.0) else {
                return brought;
            };
            let s = self.surface(&hit, way);
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

    fn surface(&self, hit: &Hit, direction: DVec3) -> Surface<'a> {
        let t = &self.scene.triangles[hit.triangle];
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let [a, b, c] = t.positions.map(|p| p.as_dvec3());
        let point = a * weights[0] + b * weights[1] + c * weights[2];
        let outside = (b - a).cross(c - a).normalize();
        let inside = outside.dot(direction) > 0.0;
        let geometric = if inside { -outside } else { outside };
        let mut normal = DVec3::ZERO;
        let mut uv = DVec2::ZERO;
        for (i, weight) in weights.into_iter().enumerate() {
            normal += weight * t.normals[i].as_dvec3();
            uv += weight * t.uvs[i].as_dvec2();
        }
        if normal.dot(geometric) < 0.0 {
            normal = -normal;
        }
        let material = &self.scene.materials[t.material as usize];
        let mut optics = Optics::of(material);
        let texel = |map: Option<Map>| {
            let none = (DVec3::ONE, 1.0);
            map.map_or(none, |m| {
                sample(&self.scene.textures[m.texture as usize], m.clamp, uv)
            })
        };
        optics.diffuse *= texel(material.diffuse_map).0;
        optics.highlight *= texel(material.specular_map).0;
        optics.there = texel(material.dissolve_map).1;
        let largest = [a, b, c].map(|p| p.abs().max_element());
        Surface {
            material,
            optics,
            point,
            geometric,
            normal: if normal.length() < 1e-6 {
                geometric
            } else {
                normal.normalize()
            },
            inside,
            off: largest.into_iter().fold(0.0, f64::max) / f64::from(1 << 19),
        }
    }
}

/// An intensity as an sRGB value from 0 to 255.
fn shown(x: f64) -> f64 {
    let x = x.clamp(0.0, 2.0);
    let x = (x * (1.0 - x / 4.0)).min(1.0);
    255.0
        * match x {
            ..=0.0031308 => 12.92 * x,
            _ => 1.055 * x.powf(1.0 / 2.4) - 0.055,
        }
}
