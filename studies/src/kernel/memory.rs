//! The memory of a program that runs on numbers, and its words.

use crate::real::{Number, Undefined};
use srp_archdesc::ops::V4 as Lanes;
use srp_archdesc::ops::semantics::word::{hhigh, hlow, hpack};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::ops::Range;

/// A word of a value.
#[derive(Clone, Debug)]
pub(super) enum Word<N> {
    /// Its bits.
    Bits(u32),
    /// A number, not rounded.
    Real(N),
    /// Two numbers that stand for the halves of the word, the lower one first.
    Pair(Box<[N; 2]>),
}

impl<N: Number> Word<N> {
    pub(super) fn number(&self) -> N {
        match self {
            Word::Bits(bits) => N::of_float(f32::from_bits(*bits)),
            Word::Real(number) => number.clone(),
            Word::Pair(_) => N::of_float(self.bits().map_or(f32::NAN, f32::from_bits)),
        }
    }

    /// The numbers that its halves are.
    pub(super) fn halves(&self) -> Result<[N; 2], Undefined> {
        if let Word::Pair(pair) = self {
            return Ok((**pair).clone());
        }
        let bits = self.bits()?;
        Ok([hlow(bits), hhigh(bits)].map(|half| N::of_float(f32::from_bits(half))))
    }

    pub(super) fn bits(&self) -> Result<u32, Undefined> {
        match self {
            Word::Bits(bits) => Ok(*bits),
            Word::Real(number) => nearest(number),
            Word::Pair(pair) => Ok(hpack(nearest(&pair[0])?, nearest(&pair[1])?)),
        }
    }
}

/// The bits of the float nearest to a number.
fn nearest<N: Number>(number: &N) -> Result<u32, Undefined> {
    number
        .nearest()
        .map(f32::to_bits)
        .ok_or_else(|| Undefined("the program takes apart a number that is not known".to_owned()))
}

/// The words of a value.
pub(super) type Words<N> = [Word<N>; 4];

/// The words of bits.
pub(super) fn bits<N>(value: Lanes) -> Words<N> {
    value.0.map(Word::Bits)
}

/// Memory whose words may be numbers.
pub(super) struct Memory<N> {
    words: BTreeMap<u32, Word<N>>,
    image: Vec<u8>,
    pub(super) watched: Vec<Watched>,
}

/// Bytes that no access should touch.
pub(super) struct Watched {
    /// Where they begin, and where they end.
    pub(super) bytes: Range<u32>,
    /// The end of the farthest access, from where they begin; 0 where there was none.
    pub(super) farthest: Cell<u32>,
}

impl<N: Number> Memory<N> {
    /// The words of a memory, above those of an image.
    pub(super) fn new(
        words: BTreeMap<u32, Word<N>>,
        image: Vec<u8>,
        watched: Vec<Watched>,
    ) -> Memory<N> {
        Memory {
            words,
            image,
            watched,
        }
    }

    fn look_at(&self, address: u32, bytes: u32) {
        for watched in &self.watched {
            let last = address.wrapping_add(bytes - 1);
            if watched.bytes.contains(&last) {
                let end = last + 1 - watched.bytes.start;
                watched.farthest.set(watched.farthest.get().max(end));
            }
        }
    }

    /// The word at an address that is a multiple of 4.
    pub(super) fn word(&self, address: u32) -> Word<N> {
        if let Some(word) = self.words.get(&address) {
            return word.clone();
        }
        let at = address as usize;
        let bytes = self.image.get(at..at + 4).and_then(|b| b.try_into().ok());
        Word::Bits(bytes.map_or(0, u32::from_le_bytes))
    }

    pub(super) fn load(&self, address: u32, bytes: u32) -> Result<Words<N>, Undefined> {
        self.look_at(address, bytes);
        if bytes >= 4 {
            let mut words = [0, 4, 8, 12].map(|i| match i < bytes {
                true => self.word(address.wrapping_add(i)),
                false => Word::Bits(0),
            });
            if bytes == 4 {
                words[1] = Word::Bits(0);
            }
            return Ok(words);
        }
        let word = self.word(address & !3).bits()?;
        let shifted = word >> (8 * (address & 3));
        let mask = (1 << (8 * bytes)) - 1;
        Ok(bits(Lanes([shifted & mask, 0, 0, 0])))
    }

    pub(super) fn store(
        &mut self,
        address: u32,
        bytes: u32,
        value: &Words<N>,
    ) -> Result<(), Undefined> {
        self.look_at(address, bytes);
        if bytes >= 4 {
            for (i, word) in (0..bytes / 4).zip(value) {
                self.words.insert(address.wrapping_add(4 * i), word.clone());
            }
            return Ok(());
        }
        let at = address & !3;
        let (shift, mask) = (8 * (address & 3), (1u32 << (8 * bytes)) - 1);
        let kept = self.word(at).bits()? & !(mask << shift);
        let new = (value[0].bits()? & mask) << shift;
        self.words.insert(at, Word::Bits(kept | new));
        Ok(())
    }
}
