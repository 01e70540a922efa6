//! Where the light comes from when a file does not say.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};

use super::{Camera, Light, Material, Triangle, bounds};

/// Power of emitting faces (area times brightness) over the surface of the scene's bounds, from
/// which on they light the scene. What is below is a lamp to be looked at.
const LEAST_POWER: f64 = 0.01;

/// Most lamps that light a scene, the strongest.
const MOST_LAMPS: usize = 8;

/// The point lights of a scene.
///
/// Where faces emit enough, those that hang together are a lamp: its light stands at the centre of
/// their power, moved off them along their mean normal by a hundredth of the scene, and has their
/// mean colour. All lamps together are scaled so that their strongest part is 1. Otherwise there is
/// one white light. A camera inside the scene's bounds is in a room: from the camera the light goes
/// 0.35 of the free way ahead, from there 0.3 of it to the right, from there 0.6 of it up, so that it
/// hangs in front of the viewer with nothing between. A camera outside looks at an object: the light
/// stands on the camera's upper right, 0.7 of the distance to the centre up and half of it to the
/// side.
pub fn default_lights(
    triangles: &[Triangle],
    materials: &[Material],
    camera: &Camera,
) -> Vec<Light> {
    let Some((lo, hi)) = bounds(triangles) else {
        return Vec::new();
    };
    let (lo, hi) = (lo.as_dvec3(), hi.as_dvec3());
    let emitted = emitted(triangles, materials, hi - lo);
    if !emitted.is_empty() {
        return emitted;
    }
    let eye = camera.position.as_dvec3();
    let up = camera.up.as_dvec3().normalize_or(DVec3::Y);
    let forward = camera.forward.as_dvec3();
    let right = forward.cross(up).normalize_or(DVec3::X);
    let inside = eye.cmpge(lo).all() && eye.cmple(hi).all();
    let position = if inside {
        let size = (hi - lo).length();
        let ways = [(up.cross(right), 0.35), (right, 0.3), (up, 0.6)];
        ways.into_iter().fold(eye, |from, (way, part)| {
            from + way * (part * free_way(triangles, from, way).min(size))
        })
    } else {
        let distance = ((lo + hi) / 2.0 - eye).length();
        eye + distance * (0.7 * up + 0.5 * right)
    };
    vec![Light {
        position: position.as_vec3(),
        colour: [1.0; 3],
    }]
}

/// Emitting faces that hang together: sums over them.
#[derive(Clone, Copy, Default)]
struct Lamp {
    /// Area times brightness.
    power: f64,
    /// Centres, by power.
    centre: DVec3,
    /// Normals, by power.
    normal: DVec3,
    /// Emission, by area.
    colour: DVec3,
}

impl Lamp {
    fn add(&mut self, triangle: &Triangle, material: &Material) {
        let [a, b, c] = triangle.positions.map(|p| p.as_dvec3());
        let area = (b - a).cross(c - a) / 2.0;
        let emission = Vec3::from(material.emission).as_dvec3().max(DVec3::ZERO);
        let power = emission.max_element() * area.length();
        self.power += power;
        self.centre += (a + b + c) / 3.0 * power;
        self.normal += area * emission.max_element();
        self.colour += emission * area.length();
    }
}

fn emitted(triangles: &[Triangle], materials: &[Material], size: DVec3) -> Vec<Light> {
    let emits = |t: &&Triangle| materials[t.material as usize].emits();
    let emitting: Vec<&Triangle> = triangles.iter().filter(emits).collect();
    let mut lamps: BTreeMap<usize, Lamp> = BTreeMap::new();
    for (group, triangle) in groups(&emitting).into_iter().zip(&emitting) {
        let lamp = lamps.entry(group).or_default();
        lamp.add(triangle, &materials[triangle.material as usize]);
    }
    let mut lamps: Vec<Lamp> = lamps.into_values().collect();
    let power: f64 = lamps.iter().map(|l| l.power).sum();
    let surface = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
    if !(power.is_finite() && power > LEAST_POWER * surface) {
        return Vec::new();
    }
    lamps.retain(|l| l.power > 0.0);
    lamps.sort_by(|a, b| b.power.total_cmp(&a.power));
    lamps.truncate(MOST_LAMPS);
    let whole: DVec3 = lamps.iter().map(|l| l.colour).sum();
    let light = |lamp: &Lamp| {
        let off = lamp.normal.normalize_or_zero() * (0.01 * size.length());
        Light {
            position: (lamp.centre / lamp.power + off).as_vec3(),
            colour: (lamp.colour / whole.max_element()).as_vec3().to_array(),
        }
    };
    lamps.iter().map(light).collect()
}

/// For each triangle the first of those that it hangs together with, by corners at one place.
fn groups(triangles: &[&Triangle]) -> Vec<usize> {
    let mut parents: Vec<usize> = (0..triangles.len()).collect();
    let mut corners: BTreeMap<[u32; 3], usize> = BTreeMap::new();
    for (i, triangle) in triangles.iter().enumerate() {
        for position in triangle.positions {
            let place = position.to_array().map(f32::to_bits);
            let other = *corners.entry(place).or_insert(i);
            let (a, b) = (root(&mut parents, i), root(&mut parents, other));
            parents[a.max(b)] = a.min(b);
        }
    }
    (0..triangles.len())
        .map(|i| root(&mut parents, i))
        .collect()
}

