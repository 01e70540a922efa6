//! Simplification of control flow.

use super::Remark;
use super::rename::Renames;
use crate::flow::{Cfg, Flow};
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Opcode;

/// An empty block may head a loop and do nothing but go on to the header of a loop inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Nests {
    /// Such a block goes, and the two loops are one.
    Merge,
    /// Such a block stays, so that the loop inside is a loop of its own.
    Keep,
}

/// Decides branches on constants, makes branches whose two ways lead to one block into selections,
/// removes blocks that cannot be reached, skips empty blocks, and joins blocks that follow each
/// other. Marks on blocks that are no loop headers are dropped, with a remark.
pub(super) fn simplify_cfg(func: &mut Function, nests: Nests, remarks: &mut Vec<Remark>) -> bool {
    let mut changed = false;
    loop {
        let mut again = decide_branches(func);
        again |= skip_empty(func, nests);
        again |= select_targets(func);
        again |= remove_unreached(func);
        drop_marks(func, remarks);
        again |= join(func);
        if !again {
            return changed;
        }
        changed = true;
    }
}

/// Branches on constants, and with two equal targets, to jumps.
fn decide_branches(func: &mut Function) -> bool {
    let mut constants = EntityMap::<Value, Option<bool>>::filled(func.values.len(), None);
    for &block in &func.layout {
        for &inst in &func.blocks[block].insts {
            if let InstKind::Const(Bits::Pred(p)) = func.insts[inst].kind {
                constants[func.insts[inst].results[0]] = Some(p);
            }
        }
    }
    let mut changed = false;
    for &block in &func.layout {
        let end = &mut func.blocks[block].end;
        if let Terminator::Branch { cond, then, other } = end {
            let target = match constants[*cond] {
                Some(true) => then,
                Some(false) => other,
                None if then == other => then,
                None => continue,
            };
            *end = Terminator::Jump(target.clone());
            changed = true;
        }
    }
    changed
}

/// Branches with two ways to one block, bringing different values, to selections of the values.
fn select_targets(func: &mut Function) -> bool {
    let mut changed = false;
    for i in 0..func.layout.len() {
        let block = func.layout[i];
        let Terminator::Branch { cond, then, other } = &func.blocks[block].end else {
            continue;
        };
        if then.block != other.block {
            continue;
        }
        let (cond, mut then, other) = (*cond, then.clone(), other.clone());
        let pos = func.blocks[block].end_pos;
        for (arg, other) in then.args.iter_mut().zip(other.args) {
            if *arg != other {
                let op = Opcode::select(func.values[other]);
                let selected = func.append_op(block, op, &[cond, *arg, other], 0, pos);
                *arg = selected.expect("selections have a result");
            }
        }
        func.blocks[block].end = Terminator::Jump(then);
        changed = true;
    }
    changed
}

pub(super) fn remove_unreached(func: &mut Function) -> bool {
    let cfg = Cfg::of(func);
    let before = func.layout.len();
    func.layout.retain(|&block| cfg.is_reached(block));
    func.layout.len() != before
}

/// Lets jumps to a block that does nothing but jump on go where it goes.
fn skip_empty(func: &mut Function, nests: Nests) -> bool {
    let mut skippable = EntityMap::<Block, bool>::filled(func.blocks.len(), false);
    for &block in &func.layout[1..] {
        let data = &func.blocks[block];
        let goes_on = matches!(&data.end, Terminator::Jump(to) if to.block != block);
        skippable[block] = goes_on && data.insts.is_empty() && data.kernel.is_none();
    }
    keep_params_used_elsewhere(func, &mut skippable);
    if nests == Nests::Keep && skippable.values().any(|&s| s) {
        keep_headers_of_nests(func, &mut skippable);
    }
    let mut changed = false;
    for i in 0..func.layout.len() {
        let block = func.layout[i];
        let mut end = func.blocks[block].end.clone();
        let mut skipped = false;
        for target in end.targets_mut() {
            // An endless loop of empty blocks has no end to go to.
            for _ in 0..func.layout.len() {
                if !skippable[target.block] {
                    break;
                }
                let data = &func.blocks[target.block];
                let Terminator::Jump(next) = &data.end else {
                    unreachable!("only blocks that end in a jump are skipped")
                };
                let mut next = next.clone();
                for arg in &mut next.args {
                    if let Some(place) = data.params.iter().position(|param| param == arg) {
                        *arg = target.args[place];
                    }
                }
                *target = next;
                skipped = true;
            }
        }
        if skipped {
            changed |= func.blocks[block].end != end;
            func.blocks[block].end = end;
        }
    }
    changed
}

/// A block that heads a loop and goes on to the header of another has to stay.
fn keep_headers_of_nests(func: &Function, skippable: &mut EntityMap<Block, bool>) {
    let loops = Flow::of(func).loops;
    for data in loops.loops.values() {
        let mut targets = func.blocks[data.header].end.targets();
        if targets.any(|t| t.block != data.header && loops.is_header(t.block)) {
            skippable[data.header] = false;
        }
    }
}

/// A block whose parameters are used beyond its own jump has to stay.
fn keep_params_used_elsewhere(func: &Function, skippable: &mut EntityMap<Block, bool>) {
    let mut home = EntityMap::<Value, Option<Block>>::filled(func.values.len(), None);
    for &block in &func.layout {
        for &param in &func.blocks[block].params {
            home[param] = Some(block);
        }
    }
    for &block in &func.layout {
        let data = &func.blocks[block];
        let mut used = |value: Value| {
            if let Some(home) = home[value]
                && home != block
            {
                skippable[home] = false;
            }
        };
        for &inst in &data.insts {
            func.insts[inst].kind.for_each_use(&mut used);
        }
        data.end.for_each_use(used);
    }
}

/// Joins a block with the only one that jumps to it, where that goes nowhere else.
fn join(func: &mut Function) -> bool {
    let mut jumps = EntityMap::<Block, u32>::filled(func.blocks.len(), 0);
    for &block in &func.layout {
        for target in func.blocks[block].end.targets() {
            jumps[target.block] += 1;
        }
    }
    let mut renames = Renames::default();
    let mut gone = EntityMap::<Block, bool>::filled(func.blocks.len(), false);
    for i in 0..func.layout.len() {
        let block = func.layout[i];
        if gone[block] {
            continue;
        }
        while let Terminator::Jump(Target { block: next, args }) = &func.blocks[block].end {
            let next = *next;
            if jumps[next] != 1 || next == block || func.blocks[next].kernel.is_some() {
                break;
            }
            for (&param, &arg) in func.blocks[next].params.iter().zip(args) {
                renames.replace(param, renames.find(arg));
            }
            let data = std::mem::replace(&mut func.blocks[next], BlockData::unreachable());
            gone[next] = true;
            let into = &mut func.blocks[block];
            into.insts.extend(data.insts);
            into.end = data.end;
            into.end_pos = data.end_pos;
        }
    }
    func.layout.retain(|&block| !gone[block]);
    renames.apply(func);
    gone.values().any(|&gone| gone)
}

/// Drops the marks of blocks that no jump goes back to.
fn drop_marks(func: &mut Function, remarks: &mut Vec<Remark>) {
    if func.layout.iter().all(|&b| func.blocks[b].kernel.is_none()) {
        return;
    }
    let loops = Flow::of(func).loops;
    for &block in &func.layout {
        if !loops.is_header(block)
            && let Some(mark) = func.blocks[block].kernel.take()
        {
            remarks.push(Remark {
                pos: mark.pos,
                pass: "cfg",
                message: format!("{} is no loop: its body runs once at most", mark.name),
            });
        }
    }
}
