//! Applies the rule of each operation of a run to the shadows.

use super::arithmetic::{Function, Marked};
use super::rule::{Relation, Rule};
use super::{Mark, Marks, Meaning, PLAIN, Shadows};
use crate::interp::{Done, Observer, Values, World};
use crate::program::Pos;
use srp_archdesc::isa::{Effect, Opcode};

impl<W: World> Observer<W> for Shadows<'_> {
    fn enter(&mut self, base: usize, len: usize) {
        self.values.truncate(base);
        self.values.resize(base + len, PLAIN);
    }

    fn constant(&mut self, to: usize) {
        self.values[to] = PLAIN;
    }

    fn moved(&mut self, from: Values<'_>, to: Values<'_>) {
        self.moving.clear();
        for number in from.numbers() {
            self.moving.push(self.values[number]);
        }
        for (number, marks) in to.numbers().zip(&self.moving) {
            self.values[number] = *marks;
        }
    }

    fn branch(&mut self, cond: usize, _: bool, _: Pos) {
        self.settle(self.values[cond][0]);
    }

    fn done(&mut self, done: &Done<'_>, world: &mut W) {
        let mut marks = [PLAIN; 3];
        for (i, marks) in marks.iter_mut().enumerate() {
            if i < done.op.info().operands.len() {
                *marks = self.values[done.args[i]];
            }
        }
        let result = self.result(done, marks, world);
        if let Some((to, _)) = done.result {
            self.values[to] = result;
        }
    }
}

/// Lane `i` of operand `k` as a float.
fn float(done: &Done<'_>, marks: &[Marks; 3], k: usize, i: usize) -> Marked {
    (f32::from_bits(done.operands[k].0[i]), marks[k][i])
}

/// Marks of the first lanes; the others are plain.
#[inline]
fn each_lane(lanes: usize, mut mark: impl FnMut(usize) -> Mark) -> Marks {
    std::array::from_fn(|i| if i < lanes { mark(i) } else { Mark::PLAIN })
}

