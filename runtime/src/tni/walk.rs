//! A ray's way through the tree: the stack operations of TRV_POST.
//!
//! The stack is short: when it overflows, its oldest entry is forgotten, and when it runs empty
//! too early the ray starts again at the root. A trail (Laine 2010), one bit a level, says what has
//! been seen: 1 where everything on the near side of the current path is done. So the walk is right
//! for any stack depth, and a stack as deep as the tree never restarts.

use schemars::JsonSchema;
use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use crate::bvh::{MAX_DEPTH, NodeRef};
use crate::sums::sums;

// One trail bit a level.
const _: () = assert!(MAX_DEPTH < 127);

/// Counts of stacks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct StackCounters {
    /// Nodes put on a stack.
    pub pushes: u64,
    /// Nodes taken off.
    pub pops: u64,
    /// Of these, nodes that lay behind the nearest hit and were not visited.
    pub culled: u64,
    /// Nodes forgotten because a stack was full.
    pub overflows: u64,
    /// Walks started again at the root because of that.
    pub restarts: u64,
}

sums!(StackCounters: pushes pops culled overflows restarts);

/// A node put aside for later.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Entry {
    node: NodeRef,
    /// Where the ray enters its box.
    enter: f32,
    /// Level of its parent.
    level: u8,
}

/// No level.
const NOWHERE: u8 = u8::MAX;

/// The place of a ray in the tree, and its stack.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Walk {
    /// The node to visit.
    pub(super) node: NodeRef,
    /// Where the ray enters its box.
    pub(super) enter: f32,
    root: NodeRef,
    /// Levels of `node` below the root.
    level: u8,
    /// Bit `i`: on level `i`, the path goes through the last child to be visited.
    trail: u128,
    /// While walking down again after a restart: the level whose last child comes next.
    resume: u8,
    stack: VecDeque<Entry>,
    depth: usize,
}

/// The next step of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Next {
    /// A visit of [`Walk::node`].
    Visit,
    /// The triangles of the leaf just visited.
    Intersect,
    /// Nothing: everything that it can hit has been tested.
    Finished,
}

impl Walk {
    /// A walk with a stack of `depth` ≥ 1 entries.
    pub(super) fn new(depth: u32) -> Walk {
        let depth = depth.max(1) as usize;
        Walk {
            node: NodeRef::default(),
            enter: 0.0,
            root: NodeRef::default(),
            level: 0,
            trail: 0,
            resume: NOWHERE,
            stack: VecDeque::with_capacity(depth.min(MAX_DEPTH)),
            depth,
        }
    }

    /// Starts at the root, whose box has no record: the ray enters it where it begins.
    pub(super) fn start(&mut self, root: NodeRef) {
        self.node = root;
        self.enter = 0.0;
        self.root = root;
        self.level = 0;
        self.trail = 0;
        self.resume = NOWHERE;
        self.stack.clear();
    }

    /// True if going on from an inner node, whose children the ray enters at `enter`, leaves the stack alone:
    /// it enters one of them only.
    #[inline]
    pub(super) fn is_direct(&self, enter: [Option<f32>; 2]) -> bool {
        enter[0].is_some() != enter[1].is_some() && self.resume != self.level
    }

    /// Goes on from an inner node, whose children the ray enters at `enter` (`None`: misses). The
    /// nearer is visited first; of equally near ones the first. Says how many entries were popped.
    pub(super) fn descend(
        &mut self,
        children: [NodeRef; 2],
        enter: [Option<f32>; 2],
        limit: f32,
        counters: &mut StackCounters,
    ) -> (Next, u32) {
        let bit = 1u128 << self.level;
        let resumes = self.resume == self.level;
        if resumes {
            self.resume = NOWHERE;
        }
        let node = match enter {
            [Some(a), Some(b)] => {
                let near = usize::from(b < a);
                let far = 1 - near;
                if self.trail & bit != 0 {
                    self.enter = [a, b][far];
                    children[far]
                } else {
                    let enter = [a, b][far];
                    self.push(children[far], enter, counters);
                    self.enter = [a, b][near];
                    children[near]
                }
            }
            // Here both were met before the restart; the far one lies behind the hit by now.
            [Some(_), None] | [None, Some(_)] if resumes => return self.pop(limit, counters),
            [Some(enter), None] => {
                self.trail |= bit;
                self.enter = enter;
                children[0]
            }
            [None, Some(enter)] => {
                self.trail |= bit;
                self.enter = enter;
                children[1]
            }
            [None, None] => return self.pop(limit, counters),
        };
        self.node = node;
        self.level += 1;
        (Next::Visit, 0)
    }

