//! The checker against damage. A schedule that was right is broken in one place, in every way that
//! there is a rule against: the checker has to say so, or the damage has to be harmless, which is
//! found out by running. [`kernels`] breaks modulo schedules, [`bundles`] and [`control`] VLIW code.

mod bundles;
mod control;
mod kernels;
mod program;
mod tally;

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

/// Random choices.
struct Dice(Pcg32);

impl Dice {
    fn new(seed: u64, stream: u64) -> Dice {
        Dice(Pcg32::new(seed, stream))
    }

    fn below(&mut self, n: usize) -> usize {
        self.0.next_u32() as usize % n.max(1)
    }

    fn chance(&mut self) -> bool {
        self.below(2) == 0
    }

    /// One of these; `None` where there is none.
    fn pick<T: Clone>(&mut self, list: &[T]) -> Option<T> {
        list.get(self.below(list.len())).cloned()
    }

    /// One more, or one less: `None` where that would be less than nothing.
    fn step(&mut self, value: u32) -> Option<u32> {
        if self.chance() {
            Some(value + 1)
        } else {
            value.checked_sub(1)
        }
    }
}
