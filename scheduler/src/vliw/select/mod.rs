//! Code selection: one function of the control program to low-level code over virtual registers.
//!
//! The opcodes are the machine's already, so what is left is where operands come from. Constants
//! and addresses become operands where a slot's context has room for them and registers where not;
//! an addition of a constant in an address becomes the access's immediate; block parameters become
//! parallel copies on the edges, each edge that starts at a branch in a block of its own, so that
//! no copy disturbs the other way.

mod call;
mod copies;
mod operand;

pub(super) use operand::excess;

use super::lir::{
    Arg, Code, CodeBlock, End, Frame, FrameItem, FrameTerm, Inst, Label, RegData, Split, Vreg,
};
use super::loops;
use super::target::Target;
use super::{VliwError, place};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::check::sequence::Storage;
use srp_ir::dre::scheduled::ModuloSchedule;
use srp_ir::layout::Layout;
use srp_ir::pass::Objects;
use srp_ir::program::{
    Bits, Block, Func, Function, Inst as IrInst, InstKind, Kernel, Pos, Program, Target as Goal,
    Terminator, Value,
};
use std::collections::BTreeMap;

/// The parts of the program and machine that code selection needs.
pub(super) struct Context<'a> {
    pub(super) program: &'a Program,
    pub(super) kernels: &'a EntityMap<Kernel, ModuloSchedule>,
    pub(super) target: &'a Target<'a>,
    pub(super) layout: &'a Layout,
}

/// The low-level code of `func`; if `recursive`, it checks the stack's depth at its entry.
pub(super) fn select(cx: &Context<'_>, func: Func, recursive: bool) -> Result<Code, VliwError> {
    let mut selector = Selector::new(cx, &cx.program.funcs[func]);
    selector.prologue(recursive)?;
    for block in selector.blocks.clone() {
        selector.block(block)?;
    }
    Ok(selector.finish())
}

/// The code that runs first: sets up the stack, calls `main`, if there is one, with zeros, and halts
/// with its result.
pub(super) fn start(cx: &Context<'_>) -> Result<Code, VliwError> {
    let main = cx.program.main;
    let pos = main.map_or(Pos::nowhere(), |main| cx.program.funcs[main].pos);
    let empty = Function::new("start", &[], Vec::new(), pos);
    let mut selector = Selector::new(cx, &empty);
    if let Some(main) = main {
        selector.start(main, &cx.program.funcs[main])?;
    }
    Ok(selector.finish())
}

struct Selector<'a> {
    cx: &'a Context<'a>,
    func: &'a Function,
    code: Code,
    /// Reachable blocks in order.
    blocks: Vec<Block>,
    labels: EntityMap<Block, Label>,
    /// The objects of its addresses.
    objects: Objects,
    /// The instruction that defines each value, if it is not a parameter.
    defs: EntityMap<Value, Option<IrInst>>,
    /// The register of each value, once it has one.
    regs: EntityMap<Value, Option<Vreg>>,
    /// The block that is being filled.
    at: Label,
    /// Constants in registers in this block.
    near: BTreeMap<Arg, Vreg>,
    /// Constants in registers everywhere: set in the first block.
    far: BTreeMap<Arg, Vreg>,
    far_insts: Vec<Inst>,
    first: Label,
}

