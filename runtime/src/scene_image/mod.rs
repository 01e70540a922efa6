//! The scene as it lies in system memory: the structures of `kernels/scene.h`, byte by byte.
//!
//! From [`BASE`] on: the header, materials, nodes and triangles of the T&I unit, shading records,
//! textures, and the frame buffer, which is all that cores may write. Each part starts
//! at a multiple of 64 bytes, one of larger records at a multiple of their size. The structures are written by field name from the layouts of `srp_kernels`,
//! and a test holds the tables against the C header.

mod bytes;
mod detail;
mod objects;
mod parts;
mod structure;
mod tiling;

pub use objects::{Object, objects};
pub use tiling::tile_size;

use std::fmt;

use srp_archdesc::Arch;
use srp_archdesc::arch::{Approx, U};

use crate::bvh::{self, Bvh, Layout, TreeImage};
use crate::memory::{BASE, MAX_BYTES, SystemMemory};
use crate::scene::{Camera, Light, MAX_COORDINATE, Scene};
use crate::tni::Tree;
use parts::Parts;
use srp_kernels::layout::{LIGHT, MATERIAL, TRIANGLE};
use structure::Bytes;
use tiling::Tiling;

/// Distance of a ray without end: beyond everything in a scene, and finite.
pub const FAR: f32 = 1e30;

// Every hit a ray can have is nearer than FAR for a direction of length 1.
const _: () = assert!(FAR > 4.0 * MAX_COORDINATE);

/// How far secondary origins move off a surface, as a fraction of the largest coordinate of its
/// vertices: 32 units of the last place, four times what computing the point from its weights can
/// be off.
pub const OFFSET: f32 = 32.0 / (1 << 24) as f32;

/// The square of the length below which a normal between those of three vertices is not one: where
/// weights that are off by the error of the T&I unit's reciprocal, and the rounding of the sum, could turn
/// it by more than an eighth of a radian. `docs/numerics.md` derives it.
pub fn least_normal(rcp: Approx) -> f32 {
    let least = 8.0 * (2.0 * rcp.error_bound() + 7.0 * U);
    (least * least) as f32
}

/// Largest width and height of a frame, in pixels.
pub const MAX_SIDE: u32 = 16384;

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

/// Addresses of the data that shading reads, each part behind the one before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShadingParts {
    /// The materials.
    pub materials: u32,
    /// The lights that send out any.
    pub lights: u32,
    /// The data of each triangle that shading needs.
    pub triangles: u32,
    /// The descriptors of textures; everything from here on is read through the texture cache.
    pub maps: u32,
    /// The texels of each texture.
    pub texels: Vec<u32>,
}

impl ShadingParts {
    /// The record of a triangle.
    pub fn triangle(&self, primitive: u32) -> u32 {
        self.triangles + primitive * TRIANGLE.bytes
    }

    /// The record of a material.
    pub fn material(&self, material: u32) -> u32 {
        self.materials + material * MATERIAL.bytes
    }
}

/// System memory at the start of a frame.
#[derive(Clone, Debug)]
pub struct SceneImage {
    /// Its contents.
    pub memory: SystemMemory,
    /// The tree for the T&I unit.
    pub tree: Tree,
    /// Where the picture arises.
    pub frame: FrameBuffer,
    /// Number of tiles.
    pub tiles: u32,
    /// Tiles in a row.
    pub across: u32,
    /// Where the parts lie that shading reads.
    pub shading: ShadingParts,
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
                "scene and picture need {bytes} bytes of system memory, which has {MAX_BYTES} at most: \
                 make the picture smaller, or the scene's textures"
            ),
        }
    }
}

impl std::error::Error for ImageError {}

/// Where everything stands in system memory.
struct Plan {
    tree: TreeImage,
    tiling: Tiling,
    parts: Parts,
}

impl Plan {
    fn of(
        scene: &Scene,
        bvh: &Bvh,
        arch: &Arch,
        (width, height): (u32, u32),
    ) -> Result<Plan, ImageError> {
        let side = 1..=MAX_SIDE;
        if !side.contains(&width) || !side.contains(&height) {
            return Err(ImageError::Size { width, height });
        }
        let tree = bvh::lay_out(bvh, &scene.triangles, Layout::of(&arch.system.tni));
        let tiling = Tiling::of((width, height), arch.system.buffers.rays);
        let parts = Parts::of(scene, &tree, &tiling)?;
        Ok(Plan {
            tree,
            tiling,
            parts,
        })
    }
}

/// Why [`build`] would refuse a frame, without building it: to be asked before work that would be in
/// vain.
pub fn check(scene: &Scene, bvh: &Bvh, arch: &Arch, size: (u32, u32)) -> Result<(), ImageError> {
    Plan::of(scene, bvh, arch, size).map(|_| ())
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
    let Plan {
        tree,
        tiling,
        parts,
    } = Plan::of(scene, bvh, arch, (width, height))?;
    let mut image = Bytes(vec![0; (parts.end - u64::from(BASE)) as usize]);
    image.put(parts.nodes, &tree.nodes);
    image.put(parts.records, &tree.triangles);
    for (i, material) in (0..).zip(&scene.materials) {
        let address = parts.materials + i * u64::from(MATERIAL.bytes);
        image.material(address, (scene, material), &parts.maps);
    }
    for (map, &address) in &parts.maps {
        image.texture_map(address, *map, scene, &parts);
    }
    for (texture, &address) in scene.textures.iter().zip(&parts.texels) {
        let mut level = address;
        for tiles in texture.tiles() {
            image.put(level, &tiles);
            level += tiles.len() as u64;
        }
    }
    for (i, light) in (0..).zip(lights(scene)) {
        image.light(parts.lights + i * u64::from(LIGHT.bytes), light);
    }
    for (i, triangle) in (0..).zip(&scene.triangles) {
        let address = parts.triangles + i * u64::from(TRIANGLE.bytes);
        image.triangle(address, scene, triangle);
    }
    let widening = arch.precision.widening();
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
        across: tiling.across,
        shading: ShadingParts {
            materials: parts.materials as u32,
            lights: parts.lights as u32,
            triangles: parts.triangles as u32,
            maps: (parts.maps.values().next().or(parts.texels.first()))
                .map_or(framebuffer, |&address| address as u32),
            texels: parts.texels.iter().map(|&address| address as u32).collect(),
        },
    })
}

/// The lights that send out any.
fn lights(scene: &Scene) -> impl Iterator<Item = &Light> {
    scene.lights.iter().filter(|light| light.emits())
}
