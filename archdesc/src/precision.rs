//! [`Precision`]: how exact a machine's approximate units are.

use crate::format::{Format, Formats};
use crate::ops::semantics::elementary::SEPARATE;
use crate::structure::{Special, Structure};
use serde::{Deserialize, Serialize};

/// Fast units beside the ordinary ones; `None` where a machine has none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Fast {
    /// Reciprocal.
    pub rcp: Option<Approx>,
    /// Reciprocal square root.
    pub rsqrt: Option<Approx>,
    /// Square root.
    pub sqrt: Option<Approx>,
    /// Division.
    pub div: Option<Approx>,
}

/// How exact the special functions and the texture unit are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Precision {
    /// Reciprocal.
    pub rcp: Approx,
    /// Reciprocal square root.
    pub rsqrt: Approx,
    /// Square root.
    pub sqrt: Approx,
    /// Division: a product by a reciprocal of this precision, or digit by digit.
    pub div: Approx,
    /// Power of two.
    pub exp2: Approx,
    /// Binary logarithm.
    pub log2: Approx,
    /// Sine and cosine.
    pub sincos: Approx,
    /// Units of the same functions beside these.
    pub fast: Fast,
    /// The treatment of subnormal floats.
    pub subnormals: Subnormals,
    /// The formats that adders and multipliers compute in.
    pub formats: Formats,
    /// Fraction bits of the weights by which texels are filtered, 0 to 12; 0 takes the nearest.
    pub texture_weight_bits: u32,
}

impl Precision {
    /// Everything [`Approx::Exact`], texels weighted as machines do where nothing else is said.
    pub const EXACT: Precision = Precision {
        rcp: Approx::Exact,
        rsqrt: Approx::Exact,
        sqrt: Approx::Exact,
        div: Approx::Exact,
        exp2: Approx::Exact,
        log2: Approx::Exact,
        sincos: Approx::Exact,
        fast: Fast {
            rcp: None,
            rsqrt: None,
            sqrt: None,
            div: None,
        },
        subnormals: Subnormals::Keep,
        formats: Formats::SINGLE,
        texture_weight_bits: 8,
    };
}

/// The rounding to a format, where it is coarser than binary32.
fn beyond_single(format: Format) -> f64 {
    match format.significand < Format::SINGLE.significand {
        true => format.rounding(),
        false => 0.0,
    }
}

/// Half a unit in the last place of 1, the unit roundoff: the error of rounding to binary32.
pub const U: f64 = 1.0 / (1 << 24) as f64;

/// The part by which a [narrowed](Precision::narrowing) reciprocal is less than its error asks for, so that its roundings
/// do not make it larger.
pub const NARROWED: f64 = 8.0 * U;

impl Approx {
    /// An upper bound of the error of a function of this precision: relative for reciprocal, roots and
    /// exponential where the result is normal, absolute for logarithm, sine and cosine below 1. A step
    /// of Newton squares the error of a reciprocal, and three halves of that of a root, and adds its own
    /// roundings, five at most. `docs/numerics.md` derives it.
    pub fn error_bound(self) -> f64 {
        self.error_before_rounding() + U
    }

    /// The same before the result is rounded to binary32: 2^−bits of a table, 0 of an exact function.
    pub fn error_before_rounding(self) -> f64 {
        match self {
            Approx::Exact => 0.0,
            Approx::Table { bits, steps, .. } => {
                let table = 2f64.powi(-(bits as i32));
                (0..steps).fold(table, |e, _| 2.0 * e * e + 5.0 * U)
            }
        }
    }
}

/// The treatment of floats below 2^-126 that are not 0, as operands and as results.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Subnormals {
    /// They are numbers like others.
    Keep,
    /// Operands and results are taken as zeros of their sign.
    Flush,
}

impl Subnormals {
    /// Both.
    pub const ALL: [Subnormals; 2] = [Subnormals::Keep, Subnormals::Flush];

    /// Its name in machine files.
    pub const fn name(self) -> &'static str {
        match self {
            Subnormals::Keep => "keep",
            Subnormals::Flush => "flush",
        }
    }
}

