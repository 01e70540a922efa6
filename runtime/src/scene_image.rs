//! The scene as it lies in system memory: what `kernels/scene.h` declares, byte by byte.
//!
//! From [`BASE`] on: the header, materials, nodes and triangles of the T&I unit, shading records,
//! textures, and the frame buffer, which is all that cores may write. Each part starts
//! at a multiple of 64 bytes. The structures are written by field name from the tables below, and
//! a test holds the tables against the C header.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use glam::Vec3;
use srp_archdesc::Arch;
use srp_archdesc::arch::Approx;
use srp_archdesc::ops::semantics::texture::CLAMP;

use crate::bvh::{self, Bvh, Layout, TreeImage};
use crate::memory::{BASE, MAX_BYTES, SystemMemory};
use crate::scene::{
    Camera, Fresnel, Light, MAX_COORDINATE, Map, Material, Scene, Surface, Triangle,
};
use crate::tni::{Tree, arithmetic};

/// Distance of a ray without end: beyond everything in a scene, and finite.
pub const FAR: f32 = 1e30;

/// How far secondary origins move off a surface, as a fraction of the largest coordinate of its
/// vertices: 32 units of the last place, four times what computing the point from its weights can
/// be off.
pub const OFFSET: f32 = 32.0 / (1 << 24) as f32;

/// The square of the length below which a normal between those of three vertices is not one: where
/// weights that are off by the error of the T&I unit's reciprocal, and the rounding of the sum, could turn
/// it by more than an eighth of a radian. `docs/numerics.md` derives it.
pub fn least_normal(rcp: Approx) -> f32 {
    const U: f64 = 1.0 / (1 << 24) as f64;
    let least = 8.0 * (2.0 * rcp.error_bound() + 7.0 * U);
    (least * least) as f32
}

/// Largest width and height of a frame, in pixels.
pub const MAX_SIDE: u32 = 16384;

/// A field of a structure: name and byte offset.
type Fields = [(&'static str, u32)];

/// `srp_scene`.
const SCENE: &Fields = &[
    ("eye", 0),
    ("corner", 16),
    ("right", 32),
    ("down", 48),
    ("background", 64),
    ("ambient", 80),
    ("light", 96),
    ("colour", 112),
    ("width", 128),
    ("height", 132),
    ("tile_width", 136),
    ("tile_height", 140),
    ("tiles_x", 144),
    ("tiles_y", 148),
    ("stride", 152),
    ("framebuffer", 156),
    ("triangles", 160),
    ("triangle_count", 164),
    ("materials", 168),
    ("material_count", 172),
    ("least_normal", 176),
    ("light_count", 180),
    ("widening", 184),
    ("far", 188),
    ("offset", 192),
    ("lights", 196),
    ("bounces", 200),
    ("samples", 204),
    ("occlusion", 208),
    ("occlusion_radius", 212),
    ("inter_reflections", 216),
    ("scale", 220),
];
const SCENE_BYTES: u32 = 224;

/// `srp_triangle`.
const TRIANGLE: &Fields = &[
    ("v0", 0),
    ("v1", 16),
    ("v2", 32),
    ("n0", 48),
    ("n1", 64),
    ("n2", 80),
    ("st01", 96),
    ("st2", 112),
];
const TRIANGLE_BYTES: u32 = 128;

/// `srp_material`.
const MATERIAL: &Fields = &[
    ("kd", 0),
    ("ks", 16),
    ("ke", 32),
    ("illum", 48),
    ("map_kd", 52),
    ("map_ks", 56),
    ("map_d", 60),
    ("mirror", 64),
    ("through", 80),
    ("padding", 96),
];
const MATERIAL_BYTES: u32 = 128;

/// `srp_light`.
const LIGHT: &Fields = &[("position", 0), ("colour", 16)];
const LIGHT_BYTES: u32 = 32;

/// `srp_texture_map`.
const TEXTURE_MAP: &Fields = &[("texels", 0), ("width", 4), ("height", 8), ("flags", 12)];
const TEXTURE_MAP_BYTES: u32 = 16;

/// Where the picture arises.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameBuffer {
    /// Address of its first pixel; everything from here on may be written by cores.
    pub address: u32,
    /// Pixels of the picture in a row.
    pub width: u32,
    /// Rows of the picture.
    pub height: u32,
    /// Pixels of the buffer in a row: whole tiles.
    pub stride: u32,
    /// Rows of the buffer.
    pub rows: u32,
}

/// Addresses of what shading reads, each part behind the one before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShadingParts {
    /// The materials.
    pub materials: u32,
    /// What shading needs of each triangle.
    pub triangles: u32,
    /// The descriptors of textures; everything from here on is read through the texture cache.
    pub maps: u32,
    /// The texels of each texture.
    pub texels: Vec<u32>,
}

