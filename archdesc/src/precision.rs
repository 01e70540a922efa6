//! [`Precision`]: how exact a machine's approximate units are.

/// How exact the special functions are.
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
}

impl Precision {
    /// Everything [`Approx::Exact`].
    pub const EXACT: Precision = Precision {
        rcp: Approx::Exact,
        rsqrt: Approx::Exact,
        sqrt: Approx::Exact,
        exp2: Approx::Exact,
        log2: Approx::Exact,
        sincos: Approx::Exact,
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