/// The precision of one special function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Approx {
    /// Correctly rounded reciprocal, roots and quotient; the transcendental functions evaluated in
    /// binary64 by a fixed polynomial and rounded once.
    Exact,
    /// A first approximation good to `bits` bits, improved by `steps` Newton–Raphson steps where
    /// the function has them (reciprocal, roots, division).
    Table {
        /// How it is made; all but tables and polynomials take no steps.
        structure: Structure,
        /// Correct bits of the first approximation, 4 to 23.
        bits: u32,
        /// Newton–Raphson steps after it, 0 to 3.
        steps: u32,
        /// True when a step has fused multiply-adds; else it rounds after every operation.
        fused: bool,
        /// Who takes the steps.
        refine: Refine,
    },
}

/// Who takes the Newton–Raphson steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Refine {
    /// The unit of the function, within its latency.
    Unit,
    /// The program: the unit gives the first approximation, and the compiler puts the steps behind
    /// it. The result is the same to the bit.
    Code,
}

impl Refine {
    /// Both of them.
    pub const ALL: [Refine; 2] = [Refine::Unit, Refine::Code];

    /// Its name in machine files.
    pub const fn name(self) -> &'static str {
        match self {
            Refine::Unit => "unit",
            Refine::Code => "code",
        }
    }
}

impl Approx {
    /// A table of so many bits, improved by so many fused steps in its unit.
    pub const fn table(bits: u32, steps: u32) -> Approx {
        Approx::Table {
            structure: Structure::Table,
            bits,
            steps,
            fused: true,
            refine: Refine::Unit,
        }
    }

    /// So many bits by a structure, without steps.
    pub const fn built(structure: Structure, bits: u32) -> Approx {
        Approx::Table {
            structure,
            bits,
            steps: 0,
            fused: true,
            refine: Refine::Unit,
        }
    }

    /// The same function with all of its steps in the unit: what a compiled program computes.
    pub const fn in_unit(self) -> Approx {
        match self {
            Approx::Exact => Approx::Exact,
            Approx::Table {
                structure,
                bits,
                steps,
                fused,
                ..
            } => Approx::Table {
                structure,
                bits,
                steps,
                fused,
                refine: Refine::Unit,
            },
        }
    }

    /// Describes the unit as the functions of [`ops::semantics`](crate::ops::semantics) take it:
    /// unit word, 0 for the exact function, and steps, with [`SEPARATE`] where they are not fused.
    pub const fn arguments(self) -> (u32, u32) {
        match self {
            Approx::Exact => (0, 0),
            Approx::Table {
                structure,
                bits,
                refine: Refine::Code,
                ..
            } => (structure.unit_word(bits), 0),
            Approx::Table {
                structure,
                bits,
                steps,
                fused,
                ..
            } => {
                let steps = if fused { steps } else { steps | SEPARATE };
                (structure.unit_word(bits), steps)
            }
        }
    }
}

impl Precision {
    /// The factor by which a reciprocal is multiplied for far planes of boxes, to cover all errors of their distance
    /// against that of a near one: twice the error of the reciprocal, twice those of subtraction and multiplication, and
    /// the roundings of this product itself, which is made in the format of the machine's. `docs/numerics.md` derives it.
    pub fn widening(&self) -> f32 {
        match self.reciprocal_error() {
            error if error < 1.0 => {
                let made = (1.0 - self.product_rounding()).powi(3);
                ((1.0 + error) / (1.0 - error) / made + 16.0 * U) as f32
            }
            _ => f32::MAX,
        }
    }

    /// The factor by which a reciprocal is multiplied for near planes of boxes, so that no box seems to begin behind
    /// where it does: 1 where it is exact, for then the distance is off by no more than roundings. A hit counts from
    /// where its box begins, so that the error of a coarse reciprocal would be that of all distances.
    /// `docs/numerics.md` derives it.
    pub fn narrowing(&self) -> f32 {
        if self.rcp == Approx::Exact {
            return 1.0;
        }
        let made = (1.0 + self.product_rounding()).powi(3);
        (1.0 / (1.0 + self.reciprocal_error()) / made - NARROWED) as f32
    }

    /// The rounding of a product, and of each of its factors, beyond binary32's: 0 where that is the format of products.
    pub fn product_rounding(&self) -> f64 {
        beyond_single(self.formats.multiply)
    }

    /// An upper bound of the relative error of a reciprocal as programs have it.
    pub fn reciprocal_error(&self) -> f64 {
        self.error_in_code(Special::Rcp)
    }

