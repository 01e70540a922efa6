//! Dominance for the verifier alone: the equations of the definition, solved by iteration over rows
//! of bits. Slower than a dominator tree, and plainly right.

use crate::program::{Block, Function};
use srp_archdesc::entity::{Entity, EntityMap};

/// Which blocks dominate which.
pub(super) struct Dominance {
    /// One row of bits per block: its dominators.
    rows: EntityMap<Block, Vec<u64>>,
    reached: EntityMap<Block, bool>,
}

impl Dominance {
    /// Of a function whose first block of `blocks` is the entry. Jumps to anything that is not in
    /// `blocks` are ignored.
    pub(super) fn of(func: &Function, blocks: &[Block]) -> Dominance {
        let words = func.blocks.len().div_ceil(64);
        let mut preds = EntityMap::<Block, Vec<Block>>::filled(func.blocks.len(), Vec::new());
        let mut dominance = Dominance {
            rows: EntityMap::filled(func.blocks.len(), vec![u64::MAX; words]),
            reached: EntityMap::filled(func.blocks.len(), false),
        };
        let Some(&entry) = blocks.first() else {
            return dominance;
        };
        dominance.reach(func, entry, &mut preds);
        dominance.rows[entry] = vec![0; words];
        dominance.include(entry, entry);
        let mut changed = true;
        while changed {
            changed = false;
            for &block in blocks {
                if block == entry || !dominance.reached[block] {
                    continue;
                }
                let old = dominance.rows[block].clone();
                for &pred in &preds[block] {
                    dominance.intersect(block, pred);
                }
                dominance.include(block, block);
                changed |= dominance.rows[block] != old;
            }
        }
        dominance
    }

    /// Marks what can be reached from the entry and notes the predecessors.
    fn reach(&mut self, func: &Function, entry: Block, preds: &mut EntityMap<Block, Vec<Block>>) {
        self.reached[entry] = true;
        let mut work = vec![entry];
        while let Some(block) = work.pop() {
            for target in func.blocks[block].end.targets() {
                if self.reached.get(target.block).is_none() {
                    continue;
                }
                preds[target.block].push(block);
                if !std::mem::replace(&mut self.reached[target.block], true) {
                    work.push(target.block);
                }
            }
        }
    }

    fn include(&mut self, block: Block, dominator: Block) {
        self.rows[block][dominator.index() / 64] |= 1 << (dominator.index() % 64);
    }

    fn intersect(&mut self, block: Block, pred: Block) {
        for word in 0..self.rows[block].len() {
            let bits = self.rows[pred][word];
            self.rows[block][word] &= bits;
        }
    }

    /// Whether every way from the entry to `block` passes `dominator`.
    pub(super) fn dominates(&self, dominator: Block, block: Block) -> bool {
        self.rows[block][dominator.index() / 64] & (1 << (dominator.index() % 64)) != 0
    }

    /// Whether there is a way from the entry to the block.
    pub(super) fn is_reached(&self, block: Block) -> bool {
        self.reached[block]
    }
}
