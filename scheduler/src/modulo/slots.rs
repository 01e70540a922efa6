//! Slots of the II.

/// Remainders by a fixed divisor, by multiplication (Lemire, Kaser and Kurz, *Faster remainder by direct
/// computation*, 2019).
pub(super) struct Slots {
    ii: i32,
    /// 2^64 / II, rounded up.
    inverse: u64,
    /// A multiple of the II that makes all cycles positive.
    bias: i32,
}

impl Slots {
    /// The largest distance of a cycle from 0.
    const FARTHEST: i32 = 1 << 24;

    /// The slots of an II.
    pub(super) fn of(ii: i32) -> Slots {
        Slots {
            ii,
            inverse: (u64::MAX / ii as u64).wrapping_add(1),
            bias: (Slots::FARTHEST / ii + 1) * ii,
        }
    }

    /// The slot of a cycle.
    #[inline(always)]
    pub(super) fn slot(&self, time: i32) -> usize {
        debug_assert!(time.abs() <= Slots::FARTHEST, "cycle {time}");
        let fraction = (self.inverse).wrapping_mul(u64::from((time + self.bias) as u32));
        ((u128::from(fraction) * self.ii as u128) >> 64) as usize
    }
}