    /// An upper bound of the relative error of a reciprocal or a root as programs have it: that of
    /// [the unit](Approx::error_bound), and where its steps are operations of the program, of what these round away in the
    /// machine's formats, provided that all they meet fits into the formats' exponents. `docs/numerics.md` counts the
    /// roundings.
    pub fn error_in_code(&self, special: Special) -> f64 {
        let approx = self.of(special);
        let Approx::Table {
            bits,
            steps,
            fused,
            refine: Refine::Code,
            ..
        } = approx
        else {
            return approx.error_bound();
        };
        let Formats {
            add,
            multiply,
            fused: both,
        } = self.formats;
        let used: &[Format] = match (special, fused) {
            (Special::Rcp, true) => &[both],
            (_, true) => &[both, multiply],
            // A product and a sum may be fused after all.
            (_, false) => &[add, multiply, both],
        };
        let rounding = used.iter().map(|&format| beyond_single(format));
        let rounding = rounding.fold(0.0, f64::max);
        if rounding == 0.0 {
            return approx.error_bound();
        }
        let roundings = match (special, fused) {
            (Special::Rcp, true) => 5.0,
            (Special::Rcp, false) => 9.0,
            (_, true) => 6.0,
            (_, false) => 12.0,
        };
        let first = 2f64.powi(-(bits as i32));
        let step = |e: f64| (2.0 * e * e + roundings * rounding) * (1.0 + 4.0 * e);
        // Where a step leads to no number, the approximation before it stays.
        let refined = (0..steps).fold(first, |e, _| step(e).max(first));
        let product = match special {
            Special::Sqrt => 4.0 * rounding,
            _ => 0.0,
        };
        refined + product + U
    }

    /// True if a machine has a unit for a function: always, but for fast ones.
    pub fn has(&self, special: Special) -> bool {
        match special {
            Special::RcpFast => self.fast.rcp.is_some(),
            Special::RsqrtFast => self.fast.rsqrt.is_some(),
            Special::SqrtFast => self.fast.sqrt.is_some(),
            Special::DivFast => self.fast.div.is_some(),
            _ => true,
        }
    }

    /// The functions for which a machine has units, in the order of [`Special::ALL`].
    pub fn specials(self) -> impl Iterator<Item = Special> {
        (Special::ALL.into_iter()).filter(move |&special| self.has(special))
    }

    /// That of one function; without a fast unit, the ordinary one computes it.
    pub const fn of(&self, special: Special) -> Approx {
        match special {
            Special::Rcp => self.rcp,
            Special::Rsqrt => self.rsqrt,
            Special::Sqrt => self.sqrt,
            Special::Div => self.div,
            Special::Exp2 => self.exp2,
            Special::Log2 => self.log2,
            Special::Sincos => self.sincos,
            Special::RcpFast => or(self.fast.rcp, self.rcp),
            Special::RsqrtFast => or(self.fast.rsqrt, self.rsqrt),
            Special::SqrtFast => or(self.fast.sqrt, self.sqrt),
            Special::DivFast => or(self.fast.div, self.div),
        }
    }

    /// That of one function, to change it. A fast unit that there is not begins as the ordinary one.
    pub fn of_mut(&mut self, special: Special) -> &mut Approx {
        match special {
            Special::Rcp => &mut self.rcp,
            Special::Rsqrt => &mut self.rsqrt,
            Special::Sqrt => &mut self.sqrt,
            Special::Div => &mut self.div,
            Special::Exp2 => &mut self.exp2,
            Special::Log2 => &mut self.log2,
            Special::Sincos => &mut self.sincos,
            Special::RcpFast => self.fast.rcp.get_or_insert(self.rcp),
            Special::RsqrtFast => self.fast.rsqrt.get_or_insert(self.rsqrt),
            Special::SqrtFast => self.fast.sqrt.get_or_insert(self.sqrt),
            Special::DivFast => self.fast.div.get_or_insert(self.div),
        }
    }

    /// The same with all Newton–Raphson steps in their units: what a compiled program computes.
    pub const fn in_units(self) -> Precision {
        Precision {
            rcp: self.rcp.in_unit(),
            rsqrt: self.rsqrt.in_unit(),
            sqrt: self.sqrt.in_unit(),
            ..self
        }
    }
}

const fn or(fast: Option<Approx>, ordinary: Approx) -> Approx {
    match fast {
        Some(fast) => fast,
        None => ordinary,
    }
}
