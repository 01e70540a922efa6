//! Who made the value that a register has.

use crate::event::Done;
use srp_csimgen::spec::Landing;
use std::collections::BTreeMap;

/// Who made the values in the registers of a core, by names of the caller's. It is told of the steps of each turn, in
/// their order, and of the turn's end.
#[derive(Clone, Debug)]
pub(crate) struct Flow<N> {
    makers: BTreeMap<u32, N>,
    /// Results of VLIW code that have not landed: turns that are left until then, register, maker.
    on_the_way: Vec<(u32, u32, N)>,
}

impl<N> Default for Flow<N> {
    fn default() -> Flow<N> {
        Flow {
            makers: BTreeMap::new(),
            on_the_way: Vec::new(),
        }
    }
}

impl<N: Copy> Flow<N> {
    /// The makers of a step's operands, where they are known. To be asked before the step is told of.
    pub(crate) fn producers(&self, done: &Done<'_>) -> [Option<N>; 3] {
        done.sources.map(|cell| self.makers.get(&cell?).copied())
    }

    /// The step makes its result.
    pub(crate) fn make(&mut self, done: &Done<'_>, maker: N) {
        for &cell in done.dests {
            match done.step.landing {
                Landing::After(turns) => self.on_the_way.push((turns, cell, maker)),
                Landing::InPlace => {
                    self.makers.insert(cell, maker);
                }
            }
        }
    }

    /// The step only brings a value to another place.
    pub(crate) fn pass_on(&mut self, done: &Done<'_>) {
        match self.producers(done)[0] {
            Some(maker) => self.make(done, maker),
            // It is older than all that is known.
            None => done.dests.iter().for_each(|cell| {
                self.makers.remove(cell);
            }),
        }
    }

    /// A register gets the value of another, or of none.
    pub(crate) fn set(&mut self, cell: u32, source: Option<u32>) {
        match source.and_then(|source| self.makers.get(&source).copied()) {
            Some(maker) => self.makers.insert(cell, maker),
            None => self.makers.remove(&cell),
        };
    }

    /// The turn is over.
    pub(crate) fn end_turn(&mut self) {
        let makers = &mut self.makers;
        self.on_the_way.retain_mut(|(left, cell, maker)| {
            *left -= 1;
            if *left == 0 {
                makers.insert(*cell, *maker);
            }
            *left > 0
        });
    }
}
