//! Writing blocks.

use crate::program::*;
use srp_archdesc::isa::{Opcode, Ty};

/// Instructions put at the end of a block.
pub(super) struct At<'a> {
    pub(super) func: &'a mut Function,
    pub(super) pos: Pos,
}

impl At<'_> {
    pub(super) fn block(&mut self) -> Block {
        let block = self.func.blocks.push(BlockData::unreachable());
        self.func.blocks[block].end_pos = self.pos;
        block
    }

    pub(super) fn constant(&mut self, block: Block, bits: Bits) -> Value {
        self.func.append_const(block, bits, self.pos)
    }

    pub(super) fn op(&mut self, block: Block, op: Opcode, args: &[Value]) -> Value {
        let made = self.func.append_op(block, op, args, 0, self.pos);
        made.expect("operations of words have results")
    }

    pub(super) fn params(&mut self, block: Block, tys: &[Ty]) -> Vec<Value> {
        tys.iter()
            .map(|&ty| self.func.add_param(block, ty))
            .collect()
    }

    pub(super) fn end(&mut self, block: Block, end: Terminator) {
        self.func.blocks[block].end = end;
    }

    pub(super) fn jump(&mut self, block: Block, to: Block, args: Vec<Value>) {
        self.end(block, Terminator::Jump(Target { block: to, args }));
    }
}
