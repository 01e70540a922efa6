//! If-conversion: the body of a kernel loop without branches.
//!
//! Everything in the body runs in every iteration. Where ways through the body meet again, values
//! are selected by the predicates of the ways; loads, stores and divisions, which must not happen on
//! a way not taken, get the predicate into their guard.

use super::Remark;
use super::cfg::remove_unreached;
use super::rename::Renames;
use crate::flow::{Flow, LoopData};
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Effect, Opcode, Ty};

mod ahead;
mod at;
mod counted;
mod estimate;
mod exits;
mod latches;
mod limit;
mod predicates;

use exits::{Free, run_in_chunks};
use predicates::{Edge, Ways};

/// Makes each marked loop one block that jumps back to itself or out. Where that cannot be, the
/// loop stays as it is, and a remark says why: a loop inside it, a way out that is not its test at
/// the end, a call, a port.
pub(crate) fn ifconvert(
    func: &mut Function,
    globals: &EntityMap<Global, GlobalData>,
) -> Vec<Remark> {
    let mut remarks = Vec::new();
    if func.layout.iter().all(|&b| func.blocks[b].kernel.is_none()) {
        return remarks;
    }
    // A block that nothing reaches may still lead into a loop that becomes one block.
    remove_unreached(func);
    latches::join(func);
    let free = run_in_chunks(func, globals);
    let flow = Flow::of(func);
    let mut renames = Renames::default();
    for (id, data) in flow.loops.loops.iter() {
        let Some(mark) = &func.blocks[data.header].kernel else {
            continue;
        };
        let inner = flow.loops.inside(id).next().map(|(_, inner)| inner);
        match obstacle(func, data, inner) {
            Some((pos, why)) => remarks.push(Remark {
                pos,
                pass: "ifconvert",
                message: format!("kernel {} stays on the VLIW engine: {why}", mark.name),
            }),
            None if data.blocks.len() > 1 => {
                let ways = Ways::of(func, &flow, data);
                to_one_block(func, ways, data, &free, &mut renames);
            }
            None => {}
        }
    }
    renames.apply(func);
    remarks
}

/// Why a loop cannot be made one block, and where.
fn obstacle(
    func: &Function,
    data: &LoopData,
    inner: Option<&LoopData>,
) -> Option<(Pos, &'static str)> {
    if let Some(inner) = inner {
        let header = &func.blocks[inner.header];
        let latch = inner.latches.first().copied().unwrap_or(inner.header);
        let pos = match &header.kernel {
            Some(mark) => mark.pos,
            None => func.blocks[latch].end_pos,
        };
        return Some((
            pos,
            "there is a loop inside it; unroll that one, or mark it instead",
        ));
    }
    for &block in &data.blocks {
        for &inst in &func.blocks[block].insts {
            let InstData { kind, pos, .. } = &func.insts[inst];
            match kind {
                InstKind::Call { .. } | InstKind::Launch { .. } => {
                    return Some((*pos, "it calls a function that is not inlined"));
                }
                InstKind::Op { op, .. } if op.info().effect == Effect::Io => {
                    return Some((*pos, "it uses a port, which the array cannot"));
                }
                _ => {}
            }
        }
    }
    let [latch] = data.latches[..] else {
        let pos = func.blocks[data.header].end_pos;
        return Some((pos, "its iterations end in several places"));
    };
    for &block in &data.blocks {
        let leaves = data.is_left_at(func, block);
        let end_pos = func.blocks[block].end_pos;
        if block != latch && leaves {
            let why = "an iteration can leave it in the middle (break, return, or a test at the \
                       top); compute a condition instead and go on with what follows under it";
            return Some((end_pos, why));
        }
        if block == latch && !leaves {
            return Some((end_pos, "it has no end"));
        }
    }
    None
}

/// Puts all blocks of a loop into its header.
fn to_one_block(
    func: &mut Function,
    mut ways: Ways,
    data: &LoopData,
    free: &Free,
    renames: &mut Renames,
) {
    let mut insts = Vec::new();
    for &block in &data.blocks {
        if block != data.header {
            let header = data.header;
            merge_params(func, &mut ways, (header, block), free, &mut insts, renames);
        }
        let guard = ways.from(func, data.header, block, &mut insts);
        for inst in std::mem::take(&mut func.blocks[block].insts) {
            if let Some(guard) = guard {
                add_guard(func, inst, guard, &mut insts);
            }
            insts.push(inst);
        }
    }
    let latch = data.latches[0];
    let end = std::mem::replace(&mut func.blocks[latch].end, Terminator::Unreachable);
    let end_pos = func.blocks[latch].end_pos;
    let header = &mut func.blocks[data.header];
    header.insts = insts;
    header.end = end;
    header.end_pos = end_pos;
    let mut gone = EntityMap::<Block, bool>::filled(func.blocks.len(), false);
    data.blocks[1..]
        .iter()
        .for_each(|&block| gone[block] = true);
    func.layout.retain(|&block| !gone[block]);
}

