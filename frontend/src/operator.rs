//! Which opcodes compute C's operators, by the type of the operands. The constant folder and the
//! lowering both read it here.
//!
//! Integers of 64 bits are pairs of words: most operators on them become several opcodes. What is
//! too long for that, and all arithmetic of `double`, are functions of the library ([`Support`]).

use crate::ctype::{Int, Type};
use srp_archdesc::isa::Opcode;

/// Arithmetic operators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // each is its C operator
pub enum BinaryOp {
    Add,
    Sub,
    Mul,
    Div,
    Rem,
    And,
    Or,
    Xor,
    Shl,
    Shr,
}

/// Relations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // each is its C operator
pub enum Relation {
    Eq,
    Ne,
    Lt,
    Le,
    Gt,
    Ge,
}

/// The class of a type's values, which selects opcodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    /// A signed integer.
    Signed,
    /// An unsigned integer or a pointer.
    Unsigned,
    /// A signed integer of 64 bits.
    Long,
    /// An unsigned integer of 64 bits.
    ULong,
    /// A float.
    Float,
    /// A double.
    Double,
    /// Four signed integers.
    Int4,
    /// Four floats.
    Float4,
}

impl Class {
    /// The class of a scalar or vector type.
    pub(crate) fn of(ty: &Type) -> Class {
        match ty {
            Type::Float => Class::Float,
            Type::Double => Class::Double,
            Type::Vector(true) => Class::Float4,
            Type::Vector(false) => Class::Int4,
            Type::Int(int) if int.size() == 8 && int.signed() => Class::Long,
            Type::Int(int) if int.size() == 8 => Class::ULong,
            Type::Int(int) if int.signed() => Class::Signed,
            _ => Class::Unsigned,
        }
    }

    /// True if its values are vectors.
    pub(crate) fn is_vector(self) -> bool {
        matches!(self, Class::Int4 | Class::Float4)
    }
}

macro_rules! support {
    ($($name:ident $function:literal;)*) => {
        /// Functions of the library that compute what no opcode does. Doubles are passed to them
        /// and returned as their bits.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub(crate) enum Support { $($name,)* }

        impl Support {
            /// All of them.
            pub(crate) const ALL: &'static [Support] = &[$(Support::$name,)*];

            /// The name of the function.
            pub(crate) fn name(self) -> &'static str {
                match self { $(Support::$name => $function,)* }
            }
        }
    };
}

support! {
    LongDiv "__srp_divdi3"; LongRem "__srp_moddi3";
    ULongDiv "__srp_udivdi3"; ULongRem "__srp_umoddi3";
    DoubleAdd "__srp_adddf3"; DoubleSub "__srp_subdf3";
    DoubleMul "__srp_muldf3"; DoubleDiv "__srp_divdf3";
    DoubleEq "__srp_eqdf2"; DoubleLt "__srp_ltdf2"; DoubleLe "__srp_ledf2";
    IntToDouble "__srp_floatsidf"; UIntToDouble "__srp_floatunsidf";
    LongToDouble "__srp_floatdidf"; ULongToDouble "__srp_floatundidf";
    DoubleToInt "__srp_fixdfsi"; DoubleToUInt "__srp_fixunsdfsi";
    DoubleToLong "__srp_fixdfdi"; DoubleToULong "__srp_fixunsdfdi";
    FloatToDouble "__srp_extendsfdf2"; DoubleToFloat "__srp_truncdfsf2";
    LongToFloat "__srp_floatdisf"; ULongToFloat "__srp_floatundisf";
    FloatToLong "__srp_fixsfdi"; FloatToULong "__srp_fixunssfdi";
}

/// How an operator is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Plan {
    /// By one opcode.
    Direct(Opcode),
    /// By a guarded opcode.
    Guarded(Opcode),
    /// On each lane by the scalar operator.
    Lanes,
    /// On pairs of words.
    Pairs,
    /// By a function of the library.
    Support(Support),
}

/// How an arithmetic operator is computed; `None` where the type has none.
pub(crate) fn binary(op: BinaryOp, class: Class) -> Option<Plan> {
    use BinaryOp::*;
    use Class::*;
    let direct = match (op, class) {
        (Add, Signed | Unsigned) => Opcode::Add,
        (Add, Float) => Opcode::Fadd,
        (Add, Int4) => Opcode::Vadd,
        (Add, Float4) => Opcode::Vfadd,
        (Sub, Signed | Unsigned) => Opcode::Sub,
        (Sub, Float) => Opcode::Fsub,
        (Sub, Int4) => Opcode::Vsub,
        (Sub, Float4) => Opcode::Vfsub,
        (Mul, Signed | Unsigned) => Opcode::Mul,
        (Mul, Float) => Opcode::Fmul,
        (Mul, Int4) => Opcode::Vmul,
        (Mul, Float4) => Opcode::Vfmul,
        (Div, Float) => Opcode::Fdiv,
        (Div, Signed) => return Some(Plan::Guarded(Opcode::Div)),
        (Div, Unsigned) => return Some(Plan::Guarded(Opcode::Divu)),
        (Rem, Signed) => return Some(Plan::Guarded(Opcode::Rem)),
        (Rem, Unsigned) => return Some(Plan::Guarded(Opcode::Remu)),
        (Div, Float4 | Int4) | (Rem, Int4) => return Some(Plan::Lanes),
        (And, Signed | Unsigned) => Opcode::And,
        (And, Int4) => Opcode::Vand,
        (Or, Signed | Unsigned) => Opcode::Or,
        (Or, Int4) => Opcode::Vor,
        (Xor, Signed | Unsigned) => Opcode::Xor,
        (Xor, Int4) => Opcode::Vxor,
        (Shl, Signed | Unsigned) => Opcode::Shl,
        (Shl, Int4) => Opcode::Vshl,
        (Shr, Signed) => Opcode::Sar,
        (Shr, Unsigned) => Opcode::Shr,
        (Shr, Int4) => Opcode::Vsar,
        (Div, Long) => return Some(Plan::Support(Support::LongDiv)),
        (Div, ULong) => return Some(Plan::Support(Support::ULongDiv)),
        (Rem, Long) => return Some(Plan::Support(Support::LongRem)),
        (Rem, ULong) => return Some(Plan::Support(Support::ULongRem)),
        (_, Long | ULong) => return Some(Plan::Pairs),
        (Add, Double) => return Some(Plan::Support(Support::DoubleAdd)),
        (Sub, Double) => return Some(Plan::Support(Support::DoubleSub)),
        (Mul, Double) => return Some(Plan::Support(Support::DoubleMul)),
        (Div, Double) => return Some(Plan::Support(Support::DoubleDiv)),
        (Rem | And | Or | Xor | Shl | Shr, Float | Float4 | Double) => return None,
    };
    Some(Plan::Direct(direct))
}

