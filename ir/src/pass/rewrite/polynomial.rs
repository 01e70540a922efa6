//! Polynomials, and two ways to evaluate them.

use super::tree::{Expressions, Made, Tree, operation};
use crate::program::*;
use srp_archdesc::isa::Opcode;
use std::collections::BTreeSet;

/// Degrees beyond which a polynomial is left alone.
const MOST_DEGREES: usize = 32;

/// Factors that are tried as the variable.
const MOST_VARIABLES: usize = 16;

/// A polynomial as it is computed.
struct Polynomial {
    /// Of the powers of the variable, from 0.
    coefficients: Vec<Tree>,
    /// The values of its sums and products.
    within: BTreeSet<Value>,
    /// The operations of the longest way through it.
    depth: usize,
    /// True if sums take in products unrounded.
    is_fused: bool,
}

impl Polynomial {
    /// A part that is no sum and no product, or not for this polynomial alone.
    fn leaf(tree: Tree) -> Polynomial {
        Polynomial {
            coefficients: vec![tree],
            within: BTreeSet::new(),
            depth: 0,
            is_fused: false,
        }
    }

    fn degree(&self) -> usize {
        self.coefficients.len() - 1
    }

    /// Power and coefficient of a polynomial of one term.
    fn monomial(&self) -> Option<(usize, &Tree)> {
        let mut terms = self.coefficients.iter().enumerate();
        let zero = Tree::Constant(0.0);
        let term = terms.find(|(_, c)| **c != zero)?;
        terms.all(|(_, c)| *c == zero).then_some(term)
    }

    /// This with another as operand of the same operation.
    fn joined(mut self, other: Polynomial, coefficients: Vec<Tree>) -> Polynomial {
        self.within.extend(other.within);
        self.depth = self.depth.max(other.depth);
        self.is_fused |= other.is_fused;
        self.coefficients = coefficients;
        self
    }

    fn plus(self, other: Polynomial, combine: fn(Tree, Tree) -> Tree) -> Polynomial {
        let at = |p: &Polynomial, i: usize| {
            let c = p.coefficients.get(i).cloned();
            c.unwrap_or(Tree::Constant(0.0))
        };
        let count = self.coefficients.len().max(other.coefficients.len());
        let all = (0..count).map(|i| combine(at(&self, i), at(&other, i)));
        let all = all.collect();
        self.joined(other, all)
    }

    /// The product, where one of the two has one term.
    fn times(self, other: Polynomial) -> Option<Polynomial> {
        let (of_one, of_many) = match (self.monomial(), other.monomial()) {
            (Some(_), _) => (&self, &other),
            (_, Some(_)) => (&other, &self),
            _ => return None,
        };
        let (power, factor) = of_one.monomial()?;
        let scaled = of_many.coefficients.iter().map(|c| match c {
            Tree::Constant(0.0) => Tree::Constant(0.0),
            c => Tree::product(factor.clone(), c.clone()),
        });
        let all: Vec<Tree> = std::iter::repeat_n(Tree::Constant(0.0), power)
            .chain(scaled)
            .collect();
        (all.len() <= MOST_DEGREES + 1).then(|| self.joined(other, all))
    }
}

/// Reads polynomials of one variable out of a function.
struct Reader<'a> {
    func: &'a Function,
    made: &'a Made,
    variable: Value,
}

