//! The most iterations that a loop with several ways out can still run, where one of its tests counts: a chunk need not be
//! longer.

use super::at::At;
use super::counted::Within;
use crate::flow::{Dominators, LoopData};
use crate::pass::defs::Defs;
use crate::program::*;
use srp_archdesc::isa::Opcode;

/// A test that each iteration makes, of a variable that goes towards a bound by a power of two.
pub(super) struct Limit {
    /// The place among the header's parameters of the variable, and what is added to it before it is tested.
    place: usize,
    plus: u32,
    bound: Bound,
    /// The comparison of the smaller one with the larger one, by which the loop goes on.
    compare: Opcode,
    /// The variable is the smaller one, and grows.
    grows: bool,
    /// The logarithm of the steps that it goes by.
    shift: u32,
    /// The word that the variable begins with, if that is constant.
    first: Option<u32>,
}

/// The end that a variable goes to.
#[derive(Clone, Copy)]
enum Bound {
    Constant(u32),
    /// A value that is there before the loop.
    Value(Value),
}

impl Limit {
    /// A limit of a loop of one way back.
    pub(super) fn of(func: &Function, dominators: &Dominators, data: &LoopData) -> Option<Limit> {
        let known = Known {
            within: Within::of(func, data),
            defs: Defs::of(func),
        };
        let latch = data.latches[0];
        data.blocks.iter().find_map(|&block| {
            if !data.is_left_at(func, block) || !dominators.dominates(block, latch) {
                return None;
            }
            let Terminator::Branch { cond, then, .. } = &func.blocks[block].end else {
                return None;
            };
            Limit::of_test(&known, (*cond, data.contains(then.block)))
        })
    }

    /// The limit by a test with whose outcome the loop goes on.
    fn of_test(known: &Known<'_>, (mut cond, mut outcome): (Value, bool)) -> Option<Limit> {
        let Within { func, data, .. } = known.within;
        while let Some((Opcode::Pnot, args)) = known.within.op(cond) {
            (cond, outcome) = (args[0], !outcome);
        }
        let (op, &[left, right]) = known.within.op(cond)? else {
            return None;
        };
        let negated = |op| match op {
            Opcode::Lt => Some(Opcode::Le),
            Opcode::Le => Some(Opcode::Lt),
            Opcode::Ltu => Some(Opcode::Leu),
            Opcode::Leu => Some(Opcode::Ltu),
            _ => None,
        };
        let opposite = negated(op)?;
        let (compare, smaller, larger) = match outcome {
            true => (op, left, right),
            false => (opposite, right, left),
        };
        [(smaller, larger, true), (larger, smaller, false)]
            .into_iter()
            .find_map(|(variable, bound, grows)| {
                let (place, plus) = known.counter(variable)?;
                let stride = known.stride(place)? as i32;
                let is_towards = (stride > 0) == grows && stride.unsigned_abs().is_power_of_two();
                let bound = known.bound(bound).filter(|_| is_towards)?;
                let entries = func.layout.iter().filter(|&&from| !data.contains(from));
                let mut entries = entries
                    .flat_map(|&from| func.blocks[from].end.targets())
                    .filter(|target| target.block == data.header);
                let first = entries.next().map(|target| target.args[place]);
                Some(Limit {
                    place,
                    plus,
                    bound,
                    compare,
                    grows,
                    shift: stride.unsigned_abs().trailing_zeros(),
                    first: first
                        .filter(|_| entries.next().is_none())
                        .and_then(|v| known.defs.word(func, v)),
                })
            })
    }

    /// The most iterations, where what is compared is constant at first.
    pub(super) fn count(&self) -> Option<u32> {
        let Bound::Constant(bound) = self.bound else {
            return None;
        };
        let first = self.first?.wrapping_add(self.plus);
        let (smaller, larger) = match self.grows {
            true => (first, bound),
            false => (bound, first),
        };
        let goes_on = match self.compare {
            Opcode::Lt => (smaller as i32) < larger as i32,
            Opcode::Le => smaller as i32 <= larger as i32,
            Opcode::Ltu => smaller < larger,
            _ => smaller <= larger,
        };
        match goes_on {
            true => Some(self.after(larger.wrapping_sub(smaller))),
            false => Some(1),
        }
    }

    /// The iterations that a variable needs over a distance, with the one in which the loop is left.
    fn after(&self, distance: u32) -> u32 {
        let steps = distance.wrapping_add(self.slack()) >> self.shift;
        steps.wrapping_add(1)
    }

    /// The addend that makes a distance the next number of whole steps.
    fn slack(&self) -> u32 {
        match self.compare {
            // A last step from the bound itself.
            Opcode::Le | Opcode::Leu => 1 << self.shift,
            _ => (1 << self.shift) - 1,
        }
    }

    /// The length of a chunk that begins with these values of the header's parameters: no more than the loop can run, as far
    /// as signed words tell, and less than one where it ends at once.
    pub(super) fn clip(&self, at: &mut At<'_>, block: Block, own: &[Value], chunk: Value) -> Value {
        let bound = match self.bound {
            Bound::Constant(word) => at.constant(block, Bits::Word(word)),
            Bound::Value(value) => value,
        };
        let (smaller, larger, plus) = match self.grows {
            true => (own[self.place], bound, self.plus.wrapping_neg()),
            false => (bound, own[self.place], self.plus),
        };
        let distance = at.op(block, Opcode::Sub, &[larger, smaller]);
        let slack = at.constant(block, Bits::Word(self.slack().wrapping_add(plus)));
        let distance = at.op(block, Opcode::Add, &[distance, slack]);
        let shift = at.constant(block, Bits::Word(self.shift));
        let steps = at.op(block, Opcode::Sar, &[distance, shift]);
        let one = at.constant(block, Bits::Word(1));
        let most = at.op(block, Opcode::Add, &[steps, one]);
        at.op(block, Opcode::Min, &[chunk, most])
    }
}

/// The values of a loop, and the constants of its function.
struct Known<'a> {
    within: Within<'a>,
    defs: Defs,
}

impl Known<'_> {
    /// The parameter of the header that a value is, by its place, and the constant that is added to it.
    fn counter(&self, value: Value) -> Option<(usize, u32)> {
        let header = &self.within.func.blocks[self.within.data.header];
        let place = |value: Value| header.params.iter().position(|&p| p == value);
        if let Some(place) = place(value) {
            return Some((place, 0));
        }
        match self.within.op(value)? {
            (Opcode::Add, &[param, plus]) => Some((place(param)?, self.constant(plus)?)),
            _ => None,
        }
    }

    /// The constant by which a parameter of the header changes in each iteration.
    fn stride(&self, place: usize) -> Option<u32> {
        let (from, plus) = self.counter(self.within.next(place)?)?;
        (from == place).then_some(plus)
    }

    /// The word that a value which does not change is before the loop.
    fn bound(&self, value: Value) -> Option<Bound> {
        match self.constant(value) {
            Some(word) => Some(Bound::Constant(word)),
            None => (!self.within.inside[value]).then_some(Bound::Value(value)),
        }
    }

    fn constant(&self, value: Value) -> Option<u32> {
        self.defs.word(self.within.func, value)
    }
}
