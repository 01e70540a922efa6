//! Scalars in objects: where in an object each lies, and how. Copies, initializers and split variables
//! go by them.

use crate::ctype::{Record, Type, TypeId, TypeTable};
use srp_archdesc::isa::{Opcode, Ty};

/// How a scalar lies in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Access {
    /// A byte, signed where true.
    Byte(bool),
    /// Two bytes, signed where true.
    Half(bool),
    Word,
    Vector,
}

impl Access {
    /// How values of a scalar or vector type lie in memory.
    pub(super) fn of(ty: &Type) -> Access {
        match ty {
            Type::Bool => Access::Byte(false),
            Type::Int(int) => match int.size() {
                1 => Access::Byte(int.signed()),
                2 => Access::Half(int.signed()),
                _ => Access::Word,
            },
            Type::Vector(_) => Access::Vector,
            _ => Access::Word,
        }
    }

    /// The value it is once read.
    pub(super) fn ty(self) -> Ty {
        match self {
            Access::Vector => Ty::Vec,
            _ => Ty::Word,
        }
    }

    /// The load, from system memory where `global`.
    pub(super) fn load(self, global: bool) -> Opcode {
        use Opcode::*;
        match (self, global) {
            (Access::Byte(true), false) => Lb,
            (Access::Byte(false), false) => Lbu,
            (Access::Half(true), false) => Lh,
            (Access::Half(false), false) => Lhu,
            (Access::Word, false) => Lw,
            (Access::Vector, false) => Lv,
            (Access::Byte(true), true) => Glb,
            (Access::Byte(false), true) => Glbu,
            (Access::Half(true), true) => Glh,
            (Access::Half(false), true) => Glhu,
            (Access::Word, true) => Glw,
            (Access::Vector, true) => Glv,
        }
    }

    /// The store, to system memory where `global`.
    pub(super) fn store(self, global: bool) -> Opcode {
        use Opcode::*;
        match (self, global) {
            (Access::Byte(_), false) => Sb,
            (Access::Half(_), false) => Sh,
            (Access::Word, false) => Sw,
            (Access::Vector, false) => Sv,
            (Access::Byte(_), true) => Gsb,
            (Access::Half(_), true) => Gsh,
            (Access::Word, true) => Gsw,
            (Access::Vector, true) => Gsv,
        }
    }
}

/// A scalar in an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Leaf {
    pub(super) offset: u32,
    pub(super) access: Access,
}

/// The scalars of an object, a union being cut into pieces of its alignment; `None` where there
/// are more than `limit`.
pub(super) fn leaves(types: &TypeTable, ty: TypeId, limit: usize) -> Option<Vec<Leaf>> {
    let mut out = Vec::new();
    collect(types, ty, 0, limit, &mut out)?;
    Some(out)
}

fn collect(
    types: &TypeTable,
    ty: TypeId,
    offset: u32,
    limit: usize,
    out: &mut Vec<Leaf>,
) -> Option<()> {
    match types.get(ty) {
        Type::Array(of, length) => {
            let size = types.size(of.ty)?;
            for i in 0..length.unwrap_or(0) {
                // An element without scalars does not count against the limit.
                if size == 0 {
                    break;
                }
                collect(types, of.ty, offset + i * size, limit, out)?;
            }
        }
        Type::Record(record) => {
            let record = &types.records[*record];
            // Bit-fields lie in units that overlap.
            if record.union || has_bits(record) {
                let (access, step) = match record.align {
                    16.. => (Access::Vector, 16),
                    4.. => (Access::Word, 4),
                    2.. => (Access::Half(false), 2),
                    _ => (Access::Byte(false), 1),
                };
                for at in (0..record.size).step_by(step) {
                    push(out, limit, offset + at, access)?;
                }
            } else {
                for field in record.fields.as_deref().unwrap_or(&[]) {
                    collect(types, field.ty.ty, offset + field.offset, limit, out)?;
                }
            }
        }
        _ if types.is_wide(ty) => {
            push(out, limit, offset, Access::Word)?;
            push(out, limit, offset + 4, Access::Word)?;
        }
        scalar => push(out, limit, offset, Access::of(scalar))?,
    }
    Some(())
}

fn has_bits(record: &Record) -> bool {
    let fields = record.fields.as_deref().unwrap_or(&[]);
    fields.iter().any(|field| field.bits.is_some())
}

fn push(out: &mut Vec<Leaf>, limit: usize, offset: u32, access: Access) -> Option<()> {
    if out.len() >= limit {
        return None;
    }
    out.push(Leaf { offset, access });
    Some(())
}

/// True if a type contains a union, or a struct that is laid out as one.
pub(super) fn has_union(types: &TypeTable, ty: TypeId) -> bool {
    match types.get(ty) {
        Type::Array(of, _) => has_union(types, of.ty),
        Type::Record(record) => {
            let record = &types.records[*record];
            let fields = record.fields.as_deref().unwrap_or(&[]);
            record.union || has_bits(record) || fields.iter().any(|f| has_union(types, f.ty.ty))
        }
        _ => false,
    }
}
