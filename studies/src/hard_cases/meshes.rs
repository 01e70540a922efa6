//! The meshes that the catalogue names.

use super::catalogue::Case;
use glam::Vec3;
use srp_runtime::scene::{Scene, Triangle};

/// A triangle with these corners.
pub(crate) fn triangle(positions: [Vec3; 3]) -> Triangle {
    let bare = Triangle {
        positions,
        normals: [Vec3::ZERO; 3],
        uvs: Default::default(),
        material: 0,
    };
    Triangle {
        normals: [bare.geometric_normal(); 3],
        ..bare
    }
}

/// The triangles that an argument of a case names: `tri` and nine coordinates, any number of times; `sphere columns rows
/// radius x y z`; `grid n`, flat and square, from 0 to n; `identical n`; `nested n`, in planes at
/// 2^-i; `ladder n`, equal ones in the planes 1 to n; `scene`, the scene at hand. None for all else.
pub(super) fn mesh(name: &str, numbers: &[f32], scene: &Scene) -> Vec<Triangle> {
    let count = numbers.first().map_or(0, |&n| n as usize);
    let flat = |z: f32, size: f32| {
        let corner = |x: f32, y: f32| Vec3::new(x * size, y * size, z);
        triangle([corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0)])
    };
    match (name, numbers) {
        ("tri", corners) => {
            let triangles = corners.chunks_exact(9).map(|corners| {
                let corner = |i: usize| Vec3::from_slice(&corners[3 * i..]);
                triangle([0, 1, 2].map(corner))
            });
            triangles.collect()
        }
        ("sphere", &[columns, rows, radius, x, y, z]) => {
            let counts = (columns as usize, rows as usize);
            sphere(counts, radius, Vec3::new(x, y, z))
        }
        ("grid", _) => grid(count),
        ("identical", _) => vec![flat(1.0, 1.0); count],
        ("nested", _) => {
            let plane = |i: usize| flat((-(i as f32)).exp2(), 1.0);
            (0..count).map(plane).collect()
        }
        ("ladder", _) => (1..=count).map(|i| flat(i as f32, 1.0)).collect(),
        ("scene", _) => scene.triangles.clone(),
        _ => Vec::new(),
    }
}

/// The triangles of a case. `normals` are shading normals of the first.
pub(super) fn of(case: &Case, scene: &Scene) -> Vec<Triangle> {
    let mut triangles: Vec<Triangle> = Vec::new();
    for (name, words) in &case.arguments {
        let numbers: Vec<f32> = words.iter().map(|&w| f32::from_bits(w)).collect();
        match (name.as_str(), &numbers[..]) {
            ("normals", normals) if normals.len() == 9 => {
                if let Some(first) = triangles.first_mut() {
                    first.normals = [0, 1, 2].map(|i| Vec3::from_slice(&normals[3 * i..]));
                }
            }
            (name, numbers) => triangles.extend(mesh(name, numbers, scene)),
        }
    }
    triangles
}

/// A sphere of `columns` by `rows` quadrilaterals, seen from outside counter-clockwise.
pub(crate) fn sphere((columns, rows): (usize, usize), radius: f32, centre: Vec3) -> Vec<Triangle> {
    let point = |i: usize, j: usize| {
        let up = std::f64::consts::PI * j as f64 / rows as f64;
        let round = std::f64::consts::TAU * (i % columns) as f64 / columns as f64;
        let flat = if j == 0 || j == rows {
            0.0
        } else {
            libm::sin(up)
        };
        let on_unit = glam::DVec3::new(
            flat * libm::cos(round),
            libm::cos(up),
            flat * libm::sin(round),
        );
        centre + radius * on_unit.as_vec3()
    };
    let mut triangles = Vec::new();
    for i in 0..columns {
        for j in 0..rows {
            let [a, b] = [point(i, j), point(i, j + 1)];
            let [c, d] = [point(i + 1, j + 1), point(i + 1, j)];
            if j + 1 < rows {
                triangles.push(triangle([a, c, b]));
            }
            if j > 0 {
                triangles.push(triangle([a, d, c]));
            }
        }
    }
    triangles
}

/// n by n squares of two triangles, at z = 0.
fn grid(n: usize) -> Vec<Triangle> {
    let point = |i: usize, j: usize| Vec3::new(i as f32, j as f32, 0.0);
    let square = |k: usize| {
        let (i, j) = (k % n, k / n);
        let [a, b] = [point(i, j), point(i + 1, j)];
        let [c, d] = [point(i + 1, j + 1), point(i, j + 1)];
        [triangle([a, b, c]), triangle([a, c, d])]
    };
    (0..n * n).flat_map(square).collect()
}
