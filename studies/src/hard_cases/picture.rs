//! Whole frames: meshes of a few materials before a camera, by the kernels that the scene calls for, against the
//! renderer in binary64.
//!
//! Kernels run by their meaning and the T&I unit answers at once; the system with a clock gives the same pictures to the
//! bit. A pixel is off where a channel differs by more than a level of 255 from the reference, which is rounded: at the
//! edges of things either side is drawn, and next to the middle of two levels either of them.

use super::catalogue::Case;
use super::judge::{Verdict, allowance};
use super::meshes;
use super::settings::Setting;
use crate::Error;
use crate::accuracy::{Comparison, picture_without_clock};
use crate::reference;
use glam::Vec3;
use srp_runtime::bvh;
use srp_runtime::scene::{
    Camera, Light, MAX_COORDINATE, MAX_LIGHTS, Material, Options, Scene, Triangle,
};
use srp_toolchain::{Frame, Kernels, Session};

/// The scene of a case. Its arguments are read in order: one that names a material holds for the meshes after it.
///
/// # Errors
///
/// The camera sees nothing, a place is too far away, or there are too many lights.
fn scene(case: &Case, at_hand: &Scene) -> Result<Scene, String> {
    let mut scene = Scene {
        name: case.id.clone(),
        triangles: Vec::new(),
        materials: vec![Material::diffuse("m0", [0.8; 3])],
        textures: Vec::new(),
        lights: Vec::new(),
        ambient: [0.1; 3],
        background: [0.3, 0.5, 0.8],
        camera: Camera {
            position: Vec3::ZERO,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            fov: 45.0,
        },
        options: Options::default(),
    };
    let (mut at, mut offset, mut scale) = (Vec3::ZERO, Vec3::ZERO, 1.0);
    for (name, words) in &case.arguments {
        let numbers: Vec<f32> = words.iter().map(|&w| f32::from_bits(w)).collect();
        let count = numbers.first().map_or(0, |&n| n as u32);
        let is_new = !scene.triangles.is_empty();
        let name_of_next = format!("m{}", scene.materials.len());
        let material = (scene.materials.last_mut()).expect("there is one from the start");
        match (name.as_str(), &numbers[..]) {
            ("diffuse", &[r, g, b]) if is_new => {
                scene
                    .materials
                    .push(Material::diffuse(name_of_next, [r, g, b]));
            }
            ("diffuse", &[r, g, b]) => material.diffuse = [r, g, b],
            ("shiny", &[strength, exponent]) => {
                (material.specular, material.exponent) = ([strength; 3], exponent);
                material.illumination = 2;
            }
            ("mirror", &[strength]) => {
                (material.specular, material.illumination) = ([strength; 3], 3);
            }
            ("glass", &[index, dissolve]) => {
                (material.refraction_index, material.dissolve) = (index, dissolve);
                (material.filter, material.illumination) = ([1.0; 3], 7);
            }
            ("glow", &[strength]) => material.emission = [strength; 3],
            ("eye", eye) => scene.camera.position = Vec3::from_slice(eye),
            ("at", to) => at = Vec3::from_slice(to),
            ("up", up) => scene.camera.up = Vec3::from_slice(up),
            ("fov", &[degrees]) => scene.camera.fov = degrees,
            ("light", &[x, y, z]) => scene.lights.push(Light {
                position: Vec3::new(x, y, z),
                colour: [1.0; 3],
            }),
            ("ambient", &[ambient]) => scene.ambient = [ambient; 3],
            ("background", &[r, g, b]) => scene.background = [r, g, b],
            ("samples", _) => scene.options.samples = count,
            ("bounces", _) => scene.options.bounces = count,
            ("inter", _) => scene.options.inter_reflections = count,
            ("occlusion", &[_, radius]) => {
                (scene.options.occlusion, scene.options.occlusion_radius) = (count, radius);
            }
            ("moved", offsets) => offset = Vec3::from_slice(offsets),
            ("scaled", &[exponent]) => scale = exponent.exp2(),
            (mesh, numbers) => {
                let material = scene.materials.len() as u32 - 1;
                let triangles = meshes::mesh(mesh, numbers, at_hand).into_iter();
                let triangles = triangles.map(|t| Triangle { material, ..t });
                scene.triangles.extend(triangles);
            }
        }
    }
    let place = |p: Vec3| p * scale + offset;
    for triangle in &mut scene.triangles {
        triangle.positions = triangle.positions.map(place);
    }
    for light in &mut scene.lights {
        light.position = place(light.position);
    }
    let camera: Camera = scene.camera;
    scene.camera = Camera {
        position: place(camera.position),
        forward: at - camera.position,
        ..camera
    }
    .checked()
    .map_err(|e| e.to_string())?;
    scene.options.occlusion_radius *= scale;
    let corners = scene.triangles.iter().flat_map(|t| t.positions);
    let mut places = corners.chain(scene.lights.iter().map(|light| light.position));
    let within = -MAX_COORDINATE..=MAX_COORDINATE;
    if !places.all(|p| p.to_array().iter().all(|x| within.contains(x))) {
        return Err(format!("a coordinate is beyond {MAX_COORDINATE}"));
    }
    match scene.lights.len() > MAX_LIGHTS {
        true => Err(format!("there are more than {MAX_LIGHTS} lights")),
        false => Ok(scene),
    }
}

