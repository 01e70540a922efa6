//! Identities of predicates and selections.

use super::Folder;
use crate::pass::order::Stage;
use crate::program::*;
use srp_archdesc::isa::Opcode;

impl Folder<'_> {
    /// Rules for `p ? a : b`, of any type.
    pub(super) fn selection(&mut self, op: Opcode, p: Value, a: Value, b: Value) -> Option<Value> {
        if let Some(p) = self.pred(p) {
            return Some(if p { a } else { b });
        }
        if self.same(a, b) {
            return Some(a);
        }
        if let Some((Opcode::Pnot, [q, ..], _)) = self.op_of(p) {
            return Some(self.build(op, &[q, b, a]));
        }
        // The same question asked again has the same answer.
        if let Some((inner, [q, x, _], _)) = self.op_of(a)
            && inner == op
            && q == p
        {
            return Some(self.build(op, &[p, x, b]));
        }
        if let Some((inner, [q, _, y], _)) = self.op_of(b)
            && inner == op
            && q == p
        {
            return Some(self.build(op, &[p, a, y]));
        }
        match op {
            Opcode::Psel => self.predicate_selection(p, a, b),
            Opcode::Sel => {
                if let Some(op) = self.extremum(p, a, b) {
                    return Some(self.build(op, &[a, b]));
                }
                let (a, b) = (self.as_predicate(a)?, self.as_predicate(b)?);
                let chosen = self.build(Opcode::Psel, &[p, a, b]);
                Some(self.build(Opcode::Ptoi, &[chosen]))
            }
            _ => None,
        }
    }

    /// The operation that `p ? a : b` is where p compares a and b as integers.
    fn extremum(&self, p: Value, a: Value, b: Value) -> Option<Opcode> {
        let (Opcode::Lt | Opcode::Le, [x, y, _], _) = self.op_of(p)? else {
            return None;
        };
        match (x, y) {
            _ if (x, y) == (a, b) => Some(Opcode::Min),
            _ if (x, y) == (b, a) => Some(Opcode::Max),
            _ => None,
        }
    }

    fn predicate_selection(&mut self, p: Value, a: Value, b: Value) -> Option<Value> {
        use Opcode::{Pand, Pnot, Por};
        match (self.pred(a), self.pred(b)) {
            (Some(true), Some(false)) => return Some(p),
            (Some(false), Some(true)) => return Some(self.build(Pnot, &[p])),
            (Some(true), _) => return Some(self.build(Por, &[p, b])),
            (_, Some(false)) => return Some(self.build(Pand, &[p, a])),
            (Some(false), _) => {
                let not = self.build(Pnot, &[p]);
                return Some(self.build(Pand, &[not, b]));
            }
            (_, Some(true)) => {
                let not = self.build(Pnot, &[p]);
                return Some(self.build(Por, &[not, a]));
            }
            (None, None) => {}
        }
        if a == p {
            return Some(self.build(Por, &[p, b]));
        }
        if b == p {
            return Some(self.build(Pand, &[p, a]));
        }
        None
    }

    /// Rules for predicate logic; a constant comes as `b`.
    pub(super) fn predicate(&mut self, op: Opcode, a: Value, b: Value) -> Option<Value> {
        use Opcode::*;
        match (op, self.pred(b)) {
            (Pnot, _) => return self.negation(a),
            (Ptoi, _) => return self.zero_or_one(a),
            (Pand, Some(true)) | (Por | Pxor, Some(false)) => return Some(a),
            (Pand, Some(false)) | (Por, Some(true)) => return Some(b),
            (Pxor, Some(true)) => return Some(self.build(Pnot, &[a])),
            (Pand | Por, None) if a == b => return Some(a),
            (Pxor, None) if a == b => return Some(self.truth(false)),
            (Pand | Por | Pxor, None) if self.are_opposite(a, b) => {
                return Some(self.truth(op != Pand));
            }
            _ => {}
        }
        if op == Pxor {
            return None;
        }
        self.absorb(op, a, b)
            .or_else(|| self.absorb(op, b, a))
            .or_else(|| self.absorb_negated(op, a, b))
            .or_else(|| self.absorb_negated(op, b, a))
            .or_else(|| self.common_factor(op, a, b))
            .or_else(|| self.de_morgan(op, a, b))
            .or_else(|| self.range(op, a, b))
            .or_else(|| self.range(op, b, a))
    }

    fn negation(&mut self, a: Value) -> Option<Value> {
        let (inner, [x, y, _], _) = self.op_of(a)?;
        match inner {
            Opcode::Pnot => Some(x),
            _ => {
                let (op, swapped) = opposite(inner)?;
                let args = if swapped { [y, x] } else { [x, y] };
                Some(self.build(op, &args))
            }
        }
    }

    /// `ptoi (x ≠ 0)` is `x` where `x` is 0 or 1.
    fn zero_or_one(&self, p: Value) -> Option<Value> {
        let (Opcode::Ne, [x, y, _], _) = self.op_of(p)? else {
            return None;
        };
        (self.word(y) == Some(0) && self.ones(x, 0) <= 1).then_some(x)
    }

    /// True if one of two predicates is always the negation of the other.
    fn are_opposite(&self, a: Value, b: Value) -> bool {
        let not = |x: Value, y: Value| match self.op_of(x) {
            Some((Opcode::Pnot, [inner, ..], _)) => inner == y,
            Some((op, [p, q, _], _)) => opposite(op).is_some_and(|(other, swapped)| {
                let (p, q) = if swapped { (q, p) } else { (p, q) };
                self.op_of(y).is_some_and(|(op, [r, s, _], _)| {
                    op == other && self.same(p, r) && self.same(q, s)
                })
            }),
            None => false,
        };
        not(a, b) || not(b, a)
    }

    /// `a op (a op' x)` and `a op (¬a op' x)`, where `op'` is the other of *and* and *or*; and
    /// `a op (a op x)`.
    fn absorb(&mut self, op: Opcode, a: Value, b: Value) -> Option<Value> {
        let (inner, [x, y, _], _) = self.op_of(b)?;
        if !matches!(inner, Opcode::Pand | Opcode::Por) {
            return None;
        }
        for (x, rest) in [(x, y), (y, x)] {
            if inner == op {
                if x == a {
                    return Some(b);
                }
                if self.are_opposite(x, a) {
                    return Some(self.truth(op == Opcode::Por));
                }
            } else {
                if x == a {
                    return Some(a);
                }
                if self.are_opposite(x, a) {
                    return Some(self.build(op, &[a, rest]));
                }
            }
        }
        None
    }

    /// `a op ¬(a op' x)` and `a op ¬(¬a op' x)`, where `op'` is *and* or *or*. Control code keeps them: the
    /// predicates of its hyperblocks share what is negated, and ¬x would be one operation more.
    fn absorb_negated(&mut self, op: Opcode, a: Value, b: Value) -> Option<Value> {
        if self.stage == Stage::Control {
            return None;
        }
        let (Opcode::Pnot, [b, ..], _) = self.op_of(b)? else {
            return None;
        };
        let (inner, [x, y, _], _) = self.op_of(b)?;
        if !matches!(inner, Opcode::Pand | Opcode::Por) {
            return None;
        }
        for (x, rest) in [(x, y), (y, x)] {
            let is_opposite = self.are_opposite(x, a);
            if x != a && !is_opposite {
                continue;
            }
            // What is left of ¬(x op' y) = ¬x op" ¬y, where `op"` is the other of the two.
            return Some(match (inner == op, is_opposite) {
                (true, true) => a,
                (false, false) => self.truth(op == Opcode::Por),
                _ => {
                    let not = self.build(Opcode::Pnot, &[rest]);
                    self.build(op, &[a, not])
                }
            });
        }
        None
    }

    /// `(f op' x) op (f op' y)` to `f op' (x op y)`, if that is `f` or has no more operations.
    fn common_factor(&mut self, op: Opcode, a: Value, b: Value) -> Option<Value> {
        let (inner, [p, q, _], _) = self.op_of(a)?;
        let (other, [r, s, _], _) = self.op_of(b)?;
        if inner != other || inner == op || !matches!(inner, Opcode::Pand | Opcode::Por) {
            return None;
        }
        let pairs = [(p, q, r, s), (p, q, s, r), (q, p, r, s), (q, p, s, r)];
        let (factor, x, _, y) = pairs.into_iter().find(|&(f, _, g, _)| f == g)?;
        let rest = self.build(op, &[x, y]);
        Some(self.build(inner, &[factor, rest]))
    }

    /// One comparison for a range from 0 on, the two of which may be `b` and a part of `a`.
    fn range(&mut self, op: Opcode, a: Value, b: Value) -> Option<Value> {
        if let Some(range) = self.both_ends(op, a, b) {
            return Some(range);
        }
        let (inner, [x, y, _], _) = self.op_of(a)?;
        if inner != op {
            return None;
        }
        for (rest, end) in [(x, y), (y, x)] {
            let range = self.both_ends(op, end, b);
            let range = range.or_else(|| self.both_ends(op, b, end));
            if let Some(range) = range {
                return Some(self.build(op, &[rest, range]));
            }
        }
        None
    }

    /// `0 ≤ x ∧ x < c` is `x < c` without signs, and `x < 0 ∨ c ≤ x` is `c ≤ x`, where c is a constant from 0 on.
    fn both_ends(&mut self, op: Opcode, low: Value, high: Value) -> Option<Value> {
        use Opcode::{Le, Leu, Lt, Ltu, Pand};
        let (relation, [p, q, _], _) = self.op_of(low)?;
        let (zero, x) = if op == Pand { (p, q) } else { (q, p) };
        let within = match (op == Pand, relation) {
            (true, Le) | (false, Lt) => self.word(zero) == Some(0),
            (true, Lt) | (false, Le) => self.word(zero) == Some(u32::MAX),
            _ => false,
        };
        let (relation, [r, s, _], _) = self.op_of(high)?;
        let (y, bound) = if op == Pand { (r, s) } else { (s, r) };
        let bound = self.word(bound)? as i32;
        let unsigned = match relation {
            Lt => Ltu,
            Le => Leu,
            _ => return None,
        };
        (within && bound >= 0 && x == y).then(|| self.build(unsigned, &[r, s]))
    }

    /// `¬x op ¬y` to `¬(x op' y)`.
    fn de_morgan(&mut self, op: Opcode, a: Value, b: Value) -> Option<Value> {
        let (Opcode::Pnot, [x, ..], _) = self.op_of(a)? else {
            return None;
        };
        let (Opcode::Pnot, [y, ..], _) = self.op_of(b)? else {
            return None;
        };
        let dual = match op {
            Opcode::Pand => Opcode::Por,
            _ => Opcode::Pand,
        };
        let both = self.build(dual, &[x, y]);
        Some(self.build(Opcode::Pnot, &[both]))
    }
}

/// The relation that holds where this one does not, and whether with its operands changed over.
/// Orders of floats have none: no order holds of a NaN.
fn opposite(op: Opcode) -> Option<(Opcode, bool)> {
    use Opcode::*;
    Some(match op {
        Eq => (Ne, false),
        Ne => (Eq, false),
        Feq => (Fne, false),
        Fne => (Feq, false),
        Lt => (Le, true),
        Le => (Lt, true),
        Ltu => (Leu, true),
        Leu => (Ltu, true),
        _ => return None,
    })
}
