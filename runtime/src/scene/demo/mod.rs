//! The default scene, made by code: a tiled floor, a mirror, glass, a ring and boxes in one light.

mod tiles;

use glam::{Vec2, Vec3};

use super::angle::turn;
use super::{Camera, Light, Map, Material, Options, Scene, Triangle};

/// The default scene: about ten thousand triangles and a picture.
pub fn demo() -> Scene {
    let mut scene = Scene {
        name: "demo".to_owned(),
        triangles: Vec::new(),
        materials: materials(),
        textures: vec![tiles::tiles()],
        lights: vec![Light {
            position: Vec3::new(-5.5, 8.5, 5.0),
            colour: [1.2, 1.15, 1.05],
        }],
        ambient: [0.16, 0.18, 0.22],
        background: [0.62, 0.86, 1.28],
        options: Options::default(),
        camera: Camera::looking_at(Vec3::new(4.6, 3.1, 8.2), Vec3::new(0.0, 0.75, 0.0), 38.0),
    };
    floor(&mut scene);
    sphere(&mut scene, Vec3::new(0.0, 1.3, 0.0), 1.3, 32, SILVER);
    sphere(&mut scene, Vec3::new(2.3, 0.65, 1.5), 0.65, 22, GOLD);
    sphere(&mut scene, Vec3::new(-0.75, 0.6, 2.75), 0.6, 24, GLASS);
    sphere(&mut scene, Vec3::new(0.95, 0.3, 3.1), 0.3, 14, TEAL);
    ring(&mut scene, Vec3::new(-2.7, 0.95, 0.9), 0.7, 0.25, RED);
    let boxes = [
        (
            Vec3::new(-2.2, 1.1, -2.4),
            Vec3::new(0.9, 1.1, 0.9),
            24.0,
            STONE,
        ),
        (
            Vec3::new(2.4, 0.7, -2.0),
            Vec3::new(0.7, 0.7, 0.7),
            -31.0,
            BLUE,
        ),
    ];
    for (centre, half, degrees, material) in boxes {
        cuboid(&mut scene, centre, half, degrees, material);
    }
    scene
}

const TILES: u32 = 0;
const RED: u32 = 1;
const GOLD: u32 = 2;
const TEAL: u32 = 3;
const BLUE: u32 = 4;
const STONE: u32 = 5;
const SILVER: u32 = 6;
const GLASS: u32 = 7;

fn materials() -> Vec<Material> {
    let glossy = |name: &str, diffuse, specular: f32, exponent| Material {
        specular: [specular; 3],
        exponent,
        illumination: 2,
        ..Material::diffuse(name, diffuse)
    };
    vec![
        Material {
            diffuse_map: Some(Map {
                texture: 0,
                clamp: false,
            }),
            ..Material::diffuse("tiles", [0.97; 3])
        },
        glossy("red", [0.72, 0.13, 0.10], 0.6, 60.0),
        glossy("gold", [0.85, 0.58, 0.16], 0.7, 30.0),
        glossy("teal", [0.08, 0.55, 0.50], 0.5, 90.0),
        glossy("blue", [0.16, 0.27, 0.68], 0.6, 45.0),
        glossy("stone", [0.66, 0.64, 0.60], 0.1, 8.0),
        Material {
            specular: [0.86, 0.87, 0.90],
            exponent: 400.0,
            illumination: 5,
            ..Material::diffuse("silver", [0.03; 3])
        },
        Material {
            specular: [0.9; 3],
            exponent: 300.0,
            filter: [0.93, 0.97, 0.95],
            refraction_index: 1.5,
            illumination: 7,
            ..Material::diffuse("glass", [0.0; 3])
        },
    ]
}

fn quad(scene: &mut Scene, corners: [Vec3; 4], normals: [Vec3; 4], material: u32) {
    let uvs = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
        scene.triangles.push(Triangle {
            positions: [corners[a], corners[b], corners[c]],
            normals: [normals[a], normals[b], normals[c]],
            uvs: [uvs[a], uvs[b], uvs[c]],
            material,
        });
    }
}

