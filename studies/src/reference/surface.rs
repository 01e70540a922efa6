//! The surface that a ray meets: the point, its normals, and the effect of the material on light.

use super::geometry::Hit;
use glam::{DVec2, DVec3};
use srp_runtime::scene::{Map, Material, Scene, Texture};

/// Optical properties of a material, after the table of the document.
pub(super) struct Optics {
    pub(super) diffuse: DVec3,
    pub(super) highlight: DVec3,
    pub(super) mirror: DVec3,
    pub(super) through: DVec3,
    pub(super) index: f64,
    pub(super) rises: bool,
    pub(super) glass: bool,
    /// How much of it is there.
    pub(super) there: f64,
}

pub(super) fn rgb(c: [f32; 3]) -> DVec3 {
    DVec3::from(c.map(f64::from))
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
        libm::pow((s + 0.055) / 1.055, 2.4)
    }
}

/// The surface that a ray meets.
pub(super) struct Surface<'a> {
    pub(super) material: &'a Material,
    pub(super) optics: Optics,
    pub(super) point: DVec3,
    /// On the side of the ray.
    pub(super) geometric: DVec3,
    pub(super) normal: DVec3,
    /// True if the ray comes from behind.
    pub(super) inside: bool,
    pub(super) off: f64,
}

/// Returns the surface that a ray of this direction meets at a hit.
pub(super) fn surface<'a>(scene: &'a Scene, hit: &Hit, direction: DVec3) -> Surface<'a> {
    let t = &scene.triangles[hit.triangle];
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
    let material = &scene.materials[t.material as usize];
    let mut optics = Optics::of(material);
    let texel = |map: Option<Map>| {
        let none = (DVec3::ONE, 1.0);
        map.map_or(none, |m| {
            sample(&scene.textures[m.texture as usize], m.clamp, uv)
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