/// Selects the values of a block's parameters by the ways into it.
fn merge_params(
    func: &mut Function,
    ways: &mut Ways,
    (header, block): (Block, Block),
    free: &Free,
    insts: &mut Vec<Inst>,
    renames: &mut Renames,
) {
    let edges = ways.edges_into(block).to_vec();
    // The header's own test may come from the iteration before, which then waits for what it decides: it comes last.
    let past = ways.past_the_body(func, header, &edges);
    let rest: Vec<Edge> = (edges.iter().enumerate())
        .filter(|(i, _)| past.is_none_or(|past| *i != past.edge))
        .map(|(_, edge)| edge.clone())
        .collect();
    let costs: Vec<u32> = rest.iter().map(|edge| ways.cost(block, edge)).collect();
    let mut taken = vec![None; rest.len()];
    for (place, param) in func.blocks[block].params.clone().into_iter().enumerate() {
        let ty = func.values[param];
        if let Some(edge) = ways.only_true(func, &edges, place) {
            let taken = ways.taken_last(func, header, edge, insts);
            renames.replace(param, taken);
            continue;
        }
        let matters = |edge: &Edge| !free.contains(&(edge.from, block, place));
        let brought: Vec<(usize, Value)> = (rest.iter().enumerate())
            .filter(|(_, edge)| matters(edge))
            .map(|(i, edge)| (i, renames.find(edge.args[place])))
            .collect();
        // The value is left over whose ways have predicates that take most to compute, all of them together.
        let cost = |value: Value| -> u64 {
            let ways = brought.iter().filter(|(_, other)| *other == value);
            ways.map(|&(i, _)| u64::from(costs[i])).sum()
        };
        let values = brought.iter().map(|&(_, value)| value);
        let left = values.max_by_key(|&value| cost(value));
        let mut value = left;
        for &(i, other) in brought.iter().filter(|(_, other)| Some(*other) != left) {
            let edge = &rest[i];
            let taken = *taken[i].get_or_insert_with(|| match past {
                Some(past) => ways.along(func, past.body, edge, insts),
                None => ways.taken(func, block, edge, insts),
            });
            value = match (taken, value) {
                (Some(taken), Some(value)) => {
                    let args = vec![taken, other, value];
                    Some(push_op(func, insts, Opcode::select(ty), args, edge.pos))
                }
                _ => Some(other),
            };
        }
        if let Some(past) = past {
            let edge = &edges[past.edge];
            let other = renames.find(edge.args[place]);
            value = match value {
                Some(value) if other != value && matters(edge) => {
                    let args = match past.sense {
                        true => vec![past.cond, other, value],
                        false => vec![past.cond, value, other],
                    };
                    Some(push_op(func, insts, Opcode::select(ty), args, edge.pos))
                }
                value => value.or(Some(other)),
            };
        }
        // Where no way matters, any value does.
        let value = value.unwrap_or_else(|| renames.find(edges[0].args[place]));
        renames.replace(param, value);
    }
}

/// Lets an instruction that has a guard do something only under `guard`.
fn add_guard(func: &mut Function, inst: Inst, guard: Value, insts: &mut Vec<Inst>) {
    let InstKind::Op { op, args, .. } = &func.insts[inst].kind else {
        return;
    };
    if !op.is_guarded() {
        return;
    }
    let own = args[0];
    let pos = func.insts[inst].pos;
    let both = push_op(func, insts, Opcode::Pand, vec![guard, own], pos);
    if let InstKind::Op { args, .. } = &mut func.insts[inst].kind {
        args[0] = both;
    }
}

fn push_op(
    func: &mut Function,
    insts: &mut Vec<Inst>,
    op: Opcode,
    args: Vec<Value>,
    pos: Pos,
) -> Value {
    let ty: Option<Ty> = op.result();
    let inst = func.make_inst(InstKind::Op { op, args, imm: 0 }, ty.as_slice(), pos);
    insts.push(inst);
    func.insts[inst].results[0]
}
