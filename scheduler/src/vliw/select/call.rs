//! The calling convention: values pass as [`abi::passing`](crate::abi::passing) says, and on the
//! stack where it finds no register for them: arguments first, results behind, in the outgoing area
//! of the caller's frame. A call keeps no register but the stack pointer; a launch destroys what
//! its schedule writes.
//!
//! A predicate on the stack is a word, and so takes a word register on its way. Hence words are the
//! last to be set before a call and the first to be taken after it.

use super::Selector;
use crate::abi;
use crate::vliw::lir::{
    Arg, End, FRAME_ALIGN, FrameItem, FrameTerm, Inst, Kind, Split, Vreg, stack_bytes,
};
use crate::vliw::{VliwError, place};
use srp_archdesc::arch::FileKind;
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::dre::scheduled::{ModuloSchedule, Reg};
use srp_ir::program::{Bits, Callee, Func, Function, Kernel, Pos, Value};

/// Where a value passes.
#[derive(Clone, Copy)]
enum Where {
    /// In a register of the machine.
    Reg(Vreg),
    /// At this byte of the area.
    Stack(u32),
}

/// Where the values of a call pass.
struct Passage {
    params: Vec<Where>,
    results: Vec<Where>,
    /// Bytes of the area.
    bytes: u32,
}

/// The order in which values are set before a call; backwards, the one in which they are taken.
fn rank(at: Where, ty: Ty) -> u32 {
    match (at, ty) {
        (Where::Stack(_), _) => 0,
        (_, Ty::Pred) => 1,
        (_, Ty::Vec) => 2,
        (_, Ty::Word) => 3,
    }
}

