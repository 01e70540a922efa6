//! The predicates of the ways through a loop body.

use super::push_op;
use crate::flow::{Cfg, Flow, LoopData};
use crate::program::*;
use rustc_hash::FxHashMap;
use srp_archdesc::isa::{Opcode, Ty};

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

/// A jump from a loop's header past its body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Past {
    /// Its number among the edges into its target.
    pub(super) edge: usize,
    /// The first block of the body.
    pub(super) body: Block,
    /// Taken if this predicate has this value.
    pub(super) cond: Value,
    pub(super) sense: bool,
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
    costs: FxHashMap<(Block, Block), u32>,
    /// Predicates that are constants of the loop.
    constants: FxHashMap<Value, bool>,
}

impl Ways {
    pub(super) fn of(func: &Function, flow: &Flow, data: &LoopData) -> Ways {
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
                if target.block != data.header && data.contains(target.block) {
                    edges.entry(target.block).or_default().push(Edge {
                        from: block,
                        cond,
                        args: target.args.clone(),
                        pos: func.blocks[block].end_pos,
                    });
                }
            }
        }
        let after = post_dominators(func, &flow.cfg, data);
        let mut parent = FxHashMap::default();
        let mut sure = FxHashMap::default();
        for &block in &data.blocks[1..] {
            let above = flow
                .dominators
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
            costs: FxHashMap::default(),
            constants: constants(func, data),
        }
    }

    /// The jumps to a block.
    pub(super) fn edges_into(&self, block: Block) -> &[Edge] {
        self.edges.get(&block).map_or(&[], Vec::as_slice)
    }

    /// About how many operations compute the predicate that an edge into `block` is taken, given
    /// that the block is reached.
    pub(super) fn cost(&mut self, block: Block, edge: &Edge) -> u32 {
        let above = self.parent[&block];
        self.cost_along(above, edge)
    }

    fn cost_along(&mut self, from: Block, edge: &Edge) -> u32 {
        let reached = self.cost_from(from, edge.from);
        let own = match edge.cond {
            None => 0,
            Some((_, sense)) => u32::from(!sense) + u32::from(reached > 0),
        };
        reached.saturating_add(own)
    }

    fn cost_from(&mut self, from: Block, to: Block) -> u32 {
        let to = self.unsure(from, to);
        if to == from {
            return 0;
        }
        if let Some(&cost) = self.costs.get(&(from, to)) {
            return cost;
        }
        let edges = self.edges_into(to).to_vec();
        // The condition itself counts as well: *always* is cheaper.
        let mut cost = edges.len() as u32;
        for edge in &edges {
            cost = cost.saturating_add(self.cost_along(from, edge));
        }
        self.costs.insert((from, to), cost);
        cost
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

    /// The edge from the header past all of the body, among those into a block, if all others come from the other side of
    /// the header's test.
    pub(super) fn past_the_body(
        &self,
        func: &Function,
        header: Block,
        edges: &[Edge],
    ) -> Option<Past> {
        let Terminator::Branch { cond, then, other } = &func.blocks[header].end else {
            return None;
        };
        let edge = edges.iter().position(|edge| edge.from == header)?;
        let (_, sense) = edges[edge].cond?;
        let body = if sense { other.block } else { then.block };
        let from_body = |(i, e): (usize, &Edge)| i == edge || self.dominates(body, e.from);
        let all = edges.len() > 1 && edges.iter().enumerate().all(from_body);
        (all && then.block != other.block).then_some(Past {
            edge,
            body,
            cond: *cond,
            sense,
        })
    }

    /// The one edge that brings *true* to a parameter of a block, where all others bring *false*: what the parameter
    /// says is that this edge was taken.
    pub(super) fn only_true<'e>(
        &self,
        func: &Function,
        edges: &'e [Edge],
        place: usize,
    ) -> Option<&'e Edge> {
        let constant = |edge: &Edge| self.constants.get(&edge.args[place]).copied();
        let mut only = None;
        for edge in edges {
            match constant(edge)? {
                true if only.is_some() => return None,
                true => only = Some(edge),
                false => {}
            }
        }
        only.filter(|edge| func.values[edge.args[place]] == Ty::Pred)
    }

    /// The predicate of getting from the header to an edge and along it, where the header's own test comes last: what it
    /// tests may come from the iteration before, which then waits for one operation only.
    pub(super) fn taken_last(
        &mut self,
        func: &mut Function,
        header: Block,
        edge: &Edge,
        insts: &mut Vec<Inst>,
    ) -> Value {
        let pos = edge.pos;
        let mut value = None;
        let mut start = header;
        if let Terminator::Branch { cond, then, .. } = &func.blocks[header].end
            && self.dominates(then.block, edge.from)
        {
            value = Some(*cond);
            start = then.block;
        }
        let rest = self.along(func, start, edge, insts);
        match (value, rest) {
            (Some(first), Some(rest)) => push_op(func, insts, Opcode::Pand, vec![rest, first], pos),
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => {
                let inst = func.make_inst(InstKind::Const(Bits::Pred(true)), &[Ty::Pred], pos);
                insts.push(inst);
                func.insts[inst].results[0]
            }
        }
    }

    /// True if every way to a block passes another one.
    fn dominates(&self, above: Block, block: Block) -> bool {
        let mut at = Some(block);
        while let Some(here) = at {
            if here == above {
                return true;
            }
            at = self.parent.get(&here).copied();
        }
        false
    }

    /// The predicate of getting to an edge and along it, from a block that dominates it.
    pub(super) fn along(
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
        let to = self.unsure(from, to);
        if to == from {
            return None;
        }
        if let Some(&made) = self.made.get(&(from, to)) {
            return made;
        }
        let made = match self.alternative(func, to) {
            Some(other) => {
                let above = self.parent[&to];
                let reached = self.from(func, from, above, insts);
                let pos = func.blocks[above].end_pos;
                let other = self.from(func, above, other, insts);
                let other = other.expect("an alternative is not sure");
                let not = push_op(func, insts, Opcode::Pnot, vec![other], pos);
                Some(match reached {
                    None => not,
                    Some(reached) => push_op(func, insts, Opcode::Pand, vec![reached, not], pos),
                })
            }
            None => self.any_edge(func, from, to, insts),
        };
        self.made.insert((from, to), made);
        made
    }

    /// The block above `to` that is reached just when `to` is, or `from` if that comes first.
    fn unsure(&self, from: Block, to: Block) -> Block {
        let mut to = to;
        while to != from && self.sure[&to] {
            to = self.parent[&to];
        }
        to
    }

    /// The block that is reached from the parent of `block` just when `block` is not, if that has
    /// fewer ways into it: of `if (a && b) … else …` the *then* for the *else*.
    fn alternative(&self, func: &Function, block: Block) -> Option<Block> {
        let above = self.parent[&block];
        let into = self.edges_into(block);
        // The blocks between: those that decide.
        let mut between = vec![above];
        let mut work: Vec<Block> = into.iter().map(|e| e.from).collect();
        while let Some(at) = work.pop() {
            if !between.contains(&at) {
                between.push(at);
                work.extend(self.edges_into(at).iter().map(|e| e.from));
            }
        }
        let mut other = None;
        for &at in &between {
            for target in func.blocks[at].end.targets().map(|t| t.block) {
                if target != block && !between.contains(&target) && other != Some(target) {
                    if other.is_some() {
                        return None;
                    }
                    other = Some(target);
                }
            }
        }
        let other = other?;
        let ways = self.edges_into(other);
        let decided = !ways.is_empty() && ways.iter().all(|e| between.contains(&e.from));
        (decided && ways.len() < into.len()).then_some(other)
    }

    /// The predicate that one of the edges into a block is taken.
    fn any_edge(
        &mut self,
        func: &mut Function,
        from: Block,
        to: Block,
        insts: &mut Vec<Inst>,
    ) -> Option<Value> {
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
        any
    }
}

/// The constant predicates that a loop's blocks have.
fn constants(func: &Function, data: &LoopData) -> FxHashMap<Value, bool> {
    let insts = data
        .blocks
        .iter()
        .flat_map(|&block| &func.blocks[block].insts);
    let constant = |&inst: &Inst| match func.insts[inst].kind {
        InstKind::Const(Bits::Pred(known)) => Some((func.insts[inst].results[0], known)),
        _ => None,
    };
    insts.filter_map(constant).collect()
}

/// For each block but the latch the nearest other one that all its ways to the latch pass.
fn post_dominators(func: &Function, cfg: &Cfg, data: &LoopData) -> FxHashMap<Block, Block> {
    let position = |b: Block| cfg.position(b);
    let mut after = FxHashMap::<Block, Block>::default();
    for &block in data.blocks.iter().rev() {
        let targets = func.blocks[block].end.targets().map(|t| t.block);
        let inside = targets.filter(|&t| t != data.header && data.contains(t));
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
