//! How the values of a loop change from iteration to iteration.

use super::linear::{Affine, Atom, Linear};
use super::shape::{Loop, Outer};
use crate::program::{Bits, InstKind, Value};
use srp_archdesc::isa::{Opcode, Ty};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// How far definitions before the loop are followed.
const MAX_DEPTH: u32 = 64;

/// Which words of a loop are affine in the iteration number.
pub(super) struct Inductions<'a> {
    lp: &'a Loop<'a>,
    /// True if values from before the loop are decomposed, down to the objects they point into. If
    /// false, they are atoms: values of the control code.
    through: bool,
    /// Words of the loop as sums over its parameters and values from outside.
    sums: BTreeMap<Value, Linear>,
    /// The function of the iteration for each parameter, if it is known.
    params: Vec<Option<Affine>>,
    outer: RefCell<BTreeMap<Value, Linear>>,
}

impl<'a> Inductions<'a> {
    pub(super) fn of(lp: &'a Loop<'a>, through: bool) -> Inductions<'a> {
        let mut inductions = Inductions {
            lp,
            through,
            sums: BTreeMap::new(),
            params: vec![None; lp.params().len()],
            outer: RefCell::default(),
        };
        for i in 0..lp.params().len() {
            if lp.next[i] == lp.params()[i] && lp.ty(lp.params()[i]) == Ty::Word {
                inductions.params[i] = Some(Affine::invariant(inductions.initial(i)));
            }
        }
        for &inst in &lp.func.blocks[lp.block].insts {
            let data = &lp.func.insts[inst];
            let Some(&result) = data.results.first() else {
                continue;
            };
            if let Some(sum) = inductions.sum_of_inst(&data.kind, result) {
                inductions.sums.insert(result, sum);
            }
        }
        while inductions.learn() {}
        inductions
    }

    /// Returns `value` as a function of the iteration, if it is known.
    pub(super) fn affine(&self, value: Value) -> Option<Affine> {
        let sum = self.sum(value)?;
        let mut affine = Affine::invariant(Linear::constant(sum.constant));
        for (&atom, &c) in &sum.terms {
            match self.own_param(atom) {
                Some(i) => {
                    let param = self.params[i].as_ref()?;
                    affine.base = affine.base.plus(c, &param.base);
                    affine.stride = affine.stride.plus(c, &param.stride);
                }
                None => affine.base = affine.base.plus(c, &Linear::atom(atom)),
            }
        }
        affine.base.is_short().then_some(affine)
    }

    /// The parameter that an atom of a sum is; one that never changes stands for its first value.
    fn own_param(&self, atom: Atom) -> Option<usize> {
        let Atom::Value(v) = atom else {
            return None;
        };
        self.lp
            .param_index(v)
            .filter(|i| self.lp.next[*i] != self.lp.params()[*i])
    }

    /// A parameter's value in the first iteration.
    fn initial(&self, i: usize) -> Linear {
        match self.lp.initial[i] {
            Outer::Const(bits) => Linear::constant(bits.lanes()[0]),
            Outer::Value(v) if self.lp.is_inside(v) => Linear::value(v),
            Outer::Value(v) => self.outer(v, 0),
        }
    }

    /// A word as a sum over the loop's parameters and values from outside.
    fn sum(&self, value: Value) -> Option<Linear> {
        if self.lp.ty(value) != Ty::Word {
            None
        } else if self.lp.param_index(value).is_some() {
            Some(self.sum_of_param(value))
        } else if self.lp.is_inside(value) {
            self.sums.get(&value).cloned()
        } else {
            Some(self.outer(value, 0))
        }
    }

    fn sum_of_param(&self, value: Value) -> Linear {
        let i = self.lp.param_index(value);
        match i.and_then(|i| self.params[i].as_ref()) {
            Some(known) if known.stride == Linear::default() => known.base.clone(),
            _ => Linear::value(value),
        }
    }

    fn sum_of_inst(&self, kind: &InstKind, result: Value) -> Option<Linear> {
        match kind {
            InstKind::Const(Bits::Word(w)) => Some(Linear::constant(*w)),
            InstKind::SymbolAddr(..) | InstKind::SlotAddr(..) => Some(self.address(kind, result)),
            InstKind::Op { op, args, .. } if op.result() == Some(Ty::Word) => {
                let sums: Option<Vec<Linear>> = args.iter().map(|a| self.sum(*a)).collect();
                let sums = sums?;
                let sum = combine(*op, &sums);
                // Whatever unchanging words give is unchanging too.
                let unchanging = || {
                    let varies = |s: &Linear| s.terms.keys().any(|a| self.own_param(*a).is_some());
                    op.is_pure() && !sums.iter().any(varies)
                };
                sum.or_else(|| unchanging().then(|| Linear::value(result)))
            }
            _ => None,
        }
    }

    fn address(&self, kind: &InstKind, result: Value) -> Linear {
        let (atom, offset) = match *kind {
            InstKind::SymbolAddr(symbol, offset) => (Atom::Symbol(symbol), offset),
            InstKind::SlotAddr(slot, offset) => (Atom::Slot(slot), offset),
            _ => return Linear::value(result),
        };
        if self.through {
            Linear::atom(atom).plus_constant(offset as u32)
        } else {
            Linear::value(result)
        }
    }

    /// A word from before the loop.
    fn outer(&self, value: Value, depth: u32) -> Linear {
        if let Some(Bits::Word(w)) = self.lp.constant(value) {
            return Linear::constant(w);
        }
        if !self.through || depth > MAX_DEPTH || self.lp.is_inside(value) {
            return Linear::value(value);
        }
        if let Some(known) = self.outer.borrow().get(&value) {
            return known.clone();
        }
        let sum = match self.lp.inst(value).map(|data| &data.kind) {
            Some(InstKind::Op { op, args, .. })
                if args.iter().all(|a| self.lp.ty(*a) == Ty::Word) =>
            {
                let sums: Vec<_> = args.iter().map(|a| self.outer(*a, depth + 1)).collect();
                combine(*op, &sums)
            }
            Some(kind) => Some(self.address(kind, value)),
            None => None,
        };
        let sum = sum.unwrap_or_else(|| Linear::value(value));
        self.outer.borrow_mut().insert(value, sum.clone());
        sum
    }

    /// Finds out about parameters; whether anything new was found.
    fn learn(&mut self) -> bool {
        let unknown: Vec<usize> = (0..self.params.len())
            .filter(|i| self.params[*i].is_none())
            .collect();
        let mut learnt = false;
        for i in unknown {
            let found = self
                .sum(self.lp.next[i])
                .and_then(|next| self.solve(i, &next));
            learnt |= found.is_some();
            self.params[i] = found;
        }
        learnt
    }

    /// The parameter `i` whose next value is `next`.
    fn solve(&self, i: usize, next: &Linear) -> Option<Affine> {
        let own = Linear::value(self.lp.params()[i]);
        let initial = self.initial(i);
        let step = next.minus(&own);
        let unchanging = |sum: &Linear| sum.terms.keys().all(|a| self.own_param(*a).is_none());
        if unchanging(&step) {
            return Some(Affine {
                base: initial,
                stride: step,
            });
        }
        // It follows another: affine if it starts one step before it.
        let mut follows = Affine::invariant(Linear::constant(next.constant));
        for (&atom, &c) in &next.terms {
            let known = match self.own_param(atom) {
                Some(j) => self.params[j].clone()?,
                None => Affine::invariant(Linear::atom(atom)),
            };
            follows.base = follows.base.plus(c, &known.base);
            follows.stride = follows.stride.plus(c, &known.stride);
        }
        (follows.base.minus(&follows.stride) == initial).then_some(Affine {
            base: initial,
            stride: follows.stride,
        })
    }
}

/// The sum that an operation makes of sums, if it makes one.
fn combine(op: Opcode, args: &[Linear]) -> Option<Linear> {
    let sum = match (op, args) {
        (Opcode::Mov, [a]) => a.clone(),
        (Opcode::Add, [a, b]) => a.plus(1, b),
        (Opcode::Sub, [a, b]) => a.minus(b),
        (Opcode::Shl, [a, b]) => a.scaled(1u32.wrapping_shl(b.as_constant()?)),
        (Opcode::Mul, [a, b]) => match (a.as_constant(), b.as_constant()) {
            (_, Some(c)) => a.scaled(c),
            (Some(c), None) => b.scaled(c),
            (None, None) => return None,
        },
        (Opcode::And, [a, b]) => match (a.as_constant(), b.as_constant()) {
            (_, Some(c)) => a.masked(c)?,
            (Some(c), None) => b.masked(c)?,
            (None, None) => return None,
        },
        (Opcode::Or, [a, b]) => match (a.as_constant(), b.as_constant()) {
            (_, Some(c)) => a.with_bits(c)?,
            (Some(c), None) => b.with_bits(c)?,
            (None, None) => return None,
        },
        _ => return None,
    };
    sum.is_short().then_some(sum)
}
