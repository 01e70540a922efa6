//! Intervals of what a program may compute of a memory that is known, on a machine whose units round otherwise than binary32.

use super::decisions::each_way;
use super::evaluate::Meaning;
use super::memory::Word;
use crate::real::{Bounded, Undefined, Units};
use srp_archdesc::arch::Precision;
use srp_ir::layout::Layout;
use srp_ir::pass::FastMath;
use srp_ir::program::Program;
use std::collections::BTreeMap;

/// For some words of memory the least and the greatest number that they may be after a run of the program before any
/// pass, whichever way its decisions go on units of this precision. Functions of `math.h` are computed as their text says.
///
/// # Errors
///
/// Why there are no such numbers.
pub(crate) fn computed(
    (program, layout): (&Program, &Layout),
    memory: &BTreeMap<u32, u32>,
    places: &[u32],
    precision: &Precision,
) -> Result<Vec<[f64; 2]>, Undefined> {
    let words = memory.iter().map(|(&at, &word)| (at, Word::Bits(word)));
    let words: BTreeMap<u32, Word<Bounded>> = words.collect();
    let units = Units::of(precision, FastMath::default());
    let meaning = Meaning::literal(program, layout);
    let too_many = |n| Undefined(format!("more than {n} ways lead through the call"));
    let ways = each_way(too_many, |decisions| {
        let memory = meaning.run(&words, &units, decisions)?;
        let numbers = places.iter().map(|&at| memory.word(at).number().computed());
        Ok::<Vec<(f64, f64)>, Undefined>(numbers.collect())
    })?;
    let mut hull = vec![[f64::INFINITY, f64::NEG_INFINITY]; places.len()];
    for (low, high) in ways.iter().flatten() {
        if !low.is_finite() || !high.is_finite() {
            return Err(Undefined("a number may be infinite or none".to_owned()));
        }
    }
    for way in ways {
        for (all, (low, high)) in hull.iter_mut().zip(way) {
            *all = [all[0].min(low), all[1].max(high)];
        }
    }
    Ok(hull)
}
