//! Marks of selections, and of values made of bytes and of truth values.

use super::rule::{Bitwise, Logic};
use super::{Mark, Marks, Meaning, PLAIN, Shadows};
use crate::interp::Done;
use srp_archdesc::ops::Value;

impl Shadows<'_> {
    /// The marks of what is made of bits that are no floats: bytes that floats were converted to, or
    /// masks of truth values; others are used up.
    pub(super) fn combined(
        &mut self,
        done: &Done<'_>,
        how: Bitwise,
        lanes: usize,
        marks: [Marks; 3],
    ) -> Marks {
        let [a, b, _] = marks;
        match (how, lanes) {
            (Bitwise::And, 1) => self.of_word(done, a[0], b[0], |shadows, operands| {
                match b[0] == Mark::PLAIN {
                    true => shadows.masked(a[0], operands[1].as_word()),
                    false => shadows.masked(b[0], operands[0].as_word()),
                }
            }),
            (Bitwise::Or, 1) => {
                self.of_word(done, a[0], b[0], |shadows, _| shadows.united(a[0], b[0]))
            }
            (Bitwise::And, _) => self.of_truths(done, Logic::And, 4, marks),
            (Bitwise::Or, _) => self.of_truths(done, Logic::Or, 4, marks),
            (Bitwise::Xor, 4) => self.of_truths(done, Logic::Xor, 4, marks),
            (Bitwise::Xor | Bitwise::Add | Bitwise::Sub, _) => self.used(marks),
        }
    }

    /// The marks of a word whose bits were moved up.
    pub(super) fn moved_up(&mut self, done: &Done<'_>, a: Mark, b: Mark) -> Marks {
        self.of_word(done, a, b, |shadows, operands| {
            shadows.shifted(a, operands[1].as_word() & 31)
        })
    }

    /// An integer operation that keeps bytes whole; truth values are used up.
    fn of_word(
        &mut self,
        done: &Done<'_>,
        a: Mark,
        b: Mark,
        keep: impl Fn(&mut Self, &[Value; 3]) -> Mark,
    ) -> Marks {
        let is_bytes = |mark: Mark| matches!(mark.meaning(), Meaning::Bytes(_));
        for mark in [a, b] {
            if !is_bytes(mark) {
                self.settle(mark);
            }
        }
        let mark = match is_bytes(a) || is_bytes(b) {
            true => keep(self, done.operands),
            false => Mark::PLAIN,
        };
        [mark, Mark::PLAIN, Mark::PLAIN, Mark::PLAIN]
    }

    pub(super) fn selected(
        &mut self,
        done: &Done<'_>,
        condition: Mark,
        a: Marks,
        b: Marks,
    ) -> Marks {
        let [chosen, one, other] = done.operands;
        if condition != Mark::PLAIN && (one != other || a != b) {
            self.settle(condition);
        }
        if chosen.as_pred() { a } else { b }
    }

    /// One lane of a selection by a mask.
    pub(super) fn blended(&mut self, [mask, one, other]: [u32; 3], [m, a, b]: [Mark; 3]) -> Mark {
        if m != Mark::PLAIN && (one != other || a != b) {
            self.settle(m);
        }
        match mask {
            u32::MAX => a,
            0 => b,
            _ => Mark::PLAIN,
        }
    }

    /// The marks of a result that is made of truth values, as the shadows have them: predicates in
    /// one lane, masks in several.
    pub(super) fn of_truths(
        &mut self,
        done: &Done<'_>,
        logic: Logic,
        lanes: usize,
        marks: [Marks; 3],
    ) -> Marks {
        let all = if lanes == 1 { 1 } else { u32::MAX };
        let result = done.result.map_or([0; 4], |(_, value)| value.0);
        let mut of = PLAIN;
        for (i, of) in of.iter_mut().enumerate().take(lanes) {
            let lanes = [0, 1, 2].map(|k| marks[k][i]);
            if lanes == [Mark::PLAIN; 3] {
                continue;
            }
            let word = |k: usize| Self::truth(done.operands[k].0[i], lanes[k], all);
            let (a, b, c) = (word(0), word(1), word(2));
            let shadow = match logic {
                Logic::And => a & b,
                Logic::Or => a | b,
                Logic::Xor => a ^ b,
                Logic::Not => a ^ 1,
                Logic::Select if a != 0 => b,
                Logic::Select => c,
            };
            *of = Self::decided(result[i], shadow, &lanes);
        }
        of
    }

    /// Operands are used as they are: disputes about them have consequences.
    pub(super) fn used(&mut self, marks: [Marks; 3]) -> Marks {
        marks.iter().flatten().for_each(|&mark| self.settle(mark));
        PLAIN
    }
}