/// The first of a group.
fn root(parents: &mut [usize], mut of: usize) -> usize {
    while parents[of] != of {
        parents[of] = parents[parents[of]];
        of = parents[of];
    }
    of
}

/// How far one can go from a point in a direction of length 1 before meeting a triangle.
fn free_way(triangles: &[Triangle], from: DVec3, direction: DVec3) -> f64 {
    let distance = |triangle: &Triangle| {
        let [a, b, c] = triangle.positions.map(|p| p.as_dvec3() - from);
        let weights = [c.cross(b), a.cross(c), b.cross(a)].map(|n| n.dot(direction));
        let sum: f64 = weights.iter().sum();
        let inside = weights.iter().all(|&w| w * sum > 0.0);
        let point = (a * weights[0] + b * weights[1] + c * weights[2]) / sum;
        let t = point.dot(direction);
        (inside && t > 0.0).then_some(t)
    };
    triangles
        .iter()
        .filter_map(distance)
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3Swizzles as _};

    /// A square room of the size 10, and a lamp in its ceiling.
    fn room(lamp: f32) -> (Vec<Triangle>, Vec<Material>) {
        let mut triangles = Vec::new();
        let mut square = |corner: Vec3, u: Vec3, v: Vec3, material| {
            for [a, b, c] in [[Vec3::ZERO, u, v], [u + v, v, u]] {
                triangles.push(Triangle {
                    positions: [corner + a, corner + b, corner + c],
                    normals: [Vec3::ZERO; 3],
                    uvs: [Vec2::ZERO; 3],
                    material,
                });
            }
        };
        let (x, y, z) = (10.0 * Vec3::X, 10.0 * Vec3::Y, 10.0 * Vec3::Z);
        for (corner, u, v) in [
            (Vec3::ZERO, x, y),
            (Vec3::ZERO, y, z),
            (Vec3::ZERO, z, x),
            (z, x, y),
            (x, y, z),
            (y, z, x),
        ] {
            square(corner, u, v, 0);
        }
        square(Vec3::new(4.0, 9.9, 4.0), 2.0 * Vec3::X, 2.0 * Vec3::Z, 1);
        let mut emitter = Material::diffuse("lamp", [0.0; 3]);
        emitter.emission = [lamp, 0.5 * lamp, 0.0];
        (
            triangles,
            vec![Material::diffuse("wall", [1.0; 3]), emitter],
        )
    }

    #[test]
    fn strong_lamps_are_the_light_and_weak_ones_are_not() {
        let camera = Camera::looking_at(Vec3::new(2.0, 2.0, 5.0), Vec3::new(8.0, 2.0, 5.0), 60.0);
        let light = |lamp| {
            let (triangles, materials) = room(lamp);
            let lights = default_lights(&triangles, &materials, &camera);
            assert_eq!(lights.len(), 1);
            lights[0]
        };
        let strong = light(10.0);
        assert_eq!(strong.colour, [1.0, 0.5, 0.0]);
        assert!((strong.position.xz() - Vec2::new(5.0, 5.0)).length() < 0.1);
        assert!(strong.position.y < 9.9);
        // Ahead of the camera (x), to its right (z), and above it.
        let weak = light(0.01);
        assert_eq!(weak.colour, [1.0; 3]);
        let expected = Vec3::new(2.0 + 0.35 * 8.0, 2.0 + 0.6 * 7.9, 5.0 + 0.3 * 5.0);
        assert!(
            (weak.position - expected).length() < 0.2,
            "{}",
            weak.position
        );
    }

    #[test]
    fn lamps_apart_are_lights_of_their_own() {
        let (mut triangles, materials) = room(10.0);
        let lamp = triangles.len() - 2;
        for i in 0..2 {
            let mut other = triangles[lamp + i];
            other.positions = other.positions.map(|p| p - Vec3::new(3.0, 0.0, 0.0));
            // Half of the first lamp's size in one direction.
            other.positions = other.positions.map(|p| p.with_z(5.0 + (p.z - 5.0) / 2.0));
            triangles.push(other);
        }
        let camera = Camera::looking_at(Vec3::new(2.0, 2.0, 5.0), Vec3::new(8.0, 2.0, 5.0), 60.0);
        let lights = default_lights(&triangles, &materials, &camera);
        let near = |light: &Light, x: f32| (light.position.x - x).abs() < 0.1;
        assert!(
            lights.len() == 2 && near(&lights[0], 5.0) && near(&lights[1], 2.0),
            "{lights:?}"
        );
        let red = lights.iter().map(|l| l.colour[0]).collect::<Vec<_>>();
        assert!((red[0] - 2.0 / 3.0).abs() < 1e-6 && (red[1] - 1.0 / 3.0).abs() < 1e-6);
    }
}
