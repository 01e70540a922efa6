//! Control flow of a function: predecessors, dominators, loops. Derived, never edited; made anew
//! after a change.

use crate::program::{Block, Function, Target};
use rustc_hash::FxHashSet;
use srp_archdesc::entity;
use srp_archdesc::entity::EntityMap;

entity! {
    /// A natural loop of one function.
    Loop = "loop";
}

/// The control flow of a function in all its parts.
#[derive(Clone, Debug)]
pub struct Flow {
    /// Predecessors, and an order of the blocks.
    pub cfg: Cfg,
    /// The dominator tree.
    pub dominators: Dominators,
    /// The natural loops.
    pub loops: Loops,
}

impl Flow {
    /// The control flow of a function.
    pub fn of(func: &Function) -> Flow {
        let cfg = Cfg::of(func);
        let dominators = Dominators::of(&cfg);
        let loops = Loops::of(&cfg, &dominators);
        Flow {
            cfg,
            dominators,
            loops,
        }
    }
}

/// Predecessors and an order of the blocks that can be reached.
#[derive(Clone, Debug)]
pub struct Cfg {
    /// The blocks that can be reached, each before its successors but for back edges: reverse
    /// postorder.
    pub order: Vec<Block>,
    /// Where jumps to a block come from, one entry a jump, in `order`.
    pub preds: EntityMap<Block, Vec<Block>>,
    position: EntityMap<Block, Option<u32>>,
}

impl Cfg {
    /// The control flow of a function.
    pub fn of(func: &Function) -> Cfg {
        let count = func.blocks.len();
        let mut seen = EntityMap::<Block, bool>::filled(count, false);
        let mut order = Vec::new();
        let mut stack = vec![(func.entry(), 0)];
        seen[func.entry()] = true;
        while let Some((block, next)) = stack.last_mut() {
            let target = func.blocks[*block].end.targets().nth(*next);
            *next += 1;
            match target {
                Some(target) if seen[target.block] => {}
                Some(target) => {
                    seen[target.block] = true;
                    stack.push((target.block, 0));
                }
                None => {
                    order.push(*block);
                    stack.pop();
                }
            }
        }
        order.reverse();
        let mut preds = EntityMap::<Block, Vec<Block>>::filled(count, Vec::new());
        let mut position = EntityMap::filled(count, None);
        for (i, &block) in (0..).zip(&order) {
            position[block] = Some(i);
            for target in func.blocks[block].end.targets() {
                preds[target.block].push(block);
            }
        }
        Cfg {
            order,
            preds,
            position,
        }
    }

    /// True if a block can be reached.
    pub fn is_reached(&self, block: Block) -> bool {
        self.position[block].is_some()
    }

    /// Where a block stands in `order`, if it can be reached.
    pub fn position(&self, block: Block) -> Option<u32> {
        self.position[block]
    }
}

/// The dominator tree of the blocks that can be reached (Cooper, Harvey and Kennedy 2001).
#[derive(Clone, Debug)]
pub struct Dominators {
    parent: EntityMap<Block, Option<Block>>,
    children: EntityMap<Block, Vec<Block>>,
    /// When a walk over the tree enters and leaves a block.
    entered: EntityMap<Block, u32>,
    left: EntityMap<Block, u32>,
}

impl Dominators {
    /// The dominators of a function with this control flow.
    pub fn of(cfg: &Cfg) -> Dominators {
        let count = cfg.preds.len();
        let mut parent = EntityMap::<Block, Option<Block>>::filled(count, None);
        let Some((&entry, rest)) = cfg.order.split_first() else {
            unreachable!("a function has an entry")
        };
        // The entry is its own parent while the others are sought.
        parent[entry] = Some(entry);
        let mut changed = true;
        while changed {
            changed = false;
            for &block in rest {
                let known = cfg.preds[block].iter().filter(|&&p| parent[p].is_some());
                let nearest = known.copied().reduce(|a, b| meet(cfg, &parent, a, b));
                changed |= parent[block] != nearest;
                parent[block] = nearest;
            }
        }
        parent[entry] = None;
        let mut children = EntityMap::<Block, Vec<Block>>::filled(count, Vec::new());
        for &block in rest {
            if let Some(parent) = parent[block] {
                children[parent].push(block);
            }
        }
        let mut tree = Dominators {
            parent,
            children,
            entered: EntityMap::filled(count, 0),
            left: EntityMap::filled(count, 0),
        };
        tree.number(entry);
        tree
    }

    fn number(&mut self, entry: Block) {
        let mut clock = 0;
        let mut stack = vec![(entry, 0)];
        while let Some((block, next)) = stack.last_mut() {
            clock += 1;
            if *next == 0 {
                self.entered[*block] = clock;
            }
            match self.children[*block].get(*next) {
                Some(&child) => {
                    *next += 1;
                    stack.push((child, 0));
                }
                None => {
                    self.left[*block] = clock;
                    stack.pop();
                }
            }
        }
    }

