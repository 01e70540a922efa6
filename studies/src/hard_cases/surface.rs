//! Rays that start on surfaces, as the kernels make them: from a hit to the shadow ray, the mirrored
//! ray and the one through the surface, and back to the T&I unit.

use super::call::Calls;
use super::catalogue::Case;
use super::functions::Function;
use super::judge::{self, Verdict};
use super::unit::{Mesh, Unit};
use crate::exact;
use crate::rays::kernel_ray;
use glam::Vec3;
use srp_archdesc::arch::Arch;
use srp_runtime::memory::BASE;
use srp_runtime::scene::{Camera, Light, Material, Options, Scene, Triangle};
use srp_runtime::scene_image;
use srp_runtime::tni::arithmetic::{NO_HIT, Ray};
use std::cmp::Ordering;

/// Where the kernels find a scene, and its figures in the header.
#[derive(Clone, Copy)]
pub(super) struct Scenery {
    triangles: u32,
    materials: u32,
    widening: u32,
    offset: u32,
    scale: u32,
    least_normal: u32,
}

/// Offsets in `srp_scene`.
const TRIANGLES: u32 = 160;
const MATERIALS: u32 = 168;
const LEAST_NORMAL: u32 = 176;
const WIDENING: u32 = 184;
const OFFSET: u32 = 192;
const SCALE: u32 = 220;

impl Scenery {
    /// Places triangles of a glass with this index of refraction, that mirrors too, in one light.
    pub(super) fn place(
        calls: &mut Calls,
        mesh: &Mesh,
        index: f32,
        light: Vec3,
        arch: &Arch,
    ) -> Result<Scenery, String> {
        let scene = Scene {
            name: String::new(),
            triangles: (mesh.triangles.iter())
                .map(|t| Triangle { material: 0, ..*t })
                .collect(),
            materials: vec![Material {
                illumination: 6,
                specular: [0.5; 3],
                refraction_index: index,
                ..Material::diffuse("glass", [0.5; 3])
            }],
            textures: Vec::new(),
            lights: vec![Light {
                position: light,
                colour: [1.0; 3],
            }],
            ambient: [0.0; 3],
            background: [0.0; 3],
            camera: Camera::looking_at(Vec3::ZERO, Vec3::X, 60.0),
            options: Options::default(),
        };
        let image = scene_image::build(&scene, mesh.tree(), &scene.camera, arch, (1, 1));
        let memory = image.map_err(|e| e.to_string())?.memory;
        let words = |address: u32, bytes: u32| {
            let bytes = memory.get(address, bytes).unwrap_or_default();
            let word = |b: &[u8]| u32::from_le_bytes(b.try_into().unwrap_or_default());
            bytes.chunks_exact(4).map(word).collect::<Vec<u32>>()
        };
        let header = |offset: u32| words(BASE + offset, 4)[0];
        let part = |offset: u32| words(header(offset), 128 * header(offset + 4));
        Ok(Scenery {
            triangles: calls.place(&part(TRIANGLES)),
            materials: calls.place(&part(MATERIALS)),
            widening: header(WIDENING),
            offset: header(OFFSET),
            scale: header(SCALE),
            least_normal: header(LEAST_NORMAL),
        })
    }

    /// The arguments of a call for a hit by a ray that goes in `direction`, of length 1.
    pub(super) fn arguments(
        &self,
        (u, v, primitive): (f32, f32, u32),
        direction: [f32; 3],
        light: Vec3,
    ) -> [[u32; 4]; 5] {
        let [x, y, z] = direction.map(f32::to_bits);
        let [lx, ly, lz] = light.to_array().map(f32::to_bits);
        [
            [u.to_bits(), v.to_bits(), primitive, 0],
            [x, y, z, 0],
            [lx, ly, lz, self.widening],
            [self.offset, self.scale, self.least_normal, 0],
            [self.triangles, self.materials, 0, 0],
        ]
    }
}

/// The rays that the kernels made of a hit.
#[derive(Clone, Copy)]
pub(super) struct Made {
    pub(super) shadow: Ray,
    /// Origin and direction, if the ray is sent.
    pub(super) mirrored: Option<([f32; 3], [f32; 3])>,
    pub(super) through: Option<([f32; 3], [f32; 3])>,
}

impl Made {
    /// From the words that the driver gives.
    pub(super) fn of(words: &[u32]) -> Made {
        let vector = |at: usize| [0, 1, 2].map(|i| f32::from_bits(words[4 * at + i]));
        let sent = |at: usize| {
            let weight = vector(at + 2);
            (weight != [0.0; 3]).then(|| (vector(at), vector(at + 1)))
        };
        Made {
            shadow: Ray::from_words(std::array::from_fn(|i| words[8 + i])),
            mirrored: sent(6),
            through: sent(9),
        }
    }
}

