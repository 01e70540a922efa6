//! Loads at the head of a loop of what the iteration before has loaded or stored, from the address that is
//! now the loop's own: a parameter brings the value instead. In kernels [another pass](super::forward) does that.

use super::nearby::Facts;
use super::rename::Renames;
use crate::flow::{Cfg, Flow};
use crate::program::*;
use srp_archdesc::isa::{Effect, Opcode};

/// Blocks that are searched for a load, each the only one before the next.
const MAX_BEFORE: usize = 4;

/// Carries values that loops have loaded from one iteration to the next.
pub(crate) fn carry(func: &mut Function) -> bool {
    let Flow { cfg, loops, .. } = Flow::of(func);
    let facts = Facts::of(func);
    let mut renames = Renames::default();
    for data in loops.loops.values() {
        let header = data.header;
        if header == func.entry() || func.blocks[header].kernel.is_some() {
            continue;
        }
        for inst in func.blocks[header].insts.clone() {
            let kind = &func.insts[inst].kind;
            if let InstKind::Op { op, args, imm } = kind
                && op.info().effect == Effect::Load
                && facts.truths.contains(&args[0])
                && let Some(found) = arriving(func, &cfg, &facts, header, (*op, args[1], *imm))
            {
                let result = func.insts[inst].results[0];
                bring(func, header, result, &found, &mut renames);
                func.blocks[header].insts.retain(|&i| i != inst);
            } else if writes(kind) {
                break;
            }
        }
    }
    let changed = !renames.is_empty();
    renames.apply(func);
    changed
}

/// True if an instruction may write memory.
pub(super) fn writes(kind: &InstKind) -> bool {
    match kind {
        InstKind::Op { op, .. } => matches!(op.info().effect, Effect::Store | Effect::Io),
        InstKind::Call { .. } | InstKind::Launch { .. } => true,
        _ => false,
    }
}

/// An address as the sum of values and a constant.
pub(super) type Place = (Vec<Value>, u32);

/// For each way into a block, in the order of the predecessors, the value at an address that the block
/// loads first; `None` if that is not known on all ways.
fn arriving(
    func: &Function,
    cfg: &Cfg,
    facts: &Facts,
    block: Block,
    (op, address, imm): (Opcode, Value, i32),
) -> Option<Vec<(Block, Value)>> {
    let (terms, offset) = loop_place(func, facts, block, address)?;
    let mut found = Vec::new();
    for &pred in &cfg.preds[block] {
        let place = arriving_from(func, facts, block, pred, &terms, offset, imm)?;
        found.push((pred, held(func, cfg, facts, pred, op, &place)?));
    }
    Some(found)
}

/// The place of an address that a block changes, where it is a sum of the block's parameters and of what does not
/// change in its loop.
pub(super) fn loop_place(
    func: &Function,
    facts: &Facts,
    block: Block,
    address: Value,
) -> Option<Place> {
    let (terms, offset) = facts.terms(address);
    let params = &func.blocks[block].params;
    // Only what the loop changes is worth a parameter.
    terms.iter().find(|v| params.contains(v))?;
    let insts = func.blocks[block].insts.iter();
    let own: Vec<Value> = insts
        .flat_map(|&i| func.insts[i].results.iter().copied())
        .collect();
    let computed = terms.iter().any(|v| own.contains(v) && !params.contains(v));
    (!computed).then_some((terms, offset))
}

/// The state of a place in a block before the block is entered from another.
pub(super) fn arriving_from(
    func: &Function,
    facts: &Facts,
    block: Block,
    pred: Block,
    terms: &[Value],
    offset: u32,
    imm: i32,
) -> Option<Place> {
    let params = &func.blocks[block].params;
    let mut ways = func.blocks[pred].end.targets().filter(|t| t.block == block);
    let way = ways.next()?;
    if ways.next().is_some() {
        return None;
    }
    let mut place = (Vec::new(), offset.wrapping_add_signed(imm));
    for &term in terms {
        let at = params.iter().position(|&p| p == term);
        let (more, plus) = facts.terms(at.map_or(term, |at| way.args[at]));
        place.0.extend(more);
        place.1 = place.1.wrapping_add(plus);
    }
    place.0.sort_unstable();
    Some(place)
}

/// The value that a load at a place would find at the end of a block.
fn held(
    func: &Function,
    cfg: &Cfg,
    facts: &Facts,
    mut block: Block,
    wanted: Opcode,
    place: &Place,
) -> Option<Value> {
    for _ in 0..MAX_BEFORE {
        for &inst in func.blocks[block].insts.iter().rev() {
            let data = &func.insts[inst];
            if let InstKind::Op { op, args, imm } = &data.kind
                && op.access_bytes().is_some()
                && facts.truths.contains(&args[0])
            {
                let (terms, offset) = facts.terms(args[1]);
                let here = (terms, offset.wrapping_add_signed(*imm));
                match op {
                    _ if here != *place => {}
                    Opcode::Sw if wanted == Opcode::Lw => return Some(args[2]),
                    _ if *op == wanted => return data.results.first().copied(),
                    _ => {}
                }
            }
            if writes(&data.kind) {
                return None;
            }
        }
        let [before] = cfg.preds[block][..] else {
            return None;
        };
        block = before;
    }
    None
}

/// Gives a block a parameter in the place of a value.
pub(super) fn bring(
    func: &mut Function,
    block: Block,
    value: Value,
    found: &[(Block, Value)],
    renames: &mut Renames,
) {
    let param = func.add_param(block, func.values[value]);
    for &(pred, arriving) in found {
        for target in func.blocks[pred].end.targets_mut() {
            if target.block == block {
                target.args.push(arriving);
            }
        }
    }
    renames.replace(value, param);
}
