//! Strength reduction of addresses: in a loop of one block, `base + i · stride` becomes a value that
//! advances by the stride, so that an iteration takes one addition for all accesses beside each
//! other, and the constants between them go into their immediates.

use super::preheader::{find, with_preheaders};
use crate::flow::Flow;
use crate::flow::LoopData;
use crate::program::*;
use rustc_hash::FxHashMap;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Opcode, Ty};
use std::collections::BTreeMap;

mod linear;

use linear::Linear;
pub(super) use linear::Linearity;

/// Gives the addresses of loads and stores in loops of one block values of their own that advance
/// with the loop, where that makes the loop shorter.
pub(crate) fn strength(func: &mut Function) -> bool {
    let Flow { cfg, loops, .. } = with_preheaders(func);
    if loops.loops.values().all(|data| data.blocks.len() > 1) {
        return false;
    }
    let mut counts = Counts::of(func);
    let mut changed = false;
    for data in loops.loops.values() {
        if data.blocks.len() == 1 {
            let before = find(func, &cfg, data).expect("every loop was given a preheader");
            changed |= reduce(func, data, before, &mut counts);
        }
    }
    changed
}

/// Counts for all loops of a function, updated as the loops change.
struct Counts {
    /// The words that are constants.
    constants: FxHashMap<Value, u32>,
    /// How often each value is used.
    uses: EntityMap<Value, u32>,
}

impl Counts {
    fn of(func: &Function) -> Counts {
        let mut counts = Counts {
            constants: FxHashMap::default(),
            uses: EntityMap::filled(func.values.len(), 0),
        };
        for &block in &func.layout {
            for &inst in &func.blocks[block].insts {
                let data = &func.insts[inst];
                if let InstKind::Const(Bits::Word(word)) = data.kind {
                    counts.constants.insert(data.results[0], word);
                }
                data.kind.for_each_use(|v| counts.uses[v] += 1);
            }
            func.blocks[block].end.for_each_use(|v| counts.uses[v] += 1);
        }
        counts
    }

    /// Notes uses of values, which may be new.
    fn used(&mut self, values: &[Value]) {
        for &value in values {
            while self.uses.len() <= value.index() {
                self.uses.push(0);
            }
            self.uses[value] += 1;
        }
    }
}

/// Addresses that differ by constants: induction variable and its scale, and the invariant terms.
type Group = (Value, u32, Vec<(Value, u32)>);

/// An access, the group of its address, and the constant that is left.
struct Use {
    inst: Inst,
    group: Group,
    constant: u32,
}

fn reduce(func: &mut Function, data: &LoopData, before: Block, counts: &mut Counts) -> bool {
    let header = data.header;
    let linearity = Linearity::of(func, header, &counts.constants);
    let uses = uses(func, header, &linearity);
    let mut pointers = BTreeMap::<Group, Option<Value>>::new();
    for item in &uses {
        let (iv, scale, invariant) = &item.group;
        let itself = (*scale == 1 && invariant.is_empty()).then_some(*iv);
        pointers.insert(item.group.clone(), itself);
    }
    let added = pointers.values().filter(|p| p.is_none()).count();
    if uses.is_empty() || removed(func, header, &uses, &counts.uses) <= added {
        return false;
    }
    for (group, pointer) in &mut pointers {
        if pointer.is_none() {
            let step = linearity.step(group.0).wrapping_mul(group.1);
            *pointer = Some(Appender { func, counts }.pointer(header, before, group, step));
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
            counts.uses[args[1]] -= 1;
            counts.used(&[pointer]);
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
fn removed(func: &Function, block: Block, uses: &[Use], count: &EntityMap<Value, u32>) -> usize {
    let mut defs = BTreeMap::new();
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
    let mut gone = FxHashMap::<Value, u32>::default();
    while let Some(value) = work.pop() {
        let gone = gone.entry(value).or_insert(0);
        *gone += 1;
        if count[value] == *gone
            && let Some(&inst) = defs.get(&value)
        {
            // Constants cost nothing.
            removed += usize::from(matches!(func.insts[inst].kind, InstKind::Op { .. }));
            func.insts[inst].kind.for_each_use(|v| work.push(v));
        }
    }
    removed
}

/// Adds instructions to a function and counts them.
struct Appender<'a> {
    func: &'a mut Function,
    counts: &'a mut Counts,
}

impl Appender<'_> {
    /// Adds a parameter to the loop that is the address of a group in each iteration.
    fn pointer(
        &mut self,
        header: Block,
        before: Block,
        (iv, scale, invariant): &Group,
        step: u32,
    ) -> Value {
        let pos = self.func.blocks[header].end_pos;
        let params = &self.func.blocks[header].params;
        let place = params.iter().position(|p| p == iv);
        let place = place.expect("an induction variable is a parameter of its loop");
        let first = match &self.func.blocks[before].end {
            Terminator::Jump(target) => target.args[place],
            _ => unreachable!("a preheader ends in a jump"),
        };
        let mut start = self.scaled(before, first, *scale, pos);
        for &(value, scale) in invariant {
            let part = self.scaled(before, value, scale, pos);
            start = self.op(before, Opcode::Add, &[start, part], pos);
        }
        let pointer = self.func.add_param(header, Ty::Word);
        let step = self.constant(before, step, pos);
        let next = self.op(header, Opcode::Add, &[pointer, step], pos);
        for (block, arg) in [(before, start), (header, next)] {
            for target in self.func.blocks[block].end.targets_mut() {
                if target.block == header {
                    target.args.push(arg);
                    self.counts.used(&[arg]);
                }
            }
        }
        pointer
    }

    fn scaled(&mut self, block: Block, value: Value, scale: u32, pos: Pos) -> Value {
        if scale == 1 {
            return value;
        }
        let (op, by) = match scale.is_power_of_two() {
            true => (Opcode::Shl, scale.trailing_zeros()),
            false => (Opcode::Mul, scale),
        };
        let by = self.constant(block, by, pos);
        self.op(block, op, &[value, by], pos)
    }

    fn constant(&mut self, block: Block, word: u32, pos: Pos) -> Value {
        let value = self.func.append_const(block, Bits::Word(word), pos);
        self.counts.constants.insert(value, word);
        value
    }

    fn op(&mut self, block: Block, op: Opcode, args: &[Value], pos: Pos) -> Value {
        self.counts.used(args);
        let value = self.func.append_op(block, op, args, 0, pos);
        value.expect("arithmetic has a result")
    }
}
