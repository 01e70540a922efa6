//! Where each part of the scene lies in system memory.

use std::collections::{BTreeMap, BTreeSet};

use srp_kernels::layout::{LIGHT, MATERIAL, SCENE, TEXTURE_MAP, TRIANGLE};

use super::tiling::Tiling;
use super::{ImageError, lights};
use crate::bvh::TreeImage;
use crate::memory::{BASE, MAX_BYTES};
use crate::scene::{Map, Material, Scene};

/// Addresses of the parts of system memory, and of its first byte behind the last part.
pub(super) struct Parts {
    pub(super) header: u64,
    pub(super) materials: u64,
    pub(super) lights: u64,
    pub(super) nodes: u64,
    pub(super) records: u64,
    pub(super) triangles: u64,
    /// The descriptor of each texture in use, with and without clamping.
    pub(super) maps: BTreeMap<Map, u64>,
    /// The texels of each texture.
    pub(super) texels: Vec<u64>,
    pub(super) framebuffer: u64,
    pub(super) end: u64,
}

impl Parts {
    pub(super) fn of(
        scene: &Scene,
        tree: &TreeImage,
        tiling: &Tiling,
    ) -> Result<Parts, ImageError> {
        let count = scene.triangles.len() as u64;
        let mut end = u64::from(BASE);
        let mut part = |bytes: u64| {
            let start = end;
            end = (end + bytes).next_multiple_of(64);
            start
        };
        let maps: BTreeSet<Map> = scene.materials.iter().flat_map(Material::maps).collect();
        let parts = Parts {
            header: part(u64::from(SCENE.bytes)),
            materials: part(scene.materials.len() as u64 * u64::from(MATERIAL.bytes)),
            lights: part(lights(scene).count() as u64 * u64::from(LIGHT.bytes)),
            nodes: part(tree.nodes.len() as u64),
            records: part(tree.triangles.len() as u64),
            triangles: part(count * u64::from(TRIANGLE.bytes)),
            maps: {
                let bytes = u64::from(TEXTURE_MAP.bytes);
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
