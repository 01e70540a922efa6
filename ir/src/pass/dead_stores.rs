//! Stores that a later one in their block overwrites before anything may read them.
//!
//! The later store is to the same address and traps where the earlier one would have. What a kernel stores to one place
//! under several predicates becomes one store of a selection.

use super::alias::{Objects, Piece, Scopes};
use super::guards::Guards;
use crate::program::*;
use srp_archdesc::isa::{Effect, Opcode, Ty};

/// Stores that are looked back at.
const MAX_OPEN: usize = 64;

/// Removes stores that are overwritten.
pub(crate) fn dead_stores(func: &mut Function) -> bool {
    let stores = |b: Block| {
        let insts = func.blocks[b].insts.iter();
        insts.filter(|&&i| matches!(&func.insts[i].kind, InstKind::Op { op, .. } if is_store(*op)))
    };
    let blocks: Vec<Block> = (func.layout.iter().copied())
        .filter(|&b| stores(b).nth(1).is_some())
        .collect();
    if blocks.is_empty() {
        return false;
    }
    let mut scopes = Scopes::default();
    let guards = Guards::of(func);
    let mut changed = false;
    for block in blocks {
        let open = Open {
            stores: Vec::new(),
            objects: scopes.of_block(func, block),
            guards: &guards,
            merges: func.blocks[block].kernel.is_some(),
        };
        changed |= open.scan(func, block);
    }
    changed
}

fn is_store(op: Opcode) -> bool {
    op.info().effect == Effect::Store && op.access_bytes().is_some()
}

/// A store that nothing has read so far.
struct Store {
    inst: Inst,
    op: Opcode,
    guard: Value,
    value: Value,
    piece: Piece,
    /// No store since then may have been to a part of its piece: it may as well be made now.
    is_last: bool,
}

/// The stores of a block up to a point that nothing has read.
struct Open<'a> {
    stores: Vec<Store>,
    objects: &'a Objects,
    guards: &'a Guards,
    /// Stores under different predicates become one.
    merges: bool,
}

impl Open<'_> {
    fn scan(mut self, func: &mut Function, block: Block) -> bool {
        let before = func.blocks[block].insts.len();
        let mut gone = Vec::new();
        for inst in std::mem::take(&mut func.blocks[block].insts) {
            if let InstKind::Op { op, args, imm } = &func.insts[inst].kind {
                let (op, imm, args) = (*op, *imm, args.clone());
                match op.info().effect {
                    Effect::Pure | Effect::Prefetch => {}
                    Effect::Io => self.stores.clear(),
                    Effect::Load => self.load(op, &args, imm),
                    Effect::Store => match Piece::of(op, args[1], imm) {
                        Some(piece) => self.store(func, block, inst, piece, &mut gone),
                        None => self.stores.clear(),
                    },
                }
            } else if let InstKind::Call { .. } | InstKind::Launch { .. } = func.insts[inst].kind {
                self.stores.clear();
            }
            func.blocks[block].insts.push(inst);
        }
        func.blocks[block].insts.retain(|i| !gone.contains(i));
        !gone.is_empty() || func.blocks[block].insts.len() != before
    }

    /// Forgets what a load may read.
    fn load(&mut self, op: Opcode, args: &[Value], imm: i32) {
        let objects = self.objects;
        match (
            args.get(1).and_then(|&base| Piece::of(op, base, imm)),
            op.space(),
        ) {
            (Some(piece), _) => self.stores.retain(|s| !s.piece.may_meet(&piece, objects)),
            (None, Some(space)) => self.stores.retain(|s| !s.piece.is_in(space)),
            (None, None) => {}
        }
    }

    /// Looks which earlier stores one makes void, and takes in those that it can.
    fn store(
        &mut self,
        func: &mut Function,
        block: Block,
        inst: Inst,
        piece: Piece,
        gone: &mut Vec<Inst>,
    ) {
        let InstData { kind, pos, .. } = &func.insts[inst];
        let (pos, InstKind::Op { op, args, .. }) = (*pos, kind) else {
            return;
        };
        let (op, mut guard, mut value) = (*op, args[0], args[2]);
        let guards = self.guards;
        self.stores.retain(|earlier| {
            let void = piece.contains(&earlier.piece) && guards.implies(earlier.guard, guard);
            gone.extend(void.then_some(earlier.inst));
            !void
        });
        let same = |s: &Store| s.is_last && s.op == op && s.piece == piece;
        let earlier = self.stores.iter().position(same).filter(|_| self.merges);
        if let Some(earlier) = earlier.map(|at| self.stores.remove(at)) {
            gone.push(earlier.inst);
            let select = Opcode::select(func.values[value]);
            let chosen = func.append_op(block, select, &[guard, value, earlier.value], 0, pos);
            value = chosen.expect("a selection has a result");
            guard = self.either(func, block, guard, earlier.guard, pos);
            if let InstKind::Op { args, .. } = &mut func.insts[inst].kind {
                (args[0], args[2]) = (guard, value);
            }
        }
        for earlier in &mut self.stores {
            earlier.is_last &= !earlier.piece.may_meet(&piece, self.objects);
        }
        if self.stores.len() == MAX_OPEN {
            self.stores.remove(0);
        }
        self.stores.push(Store {
            inst,
            op,
            guard,
            value,
            piece,
            is_last: true,
        });
    }

    /// The predicate that one of two holds.
    fn either(&self, func: &mut Function, block: Block, a: Value, b: Value, pos: Pos) -> Value {
        if self.guards.implies(a, b) {
            return b;
        }
        debug_assert_eq!(func.values[a], Ty::Pred);
        let any = func.append_op(block, Opcode::Por, &[a, b], 0, pos);
        any.expect("logic has a result")
    }
}
