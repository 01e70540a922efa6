//! Identities of integer arithmetic.

use super::{Folder, LOOK_BACK};
use crate::program::*;
use srp_archdesc::isa::{Opcode, Ty};

impl Folder<'_> {
    /// Rules for `a op b`; of a commutative operation a constant comes as `b`.
    pub(super) fn integer(&mut self, op: Opcode, a: Value, b: Value) -> Option<Value> {
        use Opcode::*;
        let constant = self.word(b);
        let by = constant.map(|c| c & 31);
        match (op, constant) {
            (Add | Sub | Or | Xor, Some(0)) | (Mul, Some(1)) | (And, Some(u32::MAX)) => Some(a),
            (Shl | Shr | Sar, _) if by == Some(0) => Some(a),
            (And | Mul, Some(0)) | (Or, Some(u32::MAX)) => Some(b),
            (And | Or | Min | Max | Minu | Maxu, _) if self.same(a, b) => Some(a),
            (Sub | Xor, _) if self.same(a, b) => Some(self.int(0)),
            (Sub, Some(c)) => {
                let minus = self.int(c.wrapping_neg());
                Some(self.build(Add, &[a, minus]))
            }
            (Add, Some(c)) => self.add_constant(a, c),
            (Mul, Some(c)) if c.is_power_of_two() => {
                let by = self.int(c.trailing_zeros());
                Some(self.build(Shl, &[a, by]))
            }
            (Mul, Some(u32::MAX)) => {
                let zero = self.int(0);
                Some(self.build(Sub, &[zero, a]))
            }
            (And, Some(c)) if self.ones(a, 0) & !c == 0 => Some(a),
            (And | Or | Xor | Mul, Some(c)) => self.regroup(op, a, c),
            (Shl | Shr | Sar, Some(c)) => self.shift(op, a, c & 31, c),
            (Sub, None) => self.subtract(a, b),
            _ => None,
        }
        .or_else(|| self.truth_values(op, a, b))
        .or_else(|| self.masked(op, a, b))
        .or_else(|| self.masked(op, b, a))
    }

    /// `−t & x` and, if t is a predicate, `t · x`: x or 0, where t is 1 or 0.
    fn masked(&mut self, op: Opcode, mask: Value, x: Value) -> Option<Value> {
        let t = match (op, self.op_of(mask)?) {
            (Opcode::And, (Opcode::Sub, [zero, t, _], _)) => {
                (self.word(zero) == Some(0) && self.ones(t, 0) <= 1).then_some(t)
            }
            (Opcode::Mul, (Opcode::Ptoi, ..)) => Some(mask),
            _ => None,
        }?;
        let zero = self.int(0);
        let holds = self.build(Opcode::Ne, &[t, zero]);
        Some(self.build(Opcode::Sel, &[holds, x, zero]))
    }

    /// `a + c`, `c` not 0.
    fn add_constant(&mut self, a: Value, c: u32) -> Option<Value> {
        let kind = match self.kind_of(a)? {
            InstKind::SymbolAddr(symbol, offset) => {
                InstKind::SymbolAddr(*symbol, offset.wrapping_add_unsigned(c))
            }
            InstKind::SlotAddr(slot, offset) => {
                InstKind::SlotAddr(*slot, offset.wrapping_add_unsigned(c))
            }
            _ => return self.regroup(Opcode::Add, a, c),
        };
        Some(self.make(kind, Ty::Word))
    }

    /// `(x op d) op c` to `x op (d op c)`, for operations that may be regrouped.
    fn regroup(&mut self, op: Opcode, a: Value, c: u32) -> Option<Value> {
        let (inner, [x, y, _], _) = self.op_of(a)?;
        if op == Opcode::Add
            && inner == Opcode::Sub
            && let Some(d) = self.word(x)
        {
            // (d − y) + c
            let sum = self.int(d.wrapping_add(c));
            return Some(self.build(Opcode::Sub, &[sum, y]));
        }
        let d = self.word(y).filter(|_| inner == op)?;
        let together = match op {
            Opcode::Add => d.wrapping_add(c),
            Opcode::And => d & c,
            Opcode::Or => d | c,
            Opcode::Xor => d ^ c,
            Opcode::Mul => d.wrapping_mul(c),
            _ => return None,
        };
        let together = self.int(together);
        Some(self.build(op, &[x, together]))
    }

    /// `a shifted by`, `by` not 0 and given as `count`.
    fn shift(&mut self, op: Opcode, a: Value, by: u32, count: u32) -> Option<Value> {
        if let Some((inner, [x, y, _], _)) = self.op_of(a)
            && let Some(before) = self.word(y).map(|y| y & 31)
        {
            if inner == op {
                let sum = before + by;
                let sum = match op {
                    Opcode::Sar => sum.min(31),
                    _ if sum > 31 => return Some(self.int(0)),
                    _ => sum,
                };
                let sum = self.int(sum);
                return Some(self.build(op, &[x, sum]));
            }
            if op == Opcode::Sar && inner == Opcode::Shl && by == before && self.fits(x, 32 - by) {
                return Some(x);
            }
        }
        if count != by {
            let by = self.int(by);
            return Some(self.build(op, &[a, by]));
        }
        None
    }

    /// `a − b` where one contains the other.
    fn subtract(&mut self, a: Value, b: Value) -> Option<Value> {
        if let Some((Opcode::Add, [x, y, _], _)) = self.op_of(a) {
            if self.same(y, b) {
                return Some(x);
            }
            if self.same(x, b) {
                return Some(y);
            }
        }
        let (Opcode::Add, [x, y, _], _) = self.op_of(b)? else {
            return None;
        };
        let left = match (self.same(x, a), self.same(y, a)) {
            (true, _) => y,
            (_, true) => x,
            _ => return None,
        };
        let zero = self.int(0);
        Some(self.build(Opcode::Sub, &[zero, left]))
    }

    /// Logic of words that are predicates as 0 and 1, as logic of the predicates.
    fn truth_values(&mut self, op: Opcode, a: Value, b: Value) -> Option<Value> {
        let logic = match op {
            Opcode::And => Opcode::Pand,
            Opcode::Or => Opcode::Por,
            Opcode::Xor => Opcode::Pxor,
            _ => return None,
        };
        // A constant alone is no predicate yet.
        let (Opcode::Ptoi, _, _) = self.op_of(a)? else {
            return None;
        };
        let (p, q) = (self.as_predicate(a)?, self.as_predicate(b)?);
        let both = self.build(logic, &[p, q]);
        Some(self.build(Opcode::Ptoi, &[both]))
    }

    /// The predicate that a word is as 0 or 1.
    pub(super) fn as_predicate(&mut self, value: Value) -> Option<Value> {
        if let Some((Opcode::Ptoi, [p, ..], _)) = self.op_of(value) {
            return Some(p);
        }
        match self.word(value)? {
            0 => Some(self.truth(false)),
            1 => Some(self.truth(true)),
            _ => None,
        }
    }

    /// The bits of a word that may be 1.
    pub(super) fn ones(&self, value: Value, depth: u32) -> u32 {
        use Opcode::*;
        if let Some(word) = self.word(value) {
            return word;
        }
        if depth == LOOK_BACK {
            return u32::MAX;
        }
        let Some((op, [a, b, c], _)) = self.op_of(value) else {
            return u32::MAX;
        };
        let ones = |v| self.ones(v, depth + 1);
        match op {
            Ptoi => 1,
            Lbu | Glbu => 0xff,
            Lhu | Glhu => 0xffff,
            And => ones(a) & ones(b),
            Or | Xor => ones(a) | ones(b),
            Sel => ones(b) | ones(c),
            Shr => self.word(b).map_or(u32::MAX, |by| ones(a) >> (by & 31)),
            Shl => self.word(b).map_or(u32::MAX, |by| ones(a) << (by & 31)),
            _ => u32::MAX,
        }
    }

    /// True if a word is the sign extension of its low `bits` bits (1 to 31).
    fn fits(&self, value: Value, bits: u32) -> bool {
        let loaded = match self.op_of(value) {
            Some((Opcode::Lb | Opcode::Glb, ..)) => 8,
            Some((Opcode::Lh | Opcode::Glh, ..)) => 16,
            _ => 32,
        };
        loaded <= bits || self.ones(value, 0) >> (bits - 1) == 0
    }
}
