//! What shadows make of each operation of a run.

use super::arithmetic::{Marked, function};
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

impl Shadows<'_> {
    fn result(&mut self, done: &Done<'_>, marks: [Marks; 3], world: &mut impl World) -> Marks {
        if let Some((function, lanes)) = function(done.op) {
            let source = self.sources.number(done.func, done.inst);
            let results = done.result.map_or([0; 4], |(_, value)| value.0);
            return std::array::from_fn(|i| match i < lanes {
                true => {
                    let args = [0, 1, 2].map(|k| float(done, &marks, k, i));
                    self.lane(function, source, args, f32::from_bits(results[i]))
                }
                false => Mark::PLAIN,
            });
        }
        match done.op.info().effect {
            Effect::Load | Effect::Store => return self.access(done, marks, world),
            // Nothing is known of operands that have no marks, and of what is made of them.
            Effect::Pure if marks == [PLAIN; 3] && !rounds(done.op) => return PLAIN,
            Effect::Pure | Effect::Io => {}
        }
        let handed_on = self.handed_on(done, marks);
        if let Some(marks) = handed_on.or_else(|| self.of_truths(done, marks)) {
            return marks;
        }
        self.other(done, marks)
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

    /// Comparisons, conversions, dot products, and integers.
    fn other(&mut self, done: &Done<'_>, marks: [Marks; 3]) -> Marks {
        use Opcode::*;
        let source = self.sources.number(done.func, done.inst);
        let result = done.result.map_or([0; 4], |(_, value)| value.0);
        let lanes = |k| std::array::from_fn(|i| float(done, &marks, k, i));
        let mut of = PLAIN;
        match done.op {
            Feq | Fne | Flt | Fle => of[0] = self.relation(done, &marks, source, 0),
            Vfeq | Vfne | Vflt | Vfle => {
                of = std::array::from_fn(|i| self.relation(done, &marks, source, i));
            }
            Dot3 | Dot4 => {
                let n = if done.op == Dot3 { 3 } else { 4 };
                let result = f32::from_bits(result[0]);
                of[0] = self.dot(source, n, lanes(0), lanes(1), result);
            }
            Ftoi | Ftou | Vftoi => {
                let n = if done.op == Vftoi { 4 } else { 1 };
                for (i, of) in of.iter_mut().enumerate().take(n) {
                    let (value, mark) = float(done, &marks, 0, i);
                    *of = self.converted(source, value, mark);
                }
            }
            Ffloor | Vffloor => {
                let n = if done.op == Vffloor { 4 } else { 1 };
                for i in 0..n {
                    self.floored(source, float(done, &marks, 0, i));
                }
            }
            Itof | Utof | Vitof => {
                let n = if done.op == Vitof { 4 } else { 1 };
                for (i, of) in of.iter_mut().enumerate().take(n) {
                    self.settle(marks[0][i]);
                    let word = done.operands[0].0[i];
                    let exact = match done.op {
                        Utof => f64::from(word),
                        _ => f64::from(word as i32),
                    };
                    let value = f32::from_bits(result[i]);
                    *of = Mark::node(self.tape.push(value, exact, source, [(0, 0.0); 3]));
                }
            }
            Eq | Ne => of[0] = self.equality(done, marks[0][0], marks[1][0]),
            _ => marks.iter().flatten().for_each(|&mark| self.settle(mark)),
        }
        of
    }

    fn relation(&mut self, done: &Done<'_>, marks: &[Marks; 3], source: u32, i: usize) -> Mark {
        use Opcode::*;
        let args = [0, 1].map(|k| float(done, marks, k, i));
        let outcome = done.result.is_some_and(|(_, value)| value.0[i] != 0);
        if args.iter().any(|(value, _)| value.is_nan()) {
            return Mark::PLAIN;
        }
        self.compare(source, args, outcome, |a, b| match done.op {
            Feq | Vfeq => a == b,
            Fne | Vfne => a != b,
            Flt | Vflt => a < b,
            _ => a <= b,
        })
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

/// Whether an operation that has no float operand makes a float with an error.
fn rounds(op: Opcode) -> bool {
    use Opcode::*;
    matches!(op, Itof | Utof | Vitof | Dot3 | Dot4)
}
