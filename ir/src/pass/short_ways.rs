//! Loops with a short way round, as loops of their own.
//!
//! Where an iteration sometimes runs a loop inside or calls a function, and otherwise goes straight back,
//! the straight way is taken most often. A way past the test before a loop is none: loops mostly run, but
//! for those that begin only if two values are equal (Ball and Larus 1993).
//!
//! The blocks of the short way become an inner loop, which [`hyperblocks`](super::hyperblock) and
//! [`replicate`](super::replicate) then can make one block: blocks where the ways meet again are doubled for
//! the short one (superblocks, Hwu et al. 1993), and the header gets a block before it to which the long ways
//! go back.

use super::defs::Defs;
use super::duplicate::copy;
use super::hyperblock::size;
use super::slots::{Uses, demote};
use crate::flow::{Cfg, Flow, Loop, LoopData};
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Opcode;

/// Operations of a block that is doubled.
const MAX_DOUBLED: usize = 16;

/// Changes of one function.
const MAX_CHANGES: u32 = 32;

/// Makes the short ways of all loops loops.
pub(crate) fn short_ways(func: &mut Function) -> bool {
    let mut changes = 0;
    while changes < MAX_CHANGES && change(func) {
        changes += 1;
    }
    changes > 0
}

/// Doubles one block, or gives one loop another header.
fn change(func: &mut Function) -> bool {
    let flow = Flow::of(func);
    if flow.loops.loops.is_empty() {
        return false;
    }
    let defs = Defs::of(func);
    flow.loops.loops.iter().any(|(id, data)| {
        if data.header == func.entry() || launches(func, data) {
            return false;
        }
        let ways = Ways::of(func, &defs, &flow, id);
        ways.has_long && (ways.double(func) || ways.divide(func))
    })
}

/// True if a loop runs a kernel, which it does as a rule.
fn launches(func: &Function, data: &LoopData) -> bool {
    let insts = data.blocks.iter().flat_map(|&b| &func.blocks[b].insts);
    let mut kinds = insts.map(|&inst| &func.insts[inst].kind);
    kinds.any(|kind| matches!(kind, InstKind::Launch { .. }))
}

/// The blocks of a loop by the ways that go through them.
struct Ways<'a> {
    cfg: &'a Cfg,
    data: &'a LoopData,
    /// Only short ways lead there.
    short: EntityMap<Block, bool>,
    /// It is in a loop inside, or calls.
    long: EntityMap<Block, bool>,
    /// The test of a loop, which comes next on one of its ways.
    tests: EntityMap<Block, bool>,
    has_long: bool,
}

