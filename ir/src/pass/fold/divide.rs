//! Division by constants: shifts, and products with reciprocals (Warren, *Hacker's Delight*, chapter 10).

use super::Folder;
use crate::program::*;
use srp_archdesc::arch::Approx;
use srp_archdesc::format::Format;
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
            let quotient = match signed {
                _ if divisor == 0 || signed && divisor == 1 << 31 => return None,
                true => self.signed_quotient(a, divisor as i32),
                false => self.unsigned_quotient(a, divisor),
            };
            let value = match op {
                Opcode::Div | Opcode::Divu => quotient,
                _ => {
                    let multiple = self.build(Opcode::Mul, &[quotient, b]);
                    self.build(Opcode::Sub, &[a, multiple])
                }
            };
            let zero = self.int(0);
            return Some(self.build(Opcode::Sel, &[guard, value, zero]));
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

    /// A float divided by a power of two: the product with its reciprocal is the same number, rounded
    /// the same way.
    pub(super) fn quotient(&mut self, a: Value, b: Value) -> Option<Value> {
        let divisor = self.word(b)?;
        let (exponent, fraction) = (divisor >> 23 & 0xff, divisor & 0x7f_ffff);
        let reciprocal = (254u32.wrapping_sub(exponent)) << 23 | divisor & 1 << 31;
        let exact = self.precision.div == Approx::Exact
            && self.precision.formats.multiply == Format::SINGLE;
        if fraction != 0 || !(1..=253).contains(&exponent) || !exact {
            return None;
        }
        let reciprocal = self.int(reciprocal);
        Some(self.build(Opcode::Fmul, &[a, reciprocal]))
    }

    /// `a / divisor`, which is neither 0 nor a power of two.
    fn unsigned_quotient(&mut self, a: Value, divisor: u32) -> Value {
        let bits = 32 - (divisor - 1).leading_zeros();
        // The reciprocal with 32 + bits bits, rounded up: 33 bits, of which the first is 1.
        let full = ((1u128 << (32 + bits)) / u128::from(divisor) + 1) as u64;
        let known_small = self.ones(a, 0) >> 31 == 0;
        if known_small {
            // One bit less of the operand needs one less of the reciprocal.
            let magic = ((1u128 << (31 + bits)) / u128::from(divisor) + 1) as u32;
            return self.high_product(a, magic, bits - 1);
        }
        let magic = self.int(full as u32);
        let high = self.build(Opcode::Mulhu, &[a, magic]);
        let one = self.int(1);
        let rest = self.build(Opcode::Sub, &[a, high]);
        let half = self.build(Opcode::Shr, &[rest, one]);
        let sum = self.build(Opcode::Add, &[half, high]);
        let by = self.int(bits - 1);
        self.build(Opcode::Shr, &[sum, by])
    }

    fn high_product(&mut self, a: Value, magic: u32, shift: u32) -> Value {
        let magic = self.int(magic);
        let high = self.build(Opcode::Mulhu, &[a, magic]);
        let by = self.int(shift);
        self.build(Opcode::Shr, &[high, by])
    }

    /// `a / divisor`, rounded toward zero; the divisor is not 0, 1 or the least integer.
    fn signed_quotient(&mut self, a: Value, divisor: i32) -> Value {
        let size = divisor.unsigned_abs();
        let zero = self.int(0);
        let magnitude = if size.is_power_of_two() {
            let by = self.int(size);
            let guard = self.truth(true);
            self.build(Opcode::Div, &[guard, a, by])
        } else if self.ones(a, 0) >> 31 == 0 {
            self.unsigned_quotient(a, size)
        } else {
            let bits = 32 - (size - 1).leading_zeros();
            let magic = ((1u128 << (31 + bits)) / u128::from(size) + 1) as u32;
            // The reciprocal has 32 bits: as a signed number it is 2^32 too small.
            let magic_value = self.int(magic);
            let high = self.build(Opcode::Mulhs, &[a, magic_value]);
            let high = match (magic as i32) < 0 {
                true => self.build(Opcode::Add, &[high, a]),
                false => high,
            };
            let by = self.int(bits - 1);
            let down = self.build(Opcode::Sar, &[high, by]);
            let sign = self.int(31);
            let negative = self.build(Opcode::Shr, &[a, sign]);
            self.build(Opcode::Add, &[down, negative])
        };
        match divisor < 0 {
            true => self.build(Opcode::Sub, &[zero, magnitude]),
            false => magnitude,
        }
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
