//! Differences of numbers that may be nearly equal, in forms that do not lose their digits. The first four are the
//! classic ones (Hamming, *Numerical Methods for Scientists and Engineers*, 1962, chapter 3); Kahan's difference of products is analysed by
//! Jeannerod, Louvet and Muller (2013): off by at most two units in the last place.

use super::tree::{Expressions, Made, Tree, operation};
use crate::program::*;
use srp_archdesc::isa::{Opcode, Ty};

/// Operands of nested sums that are looked through.
const MOST_TERMS: usize = 32;

/// The two operands of a difference.
fn operands(func: &Function, made: &Made, inst: Inst) -> Option<(Value, Value)> {
    let negated = |value: Value| match made.operation(func, value) {
        Some((Opcode::Fneg, [inner])) => Some(*inner),
        _ => None,
    };
    match operation(func, inst)? {
        (Opcode::Fsub, [a, b]) => Some((*a, *b)),
        (Opcode::Fadd, [a, b]) => match (negated(*a), negated(*b)) {
            (_, Some(inner)) => Some((*a, inner)),
            (Some(inner), None) => Some((*b, inner)),
            (None, None) => None,
        },
        _ => None,
    }
}

/// Both factors of a product.
fn factors(func: &Function, made: &Made, value: Value) -> Option<[Value; 2]> {
    match made.operation(func, value)? {
        (Opcode::Fmul, [a, b]) => Some([*a, *b]),
        _ => None,
    }
}

/// A difference of sums without what the two have in common.
struct Cancelled<'a> {
    func: &'a Function,
    made: &'a Made,
    /// Terms with their signs: true for those that are subtracted.
    terms: Vec<(bool, Tree)>,
    /// True if anything was in common.
    any: bool,
}

impl Cancelled<'_> {
    fn add(&mut self, value: Value, is_subtracted: bool) {
        match self.made.operation(self.func, value) {
            Some((op @ (Opcode::Fadd | Opcode::Fsub), &[a, b]))
                if self.terms.len() < MOST_TERMS =>
            {
                self.add(a, is_subtracted);
                self.add(b, is_subtracted ^ (op == Opcode::Fsub));
            }
            Some((Opcode::Fneg, &[inner])) => self.add(inner, !is_subtracted),
            _ => {
                let tree = self.made.tree(self.func, value);
                self.term(tree, is_subtracted);
            }
        }
    }

    fn term(&mut self, tree: Tree, is_subtracted: bool) {
        let opposite = (!is_subtracted, tree);
        match self.terms.iter().position(|known| *known == opposite) {
            Some(at) => {
                self.terms.remove(at);
                self.any = true;
            }
            None => self.terms.push((is_subtracted, opposite.1)),
        }
    }

    /// A term that is the square of a value.
    fn square(&mut self, of: Value, is_subtracted: bool) {
        let bare = match self.made.operation(self.func, of) {
            Some((Opcode::Fneg, &[inner])) => inner,
            _ => of,
        };
        let is_square = |tree: &Tree| match tree {
            Tree::Value(value) => {
                let same = |v: Value| v == of || v == bare;
                factors(self.func, self.made, *value).is_some_and(|f| f[0] == f[1] && same(f[0]))
            }
            _ => false,
        };
        let known = |(sign, tree): &(bool, Tree)| *sign != is_subtracted && is_square(tree);
        match self.terms.iter().position(known) {
            Some(at) => {
                self.terms.remove(at);
                self.any = true;
            }
            None => {
                let factor = Tree::Value(of);
                let square = Tree::product(factor.clone(), factor);
                self.terms.push((is_subtracted, square));
            }
        }
    }

    fn tree(self) -> Tree {
        let (below, above): (Vec<_>, Vec<_>) = self.terms.into_iter().partition(|(sign, _)| *sign);
        let sum = |terms: Vec<(bool, Tree)>| {
            let terms = terms.into_iter().map(|(_, tree)| tree);
            terms.fold(Tree::Constant(0.0), Tree::sum)
        };
        Tree::difference(sum(above), sum(below))
    }
}

/// a − b.
fn cancelled<'a>(func: &'a Function, made: &'a Made, a: Value, b: Option<Value>) -> Cancelled<'a> {
    let mut sum = Cancelled {
        func,
        made,
        terms: Vec::new(),
        any: false,
    };
    sum.add(a, false);
    if let Some(b) = b {
        sum.add(b, true);
    }
    sum
}

