//! Values kept in stack slots, which [`mem2reg`](super::mem2reg) makes values again: so control flow can be
//! changed without a thought to where values meet.

use crate::program::*;
use rustc_hash::{FxHashMap, FxHashSet};
use srp_archdesc::isa::{Opcode, Ty};

/// A new slot for a value of a type.
pub(super) fn slot_for(func: &mut Function, ty: Ty) -> Slot {
    let size = if ty == Ty::Vec { 16 } else { 4 };
    func.slots.push(SlotData::temporary(size, size))
}

/// The instructions of a store of a value to a slot.
pub(super) fn store(func: &mut Function, slot: Slot, value: Value, pos: Pos) -> Vec<Inst> {
    let mut access = Access::of(func, slot, pos);
    let (op, stored) = match access.func.values[value] {
        Ty::Vec => (Opcode::Sv, value),
        Ty::Word => (Opcode::Sw, value),
        Ty::Pred => (Opcode::Sw, access.op(Opcode::Ptoi, vec![value])),
    };
    let args = vec![access.truth, access.address, stored];
    access.make(InstKind::Op { op, args, imm: 0 }, None);
    access.insts
}

/// The instructions of a load of a slot, and the value that the last of them gives.
pub(super) fn load(func: &mut Function, slot: Slot, ty: Ty, pos: Pos) -> (Vec<Inst>, Value) {
    let mut access = Access::of(func, slot, pos);
    let args = vec![access.truth, access.address];
    let loaded = match ty {
        Ty::Vec => access.op(Opcode::Lv, args),
        Ty::Word => access.op(Opcode::Lw, args),
        Ty::Pred => {
            let word = access.op(Opcode::Lw, args);
            let zero = access.value(InstKind::Const(Bits::Word(0)), Ty::Word);
            access.op(Opcode::Ne, vec![word, zero])
        }
    };
    (access.insts, loaded)
}

/// An access to a slot under way.
struct Access<'a> {
    func: &'a mut Function,
    pos: Pos,
    insts: Vec<Inst>,
    truth: Value,
    address: Value,
}

impl<'a> Access<'a> {
    fn of(func: &'a mut Function, slot: Slot, pos: Pos) -> Access<'a> {
        let truth = func.make_inst(InstKind::Const(Bits::Pred(true)), &[Ty::Pred], pos);
        let address = func.make_inst(InstKind::SlotAddr(slot, 0), &[Ty::Word], pos);
        Access {
            truth: func.insts[truth].results[0],
            address: func.insts[address].results[0],
            func,
            pos,
            insts: vec![truth, address],
        }
    }

    fn make(&mut self, kind: InstKind, ty: Option<Ty>) -> Inst {
        let inst = self.func.make_inst(kind, ty.as_slice(), self.pos);
        self.insts.push(inst);
        inst
    }

    fn value(&mut self, kind: InstKind, ty: Ty) -> Value {
        let inst = self.make(kind, Some(ty));
        self.func.insts[inst].results[0]
    }

    fn op(&mut self, op: Opcode, args: Vec<Value>) -> Value {
        let ty = op.result().expect("the operation has a result");
        self.value(InstKind::Op { op, args, imm: 0 }, ty)
    }
}

/// The uses that [`demote`] takes from a value.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Uses {
    /// Those outside all of the blocks.
    Outside,
    /// Those in any block but the value's own.
    Elsewhere,
}

/// Keeps what some blocks define and other blocks use in slots. Constants are made again where they are used.
pub(super) fn demote(func: &mut Function, blocks: &[Block], uses: Uses) {
    let inside: FxHashSet<Block> = blocks.iter().copied().collect();
    let users = users(func);
    for (value, block, inst) in defined(func, blocks) {
        let moves = |user: &Block| match uses {
            Uses::Outside => !inside.contains(user),
            Uses::Elsewhere => *user != block,
        };
        let users = users.get(&value).into_iter().flatten().copied();
        let users: Vec<Block> = users.filter(moves).collect();
        if users.is_empty() {
            continue;
        }
        let ty = func.values[value];
        if let Some(inst) = inst.filter(|&inst| is_constant(&func.insts[inst].kind)) {
            for user in users {
                let InstData { kind, pos, .. } = func.insts[inst].clone();
                let made = func.make_inst(kind, &[ty], pos);
                let again = func.insts[made].results[0];
                replace_uses(func, user, value, (vec![made], again));
            }
            continue;
        }
        let slot = slot_for(func, ty);
        let place = inst.map_or(0, |inst| {
            let insts = &func.blocks[block].insts;
            insts.iter().position(|&i| i == inst).map_or(0, |p| p + 1)
        });
        let pos = inst.map_or(Pos::nowhere(), |inst| func.insts[inst].pos);
        let stored = store(func, slot, value, pos);
        func.blocks[block].insts.splice(place..place, stored);
        for user in users {
            let pos = func.blocks[user].end_pos;
            let loaded = load(func, slot, ty, pos);
            replace_uses(func, user, value, loaded);
        }
    }
}

/// The values that blocks define, each with its block and, if it is no parameter, its instruction.
fn defined(func: &Function, blocks: &[Block]) -> Vec<(Value, Block, Option<Inst>)> {
    let mut defined = Vec::new();
    for &block in blocks {
        defined.extend(func.blocks[block].params.iter().map(|&v| (v, block, None)));
        for &inst in &func.blocks[block].insts {
            let results = func.insts[inst].results.iter();
            defined.extend(results.map(|&v| (v, block, Some(inst))));
        }
    }
    defined
}

/// The blocks that use each value, in the order of the layout.
fn users(func: &Function) -> FxHashMap<Value, Vec<Block>> {
    let mut users = FxHashMap::<Value, Vec<Block>>::default();
    for &block in &func.layout {
        let mut note = |v: Value| {
            let list = users.entry(v).or_default();
            if list.last() != Some(&block) {
                list.push(block);
            }
        };
        for &inst in &func.blocks[block].insts {
            func.insts[inst].kind.for_each_use(&mut note);
        }
        func.blocks[block].end.for_each_use(&mut note);
    }
    users
}

/// True when an instruction can be made again anywhere.
fn is_constant(kind: &InstKind) -> bool {
    matches!(
        kind,
        InstKind::Const(_) | InstKind::SymbolAddr(..) | InstKind::SlotAddr(..)
    )
}

/// Lets a block use, instead of a value, another that these instructions at its beginning make.
fn replace_uses(
    func: &mut Function,
    block: Block,
    value: Value,
    (first, made): (Vec<Inst>, Value),
) {
    let rename = |v: &mut Value| {
        if *v == value {
            *v = made;
        }
    };
    for &inst in &func.blocks[block].insts {
        func.insts[inst].kind.for_each_use_mut(rename);
    }
    func.blocks[block].end.for_each_use_mut(rename);
    func.blocks[block].insts.splice(0..0, first);
}