impl Shadows<'_> {
    fn result(&mut self, done: &Done<'_>, marks: [Marks; 3], world: &mut impl World) -> Marks {
        let rule = Rule::of(done.op);
        // Nothing is known of operands that have no marks, and of what is made of them.
        if marks == [PLAIN; 3] && !rule.needs_no_marks() {
            return PLAIN;
        }
        let [a, b, c] = marks;
        let lane = (done.imm as u32 & 3) as usize;
        match rule {
            Rule::Float(function, lanes) => self.computed(done, &marks, function, lanes),
            Rule::Dot(n) => self.summed(done, &marks, n),
            Rule::Access | Rule::Texture => self.access(done, marks, world),
            Rule::FromInteger { signed, lanes } => self.integers_to_floats(done, a, signed, lanes),
            Rule::ToInteger(lanes) => {
                let source = self.sources.number(done.func, done.inst);
                each_lane(lanes, |i| {
                    let (value, mark) = float(done, &marks, 0, i);
                    self.converted(source, value, mark)
                })
            }
            Rule::Floor(lanes) => {
                let source = self.sources.number(done.func, done.inst);
                for i in 0..lanes {
                    self.floored(source, float(done, &marks, 0, i));
                }
                PLAIN
            }
            Rule::Relation(relation, lanes) => {
                each_lane(lanes, |i| self.relation(done, &marks, relation, i))
            }
            Rule::Bits(how, lanes) => match self.taken_apart(done, how, lanes, marks) {
                Some(marks) => marks,
                None => self.combined(done, how, lanes, marks),
            },
            Rule::ShiftUp => self.moved_up(done, a[0], b[0]),
            Rule::Equality => each_lane(1, |_| self.equality(done, a[0], b[0])),
            Rule::Logic(logic) => self.of_truths(done, logic, 1, marks),
            Rule::Move => a,
            Rule::Select => self.selected(done, a[0], b, c),
            Rule::Blend => each_lane(4, |i| {
                let lane = |k: usize| done.operands[k].0[i];
                self.blended([lane(0), lane(1), lane(2)], [a[i], b[i], c[i]])
            }),
            Rule::Splat => [a[0]; 4],
            Rule::Extract => each_lane(1, |_| a[lane]),
            Rule::Insert => each_lane(4, |i| if i == lane { b[0] } else { a[i] }),
            Rule::Swizzle => each_lane(4, |i| a[(done.imm as u32 >> (2 * i) & 3) as usize]),
            Rule::Use | Rule::Halves => self.used(marks),
        }
    }

    /// A function of floats, lane by lane.
    fn computed(
        &mut self,
        done: &Done<'_>,
        marks: &[Marks; 3],
        function: Function,
        lanes: usize,
    ) -> Marks {
        let source = self.sources.number(done.func, done.inst);
        let results = done.result.map_or([0; 4], |(_, value)| value.0);
        each_lane(lanes, |i| {
            let args = [0, 1, 2].map(|k| float(done, marks, k, i));
            self.lane(function, source, args, f32::from_bits(results[i]))
        })
    }

    /// A dot product of `n` lanes.
    fn summed(&mut self, done: &Done<'_>, marks: &[Marks; 3], n: usize) -> Marks {
        let source = self.sources.number(done.func, done.inst);
        let result = done.result.map_or(0, |(_, value)| value.0[0]);
        let lanes = |k| std::array::from_fn(|i| float(done, marks, k, i));
        let (a, b) = (lanes(0), lanes(1));
        each_lane(1, |_| self.dot(source, n, a, b, f32::from_bits(result)))
    }

    /// Floats made of integers.
    fn integers_to_floats(
        &mut self,
        done: &Done<'_>,
        marks: Marks,
        signed: bool,
        lanes: usize,
    ) -> Marks {
        let source = self.sources.number(done.func, done.inst);
        let results = done.result.map_or([0; 4], |(_, value)| value.0);
        each_lane(lanes, |i| {
            self.settle(marks[i]);
            let word = done.operands[0].0[i];
            let exact = match signed {
                true => f64::from(word as i32),
                false => f64::from(word),
            };
            let value = f32::from_bits(results[i]);
            Mark::node(self.tape.push(value, exact, source, [(0, 0.0); 3]))
        })
    }

    fn access(&mut self, done: &Done<'_>, marks: [Marks; 3], world: &mut impl World) -> Marks {
        let [guard, address, value] = marks;
        self.settle(guard[0]);
        if !done.operands[0].as_pred() {
            return PLAIN;
        }
        if done.op == Opcode::Tex {
            let source = self.sources.number(done.func, done.inst);
            return self.sampled(done, source, value, world);
        }
        self.settle(address[0]);
        let address = done.operands[1].as_word().wrapping_add_signed(done.imm);
        if done.op.info().effect == Effect::Store {
            self.stored(done.op, address, value);
            return PLAIN;
        }
        self.loaded(done.op, address)
    }

    /// The mark of one lane of a comparison of floats.
    fn relation(
        &mut self,
        done: &Done<'_>,
        marks: &[Marks; 3],
        relation: Relation,
        i: usize,
    ) -> Mark {
        let source = self.sources.number(done.func, done.inst);
        let args = [0, 1].map(|k| float(done, marks, k, i));
        let outcome = done.result.is_some_and(|(_, value)| value.0[i] != 0);
        if args.iter().any(|(value, _)| value.is_nan()) {
            return Mark::PLAIN;
        }
        self.compare(source, args, outcome, |a, b| relation.holds(a, b))
    }

    /// The mark of whether two integers are equal. A truth value against 0 is one again.
    fn equality(&mut self, done: &Done<'_>, a: Mark, b: Mark) -> Mark {
        let [x, y, _] = done.operands.map(|operand| operand.as_word());
        for (mark, other, value) in [(a, b, y), (b, a, x)] {
            let disputed = matches!(mark.meaning(), Meaning::Dispute(_));
            if disputed && other == Mark::PLAIN && value == 0 {
                return mark;
            }
        }
        self.settle(a);
        self.settle(b);
        Mark::PLAIN
    }
}
