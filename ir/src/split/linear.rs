//! Linear forms over values, modulo 2³².

use crate::program::{Slot, Symbol, Value};
use std::collections::BTreeMap;

/// Longest sum that is followed; longer ones count as unknown.
const MAX_TERMS: usize = 24;

/// Something a linear form counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Atom {
    /// The address of a global or a function.
    Symbol(Symbol),
    /// The address of a stack slot.
    Slot(Slot),
    /// A value whose making is not looked into.
    Value(Value),
}

/// `Σ coefficient · atom + constant`, modulo 2³². No coefficient is zero.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Linear {
    /// The atoms with their coefficients.
    pub(super) terms: BTreeMap<Atom, u32>,
    /// The constant.
    pub(super) constant: u32,
}

impl Linear {
    pub(super) fn constant(constant: u32) -> Linear {
        Linear {
            terms: BTreeMap::new(),
            constant,
        }
    }

    pub(super) fn atom(atom: Atom) -> Linear {
        Linear {
            terms: BTreeMap::from([(atom, 1)]),
            constant: 0,
        }
    }

    pub(super) fn value(value: Value) -> Linear {
        Linear::atom(Atom::Value(value))
    }

    /// The number it is, if no atom is in it.
    pub(super) fn as_constant(&self) -> Option<u32> {
        self.terms.is_empty().then_some(self.constant)
    }

    /// `self + factor · other`.
    pub(super) fn plus(&self, factor: u32, other: &Linear) -> Linear {
        let mut sum = self.clone();
        sum.constant = sum
            .constant
            .wrapping_add(factor.wrapping_mul(other.constant));
        for (&atom, &c) in &other.terms {
            let slot = sum.terms.entry(atom).or_insert(0);
            *slot = slot.wrapping_add(factor.wrapping_mul(c));
            if *slot == 0 {
                sum.terms.remove(&atom);
            }
        }
        sum
    }

    pub(super) fn minus(&self, other: &Linear) -> Linear {
        self.plus(u32::MAX, other)
    }

    pub(super) fn plus_constant(&self, c: u32) -> Linear {
        self.plus(1, &Linear::constant(c))
    }

    pub(super) fn scaled(&self, factor: u32) -> Linear {
        Linear::default().plus(factor, self)
    }

    /// True if it is short enough to be followed.
    pub(super) fn is_short(&self) -> bool {
        self.terms.len() <= MAX_TERMS
    }

    /// The number of low bits that are zero whatever the atoms are.
    pub(super) fn zero_bits(&self) -> u32 {
        self.zero_bits_of_terms()
            .min(self.constant.trailing_zeros())
    }

    /// The number of low bits that are zero in everything but the constant.
    pub(super) fn zero_bits_of_terms(&self) -> u32 {
        let bits = self.terms.values().map(|c| c.trailing_zeros());
        bits.min().unwrap_or(32)
    }

    /// `self & mask` where the mask only clears low bits that come from the constant.
    pub(super) fn masked(&self, mask: u32) -> Option<Linear> {
        let low = mask.trailing_zeros();
        let clears_only_low = mask == u32::MAX.checked_shl(low).unwrap_or(0);
        (clears_only_low && self.zero_bits_of_terms() >= low).then(|| Linear {
            terms: self.terms.clone(),
            constant: self.constant & mask,
        })
    }

    /// `self | bits` where the bits are zero in everything but the constant.
    pub(super) fn with_bits(&self, bits: u32) -> Option<Linear> {
        let width = 32 - bits.leading_zeros();
        (self.zero_bits_of_terms() >= width).then(|| Linear {
            terms: self.terms.clone(),
            constant: self.constant | bits,
        })
    }
}

/// A value of iteration `i`: `base + i · stride`, both unchanging in the loop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Affine {
    /// The value in iteration 0.
    pub(super) base: Linear,
    /// The increment of each iteration.
    pub(super) stride: Linear,
}

impl Affine {
    pub(super) fn invariant(base: Linear) -> Affine {
        Affine {
            base,
            stride: Linear::default(),
        }
    }
}

/// The smallest `x ≥ 0` with `low ≤ a·x mod m ≤ high`, where `low ≤ high < m`: Euclid's algorithm
/// on the window.
fn first_hit(a: u64, m: u64, low: u64, high: u64) -> Option<u64> {
    if low == 0 {
        return Some(0);
    }
    let a = a % m;
    if a == 0 {
        return None;
    }
    if 2 * a > m {
        // Counting down by the rest is the same, and shortens fast.
        return first_hit(m - a, m, m - high, m - low);
    }
    let x = low.div_ceil(a);
    if a * x <= high {
        return Some(x);
    }
    // No multiple of `a` lies in the window itself: find the first turn `y` round `m` after which
    // one does.
    let y = first_hit((a - m % a) % a, a, low % a, high % a)?;
    Some((m * y + low).div_ceil(a))
}

/// The smallest `x ≥ from` for which `a·x` lies, modulo 2³², in the window of `width` numbers that
/// starts at `low`.
pub(super) fn first_in_window(a: u32, low: u32, width: u32, from: u32) -> Option<u64> {
    const M: u64 = 1 << 32;
    debug_assert!(width > 0);
    let low = low.wrapping_sub(a.wrapping_mul(from));
    let high = u64::from(low) + u64::from(width) - 1;
    let hit = if high >= M {
        Some(0)
    } else {
        first_hit(u64::from(a), M, u64::from(low), high)
    };
    hit.map(|x| x + u64::from(from))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_pcg::rand_core::{Rng, SeedableRng};

    #[test]
    fn first_hit_is_the_first() {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(7);
        for _ in 0..20_000 {
            let m = u64::from(rng.next_u32() % 60 + 1);
            let a = u64::from(rng.next_u32()) % (m + 3);
            let low = u64::from(rng.next_u32()) % m;
            let high = low + u64::from(rng.next_u32()) % (m - low);
            let slow = (0..m).find(|x| (low..=high).contains(&(a * x % m)));
            assert_eq!(
                first_hit(a, m, low, high),
                slow,
                "{a} mod {m} in {low}..={high}"
            );
        }
    }

    #[test]
    fn windows_wrap_and_start_late() {
        assert_eq!(first_in_window(4, 40, 4, 0), Some(10));
        assert_eq!(first_in_window(4, 41, 3, 0), None);
        assert_eq!(first_in_window(4, (-3i32) as u32, 7, 0), Some(0));
        assert_eq!(first_in_window(4, (-3i32) as u32, 7, 1), Some(1 << 30));
        assert_eq!(
            first_in_window((-4i32) as u32, (-40i32) as u32, 1, 3),
            Some(10)
        );
    }
}
