//! Which loops the array can run, as far as their shape goes: one block that jumps back to itself.

use super::places::{Def, Places};
use super::{Reason, Refusal};
use crate::flow::Flow;
use crate::pass::{MAX_UNROLL, trip};
use crate::program::{
    Bits, Block, Callee, Func, Function, InstKind, Program, Target, Terminator, Value,
};
use srp_archdesc::arch::Precision;
use srp_archdesc::isa::{Effect, Opcode, Ty};
use std::collections::BTreeSet;

/// A value from outside the loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outer {
    /// A constant.
    Const(Bits),
    /// A value of the control code.
    Value(Value),
}

/// A loop of one block.
pub(super) struct Loop<'a> {
    pub(super) func: &'a Function,
    /// Header, body and latch.
    pub(super) block: Block,
    places: &'a Places,
    /// For each parameter, its value in the next iteration.
    pub(super) next: Vec<Value>,
    /// For each parameter, its value in the first iteration. Where the loop is entered with
    /// different values, the parameter stands for whichever it was.
    pub(super) initial: Vec<Outer>,
    /// Where the loop goes when it ends.
    pub(super) exit: Target,
    /// The loop goes on while this is `sense`.
    pub(super) cond: Value,
    pub(super) sense: bool,
    /// Values of the loop that are used after it.
    pub(super) used_after: BTreeSet<Value>,
}

impl<'a> Loop<'a> {
    /// True if nothing that the function loads is based on a `restrict` pointer.
    pub(super) fn restrict_stays(&self) -> bool {
        self.places.restrict_stays
    }

    /// The loop with this header.
    pub(super) fn of(
        program: &'a Program,
        func: &'a Function,
        places: &'a Places,
        block: Block,
    ) -> Result<Loop<'a>, Refusal> {
        let data = &func.blocks[block];
        let endless = Refusal {
            pos: data.end_pos,
            reason: Reason::NeverEnds,
        };
        let (cond, sense, back, exit) = match &data.end {
            Terminator::Branch { cond, then, other } => {
                match (then.block == block, other.block == block) {
                    (true, false) => (*cond, true, then, other),
                    (false, true) => (*cond, false, other, then),
                    (true, true) => return Err(endless),
                    (false, false) => return Err(why_not_one_block(program, func, block)),
                }
            }
            Terminator::Jump(t) if t.block == block => return Err(endless),
            _ => return Err(why_not_one_block(program, func, block)),
        };
        check_insts(program, func, block)?;
        let mut l = Loop {
            func,
            block,
            places,
            next: back.args.clone(),
            initial: Vec::new(),
            exit: exit.clone(),
            cond,
            sense,
            used_after: BTreeSet::new(),
        };
        l.initial = (0..data.params.len()).map(|i| l.initial_of(i)).collect();
        l.used_after = l.values_used_after();
        Ok(l)
    }

    pub(super) fn params(&self) -> &'a [Value] {
        &self.func.blocks[self.block].params
    }

    /// Where `value` is defined.
    pub(super) fn def(&self, value: Value) -> Option<Def> {
        self.places.defs[value]
    }

    /// The position of `value` among the loop's parameters, if it is one.
    pub(super) fn param_index(&self, value: Value) -> Option<usize> {
        match self.def(value) {
            Some(Def::Param(block, i)) if block == self.block => Some(i),
            _ => None,
        }
    }

    /// True if `value` is defined in the loop.
    pub(super) fn is_inside(&self, value: Value) -> bool {
        match self.def(value) {
            Some(Def::Param(block, _) | Def::Inst(block, _)) => block == self.block,
            None => false,
        }
    }

    /// The instruction that defines `value`, in the loop or before it.
    pub(super) fn inst(&self, value: Value) -> Option<&'a crate::program::InstData> {
        match self.def(value) {
            Some(Def::Inst(_, inst)) => Some(&self.func.insts[inst]),
            _ => None,
        }
    }

    /// The operation that computes `value`, with its operands.
    pub(super) fn op(&self, value: Value) -> Option<(Opcode, &'a [Value])> {
        match &self.inst(value)?.kind {
            InstKind::Op { op, args, .. } => Some((*op, args)),
            _ => None,
        }
    }

    /// The constant that `value` is, if it is one.
    pub(super) fn constant(&self, value: Value) -> Option<Bits> {
        match self.inst(value)?.kind {
            InstKind::Const(bits) => Some(bits),
            _ => None,
        }
    }

    pub(super) fn outer(&self, value: Value) -> Outer {
        self.constant(value)
            .map_or(Outer::Value(value), Outer::Const)
    }

    /// True if `block` is the entry, whose parameters are those of the function.
    pub(super) fn is_entry(&self, block: Block) -> bool {
        self.func.layout.first() == Some(&block)
    }

    pub(super) fn ty(&self, value: Value) -> Ty {
        self.func.values[value]
    }

    /// The jumps to `block` with the blocks they are in.
    pub(super) fn jumps_to(&self, block: Block) -> impl Iterator<Item = (Block, &'a Target)> {
        self.places.preds(block).iter().flat_map(move |&from| {
            let targets = self.func.blocks[from].end.targets();
            targets
                .filter(move |t| t.block == block)
                .map(move |t| (from, t))
        })
    }

    fn initial_of(&self, i: usize) -> Outer {
        let entries = self
            .jumps_to(self.block)
            .filter(|(from, _)| *from != self.block);
        let mut brought = entries.map(|(_, target)| self.outer(target.args[i]));
        let param = Outer::Value(self.params()[i]);
        if self.is_entry(self.block) {
            return param;
        }
        let Some(first) = brought.next() else {
            return param;
        };
        let inside = matches!(first, Outer::Value(v) if self.is_inside(v));
        if !inside && brought.all(|other| other == first) {
            first
        } else {
            param
        }
    }

    fn values_used_after(&self) -> BTreeSet<Value> {
        let data = &self.func.blocks[self.block];
        let results = data.insts.iter().flat_map(|&i| &self.func.insts[i].results);
        let elsewhere = |v: &Value| self.places.users(*v).iter().any(|b| *b != self.block);
        let inside = data.params.iter().chain(results).copied();
        let used = inside.filter(elsewhere);
        let brought = self.exit.args.iter().copied();
        used.chain(brought.filter(|v| self.is_inside(*v))).collect()
    }
}