    /// The nearest block that dominates this one, but for itself.
    pub fn parent(&self, block: Block) -> Option<Block> {
        self.parent[block]
    }

    /// The blocks whose [`parent`](Self::parent) this is, in the order of the control flow.
    pub fn children(&self, block: Block) -> &[Block] {
        &self.children[block]
    }

    /// True if every path from the entry to `below` passes `above`. Both must be reachable.
    pub fn dominates(&self, above: Block, below: Block) -> bool {
        self.entered[above] <= self.entered[below] && self.left[below] <= self.left[above]
    }
}

fn meet(cfg: &Cfg, parent: &EntityMap<Block, Option<Block>>, a: Block, b: Block) -> Block {
    let (mut a, mut b) = (a, b);
    while a != b {
        let later = if cfg.position[a] > cfg.position[b] {
            &mut a
        } else {
            &mut b
        };
        *later = parent[*later].expect("blocks before others in the order have a parent");
    }
    a
}

/// The natural loops of a function, inner ones after those round them.
#[derive(Clone, Debug)]
pub struct Loops {
    /// The loops.
    pub loops: EntityMap<Loop, LoopData>,
    innermost: EntityMap<Block, Option<Loop>>,
}

/// One natural loop.
#[derive(Clone, Debug)]
pub struct LoopData {
    /// The block that all ways into the loop pass.
    pub header: Block,
    /// The blocks that jump back to the header.
    pub latches: Vec<Block>,
    /// All blocks, the header first, in the order of the control flow.
    pub blocks: Vec<Block>,
    /// The loop round it.
    pub parent: Option<Loop>,
    members: FxHashSet<Block>,
}

impl LoopData {
    /// True if a block is in the loop.
    pub fn contains(&self, block: Block) -> bool {
        self.members.contains(&block)
    }

    /// True if a jump at the end of a block goes out of the loop.
    pub fn is_left_at(&self, func: &Function, block: Block) -> bool {
        let mut targets = func.blocks[block].end.targets();
        targets.any(|t| !self.contains(t.block))
    }

    /// The jumps out of the loop, each with the block that ends in it.
    pub fn exits<'a>(&'a self, func: &'a Function) -> impl Iterator<Item = (Block, &'a Target)> {
        let jumps = self.blocks.iter().flat_map(|&from| {
            let targets = func.blocks[from].end.targets();
            targets.map(move |target| (from, target))
        });
        jumps.filter(|(_, target)| !self.contains(target.block))
    }
}

impl Loops {
    /// The loops of a function with this control flow.
    pub fn of(cfg: &Cfg, dominators: &Dominators) -> Loops {
        let mut loops = EntityMap::new();
        let mut innermost = EntityMap::<Block, Option<Loop>>::filled(cfg.preds.len(), None);
        // Headers of outer loops come first, so that an inner loop overwrites what it contains.
        for &header in &cfg.order {
            let back = |&p: &Block| cfg.is_reached(p) && dominators.dominates(header, p);
            let mut latches: Vec<Block> = cfg.preds[header].iter().copied().filter(back).collect();
            latches.dedup();
            if latches.is_empty() {
                continue;
            }
            let parent = innermost[header];
            let (blocks, members) = body(cfg, header, &latches);
            let id = loops.push(LoopData {
                header,
                latches,
                blocks,
                parent,
                members,
            });
            for &block in &loops[id].blocks {
                innermost[block] = Some(id);
            }
        }
        Loops { loops, innermost }
    }

    /// The innermost loop round a block.
    pub fn innermost(&self, block: Block) -> Option<Loop> {
        self.innermost[block]
    }

    /// True if a block is the header of a loop.
    pub fn is_header(&self, block: Block) -> bool {
        let around = self.innermost[block];
        around.is_some_and(|id| self.loops[id].header == block)
    }

    /// The loops right inside one.
    pub fn inside(&self, outer: Loop) -> impl Iterator<Item = (Loop, &LoopData)> {
        let loops = self.loops.iter();
        loops.filter(move |(_, data)| data.parent == Some(outer))
    }

    /// True if no loop is inside this one.
    pub fn is_innermost(&self, of: Loop) -> bool {
        self.inside(of).next().is_none()
    }
}

/// The blocks that reach a latch without passing the header, in order, and as a set.
fn body(cfg: &Cfg, header: Block, latches: &[Block]) -> (Vec<Block>, FxHashSet<Block>) {
    let mut blocks = vec![header];
    let mut seen = FxHashSet::default();
    seen.insert(header);
    let mut work = latches.to_vec();
    while let Some(block) = work.pop() {
        if seen.insert(block) {
            blocks.push(block);
            work.extend(&cfg.preds[block]);
        }
    }
    blocks.sort_by_key(|&block| cfg.position(block));
    (blocks, seen)
}
