//! The work of rays by level of the tree, from the visits that the unit notes.

use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::system::TniSpec;

use super::decoded::Decoded;
use super::{Tree, Visited};
use crate::memory::SystemMemory;

/// The work of rays at one level of a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct LevelCounts {
    /// Inner nodes of the tree.
    pub nodes: u64,
    /// Leaves of the tree.
    pub leaves: u64,
    /// Visits of inner nodes.
    pub visits: u64,
    /// Visits of leaves.
    pub leaf_visits: u64,
    /// Triangles tested.
    pub tests: u64,
    /// Bytes that the memory gave T&I units; a line of memory belongs to the level of the first thing in it.
    pub bytes: u64,
}

/// Counts by level.
pub struct Levels {
    spec: TniSpec,
    tree: Tree,
    /// The level of the inner node that each pair of siblings is below, and of the leaf of each triangle record.
    of_pairs: Vec<u16>,
    of_records: Vec<u16>,
    counts: Vec<LevelCounts>,
}

impl Levels {
    /// The levels of a tree in memory.
    pub fn of(spec: &TniSpec, tree: &Tree, memory: &SystemMemory) -> Levels {
        let mut levels = Levels {
            spec: *spec,
            tree: *tree,
            of_pairs: Vec::new(),
            of_records: Vec::new(),
            counts: Vec::new(),
        };
        let decoded = Decoded::shared(spec, tree, memory);
        let mut open: Vec<_> = tree.root.map(|root| (root, 0)).into_iter().collect();
        while let Some((node, level)) = open.pop() {
            if levels.counts.len() <= usize::from(level) {
                let count = usize::from(level) + 1;
                levels.counts.resize(count, LevelCounts::default());
            }
            let counts = &mut levels.counts[usize::from(level)];
            if node.is_leaf() {
                counts.leaves += 1;
                for record in node.index..node.index + node.count {
                    set(&mut levels.of_records, record as usize, level);
                }
            } else {
                counts.nodes += 1;
                set(&mut levels.of_pairs, node.index as usize / 2, level);
                let below = level.saturating_add(1);
                open.extend(decoded.pair(node).child.map(|child| (child, below)));
            }
        }
        levels
    }

    /// Rays have visited these parts of the tree.
    pub fn visit(&mut self, visited: &[Visited]) {
        for visited in visited {
            match *visited {
                Visited::Node(leaf) if leaf.is_leaf() => {
                    let level = self.of_records[leaf.index as usize];
                    self.counts[usize::from(level)].leaf_visits += 1;
                }
                Visited::Node(node) => {
                    let level = self.of_pairs[node.index as usize / 2];
                    self.counts[usize::from(level)].visits += 1;
                }
                Visited::Triangle(record) => {
                    let level = self.of_records[record as usize];
                    self.counts[usize::from(level)].tests += 1;
                }
            }
        }
    }

    /// A unit reads a line of memory: it belongs to the level of the first thing in it.
    pub fn read(&mut self, address: u32, bytes: u32) {
        let of = |start: u32, size: u32, levels: &[u16]| {
            let number = address.checked_sub(start)?.div_ceil(size) as usize;
            levels.get(number).or(levels.last()).copied()
        };
        let Levels { spec, tree, .. } = self;
        let level = match address < tree.triangles {
            true => of(tree.nodes, 2 * spec.node_bytes, &self.of_pairs),
            false => of(tree.triangles, spec.triangle_bytes, &self.of_records),
        };
        if let Some(level) = level {
            self.counts[usize::from(level)].bytes += u64::from(bytes);
        }
    }

    /// The counts, level by level from the root down.
    pub fn counts(&self) -> &[LevelCounts] {
        &self.counts
    }
}

/// Sets an element of a list that grows as far as that takes.
fn set(levels: &mut Vec<u16>, number: usize, level: u16) {
    if levels.len() <= number {
        levels.resize(number + 1, 0);
    }
    levels[number] = level;
}
