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
}

/// Rounds of simplification, at most: each may make the next possible.
const MAX_ROUNDS: u32 = 8;

/// Brings a verified program from the form that a front end lowers to into the one that the
/// machine runs: no calls and no branches in kernel loops, variables in registers, nothing twice.
/// What could not be done is told in the order of the passes, each remark once.
pub fn optimise(program: &mut Program, options: &Options) -> Vec<Remark> {
    let mut remarks = Vec::new();
    // Functions are judged by their size, so they are made small first.
    each(program, |f| simplify(f, options, &mut remarks));
    remarks.extend(inline(program));
    each(program, |f| simplify(f, options, &mut remarks));
    each(program, |f| {
        licm(f);
        remarks.extend(ifconvert(f));
        simplify(f, options, &mut remarks);
        if options.associative_math && reassociate(f) {
            simplify(f, options, &mut remarks);
        }
        licm(f);
        strength(f);
        simplify(f, options, &mut remarks);
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
fn simplify(func: &mut Function, options: &Options, remarks: &mut Vec<Remark>) {
    for _ in 0..MAX_ROUNDS {
        let mut changed = simplify_cfg(func, remarks);
        changed |= fold(func, &options.precision);
        changed |= mem2reg(func);
        changed |= copyprop(func);
        changed |= gvn(func);
        changed |= dce(func);
        if !changed {
            break;
        }
    }
}
