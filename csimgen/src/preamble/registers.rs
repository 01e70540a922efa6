//! Rotating register files.

use std::ops::{Index, IndexMut};

/// A register file whose registers are named relative to the iteration begun last: `file[k]` is
/// register `k + iteration` modulo its size.
#[derive(Clone, Debug)]
pub struct Rotating<T, const N: usize> {
    registers: [T; N],
    base: usize,
}

impl<T: Copy + Default, const N: usize> Rotating<T, N> {
    /// The file as it is before any iteration.
    pub fn reset(&mut self) {
        self.base = 0;
    }

    /// An iteration begins.
    #[inline(always)]
    pub fn rotate(&mut self) {
        self.base += 1;
        if self.base == N {
            self.base = 0;
        }
    }
}

impl<T, const N: usize> Rotating<T, N> {
    /// The registers in their physical order, and which of them is register 0.
    pub fn parts(&self) -> (&[T; N], usize) {
        (&self.registers, self.base)
    }

    /// The same, to be changed.
    pub fn parts_mut(&mut self) -> (&mut [T; N], &mut usize) {
        (&mut self.registers, &mut self.base)
    }
}

impl<T: Copy + Default, const N: usize> Default for Rotating<T, N> {
    fn default() -> Self {
        Rotating {
            registers: [T::default(); N],
            base: 0,
        }
    }
}

impl<T, const N: usize> Index<usize> for Rotating<T, N> {
    type Output = T;
    #[inline(always)]
    fn index(&self, k: usize) -> &T {
        &self.registers[(self.base + k) % N]
    }
}

impl<T, const N: usize> IndexMut<usize> for Rotating<T, N> {
    #[inline(always)]
    fn index_mut(&mut self, k: usize) -> &mut T {
        &mut self.registers[(self.base + k) % N]
    }
}
