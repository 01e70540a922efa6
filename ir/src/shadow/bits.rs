//! Floats that are taken apart as integers: another exponent or another sign makes of a float the
//! float times a power of two.

use super::{Mark, Shadows};
use crate::interp::Done;
use srp_archdesc::isa::Opcode;

/// The bits of the mantissa of a binary32.
const MANTISSA: u32 = 0x7f_ffff;

impl Shadows<'_> {
    /// The mark of an integer result that has the mantissa of a float which an operand is made of.
    #[inline]
    pub(super) fn rescaled(&mut self, done: &Done<'_>, a: Mark, b: Mark) -> Option<Mark> {
        if a.behind() == 0 && b.behind() == 0 {
            return None;
        }
        let (mark, other, word) = match (a.behind(), b.behind()) {
            (_, 0) => (a, b, done.operands[1].as_word()),
            (0, _) => (b, a, done.operands[0].as_word()),
            _ => return None,
        };
        match done.op {
            Opcode::And if word & MANTISSA != MANTISSA => return None,
            Opcode::And | Opcode::Or | Opcode::Xor | Opcode::Add => {}
            Opcode::Sub if mark == a => {}
            _ => return None,
        }
        self.settle(other);
        let node = mark.behind();
        let result = done.result?.1.as_word();
        if done.op == Opcode::And && word == MANTISSA {
            return Some(Mark::mantissa(node));
        }
        let entry = self.tape.get(node)?;
        let (value, made) = (entry.value, f32::from_bits(result));
        let same = value.to_bits() & MANTISSA == result & MANTISSA;
        if !same || !value.is_normal() || !made.is_normal() {
            return None;
        }
        let ratio = f64::from(made) / f64::from(value);
        let shadow = entry.shadow * ratio;
        let source = self.sources.number(done.func, done.inst);
        let parents = [(node, ratio), (0, 0.0), (0, 0.0)];
        Some(Mark::node(self.tape.push(made, shadow, source, parents)))
    }
}
