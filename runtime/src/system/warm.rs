//! Functional warming: the contents of the caches of a core after some reads, without simulating their time.

use srp_archdesc::SystemSpec;

use crate::memory::cache::Cache;
use crate::scene_image::SceneImage;
use crate::tni;

/// The lines in a core's caches.
#[derive(Clone, Debug)]
pub struct WarmCaches {
    pub(super) data: Cache,
    pub(super) texture: Cache,
    pub(super) tni: tni::WarmCaches,
    parts: Parts,
}

/// Where the parts of memory begin, and binary logarithms of the bytes of lines.
#[derive(Clone, Copy, Debug)]
struct Parts {
    nodes: u32,
    shading: u32,
    maps: u32,
    data_line: u32,
    texture_line: u32,
}

/// Lines that were not there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Misses {
    /// Of the data cache.
    pub data: f64,
    /// Of the texture cache.
    pub texture: f64,
    /// Of the T&I unit's caches.
    pub tni: tni::Misses,
}

impl WarmCaches {
    /// Empty caches.
    pub fn new(spec: &SystemSpec, image: &SceneImage) -> WarmCaches {
        WarmCaches {
            data: Cache::new(&spec.data_cache),
            texture: Cache::new(&spec.texture_cache),
            tni: tni::WarmCaches::new(&spec.tni, image.tree),
            parts: Parts {
                nodes: image.tree.nodes,
                shading: image.shading.triangles,
                maps: image.shading.maps,
                data_line: spec.data_cache.line.ilog2(),
                texture_line: spec.texture_cache.line.ilog2(),
            },
        }
    }

    /// The core, or its T&I unit, reads at these addresses.
    pub fn read(&mut self, addresses: &[u32]) -> Misses {
        let parts = self.parts;
        let mut misses = Misses::default();
        for &address in addresses {
            if (parts.nodes..parts.shading).contains(&address) {
                self.tni.read(address, &mut misses.tni);
            } else if address >= parts.maps {
                let there = self.texture.warm(address >> parts.texture_line);
                misses.texture += f64::from(u8::from(!there));
            } else {
                let there = self.data.warm(address >> parts.data_line);
                misses.data += f64::from(u8::from(!there));
            }
        }
        misses
    }
}