impl<'a> Selector<'a> {
    fn new(cx: &'a Context<'a>, func: &'a Function) -> Selector<'a> {
        let mut defs = EntityMap::filled(func.values.len(), None);
        for (inst, data) in func.insts.iter() {
            data.results.iter().for_each(|&v| defs[v] = Some(inst));
        }
        let depth = loops::depths(func.blocks.len(), func.entry().index(), |b| {
            let targets = func.blocks[Block::new(b)].end.targets();
            targets.map(|t| t.block.index()).collect()
        });
        let mut selector = Selector {
            cx,
            func,
            code: empty_code(cx.target, func),
            objects: Objects::of(func),
            blocks: Vec::new(),
            labels: EntityMap::new(),
            defs,
            regs: EntityMap::filled(func.values.len(), None),
            at: Label::new(0),
            near: BTreeMap::new(),
            far: BTreeMap::new(),
            far_insts: Vec::new(),
            first: Label::new(0),
        };
        selector.first = selector.new_block(0);
        for block in func.blocks.keys() {
            let depth = depth[block.index()];
            let label = selector.new_block(depth.unwrap_or(0));
            selector.labels.push(label);
        }
        let reachable = |b: &Block| depth[b.index()].is_some();
        selector.blocks = func.layout.iter().copied().filter(reachable).collect();
        selector.at = selector.first;
        selector.code.order.push(selector.first);
        selector
    }

    fn new_block(&mut self, depth: u32) -> Label {
        self.code.blocks.push(CodeBlock {
            insts: Vec::new(),
            end: End::Unreachable,
            end_pos: Pos::nowhere(),
            depth,
        })
    }

    /// A register of the machine.
    fn phys(&self, number: u32) -> Vreg {
        Vreg::new(number as usize)
    }

    fn sp(&self) -> Arg {
        Arg::Reg(self.phys(self.cx.target.sp()))
    }

    fn push(&mut self, inst: Inst) {
        self.code.blocks[self.at].insts.push(inst);
    }

    fn end(&mut self, end: End, pos: Pos) {
        let block = &mut self.code.blocks[self.at];
        block.end = end;
        block.end_pos = pos;
    }

    /// Begins to fill `label`, which follows in the layout.
    fn begin(&mut self, label: Label) {
        self.at = label;
        self.near.clear();
        self.code.order.push(label);
    }

    /// The register of a value.
    fn reg(&mut self, value: Value) -> Vreg {
        if let Some(reg) = self.regs[value] {
            return reg;
        }
        let reg = self.code.fresh(self.func.values[value], Split::Whole);
        self.regs[value] = Some(reg);
        reg
    }

    fn block(&mut self, block: Block) -> Result<(), VliwError> {
        self.begin(self.labels[block]);
        let data = &self.func.blocks[block];
        for &inst in &data.insts {
            self.inst(inst)?;
        }
        self.terminator(&data.end, data.end_pos)
    }

    fn inst(&mut self, inst: IrInst) -> Result<(), VliwError> {
        let data = &self.func.insts[inst];
        let pos = data.pos;
        match &data.kind {
            // Made where they are used.
            InstKind::Const(_) | InstKind::SymbolAddr(..) | InstKind::SlotAddr(..) => Ok(()),
            InstKind::Op { op, args, imm } => {
                let result = data.results.first().copied();
                self.operation(*op, args, *imm, result, pos)
            }
            InstKind::Call { callee, args } => self.call(callee, args, &data.results, pos),
            InstKind::Launch { kernel, args } => self.launch(*kernel, args, &data.results, pos),
        }
    }

    fn operation(
        &mut self,
        op: Opcode,
        args: &[Value],
        imm: i32,
        result: Option<Value>,
        pos: Pos,
    ) -> Result<(), VliwError> {
        let mut inst = Inst::op(op, Vec::with_capacity(args.len()), pos);
        inst.imm = imm;
        for (i, &arg) in args.iter().enumerate() {
            let arg = if op.access_bytes().is_some() && i == 1 {
                if let Some(object) = self.objects.object(arg) {
                    inst.storage = Storage::Object(object, arg);
                }
                self.address(arg, &mut inst)
            } else {
                self.arg(arg, pos)?
            };
            inst.args.push(arg);
        }
        if let Some(result) = result {
            let reg = self.reg(result);
            inst = inst.to(reg);
        }
        self.legal(inst)
    }

    fn terminator(&mut self, end: &Terminator, pos: Pos) -> Result<(), VliwError> {
        match end {
            Terminator::Jump(to) => {
                self.bring(to, pos)?;
                self.end(End::Jump(self.labels[to.block]), pos);
            }
            Terminator::Branch { cond, then, other } => {
                self.branch(*cond, then, other, pos)?;
            }
            Terminator::Return(values) => self.leave(values, pos)?,
            Terminator::Unreachable => self.end(End::Unreachable, pos),
        }
        Ok(())
    }

    fn branch(
        &mut self,
        cond: Value,
        then: &Goal,
        other: &Goal,
        pos: Pos,
    ) -> Result<(), VliwError> {
        let (mut cond, mut sense) = (cond, true);
        while let Some(InstKind::Op {
            op: Opcode::Pnot,
            args,
            ..
        }) = self.def(cond)
        {
            cond = args[0];
            sense = !sense;
        }
        if let Some(InstKind::Const(bits)) = self.def(cond) {
            let taken = (*bits == Bits::Pred(true)) == sense;
            let to = if taken { then } else { other };
            self.bring(to, pos)?;
            self.end(End::Jump(self.labels[to.block]), pos);
            return Ok(());
        }
        let from = self.at;
        let edges = [self.edge(then), self.edge(other)];
        let cond = self.reg(cond);
        let end = End::Branch {
            cond,
            sense,
            then: edges[0],
            other: edges[1],
        };
        self.end(end, pos);
        let depth = self.code.blocks[from].depth;
        for (goal, label) in [then, other].into_iter().zip(edges) {
            let to = self.labels[goal.block];
            if label != to {
                self.code.blocks[label].depth = depth.min(self.code.blocks[to].depth);
                self.begin(label);
                self.bring(goal, pos)?;
                self.end(End::Jump(to), pos);
            }
        }
        Ok(())
    }

    /// Where a branch to `goal` goes: to a block between if there are values to bring.
    fn edge(&mut self, goal: &Goal) -> Label {
        if goal.args.is_empty() {
            self.labels[goal.block]
        } else {
            self.new_block(0)
        }
    }

    /// Copies the values that a jump brings to the parameters of its target.
    fn bring(&mut self, goal: &Goal, pos: Pos) -> Result<(), VliwError> {
        let params = &self.func.blocks[goal.block].params;
        let mut moves = Vec::new();
        for (&param, &arg) in params.iter().zip(&goal.args) {
            let src = self.arg(arg, pos)?;
            moves.push((self.reg(param), src));
        }
        for (dst, src) in copies::sequence(&mut self.code, moves) {
            self.legal(Inst::mov(self.code.regs[dst].ty, dst, src, pos))?;
        }
        Ok(())
    }

    fn def(&self, value: Value) -> Option<&'a InstKind> {
        self.defs[value].map(|inst| &self.func.insts[inst].kind)
    }

