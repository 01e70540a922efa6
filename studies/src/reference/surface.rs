//! The surface that a ray meets: the point, its normals, and the effect of the material on light.

use super::geometry::Hit;
use super::pictures::{Pictures, octaves};
use glam::{DVec2, DVec3};
use srp_runtime::scene::{Map, Material, Scene};

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
        let bends = matches!(m.illumination, 6 | 7) && m.refraction_index > 0.0;
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
    /// How wide the ray's cone is there.
    pub(super) width: f64,
}

/// Returns the surface that a ray of this direction meets at a hit, where its cone is so wide.
pub(super) fn surface<'a>(
    scene: &'a Scene,
    pictures: &Pictures<'_>,
    (hit, width): (&Hit, f64),
    direction: DVec3,
) -> Surface<'a> {
    let t = &scene.triangles[hit.triangle];
    let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
    let [a, b, c] = t.positions.map(|p| p.as_dvec3());
    let point = a * weights[0] + b * weights[1] + c * weights[2];
    let area = (b - a).cross(c - a);
    let outside = area.normalize();
    let cosine = outside.dot(direction) / direction.length();
    let inside = cosine > 0.0;
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
    let [uv_a, uv_b, uv_c] = t.uvs.map(|uv| uv.as_dvec2());
    let covered = (uv_b - uv_a).perp_dot(uv_c - uv_a).abs();
    let own = libm::log2(covered / area.length()) / 2.0;
    let detail = own + octaves(width) - octaves(cosine.abs());
    let texel = |map: Option<Map>| match map {
        Some(map) => pictures.sample(map, uv, detail),
        None => (DVec3::ONE, 1.0),
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
        width,
    }
}
