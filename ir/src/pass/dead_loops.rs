//! Loops that do nothing: without effects, with no value that is used behind them, and with a test that
//! certainly ends them.

use super::defs::Defs;
use super::preheader;
use super::trip::trip;
use crate::flow::{Dominators, Flow, LoopData};
use crate::program::*;
use rustc_hash::FxHashSet;
use srp_archdesc::arch::Precision;
use srp_archdesc::isa::{Effect, Opcode};
use std::cell::LazyCell;

/// Iterations up to which a number is looked for.
const MAX_TRIP: u32 = 4096;

/// Lets control go past the loops that do nothing.
pub(crate) fn dead_loops(func: &mut Function, precision: &Precision) -> bool {
    let mut changed = false;
    while let Some((before, exit)) = dead_loop(func, precision) {
        func.blocks[before].end = Terminator::Jump(exit);
        super::cfg::remove_unreached(func);
        changed = true;
    }
    changed
}

/// A block that jumps to a loop that does nothing, and where that goes.
fn dead_loop(func: &Function, precision: &Precision) -> Option<(Block, Target)> {
    let Flow {
        cfg,
        dominators,
        loops,
    } = Flow::of(func);
    let defs = LazyCell::new(|| Defs::of(func));
    loops.loops.iter().find_map(|(id, data)| {
        let before = preheader::find(func, &cfg, data)?;
        let made = made(func, data)?;
        let exit = exit(func, data, &made)?;
        let ends = || {
            trip(func, &dominators, data, MAX_TRIP, precision).is_some()
                || counts(func, &defs, data, &dominators, &made)
        };
        (loops.is_innermost(id) && !used_outside(func, data, &made) && ends())
            .then_some((before, exit))
    })
}

/// The values that a loop makes; `None` if it does something else.
fn made(func: &Function, data: &LoopData) -> Option<FxHashSet<Value>> {
    let mut made = FxHashSet::default();
    for &block in &data.blocks {
        made.extend(&func.blocks[block].params);
        for &inst in &func.blocks[block].insts {
            let InstData { kind, results, .. } = &func.insts[inst];
            match kind {
                InstKind::Call { .. } | InstKind::Launch { .. } => return None,
                InstKind::Op { op, .. }
                    if matches!(
                        op.info().effect,
                        Effect::Store | Effect::Prefetch | Effect::Io
                    ) =>
                {
                    return None;
                }
                _ => made.extend(results),
            }
        }
    }
    Some(made)
}

/// Where a loop goes in the end, if that is one place, to which it brings nothing that it made.
fn exit(func: &Function, data: &LoopData, made: &FxHashSet<Value>) -> Option<Target> {
    let mut exits = data.exits(func).map(|(_, target)| target);
    let exit = exits.next()?;
    let one = exits.all(|other| other == exit);
    (one && exit.args.iter().all(|v| !made.contains(v))).then(|| exit.clone())
}

fn used_outside(func: &Function, data: &LoopData, made: &FxHashSet<Value>) -> bool {
    let mut used = false;
    for &block in func.layout.iter().filter(|&&b| !data.contains(b)) {
        for &inst in &func.blocks[block].insts {
            func.insts[inst]
                .kind
                .for_each_use(|v| used |= made.contains(&v));
        }
        let end = &func.blocks[block].end;
        end.for_each_use(|v| used |= made.contains(&v));
    }
    used
}

/// True if every iteration compares what grows by one with a limit that stays: sooner or later any number
/// is reached.
fn counts(
    func: &Function,
    defs: &Defs,
    data: &LoopData,
    dominators: &Dominators,
    made: &FxHashSet<Value>,
) -> bool {
    let [latch] = data.latches[..] else {
        return false;
    };
    let is_one = |v: Value| defs.word(func, v) == Some(1);
    let next = |param: Value| {
        let place = func.blocks[data.header].params.iter();
        let place = place.into_iter().position(|&p| p == param)?;
        let mut backs = func.blocks[latch].end.targets();
        let mut backs = backs.by_ref().filter(|t| t.block == data.header);
        let back = backs.next()?;
        backs.next().is_none().then(|| back.args[place])
    };
    let grows = |value: Value, from: Value| match defs.op(func, value) {
        Some((Opcode::Add, &[a, b])) => a == from && is_one(b) || b == from && is_one(a),
        _ => false,
    };
    let counter = |value: Value| {
        let params = &func.blocks[data.header].params;
        params
            .iter()
            .any(|&p| next(p).is_some_and(|next| grows(next, p) && (value == p || value == next)))
    };
    data.blocks.iter().any(|&block| {
        let Terminator::Branch { cond, then, .. } = &func.blocks[block].end else {
            return false;
        };
        let ends = data.is_left_at(func, block);
        let Some((op, args)) = defs.op(func, *cond) else {
            return false;
        };
        let stays = match data.contains(then.block) {
            true => matches!(op, Opcode::Lt | Opcode::Ltu | Opcode::Ne),
            false => op == Opcode::Eq,
        };
        let limit = args.get(1).is_some_and(|limit| !made.contains(limit));
        ends && stays && limit && dominators.dominates(block, latch) && counter(args[0])
    })
}
