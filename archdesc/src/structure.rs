//! [`Structure`]: how the unit of a special function is built. Its results follow from it to the bit
//! ([`approximation`]), and so do its
//! cycles, area and energy ([`cost`](crate::cost)).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

use crate::isa::Opcode;
use crate::ops::semantics::approximation::{
    self, CORDIC, Curve, OFFSETS, POLYNOMIAL, RECURRENCE, TABLE,
};

/// How a first approximation, or an exact function, is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
pub enum Structure {
    /// A table of results, addressed by the leading bits of the operand.
    Table,
    /// A table of values and so many of offsets, 1 to 4, which are added; one is a bipartite table.
    Offsets {
        /// Tables of offsets.
        tables: u32,
    },
    /// A polynomial for each segment of the operand's range, coefficients from a table.
    Polynomial {
        /// Its degree, 1 to 3.
        degree: u32,
        /// The binary logarithm of the segments of an octave.
        segments: u32,
    },
    /// Digit recurrence with a remainder, as SRT division has it: correctly rounded.
    Recurrence {
        /// The radix, a power of two from 2 to 16: digits that one cycle gives.
        radix: u32,
        /// True if every digit has a row of its own, so that an operation starts every cycle.
        unrolled: bool,
    },
    /// Rotations by shifts and additions, one a cycle.
    Cordic,
}

/// Most segments of a polynomial's octave, as a power of two.
pub const MAX_SEGMENTS: u32 = 16;

impl Structure {
    /// Its name in machine files.
    pub const fn name(self) -> &'static str {
        match self {
            Structure::Table => "table",
            Structure::Offsets { tables: 1 } => "bipartite",
            Structure::Offsets { .. } => "multipartite",
            Structure::Polynomial { .. } => "polynomial",
            Structure::Recurrence { .. } => "srt",
            Structure::Cordic => "cordic",
        }
    }

    /// True if it has tables, and so gives a first approximation that Newton–Raphson steps can improve.
    pub const fn is_tabulated(self) -> bool {
        matches!(
            self,
            Structure::Table | Structure::Offsets { .. } | Structure::Polynomial { .. }
        )
    }

    /// The unit word of a unit of this structure and precision.
    pub const fn unit_word(self, bits: u32) -> u32 {
        let (kind, first, second) = match self {
            Structure::Table => (TABLE, 0, 0),
            Structure::Offsets { tables } => (OFFSETS, tables, 0),
            Structure::Polynomial { degree, segments } => (POLYNOMIAL, degree, segments),
            Structure::Recurrence { .. } => (RECURRENCE, 0, 0),
            Structure::Cordic => (CORDIC, 0, 0),
        };
        bits | kind << 8 | first << 12 | second << 16
    }
}

/// As in `bipartite`, `polynomial of degree 2 in 64 segments`, `srt of radix 4`.
impl fmt::Display for Structure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())?;
        match *self {
            Structure::Offsets { tables } if tables > 1 => write!(f, " with {tables} offsets"),
            Structure::Polynomial { degree, segments } => {
                write!(f, " of degree {degree} in {} segments", 1u32 << segments)
            }
            Structure::Recurrence { radix, unrolled } => {
                let unrolled = if unrolled { ", unrolled" } else { "" };
                write!(f, " of radix {radix}{unrolled}")
            }
            _ => Ok(()),
        }
    }
}

/// A function that a `<special>` describes; `Sincos` is two.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Special {
    /// 1/x
    Rcp,
    /// 1/√x
    Rsqrt,
    /// √x
    Sqrt,
    /// a/x
    Div,
    /// 2^x
    Exp2,
    /// log2 x
    Log2,
    /// sin x and cos x
    Sincos,
    /// 1/x on the fast unit
    #[serde(rename = "rcp_fast")]
    RcpFast,
    /// 1/√x on the fast unit
    #[serde(rename = "rsqrt_fast")]
    RsqrtFast,
    /// √x on the fast unit
    #[serde(rename = "sqrt_fast")]
    SqrtFast,
    /// a/x on the fast unit
    #[serde(rename = "div_fast")]
    DivFast,
}

