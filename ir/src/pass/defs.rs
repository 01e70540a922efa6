//! The instructions that define the values of a function.

use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Opcode;

/// For each value the instruction that defines it, as far as blocks were looked at.
pub(super) struct Defs(EntityMap<Value, Option<Inst>>);

impl Defs {
    /// The definitions of a function.
    pub(super) fn of(func: &Function) -> Defs {
        Defs::within(func, &func.layout)
    }

    /// The definitions of some of its blocks.
    pub(super) fn within(func: &Function, blocks: &[Block]) -> Defs {
        let mut defs = Defs(EntityMap::filled(func.values.len(), None));
        for &inst in blocks.iter().flat_map(|&b| &func.blocks[b].insts) {
            defs.add(func, inst);
        }
        defs
    }

    /// Adds an instruction that was made since.
    pub(super) fn add(&mut self, func: &Function, inst: Inst) {
        while self.0.len() < func.values.len() {
            self.0.push(None);
        }
        for &result in &func.insts[inst].results {
            self.0[result] = Some(inst);
        }
    }

    /// The instruction that defines a value; none for parameters.
    pub(super) fn inst(&self, value: Value) -> Option<Inst> {
        self.0.get(value).copied().flatten()
    }

    /// The kind of that instruction.
    pub(super) fn kind<'f>(&self, func: &'f Function, value: Value) -> Option<&'f InstKind> {
        Some(&func.insts[self.inst(value)?].kind)
    }

    /// The operation that gives a value, and its operands.
    pub(super) fn op<'f>(&self, func: &'f Function, value: Value) -> Option<(Opcode, &'f [Value])> {
        match self.kind(func, value)? {
            InstKind::Op { op, args, .. } => Some((*op, args)),
            _ => None,
        }
    }

    /// The word that a value always is.
    pub(super) fn word(&self, func: &Function, value: Value) -> Option<u32> {
        match self.kind(func, value)? {
            InstKind::Const(Bits::Word(word)) => Some(*word),
            _ => None,
        }
    }
}
