//! Division by powers of two.

use super::Folder;
use crate::program::*;
use srp_archdesc::isa::Opcode;

impl Folder<'_> {
    /// Rules for a division or remainder of `a` by `b` under a guard.
    pub(super) fn division(
        &mut self,
        op: Opcode,
        guard: Value,
        a: Value,
        b: Value,
    ) -> Option<Value> {
        if self.pred(guard) == Some(false) {
            return Some(self.int(0));
        }
        let divisor = self.word(b)?;
        let signed = matches!(op, Opcode::Div | Opcode::Rem);
        if !divisor.is_power_of_two() || signed && divisor > i32::MAX as u32 {
            return None;
        }
        let shift = divisor.trailing_zeros();
        let value = match op {
            Opcode::Div | Opcode::Divu if shift == 0 => a,
            Opcode::Rem | Opcode::Remu if shift == 0 => self.int(0),
            _ => {
                let negative = signed && self.ones(a, 0) >> 31 != 0;
                // Division rounds toward zero, a shift downward: 2^shift − 1 makes up for it.
                let biased = if negative { self.bias(a, shift) } else { a };
                match op {
                    Opcode::Div | Opcode::Divu => {
                        let by = self.int(shift);
                        let op = if signed { Opcode::Sar } else { Opcode::Shr };
                        self.build(op, &[biased, by])
                    }
                    _ if negative => {
                        let mask = self.int(divisor.wrapping_neg());
                        let multiple = self.build(Opcode::And, &[biased, mask]);
                        self.build(Opcode::Sub, &[a, multiple])
                    }
                    _ => {
                        let mask = self.int(divisor - 1);
                        self.build(Opcode::And, &[a, mask])
                    }
                }
            }
        };
        let zero = self.int(0);
        Some(self.build(Opcode::Sel, &[guard, value, zero]))
    }

    /// `a`, plus 2^shift − 1 if it is negative.
    fn bias(&mut self, a: Value, shift: u32) -> Value {
        let sign = self.int(31);
        let sign = self.build(Opcode::Sar, &[a, sign]);
        let by = self.int(32 - shift);
        let bias = self.build(Opcode::Shr, &[sign, by]);
        self.build(Opcode::Add, &[a, bias])
    }
}
