//! The passes in order.

use super::*;
use crate::program::{Function, Program};
use srp_archdesc::arch::Precision;

/// How to optimise.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// How exact the special functions of the machine are: constants are folded by them.
    pub precision: Precision,
    /// Whether sums and products of floating-point numbers may be associated otherwise.
    pub associative_math: bool,
    /// Whether quotients may be products with reciprocals.
    pub reciprocal_math: bool,
    /// Whether sums may take in products without rounding them.
    pub contract: bool,
}

impl Options {
    /// What C allows, on a machine of this precision.
    pub const fn new(precision: Precision) -> Options {
        Options {
            precision,
            associative_math: false,
            reciprocal_math: false,
            contract: false,
        }
    }
}

/// Rounds of simplification, at most: each may make the next possible.
const MAX_ROUNDS: u32 = 8;

/// Brings a verified program from the form that a front end lowers to into the one that the
/// machine runs: no calls and no branches in kernel loops, variables in registers, nothing twice.
/// What could not be done is told in the order of the passes, each remark once.
pub fn optimise(program: &mut Program, options: &Options) -> Vec<Remark> {
    let mut remarks = Vec::new();
    // Until the steps of special functions are in the program, their operations stand for all of it.
    let (whole, first) = (&options.precision.in_units(), &options.precision);
    // Functions are judged by their size, so they are made small first.
    each(program, |f| simplify(f, whole, &mut remarks));
    remarks.extend(inline(program));
    each(program, |f| simplify(f, whole, &mut remarks));
    each(program, |f| {
        if options.reciprocal_math && reciprocal(f, &mut remarks) {
            simplify(f, whole, &mut remarks);
        }
        if refine(f, first) {
            simplify(f, first, &mut remarks);
        }
        licm(f);
        remarks.extend(ifconvert(f));
        simplify(f, first, &mut remarks);
        if options.associative_math && reassociate(f, &mut remarks) {
            simplify(f, first, &mut remarks);
        }
        if options.contract && contract(f, &mut remarks) {
            simplify(f, first, &mut remarks);
        }
        licm(f);
        strength(f);
        simplify(f, first, &mut remarks);
        compact(f);
    });
    let mut seen = std::collections::BTreeSet::new();
    remarks.retain(|remark| seen.insert(remark.clone()));
    remarks
}

fn each(program: &mut Program, pass: impl FnMut(&mut Function)) {
    program.funcs.values_mut().for_each(pass);
}

/// Makes a function simpler until it stays as it is.
fn simplify(func: &mut Function, precision: &Precision, remarks: &mut Vec<Remark>) {
    for _ in 0..MAX_ROUNDS {
        let mut changed = simplify_cfg(func, remarks);
        changed |= fold(func, precision);
        changed |= mem2reg(func);
        changed |= copyprop(func);
        changed |= gvn(func);
        changed |= dce(func);
        if !changed {
            break;
        }
    }
}
