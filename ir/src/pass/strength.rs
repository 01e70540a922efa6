//! Strength reduction of addresses: in a loop of one block, `base + i · stride` becomes a value that
//! advances by the stride, so that an iteration takes one addition for all accesses beside each
//! other, and the constants between them go into their immediates.

use super::preheader::{find, with_preheaders};
use crate::flow::LoopData;
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Opcode, Ty};
use std::collections::BTreeMap;

mod linear;

use linear::{Linear, Linearity};

/// Gives the addresses of loads and stores in loops of one block values of their own that advance
/// with the loop, where that makes the loop shorter.
pub fn strength(func: &mut Function) -> bool {
    let (cfg, _, loops) = with_preheaders(func);
    let mut changed = false;
    for data in loops.loops.values() {
        if data.blocks.len() == 1 {
            let before = find(func, &cfg, data).expect("every loop was given a preheader");
            changed |= reduce(func, data, before);
        }
    }
    changed
}

/// Addresses that differ by constants: induction variable and its scale, and what does not change
/// in the loop.
type Group = (Value, u32, Vec<(Value, u32)>);

/// An access, the group of its address, and the constant that is left.
struct Use {
    inst: Inst,
    group: Group,
    constant: u32,
}

fn reduce(func: &mut Function, data: &LoopData, before: Block) -> bool {
    let header = data.header;
    let linearity = Linearity::of(func, header);
    let uses = uses(func, header, &linearity);
    let mut pointers = BTreeMap::<Group, Option<Value>>::new();
    for item in &uses {
        let (iv, scale, invariant) = &item.group;
        let itself = (*scale == 1 && invariant.is_empty()).then_some(*iv);
        pointers.insert(item.group.clone(), itself);
    }
    let added = pointers.values().filter(|p| p.is_none()).count();
    if uses.is_empty() || removed(func, header, &uses) <= added {
        return false;
    }
    for (group, pointer) in &mut pointers {
        if pointer.is_none() {
            let step = linearity.step(group.0).wrapping_mul(group.1);
            *pointer = Some(add_pointer(func, header, before, group, step));
        }
    }
    for Use {
        inst,
        group,
        constant,
    } in uses
    {
        if let InstKind::Op { args, imm, .. } = &mut func.insts[inst].kind
            && let Some(pointer) = pointers[&group]
        {
            args[1] = pointer;
            *imm = imm.wrapping_add_unsigned(constant);
        }
    }
    true
}

/// The accesses whose address advances with the loop and is computed in it.
fn uses(func: &Function, header: Block, linearity: &Linearity) -> Vec<Use> {
    let mut uses = Vec::new();
    for &inst in &func.blocks[header].insts {
        let InstKind::Op { op, args, .. } = &func.insts[inst].kind else {
            continue;
        };
        if op.access_bytes().is_none() || func.blocks[header].params.contains(&args[1]) {
            continue;
        }
        if let Some(Linear {
            iv: Some((iv, scale)),
            invariant,
            constant,
        }) = linearity.get(args[1])
        {
            let group = (*iv, *scale, invariant.clone());
            let constant = *constant;
            uses.push(Use {
                inst,
                group,
                constant,
            });
        }
    }
    uses
}

/// How many instructions of the block nothing needs once the addresses are computed otherwise.
fn removed(func: &Function, block: Block, uses: &[Use]) -> usize {
    let mut defs = BTreeMap::new();
    let mut count = EntityMap::<Value, u32>::filled(func.values.len(), 0);
    for &at in &func.layout {
        for &inst in &func.blocks[at].insts {
            func.insts[inst].kind.for_each_use(|v| count[v] += 1);
        }
        func.blocks[at].end.for_each_use(|v| count[v] += 1);
    }
    for &inst in &func.blocks[block].insts {
        let data = &func.insts[inst];
        if data.kind.is_pure() {
            defs.insert(data.results[0], inst);
        }
    }
    let mut work: Vec<Value> = uses
        .iter()
        .filter_map(|item| func.insts[item.inst].kind.args().get(1).copied())
        .collect();
    let mut removed = 0;
    while let Some(value) = work.pop() {
        count[value] -= 1;
        if count[value] == 0
            && let Some(&inst) = defs.get(&value)
        {
            // Constants cost nothing.
            removed += usize::from(matches!(func.insts[inst].kind, InstKind::Op { .. }));
            func.insts[inst].kind.for_each_use(|v| work.push(v));
        }
    }
    removed
}

/// Adds a parameter to the loop that is the address of a group in each iteration.
fn add_pointer(
    func: &mut Function,
    header: Block,
    before: Block,
    (iv, scale, invariant): &Group,
    step: u32,
) -> Value {
    let pos = func.blocks[header].end_pos;
    let place = func.blocks[header].params.iter().position(|p| p == iv);
    let place = place.expect("an induction variable is a parameter of its loop");
    let first = match &func.blocks[before].end {
        Terminator::Jump(target) => target.args[place],
        _ => unreachable!("a preheader ends in a jump"),
    };
    let mut start = scaled(func, before, first, *scale, pos);
    for &(value, scale) in invariant {
        let part = scaled(func, before, value, scale, pos);
        start = append(func, before, Opcode::Add, &[start, part], pos);
    }
    let pointer = func.add_param(header, Ty::Word);
    let step = func.append_const(before, Bits::Word(step), pos);
    let next = append(func, header, Opcode::Add, &[pointer, step], pos);
    for (block, arg) in [(before, start), (header, next)] {
        for target in func.blocks[block].end.targets_mut() {
            if target.block == header {
                target.args.push(arg);
            }
        }
    }
    pointer
}

fn scaled(func: &mut Function, block: Block, value: Value, scale: u32, pos: Pos) -> Value {
    if scale == 1 {
        return value;
    }
    let (op, by) = match scale.is_power_of_two() {
        true => (Opcode::Shl, scale.trailing_zeros()),
        false => (Opcode::Mul, scale),
    };
    let by = func.append_const(block, Bits::Word(by), pos);
    append(func, block, op, &[value, by], pos)
}

fn append(func: &mut Function, block: Block, op: Opcode, args: &[Value], pos: Pos) -> Value {
    let value = func.append_op(block, op, args, 0, pos);
    value.expect("arithmetic has a result")
}
