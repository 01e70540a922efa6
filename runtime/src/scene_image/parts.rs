//! Where each part of the scene lies in system memory.

use std::collections::{BTreeMap, BTreeSet};

use srp_kernels::layout::{LIGHT, MATERIAL, SCENE, TEXTURE_MAP, TRIANGLE};

use super::tiling::Tiling;
use super::{ImageError, lights};
use crate::bvh::TreeImage;
use crate::memory::{BASE, MAX_BYTES};
use crate::scene::{Map, Material, Scene};

/// Bytes of which the address of every part is a multiple.
const LEAST: u32 = 64;

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

/// A part of so many records.
fn records(part: &mut impl FnMut(u64, u32) -> u64, count: usize, bytes: u32) -> u64 {
    part(count as u64 * u64::from(bytes), bytes)
}

impl Parts {
    pub(super) fn of(
        scene: &Scene,
        tree: &TreeImage,
        tiling: &Tiling,
    ) -> Result<Parts, ImageError> {
        let mut end = u64::from(BASE);
        // A record that fits in a line of a cache lies in one.
        let mut part = |bytes: u64, record: u32| {
            let start = end.next_multiple_of(u64::from(record.next_power_of_two().max(LEAST)));
            end = start + bytes;
            start
        };
        let maps: BTreeSet<Map> = scene.materials.iter().flat_map(Material::maps).collect();
        let parts = Parts {
            header: part(u64::from(SCENE.bytes), LEAST),
            materials: records(&mut part, scene.materials.len(), MATERIAL.bytes),
            lights: records(&mut part, lights(scene).count(), LIGHT.bytes),
            nodes: part(tree.nodes.len() as u64, LEAST),
            records: part(tree.triangles.len() as u64, LEAST),
            triangles: records(&mut part, scene.triangles.len(), TRIANGLE.bytes),
            maps: {
                let bytes = TEXTURE_MAP.bytes;
                let start = records(&mut part, maps.len(), bytes);
                maps.into_iter()
                    .zip((start..).step_by(bytes as usize))
                    .collect()
            },
            texels: scene
                .textures
                .iter()
                .map(|t| part(t.bytes(), LEAST))
                .collect(),
            framebuffer: part(
                u64::from(tiling.stride()) * u64::from(tiling.rows()) * 4,
                LEAST,
            ),
            end: part(0, LEAST),
        };
        let bytes = parts.end - u64::from(BASE);
        match bytes > MAX_BYTES as u64 {
            true => Err(ImageError::TooLarge { bytes }),
            false => Ok(parts),
        }
    }
}

#[cfg(test)]
mod tests {
    use srp_archdesc::{machines, parse};
    use srp_kernels::layout::{MATERIAL, TRIANGLE};

    use crate::bvh::{self, Options};
    use crate::scene::demo::demo;
    use crate::scene_image::build;

    #[test]
    fn records_lie_in_one_line_whatever_nodes_there_are() {
        let scene = demo();
        let options = Options {
            view: Some(scene.camera),
            ..Options::default()
        };
        let bvh = bvh::build(&scene.triangles, &options);
        for node in [
            "node-bytes=\"32\"",
            "node-format=\"f16\" node-bytes=\"20\"",
            "node-format=\"f16\" node-bytes=\"28\"",
            "node-format=\"q8\"",
            "node-bytes=\"40\"",
            "node-bytes=\"48\"",
        ] {
            let xml = machines::SGRT.xml.replace("node-bytes=\"32\"", node);
            let arch = parse("machine", &xml).expect("a machine");
            let image = build(&scene, &bvh, &scene.camera, &arch, (64, 48)).expect("it fits");
            let shading = image.shading;
            assert_eq!(shading.triangles % TRIANGLE.bytes, 0, "{node}");
            assert_eq!(shading.materials % MATERIAL.bytes, 0, "{node}");
        }
    }
}
