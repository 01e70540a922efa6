//! Where the light comes from when a file does not say.

use glam::{DVec3, Vec3};

use super::{Camera, Light, Material, Triangle, bounds};

/// The one point light of a scene.
///
/// Where faces emit, it stands at the centre of their power (area times brightness), moved off
/// them along their mean normal by a hundredth of the scene, and has their mean colour, scaled so
/// that its strongest part is 1. Otherwise it is white: a camera inside the scene's bounds is in a
/// room, and the light hangs in the middle of it, a quarter of its height above the centre; a
/// camera outside looks at an object, and the light stands on the camera's upper right, 0.7 of the
/// distance to the centre up and half of it to the side.
pub fn default_light(
    triangles: &[Triangle],
    materials: &[Material],
    camera: &Camera,
) -> Option<Light> {
    let (lo, hi) = bounds(triangles)?;
    let (lo, hi) = (lo.as_dvec3(), hi.as_dvec3());
    if let Some(light) = emitted(triangles, materials, (hi - lo).length()) {
        return Some(light);
    }
    let eye = camera.position.as_dvec3();
    let centre = (lo + hi) / 2.0;
    let up = camera.up.as_dvec3().normalize_or(DVec3::Y);
    let inside = eye.cmpge(lo).all() && eye.cmple(hi).all();
    let position = if inside {
        centre + up * (0.25 * (hi - lo).dot(up.abs()))
    } else {
        let distance = (centre - eye).length();
        let right = camera.forward.as_dvec3().cross(up).normalize_or(DVec3::X);
        eye + distance * (0.7 * up + 0.5 * right)
    };
    Some(Light {
        position: position.as_vec3(),
        colour: [1.0; 3],
    })
}

fn emitted(triangles: &[Triangle], materials: &[Material], size: f64) -> Option<Light> {
    let (mut power, mut centre, mut normal) = (0.0, DVec3::ZERO, DVec3::ZERO);
    let mut colour = DVec3::ZERO;
    for triangle in triangles {
        let material = &materials[triangle.material as usize];
        if !material.emits() {
            continue;
        }
        let [a, b, c] = triangle.positions.map(|p| p.as_dvec3());
        let cross = (b - a).cross(c - a);
        let emission = Vec3::from(material.emission).as_dvec3().max(DVec3::ZERO);
        let brightness = emission.element_sum();
        power += cross.length() * brightness;
        centre += (a + b + c) / 3.0 * (cross.length() * brightness);
        normal += cross * brightness;
        colour += emission * cross.length();
    }
    if !(power > 0.0 && power.is_finite()) {
        return None;
    }
    let off = normal.normalize_or_zero() * (0.01 * size);
    Some(Light {
        position: (centre / power + off).as_vec3(),
        colour: (colour / colour.max_element()).as_vec3().to_array(),
    })
}
