//! Marks of moves, selections and lanes, and of what is done with truth values.

use super::{Mark, Marks, Meaning, PLAIN, Shadows};
use crate::interp::Done;
use srp_archdesc::isa::Opcode;
use srp_archdesc::ops::Value;

impl Shadows<'_> {
    /// The marks of the result of an operation that computes no float; `None` where it does.
    pub(super) fn handed_on(&mut self, done: &Done<'_>, marks: [Marks; 3]) -> Option<Marks> {
        let [a, b, c] = marks;
        let imm = done.imm as u32;
        let lane = (imm & 3) as usize;
        if let Some(marks) = self.taken_apart(done, marks) {
            return Some(marks);
        }
        Some(match done.op {
            Opcode::Mov | Opcode::Pmov | Opcode::Vmov | Opcode::Ptoi => a,
            Opcode::Sel | Opcode::Vsel => self.selected(done, a[0], b, c),
            Opcode::Vblend => std::array::from_fn(|i| {
                let lane = |k: usize| done.operands[k].0[i];
                self.blended([lane(0), lane(1), lane(2)], [a[i], b[i], c[i]])
            }),
            Opcode::Vsplat => [a[0]; 4],
            Opcode::Vext => [a[lane], Mark::PLAIN, Mark::PLAIN, Mark::PLAIN],
            Opcode::Vins => {
                let mut marks = a;
                marks[lane] = b[0];
                marks
            }
            Opcode::Swz => std::array::from_fn(|i| a[(imm >> (2 * i) & 3) as usize]),
            Opcode::Shl => self.of_word(done, a[0], b[0], |shadows, operands| {
                shadows.shifted(a[0], operands[1].as_word() & 31)
            }),
            Opcode::Or => self.of_word(done, a[0], b[0], |shadows, _| shadows.united(a[0], b[0])),
            Opcode::And => self.of_word(done, a[0], b[0], |shadows, operands| {
                match b[0] == Mark::PLAIN {
                    true => shadows.masked(a[0], operands[1].as_word()),
                    false => shadows.masked(b[0], operands[0].as_word()),
                }
            }),
            _ => return None,
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

    fn selected(&mut self, done: &Done<'_>, condition: Mark, a: Marks, b: Marks) -> Marks {
        let [chosen, one, other] = done.operands;
        if condition != Mark::PLAIN && (one != other || a != b) {
            self.settle(condition);
        }
        if chosen.as_pred() { a } else { b }
    }

    /// One lane of a selection by a mask.
    fn blended(&mut self, [mask, one, other]: [u32; 3], [m, a, b]: [Mark; 3]) -> Mark {
        if m != Mark::PLAIN && (one != other || a != b) {
            self.settle(m);
        }
        match mask {
            u32::MAX => a,
            0 => b,
            _ => Mark::PLAIN,
        }
    }

    /// The marks of a result that is made of truth values, as the shadows have them; `None` where
    /// it is not.
    pub(super) fn of_truths(&mut self, done: &Done<'_>, marks: [Marks; 3]) -> Option<Marks> {
        let (lanes, all) = match done.op {
            Opcode::Pand | Opcode::Por | Opcode::Pxor | Opcode::Pnot | Opcode::Psel => (1, 1),
            Opcode::Vand | Opcode::Vor | Opcode::Vxor => (4, u32::MAX),
            _ => return None,
        };
        let result = done.result?.1;
        let mut of = PLAIN;
        for (i, of) in of.iter_mut().enumerate().take(lanes) {
            let lanes = [0, 1, 2].map(|k| marks[k][i]);
            if lanes == [Mark::PLAIN; 3] {
                continue;
            }
            let word = |k: usize| Self::truth(done.operands[k].0[i], lanes[k], all);
            let (a, b, c) = (word(0), word(1), word(2));
            let shadow = match done.op {
                Opcode::Pand | Opcode::Vand => a & b,
                Opcode::Por | Opcode::Vor => a | b,
                Opcode::Pxor | Opcode::Vxor => a ^ b,
                Opcode::Pnot => a ^ 1,
                _ if a != 0 => b,
                _ => c,
            };
            *of = Self::decided(result.0[i], shadow, &lanes);
        }
        Some(of)
    }
}
