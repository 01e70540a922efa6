//! The effect of each operation on marks: one line an opcode.
//!
//! The table is complete by construction: an opcode without a line does not compile, nor does a
//! float operation whose line is for other values.

use super::arithmetic::Function;
use srp_archdesc::isa::{Kind, Opcode};

/// The effect of an operation on the marks of its operands. Rules for one lane and for several
/// include the number of lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// It computes a function of floats.
    Float(Function, usize),
    /// It adds up products of so many lanes, each step rounded.
    Dot(usize),
    /// It filters texels.
    Texture,
    /// It converts integers to floats.
    FromInteger {
        /// True if the integers are signed.
        signed: bool,
        /// Lanes.
        lanes: usize,
    },
    /// It rounds floats toward zero, to integers.
    ToInteger(usize),
    /// It rounds floats down, to floats.
    Floor(usize),
    /// It compares floats.
    Relation(Relation, usize),
    /// It computes with bits, which may be those of integers, of floats or of truth values.
    Bits(Bitwise, usize),
    /// It moves the bits of a word up.
    ShiftUp,
    /// It compares integers for being equal or not.
    Equality,
    /// It combines predicates.
    Logic(Logic),
    /// It hands its operand on.
    Move,
    /// It selects one of two values by a predicate.
    Select,
    /// It selects lanes of two vectors by a mask.
    Blend,
    /// It hands a word on to all lanes.
    Splat,
    /// It hands a lane on.
    Extract,
    /// It replaces a lane.
    Insert,
    /// It hands lanes on in another order.
    Swizzle,
    /// It reads or writes memory.
    Access,
    /// It takes halves apart, or puts floats together as halves: where they come from is not followed.
    Halves,
    /// It uses integers, predicates or words up.
    Use,
}

/// A comparison of floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Relation {
    Equal,
    NotEqual,
    Less,
    LessOrEqual,
}

impl Relation {
    /// True if the relation holds of two numbers.
    pub(super) fn holds(self, a: f64, b: f64) -> bool {
        match self {
            Relation::Equal => a == b,
            Relation::NotEqual => a != b,
            Relation::Less => a < b,
            Relation::LessOrEqual => a <= b,
        }
    }
}

/// A bitwise or integer operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bitwise {
    And,
    Or,
    Xor,
    Add,
    Sub,
}

/// How truth values are combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Logic {
    And,
    Or,
    Xor,
    Not,
    Select,
}

