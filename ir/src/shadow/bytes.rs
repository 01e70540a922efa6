//! Integers that floats were converted to: where they are put together as bytes of a word, each
//! keeps its float.

use super::{Decision, Flip, Mark, Meaning, Shadows};

/// A float that was converted to an integer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Converted {
    /// Its node.
    pub node: u32,
    /// Its value before it was converted.
    pub value: f32,
    /// The conversion, by its number in [`Sources`](super::Sources).
    pub source: u32,
    /// True if the shadow is converted to another integer.
    pub differs: bool,
}

/// The floats of the bytes of a word, the lowest first. A word that is not put together has one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bytes(pub(super) [Option<Converted>; 4]);

impl Shadows<'_> {
    /// The mark of an integer that a float was converted to, toward zero.
    pub(super) fn converted(&mut self, source: u32, value: f32, mark: Mark) -> Mark {
        let node = mark.node_of();
        if node == 0 {
            return Mark::PLAIN;
        }
        let shadow = self.shadow((value, mark));
        let converted = Converted {
            node,
            value,
            source,
            differs: shadow.trunc() != f64::from(value.trunc()),
        };
        self.add_bytes([Some(converted), None, None, None])
    }

    fn add_bytes(&mut self, bytes: [Option<Converted>; 4]) -> Mark {
        if bytes.iter().all(Option::is_none) {
            return Mark::PLAIN;
        }
        self.bytes.push(Bytes(bytes));
        Mark::bytes(self.bytes.len() - 1)
    }

    fn bytes_of(&self, mark: Mark) -> [Option<Converted>; 4] {
        match mark.meaning() {
            Meaning::Bytes(index) => self.bytes[index as usize].0,
            _ => [None; 4],
        }
    }

    /// Bytes shifted up by so many bits; whether they were whole bytes.
    pub(super) fn shifted(&mut self, mark: Mark, bits: u32) -> Mark {
        if !bits.is_multiple_of(8) {
            self.settle(mark);
            return Mark::PLAIN;
        }
        let by = (bits as usize % 32) / 8;
        let bytes = self.bytes_of(mark);
        self.add_bytes(std::array::from_fn(|i| match i >= by {
            true => bytes[i - by],
            false => None,
        }))
    }

    /// Bytes of two words in one.
    pub(super) fn united(&mut self, a: Mark, b: Mark) -> Mark {
        let (a, b) = (self.bytes_of(a), self.bytes_of(b));
        self.add_bytes(std::array::from_fn(|i| a[i].or(b[i])))
    }

    /// The bytes that a mask leaves whole.
    pub(super) fn masked(&mut self, mark: Mark, mask: u32) -> Mark {
        let bytes = self.bytes_of(mark);
        let whole = |i: usize| mask.to_le_bytes()[i] == 0xff;
        self.add_bytes(std::array::from_fn(|i| bytes[i].filter(|_| whole(i))))
    }

    /// The integers are used as integers: another one makes a difference.
    pub(super) fn settle_bytes(&mut self, index: u32) {
        let bytes = &mut self.bytes[index as usize].0;
        for byte in bytes.iter_mut().flatten() {
            if !std::mem::replace(&mut byte.differs, false) {
                continue;
            }
            self.flips.push(Flip {
                decision: Decision::Integer,
                source: byte.source,
                tag: self.tape.tag([byte.node]),
                values: [byte.value, 0.0],
                shadows: [self.tape.shadow(byte.node, byte.value), 0.0],
                nodes: [byte.node, 0],
            });
        }
    }
}
