//! Sums of integers on recurrences: their terms have signs, and those of one value are multiples of it.
//!
//! `h·33 + x` becomes `(h << 5) + (h + x)`, whose way from h is one shift and one sum, and `h + (h << 1) + (h << 4) + (h << 7)`
//! becomes one product. Words wrap, so all of this is exact.

use super::{Cycles, Trees, least_wait, ranks};
use crate::pass::cycle::latency;
use crate::pass::nearby::Facts;
use crate::program::*;
use rustc_hash::{FxHashMap, FxHashSet};
use srp_archdesc::isa::{Opcode, Ty};

/// Terms of a sum that is looked at.
const MAX_TERMS: usize = 16;

/// A multiple of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Term {
    base: Value,
    /// Its factor: a power of two, unless it is a product.
    factor: u32,
    is_negative: bool,
}

impl Term {
    /// The operation that makes it of its base, and the constant for that; `None` for the base itself.
    fn operation(&self) -> Option<(Opcode, u32)> {
        match self.factor {
            1 => None,
            factor if factor.is_power_of_two() => Some((Opcode::Shl, factor.trailing_zeros())),
            factor => Some((Opcode::Mul, factor)),
        }
    }

    /// The cycles from the loop's parameters to its value; `None` if the loop does not carry it.
    fn wait(&self, waits: &FxHashMap<Value, u32>) -> Option<u32> {
        let own = self.operation().map_or(0, |(op, _)| latency(op));
        waits.get(&self.base).map(|wait| wait + own)
    }
}

/// Shortens the recurrences through sums of a block; whether there were any to shorten.
pub(super) fn shorten(func: &mut Function, block: Block, has_products: bool) -> bool {
    let cycles = Cycles::of(func, block);
    if cycles.is_empty() {
        return false;
    }
    let mut sums = Sums {
        trees: Trees::of(func, block),
        facts: Facts::of(func),
    };
    let roots = sums.roots(func, block);
    let mut changed = false;
    for root in roots {
        let result = func.insts[root].results[0];
        if !cycles.has(result, result) {
            continue;
        }
        let waits = cycles.waits(func, block, result);
        let before = waits.get(&result).copied();
        let Some(terms) = sums.terms(func, root, &waits) else {
            continue;
        };
        let wait_of = |terms: &[Term]| {
            let waits = terms.iter().map(|term| term.wait(&waits)).collect();
            least_wait(waits, latency(Opcode::Add))
        };
        let best = forms(&terms, &waits, has_products)
            .into_iter()
            .filter(|terms| terms.iter().any(|t| !t.is_negative && !is_itself(terms, t)))
            .min_by_key(|terms| (wait_of(terms), terms.len()));
        if let Some(best) = best.filter(|best| wait_of(best) < before) {
            sums.build(func, block, root, &best, &waits);
            changed = true;
        }
    }
    changed
}

/// True if a term is all of a sum, which then is its base.
fn is_itself(terms: &[Term], term: &Term) -> bool {
    terms.len() == 1 && term.factor == 1
}

/// The ways to write a sum: as it is, or with the terms of one carried value as one product or as two shifts.
fn forms(terms: &[Term], waits: &FxHashMap<Value, u32>, has_products: bool) -> Vec<Vec<Term>> {
    let mut forms = vec![terms.to_vec()];
    let mut bases: Vec<Value> = terms.iter().map(|t| t.base).collect();
    bases.dedup();
    for base in bases.into_iter().filter(|base| waits.contains_key(base)) {
        let (own, others): (Vec<Term>, Vec<Term>) = terms.iter().partition(|t| t.base == base);
        let factor = own.iter().fold(0u32, |sum, term| match term.is_negative {
            true => sum.wrapping_sub(term.factor),
            false => sum.wrapping_add(term.factor),
        });
        let term = |factor, is_negative| Term {
            base,
            factor,
            is_negative,
        };
        let mut shapes = Vec::new();
        if factor.is_power_of_two() || has_products && factor != 0 {
            shapes.push(vec![term(factor, false)]);
        }
        shapes.extend(
            two_powers(factor).map(|powers| powers.map(|(f, sign)| term(f, sign)).to_vec()),
        );
        forms.extend(shapes.into_iter().map(|own| [&own[..], &others].concat()));
    }
    forms
}

/// Two powers of two, with their signs, whose sum is a factor that is no power itself.
fn two_powers(factor: u32) -> Option<[(u32, bool); 2]> {
    if factor.is_power_of_two() || factor == 0 {
        return None;
    }
    // Its lowest bit is one of them; if the rest is a power, or the rest with the bit taken away.
    let low = 1 << factor.trailing_zeros();
    let (less, more) = (factor - low, factor.wrapping_add(low));
    if less.is_power_of_two() {
        Some([(less, false), (low, false)])
    } else if more.is_power_of_two() {
        Some([(more, false), (low, true)])
    } else {
        let less = factor.wrapping_neg().wrapping_add(low);
        less.is_power_of_two()
            .then_some([(low, false), (less, true)])
    }
}