/// A difference with a square root on one side or both.
pub(super) fn roots(within: &Expressions<'_>, inst: Inst) -> Option<Tree> {
    let Expressions { func, made, .. } = within;
    let (a, b) = operands(func, made, inst)?;
    let root = |value: Value| within.root(value);
    let above = match (root(a), root(b)) {
        (Some(x), Some(y)) => cancelled(func, made, x, Some(y)).tree(),
        (Some(x), None) => {
            let mut above = cancelled(func, made, x, None);
            above.square(b, true);
            above.any.then(|| above.tree())?
        }
        (None, Some(y)) => {
            let mut below = cancelled(func, made, y, None);
            below.square(a, true);
            below.any.then(|| below.tree())?.negated()
        }
        (None, None) => return None,
    };
    let below = Tree::sum(made.tree(func, a), made.tree(func, b));
    Some(Tree::quotient(above, below))
}

/// A difference of squares.
pub(super) fn squares(within: &Expressions<'_>, inst: Inst) -> Option<Tree> {
    let Expressions { func, made, .. } = within;
    let (a, b) = operands(func, made, inst)?;
    let root = |value: Value| match factors(func, made, value) {
        Some([x, y]) if x == y => Some(made.tree(func, x)),
        _ => match made.constant(func, value) {
            Some(1.0) => Some(Tree::Constant(1.0)),
            _ => None,
        },
    };
    let (a, b) = (root(a)?, root(b)?);
    let (difference, sum) = (Tree::difference(a.clone(), b.clone()), Tree::sum(a, b));
    match (&difference, &sum) {
        (Tree::Constant(_), _) | (_, Tree::Constant(_)) => None,
        _ => Some(Tree::product(difference, sum)),
    }
}

/// A difference of quotients.
pub(super) fn quotients(within: &Expressions<'_>, inst: Inst) -> Option<Tree> {
    let Expressions { func, made, .. } = within;
    let (a, b) = operands(func, made, inst)?;
    let parts = |value: Value| match made.operation(func, value)? {
        (Opcode::Fdiv, &[above, below]) => Some((made.tree(func, above), below)),
        (Opcode::Rcp, &[below]) => Some((Tree::Constant(1.0), below)),
        _ => None,
    };
    let ((p, q), (r, s)) = (parts(a)?, parts(b)?);
    if q == s {
        return None;
    }
    let above = match p == r {
        true => Tree::product(p, cancelled(func, made, s, Some(q)).tree()),
        false => Tree::difference(
            Tree::product(p, Tree::Value(s)),
            Tree::product(r, Tree::Value(q)),
        ),
    };
    let below = Tree::product(made.tree(func, q), made.tree(func, s));
    Some(Tree::quotient(above, below))
}

/// One without a cosine.
pub(super) fn half_angle(within: &Expressions<'_>, inst: Inst) -> Option<Tree> {
    let Expressions { func, made, .. } = within;
    let (one, cosine) = operands(func, made, inst)?;
    let (Some(1.0), (Opcode::Cos, &[angle])) =
        (made.constant(func, one), made.operation(func, cosine)?)
    else {
        return None;
    };
    let half = Tree::product(Tree::Constant(0.5), Tree::Value(angle));
    let sine = Tree::Op(Opcode::Sin, vec![half]);
    let twice = Tree::product(Tree::Constant(2.0), sine.clone());
    Some(Tree::product(twice, sine))
}

/// A difference of products.
pub(super) fn products(within: &Expressions<'_>, inst: Inst) -> Option<Tree> {
    let Expressions { func, made, .. } = within;
    let (a, b) = operands(func, made, inst)?;
    let [p, q] = factors(func, made, a)?;
    let [r, s] = factors(func, made, b)?;
    let is_float = |v: Value| func.values[v] != Ty::Pred;
    if !is_float(a) {
        return None;
    }
    let tree = |v: Value| made.tree(func, v);
    let fma = |a: Tree, b: Tree, c: Tree| Tree::Op(Opcode::Fma, vec![a, b, c]);
    let lost = fma(tree(r).negated(), tree(s), Tree::Value(b));
    let rest = fma(tree(p), tree(q), Tree::Value(b).negated());
    Some(Tree::sum(rest, lost))
}
