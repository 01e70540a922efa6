//! Operands: constants where the context word has room, registers where not.

use super::Selector;
use crate::vliw::VliwError;
use crate::vliw::lir::{Arg, FrameItem, FrameTerm, Inst, Kind, Split, Vreg};
use crate::vliw::target::Target;
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::program::{Bits, InstKind, Pos, Value};

/// The operands, by index, that have to be in registers because no slot's context has room for all
/// constants; `None` where no slot runs the operation. The first constants stay, and predicates,
/// which take no room.
pub(in crate::vliw) fn excess(target: &Target<'_>, op: Opcode, args: &[Arg]) -> Option<Vec<usize>> {
    let room = target.max_constants(op)? as usize;
    let mut kept: Vec<Arg> = Vec::new();
    let mut moved = Vec::new();
    for (i, &arg) in args.iter().enumerate() {
        let free = matches!(arg, Arg::Reg(_) | Arg::Const(Bits::Pred(_)));
        if free || kept.contains(&arg) {
            continue;
        }
        if kept.len() < room {
            kept.push(arg);
        } else {
            moved.push(i);
        }
    }
    Some(moved)
}

impl Selector<'_> {
    /// A value as an operand: a constant if it is one.
    pub(super) fn arg(&mut self, value: Value, pos: Pos) -> Result<Arg, VliwError> {
        match self.def(value) {
            Some(InstKind::Const(bits)) => Ok(Arg::Const(*bits)),
            Some(InstKind::SymbolAddr(symbol, offset)) => {
                let address = self.cx.layout.address(*symbol).wrapping_add_signed(*offset);
                Ok(Arg::Const(Bits::Word(address)))
            }
            Some(InstKind::SlotAddr(slot, offset)) => {
                let term = FrameTerm::At(FrameItem::Slot(*slot));
                self.in_register(Arg::Frame(term, *offset), pos)
                    .map(Arg::Reg)
            }
            _ => Ok(Arg::Reg(self.reg(value))),
        }
    }

    /// The address operand of `inst`: what can be added at the access goes into its immediate.
    pub(super) fn address(&mut self, value: Value, inst: &mut Inst) -> Arg {
        let mut base = value;
        loop {
            match self.def(base) {
                Some(InstKind::Const(Bits::Word(address))) => {
                    return Arg::Const(Bits::Word(*address));
                }
                Some(InstKind::SymbolAddr(symbol, offset)) => {
                    let address = self.cx.layout.address(*symbol).wrapping_add_signed(*offset);
                    return Arg::Const(Bits::Word(address));
                }
                Some(InstKind::SlotAddr(slot, offset)) => {
                    inst.frame = Some(FrameTerm::At(FrameItem::Slot(*slot)));
                    inst.imm = inst.imm.wrapping_add(*offset);
                    return self.sp();
                }
                Some(InstKind::Op {
                    op: op @ (Opcode::Add | Opcode::Sub),
                    args,
                    ..
                }) => {
                    let constant = |v: Value| match self.def(v) {
                        Some(InstKind::Const(Bits::Word(w))) => Some(*w as i32),
                        Some(InstKind::SymbolAddr(symbol, offset)) => {
                            let address = self.cx.layout.address(*symbol);
                            Some(address.wrapping_add_signed(*offset) as i32)
                        }
                        _ => None,
                    };
                    let (rest, by) = match (op, constant(args[0]), constant(args[1])) {
                        (Opcode::Add, _, Some(by)) => (args[0], by),
                        (Opcode::Sub, _, Some(by)) => (args[0], by.wrapping_neg()),
                        (Opcode::Add, Some(by), _) => (args[1], by),
                        _ => return Arg::Reg(self.reg(base)),
                    };
                    inst.imm = inst.imm.wrapping_add(by);
                    base = rest;
                }
                _ => return Arg::Reg(self.reg(base)),
            }
        }
    }

    /// Appends an operation, constants that have no room in registers first.
    pub(super) fn legal(&mut self, mut inst: Inst) -> Result<(), VliwError> {
        let Kind::Op(op) = inst.kind else {
            self.push(inst);
            return Ok(());
        };
        let unsupported = self.unsupported(op, inst.pos);
        let moved = excess(self.cx.target, op, &inst.args).ok_or(unsupported)?;
        if moved.is_empty() {
            self.push(inst);
            return Ok(());
        }
        if let (Some(_), Some(&Arg::Const(Bits::Word(address)))) =
            (op.access_bytes(), inst.args.get(1))
        {
            // One register with zero serves all such accesses.
            inst.imm = inst.imm.wrapping_add_unsigned(address);
            inst.args[1] = self
                .in_register(Arg::Const(Bits::Word(0)), inst.pos)
                .map(Arg::Reg)?;
            return self.legal(inst);
        }
        for i in moved {
            inst.args[i] = self.in_register(inst.args[i], inst.pos).map(Arg::Reg)?;
        }
        self.push(inst);
        Ok(())
    }

    /// A register with this constant. Outside of loops it is set in the block, else at the
    /// function's entry; a spill makes it anew.
    pub(super) fn in_register(&mut self, arg: Arg, pos: Pos) -> Result<Vreg, VliwError> {
        if let Some(&reg) = self.near.get(&arg).or_else(|| self.far.get(&arg)) {
            return Ok(reg);
        }
        let ty = match arg {
            Arg::Const(bits) => bits.ty(),
            Arg::Frame(..) => Ty::Word,
            Arg::Reg(reg) => return Ok(reg),
        };
        let dst = self.code.fresh(ty, Split::Whole);
        let inst = match arg {
            Arg::Frame(..) => Inst::op(Opcode::Add, vec![self.sp(), arg], pos).to(dst),
            _ => Inst::mov(ty, dst, arg, pos),
        };
        let Kind::Op(op) = inst.kind else {
            unreachable!("a constant is made by an operation")
        };
        if excess(self.cx.target, op, &inst.args).is_none_or(|moved| !moved.is_empty()) {
            return Err(self.unsupported(op, pos));
        }
        if self.code.blocks[self.at].depth > 0 {
            self.far_insts.push(inst);
            self.far.insert(arg, dst);
        } else {
            self.push(inst);
            self.near.insert(arg, dst);
        }
        Ok(dst)
    }
}