struct Sums {
    trees: Trees,
    facts: Facts,
}

impl Sums {
    /// The sums of a block that are no terms of others.
    fn roots(&self, func: &Function, block: Block) -> Vec<Inst> {
        let is_sum = |op: Opcode| matches!(op, Opcode::Add | Opcode::Sub);
        let mut roots = Vec::new();
        let mut within = FxHashSet::default();
        for &inst in func.blocks[block].insts.iter().rev() {
            if let InstKind::Op { op, args, .. } = &func.insts[inst].kind
                && is_sum(*op)
            {
                if !within.contains(&inst) {
                    roots.push(inst);
                }
                let inner = args.iter().filter_map(|&v| self.trees.inner(func, v));
                within.extend(inner.filter(|&(_, op, _)| is_sum(op)).map(|(i, ..)| i));
            }
        }
        roots.reverse();
        roots
    }

    /// The terms of a sum; `None` if they are too many.
    fn terms(
        &self,
        func: &Function,
        root: Inst,
        waits: &FxHashMap<Value, u32>,
    ) -> Option<Vec<Term>> {
        let result = func.insts[root].results[0];
        let mut terms = Vec::new();
        let mut open = vec![(result, false)];
        while let Some((value, is_negative)) = open.pop() {
            let made = match value == result {
                true => self
                    .trees
                    .made_by
                    .get(&value)
                    .map(|&inst| &func.insts[inst].kind),
                false => self
                    .trees
                    .inner(func, value)
                    .map(|(i, ..)| &func.insts[i].kind),
            };
            let made = match made {
                Some(InstKind::Op { op, args, .. }) => Some((*op, &args[..])),
                _ => None,
            };
            let constant = |v: Value| self.facts.constants.get(&v).copied();
            match made {
                Some((Opcode::Add, &[a, b])) => open.extend([(b, is_negative), (a, is_negative)]),
                Some((Opcode::Sub, &[a, b])) => open.extend([(b, !is_negative), (a, is_negative)]),
                made => {
                    let (base, factor) = match made {
                        Some((op, &[a, b])) if waits.contains_key(&a) => match (op, constant(b)) {
                            (Opcode::Shl, Some(by)) => (a, 1 << (by & 31)),
                            (Opcode::Mul, Some(factor)) if factor != 0 => (a, factor),
                            _ => (value, 1),
                        },
                        _ => (value, 1),
                    };
                    terms.push(Term {
                        base,
                        factor,
                        is_negative,
                    });
                }
            }
            if terms.len() + open.len() > MAX_TERMS {
                return None;
            }
        }
        Some(terms)
    }

    /// Makes a sum of its terms, always of the two that are there first.
    fn build(
        &mut self,
        func: &mut Function,
        block: Block,
        root: Inst,
        terms: &[Term],
        waits: &FxHashMap<Value, u32>,
    ) {
        let pos = func.insts[root].pos;
        let depths = ranks(func, block);
        let mut made = Vec::new();
        let mut push = |func: &mut Function, kind: InstKind| {
            let inst = func.make_inst(kind, &[Ty::Word], pos);
            made.push(inst);
            func.insts[inst].results[0]
        };
        let of = |op, args| InstKind::Op { op, args, imm: 0 };
        let mut open = Vec::new();
        for term in terms {
            let mut value = term.base;
            if let Some((op, with)) = term.operation() {
                let with = push(func, InstKind::Const(Bits::Word(with)));
                let kind = of(op, vec![value, with]);
                if terms.len() == 1 {
                    func.insts[root].kind = kind;
                    break;
                }
                value = push(func, kind);
            }
            let wait = term.wait(waits);
            let depth = depths.get(&term.base).copied().unwrap_or(0);
            open.push(((wait, depth), value, term.is_negative));
        }
        open.sort_by_key(|&(rank, ..)| rank);
        while let [(a_rank, a, a_negative), (b_rank, b, b_negative), ..] = open[..] {
            open.drain(..2);
            let kind = match (a_negative, b_negative) {
                (true, false) => of(Opcode::Sub, vec![b, a]),
                (false, true) => of(Opcode::Sub, vec![a, b]),
                _ => of(Opcode::Add, vec![a, b]),
            };
            if open.is_empty() {
                func.insts[root].kind = kind;
                break;
            }
            let sum = push(func, kind);
            let (wait, depth) = a_rank.max(b_rank);
            let rank = (wait.map(|wait| wait + latency(Opcode::Add)), depth + 1);
            let place = open.partition_point(|&(other, ..)| other <= rank);
            open.insert(place, (rank, sum, a_negative && b_negative));
        }
        let insts = &mut func.blocks[block].insts;
        let place = insts.iter().position(|&i| i == root).expect("it is there");
        insts.splice(place..place, made);
    }
}
