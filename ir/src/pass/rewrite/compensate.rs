//! Sums that a loop carries, compensated: beside the sum s runs a second one, c, of what each addition rounds away,
//! and where the sum is used, s + c is. Knuth's six operations find the rounding error exactly, without a comparison of
//! magnitudes; none of them lies on the way from one iteration's sum to the next's but the addition that was there.

use super::tree::{Made, operation};
use crate::flow::Flow;
use crate::program::*;
use srp_archdesc::isa::{Opcode, Ty};

/// A sum that a loop carries.
struct Carried {
    header: Block,
    /// Its place among the header's parameters.
    at: usize,
    /// Before an iteration's addition.
    before: Value,
    /// The addition, and its block.
    addition: Inst,
    block: Block,
    /// After it.
    after: Value,
    latch: Block,
}

/// Where the sums are that loops carry.
pub(super) fn places(func: &Function) -> Vec<Pos> {
    let sums = carried(func).into_iter();
    sums.map(|sum| func.insts[sum.addition].pos).collect()
}

/// Compensates the sums at the places that are wished for. Returns them.
pub(super) fn compensate(func: &mut Function, is_wished: &dyn Fn(Pos) -> bool) -> Vec<Pos> {
    let sums = carried(func).into_iter();
    let wished: Vec<Carried> = sums
        .filter(|sum| is_wished(func.insts[sum.addition].pos))
        .collect();
    wished
        .iter()
        .map(|sum| {
            compensate_sum(func, sum);
            func.insts[sum.addition].pos
        })
        .collect()
}

fn carried(func: &Function) -> Vec<Carried> {
    let made = Made::of(func);
    let mut found = Vec::new();
    for data in Flow::of(func).loops.loops.values() {
        let &[latch] = data.latches.as_slice() else {
            continue;
        };
        let header = data.header;
        let ends = &func.blocks[latch].end;
        let mut back = ends.targets().filter(|target| target.block == header);
        let (Some(back), None) = (back.next(), back.next()) else {
            continue;
        };
        let within = data.blocks.iter().copied();
        let within =
            within.flat_map(|block| func.blocks[block].insts.iter().map(move |&i| (block, i)));
        for (block, addition) in within {
            let Some(&after) = func.insts[addition].results.first() else {
                continue;
            };
            let Some(at) = back.args.iter().position(|&arg| arg == after) else {
                continue;
            };
            let before = func.blocks[header].params[at];
            let added = match operation(func, addition) {
                Some((Opcode::Fadd, &[a, b])) if a == before => b,
                Some((Opcode::Fadd, &[a, b])) if b == before => a,
                _ => continue,
            };
            // The sum of errors is no sum to compensate.
            let is_difference =
                |v: &Value| matches!(made.operation(func, *v), Some((Opcode::Fsub, _)));
            let is_error = match made.operation(func, added) {
                Some((Opcode::Fadd, parts)) => parts.iter().all(is_difference),
                _ => false,
            };
            let is_compensated = super::listed(func).any(|(_, inst)| {
                matches!(operation(func, inst), Some((Opcode::Fsub, &[a, b])) if a == after && b == before)
            });
            if added != before && !is_error && !is_compensated {
                found.push(Carried {
                    header,
                    at,
                    before,
                    addition,
                    block,
                    after,
                    latch,
                });
            }
        }
    }
    found
}

