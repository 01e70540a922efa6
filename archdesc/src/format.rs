//! Formats of floats: what the adders and multipliers of a machine take and give.
//!
//! A register holds binary32 whatever the units compute in. A unit of a narrower format rounds its operands to it, computes,
//! and rounds the result to it, both to nearest and ties to even, with that format's range. Rounding a sum, a difference
//! or a product first to 24 bits and then to at most 11 gives what rounding once does (Figueroa, *When is double
//! rounding innocuous?*, 1995: 24 ≥ 2 · 11 + 2), but for products below 2⁻¹²⁶ in formats of 8 exponent bits and 9 to 11
//! digits: binary32 has fewer than 24 bits there.

use crate::isa::{Class, Opcode};
use serde::{Deserialize, Serialize};

/// A binary format with a sign, as IEEE 754 has them: subnormals, infinities, NaNs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Format {
    /// Bits of the exponent, 4 to 8.
    pub exponent: u32,
    /// Bits of the significand with the hidden one: 2 to 11, or 24.
    pub significand: u32,
}

impl Format {
    /// binary32.
    pub const SINGLE: Format = Format::new(8, 24);
    /// binary16.
    pub const HALF: Format = Format::new(5, 11);
    /// The upper half of binary32.
    pub const BFLOAT16: Format = Format::new(8, 8);
    /// The range of binary32 with the digits of binary16, in 19 bits.
    pub const TF32: Format = Format::new(8, 11);

    /// Formats with a name of their own.
    pub const NAMED: [(&'static str, Format); 4] = [
        ("single", Format::SINGLE),
        ("half", Format::HALF),
        ("bfloat16", Format::BFLOAT16),
        ("tf32", Format::TF32),
    ];

    /// A format of so many bits.
    pub const fn new(exponent: u32, significand: u32) -> Format {
        Format {
            exponent,
            significand,
        }
    }

    /// The format of a name, or of `eXmY` with X exponent bits, 4 to 8, and Y stored bits of the significand, 1 to 10.
    pub fn parse(text: &str) -> Option<Format> {
        if let Some((_, format)) = Format::NAMED.iter().find(|(name, _)| *name == text) {
            return Some(*format);
        }
        let (exponent, stored) = text.strip_prefix('e')?.split_once('m')?;
        let (exponent, stored): (u32, u32) = (exponent.parse().ok()?, stored.parse().ok()?);
        let known = (4..=8).contains(&exponent) && (1..=10).contains(&stored);
        known.then(|| Format::new(exponent, stored + 1))
    }

    /// Its name in machine files.
    pub fn name(self) -> String {
        match Format::NAMED.iter().find(|(_, format)| *format == self) {
            Some((name, _)) => (*name).to_owned(),
            None => format!("e{}m{}", self.exponent, self.significand - 1),
        }
    }

    /// Half a unit in the last place of 1: what rounding is off by at most, relatively.
    pub fn rounding(self) -> f64 {
        2f64.powi(-(self.significand as i32))
    }

    /// The least normal number.
    pub fn least_normal(self) -> f64 {
        2f64.powi(2 - (1 << (self.exponent - 1)))
    }

    /// The largest number.
    pub fn largest(self) -> f64 {
        (2.0 - 2.0 * self.rounding()) * 2f64.powi((1 << (self.exponent - 1)) - 1)
    }
}

/// The operations that have a format of their own: its name in machine files, and what it is of.
pub const KINDS: [(&str, &str); 3] = [
    ("add", "sums"),
    ("multiply", "products"),
    ("fused", "fused and dot products"),
];

/// The formats of a machine's units.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Formats {
    /// Of sums and differences.
    pub add: Format,
    /// Of products.
    pub multiply: Format,
    /// Of products that are added without rounding between, and of dot products.
    pub fused: Format,
}

impl Formats {
    /// binary32 everywhere.
    pub const SINGLE: Formats = Formats {
        add: Format::SINGLE,
        multiply: Format::SINGLE,
        fused: Format::SINGLE,
    };

    /// The format that an operation computes in.
    pub fn of(&self, op: Opcode) -> Format {
        use Opcode::{Fadd, Fsub, Vfadd, Vfsub};
        match op.class() {
            Class::Fadd | Class::Vfadd if matches!(op, Fadd | Fsub | Vfadd | Vfsub) => self.add,
            Class::Fmul | Class::Vfmul => self.multiply,
            Class::Fma | Class::Vfma | Class::Vdot => self.fused,
            _ => Format::SINGLE,
        }
    }

    /// Each with its place among [`KINDS`].
    pub fn all(&self) -> [Format; KINDS.len()] {
        [self.add, self.multiply, self.fused]
    }

    /// The one of a kind, by its place among [`KINDS`].
    pub fn of_kind(&mut self, kind: usize) -> &mut Format {
        match kind {
            0 => &mut self.add,
            1 => &mut self.multiply,
            _ => &mut self.fused,
        }
    }
}