/// How a relation of single words or vectors is computed: an opcode, whether its operands change
/// places, and whether its result is then inverted (which is never so for floats: a NaN makes every
/// order false).
pub(crate) fn relation(relation: Relation, class: Class) -> (Opcode, bool, bool) {
    use Class::*;
    use Relation::*;
    let swap = matches!(relation, Gt | Ge);
    let opcode = match (relation, class) {
        (Eq, Signed | Unsigned) => Opcode::Eq,
        (Eq, Float) => Opcode::Feq,
        (Eq | Ne, Int4) => return (Opcode::Veq, false, relation == Ne),
        (Eq, Float4) => Opcode::Vfeq,
        (Ne, Signed | Unsigned) => Opcode::Ne,
        (Ne, Float) => Opcode::Fne,
        (Ne, Float4) => Opcode::Vfne,
        (Lt | Gt, Signed) => Opcode::Lt,
        (Lt | Gt, Unsigned) => Opcode::Ltu,
        (Lt | Gt, Float) => Opcode::Flt,
        (Lt | Gt, Int4) => Opcode::Vlt,
        (Lt | Gt, Float4) => Opcode::Vflt,
        (Le | Ge, Signed) => Opcode::Le,
        (Le | Ge, Unsigned) => Opcode::Leu,
        (Le | Ge, Float) => Opcode::Fle,
        // a <= b is not (b < a).
        (Le | Ge, Int4) => return (Opcode::Vlt, !swap, true),
        (Le | Ge, Float4) => Opcode::Vfle,
        (_, Long | ULong | Double) => unreachable!("relations of pairs are computed otherwise"),
    };
    (opcode, swap, false)
}

/// The function for a relation of doubles, whether its operands change places, and whether its
/// result is then inverted.
pub(crate) fn double_relation(relation: Relation) -> (Support, bool, bool) {
    match relation {
        Relation::Eq => (Support::DoubleEq, false, false),
        Relation::Ne => (Support::DoubleEq, false, true),
        Relation::Lt => (Support::DoubleLt, false, false),
        Relation::Gt => (Support::DoubleLt, true, false),
        Relation::Le => (Support::DoubleLe, false, false),
        Relation::Ge => (Support::DoubleLe, true, false),
    }
}

/// The opcode that converts between integer and float before an integer is cut to its size; for
/// types of one word.
pub(crate) fn conversion(from: &Type, to: &Type) -> Option<Opcode> {
    match (Class::of(from), Class::of(to), to) {
        (Class::Float, Class::Float, _) => None,
        (Class::Signed, Class::Float, _) => Some(Opcode::Itof),
        (Class::Unsigned, Class::Float, _) => Some(Opcode::Utof),
        (Class::Float, _, Type::Int(Int::UInt | Int::ULong)) => Some(Opcode::Ftou),
        (Class::Float, _, _) => Some(Opcode::Ftoi),
        _ => None,
    }
}

/// The function that converts from or to a double, or between float and an integer of 64 bits,
/// before an integer is cut to its size.
pub(crate) fn conversion_support(from: &Type, to: &Type) -> Option<Support> {
    use Class::*;
    if *to == Type::Bool {
        return None;
    }
    Some(match (Class::of(from), Class::of(to)) {
        (Signed, Double) => Support::IntToDouble,
        (Unsigned, Double) => Support::UIntToDouble,
        (Long, Double) => Support::LongToDouble,
        (ULong, Double) => Support::ULongToDouble,
        (Float, Double) => Support::FloatToDouble,
        (Double, Float) => Support::DoubleToFloat,
        (Double, Long) => Support::DoubleToLong,
        (Double, ULong) => Support::DoubleToULong,
        (Double, Signed | Unsigned) => match to {
            Type::Int(Int::UInt | Int::ULong) => Support::DoubleToUInt,
            _ => Support::DoubleToInt,
        },
        (Long, Float) => Support::LongToFloat,
        (ULong, Float) => Support::ULongToFloat,
        (Float, Long) => Support::FloatToLong,
        (Float, ULong) => Support::FloatToULong,
        _ => return None,
    })
}