    /// Goes on from a node below which everything is done.
    pub(super) fn pop(&mut self, limit: f32, counters: &mut StackCounters) -> (Next, u32) {
        let mut popped = 0;
        loop {
            // The deepest level above on which the far child is still to be visited.
            let open = !self.trail & ((1 << self.level) - 1);
            if open == 0 {
                return (Next::Finished, popped);
            }
            let level = 127 - open.leading_zeros() as u8;
            let bit = 1u128 << level;
            self.trail = (self.trail & (bit - 1)) | bit;
            let Some(entry) = self.stack.pop_back() else {
                counters.restarts += 1;
                self.node = self.root;
                self.enter = 0.0;
                self.level = 0;
                self.resume = level;
                return (Next::Visit, popped);
            };
            debug_assert_eq!(entry.level, level, "the stack follows the trail");
            popped += 1;
            counters.pops += 1;
            self.level = level + 1;
            self.resume = NOWHERE;
            if entry.enter <= limit {
                self.node = entry.node;
                self.enter = entry.enter;
                return (Next::Visit, popped);
            }
            counters.culled += 1;
        }
    }

    fn push(&mut self, node: NodeRef, enter: f32, counters: &mut StackCounters) {
        if self.stack.len() == self.depth {
            self.stack.pop_front();
            counters.overflows += 1;
        }
        counters.pushes += 1;
        self.stack.push_back(Entry {
            node,
            enter,
            level: self.level,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Walks a full binary tree of 2^levels leaves whose nodes are numbered as in a heap; `enter`
    /// gives the distance of a node. Returns the leaves in order of visit.
    fn leaves(
        levels: u32,
        depth: u32,
        limit: f32,
        enter: impl Fn(u32) -> Option<f32>,
    ) -> (Vec<u32>, StackCounters) {
        let first_leaf = 1 << levels;
        let node = |i: u32| NodeRef {
            index: i,
            count: u32::from(i >= first_leaf),
        };
        let mut counters = StackCounters::default();
        let mut walk = Walk::new(depth);
        walk.start(node(1));
        let mut visited = Vec::new();
        let mut next = Next::Visit;
        while next == Next::Visit {
            let at = walk.node.index;
            next = if walk.node.is_leaf() {
                visited.push(at);
                walk.pop(limit, &mut counters).0
            } else {
                let children = [2 * at, 2 * at + 1];
                walk.descend(
                    children.map(node),
                    children.map(&enter),
                    limit,
                    &mut counters,
                )
                .0
            };
        }
        (visited, counters)
    }

    #[test]
    fn any_stack_visits_the_same_leaves_in_the_same_order() {
        for seed in 0..200u32 {
            let hash = |i: u32| (i ^ seed).wrapping_mul(2_654_435_761) >> 7;
            let enter = |i: u32| (hash(i) % 5 != 0).then_some((hash(i) % 64) as f32);
            let (expected, full) = leaves(8, 64, f32::MAX, enter);
            assert_eq!(full.restarts, 0);
            assert_eq!(full.overflows, 0);
            for depth in 1..6 {
                let (visited, short) = leaves(8, depth, f32::MAX, enter);
                assert_eq!(visited, expected, "seed {seed}, depth {depth}");
                assert!(short.overflows >= short.restarts);
            }
        }
    }

    #[test]
    fn what_lies_behind_the_limit_is_not_visited() {
        let (visited, counters) = leaves(4, 64, 10.0, |i| Some((i % 16) as f32));
        assert!(counters.culled > 0);
        assert!(visited.len() < 16);
    }
}
