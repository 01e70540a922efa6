//! Loads in kernels of what the iteration before has stored: a parameter brings the value instead, which takes the way
//! through memory out of a recurrence.
//!
//! Values that were only loaded are loaded again, for more values on their way from iteration to iteration would take registers. The
//! first iteration gets its value from a load before the loop.

use super::carry::{Place, arriving_from, bring, loop_place, writes};
use super::gvn::returns;
use super::narrow::Narrow;
use super::nearby::Facts;
use super::preheader::{self, with_preheaders};
use super::rename::Renames;
use crate::flow::{Flow, LoopData};
use crate::program::*;
use srp_archdesc::isa::{Effect, Opcode, Space, Ty};

/// Stores under predicates that are looked through for what was there before.
const MAX_OVER: usize = 4;

/// Carries values that kernels have stored from one iteration to the next.
pub(crate) fn forward(func: &mut Function) -> bool {
    let is_kernel = |func: &Function, data: &LoopData| {
        func.blocks[data.header].kernel.is_some() && data.blocks.len() == 1
    };
    if (func.layout.iter()).all(|&block| func.blocks[block].kernel.is_none()) {
        return false;
    }
    let Flow { cfg, loops, .. } = with_preheaders(func);
    let facts = Facts::of(func);
    let mut renames = Renames::default();
    for data in loops.loops.values() {
        if !is_kernel(func, data) {
            continue;
        }
        let header = data.header;
        let Some(before) = preheader::find(func, &cfg, data) else {
            continue;
        };
        for inst in func.blocks[header].insts.clone() {
            let InstData { kind, results, pos } = func.insts[inst].clone();
            if let InstKind::Op { op, args, imm } = &kind
                && op.space() == Some(Space::Sram)
                && op.result() == Some(Ty::Word)
                && facts.truths.contains(&args[0])
                && let Some((terms, offset)) = loop_place(func, &facts, header, args[1])
                && let Some(place) =
                    arriving_from(func, &facts, header, header, &terms, offset, *imm)
                && let Some(left) = left(func, &facts, header, *op, &place)
                && let Some(first) =
                    arriving_from(func, &facts, header, before, &terms, offset, *imm)
            {
                let loaded = load_before(func, before, *op, &first, pos);
                let brought = left.build(func, header, pos);
                let found = [(header, brought), (before, loaded)];
                bring(func, header, results[0], &found, &mut renames);
                func.blocks[header].insts.retain(|&i| i != inst);
            } else if writes(&kind) {
                break;
            }
        }
    }
    let changed = !renames.is_empty();
    renames.apply(func);
    changed
}

/// Loads what is at a place at the end of a block.
fn load_before(
    func: &mut Function,
    block: Block,
    load: Opcode,
    (terms, offset): &Place,
    pos: Pos,
) -> Value {
    let mut address = func.append_const(block, Bits::Word(*offset), pos);
    for &term in terms {
        let sum = func.append_op(block, Opcode::Add, &[term, address], 0, pos);
        address = sum.expect("a sum has a result");
    }
    let always = func.append_const(block, Bits::Pred(true), pos);
    let loaded = func.append_op(block, load, &[always, address], 0, pos);
    loaded.expect("a load has a result")
}

/// The value that an iteration leaves at a place.
struct Left {
    /// The value that was surely loaded or stored there, and the type that a load extends from its low bits.
    value: (Value, Option<Narrow>),
    /// The predicates of the stores since then, and what they have stored, the last one first.
    over: Vec<(Value, (Value, Option<Narrow>))>,
}

impl Left {
    /// Makes instructions at the end of a block that give what a load finds; returns the result.
    fn build(self, func: &mut Function, block: Block, pos: Pos) -> Value {
        let extended = |func: &mut Function, (value, narrow): (Value, Option<Narrow>)| {
            let Some(narrow) = narrow else {
                return value;
            };
            let (insts, value) = narrow.extend(func, value, pos);
            func.blocks[block].insts.extend(insts);
            value
        };
        let mut value = extended(func, self.value);
        for (guard, stored) in self.over.into_iter().rev() {
            let stored = extended(func, stored);
            let selected = func.append_op(block, Opcode::Sel, &[guard, stored, value], 0, pos);
            value = selected.expect("a selection has a result");
        }
        value
    }
}

/// The value that an iteration leaves for a load at a place, if one of its stores surely wrote that, or one of its loads surely read it
/// before stores under predicates.
fn left(func: &Function, facts: &Facts, block: Block, load: Opcode, place: &Place) -> Option<Left> {
    let mut over = Vec::new();
    for &inst in func.blocks[block].insts.iter().rev() {
        let InstData { kind, results, .. } = &func.insts[inst];
        let (op, args, imm) = match kind {
            InstKind::Op { op, args, imm } if op.space() == load.space() => (op, args, imm),
            // The other memory has other bytes.
            InstKind::Op { op, .. } if op.info().effect != Effect::Io => continue,
            kind if writes(kind) => return None,
            _ => continue,
        };
        let effect = op.info().effect;
        let (terms, offset) = facts.terms(args[1]);
        let offset = offset.wrapping_add_signed(*imm);
        let is_sure = facts.truths.contains(&args[0]);
        if (&terms, offset) == (&place.0, place.1) {
            match (effect, returns(*op, load)) {
                // Only what is stored can be worth a way around memory.
                (Effect::Load, _) if over.is_empty() => {}
                (Effect::Load, Some(narrow)) if is_sure => {
                    let value = (*results.first()?, narrow);
                    return Some(Left { value, over });
                }
                (Effect::Store, Some(narrow)) if is_sure => {
                    let value = (args[2], narrow);
                    return Some(Left { value, over });
                }
                (Effect::Store, Some(narrow)) if over.len() < MAX_OVER => {
                    over.push((args[0], (args[2], narrow)));
                }
                (Effect::Store, _) => return None,
                _ => {}
            }
        } else if effect == Effect::Store {
            // Beside it, by a constant.
            let (from, bytes) = (offset.wrapping_sub(place.1), op.access_bytes()?);
            let is_beside = from >= load.access_bytes()? && from.wrapping_neg() >= bytes;
            if terms != place.0 || !is_beside {
                return None;
            }
        }
    }
    None
}
