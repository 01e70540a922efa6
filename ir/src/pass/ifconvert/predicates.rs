//! The predicates of the ways through a loop body.

use super::push_op;
use crate::flow::{Cfg, Dominators, LoopData};
use crate::program::*;
use rustc_hash::FxHashMap;
use srp_archdesc::isa::Opcode;

/// A jump from one block of the body to another.
#[derive(Clone, Debug)]
pub(super) struct Edge {
    pub(super) from: Block,
    /// Taken if this predicate has this value; always, if there is none.
    pub(super) cond: Option<(Value, bool)>,
    pub(super) args: Vec<Value>,
    /// Position of the jump.
    pub(super) pos: Pos,
}

/// The ways through a loop body, its back edge left out: an acyclic graph from header to latch.
pub(super) struct Ways {
    edges: FxHashMap<Block, Vec<Edge>>,
    /// The nearest dominator of each block but the header.
    parent: FxHashMap<Block, Block>,
    /// Blocks that every way from their nearest dominator to the latch passes.
    sure: FxHashMap<Block, bool>,
    /// Predicates already made: of getting from the first block to the second.
    made: FxHashMap<(Block, Block), Option<Value>>,
}

impl Ways {
    pub(super) fn of(func: &Function, cfg: &Cfg, dominators: &Dominators, data: &LoopData) -> Ways {
        let mut edges = FxHashMap::<Block, Vec<Edge>>::default();
        for &block in &data.blocks {
            let end = &func.blocks[block].end;
            let mut sense = true;
            for target in end.targets() {
                let cond = match end {
                    Terminator::Branch { cond, .. } => Some((*cond, sense)),
                    _ => None,
                };
                sense = false;
                if target.block != data.header && data.blocks.contains(&target.block) {
                    edges.entry(target.block).or_default().push(Edge {
                        from: block,
                        cond,
                        args: target.args.clone(),
                        pos: func.blocks[block].end_pos,
                    });
                }
            }
        }
        let after = post_dominators(func, cfg, data);
        let mut parent = FxHashMap::default();
        let mut sure = FxHashMap::default();
        for &block in &data.blocks[1..] {
            let above = dominators
                .parent(block)
                .expect("the header dominates the blocks of its loop");
            let mut at = Some(above);
            while let Some(here) = at.filter(|&b| b != block) {
                at = after.get(&here).copied();
            }
            parent.insert(block, above);
            sure.insert(block, at.is_some());
        }
        Ways {
            edges,
            parent,
            sure,
            made: FxHashMap::default(),
        }
    }

    /// The jumps to a block.
    pub(super) fn edges_into(&self, block: Block) -> &[Edge] {
        self.edges.get(&block).map_or(&[], Vec::as_slice)
    }

    /// The predicate that an edge into `block` is taken, given that the block is reached.
    pub(super) fn taken(
        &mut self,
        func: &mut Function,
        block: Block,
        edge: &Edge,
        insts: &mut Vec<Inst>,
    ) -> Option<Value> {
        let above = self.parent[&block];
        self.along(func, above, edge, insts)
    }

    /// The predicate of getting to an edge and along it, from a block that dominates it.
    fn along(
        &mut self,
        func: &mut Function,
        from: Block,
        edge: &Edge,
        insts: &mut Vec<Inst>,
    ) -> Option<Value> {
        let reached = self.from(func, from, edge.from, insts);
        let Some((cond, sense)) = edge.cond else {
            return reached;
        };
        let cond = match sense {
            true => cond,
            false => push_op(func, insts, Opcode::Pnot, vec![cond], edge.pos),
        };
        Some(match reached {
            None => cond,
            Some(reached) => push_op(func, insts, Opcode::Pand, vec![reached, cond], edge.pos),
        })
    }

    /// The predicate of getting from one block to another that it dominates; none, if that is sure.
    pub(super) fn from(
        &mut self,
        func: &mut Function,
        from: Block,
        to: Block,
        insts: &mut Vec<Inst>,
    ) -> Option<Value> {
        // Up to where it is no longer sure.
        let mut to = to;
        while to != from && self.sure[&to] {
            to = self.parent[&to];
        }
        if to == from {
            return None;
        }
        if let Some(&made) = self.made.get(&(from, to)) {
            return made;
        }
        let mut any = None;
        for edge in self.edges_into(to).to_vec() {
            let taken = self
                .along(func, from, &edge, insts)
                .expect("a way that is not sure has a condition");
            any = Some(match any {
                None => taken,
                Some(any) => push_op(func, insts, Opcode::Por, vec![any, taken], edge.pos),
            });
        }
        self.made.insert((from, to), any);
        any
    }
}

/// For each block but the latch the nearest other one that all its ways to the latch pass.
fn post_dominators(func: &Function, cfg: &Cfg, data: &LoopData) -> FxHashMap<Block, Block> {
    let position = |b: Block| cfg.position(b);
    let mut after = FxHashMap::<Block, Block>::default();
    for &block in data.blocks.iter().rev() {
        let targets = func.blocks[block].end.targets().map(|t| t.block);
        let inside = targets.filter(|&t| t != data.header && data.blocks.contains(&t));
        let meet = |a: Block, b: Block| {
            let (mut a, mut b) = (a, b);
            while a != b {
                let earlier = if position(a) < position(b) {
                    &mut a
                } else {
                    &mut b
                };
                *earlier = after[earlier];
            }
            a
        };
        if let Some(nearest) = inside.reduce(meet) {
            after.insert(block, nearest);
        }
    }
    after
}
