//! The FIFOs of the unit.

use serde::{Deserialize, Serialize};

/// A FIFO of bounded length. Rays are many in few places: its length is known beforehand, and
/// taking from it or adding to it has to be cheap.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Ring<T> {
    /// A power of two of places.
    places: Box<[T]>,
    /// Of these, the first, counted from the beginning of time.
    first: u32,
    /// The one behind the last.
    end: u32,
}

impl<T: Copy + Default> Ring<T> {
    /// Room for `length` at least.
    pub(super) fn new(length: usize) -> Ring<T> {
        Ring {
            places: vec![T::default(); length.max(1).next_power_of_two()].into(),
            first: 0,
            end: 0,
        }
    }

    #[inline]
    fn place(&self, n: u32) -> usize {
        n as usize & (self.places.len() - 1)
    }

    #[inline]
    pub(super) fn len(&self) -> usize {
        self.end.wrapping_sub(self.first) as usize
    }

    #[inline]
    pub(super) fn is_empty(&self) -> bool {
        self.end == self.first
    }

    #[inline]
    pub(super) fn front(&self) -> Option<T> {
        (!self.is_empty()).then(|| self.places[self.place(self.first)])
    }

    #[inline]
    pub(super) fn pop_front(&mut self) -> Option<T> {
        let value = self.front()?;
        self.first = self.first.wrapping_add(1);
        Some(value)
    }

    #[inline]
    pub(super) fn push_back(&mut self, value: T) {
        debug_assert!(self.len() < self.places.len(), "a FIFO overflows");
        let place = self.place(self.end);
        self.places[place] = value;
        self.end = self.end.wrapping_add(1);
    }

    #[inline]
    pub(super) fn push_front(&mut self, value: T) {
        debug_assert!(self.len() < self.places.len(), "a FIFO overflows");
        self.first = self.first.wrapping_sub(1);
        let place = self.place(self.first);
        self.places[place] = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::VecDeque;

    #[test]
    fn behaves_as_a_queue() {
        let (mut ring, mut queue) = (Ring::new(6), VecDeque::new());
        let mut state = 1u32;
        for i in 0..2000 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            match state >> 30 {
                _ if queue.len() == 6 => assert_eq!(ring.pop_front(), queue.pop_front()),
                0 => {
                    ring.push_front(i);
                    queue.push_front(i);
                }
                1 => {
                    ring.push_back(i);
                    queue.push_back(i);
                }
                _ => assert_eq!(ring.pop_front(), queue.pop_front()),
            }
            assert_eq!(ring.len(), queue.len());
            assert_eq!(ring.is_empty(), queue.is_empty());
            assert_eq!(ring.front(), queue.front().copied());
        }
    }
}
