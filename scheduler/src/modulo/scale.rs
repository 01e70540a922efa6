//! Weights of costs: powers of two, in integers.

/// The weight of the least cost, as a power of two; what weighs less than 1 weighs nothing.
pub(super) const LIGHTEST: i32 = 20;

/// Costs to powers of two.
#[derive(Clone, Copy)]
pub(super) struct Scale {
    /// Parts of a power of two, of which there are 2^24, to a unit of cost.
    parts: u64,
}

impl Scale {
    /// A cost of `half` 16ths is a power of two.
    pub(super) fn of(half: i32) -> Scale {
        Scale {
            parts: (16 << 24) / half as u64,
        }
    }

    /// 2^(20 − cost · 16 / half), with straight lines between powers of two.
    pub(super) fn weight(self, cost: i32) -> u32 {
        let powers = (cost as u64 * self.parts) >> 16;
        let (whole, part) = (powers >> 8, powers as u32 & 0xff);
        match whole {
            0..=20 => (((1u32 << LIGHTEST) >> whole) * (512 - part)) >> 9,
            _ => 0,
        }
    }

    /// True when a change of the cost is taken: a rise with a probability that halves with each `half`
    /// 16ths.
    pub(super) fn accepts(self, change: i32, random: u32) -> bool {
        change <= 0 || random >> 12 < self.weight(change)
    }
}
