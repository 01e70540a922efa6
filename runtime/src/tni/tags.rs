//! What the caches of a unit hold, followed without its time.

use srp_archdesc::system::TniSpec;

use super::{Tni, Tree};
use crate::bvh::TRIANGLE_BYTES;
use crate::memory::cache::Cache;

/// The lines in a unit's caches.
#[derive(Clone, Debug)]
pub(crate) struct Tags {
    tree: Tree,
    level1: Vec<Cache>,
    level2: Cache,
    ists: Vec<Cache>,
    pair_bytes: u32,
    lines: Lines,
    /// The traversal unit and the intersection unit of the ray in hand: each ray goes to others than the last.
    trv: usize,
    ist: usize,
}

/// Binary logarithms of the bytes of lines.
#[derive(Clone, Copy, Debug)]
struct Lines {
    level1: u32,
    level2: u32,
    ist: u32,
}

/// Lines that were not there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Misses {
    pub(crate) level1: f64,
    pub(crate) level2: f64,
    pub(crate) ist: f64,
}

impl Misses {
    /// Adds others.
    pub(crate) fn add(&mut self, more: &Misses) {
        self.level1 += more.level1;
        self.level2 += more.level2;
        self.ist += more.ist;
    }
}

impl Tags {
    /// Empty caches.
    pub(crate) fn new(spec: &TniSpec, tree: Tree) -> Tags {
        Tags {
            tree,
            level1: vec![Cache::new(&spec.trv_l1); spec.trvs as usize],
            level2: Cache::new(&spec.trv_l2),
            ists: vec![Cache::new(&spec.ist_l1); spec.ists as usize],
            pair_bytes: spec.node_bytes + spec.node_format.bytes(),
            lines: Lines {
                level1: spec.trv_l1.line.ilog2(),
                level2: spec.trv_l2.line.ilog2(),
                ist: spec.ist_l1.line.ilog2(),
            },
            trv: 0,
            ist: 0,
        }
    }

    /// A ray reads the node or the triangle at an address. Each ray begins at the first node.
    #[inline]
    pub(crate) fn read(&mut self, address: u32, misses: &mut Misses) {
        let Lines {
            level1,
            level2,
            ist,
        } = self.lines;
        if address == self.tree.nodes {
            self.trv = (self.trv + 1) % self.level1.len();
            self.ist = (self.ist + 1) % self.ists.len();
        }
        if address < self.tree.triangles {
            let cache = &mut self.level1[self.trv];
            for line in address >> level1..=(address + self.pair_bytes - 1) >> level1 {
                if !cache.warm(line) {
                    misses.level1 += 1.0;
                    let there = self.level2.warm(line << level1 >> level2);
                    misses.level2 += f64::from(u8::from(!there));
                }
            }
        } else {
            let cache = &mut self.ists[self.ist];
            for line in address >> ist..=(address + TRIANGLE_BYTES - 1) >> ist {
                let there = cache.warm(line);
                misses.ist += f64::from(u8::from(!there));
            }
        }
    }
}

impl Tni {
    /// Holds what these caches hold; what is counted and on the way stays.
    pub(crate) fn hold(&mut self, tags: &Tags) {
        for (trv, cache) in self.trvs.iter_mut().zip(&tags.level1) {
            trv.fetch.cache.hold_lines_of(cache);
        }
        self.level2.cache.hold_lines_of(&tags.level2);
        for (ist, cache) in self.ists.iter_mut().zip(&tags.ists) {
            ist.fetch.cache.hold_lines_of(cache);
        }
    }
}