impl ShadingParts {
    /// The record of a triangle.
    pub fn triangle(&self, primitive: u32) -> u32 {
        self.triangles + primitive * TRIANGLE_BYTES
    }

    /// The record of a material.
    pub fn material(&self, material: u32) -> u32 {
        self.materials + material * MATERIAL_BYTES
    }
}

/// System memory at the start of a frame.
#[derive(Clone, Debug)]
pub struct SceneImage {
    /// What it holds.
    pub memory: SystemMemory,
    /// The tree for the T&I unit.
    pub tree: Tree,
    /// Where the picture arises.
    pub frame: FrameBuffer,
    /// Number of tiles.
    pub tiles: u32,
    /// Where the parts lie that shading reads.
    pub shading: ShadingParts,
    /// What reciprocals are widened by ([`arithmetic::widening`]).
    pub widening: f32,
}

impl SceneImage {
    /// The image, whose memory is gone from here.
    pub(crate) fn take(&mut self) -> SceneImage {
        SceneImage {
            memory: std::mem::replace(&mut self.memory, SystemMemory::new(Vec::new())),
            shading: self.shading.clone(),
            ..*self
        }
    }
}

/// Why there is no image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageError {
    /// The frame has no pixels, or more than [`MAX_SIDE`] on a side.
    Size {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Scene and frame need more than [`MAX_BYTES`].
    TooLarge {
        /// Bytes needed.
        bytes: u64,
    },
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ImageError::Size { width, height } => write!(
                f,
                "a picture of {width}x{height} pixels: each side must be 1 to {MAX_SIDE}"
            ),
            ImageError::TooLarge { bytes } => write!(
                f,
                "scene and picture need {bytes} bytes of system memory, which has {MAX_BYTES}"
            ),
        }
    }
}

impl std::error::Error for ImageError {}

/// Width and height of a tile for packets of `rays` rays: about a square, as many pixels as a packet
/// has rays or less. The width is a power of two, for the kernels divide by it.
pub fn tile_size(rays: u32) -> (u32, u32) {
    let rays = rays.max(1);
    let width = 1 << (rays.ilog2() / 2);
    (width, rays / width)
}

/// Lays out system memory for a frame of `width`×`height` pixels. `bvh` is built over the scene's
/// triangles.
pub fn build(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    arch: &Arch,
    (width, height): (u32, u32),
) -> Result<SceneImage, ImageError> {
    let side = 1..=MAX_SIDE;
    if !side.contains(&width) || !side.contains(&height) {
        return Err(ImageError::Size { width, height });
    }
    let tree = bvh::lay_out(bvh, &scene.triangles, Layout::of(&arch.system.tni));
    let tiling = Tiling::of((width, height), arch.system.buffers.rays);
    let parts = Parts::of(scene, &tree, &tiling)?;
    let mut image = Bytes(vec![0; (parts.end - u64::from(BASE)) as usize]);
    image.put(parts.nodes, &tree.nodes);
    image.put(parts.records, &tree.triangles);
    for (i, material) in (0..).zip(&scene.materials) {
        let address = parts.materials + i * u64::from(MATERIAL_BYTES);
        image.material(address, material, &parts.maps);
    }
    for (map, &address) in &parts.maps {
        image.texture_map(address, *map, scene, &parts);
    }
    for (texture, &address) in scene.textures.iter().zip(&parts.texels) {
        image.put(address, &texture.tiles());
    }
    for (i, light) in (0..).zip(lights(scene)) {
        image.light(parts.lights + i * u64::from(LIGHT_BYTES), light);
    }
    for (i, triangle) in (0..).zip(&scene.triangles) {
        image.triangle(parts.triangles + i * u64::from(TRIANGLE_BYTES), triangle);
    }
    let widening = arithmetic::widening(arch.precision.rcp);
    let least_normal = least_normal(arch.system.tni.rcp);
    image.header(scene, camera, &parts, &tiling, (widening, least_normal));
    let framebuffer = parts.framebuffer as u32;
    Ok(SceneImage {
        memory: SystemMemory::new(image.0).writable_from(framebuffer),
        tree: Tree {
            root: tree.root,
            nodes: parts.nodes as u32,
            triangles: parts.records as u32,
        },
        frame: FrameBuffer {
            address: framebuffer,
            width,
            height,
            stride: tiling.stride(),
            rows: tiling.rows(),
        },
        tiles: tiling.across * tiling.down,
        shading: ShadingParts {
            materials: parts.materials as u32,
            triangles: parts.triangles as u32,
            maps: (parts.maps.values().next().or(parts.texels.first()))
                .map_or(framebuffer, |&address| address as u32),
            texels: parts.texels.iter().map(|&address| address as u32).collect(),
        },
        widening,
    })
}

