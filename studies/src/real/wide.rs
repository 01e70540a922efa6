//! [`Wide`]: numbers of some 200 bits.

use crate::expansion::Expansion;
use std::cmp::Ordering;

/// Binary64 numbers that a number is the sum of, at most.
const PARTS: usize = 5;

/// A real number to some 200 bits, an infinity or a NaN.
#[derive(Clone, Debug)]
pub struct Wide(Expansion);

impl Wide {
    /// A number of binary64.
    pub fn of(x: f64) -> Wide {
        Wide(Expansion::of_double(x))
    }

    /// The binary64 number nearest to it, or nearly so.
    pub fn value(&self) -> f64 {
        self.0.value()
    }

    /// The float nearest to it.
    pub fn to_float(&self) -> f32 {
        let value = self.value();
        let float = value as f32;
        let parts = self.0.parts();
        // The sum in binary64 may be the middle of two floats where the number is not.
        let middle = |other: f32| (f64::from(float) + f64::from(other)) / 2.0 == value;
        for other in [float.next_up(), float.next_down()] {
            if parts.len() > 1 && middle(other) {
                let rest = self.minus(&Wide::of(value)).value();
                let up = other > float;
                if rest > 0.0 && up || rest < 0.0 && !up {
                    return other;
                }
            }
        }
        float
    }

    /// True when it is a number.
    pub fn is_finite(&self) -> bool {
        self.value().is_finite()
    }

    pub(super) fn sign(&self) -> Ordering {
        self.0.sign()
    }

    pub(super) fn is_negative(&self) -> bool {
        self.value().is_sign_negative()
    }

    /// The result of an operation that has one, else that of binary64.
    fn or(exact: Expansion, plain: f64) -> Wide {
        match plain.is_finite() && exact.value().is_finite() {
            true => Wide(exact.rounded(PARTS)),
            false => Wide::of(plain),
        }
    }

    pub(super) fn both_finite(&self, other: &Wide) -> bool {
        self.is_finite() && other.is_finite()
    }

    pub(crate) fn plus(&self, other: &Wide) -> Wide {
        let plain = self.value() + other.value();
        match self.both_finite(other) {
            true => Wide::or(self.0.plus(&other.0), plain),
            false => Wide::of(plain),
        }
    }

    pub(crate) fn minus(&self, other: &Wide) -> Wide {
        let plain = self.value() - other.value();
        match self.both_finite(other) {
            true => Wide::or(self.0.minus(&other.0), plain),
            false => Wide::of(plain),
        }
    }

    pub(crate) fn times(&self, other: &Wide) -> Wide {
        let plain = self.value() * other.value();
        match self.both_finite(other) {
            // A product whose parts underflow has lost nothing that any float would tell.
            true => Wide::or(self.0.times(&other.0), plain),
            false => Wide::of(plain),
        }
    }

    /// The quotient, digit by digit in base 2^53.
    pub(crate) fn over(&self, other: &Wide) -> Wide {
        let plain = self.value() / other.value();
        if !self.both_finite(other) || !plain.is_finite() || plain == 0.0 {
            return Wide::of(plain);
        }
        let mut quotient = Expansion::of_double(0.0);
        let mut rest = self.clone();
        for _ in 0..=PARTS {
            let digit = rest.value() / other.value();
            if digit == 0.0 || !digit.is_finite() {
                break;
            }
            quotient = quotient.plus_number(digit);
            rest = rest.minus(&other.times(&Wide::of(digit)));
        }
        Wide::or(quotient, plain)
    }

    pub(crate) fn negated(&self) -> Wide {
        Wide(self.0.scaled(-1.0))
    }

    /// Times a power of two.
    pub(super) fn scaled(&self, factor: f64) -> Wide {
        Wide(self.0.scaled(factor))
    }

    pub(super) fn absolute(&self) -> Wide {
        match self.is_negative() {
            true => self.negated(),
            false => self.clone(),
        }
    }

    /// √x: Heron's steps from binary64's.
    pub(super) fn root(&self) -> Wide {
        let plain = self.value().sqrt();
        if !plain.is_finite() || plain == 0.0 {
            return Wide::of(plain);
        }
        let step = |root: Wide| root.plus(&self.over(&root)).scaled(0.5);
        (0..3).fold(Wide::of(plain), |root, _| step(root))
    }

    /// The greatest whole number that is not above it.
    pub(super) fn floor(&self) -> Wide {
        if !self.is_finite() {
            return self.clone();
        }
        // From the largest part down; below the first that is not whole nothing matters but a sign.
        let mut sum = Wide::of(0.0);
        for &part in self.0.parts().iter().rev() {
            let whole = part.floor();
            sum = sum.plus(&Wide::of(whole));
            if whole != part {
                return sum;
            }
            if part == 0.0 {
                continue;
            }
        }
        sum
    }

    pub(super) fn truncated(&self) -> Wide {
        match self.is_negative() {
            true => self.negated().floor().negated(),
            false => self.floor(),
        }
    }
}
