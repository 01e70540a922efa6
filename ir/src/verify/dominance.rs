//! Dominance for the verifier alone: the equations of the definition, solved by iteration over rows
//! of bits. Slower than a dominator tree, and plainly right.

use crate::program::{Block, Function};
use srp_archdesc::entity::{Entity, EntityMap};

/// Which blocks dominate which.
pub(super) struct Dominance {
    /// A row of so many words per block: its dominators, a bit each.
    rows: Vec<u64>,
    words: usize,
    reached: EntityMap<Block, bool>,
}

impl Dominance {
    /// Of a function whose first block of `blocks` is the entry. Jumps to anything that is not in
    /// `blocks` are ignored.
    pub(super) fn of(func: &Function, blocks: &[Block]) -> Dominance {
        let words = func.blocks.len().div_ceil(64);
        let mut preds = EntityMap::<Block, Vec<Block>>::filled(func.blocks.len(), Vec::new());
        let mut dominance = Dominance {
            rows: vec![u64::MAX; words * func.blocks.len()],
            words,
            reached: EntityMap::filled(func.blocks.len(), false),
        };
        let Some(&entry) = blocks.first() else {
            return dominance;
        };
        let order = dominance.reach(func, entry, &mut preds);
        let own = entry.index() * words;
        dominance.rows[own..own + words].fill(0);
        dominance.rows[own + entry.index() / 64] = 1 << (entry.index() % 64);
        let mut changed = true;
        while changed {
            changed = false;
            // The entry comes first and stays.
            for &block in &order[1..] {
                for &pred in &preds[block] {
                    changed |= dominance.intersect(block, pred);
                }
            }
        }
        dominance
    }

    /// Marks what can be reached from the entry and notes the predecessors. The blocks in an order
    /// that has most of them after their predecessors.
    fn reach(
        &mut self,
        func: &Function,
        entry: Block,
        preds: &mut EntityMap<Block, Vec<Block>>,
    ) -> Vec<Block> {
        self.reached[entry] = true;
        let mut work = vec![(entry, 0)];
        let mut left = Vec::new();
        while let Some((block, next)) = work.last_mut() {
            let block = *block;
            let Some(target) = func.blocks[block].end.targets().nth(*next) else {
                left.push(block);
                work.pop();
                continue;
            };
            *next += 1;
            if self.reached.get(target.block).is_none() {
                continue;
            }
            preds[target.block].push(block);
            if !std::mem::replace(&mut self.reached[target.block], true) {
                work.push((target.block, 0));
            }
        }
        left.reverse();
        left
    }

    /// Lets a block have no dominators but itself that its predecessor has not; whether it had.
    fn intersect(&mut self, block: Block, pred: Block) -> bool {
        let mut changed = false;
        let (start, of_pred) = (block.index() * self.words, pred.index() * self.words);
        for word in 0..self.words {
            let own = if word == block.index() / 64 {
                1 << (block.index() % 64)
            } else {
                0
            };
            let old = self.rows[start + word];
            let new = old & (self.rows[of_pred + word] | own);
            self.rows[start + word] = new;
            changed |= new != old;
        }
        changed
    }

    /// True if every path from the entry to `block` passes `dominator`.
    pub(super) fn dominates(&self, dominator: Block, block: Block) -> bool {
        let word = self.rows[block.index() * self.words + dominator.index() / 64];
        word & (1 << (dominator.index() % 64)) != 0
    }

    /// True if a path leads from the entry to the block.
    pub(super) fn is_reached(&self, block: Block) -> bool {
        self.reached[block]
    }
}
