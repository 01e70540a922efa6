//! Counted loops: those whose number of iterations can be known when they start.
//!
//! The division into control code and kernels computes that number, from a loop of one block. Here
//! the loop may have many, and only whether there is such a number is asked: a loop without one runs in
//! [chunks](super::exits) instead.

use crate::flow::LoopData;
use crate::pass::defs::Defs;
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Opcode, Ty};

/// How deep a sum is looked into.
const MAX_DEPTH: usize = 16;

/// True when one of the tests that end a loop of one way back compares integers that change by the
/// same amount in each iteration, or not at all.
pub(super) fn is_counted(func: &Function, data: &LoopData) -> bool {
    let within = Within::of(func, data);
    data.blocks.iter().any(|&block| {
        let Terminator::Branch { cond, .. } = &func.blocks[block].end else {
            return false;
        };
        data.is_left_at(func, block) && within.is_bound(*cond)
    })
}

/// The values of a loop, by what they are made of.
pub(super) struct Within<'a> {
    pub(super) func: &'a Function,
    pub(super) data: &'a LoopData,
    pub(super) inside: EntityMap<Value, bool>,
    defs: Defs,
}

impl Within<'_> {
    pub(super) fn of<'a>(func: &'a Function, data: &'a LoopData) -> Within<'a> {
        let mut inside = EntityMap::filled(func.values.len(), false);
        for &block in &data.blocks {
            for &param in &func.blocks[block].params {
                inside[param] = true;
            }
            for &inst in &func.blocks[block].insts {
                for &result in &func.insts[inst].results {
                    inside[result] = true;
                }
            }
        }
        Within {
            func,
            data,
            inside,
            defs: Defs::within(func, &data.blocks),
        }
    }

    pub(super) fn op(&self, value: Value) -> Option<(Opcode, &[Value])> {
        self.defs.op(self.func, value)
    }

    /// True for a comparison of integers that are [regular](Within::is_regular).
    fn is_bound(&self, mut cond: Value) -> bool {
        use Opcode::{Eq, Le, Leu, Lt, Ltu, Ne};
        while let Some((Opcode::Pnot | Opcode::Pmov, args)) = self.op(cond) {
            cond = args[0];
        }
        let compared = self.op(cond);
        compared.is_some_and(|(op, args)| {
            matches!(op, Eq | Ne | Lt | Le | Ltu | Leu)
                && args.iter().all(|&v| self.is_regular(v, &mut Vec::new()))
        })
    }

    /// True for what is the same in all iterations.
    fn is_unchanging(&self, value: Value, depth: usize) -> bool {
        if !self.inside[value] {
            return true;
        }
        match self.defs.kind(self.func, value) {
            None => false,
            Some(InstKind::Op { op, args, .. }) => {
                let same = |&v: &Value| self.is_unchanging(v, depth + 1);
                depth < MAX_DEPTH && op.is_pure() && args.iter().all(same)
            }
            Some(InstKind::Call { .. } | InstKind::Launch { .. }) => false,
            Some(_) => true,
        }
    }

    /// True for a word that changes by the same amount in each iteration; `seen` are parameters of the
    /// loop that it is asked for.
    pub(super) fn is_regular(&self, value: Value, seen: &mut Vec<Value>) -> bool {
        if self.func.values[value] != Ty::Word || seen.len() > MAX_DEPTH {
            return false;
        }
        if self.is_unchanging(value, 0) {
            return true;
        }
        let header = &self.func.blocks[self.data.header];
        if let Some(place) = header.params.iter().position(|&p| p == value) {
            let next = self.without_steps(self.next(place));
            if next == Some(value) {
                return true;
            }
            if seen.contains(&value) {
                return false;
            }
            seen.push(value);
            let regular = next.is_some_and(|next| self.is_regular(next, seen));
            seen.pop();
            return regular;
        }
        let Some((op, args)) = self.op(value) else {
            return false;
        };
        use Opcode::{Add, And, Mov, Mul, Or, Shl, Sub};
        seen.push(value);
        let regular = match op {
            Mov | Add | Sub => args.iter().all(|&v| self.is_regular(v, seen)),
            Shl | Mul | And | Or => {
                let constant = args.iter().any(|&v| self.is_unchanging(v, 0));
                constant && args.iter().all(|&v| self.is_regular(v, seen))
            }
            _ => false,
        };
        seen.pop();
        regular
    }

    /// The value of a parameter of the header in the next iteration.
    pub(super) fn next(&self, place: usize) -> Option<Value> {
        let latch = self.data.latches.first()?;
        let mut targets = self.func.blocks[*latch].end.targets();
        let back = targets.find(|t| t.block == self.data.header)?;
        Some(back.args[place])
    }

    /// The value to which unchanging ones are added.
    fn without_steps(&self, value: Option<Value>) -> Option<Value> {
        let mut value = value?;
        for _ in 0..MAX_DEPTH {
            value = match self.op(value) {
                Some((Opcode::Mov, args)) => args[0],
                Some((Opcode::Add | Opcode::Sub, args)) if self.is_unchanging(args[1], 0) => {
                    args[0]
                }
                Some((Opcode::Add, args)) if self.is_unchanging(args[0], 0) => args[1],
                _ => break,
            };
        }
        Some(value)
    }
}
