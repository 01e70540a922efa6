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
        if let (Effect::Store, Some(bytes @ (1 | 2))) = (op.info().effect, op.access_bytes()) {
            let stored = self.low_bits(args[2], 8 * bytes);
            if stored != args[2] {
                args[2] = stored;
                let args = args.clone();
                self.func.insts[inst].kind = InstKind::Op { op, args, imm };
                self.changed = true;
            }
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

    /// A value with the same low bits: what it extends or masks, for a store that takes no others.
    fn low_bits(&self, value: Value, bits: u32) -> Value {
        let low = u32::MAX >> (32 - bits);
        let mut value = value;
        for _ in 0..LOOK_BACK {
            let wider = match self.op_of(value) {
                Some((Opcode::And, [a, b, _], _))
                    if self.word(b).is_some_and(|c| c & low == low) =>
                {
                    Some(a)
                }
                Some((Opcode::Sar | Opcode::Shr, [a, by, _], _)) => match self.op_of(a) {
                    Some((Opcode::Shl, [x, there, _], _))
                        if self.word(by) == self.word(there)
                            && self.word(by).is_some_and(|by| by <= 32 - bits) =>
                    {
                        Some(x)
                    }
                    _ => None,
                },
                _ => None,
            };
            match wider {
                Some(wider) => value = wider,
                None => break,
            }
        }
        value
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
