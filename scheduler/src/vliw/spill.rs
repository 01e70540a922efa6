//! Spilling: values that found no register live on the stack, and come into a register for their
//! uses only.
//!
//! The first spill of a value leaves it one piece a block, from its definition or first use to the
//! last use before the next call; a piece that is spilled again is cut into single uses, which
//! always find a register on a machine that has enough for one operation. What can be made anew (a
//! constant, a frame address, a value that has a copy on the stack) is not stored.

use super::lir::{Arg, Code, FrameItem, FrameTerm, Inst, Kind, Label, Split, Vreg};
use super::select::excess;
use super::target::Target;
use super::{VliwError, allocate};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::check::sequence::Storage;
use srp_ir::program::{Bits, Pos};
use std::collections::BTreeMap;

/// Spills `values`, virtual registers of `code`.
pub(super) fn spill(
    code: &mut Code,
    target: &Target<'_>,
    values: &[Vreg],
) -> Result<(), VliwError> {
    let mut defs: BTreeMap<Vreg, Vec<Inst>> = values.iter().map(|&v| (v, Vec::new())).collect();
    for &label in &code.order {
        for inst in &code.blocks[label].insts {
            for def in &inst.defs {
                if let Some(list) = defs.get_mut(def) {
                    list.push(inst.clone());
                }
            }
        }
    }
    let sp = Vreg::new(target.sp() as usize);
    let mut plans = BTreeMap::new();
    for (value, defs) in defs {
        let plan = plan(code, value, &defs, sp);
        plans.insert(value, plan);
    }
    let mut spiller = Spiller {
        code,
        target,
        plans,
        sp,
        pieces: BTreeMap::new(),
        out: Vec::new(),
    };
    for label in spiller.code.order.clone() {
        spiller.block(label)?;
    }
    Ok(())
}

/// How a value comes back.
#[derive(Clone)]
enum Plan {
    /// By this operation, whose own result is left out.
    Remake(Inst),
    /// From this place on the stack, where its definitions store it.
    Home(u32),
}

fn plan(code: &mut Code, value: Vreg, defs: &[Inst], sp: Vreg) -> Plan {
    let same =
        |a: &Inst, b: &Inst| (a.kind, &a.args, a.imm, a.frame) == (b.kind, &b.args, b.imm, b.frame);
    if let Some(first) = defs.first() {
        let again = allocate::is_remade(first, sp) || is_settled_load(first);
        if again && defs.iter().all(|d| same(d, first)) {
            let mut inst = first.clone();
            inst.defs.clear();
            return Plan::Remake(inst);
        }
    }
    if let Some(home) = code.regs[value].home {
        return Plan::Home(home);
    }
    code.frame.homes.push(code.regs[value].ty);
    Plan::Home(code.frame.homes.len() as u32 - 1)
}

/// True if it loads from a place that keeps its value: that of a piece, or an argument on the
/// stack.
fn is_settled_load(inst: &Inst) -> bool {
    let settled = matches!(
        inst.frame,
        Some(FrameTerm::At(FrameItem::Home(_) | FrameItem::Incoming(_)))
    );
    let loads = matches!(inst.kind, Kind::Op(Opcode::Lw | Opcode::Lv));
    let fixed = inst.args.first() == Some(&Arg::Const(Bits::Pred(true)));
    inst.storage == Storage::Compiler && settled && loads && fixed
}

struct Spiller<'a> {
    code: &'a mut Code,
    target: &'a Target<'a>,
    plans: BTreeMap<Vreg, Plan>,
    sp: Vreg,
    /// Values that stand in a register just now.
    pieces: BTreeMap<Vreg, Vreg>,
    out: Vec<Inst>,
}