impl<'a> Ways<'a> {
    fn of(func: &Function, defs: &Defs, flow: &'a Flow, id: Loop) -> Ways<'a> {
        let Flow { cfg, loops, .. } = flow;
        let data = &loops.loops[id];
        let count = func.blocks.len();
        let mut ways = Ways {
            cfg,
            data,
            short: EntityMap::filled(count, false),
            long: EntityMap::filled(count, false),
            tests: EntityMap::filled(count, false),
            has_long: false,
        };
        for &block in &data.blocks {
            ways.long[block] = loops.innermost(block) != Some(id) || size(func, block).is_none();
            ways.has_long |= ways.long[block];
        }
        // The order is that of the control flow, so a block comes after those before it.
        for &block in &data.blocks {
            let is_header = block == data.header;
            let all = is_header || cfg.preds[block].iter().all(|&p| ways.leads(p));
            ways.short[block] = all && !ways.long[block];
            let heads = |t: &Target| match &func.blocks[t.block].end {
                Terminator::Jump(on) if !loops.is_header(t.block) => loops.is_header(on.block),
                _ => loops.is_header(t.block),
            };
            let mut targets = func.blocks[block].end.targets();
            let back = |t: &Target| {
                let end = &func.blocks[t.block].end;
                t.block == data.header || end.is_jump_to(data.header)
            };
            let inside = targets.find(|t| heads(t) && !back(t));
            ways.tests[block] = inside.is_some_and(|t| !wants_equals(func, defs, block, t));
        }
        ways
    }

    /// True if a block is on a short way, and so is the next.
    fn leads(&self, block: Block) -> bool {
        self.short[block] && !self.tests[block]
    }

    /// Doubles a block where a short way meets a long one, if it is on the way back to the header.
    fn double(&self, func: &mut Function) -> bool {
        let meets = |&&block: &&Block| {
            let small = size(func, block).is_some_and(|size| size <= MAX_DOUBLED);
            let entered = || self.cfg.preds[block].iter().any(|&p| self.leads(p));
            let header = block == self.data.header;
            !header && !self.long[block] && !self.short[block] && small && entered()
        };
        let mut blocks = self.data.blocks.iter();
        let Some(&block) = blocks.find(|b| meets(b) && self.goes_back(func, **b)) else {
            return false;
        };
        demote(func, &[block], Uses::Outside);
        let (made, _) = copy(func, &[block]);
        for &pred in &self.cfg.preds[block] {
            if self.leads(pred) {
                func.blocks[pred].end.retarget(block, made[0]);
            }
        }
        let place = func.layout.iter().position(|&b| b == block);
        let place = place.unwrap_or(func.layout.len());
        func.layout.splice(place..place, made);
        true
    }

    /// True if a way leads from a block to the header past none that is long.
    fn goes_back(&self, func: &Function, block: Block) -> bool {
        let (mut open, mut seen) = (vec![block], vec![block]);
        while let Some(block) = open.pop() {
            for target in func.blocks[block].end.targets() {
                let to = target.block;
                if to == self.data.header {
                    return true;
                }
                if self.data.contains(to) && !self.long[to] && !seen.contains(&to) {
                    seen.push(to);
                    open.push(to);
                }
            }
        }
        false
    }

    /// Puts a block before the header, to which all but the short ways go.
    fn divide(&self, func: &mut Function) -> bool {
        let header = self.data.header;
        let latches = &self.data.latches;
        let short = latches.iter().filter(|&&l| self.leads(l)).count();
        if short == 0 || short == latches.len() {
            return false;
        }
        let before = func.add_block();
        let types = func.blocks[header].params.iter();
        let types: Vec<_> = types.map(|&v| func.values[v]).collect();
        let params: Vec<Value> = types.into_iter().map(|ty| func.values.push(ty)).collect();
        func.blocks[before].params = params.clone();
        func.blocks[before].end_pos = func.blocks[header].end_pos;
        func.blocks[before].end = Terminator::Jump(Target {
            block: header,
            args: params,
        });
        for &pred in &self.cfg.preds[header] {
            if !(latches.contains(&pred) && self.leads(pred)) {
                func.blocks[pred].end.retarget(header, before);
            }
        }
        func.layout.retain(|&b| b != before);
        let place = func.layout.iter().position(|&b| b == header);
        let place = place.unwrap_or(func.layout.len());
        func.layout.insert(place, before);
        true
    }
}

/// True if a block goes to a target only where two values are equal.
fn wants_equals(func: &Function, defs: &Defs, block: Block, target: &Target) -> bool {
    let Terminator::Branch { cond, then, .. } = &func.blocks[block].end else {
        return false;
    };
    let mut open = vec![(*cond, then.block == target.block)];
    while let Some((value, sense)) = open.pop() {
        match (defs.op(func, value), sense) {
            (Some((Opcode::Eq, _)), true) | (Some((Opcode::Ne, _)), false) => return true,
            (Some((Opcode::Pnot, args)), _) => open.push((args[0], !sense)),
            (Some((Opcode::Pand, args)), true) | (Some((Opcode::Por, args)), false) => {
                open.extend(args.iter().map(|&v| (v, sense)));
            }
            _ => {}
        }
    }
    false
}
