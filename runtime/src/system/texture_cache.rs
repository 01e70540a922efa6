//! The texture cache of one core, and the descriptors that its texture unit holds.
//!
//! A sample asks for each line that its texels lie in, once; for its descriptor only where the unit
//! does not hold it. Nothing is ever stored: a store into a texture shows in the texels that are
//! read afterwards, and not in when they come.

use serde::{Deserialize, Serialize};
use srp_archdesc::system::CacheSpec;

use super::data_cache::DataCache;
use crate::core::Lanes;

/// Descriptors that the unit holds, those used last.
const HELD: usize = 4;

/// Cache and held descriptors.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct TextureCache {
    pub(super) lines: DataCache,
    line: u32,
    /// Addresses of the descriptors held, the one used last first; 0 is none's.
    held: [u32; HELD],
    /// Samples of textures.
    pub(super) samples: u64,
}

impl TextureCache {
    /// An empty cache. The values of samples are due `latency` cycles after them.
    pub(super) fn new(spec: &CacheSpec, latency: u32, immediate: bool) -> TextureCache {
        TextureCache {
            lines: DataCache::new(spec, latency, immediate),
            line: spec.line,
            held: [0; HELD],
            samples: 0,
        }
    }

    /// A sample begins, with the descriptor at this address.
    pub(super) fn descriptor(&mut self, address: u32) {
        self.samples += 1;
        let known = self.held.iter().position(|&held| held == address);
        if known.is_none() {
            self.lines.load(address);
        }
        self.held[..=known.unwrap_or(HELD - 1)].rotate_right(1);
        self.held[0] = address;
    }

    /// Four texels are read.
    pub(super) fn texels(&mut self, addresses: Lanes) {
        let number = |address: u32| address / self.line;
        for (i, &address) in addresses.iter().enumerate() {
            let earlier = &addresses[..i];
            if !earlier.iter().any(|&a| number(a) == number(address)) {
                self.lines.load(address);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four lines of 64 bytes in one set, and two misses at a time.
    fn cache() -> TextureCache {
        TextureCache::new(
            &CacheSpec {
                bytes: 256,
                ways: 4,
                line: 64,
                latency: 1,
                banks: 1,
                misses: 2,
                blocking: true,
            },
            12,
            false,
        )
    }

    /// Answers all requests; how many there were.
    fn answer(cache: &mut TextureCache) -> u32 {
        let mut requests = 0;
        while let Some((address, _, is_write)) = cache.lines.take_request() {
            assert!(!is_write);
            cache.lines.fill(address);
            requests += 1;
        }
        requests
    }

    #[test]
    fn a_sample_asks_for_each_of_its_lines_once() {
        let mut cache = cache();
        cache.texels([0x100, 0x104, 0x110, 0x114]);
        assert_eq!(answer(&mut cache), 1);
        // Three lines, one of which is there; the others stall together.
        cache.texels([0x13c, 0x140, 0x17c, 0x180]);
        assert!(cache.lines.waits());
        assert_eq!(answer(&mut cache), 2);
        let counters = cache.lines.cache.counters;
        assert_eq!((counters.hits, counters.misses), (1, 3));
        // More lines than misses are allowed: the rest follows.
        cache.texels([0x200, 0x240, 0x280, 0x2c0]);
        assert_eq!(answer(&mut cache), 4);
        assert!(!cache.lines.waits());
    }

    #[test]
    fn descriptors_that_are_held_ask_for_nothing() {
        let mut cache = cache();
        for address in [0x100, 0x110, 0x120, 0x130, 0x100, 0x130] {
            cache.descriptor(address);
            answer(&mut cache);
        }
        let accesses =
            |c: &TextureCache| c.lines.cache.counters.hits + c.lines.cache.counters.misses;
        assert_eq!((accesses(&cache), cache.samples), (4, 6));
        // The one used longest ago gives way: 0x110.
        cache.descriptor(0x140);
        cache.descriptor(0x120);
        assert_eq!(accesses(&cache), 5);
        cache.descriptor(0x110);
        assert_eq!(accesses(&cache), 6);
    }
}