impl Selector<'_> {
    fn passage(&self, params: &[Ty], results: &[Ty]) -> Passage {
        let mut bytes = 0u32;
        let mut side = |types: &[Ty]| {
            let regs = abi::passing(self.cx.target.srp, types.iter().copied());
            let wheres = regs.into_iter().zip(types).map(|(reg, &ty)| match reg {
                Some(reg) => Where::Reg(self.central(reg)),
                None => {
                    let at = bytes.next_multiple_of(stack_bytes(ty));
                    bytes = at + stack_bytes(ty);
                    Where::Stack(at)
                }
            });
            let wheres: Vec<_> = wheres.collect();
            bytes = bytes.next_multiple_of(FRAME_ALIGN as u32);
            wheres
        };
        let (params, results) = (side(params), side(results));
        Passage {
            params,
            results,
            bytes,
        }
    }

    fn central(&self, reg: Reg) -> Vreg {
        let number = self.cx.target.number(reg);
        self.phys(number.expect("values pass in central registers"))
    }

    /// Stores a value to the stack.
    fn store(&mut self, value: Arg, ty: Ty, item: FrameItem, pos: Pos) -> Result<(), VliwError> {
        let (op, value) = match ty {
            Ty::Word => (Opcode::Sw, value),
            Ty::Vec => (Opcode::Sv, value),
            Ty::Pred => {
                let word = self.code.fresh(Ty::Word, Split::Whole);
                self.legal(Inst::op(Opcode::Ptoi, vec![value], pos).to(word))?;
                (Opcode::Sw, Arg::Reg(word))
            }
        };
        let args = vec![Arg::Const(Bits::Pred(true)), self.sp(), value];
        self.legal(Inst::private(op, args, item, pos))
    }

    /// Loads a value from the stack.
    fn load(&mut self, dst: Vreg, ty: Ty, item: FrameItem, pos: Pos) -> Result<(), VliwError> {
        let args = vec![Arg::Const(Bits::Pred(true)), self.sp()];
        let (op, to) = match ty {
            Ty::Word => (Opcode::Lw, dst),
            Ty::Vec => (Opcode::Lv, dst),
            Ty::Pred => (Opcode::Lw, self.code.fresh(Ty::Word, Split::Whole)),
        };
        self.legal(Inst::private(op, args, item, pos).to(to))?;
        if ty == Ty::Pred {
            let args = vec![Arg::Reg(to), Arg::Const(Bits::Word(0))];
            self.legal(Inst::op(Opcode::Ne, args, pos).to(dst))?;
        }
        Ok(())
    }

    /// Puts values where they pass; gives the registers among these places.
    fn give(
        &mut self,
        values: &[(Ty, Arg)],
        places: &[Where],
        item: fn(u32) -> FrameItem,
        pos: Pos,
    ) -> Result<Vec<Vreg>, VliwError> {
        let mut regs = Vec::new();
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by_key(|&i| rank(places[i], values[i].0));
        for i in order {
            let (ty, value) = values[i];
            match places[i] {
                Where::Stack(byte) => self.store(value, ty, item(byte), pos)?,
                Where::Reg(reg) => {
                    self.legal(Inst::mov(ty, reg, value, pos))?;
                    regs.push(reg);
                }
            }
        }
        Ok(regs)
    }

    /// Takes values from where they pass.
    fn take(
        &mut self,
        values: &[Value],
        places: &[Where],
        item: fn(u32) -> FrameItem,
        pos: Pos,
    ) -> Result<(), VliwError> {
        let mut order: Vec<usize> = (0..values.len()).collect();
        let types = &self.func.values;
        order.sort_by_key(|&i| std::cmp::Reverse(rank(places[i], types[values[i]])));
        for i in order {
            let ty = self.func.values[values[i]];
            let dst = self.reg(values[i]);
            match places[i] {
                Where::Stack(byte) => self.load(dst, ty, item(byte), pos)?,
                Where::Reg(reg) => self.legal(Inst::mov(ty, dst, Arg::Reg(reg), pos))?,
            }
        }
        Ok(())
    }

    fn typed(&mut self, values: &[Value], pos: Pos) -> Result<Vec<(Ty, Arg)>, VliwError> {
        let typed = values.iter().map(|&v| {
            let arg = self.arg(v, pos)?;
            Ok((self.func.values[v], arg))
        });
        typed.collect()
    }

    pub(super) fn call(
        &mut self,
        callee: &Callee,
        args: &[Value],
        results: &[Value],
        pos: Pos,
    ) -> Result<(), VliwError> {
        let types: Vec<Ty> = results.iter().map(|&v| self.func.values[v]).collect();
        let values = self.typed(args, pos)?;
        let passage = self.passage(&values.iter().map(|v| v.0).collect::<Vec<_>>(), &types);
        self.transfer(callee, &values, &passage, pos)?;
        self.take(results, &passage.results, FrameItem::Outgoing, pos)
    }

    /// Sets the arguments and calls.
    fn transfer(
        &mut self,
        callee: &Callee,
        values: &[(Ty, Arg)],
        passage: &Passage,
        pos: Pos,
    ) -> Result<(), VliwError> {
        let link = self.phys(self.cx.target.link());
        let kind = match callee {
            Callee::Func(func) => Kind::Call(*func),
            Callee::Indirect(target, _) => {
                // The link register is free: it was saved, and the call writes it anyway.
                let target = self.arg(*target, pos)?;
                self.legal(Inst::mov(Ty::Word, link, target, pos))?;
                Kind::CallLink
            }
        };
        let frame = &mut self.code.frame;
        frame.outgoing = frame.outgoing.max(passage.bytes);
        let mut used = self.give(values, &passage.params, FrameItem::Outgoing, pos)?;
        if kind == Kind::CallLink {
            used.push(link);
        }
        let regs = passage.results.iter().filter_map(|&at| match at {
            Where::Reg(reg) => Some(reg),
            Where::Stack(_) => None,
        });
        let target = self.cx.target;
        let all = target.allocatable.values().flatten().copied();
        let clobbers = all.chain([target.link()]).map(|n| self.phys(n)).collect();
        self.push(Inst {
            kind,
            args: used.into_iter().map(Arg::Reg).collect(),
            defs: regs.collect(),
            clobbers,
            ..Inst::op(Opcode::Mov, Vec::new(), pos)
        });
        Ok(())
    }

    /// Calls `main` with zeros; gives the register with the status to halt with.
    pub(super) fn call_main(
        &mut self,
        main: Func,
        function: &Function,
        pos: Pos,
    ) -> Result<Vreg, VliwError> {
        let params = &function.blocks[function.entry()].params;
        let types: Vec<Ty> = params.iter().map(|&p| function.values[p]).collect();
        let passage = self.passage(&types, &function.results);
        let zeros = types.iter().map(|&ty| (ty, Arg::Const(Bits::zero(ty))));
        let zeros: Vec<_> = zeros.collect();
        self.transfer(&Callee::Func(main), &zeros, &passage, pos)?;
        let status = self.code.fresh(Ty::Word, Split::Whole);
        match (function.results.first(), passage.results.first()) {
            (Some(Ty::Word), Some(&Where::Reg(reg))) => {
                self.legal(Inst::mov(Ty::Word, status, Arg::Reg(reg), pos))?;
            }
            (Some(Ty::Word), Some(&Where::Stack(byte))) => {
                self.load(status, Ty::Word, FrameItem::Outgoing(byte), pos)?;
            }
            _ => {
                let zero = Arg::Const(Bits::Word(0));
                self.legal(Inst::mov(Ty::Word, status, zero, pos))?;
            }
        }
        Ok(status)
    }

    /// Takes the function's parameters.
    pub(super) fn receive_params(&mut self, pos: Pos) -> Result<(), VliwError> {
        let params = &self.func.blocks[self.func.entry()].params;
        let types: Vec<Ty> = params.iter().map(|&p| self.func.values[p]).collect();
        let passage = self.passage(&types, &self.func.results);
        self.take(params, &passage.params, FrameItem::Incoming, pos)
    }

    /// Returns these values.
    pub(super) fn leave(&mut self, values: &[Value], pos: Pos) -> Result<(), VliwError> {
        let params = &self.func.blocks[self.func.entry()].params;
        let params: Vec<Ty> = params.iter().map(|&p| self.func.values[p]).collect();
        let values = self.typed(values, pos)?;
        let passage = self.passage(&params, &self.func.results);
        let used = self.give(&values, &passage.results, FrameItem::Incoming, pos)?;
        if self.code.frame.saves_link {
            let link = self.phys(self.cx.target.link());
            self.load(link, Ty::Word, FrameItem::Link, pos)?;
        }
        self.adjust_stack(FrameTerm::Size, pos)?;
        self.end(End::Return(used), pos);
        Ok(())
    }

    pub(super) fn launch(
        &mut self,
        kernel: Kernel,
        args: &[Value],
        results: &[Value],
        pos: Pos,
    ) -> Result<(), VliwError> {
        let schedule = self.cx.kernels.get(kernel).filter(|s| {
            let (ins, outs) = (&s.live_in_regs, &s.live_out_regs);
            ins.len() == args.len()
                && outs.len() == results.len()
                && ins
                    .iter()
                    .chain(outs)
                    .all(|&r| self.cx.target.number(r).is_some())
        });
        let schedule = schedule.ok_or_else(|| VliwError::Launch {
            kernel,
            at: place(self.cx.program, &self.func.name, pos),
        })?;
        let places = |regs: &[Reg]| -> Vec<Where> {
            let wheres = regs.iter().map(|&r| Where::Reg(self.central(r)));
            wheres.collect()
        };
        let (ins, outs) = (
            places(&schedule.live_in_regs),
            places(&schedule.live_out_regs),
        );
        let clobbers = self.clobbers(schedule);
        let values = self.typed(args, pos)?;
        let used = self.give(&values, &ins, FrameItem::Outgoing, pos)?;
        let defs = outs.iter().filter_map(|&at| match at {
            Where::Reg(reg) => Some(reg),
            Where::Stack(_) => None,
        });
        self.push(Inst {
            kind: Kind::Launch(kernel),
            args: used.into_iter().map(Arg::Reg).collect(),
            defs: defs.collect(),
            clobbers,
            ..Inst::op(Opcode::Mov, Vec::new(), pos)
        });
        self.take(results, &outs, FrameItem::Outgoing, pos)
    }

    /// The central registers that a kernel writes.
    fn clobbers(&self, schedule: &ModuloSchedule) -> Vec<Vreg> {
        let files = &self.cx.target.srp.files;
        let writes = schedule.ops.values().flat_map(|op| &op.writes);
        let written = writes.chain(schedule.transfers.iter().map(|t| &t.to));
        let rings = written.map(|w| (w.file, w.index, w.ring));
        let preloads = schedule.preloads.iter().map(|p| (p.file, p.index, 1));
        let central = rings
            .chain(preloads)
            .filter(|&(file, ..)| files[file].kind == FileKind::Central);
        let regs =
            central.flat_map(|(file, index, ring)| (index..index + ring).map(move |i| (file, i)));
        let numbers = regs.filter_map(|(file, index)| self.cx.target.number(Reg { file, index }));
        let distinct: std::collections::BTreeSet<u32> = numbers.collect();
        distinct.into_iter().map(|n| self.phys(n)).collect()
    }
}