fn compensate_sum(func: &mut Function, sum: &Carried) {
    let &Carried {
        header,
        before,
        addition,
        block,
        after,
        latch,
        ..
    } = sum;
    let ty = func.values[before];
    let pos = func.insts[addition].pos;
    let Some((_, args)) = operation(func, addition) else {
        return;
    };
    let added = if args[0] == before { args[1] } else { args[0] };
    let (add, subtract) = match ty {
        Ty::Vec => (Opcode::Vfadd, Opcode::Vfsub),
        _ => (Opcode::Fadd, Opcode::Fsub),
    };
    // Users of the sum take the errors in. These come first: the error itself uses the bare sum.
    let lost_before = func.values.push(ty);
    let lost_after = func.values.push(ty);
    for user in func.layout.clone() {
        use_whole(
            func,
            user,
            sum,
            add,
            [(before, lost_before), (after, lost_after)],
        );
    }
    let mut made = Vec::new();
    let mut compute = |func: &mut Function, op: Opcode, args: [Value; 2]| {
        let args = args.to_vec();
        let inst = func.make_inst(InstKind::Op { op, args, imm: 0 }, &[ty], pos);
        made.push(inst);
        func.insts[inst].results[0]
    };
    let taken = compute(func, subtract, [after, before]);
    let kept = compute(func, subtract, [after, taken]);
    let lost_of_sum = compute(func, subtract, [before, kept]);
    let lost_of_added = compute(func, subtract, [added, taken]);
    let lost = compute(func, add, [lost_of_sum, lost_of_added]);
    compute(func, add, [lost_before, lost]);
    if let Some(&last) = made.last() {
        func.insts[last].results = vec![lost_after];
    }
    let place = func.blocks[block].insts.iter().position(|&i| i == addition);
    let place = place.map_or(func.blocks[block].insts.len(), |i| i + 1);
    func.blocks[block].insts.splice(place..place, made);
    func.blocks[header].params.push(lost_before);
    for from in func.layout.clone() {
        let is_back = from == latch;
        if !func.blocks[from].end.targets().any(|t| t.block == header) {
            continue;
        }
        let start = match is_back {
            true => lost_after,
            false => func.append_const(from, Bits::zero(ty), pos),
        };
        for target in func.blocks[from].end.targets_mut() {
            if target.block == header {
                target.args.push(start);
            }
        }
    }
}

/// Lets the instructions and the end of a block use the sums with their errors, but for the addition itself and
/// what it brings to the next iteration.
fn use_whole(
    func: &mut Function,
    block: Block,
    sum: &Carried,
    add: Opcode,
    sums: [(Value, Value); 2],
) {
    let mut out = Vec::new();
    let whole = |func: &mut Function, value: Value, pos: Pos, out: &mut Vec<Inst>| {
        let (bare, lost) = sums.into_iter().find(|(bare, _)| *bare == value)?;
        let args = vec![bare, lost];
        let ty = func.values[bare];
        let inst = func.make_inst(
            InstKind::Op {
                op: add,
                args,
                imm: 0,
            },
            &[ty],
            pos,
        );
        out.push(inst);
        Some(func.insts[inst].results[0])
    };
    for inst in std::mem::take(&mut func.blocks[block].insts) {
        if inst != sum.addition {
            let pos = func.insts[inst].pos;
            let mut used = Vec::new();
            func.insts[inst].kind.for_each_use(|v| used.push(v));
            for value in used {
                if let Some(new) = whole(func, value, pos, &mut out) {
                    let change = |v: &mut Value| {
                        if *v == value {
                            *v = new;
                        }
                    };
                    func.insts[inst].kind.for_each_use_mut(change);
                }
            }
        }
        out.push(inst);
    }
    let pos = func.blocks[block].end_pos;
    let mut end = func.blocks[block].end.clone();
    let back = (block == sum.latch).then_some(sum.header);
    for (bare, _) in sums {
        let is_used = |end: &Terminator| {
            let mut any = false;
            end.for_each_use(|v| any |= v == bare);
            any
        };
        if !is_used(&end) {
            continue;
        }
        let made = out.len();
        let Some(new) = whole(func, bare, pos, &mut out) else {
            continue;
        };
        let mut kept = end.clone();
        kept.for_each_use_mut(|v| {
            if *v == bare {
                *v = new;
            }
        });
        // The addition's own way back carries the bare sum.
        for target in kept.targets_mut().filter(|t| Some(t.block) == back) {
            if target.args[sum.at] == new {
                target.args[sum.at] = bare;
            }
        }
        let mut is_needed = false;
        kept.for_each_use(|v| is_needed |= v == new);
        if is_needed {
            end = kept;
        } else {
            out.truncate(made);
        }
    }
    func.blocks[block].end = end;
    func.blocks[block].insts = out;
}