/// Refuses calls and ports.
fn check_insts(program: &Program, func: &Function, block: Block) -> Result<(), Refusal> {
    for &inst in &func.blocks[block].insts {
        let data = &func.insts[inst];
        let reason = match &data.kind {
            InstKind::Call {
                callee: Callee::Func(callee),
                ..
            } => why_not_inlined(program, *callee),
            InstKind::Call { .. } => Reason::IndirectCall,
            InstKind::Launch { .. } => Reason::Launch,
            InstKind::Op { op, .. } if op.info().effect == Effect::Io => Reason::Port(*op),
            _ => continue,
        };
        return Err(Refusal {
            pos: data.pos,
            reason,
        });
    }
    Ok(())
}

/// Returns the reason why a call is left.
fn why_not_inlined(program: &Program, callee: Func) -> Reason {
    let (mut open, mut reached) = (vec![callee], BTreeSet::new());
    let (mut calls_itself, mut has_port) = (false, false);
    while let Some(func) = open.pop() {
        let func = &program.funcs[func];
        for &inst in func.layout.iter().flat_map(|&b| &func.blocks[b].insts) {
            match &func.insts[inst].kind {
                InstKind::Call {
                    callee: Callee::Func(next),
                    ..
                } => {
                    calls_itself |= *next == callee;
                    open.extend(reached.insert(*next).then_some(*next));
                }
                InstKind::Op { op, .. } => has_port |= op.info().effect == Effect::Io,
                _ => {}
            }
        }
    }
    let name = program.funcs[callee].name.clone();
    match (has_port, calls_itself) {
        (true, _) => Reason::PortCall(name),
        (_, true) => Reason::RecursiveCall(name),
        _ => Reason::Call(name),
    }
}

/// Returns the reason why the loop with this header is not a single block.
fn why_not_one_block(program: &Program, func: &Function, header: Block) -> Refusal {
    let Flow {
        loops, dominators, ..
    } = Flow::of(func);
    let pos = func.blocks[header].end_pos;
    let Some((id, data)) = loops.loops.iter().find(|(_, l)| l.header == header) else {
        let reason = Reason::NoWayBack;
        return Refusal { pos, reason };
    };
    for &block in &data.blocks {
        if let Err(refusal) = check_insts(program, func, block) {
            return refusal;
        }
    }
    if let Some((_, inner)) = loops.inside(id).next() {
        let statement = func.blocks[inner.header].kernel.as_ref().map(|m| m.pos);
        let trip = trip(func, &dominators, inner, MAX_UNROLL, &Precision::EXACT);
        return Refusal {
            pos: statement.unwrap_or(func.blocks[inner.latches[0]].end_pos),
            reason: Reason::InnerLoop {
                count: trip.map(|trip| trip.count),
            },
        };
    }
    let early = |b: &&Block| !data.latches.contains(b);
    let exits: Vec<Block> = data.exits(func).map(|(from, _)| from).collect();
    if let (Some(&exit), true) = (exits.iter().find(early), exits.len() > 1) {
        return Refusal {
            pos: func.blocks[exit].end_pos,
            reason: Reason::SeveralExits,
        };
    }
    let branches = |b: &&Block| matches!(func.blocks[**b].end, Terminator::Branch { .. });
    let branch = data
        .blocks
        .iter()
        .find(|b| branches(b) && !exits.contains(b));
    let at = branch.or(exits.first()).or(data.blocks.first());
    Refusal {
        pos: at.map_or(pos, |b| func.blocks[*b].end_pos),
        reason: Reason::Branches,
    }
}