/// The picture of a case in binary64, for packets of 64 rays.
#[cfg(test)]
pub(super) fn in_binary64(case: &Case, at_hand: &Scene) -> Vec<glam::DVec3> {
    let options = reference::Options {
        size: size(case),
        packet: 64,
        threads: 1,
        watch: &srp_archdesc::Unwatched,
    };
    let scene = scene(case, at_hand).unwrap_or_else(|why| panic!("{}: {why}", case.id));
    reference::picture(&scene, &options).expect("nobody cancels it")
}

fn size(case: &Case) -> (u32, u32) {
    case.floats::<2>("size").map(|side| side as u32).into()
}

/// The verdict on the picture of a case.
///
/// # Errors
///
/// The frame cannot be made, or the work was cancelled.
pub(super) fn judge(
    case: &Case,
    setting: &Setting,
    at_hand: &Scene,
    kernels: &Kernels,
    session: &Session<'_>,
) -> Result<Verdict, Error> {
    let wrong = |why| Error::invalid(format_args!("{}: {}: {why}", case.place, case.id));
    let scene = scene(case, at_hand).map_err(wrong)?;
    let bvh = bvh::build(&scene.triangles, &bvh::Options::default());
    let mut frame = Frame::new(setting.arch.clone(), scene, bvh, size(case));
    frame.build.kernels = kernels.clone();
    let picture = picture_without_clock(&frame, session)?;
    let options = reference::Options {
        size: frame.size,
        packet: frame.arch.system.buffers.rays,
        threads: 1,
        watch: session.watch,
    };
    let reference = reference::picture(&frame.scene, &options).ok_or_else(Error::cancelled)?;
    let comparison = Comparison::of(&picture, &reference);
    let levels = comparison.levels();
    let beyond = |levels_off: f64| {
        levels
            .iter()
            .filter(|&&l| f64::from(l) > levels_off)
            .count()
    };
    let own = case.numbers().first().map_or(0, |&n| n as usize);
    let off = beyond(1.0);
    if off <= own {
        return Ok(Verdict::Right);
    }
    let of_units = 255.0 * allowance(case, setting, 1.0);
    let coarse = match of_units > 0.0 {
        true => case.may_lose("coarse").unwrap_or(0.0) * levels.len() as f64,
        false => 0.0,
    };
    let (far, bound) = (beyond(1.0 + of_units), own + coarse as usize);
    Ok(match far <= bound {
        true => Verdict::Bounded(format!(
            "{off} pixels are off, {far} by more than {:.1} levels, at most {bound}",
            1.0 + of_units
        )),
        false => Verdict::Wrong(format!(
            "{far} pixels are off by more than {:.1} levels, not at most {bound}",
            1.0 + of_units
        )),
    })
}
