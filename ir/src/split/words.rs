//! Control code that computes a word before a loop starts, with constants folded on the way.

use super::linear::{Atom, Linear};
use super::places::Additions;
use super::shape::{Loop, Outer};
use crate::program::{Bits, Inst, InstData, InstKind, Pos, Value};
use srp_archdesc::isa::{Opcode, Ty};
use std::collections::{BTreeMap, BTreeSet};

/// A word: known now, or a value of the control code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Word {
    Const(u32),
    Value(Value),
}

/// The outcome of a test: known now, or a predicate of the control code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flag {
    Const(bool),
    Value(Value),
}

/// Instructions for the end of the block that takes a loop's place.
pub(super) struct Words<'a> {
    lp: &'a Loop<'a>,
    /// Values and instructions to add to the function.
    pub(super) added: Additions,
    /// The instructions so far.
    pub(super) insts: Vec<Inst>,
    constants: BTreeMap<Bits, Value>,
    /// Instructions of the loop that were copied in front of it.
    copies: BTreeMap<Value, Value>,
    pos: Pos,
}

impl<'a> Words<'a> {
    pub(super) fn new(lp: &'a Loop<'a>, pos: Pos) -> Words<'a> {
        Words {
            lp,
            added: Additions::to(lp.func),
            insts: Vec::new(),
            constants: BTreeMap::new(),
            copies: BTreeMap::new(),
            pos,
        }
    }

    /// Appends an instruction with one result.
    fn push(&mut self, kind: InstKind, ty: Ty, pos: Pos) -> Value {
        let result = self.added.value(ty);
        let results = vec![result];
        let inst = self.added.inst(InstData { kind, results, pos });
        self.insts.push(inst);
        result
    }

    pub(super) fn constant(&mut self, bits: Bits) -> Value {
        if let Some(&value) = self.constants.get(&bits) {
            return value;
        }
        let value = self.push(InstKind::Const(bits), bits.ty(), self.pos);
        self.constants.insert(bits, value);
        value
    }

    /// The word as a value.
    pub(super) fn value(&mut self, word: Word) -> Value {
        match word {
            Word::Const(w) => self.constant(Bits::Word(w)),
            Word::Value(v) => v,
        }
    }

    pub(super) fn outer(&mut self, outer: Outer) -> Value {
        match outer {
            Outer::Const(bits) => self.constant(bits),
            Outer::Value(v) => v,
        }
    }

    /// A word operation of two operands.
    pub(super) fn op(&mut self, op: Opcode, a: Word, b: Word) -> Word {
        match (a, b) {
            (Word::Const(a), Word::Const(b)) => return Word::Const(fold(op, a, b)),
            (word, Word::Const(0)) if matches!(op, Opcode::Add | Opcode::Shr | Opcode::Sub) => {
                return word;
            }
            _ => {}
        }
        let mut args = Vec::with_capacity(3);
        if op.is_guarded() {
            args.push(self.constant(Bits::Pred(true)));
        }
        args.push(self.value(a));
        args.push(self.value(b));
        let kind = InstKind::Op { op, args, imm: 0 };
        Word::Value(self.push(kind, Ty::Word, self.pos))
    }

    /// A comparison of two sums.
    pub(super) fn test(&mut self, op: Opcode, a: &Linear, b: &Linear) -> Flag {
        if let (Some(a), Some(b)) = (a.as_constant(), b.as_constant()) {
            return Flag::Const(fold(op, a, b) != 0);
        }
        let (a, b) = (self.linear(a), self.linear(b));
        let args = vec![self.value(a), self.value(b)];
        let kind = InstKind::Op { op, args, imm: 0 };
        Flag::Value(self.push(kind, Ty::Pred, self.pos))
    }

    pub(super) fn select(&mut self, flag: Flag, yes: Word, no: Word) -> Word {
        let flag = match flag {
            Flag::Const(true) => return yes,
            Flag::Const(false) => return no,
            Flag::Value(v) => v,
        };
        let args = vec![flag, self.value(yes), self.value(no)];
        let op = Opcode::Sel;
        let kind = InstKind::Op { op, args, imm: 0 };
        Word::Value(self.push(kind, Ty::Word, self.pos))
    }

    /// The word that a sum is.
    pub(super) fn linear(&mut self, sum: &Linear) -> Word {
        // Start with something positive, so that the rest can be subtracted.
        let first = sum.terms.iter().find(|(_, c)| (**c as i32) > 0);
        let Some((&first, &c)) = first else {
            return self.sum(Word::Const(0), sum);
        };
        let start = self.scaled(first, c);
        let mut rest = sum.clone();
        rest.terms.remove(&first);
        self.sum(start, &rest)
    }

    /// A word plus a sum.
    pub(super) fn sum(&mut self, start: Word, sum: &Linear) -> Word {
        let mut acc = start;
        let mut constant = sum.constant;
        if let Word::Const(c) = acc {
            acc = Word::Const(c.wrapping_add(constant));
            constant = 0;
        }
        for (&atom, &c) in &sum.terms {
            let negative = (c as i32) < 0;
            let magnitude = if negative { c.wrapping_neg() } else { c };
            let term = self.scaled(atom, magnitude);
            let op = if negative { Opcode::Sub } else { Opcode::Add };
            acc = if acc == Word::Const(0) && !negative {
                term
            } else {
                self.op(op, acc, term)
            };
        }
        self.op(Opcode::Add, acc, Word::Const(constant))
    }

    fn scaled(&mut self, atom: Atom, factor: u32) -> Word {
        let value = match atom {
            Atom::Value(v) => Word::Value(self.before_loop(v)),
            Atom::Symbol(symbol) => {
                let kind = InstKind::SymbolAddr(symbol, 0);
                Word::Value(self.push(kind, Ty::Word, self.pos))
            }
            Atom::Slot(slot) => {
                let kind = InstKind::SlotAddr(slot, 0);
                Word::Value(self.push(kind, Ty::Word, self.pos))
            }
        };
        if factor == 1 {
            value
        } else if factor.is_power_of_two() {
            self.op(Opcode::Shl, value, Word::Const(factor.trailing_zeros()))
        } else {
            self.op(Opcode::Mul, value, Word::Const(factor))
        }
    }

    /// An unchanging value of the loop, or one from outside, as control code has it.
    fn before_loop(&mut self, value: Value) -> Value {
        if !self.lp.is_inside(value) || self.lp.param_index(value).is_some() {
            return value;
        }
        let mut needed = BTreeSet::new();
        let mut open = vec![value];
        while let Some(v) = open.pop() {
            let copied = self.copies.contains_key(&v);
            let inside = self.lp.is_inside(v) && self.lp.param_index(v).is_none();
            if inside && !copied && needed.insert(v) {
                let data = self
                    .lp
                    .inst(v)
                    .expect("an inner value is no parameter here");
                open.extend_from_slice(data.kind.args());
            }
        }
        let lp = self.lp;
        for &inst in &lp.func.blocks[lp.block].insts {
            let data = &lp.func.insts[inst];
            if data.results.iter().any(|r| needed.contains(r)) {
                self.copy(data);
            }
        }
        self.copies[&value]
    }

    fn copy(&mut self, data: &InstData) {
        let mut kind = data.kind.clone();
        kind.for_each_use_mut(|v| {
            if let Some(&copy) = self.copies.get(v) {
                *v = copy;
            } else if let Some(i) = self.lp.param_index(*v) {
                // An unchanging parameter: the block's own, which holds its first value.
                *v = self.lp.params()[i];
            }
        });
        let result = data.results[0];
        let copy = self.push(kind, self.lp.ty(result), data.pos);
        self.copies.insert(result, copy);
    }

    /// Appends the launch or whatever else ends the block's instructions.
    pub(super) fn append(&mut self, kind: InstKind, results: Vec<Value>) {
        let inst = self.added.inst(InstData {
            kind,
            results,
            pos: self.pos,
        });
        self.insts.push(inst);
    }

    /// A new value, to be defined by [`append`](Self::append).
    pub(super) fn fresh(&mut self, ty: Ty) -> Value {
        self.added.value(ty)
    }
}

fn fold(op: Opcode, a: u32, b: u32) -> u32 {
    let (sa, sb) = (a as i32, b as i32);
    match op {
        Opcode::Add => a.wrapping_add(b),
        Opcode::Sub => a.wrapping_sub(b),
        Opcode::Mul => a.wrapping_mul(b),
        Opcode::And => a & b,
        Opcode::Shl => a.wrapping_shl(b),
        Opcode::Shr => a.wrapping_shr(b),
        Opcode::Divu => a / b,
        Opcode::Max => sa.max(sb) as u32,
        Opcode::Maxu => a.max(b),
        Opcode::Eq => u32::from(a == b),
        Opcode::Lt => u32::from(sa < sb),
        Opcode::Le => u32::from(sa <= sb),
        Opcode::Ltu => u32::from(a < b),
        Opcode::Leu => u32::from(a <= b),
        _ => unreachable!("{op} is not used in trip counts"),
    }
}