/// The lights that send out any.
fn lights(scene: &Scene) -> impl Iterator<Item = &Light> {
    scene.lights.iter().filter(|light| light.emits())
}

/// The power of two that brings the extent of a scene and its lights to 1 or a little more.
fn scale(scene: &Scene) -> f32 {
    let corners = crate::scene::bounds(&scene.triangles).unwrap_or_default();
    let start = [corners.0, corners.1];
    let lights = lights(scene).map(|l| l.position);
    let (lo, hi) = lights.fold((start[0], start[1]), |(lo, hi), p| (lo.min(p), hi.max(p)));
    let size = (hi.as_dvec3() - lo.as_dvec3()).max_element();
    let exponent = (size.to_bits() >> 52) as i32 - 1023;
    f32::from_bits(((127 - exponent.clamp(-100, 100)) as u32) << 23)
}

/// How a frame is divided into tiles.
struct Tiling {
    frame: (u32, u32),
    tile: (u32, u32),
    across: u32,
    down: u32,
}

impl Tiling {
    fn of(frame: (u32, u32), rays: u32) -> Tiling {
        let tile = tile_size(rays);
        Tiling {
            frame,
            tile,
            across: frame.0.div_ceil(tile.0),
            down: frame.1.div_ceil(tile.1),
        }
    }

    fn stride(&self) -> u32 {
        self.across * self.tile.0
    }

    fn rows(&self) -> u32 {
        self.down * self.tile.1
    }
}

/// Addresses of the parts of system memory, and of what is behind the last.
struct Parts {
    header: u64,
    materials: u64,
    lights: u64,
    nodes: u64,
    records: u64,
    triangles: u64,
    /// The descriptor of each texture in use, with and without clamping.
    maps: BTreeMap<Map, u64>,
    /// The texels of each texture.
    texels: Vec<u64>,
    framebuffer: u64,
    end: u64,
}

impl Parts {
    fn of(scene: &Scene, tree: &TreeImage, tiling: &Tiling) -> Result<Parts, ImageError> {
        let count = scene.triangles.len() as u64;
        let mut end = u64::from(BASE);
        let mut part = |bytes: u64| {
            let start = end;
            end = (end + bytes).next_multiple_of(64);
            start
        };
        let maps: BTreeSet<Map> = scene.materials.iter().flat_map(Material::maps).collect();
        let parts = Parts {
            header: part(u64::from(SCENE_BYTES)),
            materials: part(scene.materials.len() as u64 * u64::from(MATERIAL_BYTES)),
            lights: part(lights(scene).count() as u64 * u64::from(LIGHT_BYTES)),
            nodes: part(tree.nodes.len() as u64),
            records: part(tree.triangles.len() as u64),
            triangles: part(count * u64::from(TRIANGLE_BYTES)),
            maps: {
                let bytes = u64::from(TEXTURE_MAP_BYTES);
                let start = part(maps.len() as u64 * bytes);
                maps.into_iter()
                    .zip((start..).step_by(bytes as usize))
                    .collect()
            },
            texels: scene.textures.iter().map(|t| part(t.bytes())).collect(),
            framebuffer: part(u64::from(tiling.stride()) * u64::from(tiling.rows()) * 4),
            end: part(0),
        };
        let bytes = parts.end - u64::from(BASE);
        match bytes > MAX_BYTES as u64 {
            true => Err(ImageError::TooLarge { bytes }),
            false => Ok(parts),
        }
    }
}

// Every hit a ray can have is nearer than FAR for a direction of length 1.
const _: () = assert!(FAR > 4.0 * MAX_COORDINATE);

/// Memory in the making; addresses are those of the finished memory.
struct Bytes(Vec<u8>);

impl Bytes {
    fn put(&mut self, address: u64, bytes: &[u8]) {
        let start = (address - u64::from(BASE)) as usize;
        self.0[start..start + bytes.len()].copy_from_slice(bytes);
    }

