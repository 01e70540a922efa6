//! Trip counts: how often loops run whose tests follow from constants.

use super::defs::Defs;
use crate::flow::{Dominators, LoopData};
use crate::program::*;
use rustc_hash::FxHashMap;
use srp_archdesc::arch::Precision;
use srp_archdesc::ops;

/// Definitions through which a value of a loop is followed to constants.
const MAX_DEPTH: u32 = 24;

/// The number of iterations that a loop begins, and the block whose test says so.
#[derive(Clone, Copy)]
pub(crate) struct Trip {
    pub(crate) count: u32,
    pub(super) test: Block,
}

/// The number of iterations of a loop, if one of its tests that every iteration makes depends on constants alone.
pub(crate) fn trip(
    func: &Function,
    dominators: &Dominators,
    data: &LoopData,
    limit: u32,
    precision: &Precision,
) -> Option<Trip> {
    let [latch] = data.latches[..] else {
        return None;
    };
    let mut backs = func.blocks[latch].end.targets();
    let back = backs.find(|t| t.block == data.header)?;
    if backs.any(|t| t.block == data.header) {
        // Two ways back may give the header different values.
        return None;
    }
    let mut entries = func.layout.iter().flat_map(|&from| {
        let targets = func.blocks[from].end.targets();
        targets
            .filter(|t| t.block == data.header)
            .map(move |t| (from, t))
    });
    let outside = |&(from, _): &(Block, &Target)| !data.contains(from);
    let (_, entry) = entries.find(outside)?;
    let others: Vec<&Target> = entries.filter(outside).map(|(_, t)| t).collect();
    let params = &func.blocks[data.header].params;
    let mut tests: Vec<(Block, Value, bool)> = data
        .blocks
        .iter()
        .filter(|&&block| dominators.dominates(block, latch))
        .filter_map(|&block| {
            let Terminator::Branch { cond, then, other } = &func.blocks[block].end else {
                return None;
            };
            let inside = |t: &Target| data.contains(t.block);
            (inside(then) != inside(other)).then(|| (block, *cond, inside(then)))
        })
        .collect();
    if tests.is_empty() {
        return None;
    }
    let mut known = Known::of(func, precision);
    // All ways in have to agree.
    let first = |(place, &v): (usize, &Value)| {
        let value = known.value(v, 0)?;
        let mut others = others.iter().map(|t| known.value(t.args[place], 0));
        others.all(|other| other == Some(value)).then_some(value)
    };
    let mut state: Vec<Option<ops::Value>> = entry.args.iter().enumerate().map(first).collect();
    for count in 1..=limit {
        let pairs = params.iter().copied().zip(state.iter().copied());
        known.params = pairs.filter_map(|(p, v)| Some((p, v?))).collect();
        known.memo.clear();
        // A test that is unknown in one iteration may end the loop there: it is not the test that
        // counts, even if it is known later.
        tests.retain(|&(_, cond, _)| known.value(cond, 0).is_some());
        if tests.is_empty() {
            return None;
        }
        for &(test, cond, stays) in &tests {
            if known.value(cond, 0).is_some_and(|v| (v.0[0] != 0) != stays) {
                return Some(Trip { count, test });
            }
        }
        state = back.args.iter().map(|&v| known.value(v, 0)).collect();
    }
    None
}

/// Values that follow from constants and from known parameters.
struct Known<'a> {
    func: &'a Function,
    precision: &'a Precision,
    defs: Defs,
    params: FxHashMap<Value, ops::Value>,
    memo: FxHashMap<Value, Option<ops::Value>>,
}

impl<'a> Known<'a> {
    fn of(func: &'a Function, precision: &'a Precision) -> Known<'a> {
        Known {
            func,
            precision,
            defs: Defs::of(func),
            params: FxHashMap::default(),
            memo: FxHashMap::default(),
        }
    }

    fn value(&mut self, value: Value, depth: u32) -> Option<ops::Value> {
        if let Some(&known) = self.params.get(&value) {
            return Some(known);
        }
        if let Some(&known) = self.memo.get(&value) {
            return known;
        }
        if depth > MAX_DEPTH {
            return None;
        }
        let found = match self.defs.kind(self.func, value)? {
            InstKind::Const(bits) => Some(ops::Value::from(*bits)),
            InstKind::Op { op, args, imm } if op.is_pure() => {
                let args: Option<Vec<ops::Value>> =
                    args.iter().map(|&a| self.value(a, depth + 1)).collect();
                args.and_then(|args| ops::eval(*op, &args, *imm, self.precision).ok()?)
            }
            _ => None,
        };
        self.memo.insert(value, found);
        found
    }
}
