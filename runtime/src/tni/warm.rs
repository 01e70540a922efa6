//! Functional warming: the contents of the caches of a unit after some rays, without simulating their time.

use srp_archdesc::system::TniSpec;

use super::Tree;
use crate::bvh::TRIANGLE_BYTES;
use crate::memory::cache::Cache;

/// The lines in a unit's caches.
#[derive(Clone, Debug)]
pub struct WarmCaches {
    tree: Tree,
    pub(super) level1: Vec<Cache>,
    pub(super) level2: Cache,
    pub(super) ists: Vec<Cache>,
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
pub struct Misses {
    /// Of the traversal units' level-1 caches.
    pub level1: f64,
    /// Of the level-2 cache.
    pub level2: f64,
    /// Of the intersection units' caches.
    pub ist: f64,
}

impl Misses {
    /// Adds others.
    pub fn add(&mut self, more: &Misses) {
        self.level1 += more.level1;
        self.level2 += more.level2;
        self.ist += more.ist;
    }
}

impl WarmCaches {
    /// Empty caches.
    pub fn new(spec: &TniSpec, tree: Tree) -> WarmCaches {
        WarmCaches {
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

    /// A ray reads the node or the triangle at an address: a [`Step`](super::Step) of it. Each ray begins at
    /// the first node. What it misses is added to `misses`.
    #[inline]
    pub fn read(&mut self, address: u32, misses: &mut Misses) {
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