    fn header(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        parts: &Parts,
        tiling: &Tiling,
        (widening, least_normal): (f32, f32),
    ) {
        let mut at = Structure {
            image: self,
            address: parts.header,
            fields: SCENE,
        };
        let fan = camera.ray_fan(tiling.frame.0, tiling.frame.1);
        at.vector("eye", camera.position, 1.0f32.to_bits());
        at.vector("corner", fan.corner, 0);
        at.vector("right", fan.right, 0);
        at.vector("down", fan.down, 0);
        at.vector("background", Vec3::from(scene.background), 0);
        at.vector("ambient", Vec3::from(scene.ambient), 0);
        let light = lights(scene).next();
        let (position, colour) = light.map_or((Vec3::ZERO, [0.0; 3]), |l| (l.position, l.colour));
        at.vector("light", position, 1.0f32.to_bits());
        at.vector("colour", Vec3::from(colour), 0);
        for (name, word) in [
            ("width", tiling.frame.0),
            ("height", tiling.frame.1),
            ("tile_width", tiling.tile.0),
            ("tile_height", tiling.tile.1),
            ("tiles_x", tiling.across),
            ("tiles_y", tiling.down),
            ("stride", tiling.stride()),
            ("framebuffer", parts.framebuffer as u32),
            ("triangles", parts.triangles as u32),
            ("triangle_count", scene.triangles.len() as u32),
            ("materials", parts.materials as u32),
            ("material_count", scene.materials.len() as u32),
            ("light_count", lights(scene).count() as u32),
            ("lights", parts.lights as u32),
            ("bounces", scene.options.bounces),
            ("samples", scene.options.samples),
            ("occlusion", scene.options.occlusion),
            ("occlusion_radius", scene.options.occlusion_radius.to_bits()),
            ("inter_reflections", scene.options.inter_reflections),
            ("scale", scale(scene).to_bits()),
            ("widening", widening.to_bits()),
            ("least_normal", least_normal.to_bits()),
            ("far", FAR.to_bits()),
            ("offset", OFFSET.to_bits()),
        ] {
            at.word(name, word);
        }
    }

    fn material(&mut self, address: u64, m: &Material, maps: &BTreeMap<Map, u64>) {
        let mut at = Structure {
            image: self,
            address,
            fields: MATERIAL,
        };
        let surface = Surface::of(m);
        let fresnel: f32 = match surface.fresnel {
            Fresnel::None => 0.0,
            Fresnel::Conductor => 1.0,
            Fresnel::Dielectric => 2.0,
        };
        let exponent = surface.exponent.to_bits();
        let descriptor = |map: Option<Map>| map.map_or(0, |map| maps[&map] as u32);
        let map_kd = descriptor(m.diffuse_map);
        at.vector("kd", Vec3::from(surface.diffuse), map_kd);
        at.vector("ks", Vec3::from(surface.specular), exponent);
        let goes_on = surface.mirrors() || surface.transmits() || m.dissolve_map.is_some();
        let goes_on = f32::from(u8::from(goes_on));
        at.vector("ke", Vec3::from(surface.emission), goes_on.to_bits());
        at.vector("mirror", Vec3::from(surface.mirror), fresnel.to_bits());
        let index = surface.index.to_bits();
        at.vector("through", Vec3::from(surface.through), index);
        at.word("illum", u32::from(m.illumination));
        at.word("map_kd", map_kd);
        at.word("map_ks", descriptor(m.specular_map));
        at.word("map_d", descriptor(m.dissolve_map));
    }

    fn texture_map(&mut self, address: u64, map: Map, scene: &Scene, parts: &Parts) {
        let texture = &scene.textures[map.texture as usize];
        let mut at = Structure {
            image: self,
            address,
            fields: TEXTURE_MAP,
        };
        at.word("texels", parts.texels[map.texture as usize] as u32);
        at.word("width", texture.width);
        at.word("height", texture.height);
        at.word("flags", if map.clamp { CLAMP } else { 0 });
    }

    fn light(&mut self, address: u64, light: &Light) {
        let mut at = Structure {
            image: self,
            address,
            fields: LIGHT,
        };
        at.vector("position", light.position, 1.0f32.to_bits());
        at.vector("colour", Vec3::from(light.colour), 0);
    }

