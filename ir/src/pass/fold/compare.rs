//! Identities of comparisons.

use super::Folder;
use crate::program::*;
use srp_archdesc::isa::Opcode;
use srp_archdesc::ops;

impl Folder<'_> {
    /// Rules for the relation `a op b`; a constant of `eq` and `ne` comes as `b`.
    pub(super) fn comparison(&mut self, op: Opcode, a: Value, b: Value) -> Option<Value> {
        use Opcode::*;
        if self.same(a, b) {
            return Some(self.truth(matches!(op, Eq | Le | Leu)));
        }
        match (op, self.word(a), self.word(b)) {
            (Ltu, _, Some(0)) => return Some(self.truth(false)),
            (Leu, Some(0), _) => return Some(self.truth(true)),
            (Ltu, Some(0), _) => return Some(self.build(Ne, &[b, a])),
            (Leu, _, Some(0)) => return Some(self.build(Eq, &[a, b])),
            _ => {}
        }
        self.two_valued(op, a, b)
            .or_else(|| self.equality(op, a, b))
    }

    /// A relation of a constant and a word that is one of two constants: what the relation is for
    /// each decides.
    pub(super) fn two_valued(&mut self, op: Opcode, a: Value, b: Value) -> Option<Value> {
        let (choice, left) = match (self.word(a), self.word(b)) {
            (None, Some(_)) => (a, true),
            (Some(_), None) => (b, false),
            _ => return None,
        };
        let (p, yes, no) = match self.op_of(choice)? {
            (Opcode::Ptoi, [p, ..], _) => (p, 1, 0),
            (Opcode::Sel, [p, yes, no], _) => (p, self.word(yes)?, self.word(no)?),
            _ => return None,
        };
        let relation = |word: u32| {
            let other = self.word(if left { b } else { a })?;
            let (x, y) = if left { (word, other) } else { (other, word) };
            let args = [ops::Value::word(x), ops::Value::word(y)];
            Some(ops::eval(op, &args, 0, self.precision).ok()??.as_pred())
        };
        Some(match (relation(yes)?, relation(no)?) {
            (true, false) => p,
            (false, true) => self.build(Opcode::Pnot, &[p]),
            (both, _) => self.truth(both),
        })
    }

    /// `x + c = d` and the like to `x = …`.
    fn equality(&mut self, op: Opcode, a: Value, b: Value) -> Option<Value> {
        if !matches!(op, Opcode::Eq | Opcode::Ne) {
            return None;
        }
        let d = self.word(b)?;
        let (inner, [x, y, _], _) = self.op_of(a)?;
        let other = match (inner, self.word(y)) {
            (Opcode::Add, Some(c)) => self.int(d.wrapping_sub(c)),
            (Opcode::Xor, Some(c)) => self.int(d ^ c),
            (Opcode::Sub | Opcode::Xor, None) if d == 0 => y,
            _ => return None,
        };
        Some(self.build(op, &[x, other]))
    }
}
