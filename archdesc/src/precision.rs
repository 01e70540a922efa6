//! [`Precision`]: how exact a machine's approximate units are.

/// How exact the special functions and the texture unit are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Precision {
    /// Reciprocal.
    pub rcp: Approx,
    /// Reciprocal square root.
    pub rsqrt: Approx,
    /// Square root.
    pub sqrt: Approx,
    /// Power of two.
    pub exp2: Approx,
    /// Binary logarithm.
    pub log2: Approx,
    /// Sine and cosine.
    pub sincos: Approx,
    /// Fraction bits of the weights by which texels are filtered, 0 to 12; 0 takes the nearest.
    pub texture_weight_bits: u32,
}

impl Precision {
    /// Everything [`Approx::Exact`], texels weighted as machines do where nothing else is said.
    pub const EXACT: Precision = Precision {
        rcp: Approx::Exact,
        rsqrt: Approx::Exact,
        sqrt: Approx::Exact,
        exp2: Approx::Exact,
        log2: Approx::Exact,
        sincos: Approx::Exact,
        texture_weight_bits: 8,
    };
}

/// The precision of one special function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Approx {
    /// Correctly rounded reciprocal and roots; the transcendental functions evaluated in binary64
    /// by a fixed polynomial and rounded once.
    Exact,
    /// A first approximation good to `bits` bits, improved by `steps` Newton–Raphson steps where
    /// the function has them (reciprocal and roots).
    Table {
        /// Correct bits of the first approximation, 4 to 23.
        bits: u32,
        /// Newton–Raphson steps after it, 0 to 3.
        steps: u32,
    },
}
