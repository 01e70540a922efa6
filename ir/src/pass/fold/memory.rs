//! Loads and stores: constant guards, and constants of addresses.

use super::{Folder, LOOK_BACK};
use crate::program::*;
use srp_archdesc::isa::{Effect, Opcode};

impl Folder<'_> {
    /// A load or store on its way to the block.
    pub(super) fn access(&mut self, inst: Inst, op: Opcode, mut args: Vec<Value>, imm: i32) {
        if self.pred(args[0]) == Some(false) {
            if op.info().effect == Effect::Store {
                self.changed = true;
            } else {
                let ty = op.result().expect("loads have a result");
                let zero = self.constant(Bits::zero(ty));
                self.replace(inst, zero);
            }
            return;
        }
        if op.access_bytes().is_none() {
            return self.out.push(inst);
        }
        let (base, offset) = self.without_constant(args[1], 0);
        if base != args[1] {
            args[1] = base;
            let imm = imm.wrapping_add_unsigned(offset);
            self.func.insts[inst].kind = InstKind::Op { op, args, imm };
            self.changed = true;
        }
        self.out.push(inst);
    }

    /// An address as a value and a constant that add up to it: itself and 0, or a value with less
    /// constants in it.
    fn without_constant(&mut self, address: Value, depth: u32) -> (Value, u32) {
        let nothing = (address, 0);
        let Some((op, [a, b, _], _)) = self.op_of(address).filter(|_| depth < LOOK_BACK) else {
            return nothing;
        };
        match (op, self.word(b)) {
            (Opcode::Add, Some(c)) => {
                let (base, more) = self.without_constant(a, depth + 1);
                (base, c.wrapping_add(more))
            }
            (Opcode::Add, None) => {
                let (left, c) = self.without_constant(a, depth + 1);
                let (right, d) = self.without_constant(b, depth + 1);
                if (left, right) == (a, b) {
                    return nothing;
                }
                (self.build(op, &[left, right]), c.wrapping_add(d))
            }
            (Opcode::Shl | Opcode::Mul, Some(by)) => {
                let (base, c) = self.without_constant(a, depth + 1);
                if base == a {
                    return nothing;
                }
                let scaled = match op {
                    Opcode::Shl => c << (by & 31),
                    _ => c.wrapping_mul(by),
                };
                (self.build(op, &[base, b]), scaled)
            }
            _ => nothing,
        }
    }
}
