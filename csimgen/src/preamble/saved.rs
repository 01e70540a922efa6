//! The state of a core as words, for saving and restoring it.

use super::ops::V4;
use super::registers::Rotating;

/// Words that are read one after another.
#[derive(Clone, Debug)]
pub struct Words<'a>(std::slice::Iter<'a, u32>);

impl<'a> Words<'a> {
    /// All of these words.
    pub fn of(words: &'a [u32]) -> Words<'a> {
        Words(words.iter())
    }

    /// The next word.
    pub fn next_word(&mut self) -> Option<u32> {
        self.0.next().copied()
    }

    /// The next two words as a number, the lower half first.
    pub fn next_long(&mut self) -> Option<u64> {
        let low = self.next_word()?;
        Some(u64::from(low) | u64::from(self.next_word()?) << 32)
    }

    /// True if all words have been read.
    pub fn is_empty(&self) -> bool {
        self.0.len() == 0
    }
}

/// Appends a number as two words, the lower half first.
pub fn put_long(out: &mut Vec<u32>, value: u64) {
    out.extend([value as u32, (value >> 32) as u32]);
}

/// State that is saved and restored. [`restore`](Self::restore) gives `None` where words are missing
/// or mean nothing.
pub trait Saved {
    /// Appends the state.
    fn save(&self, out: &mut Vec<u32>);
    /// Takes the state from as many words as [`save`](Self::save) has appended.
    fn restore(&mut self, words: &mut Words<'_>) -> Option<()>;
}

impl Saved for u32 {
    fn save(&self, out: &mut Vec<u32>) {
        out.push(*self);
    }

    fn restore(&mut self, words: &mut Words<'_>) -> Option<()> {
        *self = words.next_word()?;
        Some(())
    }
}

impl Saved for bool {
    fn save(&self, out: &mut Vec<u32>) {
        out.push(u32::from(*self));
    }

    fn restore(&mut self, words: &mut Words<'_>) -> Option<()> {
        *self = words.next_word()? != 0;
        Some(())
    }
}

impl Saved for V4 {
    fn save(&self, out: &mut Vec<u32>) {
        out.extend(self.0);
    }

    fn restore(&mut self, words: &mut Words<'_>) -> Option<()> {
        self.0.iter_mut().try_for_each(|lane| lane.restore(words))
    }
}

impl<T: Saved, const N: usize> Saved for [T; N] {
    fn save(&self, out: &mut Vec<u32>) {
        self.iter().for_each(|cell| cell.save(out));
    }

    fn restore(&mut self, words: &mut Words<'_>) -> Option<()> {
        self.iter_mut().try_for_each(|cell| cell.restore(words))
    }
}

impl<T: Saved, const N: usize> Saved for Rotating<T, N> {
    /// The iterations that it has followed, modulo its size, then its registers in their physical
    /// order.
    fn save(&self, out: &mut Vec<u32>) {
        let (registers, base) = self.parts();
        out.push(base as u32);
        registers.save(out);
    }

    fn restore(&mut self, words: &mut Words<'_>) -> Option<()> {
        let base = words.next_word()? as usize;
        let (registers, at) = self.parts_mut();
        *at = (base < N).then_some(base)?;
        registers.restore(words)
    }
}
