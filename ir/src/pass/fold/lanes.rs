//! Identities of lane traffic and of vector integers.

use super::Folder;
use crate::program::*;
use srp_archdesc::isa::Opcode;

/// The swizzle that changes nothing.
const IDENTITY: i32 = 0b11_10_01_00;

/// The lane that a swizzle puts in `lane`.
fn picked(swizzle: i32, lane: i32) -> i32 {
    (swizzle >> (2 * lane)) & 3
}

impl Folder<'_> {
    pub(super) fn lanes(&mut self, op: Opcode, args: [Value; 3], imm: i32) -> Option<Value> {
        let [a, b, c] = args;
        match op {
            Opcode::Vext => self.extract(a, imm),
            Opcode::Vins => self.insert(a, b, imm),
            Opcode::Swz => self.swizzle(a, imm),
            Opcode::Vblend => match self.bits(a) {
                Some(Bits::Vec([u32::MAX, u32::MAX, u32::MAX, u32::MAX])) => Some(b),
                Some(Bits::Vec([0, 0, 0, 0])) => Some(c),
                _ => (b == c).then_some(b),
            },
            _ => {
                let neutral = if op == Opcode::Vand { u32::MAX } else { 0 };
                (self.bits(b) == Some(Bits::Vec([neutral; 4]))).then_some(a)
            }
        }
    }

    fn extract(&mut self, vector: Value, lane: i32) -> Option<Value> {
        match self.op_of(vector)? {
            (Opcode::Vsplat, [word, ..], _) => Some(word),
            (Opcode::Vins, [_, word, _], at) if at == lane => Some(word),
            (Opcode::Vins, [rest, ..], _) => Some(self.build_imm(Opcode::Vext, &[rest], lane)),
            (Opcode::Swz, [from, ..], swizzle) => {
                Some(self.build_imm(Opcode::Vext, &[from], picked(swizzle, lane)))
            }
            _ => None,
        }
    }

    fn insert(&mut self, vector: Value, word: Value, lane: i32) -> Option<Value> {
        // What a lane already is.
        if let Some((Opcode::Vext, [from, ..], at)) = self.op_of(word)
            && (from, at) == (vector, lane)
        {
            return Some(vector);
        }
        match self.op_of(vector)? {
            (Opcode::Vsplat, [all, ..], _) if self.same(all, word) => Some(vector),
            (Opcode::Vins, [rest, ..], at) if at == lane => {
                Some(self.build_imm(Opcode::Vins, &[rest, word], lane))
            }
            _ => None,
        }
    }

    fn swizzle(&mut self, vector: Value, swizzle: i32) -> Option<Value> {
        if swizzle == IDENTITY {
            return Some(vector);
        }
        match self.op_of(vector)? {
            (Opcode::Vsplat, ..) => Some(vector),
            (Opcode::Swz, [from, ..], first) => {
                let lane = |to: i32| picked(first, picked(swizzle, to)) << (2 * to);
                let both = lane(0) | lane(1) | lane(2) | lane(3);
                Some(self.build_imm(Opcode::Swz, &[from], both))
            }
            _ => None,
        }
    }
}
