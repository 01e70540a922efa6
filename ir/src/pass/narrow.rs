//! Words that are extended from their low bits, as C makes them where it converts to a narrow type (C17 6.3.1.3), and
//! the numbers that words may be.

use super::defs::Defs;
use crate::program::*;
use srp_archdesc::isa::{Opcode, Ty};

/// Words from the first to the last, as signed numbers.
#[derive(Clone, Copy)]
pub(super) struct Range {
    pub(super) first: i64,
    pub(super) last: i64,
}

impl Range {
    pub(super) const WORDS: Range = Range {
        first: i32::MIN as i64,
        last: i32::MAX as i64,
    };

    pub(super) fn with(self, other: Range) -> Range {
        Range {
            first: self.first.min(other.first),
            last: self.last.max(other.last),
        }
    }

    pub(super) fn within(self, other: Range) -> bool {
        other.first <= self.first && self.last <= other.last
    }
}

/// A type of fewer bits than a word's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Narrow {
    /// 1 to 31.
    pub(super) bits: u32,
    pub(super) is_signed: bool,
}

impl Narrow {
    /// The type of what a load takes from memory; `None` for words and vectors.
    pub(super) fn loaded(load: Opcode) -> Option<Narrow> {
        let (bits, is_signed) = match load {
            Opcode::Lb | Opcode::Glb => (8, true),
            Opcode::Lbu | Opcode::Glbu => (8, false),
            Opcode::Lh | Opcode::Glh => (16, true),
            Opcode::Lhu | Opcode::Glhu => (16, false),
            _ => return None,
        };
        Some(Narrow { bits, is_signed })
    }

    /// The operations that extend a word from its low bits, and the constant that each of them takes.
    pub(super) fn extending(self) -> (u32, &'static [Opcode]) {
        match self.is_signed {
            true => (32 - self.bits, &[Opcode::Shl, Opcode::Sar]),
            false => ((1 << self.bits) - 1, &[Opcode::And]),
        }
    }

    /// Makes instructions that extend a word, in no block yet; returns them and the result.
    pub(super) fn extend(self, func: &mut Function, word: Value, pos: Pos) -> (Vec<Inst>, Value) {
        let (constant, ops) = self.extending();
        let constant = InstKind::Const(Bits::Word(constant));
        let mut insts = vec![func.make_inst(constant, &[Ty::Word], pos)];
        let constant = func.insts[insts[0]].results[0];
        let mut extended = word;
        for &op in ops {
            let args = vec![extended, constant];
            let inst = func.make_inst(InstKind::Op { op, args, imm: 0 }, &[Ty::Word], pos);
            extended = func.insts[inst].results[0];
            insts.push(inst);
        }
        (insts, extended)
    }

    /// The numbers of the type.
    pub(super) fn range(self) -> Range {
        match self.is_signed {
            true => Range {
                first: -(1 << (self.bits - 1)),
                last: (1 << (self.bits - 1)) - 1,
            },
            false => Range {
                first: 0,
                last: (1 << self.bits) - 1,
            },
        }
    }
}

/// The word whose low bits a value extends, and the type that those are of.
pub(super) fn extended(func: &Function, defs: &Defs, value: Value) -> Option<(Value, Narrow)> {
    let (op, args) = defs.op(func, value)?;
    let constant = |value: Value| defs.word(func, value);
    match (op, args) {
        (Opcode::And, &[wide, mask]) => {
            let mask = constant(mask)?;
            let is_type = mask != 0 && mask < u32::MAX && (mask + 1).is_power_of_two();
            is_type.then_some((
                wide,
                Narrow {
                    bits: mask.trailing_ones(),
                    is_signed: false,
                },
            ))
        }
        (Opcode::Sar | Opcode::Shr, &[shifted, by]) => {
            let (Opcode::Shl, &[wide, there]) = defs.op(func, shifted)? else {
                return None;
            };
            let by =
                constant(by).filter(|&by| constant(there) == Some(by) && (1..32).contains(&by))?;
            Some((
                wide,
                Narrow {
                    bits: 32 - by,
                    is_signed: op == Opcode::Sar,
                },
            ))
        }
        _ => None,
    }
}

/// The words that a value may be.
pub(super) fn range(func: &Function, defs: &Defs, value: Value) -> Range {
    if let Some(word) = defs.word(func, value) {
        let word = i64::from(word as i32);
        return Range {
            first: word,
            last: word,
        };
    }
    let narrow = defs.op(func, value).and_then(|(op, _)| Narrow::loaded(op));
    let narrow = narrow.or_else(|| Some(extended(func, defs, value)?.1));
    narrow.map_or(Range::WORDS, Narrow::range)
}
