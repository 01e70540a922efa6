//! Which opcodes compute C's operators, by the type of the operands. The constant folder and the
//! lowering both read it here.

use crate::ctype::{Int, Type};
use crate::typed::{BinaryOp, Relation};
use srp_archdesc::isa::Opcode;

/// What a type's values are to the opcodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    /// A signed integer.
    Signed,
    /// An unsigned integer or a pointer.
    Unsigned,
    /// A float.
    Float,
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
            Type::Vector(true) => Class::Float4,
            Type::Vector(false) => Class::Int4,
            Type::Int(int) if int.signed() => Class::Signed,
            _ => Class::Unsigned,
        }
    }

    /// Whether its values are vectors.
    pub(crate) fn is_vector(self) -> bool {
        matches!(self, Class::Int4 | Class::Float4)
    }
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
        (Rem | And | Or | Xor | Shl | Shr, Float | Float4) => return None,
    };
    Some(Plan::Direct(direct))
}

/// How a relation is computed: an opcode, whether its operands change places, and whether its
/// result is then inverted (which is never so for floats: a NaN makes every order false).
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
    };
    (opcode, swap, false)
}

/// The opcode that converts between integer and float before an integer is cut to its size.
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