/// Squares of two by two tiles, each with the whole picture.
fn floor(scene: &mut Scene) {
    const SQUARES: i32 = 7;
    for z in -SQUARES..SQUARES {
        for x in -SQUARES..SQUARES {
            let corner =
                |dx: i32, dz: i32| Vec3::new((2 * (x + dx)) as f32, 0.0, (2 * (z + dz)) as f32);
            let corners = [corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)];
            quad(scene, corners, [Vec3::Y; 4], TILES);
        }
    }
}

/// A grid over two angles, `steps` round and as many as given across, with smooth normals.
fn swept(
    scene: &mut Scene,
    steps: [u32; 2],
    material: u32,
    point: impl Fn(f32, f32) -> (Vec3, Vec3),
) {
    let at = |i: u32, j: u32| point(i as f32 / steps[0] as f32, j as f32 / steps[1] as f32);
    for i in 0..steps[0] {
        for j in 0..steps[1] {
            let corners = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            let before = scene.triangles.len();
            quad(scene, corners.map(|c| c.0), corners.map(|c| c.1), material);
            let kept = scene.triangles[before..]
                .iter()
                .filter(|t| t.geometric_normal() != Vec3::ZERO)
                .copied()
                .collect::<Vec<_>>();
            scene.triangles.truncate(before);
            scene.triangles.extend(kept);
        }
    }
}

fn sphere(scene: &mut Scene, centre: Vec3, radius: f32, across: u32, material: u32) {
    swept(scene, [2 * across, across], material, |u, v| {
        // The poles are single points, so that the triangles there close exactly.
        let (ring, height) = match v {
            0.0 => (0.0, 1.0),
            1.0 => (0.0, -1.0),
            _ => (turned(v / 2.0).1, turned(v / 2.0).0),
        };
        let (cos, sin) = turned(u);
        let normal = Vec3::new(ring * sin, height, ring * cos);
        (centre + radius * normal, normal.normalize())
    });
}

/// A ring that stands upright and faces the camera.
fn ring(scene: &mut Scene, centre: Vec3, radius: f32, thickness: f32, material: u32) {
    let stand = |v: Vec3| about_y(28.0, v);
    swept(scene, [36, 18], material, |u, v| {
        let (cos, sin) = turned(u);
        let outward = stand(Vec3::new(cos, sin, 0.0));
        let (across, along) = turned(-v);
        let normal = across * outward + along * stand(Vec3::Z);
        (centre + radius * outward + thickness * normal, normal)
    });
}

fn cuboid(scene: &mut Scene, centre: Vec3, half: Vec3, degrees: f32, material: u32) {
    let turned = |v: Vec3| about_y(degrees, v);
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let mut normal = Vec3::ZERO;
            normal[axis] = side;
            let mut u = Vec3::ZERO;
            u[(axis + 1) % 3] = 1.0;
            let v = normal.cross(u);
            let corner = |a: f32, b: f32| centre + turned(half * (normal + a * u + b * v));
            let corners = [
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ];
            quad(scene, corners, [turned(normal); 4], material);
        }
    }
}

/// `v` turned about the y axis.
fn about_y(degrees: f32, v: Vec3) -> Vec3 {
    let (cos, sin) = turned(degrees / 360.0);
    Vec3::new(cos * v.x + sin * v.z, v.y, cos * v.z - sin * v.x)
}

fn turned(part: f32) -> (f32, f32) {
    let (cos, sin) = turn(f64::from(part));
    (cos as f32, sin as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_face_outward_and_normals_are_unit() {
        let scene = demo();
        assert!((4000..20000).contains(&scene.triangles.len()));
        for (i, triangle) in scene.triangles.iter().enumerate() {
            let geometric = triangle.geometric_normal();
            for normal in triangle.normals {
                assert!((normal.length() - 1.0).abs() < 1e-5, "triangle {i}");
                assert!(
                    normal.dot(geometric) > 0.5,
                    "triangle {i}: {normal} {geometric}"
                );
            }
        }
    }
}
