//! Loads that certainly do not trap, because an access that is made in any case lies nearby: no object
//! lies so close to the ends of SRAM that they could ([`RED_ZONE`]).

use super::order::CONTROL;
use crate::layout::RED_ZONE;
use crate::program::*;
use rustc_hash::{FxHashMap, FxHashSet};
use srp_archdesc::isa::{Opcode, Space};

/// How far from a certain access a load may be that runs in any case. What one run has made certain
/// the next takes for certain, so the runs share what there is. They are those of [`CONTROL`]: in other
/// lists of passes no load runs in any case.
pub(super) const REACH: u32 = RED_ZONE / RUNS;

/// The runs of passes that make loads certain.
const RUNS: u32 = runs("hyperblock");

/// How often a pass runs on control code.
const fn runs(name: &str) -> u32 {
    let (mut at, mut count) = (0, 0);
    while at < CONTROL.len() {
        let (a, b) = (CONTROL[at].as_bytes(), name.as_bytes());
        let mut same = a.len() == b.len();
        let mut byte = 0;
        while same && byte < a.len() {
            same = a[byte] == b[byte];
            byte += 1;
        }
        count += same as u32;
        at += 1;
    }
    count
}

// A load of a vector has to be in reach of itself.
const _: () = assert!(REACH >= 16);

/// Facts about the values of a function.
pub(super) struct Facts {
    /// The constants *true*.
    pub(super) truths: FxHashSet<Value>,
    /// The words that are constants.
    pub(super) constants: FxHashMap<Value, u32>,
    /// Operands of sums.
    sums: FxHashMap<Value, [Value; 2]>,
}

impl Facts {
    pub(super) fn of(func: &Function) -> Facts {
        let mut facts = Facts {
            truths: FxHashSet::default(),
            constants: FxHashMap::default(),
            sums: FxHashMap::default(),
        };
        for &inst in func.layout.iter().flat_map(|&b| &func.blocks[b].insts) {
            let data = &func.insts[inst];
            match &data.kind {
                InstKind::Const(Bits::Pred(true)) => {
                    facts.truths.insert(data.results[0]);
                }
                InstKind::Const(Bits::Word(word)) => {
                    facts.constants.insert(data.results[0], *word);
                }
                InstKind::Op {
                    op: Opcode::Add,
                    args,
                    ..
                } => {
                    facts.sums.insert(data.results[0], [args[0], args[1]]);
                }
                _ => {}
            }
        }
        facts
    }

    /// An address as the sum of some values, in their order, and a constant.
    pub(super) fn terms(&self, address: Value) -> (Vec<Value>, u32) {
        let (mut terms, mut offset) = (Vec::new(), 0u32);
        let mut open = vec![address];
        while let Some(value) = open.pop() {
            match (self.constants.get(&value), self.sums.get(&value)) {
                (Some(constant), _) => offset = offset.wrapping_add(*constant),
                (_, Some(parts)) if terms.len() + open.len() < MAX_TERMS => open.extend(parts),
                _ => terms.push(value),
            }
        }
        terms.sort_unstable();
        (terms, offset)
    }
}

/// Values whose sum an address is taken for.
const MAX_TERMS: usize = 4;

/// An access of SRAM.
pub(super) struct Access {
    /// The predicate under which it is made; `None` if that is always.
    guard: Option<Value>,
    terms: Vec<Value>,
    offset: u32,
    bytes: u32,
}

impl Access {
    pub(super) fn of(op: Opcode, args: &[Value], imm: i32, facts: &Facts) -> Option<Access> {
        if op.space() != Some(Space::Sram) {
            return None;
        }
        let (terms, offset) = facts.terms(*args.get(1)?);
        Some(Access {
            guard: Some(args[0]).filter(|guard| !facts.truths.contains(guard)),
            terms,
            offset: offset.wrapping_add_signed(imm),
            bytes: op.access_bytes()?,
        })
    }

    /// True if another access cannot trap where this one does not.
    pub(super) fn vouches_for(&self, other: &Access) -> bool {
        let distance = other.offset.wrapping_sub(self.offset) as i32;
        self.guard.is_none_or(|guard| other.guard == Some(guard))
            && self.terms == other.terms
            && self.bytes >= other.bytes
            && distance.unsigned_abs() + other.bytes <= REACH
            && distance.unsigned_abs().is_multiple_of(other.bytes)
    }
}