impl Spiller<'_> {
    fn block(&mut self, label: Label) -> Result<(), VliwError> {
        self.pieces.clear();
        for inst in std::mem::take(&mut self.code.blocks[label].insts) {
            self.inst(inst)?;
        }
        let mut end = self.code.blocks[label].end.clone();
        let pos = self.code.blocks[label].end_pos;
        let used: Vec<Vreg> = end.uses().collect();
        for value in used {
            if self.plans.contains_key(&value) {
                let piece = self.piece(value, pos)?;
                end.rename(|r| if r == value { piece } else { r });
            }
        }
        let block = &mut self.code.blocks[label];
        block.end = end;
        block.insts = std::mem::take(&mut self.out);
        Ok(())
    }

    fn inst(&mut self, mut inst: Inst) -> Result<(), VliwError> {
        if self.is_undone(&inst) {
            return Ok(());
        }
        // A move from or to the stack needs no register of its own.
        if let Some((dst, src)) = inst.as_copy() {
            match (self.plans.contains_key(&dst), self.plans.contains_key(&src)) {
                (false, true) if !self.pieces.contains_key(&src) => {
                    return self.bring(src, dst, inst.pos);
                }
                (true, false) => {
                    self.pieces.remove(&dst);
                    return self.keep(dst, src, inst.pos);
                }
                _ => {}
            }
        }
        let used: Vec<Vreg> = inst.uses().collect();
        for value in used {
            if self.plans.contains_key(&value) {
                let piece = self.piece(value, inst.pos)?;
                let args = inst.args.iter_mut().filter(|a| **a == Arg::Reg(value));
                args.for_each(|a| *a = Arg::Reg(piece));
            }
        }
        if !inst.clobbers.is_empty() {
            self.pieces.clear();
        }
        let mut stored = Vec::new();
        for i in 0..inst.defs.len() {
            let value = inst.defs[i];
            if self.plans.contains_key(&value) {
                inst.defs[i] = self.fresh(value);
                stored.push((value, inst.defs[i]));
            }
        }
        let pos = inst.pos;
        self.out.push(inst);
        for (value, piece) in stored {
            self.keep(value, piece, pos)?;
            self.remember(value, piece);
        }
        Ok(())
    }

    /// True if the operation stored a value that is spilled again to its stack place, or makes a
    /// value that is now made at its uses.
    fn is_undone(&self, inst: &Inst) -> bool {
        if let [def] = inst.defs[..]
            && let Some(Plan::Remake(_)) = self.plans.get(&def)
        {
            return true;
        }
        let home = match inst.frame {
            Some(FrameTerm::At(FrameItem::Home(home))) if inst.storage == Storage::Compiler => home,
            _ => return false,
        };
        let is_store = matches!(inst.kind, Kind::Op(Opcode::Sw | Opcode::Sv));
        let stored = inst.args.get(2);
        is_store
            && matches!(stored, Some(Arg::Reg(r)) if self.code.regs[*r].home == Some(home)
                && matches!(self.plans.get(r), Some(Plan::Home(_))))
    }

    /// The register of a new piece of `value`.
    fn fresh(&mut self, value: Vreg) -> Vreg {
        let data = self.code.regs[value];
        let is_remade = matches!(self.plans[&value], Plan::Remake(_));
        // A predicate takes two operations to come back, which cannot be remade as one.
        let split = if data.split == Split::Whole && (is_remade || data.ty != Ty::Pred) {
            Split::Block
        } else {
            Split::Atom
        };
        let piece = self.code.fresh(data.ty, split);
        if let Plan::Home(home) = self.plans[&value] {
            self.code.regs[piece].home = Some(home);
        }
        piece
    }

    fn remember(&mut self, value: Vreg, piece: Vreg) {
        if self.code.regs[piece].split == Split::Block {
            self.pieces.insert(value, piece);
        }
    }

    /// A register that holds `value` now.
    fn piece(&mut self, value: Vreg, pos: Pos) -> Result<Vreg, VliwError> {
        if let Some(&piece) = self.pieces.get(&value) {
            return Ok(piece);
        }
        let piece = self.fresh(value);
        self.bring(value, piece, pos)?;
        self.remember(value, piece);
        Ok(piece)
    }

    /// Brings `value` into register `dst`.
    fn bring(&mut self, value: Vreg, dst: Vreg, pos: Pos) -> Result<(), VliwError> {
        let home = match &self.plans[&value] {
            Plan::Remake(inst) => {
                let inst = inst.clone();
                self.out.push(Inst { pos, ..inst }.to(dst));
                return Ok(());
            }
            Plan::Home(home) => FrameItem::Home(*home),
        };
        let args = vec![Arg::Const(Bits::Pred(true)), Arg::Reg(self.sp)];
        match self.code.regs[value].ty {
            Ty::Word => self.legal(Inst::private(Opcode::Lw, args, home, pos).to(dst)),
            Ty::Vec => self.legal(Inst::private(Opcode::Lv, args, home, pos).to(dst)),
            Ty::Pred => {
                let word = self.code.fresh(Ty::Word, Split::Atom);
                self.legal(Inst::private(Opcode::Lw, args, home, pos).to(word))?;
                let args = vec![Arg::Reg(word), Arg::Const(Bits::Word(0))];
                self.legal(Inst::op(Opcode::Ne, args, pos).to(dst))
            }
        }
    }

    /// Stores `value`, which register `src` holds, in its place.
    fn keep(&mut self, value: Vreg, src: Vreg, pos: Pos) -> Result<(), VliwError> {
        let Plan::Home(home) = self.plans[&value] else {
            return Ok(());
        };
        let (op, src) = match self.code.regs[value].ty {
            Ty::Word => (Opcode::Sw, src),
            Ty::Vec => (Opcode::Sv, src),
            Ty::Pred => {
                let word = self.code.fresh(Ty::Word, Split::Atom);
                self.legal(Inst::op(Opcode::Ptoi, vec![Arg::Reg(src)], pos).to(word))?;
                (Opcode::Sw, word)
            }
        };
        let args = vec![
            Arg::Const(Bits::Pred(true)),
            Arg::Reg(self.sp),
            Arg::Reg(src),
        ];
        self.legal(Inst::private(op, args, FrameItem::Home(home), pos))
    }

    /// Appends an operation, with constants that have no room in registers.
    fn legal(&mut self, mut inst: Inst) -> Result<(), VliwError> {
        let Kind::Op(op) = inst.kind else {
            unreachable!("spill code is made of operations")
        };
        let name = self.code.name.clone();
        let missing = |op| VliwError::Unsupported {
            op,
            at: format!("in `{name}`"),
        };
        let moved = excess(self.target, op, &inst.args).ok_or_else(|| missing(op))?;
        for i in moved {
            let Arg::Const(bits) = inst.args[i] else {
                unreachable!("spill code has no addresses as operands")
            };
            let mov = Opcode::mov(bits.ty());
            if self.target.max_constants(mov).is_none_or(|room| room == 0) {
                return Err(missing(mov));
            }
            let reg = self.code.fresh(bits.ty(), Split::Atom);
            let mov = Inst::mov(bits.ty(), reg, inst.args[i], inst.pos);
            self.out.push(mov);
            inst.args[i] = Arg::Reg(reg);
        }
        self.out.push(inst);
        Ok(())
    }
}