    fn triangle(&mut self, address: u64, t: &Triangle) {
        let mut at = Structure {
            image: self,
            address,
            fields: TRIANGLE,
        };
        let normal = t.geometric_normal();
        at.vector("n0", t.normals[0], t.material);
        at.vector("n1", t.normals[1], u32::from(t.is_flat()));
        at.vector("n2", t.normals[2], 0);
        at.vector("v0", t.positions[0], normal.x.to_bits());
        at.vector("v1", t.positions[1], normal.y.to_bits());
        at.vector("v2", t.positions[2], normal.z.to_bits());
        let [st0, st1, st2] = t.uvs;
        at.vector("st01", st0.extend(st1.x), st1.y.to_bits());
        at.vector("st2", st2.extend(0.0), 0);
    }
}

/// A structure in memory, written field by field.
struct Structure<'a> {
    image: &'a mut Bytes,
    address: u64,
    fields: &'a Fields,
}

impl Structure<'_> {
    fn word(&mut self, name: &str, word: u32) {
        self.put(name, &word.to_le_bytes());
    }

    /// A `float4`, its last lane as bits.
    fn vector(&mut self, name: &str, v: Vec3, lane_3: u32) {
        let mut bytes = [0; 16];
        let words = v.to_array().map(f32::to_bits).into_iter().chain([lane_3]);
        for (bytes, word) in bytes.chunks_exact_mut(4).zip(words) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        self.put(name, &bytes);
    }

    fn put(&mut self, name: &str, bytes: &[u8]) {
        let field = self.fields.iter().find(|(n, _)| *n == name);
        let (_, offset) = field.expect("only fields of the tables are written");
        self.image.put(self.address + u64::from(*offset), bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fields and size of a structure of the C header, by the rules of C: a `float4` takes and is
    /// aligned to 16 bytes, anything else to 4.
    fn of_header(name: &str) -> (Vec<(String, u32)>, u32) {
        let header = include_str!("../../kernels/scene.h");
        let end = header
            .find(&format!("}} {name};"))
            .expect("the structure is declared");
        let start = header[..end]
            .rfind("typedef struct {")
            .expect("it is a typedef");
        let mut body = header[start + "typedef struct {".len()..end].to_owned();
        while let Some(comment) = body.find("/*") {
            let close = body[comment..].find("*/").expect("comments end") + 2;
            body.replace_range(comment..comment + close, "");
        }
        let mut fields = Vec::new();
        let mut offset = 0u32;
        for declaration in body.split(';').map(str::trim).filter(|d| !d.is_empty()) {
            let (ty, names) = declaration.split_once(' ').expect("type and names");
            let size = if ty == "float4" { 16 } else { 4 };
            for name in names.split(',').map(str::trim) {
                let (name, count) = match name.split_once('[') {
                    Some((name, count)) => {
                        (name, count.trim_end_matches(']').parse().expect("a number"))
                    }
                    None => (name, 1),
                };
                offset = offset.next_multiple_of(size);
                fields.push((name.to_owned(), offset));
                offset += size * count;
            }
        }
        (fields, offset)
    }

    #[test]
    fn the_c_header_declares_what_is_written() {
        for (name, fields, bytes) in [
            ("srp_scene", SCENE, SCENE_BYTES),
            ("srp_triangle", TRIANGLE, TRIANGLE_BYTES),
            ("srp_material", MATERIAL, MATERIAL_BYTES),
            ("srp_light", LIGHT, LIGHT_BYTES),
            ("srp_texture_map", TEXTURE_MAP, TEXTURE_MAP_BYTES),
        ] {
            let expected: Vec<_> = fields.iter().map(|(n, o)| ((*n).to_owned(), *o)).collect();
            assert_eq!(of_header(name), (expected, bytes), "{name}");
        }
        let (ray, bytes) = of_header("srp_ray");
        assert_eq!(ray.len(), 4);
        assert_eq!(bytes, crate::tni::RAY_BYTES);
        let (hit, bytes) = of_header("srp_hit");
        let names: Vec<&str> = hit.iter().map(|(n, _)| n.as_str()).collect();
        assert_eq!(names, ["t", "u", "v", "primitive", "ray", "flags"]);
        assert_eq!(bytes, crate::tni::HIT_BYTES);
    }

    #[test]
    fn packets_hold_a_tile() {
        for rays in 1..200 {
            let (width, height) = tile_size(rays);
            assert!(width.is_power_of_two() && width <= height);
            assert!((0..width).contains(&(rays - width * height)), "{rays}");
        }
        assert_eq!(tile_size(63), (4, 15));
        assert_eq!(tile_size(64), (8, 8));
        assert_eq!(tile_size(128), (8, 16));
    }
}