    fn prologue(&mut self, recursive: bool) -> Result<(), VliwError> {
        let pos = self.func.pos;
        let calls = |inst: &IrInst| matches!(self.func.insts[*inst].kind, InstKind::Call { .. });
        let mut insts = self.blocks.iter().flat_map(|&b| &self.func.blocks[b].insts);
        self.code.frame.saves_link = insts.any(calls);
        self.adjust_stack(FrameTerm::NegSize, pos)?;
        if self.code.frame.saves_link {
            let link = Arg::Reg(self.phys(self.cx.target.link()));
            let args = vec![Arg::Const(Bits::Pred(true)), self.sp(), link];
            self.legal(Inst::private(Opcode::Sw, args, FrameItem::Link, pos))?;
        }
        self.receive_params(pos)?;
        let entry = self.labels[self.func.entry()];
        if !recursive {
            self.end(End::Jump(entry), pos);
            return Ok(());
        }
        let overflow = self.new_block(0);
        let cond = self.code.fresh(Ty::Pred, Split::Whole);
        let args = vec![self.sp(), Arg::Frame(FrameTerm::Limit, 0)];
        self.legal(Inst::op(Opcode::Lt, args, pos).to(cond))?;
        let end = End::Branch {
            cond,
            sense: true,
            then: overflow,
            other: entry,
        };
        self.end(end, pos);
        self.begin(overflow);
        self.end(End::StackOverflow, pos);
        Ok(())
    }

    fn adjust_stack(&mut self, by: FrameTerm, pos: Pos) -> Result<(), VliwError> {
        let args = vec![self.sp(), Arg::Frame(by, 0)];
        let sp = self.phys(self.cx.target.sp());
        self.legal(Inst::op(Opcode::Add, args, pos).to(sp))
    }

    fn start(&mut self, main: Func, function: &Function) -> Result<(), VliwError> {
        let pos = function.pos;
        let top = Arg::Const(Bits::Word(self.cx.layout.stack_top));
        let sp = self.phys(self.cx.target.sp());
        self.legal(Inst::mov(Ty::Word, sp, top, pos))?;
        self.adjust_stack(FrameTerm::NegSize, pos)?;
        let status = self.call_main(main, function, pos)?;
        self.end(End::Halt(status), pos);
        Ok(())
    }

    fn finish(mut self) -> Code {
        let first = &mut self.code.blocks[self.first];
        // Only an overflow check follows, and it uses none of them.
        first.insts.append(&mut self.far_insts);
        self.code.drop_dead();
        self.code
    }

    fn unsupported(&self, op: Opcode, pos: Pos) -> VliwError {
        VliwError::Unsupported {
            op,
            at: place(self.cx.program, &self.func.name, pos),
        }
    }
}

fn empty_code(target: &Target<'_>, func: &Function) -> Code {
    let physical = (0..target.physical()).map(|n| {
        let file = &target.srp.files[target.reg(n).file];
        let fits = |ty: &&Ty| file.holds(**ty);
        RegData {
            ty: *Ty::ALL.iter().rfind(fits).unwrap_or(&Ty::Pred),
            split: Split::Atom,
            home: None,
        }
    });
    let slots = func.slots.values().map(|s| (s.size, s.align)).collect();
    Code {
        name: func.name.clone(),
        regs: physical.collect(),
        blocks: EntityMap::new(),
        order: Vec::new(),
        frame: Frame {
            slots,
            ..Frame::default()
        },
    }
}
