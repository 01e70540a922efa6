//! Certificates of approximate units: the error of a function over all 2²³ mantissas, against binary64.
//!
//! Reciprocal and division go through the octave from 1 to 2, roots through the two from 1 to 4, exp2
//! through all fractions (from 1 to 2), log2 through 1 to 2, sine and cosine through ½ to 1. By powers
//! of two, signs and quarter turns that is all there is, but for results that are denormal.

use schemars::JsonSchema;
use serde::Serialize;

use crate::ops::semantics::elementary::{self, cosine, logarithm, power, sine};
use crate::precision::{Approx, Precision};
use crate::structure::{Special, Structure};

/// A function that a unit computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Function {
    /// 1/x
    Rcp,
    /// 1/√x
    Rsqrt,
    /// √x
    Sqrt,
    /// a/x, for an a that changes with x
    Div,
    /// 2^x
    Exp2,
    /// log2 x
    Log2,
    /// sin x
    Sin,
    /// cos x
    Cos,
}

const ONE: u32 = 0x3f80_0000;
const MANTISSAS: u32 = 1 << 23;

impl Function {
    /// All of them.
    pub const ALL: [Function; 8] = [
        Function::Rcp,
        Function::Rsqrt,
        Function::Sqrt,
        Function::Div,
        Function::Exp2,
        Function::Log2,
        Function::Sin,
        Function::Cos,
    ];

    /// Its name in listings.
    pub const fn name(self) -> &'static str {
        match self {
            Function::Rcp => "rcp",
            Function::Rsqrt => "rsqrt",
            Function::Sqrt => "sqrt",
            Function::Div => "div",
            Function::Exp2 => "exp2",
            Function::Log2 => "log2",
            Function::Sin => "sin",
            Function::Cos => "cos",
        }
    }

    /// The special function that it is, or is of.
    pub const fn special(self) -> Special {
        match self {
            Function::Rcp => Special::Rcp,
            Function::Rsqrt => Special::Rsqrt,
            Function::Sqrt => Special::Sqrt,
            Function::Div => Special::Div,
            Function::Exp2 => Special::Exp2,
            Function::Log2 => Special::Log2,
            Function::Sin | Function::Cos => Special::Sincos,
        }
    }

    /// The precision that a machine has it in, with all steps taken, wherever they are.
    pub fn of(self, precision: &Precision) -> Approx {
        precision.of(self.special()).in_unit()
    }

    /// The words that it is tried on, rising.
    fn operands(self) -> std::ops::Range<u32> {
        match self {
            Function::Rsqrt | Function::Sqrt => ONE..ONE + 2 * MANTISSAS,
            Function::Sin | Function::Cos => ONE - MANTISSAS..ONE,
            _ => ONE..ONE + MANTISSAS,
        }
    }

    /// Returns the unit's result for a word.
    fn unit(self, x: u32, (bits, steps): (u32, u32)) -> u32 {
        match self {
            Function::Rcp => elementary::rcp(x, bits, steps),
            Function::Rsqrt => elementary::rsqrt(x, bits, steps),
            Function::Sqrt => elementary::sqrt(x, bits, steps),
            Function::Div => elementary::fdiv(dividend(x), x, bits, steps),
            Function::Exp2 => elementary::exp2(x, bits),
            Function::Log2 => elementary::log2(x, bits),
            Function::Sin => elementary::sin(x, bits),
            Function::Cos => elementary::cos(x, bits),
        }
    }

    /// The same in binary64.
    fn reference(self, x: u32) -> f64 {
        let value = f64::from(f32::from_bits(x));
        match self {
            Function::Rcp => 1.0 / value,
            Function::Rsqrt => 1.0 / value.sqrt(),
            Function::Sqrt => value.sqrt(),
            Function::Div => f64::from(f32::from_bits(dividend(x))) / value,
            Function::Exp2 => power(value),
            Function::Log2 => logarithm(value),
            Function::Sin => sine(value),
            Function::Cos => cosine(value),
        }
    }

    /// True if its results rise with its operands there; `None` where they do neither that nor fall.
    fn rises(self) -> Option<bool> {
        match self {
            Function::Rcp | Function::Rsqrt | Function::Cos => Some(false),
            Function::Sqrt | Function::Exp2 | Function::Log2 | Function::Sin => Some(true),
            Function::Div => None,
        }
    }

    /// True if its tables promise an absolute error; else it is a relative one.
    pub const fn is_absolute(self) -> bool {
        matches!(self, Function::Log2 | Function::Sin | Function::Cos)
    }

    /// Operands that are powers of two, or whole numbers for exp2, and their exact results.
    fn powers(self) -> Vec<(u32, u32)> {
        let word = |n: i32| ((n + 127) as u32) << 23;
        let whole = |n: i32| (n as f32).to_bits();
        let all = -126..=126;
        match self {
            Function::Rcp => all.map(|n| (word(n), word(-n))).collect(),
            Function::Rsqrt => (-63..=63).map(|n| (word(2 * n), word(-n))).collect(),
            Function::Sqrt => (-63..=63).map(|n| (word(2 * n), word(n))).collect(),
            Function::Exp2 => all.map(|n| (whole(n), word(n))).collect(),
            Function::Log2 => all.map(|n| (word(n), whole(n))).collect(),
            Function::Div | Function::Sin | Function::Cos => Vec::new(),
        }
    }
}