impl Reader<'_> {
    fn read(&self, value: Value, is_root: bool) -> Polynomial {
        if value == self.variable {
            return Polynomial::leaf(Tree::Constant(1.0)).shifted();
        }
        let leaf = || Polynomial::leaf(self.made.tree(self.func, value));
        let is_shared = !is_root && self.made.uses[value] > 1 && !self.is_power(value);
        match self.made.operation(self.func, value) {
            Some((op, args)) if !is_shared => {
                let read = self.combined(op, args);
                read.map_or_else(leaf, |mut polynomial| {
                    polynomial.within.insert(value);
                    polynomial.depth += 1;
                    polynomial
                })
            }
            _ => leaf(),
        }
    }

    fn combined(&self, op: Opcode, args: &[Value]) -> Option<Polynomial> {
        let arg = |i: usize| self.read(args[i], false);
        match op {
            Opcode::Fadd => Some(arg(0).plus(arg(1), Tree::sum)),
            Opcode::Fsub => Some(arg(0).plus(arg(1), Tree::difference)),
            Opcode::Fneg => {
                let zero = Polynomial::leaf(Tree::Constant(0.0));
                Some(zero.plus(arg(0), Tree::difference))
            }
            Opcode::Fmul => arg(0).times(arg(1)),
            Opcode::Fma => {
                let mut sum = arg(0).times(arg(1))?.plus(arg(2), Tree::sum);
                sum.is_fused = true;
                Some(sum)
            }
            _ => None,
        }
    }

    /// True of products of the variable alone.
    fn is_power(&self, value: Value) -> bool {
        match self.made.operation(self.func, value) {
            _ if value == self.variable => true,
            Some((Opcode::Fmul, args)) => args.iter().all(|&arg| self.is_power(arg)),
            _ => false,
        }
    }
}

impl Polynomial {
    /// This times the variable.
    fn shifted(mut self) -> Polynomial {
        self.coefficients.insert(0, Tree::Constant(0.0));
        self
    }
}

/// The polynomial of the highest degree that an instruction computes, and its variable.
fn polynomial(within: &Expressions<'_>, inst: Inst) -> Option<(Polynomial, Value)> {
    let Expressions { func, made, .. } = within;
    let (op, _) = operation(func, inst)?;
    if !matches!(op, Opcode::Fadd | Opcode::Fsub | Opcode::Fma) {
        return None;
    }
    let root = *func.insts[inst].results.first()?;
    let mut best: Option<(Polynomial, Value)> = None;
    for variable in variables(func, made, root) {
        let reader = Reader {
            func,
            made,
            variable,
        };
        let read = reader.read(root, true);
        let degree = best.as_ref().map_or(1, |(p, _)| p.degree());
        if read.degree() > degree {
            best = Some((read, variable));
        }
    }
    best
}

/// The factors of an expression that may be its variable.
fn variables(func: &Function, made: &Made, root: Value) -> Vec<Value> {
    let mut found = Vec::new();
    let mut seen = BTreeSet::new();
    let mut open = vec![root];
    while let Some(value) = open.pop() {
        if !seen.insert(value) || found.len() == MOST_VARIABLES {
            continue;
        }
        let Some((op, args)) = made.operation(func, value) else {
            continue;
        };
        let factors = match op {
            Opcode::Fadd | Opcode::Fsub | Opcode::Fneg => 0,
            Opcode::Fmul | Opcode::Fma => 2,
            _ => continue,
        };
        for &factor in &args[..factors] {
            if made.constant(func, factor).is_none() && !found.contains(&factor) {
                found.push(factor);
            }
        }
        open.extend(args);
    }
    found
}

/// The polynomial by Estrin's scheme, where that is a shorter way.
pub(super) fn estrin(within: &Expressions<'_>, inst: Inst) -> Option<Tree> {
    let (polynomial, variable) = polynomial(within, inst)?;
    let mut terms = polynomial.coefficients;
    let mut power = Tree::Value(variable);
    while terms.len() > 1 {
        let pairs = terms.chunks(2).map(|pair| match pair {
            [low, high] => Tree::scaled_sum(
                high.clone(),
                power.clone(),
                low.clone(),
                polynomial.is_fused,
            ),
            pair => pair[0].clone(),
        });
        terms = pairs.collect();
        power = Tree::product(power.clone(), power);
    }
    let tree = terms.pop()?;
    (tree.size().1 < polynomial.depth).then_some(tree)
}

/// The polynomial by Horner's scheme, where that takes fewer operations.
pub(super) fn horner(within: &Expressions<'_>, inst: Inst) -> Option<Tree> {
    let (polynomial, variable) = polynomial(within, inst)?;
    let mut terms = polynomial.coefficients.into_iter().rev();
    let mut tree = terms.next()?;
    for term in terms {
        tree = Tree::scaled_sum(tree, Tree::Value(variable), term, polynomial.is_fused);
    }
    (tree.size().0 < polynomial.within.len()).then_some(tree)
}
