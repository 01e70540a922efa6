//! Real arithmetic: the same program on numbers that are better than floats.
//!
//! A [`Number`] computes [`Operation`]s. [`Wide`] has some 200 bits and stands for the real number itself;
//! [`Bounded`] is an interval of real numbers with a bound of the error that binary32 makes of any of
//! them. Both run what a kernel says: its [`Program`](srp_ir::program::Program) or its FPCore.

mod bounded;
mod elementary;
mod wide;

pub use bounded::{Bounded, Units};
pub use wide::Wide;

/// An operation on real numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// a + b
    Add,
    /// a − b
    Sub,
    /// a · b
    Mul,
    /// a / b
    Div,
    /// a · b + c
    Fma,
    /// −a
    Neg,
    /// |a|
    Abs,
    /// The lesser
    Min,
    /// The greater
    Max,
    /// 1/a by the unit
    Rcp,
    /// 1/√a by the unit
    Rsqrt,
    /// √a
    Sqrt,
    /// e^a
    Exp,
    /// 2^a
    Exp2,
    /// e^a − 1
    Expm1,
    /// ln a
    Log,
    /// log2 a
    Log2,
    /// log10 a
    Log10,
    /// ln (1 + a)
    Log1p,
    /// sin a
    Sin,
    /// cos a
    Cos,
    /// tan a
    Tan,
    /// arcsin a
    Asin,
    /// arccos a
    Acos,
    /// arctan a
    Atan,
    /// The angle of the point (b, a)
    Atan2,
    /// sinh a
    Sinh,
    /// cosh a
    Cosh,
    /// tanh a
    Tanh,
    /// arsinh a
    Asinh,
    /// arcosh a
    Acosh,
    /// artanh a
    Atanh,
    /// a^b
    Pow,
    /// ∛a
    Cbrt,
    /// √(a² + b²)
    Hypot,
    /// The remainder of a by b, with the sign of a
    Fmod,
    /// The greatest whole number that is not above a
    Floor,
    /// The least whole number that is not below a
    Ceil,
    /// The whole part
    Trunc,
    /// The nearest whole number, halves away from zero
    Round,
    /// The nearest whole number, halves to even
    Rint,
    /// |a| with the sign of b
    Copysign,
    /// a − b where that is positive, else 0
    Fdim,
}

impl Operation {
    /// All operations that FPCore and `math.h` have by name: FPCore's name, operands, and the function of `math.h`
    /// for `float` where C has no operator.
    pub const NAMED: &'static [(Operation, &'static str, usize, &'static str)] = &[
        (Operation::Fma, "fma", 3, "fmaf"),
        (Operation::Abs, "fabs", 1, "fabsf"),
        (Operation::Min, "fmin", 2, "fminf"),
        (Operation::Max, "fmax", 2, "fmaxf"),
        (Operation::Sqrt, "sqrt", 1, "sqrtf"),
        (Operation::Exp, "exp", 1, "expf"),
        (Operation::Exp2, "exp2", 1, "exp2f"),
        (Operation::Expm1, "expm1", 1, "expm1f"),
        (Operation::Log, "log", 1, "logf"),
        (Operation::Log2, "log2", 1, "log2f"),
        (Operation::Log10, "log10", 1, "log10f"),
        (Operation::Log1p, "log1p", 1, "log1pf"),
        (Operation::Sin, "sin", 1, "sinf"),
        (Operation::Cos, "cos", 1, "cosf"),
        (Operation::Tan, "tan", 1, "tanf"),
        (Operation::Asin, "asin", 1, "asinf"),
        (Operation::Acos, "acos", 1, "acosf"),
        (Operation::Atan, "atan", 1, "atanf"),
        (Operation::Atan2, "atan2", 2, "atan2f"),
        (Operation::Sinh, "sinh", 1, "sinhf"),
        (Operation::Cosh, "cosh", 1, "coshf"),
        (Operation::Tanh, "tanh", 1, "tanhf"),
        (Operation::Asinh, "asinh", 1, "asinhf"),
        (Operation::Acosh, "acosh", 1, "acoshf"),
        (Operation::Atanh, "atanh", 1, "atanhf"),
        (Operation::Pow, "pow", 2, "powf"),
        (Operation::Cbrt, "cbrt", 1, "cbrtf"),
        (Operation::Hypot, "hypot", 2, "hypotf"),
        (Operation::Fmod, "fmod", 2, "fmodf"),
        (Operation::Floor, "floor", 1, "floorf"),
        (Operation::Ceil, "ceil", 1, "ceilf"),
        (Operation::Trunc, "trunc", 1, "truncf"),
        (Operation::Round, "round", 1, "roundf"),
        (Operation::Rint, "nearbyint", 1, "rintf"),
        (Operation::Copysign, "copysign", 2, "copysignf"),
        (Operation::Fdim, "fdim", 2, "fdimf"),
    ];
}

/// How two numbers relate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// The first is less.
    Less,
    /// They are equal.
    Equal,
    /// The first is greater.
    Greater,
    /// One of them is no number.
    Unordered,
    /// It cannot be told.
    Unknown,
}

/// Why a number cannot be had.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Undefined(pub String);

/// A number that a program can be run on.
pub trait Number: Clone {
    /// The settings that operations depend on besides their operands.
    type Context;

    /// A float.
    fn of_float(x: f32) -> Self;

    /// An integer of the program that becomes a float.
    fn of_integer(n: i64, context: &Self::Context) -> Self;

    /// The decimal number `digits`·10^`exponent`, which a program in binary32 has rounded.
    fn of_decimal(digits: &str, exponent: i32, context: &Self::Context) -> Self;

    /// The result of an operation.
    ///
    /// # Errors
    ///
    /// The number cannot be bounded.
    fn apply(op: Operation, args: &[Self], context: &Self::Context) -> Result<Self, Undefined>;

    /// The result of an operation of the special-function unit itself, not of the library's function.
    ///
    /// # Errors
    ///
    /// The number cannot be bounded.
    fn of_unit(op: Operation, args: &[Self], context: &Self::Context) -> Result<Self, Undefined> {
        Self::apply(op, args, context)
    }

    /// The result of a reciprocal, root or quotient on the machine's fast unit.
    ///
    /// # Errors
    ///
    /// The number cannot be bounded.
    fn of_fast_unit(
        op: Operation,
        args: &[Self],
        context: &Self::Context,
    ) -> Result<Self, Undefined> {
        Self::apply(op, args, context)
    }

    /// The number that a program has rounded to a half.
    ///
    /// # Errors
    ///
    /// The number cannot be bounded.
    fn half(&self) -> Result<Self, Undefined> {
        Ok(self.clone())
    }

    /// How it relates to another.
    fn relate(&self, other: &Self) -> Relation;

    /// The float nearest to it, if that is known: what a program sees that looks at its bits.
    fn nearest(&self) -> Option<f32>;

    /// Its whole part, if that is known.
    fn whole(&self) -> Option<i64>;
}
