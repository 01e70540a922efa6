//! Vectors: lanes, building, relations.

use super::function::Lowering;
use super::leaf::Access;
use super::place::{Base, Location};
use crate::operator::{self, Class};
use crate::typed::{ExprId, ExprKind, Relation};
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::program::{Bits, InstKind, Pos, SlotData, Value};

impl Lowering<'_> {
    /// A vector of four words.
    pub(super) fn build(&mut self, lanes: [Value; 4]) -> Value {
        let constants = lanes.map(|lane| self.constant_word(lane));
        if let [Some(x), Some(y), Some(z), Some(w)] = constants {
            return self.constant(Bits::Vec([x, y, z, w]));
        }
        let mut vector = self.op(Opcode::Vsplat, &[lanes[0]]);
        for (i, &lane) in lanes.iter().enumerate().skip(1) {
            if lane != lanes[0] {
                vector = self.op_imm(Opcode::Vins, &[vector, lane], i as i32);
            }
        }
        vector
    }

    /// The constant that a value made just now is.
    pub(super) fn constant_word(&self, value: Value) -> Option<u32> {
        let recent = self.func.blocks[self.block].insts.iter().rev().take(8);
        recent.into_iter().find_map(|&inst| {
            let data = &self.func.insts[inst];
            match data.kind {
                InstKind::Const(Bits::Word(bits)) if data.results[0] == value => Some(bits),
                _ => None,
            }
        })
    }

    /// A lane of a vector value.
    pub(super) fn lane(&mut self, vector: ExprId, index: ExprId, pos: Pos) -> Value {
        let vector = self.value(vector);
        if let ExprKind::Const(lane) = self.body.exprs[index].kind {
            self.pos = pos;
            return self.op_imm(Opcode::Vext, &[vector], lane as i32);
        }
        let index = self.value(index);
        self.pos = pos;
        let slot = self.func.slots.push(SlotData::temporary(16, 16));
        let room = Location {
            base: Base::Slot(slot),
            offset: 0,
            global: false,
        };
        self.store(room, Access::Vector, vector);
        let base = self.inst(InstKind::SlotAddr(slot, 0), Ty::Word);
        let address = self.scaled(base, index, 4);
        self.load(Location::pointer(address, false), Access::Word)
    }

    /// A relation of vectors: a mask.
    pub(super) fn vector_relation(
        &mut self,
        relation: Relation,
        class: Class,
        l: Value,
        r: Value,
    ) -> Value {
        let (op, swap, invert) = operator::relation(relation, class);
        let (l, r) = if swap { (r, l) } else { (l, r) };
        let mask = self.op(op, &[l, r]);
        if !invert {
            return mask;
        }
        let ones = self.constant(Bits::Vec([u32::MAX; 4]));
        self.op(Opcode::Vxor, &[mask, ones])
    }
}
