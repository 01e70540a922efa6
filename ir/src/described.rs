//! [`Described`]: what a debugger has to know of a source besides its program. Types, objects and variables as C has
//! them, and the slots of the program before its passes in which each variable is.

use crate::program::{Func, Pos, Slot};
use std::collections::{BTreeMap, BTreeSet};

/// The number of a type in [`Described::types`].
pub type TypeRef = usize;

/// Types, objects and variables of a source.
#[derive(Clone, Debug, Default)]
pub struct Described {
    /// All types.
    pub types: Vec<Type>,
    /// The type of each object with static storage, by its name in the program.
    pub objects: BTreeMap<String, TypeRef>,
    /// The variables of the functions.
    pub variables: Vec<Variable>,
    /// Where the steps of `for` loops are: what they set counts from the next iteration on.
    pub steps: BTreeSet<Pos>,
}

/// A type.
#[derive(Clone, Debug, PartialEq)]
pub struct Type {
    /// As C writes it.
    pub name: String,
    /// Size in bytes, 0 where it has none.
    pub size: u32,
    /// Its kind.
    pub kind: Kind,
}

/// Kinds of types.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// `_Bool`, or an integer.
    Integer {
        /// It has negative values.
        signed: bool,
        /// It is `_Bool`.
        is_bool: bool,
        /// It is `char`, which is shown with its character.
        is_char: bool,
    },
    /// `float`.
    Float,
    /// `double`.
    Double,
    /// `float4`, or `int4`.
    Vector {
        /// The type of a lane.
        lane: TypeRef,
    },
    /// A pointer.
    Pointer {
        /// The type that it points to.
        to: TypeRef,
    },
    /// An array.
    Array {
        /// The type of an element.
        of: TypeRef,
        /// How many it has.
        length: u32,
    },
    /// A struct or union.
    Record(Vec<Field>),
    /// A function, `void`, or what has no size.
    Opaque,
}

/// A member.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Its name, empty for an anonymous struct or union.
    pub name: String,
    /// Its type.
    pub ty: TypeRef,
    /// Byte offset; of a bit-field, of the unit that it lies in.
    pub offset: u32,
    /// Of a bit-field the bytes of its unit, its lowest bit and its width.
    pub bits: Option<(u32, u32, u32)>,
}

/// A variable of a function, a parameter among them.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: TypeRef,
    /// The function, by its number before the passes.
    pub func: Func,
    /// It is a parameter.
    pub is_param: bool,
    /// The lines from its beginning to the last where it can be named, with the place of its declaration.
    pub from: Pos,
    /// The last line.
    pub to: u32,
    /// The slots in which it is, each with the offset of what the slot has.
    pub slots: Vec<(Slot, u32)>,
}

impl Described {
    /// The members of a record, those of anonymous ones among them, with their offsets from its beginning.
    pub fn member(&self, record: TypeRef, name: &str) -> Option<Field> {
        let Kind::Record(fields) = &self.types[record].kind else {
            return None;
        };
        fields.iter().find_map(|field| match field.name.as_str() {
            "" => self.member(field.ty, name).map(|inner| Field {
                offset: inner.offset + field.offset,
                ..inner
            }),
            own => (own == name).then(|| field.clone()),
        })
    }
}