impl Special {
    /// All of them.
    pub const ALL: [Special; 11] = [
        Special::Rcp,
        Special::Rsqrt,
        Special::Sqrt,
        Special::Div,
        Special::Exp2,
        Special::Log2,
        Special::Sincos,
        Special::RcpFast,
        Special::RsqrtFast,
        Special::SqrtFast,
        Special::DivFast,
    ];

    /// Its name in machine files.
    pub const fn name(self) -> &'static str {
        match self {
            Special::Rcp => "rcp",
            Special::Rsqrt => "rsqrt",
            Special::Sqrt => "sqrt",
            Special::Div => "div",
            Special::Exp2 => "exp2",
            Special::Log2 => "log2",
            Special::Sincos => "sincos",
            Special::RcpFast => "rcp_fast",
            Special::RsqrtFast => "rsqrt_fast",
            Special::SqrtFast => "sqrt_fast",
            Special::DivFast => "div_fast",
        }
    }

    /// The operations that compute it.
    pub const fn opcodes(self) -> &'static [Opcode] {
        match self {
            Special::Rcp => &[Opcode::Rcp],
            Special::Rsqrt => &[Opcode::Rsqrt],
            Special::Sqrt => &[Opcode::Sqrt],
            Special::Div => &[Opcode::Fdiv],
            Special::Exp2 => &[Opcode::Exp2],
            Special::Log2 => &[Opcode::Log2],
            Special::Sincos => &[Opcode::Sin, Opcode::Cos],
            Special::RcpFast => &[Opcode::RcpFast],
            Special::RsqrtFast => &[Opcode::RsqrtFast],
            Special::SqrtFast => &[Opcode::SqrtFast],
            Special::DivFast => &[Opcode::FdivFast],
        }
    }

    /// The function on the unit that every machine has; itself where this is that one.
    pub const fn ordinary(self) -> Special {
        match self {
            Special::RcpFast => Special::Rcp,
            Special::RsqrtFast => Special::Rsqrt,
            Special::SqrtFast => Special::Sqrt,
            Special::DivFast => Special::Div,
            other => other,
        }
    }

    /// The same function on the fast unit, which a machine may have beside the ordinary one.
    pub const fn fast(self) -> Option<Special> {
        match self {
            Special::Rcp => Some(Special::RcpFast),
            Special::Rsqrt => Some(Special::RsqrtFast),
            Special::Sqrt => Some(Special::SqrtFast),
            Special::Div => Some(Special::DivFast),
            _ => None,
        }
    }

    /// True if its unit is a fast one, beside the ordinary one of the function.
    pub const fn is_fast(self) -> bool {
        matches!(
            self,
            Special::RcpFast | Special::RsqrtFast | Special::SqrtFast | Special::DivFast
        )
    }

    /// The function that an operation computes.
    pub fn of(op: Opcode) -> Option<Special> {
        Special::ALL.into_iter().find(|f| f.opcodes().contains(&op))
    }

    /// The curves that tables of it cover, one octave or quarter turn each.
    pub const fn curves(self) -> &'static [Curve] {
        match self.ordinary() {
            Special::Rcp | Special::Div => &[Curve::Reciprocal],
            Special::Rsqrt | Special::Sqrt => &[Curve::InverseRoot, Curve::InverseRootOfTwice],
            Special::Exp2 => &[Curve::Power],
            Special::Log2 => &[Curve::Logarithm],
            _ => &[Curve::QuarterSine],
        }
    }

    /// True if it has Newton–Raphson steps.
    pub const fn has_steps(self) -> bool {
        matches!(
            self.ordinary(),
            Special::Rcp | Special::Rsqrt | Special::Sqrt | Special::Div
        )
    }

    /// True if the program can take its steps.
    pub const fn has_steps_in_code(self) -> bool {
        matches!(self, Special::Rcp | Special::Rsqrt | Special::Sqrt)
    }

    /// True if a unit of this structure can compute it.
    pub const fn can_be(self, structure: Structure) -> bool {
        match structure {
            Structure::Recurrence { .. } => self.has_steps(),
            Structure::Cordic => !matches!(self.ordinary(), Special::Rsqrt),
            _ => true,
        }
    }

    /// The least segments, as a power of two, with which polynomials of a degree are good to `bits`. The
    /// interpolation at Chebyshev nodes is off by at most 2·M·(h/4)ⁿ, with n the degree and one, h
    /// the length of a segment and M the largest n-th derivative over n!. Three fifths of the error
    /// that is allowed are for this; coefficients and sums have the rest.
    pub fn segments(self, degree: u32, bits: u32) -> u32 {
        let n = degree + 1;
        let largest = self.curves().iter().map(|curve| curve.taylor(n));
        let largest = largest.fold(0.0, f64::max);
        let allowed = 0.6 * 2f64.powi(-(bits as i32));
        let enough = |k: &u32| {
            let quarter = 2f64.powi(-(*k as i32) - 2);
            2.0 * largest * quarter.powi(n as i32) <= allowed
        };
        (0..=MAX_SEGMENTS).find(enough).unwrap_or(MAX_SEGMENTS)
    }

    /// The most bits, up to `most`, to which polynomials of a degree in 2^k segments are good.
    pub fn bits_of(self, degree: u32, segments: u32, most: u32) -> u32 {
        let enough = |bits: &u32| self.segments(degree, *bits) <= segments;
        (1..=most).rev().find(enough).unwrap_or(0)
    }

    /// Bits of the tables of a unit for `bits` of precision, and of its largest single one.
    pub fn table_bits(self, structure: Structure, bits: u32) -> u64 {
        use approximation::{coefficient, division, fraction};
        let octaves = self.curves().len() as u64;
        // Results between ½ and 1 have no bit before the point; a sign or a leading bit else.
        let entry = u64::from(fraction(bits));
        octaves
            * match structure {
                // Twice as many entries where the precision is absolute.
                Structure::Table => {
                    let finer = u32::from(matches!(self, Special::Log2 | Special::Sincos));
                    u64::from((bits + 3).min(24)) << (bits + finer)
                }
                Structure::Offsets { tables } => {
                    let division = division(bits, tables);
                    let values = entry << division.values;
                    let parts = &division.offsets[..division.count];
                    // Offsets are symmetric about 0: half of them are stored, with as many bits as the
                    // largest has.
                    let offsets = parts.iter().map(|&(slope, part, before)| {
                        let width = entry.saturating_sub(u64::from(before)).max(1);
                        width << (slope + part).saturating_sub(1)
                    });
                    values + offsets.sum::<u64>()
                }
                Structure::Polynomial { degree, segments } => {
                    let widths =
                        (0..=degree).map(|i| u64::from(coefficient(bits, segments, i)) + 1);
                    widths.sum::<u64>() << segments
                }
                Structure::Recurrence { .. } | Structure::Cordic => 0,
            }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_are_those_of_published_units() {
        // The interpolator of NVIDIA's G80 has 128 segments for reciprocals of 23 bits.
        assert_eq!(Special::Rcp.segments(2, 23), 7);
        assert!(Special::Exp2.segments(2, 22) <= 6);
        assert!(Special::Rcp.segments(1, 16) > Special::Rcp.segments(2, 16));
        for bits in 4..=23 {
            for degree in 1..=3 {
                let segments = Special::Rsqrt.segments(degree, bits);
                assert!(Special::Rsqrt.bits_of(degree, segments, 23) >= bits);
            }
        }
    }

    #[test]
    fn tables_shrink_with_their_structure() {
        let size = |structure| Special::Rcp.table_bits(structure, 16);
        let polynomial = |degree| Structure::Polynomial {
            degree,
            segments: Special::Rcp.segments(degree, 16),
        };
        let sizes = [
            size(Structure::Table),
            size(Structure::Offsets { tables: 1 }),
            size(Structure::Offsets { tables: 2 }),
            size(polynomial(1)),
            size(polynomial(2)),
        ];
        assert!(sizes.is_sorted_by(|a, b| a > b), "{sizes:?}");
    }
}
