//! Levels of detail of textures, as far as they are known before a ray is: ray cones, T. Akenine-Möller et al.,
//! *Improved Shader and Texture Level of Detail Using Ray Cones*, JCGT 10(1), 2021.

use glam::{DVec2, Vec3};

use crate::scene::{Map, Material, Scene, Triangle};

/// Largest magnitude: beyond all that the width of a cone and the cosine of an angle can add.
const MOST: f64 = 256.0;

/// How much wider the cone of a ray gets in a unit of length: a pixel's width there, less where several rays
/// share the pixel.
pub(super) fn spread(right: Vec3, samples: u32) -> f32 {
    (right.as_dvec3().length() / f64::from(samples).sqrt()) as f32
}

/// The texture by whose size the levels of a material's triangles are known.
fn first(scene: &Scene, m: &Material) -> Option<f64> {
    m.maps().next().map(|map| texels(scene, map))
}

fn texels(scene: &Scene, map: Map) -> f64 {
    let texture = &scene.textures[map.texture as usize];
    f64::from(texture.width) * f64::from(texture.height)
}

/// The level of detail at which the first picture of a triangle's material has, seen straight on, a texel for
/// each square of side 1: half of log2 of the texels that lie on the triangle over its area. Where it has no area, or
/// none in the picture, so low that nothing makes it more than 0; 0 without a picture.
pub(super) fn of_triangle(scene: &Scene, t: &Triangle) -> f32 {
    let Some(texels) = first(scene, &scene.materials[t.material as usize]) else {
        return 0.0;
    };
    let [a, b, c] = t.positions.map(|p| p.as_dvec3());
    let area = (b - a).cross(c - a).length();
    let [u, v, w]: [DVec2; 3] = t.uvs.map(|uv| uv.as_dvec2());
    let covered = texels * (v - u).perp_dot(w - u).abs();
    match area > 0.0 && covered > 0.0 {
        true => (0.5 * libm::log2(covered / area)).clamp(-MOST, MOST) as f32,
        false => -MOST as f32,
    }
}

/// By how much the level of detail of a picture of a material is more than that of its first one, which has
/// another size.
pub(super) fn more_than_first(scene: &Scene, m: &Material, map: Option<Map>) -> f32 {
    match (first(scene, m), map) {
        (Some(first), Some(map)) => (0.5 * libm::log2(texels(scene, map) / first)) as f32,
        _ => 0.0,
    }
}