/// True if a ray's reciprocals for far planes are beyond those for near ones by what the box test adds to errors, along each
/// axis: a difference and a product, each rounded, on either side.
fn covers_errors(ray: &Ray) -> bool {
    let rounded = 1.0 + 4.0 * f64::from(f32::EPSILON / 2.0);
    (0..3).all(|axis| {
        // Products of two numbers of 24 bits are exact here.
        let times = |reciprocal: f32| f64::from(reciprocal) * f64::from(ray.direction[axis]);
        let (near, far) = (ray.reciprocal[axis], ray.far[axis]);
        !near.is_normal() || !far.is_finite() || times(far) >= rounded * times(near).max(1.0)
    })
}

/// Adds the call of a case. Arguments: `tri`, the triangles, of which the ray hits the first; `weights`, the
/// place of the hit; `view`, the viewing direction; `light` and `index`.
pub(super) fn add(
    calls: &mut Calls,
    case: &Case,
    function: &'static Function,
    mesh: &Mesh,
    arch: &Arch,
) -> Result<usize, String> {
    let light = Vec3::from(case.floats("light"));
    let [index] = case.floats("index");
    let scenery = Scenery::place(calls, mesh, index, light, arch)?;
    let [u, v] = case.floats("weights");
    let direction = Vec3::from(case.floats("view")).normalize().to_array();
    let arguments = scenery.arguments((u, v, 0), direction, light);
    Ok(calls.add(function, &arguments))
}

/// Checks that the origins lie on their sides of the plane in exact arithmetic, and that the rays find what
/// they must: `shadow lit`, `dark` or `empty`; `mirror` and `through` the number of a triangle, `miss`, or
/// `none` where no ray is sent.
pub(super) fn judge(case: &Case, arch: &Arch, mesh: &Mesh, made: &Made) -> Verdict {
    let unit = Unit::of(arch, mesh);
    let triangles = &mesh.triangles;
    let mut tracer = unit.tracer();
    let mut wrong = Vec::new();
    let towards = exact::leans(case.floats("view"), &triangles[0]);
    let mut apart = |what: &str, origin: [f32; 3], side: Ordering| {
        if exact::side(origin, &triangles[0]) != side {
            wrong.push(format!(
                "the {what} ray starts at {origin:?}, on the wrong side"
            ));
        }
    };
    if made.shadow.tmax >= 0.0 {
        apart("shadow", made.shadow.origin, towards.reverse());
    }
    if let Some((origin, _)) = made.mirrored {
        apart("mirrored", origin, towards.reverse());
    }
    if let Some((origin, _)) = made.through {
        apart("other", origin, towards);
    }
    let mut leaning = |what: &str, direction: [f32; 3], side: Ordering| {
        if exact::leans(direction, &triangles[0]) == side.reverse() {
            wrong.push(format!(
                "the {what} ray goes along {direction:?}, to the wrong side"
            ));
        }
    };
    if let Some((_, direction)) = made.mirrored {
        leaning("mirrored", direction, towards.reverse());
    }
    if let Some((_, direction)) = made.through {
        leaning("other", direction, towards);
    }
    for (origin, direction) in [made.mirrored, made.through].into_iter().flatten() {
        if !origin.iter().chain(&direction).all(|x| x.is_finite()) {
            wrong.push(format!("a ray from {origin:?} along {direction:?}"));
        }
    }
    if made.shadow.tmax >= 0.0 && !covers_errors(&made.shadow) {
        wrong
            .push("the far planes of the shadow ray have reciprocals that are no wider".to_owned());
    }
    // Where a ray starts and what it is made of is right in every setting.
    let placed = wrong.is_empty();
    let mut find = |sent: Option<([f32; 3], [f32; 3])>| {
        let Some((origin, direction)) = sent else {
            return "none".to_owned();
        };
        let hit = tracer
            .trace(&kernel_ray(
                &arch.precision,
                origin,
                direction,
                scene_image::FAR,
            ))
            .hit;
        match hit.primitive {
            NO_HIT => "miss".to_owned(),
            primitive => primitive.to_string(),
        }
    };
    let (mirrored, through) = (find(made.mirrored), find(made.through));
    let shadow = match made.shadow.tmax < 0.0 {
        true => "empty",
        false if tracer.trace(&made.shadow).hit.is_hit() => "dark",
        false => "lit",
    };
    let found = [
        ("shadow", shadow),
        ("mirror", mirrored.as_str()),
        ("through", through.as_str()),
    ];
    for pair in case.gives.chunks_exact(2) {
        let found = found.iter().find(|(what, _)| *what == pair[0]);
        match found {
            Some((_, found)) if *found == pair[1] => {}
            found => wrong.push(format!("{} {found:?}, not {}", pair[0], pair[1])),
        }
    }
    let coarse = !judge::is_exact(&arch.precision) && case.may_lose("coarse").is_some();
    match wrong.is_empty() {
        true => Verdict::Right,
        false if placed && coarse => {
            Verdict::Bounded("decided otherwise by a coarse root; all rays are sound".to_owned())
        }
        false => Verdict::Wrong(wrong.join("; ")),
    }
}
