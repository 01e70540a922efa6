//! Floats that are taken apart as integers, lane by lane.
//!
//! Another exponent or another sign makes of a float the float times a power of two. An integer that
//! is added moves it by so many places, and its shadow by as much. A mask that takes off its last
//! places rounds it, whatever was added before to have them rounded to the nearest.

use super::rule::Bitwise;
use super::{Mark, Marks, Meaning, Origin, PLAIN, Shadows};
use crate::interp::Done;
use srp_archdesc::isa::Opcode;

/// The bits of the mantissa of a binary32.
const MANTISSA: u32 = 0x7f_ffff;

/// True if a mask clears the last places of a mantissa and keeps the rest.
fn rounds(mask: u32) -> bool {
    let off = mask.trailing_zeros();
    (1..23).contains(&off) && mask == u32::MAX << off
}

impl Shadows<'_> {
    /// The marks of an integer operation on bits of floats; `None` where it is on others alone.
    #[inline]
    pub(super) fn taken_apart(
        &mut self,
        done: &Done<'_>,
        how: Bitwise,
        lanes: usize,
        [a, b, _]: [Marks; 3],
    ) -> Option<Marks> {
        let is_float = |mark: &Mark| mark.behind() != 0;
        if !a.iter().chain(&b).any(is_float) {
            return None;
        }
        let result = done.result?.1;
        let source = self.sources.number(done.func, done.inst);
        let [x, y, _] = done.operands;
        let mut of = PLAIN;
        for i in 0..lanes {
            let (float, other, word) = match (is_float(&a[i]), is_float(&b[i])) {
                (true, false) => (a[i], b[i], y.0[i]),
                (false, true) if how != Bitwise::Sub => (b[i], a[i], x.0[i]),
                _ => (Mark::PLAIN, a[i], 0),
            };
            self.settle(other);
            if float != Mark::PLAIN {
                of[i] = self.changed(how, source, float, word, result.0[i]);
            }
        }
        Some(of)
    }

    /// The mark of a float, or of its mantissa, whose bits were changed by a word.
    fn changed(&mut self, how: Bitwise, source: u32, float: Mark, word: u32, result: u32) -> Mark {
        let node = float.behind();
        if how == Bitwise::And && word == MANTISSA {
            return Mark::mantissa(node);
        }
        let Some(entry) = self.tape.get(node).copied() else {
            return Mark::PLAIN;
        };
        let (value, made) = (entry.value, f32::from_bits(result));
        if !value.is_normal() || !made.is_normal() {
            return Mark::PLAIN;
        }
        let whole = matches!(float.meaning(), Meaning::Node(_));
        let near = whole && (made - value).abs() <= value.abs() / 16.0;
        let alone = |parent: u32, partial: f64| [(parent, partial), (0, 0.0), (0, 0.0)];
        let (shadow, parents) = if how == Bitwise::And && rounds(word) && near {
            let origin = self.before_adding(node);
            (self.tape.shadow(origin, value), alone(origin, 1.0))
        } else if how == Bitwise::And && word & MANTISSA != MANTISSA {
            return Mark::PLAIN;
        } else if value.to_bits() & MANTISSA == result & MANTISSA {
            let ratio = f64::from(made) / f64::from(value);
            (entry.shadow * ratio, alone(node, ratio))
        } else if near && matches!(how, Bitwise::Add | Bitwise::Sub) {
            let by = f64::from(made) - f64::from(value);
            (entry.shadow + by, alone(node, 1.0))
        } else {
            return Mark::PLAIN;
        };
        Mark::node(self.tape.push(made, shadow, source, parents))
    }

    /// The node of a float before integers were added to its bits.
    fn before_adding(&self, mut node: u32) -> u32 {
        while let Some(entry) = self.tape.get(node) {
            let source = self.sources.get(entry.source);
            let adds = source.is_some_and(|source| {
                use Opcode::{Add, Sub, Vadd, Vsub};
                matches!(source.what, Origin::Operation(Add | Sub | Vadd | Vsub))
            });
            if !adds || entry.parents[0] == 0 || entry.partials[0] != 1.0 {
                break;
            }
            node = entry.parents[0];
        }
        node
    }
}
