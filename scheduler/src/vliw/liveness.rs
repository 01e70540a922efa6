//! Which registers hold a value that is read later, at the end of each block.

use super::lir::{Code, Inst, Label, Vreg};
use srp_archdesc::entity::{Entity, EntityMap};

/// A set of registers.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct RegSet {
    words: Vec<u64>,
}

impl RegSet {
    /// The empty set of registers with numbers below `count`.
    pub(super) fn new(count: usize) -> RegSet {
        RegSet {
            words: vec![0; count.div_ceil(64)],
        }
    }

    pub(super) fn insert(&mut self, reg: Vreg) {
        self.words[reg.index() / 64] |= 1 << (reg.index() % 64);
    }

    pub(super) fn remove(&mut self, reg: Vreg) {
        self.words[reg.index() / 64] &= !(1 << (reg.index() % 64));
    }

    /// Adds all of `other`; whether that changed anything.
    fn add(&mut self, other: &RegSet) -> bool {
        let mut changed = false;
        for (a, b) in self.words.iter_mut().zip(&other.words) {
            changed |= *b & !*a != 0;
            *a |= b;
        }
        changed
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Vreg> + '_ {
        self.words.iter().enumerate().flat_map(|(i, &word)| {
            (0..64)
                .filter(move |bit| word >> bit & 1 == 1)
                .map(move |bit| Vreg::new(64 * i + bit))
        })
    }
}

/// The step over one operation, backwards.
pub(super) fn step(live: &mut RegSet, inst: &Inst) {
    let written = inst.defs.iter().chain(&inst.clobbers);
    written.for_each(|&r| live.remove(r));
    inst.uses().for_each(|r| live.insert(r));
}

/// The registers live at the end of each block, after its [`End`](super::lir::End) has read its own.
pub(super) fn live_out(code: &Code) -> EntityMap<Label, RegSet> {
    let empty = RegSet::new(code.regs.len());
    let mut out = EntityMap::filled(code.blocks.len(), empty.clone());
    let mut into = EntityMap::filled(code.blocks.len(), empty);
    let preds = code.predecessors();
    let mut waiting: EntityMap<Label, bool> = EntityMap::filled(code.blocks.len(), false);
    let mut work: Vec<Label> = code.order.clone();
    work.iter().for_each(|&label| waiting[label] = true);
    while let Some(label) = work.pop() {
        waiting[label] = false;
        let block = &code.blocks[label];
        let mut live = out[label].clone();
        block.end.uses().for_each(|r| live.insert(r));
        block.insts.iter().rev().for_each(|i| step(&mut live, i));
        if !into[label].add(&live) {
            continue;
        }
        for &pred in &preds[label] {
            if out[pred].add(&into[label]) && !std::mem::replace(&mut waiting[pred], true) {
                work.push(pred);
            }
        }
    }
    out
}