impl Rule {
    /// The rule of an operation.
    pub(super) const fn of(op: Opcode) -> Rule {
        use Opcode::*;
        use Rule::{Bits, Float, Floor, FromInteger, Relation as Compare, ToInteger};
        match op {
            Mov | Pmov | Vmov | Ptoi => Rule::Move,
            Sel | Vsel => Rule::Select,
            Psel => Rule::Logic(Logic::Select),

            Add => Bits(Bitwise::Add, 1),
            Sub => Bits(Bitwise::Sub, 1),
            And => Bits(Bitwise::And, 1),
            Or => Bits(Bitwise::Or, 1),
            Xor => Bits(Bitwise::Xor, 1),
            Shl => Rule::ShiftUp,
            Eq | Ne => Rule::Equality,
            Shr | Sar | Min | Max | Minu | Maxu | Lt | Le | Ltu | Leu => Rule::Use,
            Mul | Mulhs | Mulhu | Div | Divu | Rem | Remu => Rule::Use,

            Pand => Rule::Logic(Logic::And),
            Por => Rule::Logic(Logic::Or),
            Pxor => Rule::Logic(Logic::Xor),
            Pnot => Rule::Logic(Logic::Not),

            Fadd => Float(Function::Add, 1),
            Fsub => Float(Function::Sub, 1),
            Fmin => Float(Function::Min, 1),
            Fmax => Float(Function::Max, 1),
            Fneg => Float(Function::Neg, 1),
            Fabs => Float(Function::Abs, 1),
            Fmul => Float(Function::Mul, 1),
            Fma => Float(Function::Fma, 1),
            Fdiv | FdivFast => Float(Function::Div, 1),
            Rcp | RcpFast => Float(Function::Rcp, 1),
            Rsqrt | RsqrtFast => Float(Function::Rsqrt, 1),
            Sqrt | SqrtFast => Float(Function::Sqrt, 1),
            Exp2 => Float(Function::Exp2, 1),
            Log2 => Float(Function::Log2, 1),
            Sin => Float(Function::Sin, 1),
            Cos => Float(Function::Cos, 1),
            Ffloor => Floor(1),
            Feq => Compare(Relation::Equal, 1),
            Fne => Compare(Relation::NotEqual, 1),
            Flt => Compare(Relation::Less, 1),
            Fle => Compare(Relation::LessOrEqual, 1),
            Itof => FromInteger {
                signed: true,
                lanes: 1,
            },
            Utof => FromInteger {
                signed: false,
                lanes: 1,
            },
            Ftoi | Ftou => ToInteger(1),

            Vsplat => Rule::Splat,
            Vext => Rule::Extract,
            Vins => Rule::Insert,
            Swz => Rule::Swizzle,
            Vblend => Rule::Blend,

            Vadd => Bits(Bitwise::Add, 4),
            Vsub => Bits(Bitwise::Sub, 4),
            Vand => Bits(Bitwise::And, 4),
            Vor => Bits(Bitwise::Or, 4),
            Vxor => Bits(Bitwise::Xor, 4),
            Vshl | Vshr | Vsar | Vmin | Vmax | Veq | Vlt | Vltu | Vmul => Rule::Use,

            Vfadd => Float(Function::Add, 4),
            Vfsub => Float(Function::Sub, 4),
            Vfmin => Float(Function::Min, 4),
            Vfmax => Float(Function::Max, 4),
            Vfneg => Float(Function::Neg, 4),
            Vfabs => Float(Function::Abs, 4),
            Vfmul => Float(Function::Mul, 4),
            Vfma => Float(Function::Fma, 4),
            Vffloor => Floor(4),
            Vfeq => Compare(Relation::Equal, 4),
            Vfne => Compare(Relation::NotEqual, 4),
            Vflt => Compare(Relation::Less, 4),
            Vfle => Compare(Relation::LessOrEqual, 4),
            Vitof => FromInteger {
                signed: true,
                lanes: 4,
            },
            Vftoi => ToInteger(4),
            Dot3 => Rule::Dot(3),
            Dot4 => Rule::Dot(4),

            Hpack | Hlow | Hhigh | Vhpack | Vhlow | Vhhigh => Rule::Halves,
            Hadd | Hsub | Hmul | Hfma | Hmin | Hmax => Rule::Use,
            Vhadd | Vhsub | Vhmul | Vhfma | Vhmin | Vhmax => Rule::Use,

            Lb | Lbu | Lh | Lhu | Lw | Lv | Glb | Glbu | Glh | Glhu | Glw | Glv => Rule::Access,
            Sb | Sh | Sw | Sv | Gsb | Gsh | Gsw | Gsv => Rule::Access,
            Tex => Rule::Texture,
            In | Out | Prefetch => Rule::Use,
        }
    }

    /// True if its operands or its result are floats.
    const fn is_of_floats(self) -> bool {
        match self {
            Rule::Float(..) | Rule::Dot(_) | Rule::Texture | Rule::FromInteger { .. } => true,
            Rule::ToInteger(_) | Rule::Floor(_) | Rule::Relation(..) | Rule::Halves => true,
            Rule::Bits(..) | Rule::ShiftUp | Rule::Equality | Rule::Logic(_) => false,
            Rule::Move | Rule::Select | Rule::Blend | Rule::Splat | Rule::Extract => false,
            Rule::Insert | Rule::Swizzle | Rule::Access | Rule::Use => false,
        }
    }

    /// True if it has an effect even if its operands have no marks.
    pub(super) fn needs_no_marks(self) -> bool {
        matches!(
            self,
            Rule::Float(..)
                | Rule::Dot(_)
                | Rule::Texture
                | Rule::FromInteger { .. }
                | Rule::Access
        )
    }
}

/// True if an operation has float operands or a float result.
const fn is_on_floats(op: Opcode) -> bool {
    let info = op.info();
    let mut found = matches!(info.result, Some(Kind::F | Kind::F4));
    let mut i = 0;
    while i < info.operands.len() {
        found |= matches!(info.operands[i], Kind::F | Kind::F4);
        i += 1;
    }
    found
}

const _: () = {
    let mut i = 0;
    while i < Opcode::ALL.len() {
        let op = Opcode::ALL[i];
        assert!(
            Rule::of(op).is_of_floats() == is_on_floats(op),
            "an operation has floats, and its rule has none, or the other way round"
        );
        i += 1;
    }
};