/// A dividend from 1 to 2 for a divisor, as good as any.
fn dividend(x: u32) -> u32 {
    ONE | (x.wrapping_mul(0x9e37_79b9) >> 9)
}

/// The measured errors of a unit over all mantissas.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Certificate {
    /// The function.
    pub function: Function,
    /// How its unit is built; `None` for the exact function.
    pub structure: Option<Structure>,
    /// Bits of its first approximation; `None` for the exact function.
    pub table_bits: Option<u32>,
    /// Newton–Raphson steps after it.
    pub steps: u32,
    /// True if these are fused.
    pub fused: bool,
    /// −log2 of the error that the machine promises: correct bits are not fewer.
    pub promised_bits: f64,
    /// Operands that were tried.
    pub operands: u32,
    /// Largest error in units in the last place of the exact result.
    pub worst_ulp: f64,
    /// An operand with that error, its bits.
    pub worst_at: u32,
    /// Mean error in units in the last place.
    pub mean_ulp: f64,
    /// −log2 of the largest relative error, or of the absolute one where that is what tables of the
    /// function promise.
    pub correct_bits: f64,
    /// Share of results that are the nearest float (for exp2, log2, sine and cosine: the float that
    /// binary64 rounds to).
    pub rounded: f64,
    /// True if the order of the results is that of the exact ones; `None` where these have none.
    pub monotone: Option<bool>,
    /// True if powers of two (whole numbers for exp2) have exact results; `None` where there are none.
    pub powers_exact: Option<bool>,
}

/// Tries a unit of this precision on every mantissa.
pub fn certify(function: Function, approx: Approx) -> Certificate {
    let approx = approx.in_unit();
    let arguments = approx.arguments();
    let (mut worst, mut worst_at, mut sum, mut largest) = (0f64, ONE, 0f64, 0f64);
    let (mut rounded, mut monotone) = (0u32, true);
    let mut last: Option<f32> = None;
    let range = function.operands();
    let operands = range.len() as u32;
    for x in range {
        let y = function.unit(x, arguments);
        let exact = function.reference(x);
        let found = f32::from_bits(y);
        let off = (f64::from(found) - exact).abs();
        let ulps = off / place(exact);
        sum += ulps;
        if ulps > worst {
            (worst, worst_at) = (ulps, x);
        }
        largest = largest.max(match function.is_absolute() {
            true => off,
            false => off / exact.abs(),
        });
        rounded += u32::from(y == function.unit(x, (0, 0)));
        monotone &= match (last, function.rises()) {
            (Some(last), Some(true)) => last <= found,
            (Some(last), Some(false)) => last >= found,
            _ => true,
        };
        last = Some(found);
    }
    let powers = function.powers();
    let exact = |&(x, y): &(u32, u32)| function.unit(x, arguments) == y;
    let (structure, table_bits, steps, fused) = match approx {
        Approx::Exact => (None, None, 0, true),
        Approx::Table {
            structure,
            bits,
            steps,
            fused,
            ..
        } => (Some(structure), Some(bits), steps, fused),
    };
    Certificate {
        function,
        structure,
        table_bits,
        steps,
        fused,
        promised_bits: -approx.error_bound().log2(),
        operands,
        worst_ulp: worst,
        worst_at,
        mean_ulp: sum / f64::from(operands),
        correct_bits: -largest.log2(),
        rounded: f64::from(rounded) / f64::from(operands),
        monotone: function.rises().map(|_| monotone),
        powers_exact: (!powers.is_empty()).then(|| powers.iter().all(exact)),
    }
}

/// A unit in the last place of binary32 for a result of this size.
fn place(exact: f64) -> f64 {
    let exponent = ((exact.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    f64::from_bits(((exponent.max(-126) - 23 + 1023) as u64) << 52)
}
