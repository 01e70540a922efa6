//! C types: each kept once in a [`TypeTable`], sizes and layouts as on the SRP.
//!
//! `long` has 32 bits and `long long` 64, `char` is signed, structs are laid out as the x86-64 C ABI
//! does for the same members.

mod compatible;
mod integer;

pub use compatible::Difference;
pub use integer::Int;

use crate::source::Name;
use srp_archdesc::diagnostic::Span;
use srp_archdesc::entity;
use srp_archdesc::entity::EntityMap;
use std::collections::HashMap;

entity! {
    /// A type.
    TypeId = "t";
    /// A struct or union.
    RecordId = "r";
}

/// Depth of derivation: pointers to arrays of functions of pointers…
pub const MAX_TYPE_DEPTH: u32 = 64;

/// A type without qualifiers.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Type {
    /// The type of an erroneous expression; compatible with every type.
    Error,
    /// `void`.
    Void,
    /// `_Bool`.
    Bool,
    /// An integer; enumerations are the integers they are compatible with.
    Int(Int),
    /// `float`.
    Float,
    /// `double`, and `long double`: binary64.
    Double,
    /// `float4` where true, else `int4`.
    Vector(bool),
    /// A pointer.
    Pointer(QualType),
    /// An array, of unknown length where `None`.
    Array(QualType, Option<u32>),
    /// A function.
    Function(Signature),
    /// A struct or union.
    Record(RecordId),
}

/// Qualifiers, the address space among them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Quals {
    /// `const`.
    pub constant: bool,
    /// `volatile`.
    pub volatile: bool,
    /// `restrict`.
    pub restrict: bool,
    /// `__srp_global`: in system memory.
    pub global: bool,
}

impl Quals {
    /// No qualifiers.
    pub const NONE: Quals = Quals {
        constant: false,
        volatile: false,
        restrict: false,
        global: false,
    };

    /// The qualifiers of either.
    pub fn and(self, other: Quals) -> Quals {
        Quals {
            constant: self.constant || other.constant,
            volatile: self.volatile || other.volatile,
            restrict: self.restrict || other.restrict,
            global: self.global || other.global,
        }
    }

    /// True if it has `const` and `volatile` wherever the other has.
    pub fn covers(self, other: Quals) -> bool {
        (self.constant || !other.constant) && (self.volatile || !other.volatile)
    }
}

/// A type with qualifiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct QualType {
    /// The type.
    pub ty: TypeId,
    /// Its qualifiers.
    pub quals: Quals,
}

impl QualType {
    /// A type without qualifiers.
    pub fn plain(ty: TypeId) -> QualType {
        QualType {
            ty,
            quals: Quals::NONE,
        }
    }
}

/// The result and parameters of a function.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Signature {
    /// The result; `void` for none.
    pub result: TypeId,
    /// The parameters, without qualifiers.
    pub params: Vec<TypeId>,
    /// It takes further arguments: `...`.
    pub variadic: bool,
    /// Its declaration leaves the parameters open: `()`.
    pub open: bool,
}

impl Signature {
    /// A function that takes these and nothing else.
    pub fn of(result: TypeId, params: Vec<TypeId>) -> Signature {
        Signature {
            result,
            params,
            variadic: false,
            open: false,
        }
    }
}

/// A struct or union.
#[derive(Clone, Debug)]
pub struct Record {
    /// Its tag.
    pub tag: Option<Name>,
    /// True if it is a union.
    pub union: bool,
    /// Its members; `None` while they are not known.
    pub fields: Option<Vec<Field>>,
    /// Size in bytes, padding included.
    pub size: u32,
    /// Alignment in bytes.
    pub align: u32,
    /// How deep records and arrays nest in it, with itself.
    pub nesting: u32,
    /// True if a member, or a member of one, is constant.
    pub constant: bool,
    /// Where it is declared.
    pub span: Span,
    /// The number of the source that declares it. Records of two sources are one type if they are alike, those of one
    /// source are not.
    pub unit: usize,
}

/// A member.
#[derive(Clone, Debug)]
pub struct Field {
    /// Its name; `None` for an anonymous struct or union, whose members are this record's.
    pub name: Option<Name>,
    /// Its type.
    pub ty: QualType,
    /// Byte offset; of a bit-field, of the unit that it lies in.
    pub offset: u32,
    /// The bits that a bit-field is.
    pub bits: Option<BitRange>,
}

/// The bits of a unit of memory that a bit-field is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitRange {
    /// Size of the unit in bytes: 1, 2, 4 or 8.
    pub unit: u32,
    /// Its lowest bit in the unit.
    pub shift: u32,
    /// How many bits.
    pub width: u32,
}

impl BitRange {
    /// The bits of a unit where these are set to the low bits of a value.
    pub fn insert(self, unit: u64, value: u64) -> u64 {
        let mask = self.mask() << self.shift;
        unit & !mask | value << self.shift & mask
    }

    /// As many low bits as it has.
    pub fn mask(self) -> u64 {
        u64::MAX >> (64 - self.width)
    }
}

/// A member that was looked for.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Byte offset from the start of the record.
    pub offset: u32,
    /// Its type.
    pub ty: QualType,
    /// The bits that a bit-field is.
    pub bits: Option<BitRange>,
}

/// All types of a compilation.
#[derive(Debug)]
pub struct TypeTable {
    types: EntityMap<TypeId, (Type, u32)>,
    index: HashMap<Type, TypeId>,
    /// Structs and unions.
    pub records: EntityMap<RecordId, Record>,
    /// Types often needed.
    pub known: Known,
}

/// Types often needed.
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs)] // each is its C name
pub struct Known {
    pub error: TypeId,
    pub void: TypeId,
    pub bool: TypeId,
    pub char: TypeId,
    pub int: TypeId,
    pub uint: TypeId,
    pub long: TypeId,
    pub ulong: TypeId,
    pub float: TypeId,
    pub double: TypeId,
    pub llong: TypeId,
    pub ullong: TypeId,
    pub float4: TypeId,
    pub int4: TypeId,
}

impl Default for TypeTable {
    fn default() -> TypeTable {
        let mut types = EntityMap::new();
        let mut index = HashMap::new();
        let mut add = |ty: Type| {
            let id = types.push((ty.clone(), 0));
            index.insert(ty, id);
            id
        };
        let known = Known {
            error: add(Type::Error),
            void: add(Type::Void),
            bool: add(Type::Bool),
            char: add(Type::Int(Int::Char)),
            int: add(Type::Int(Int::Int)),
            uint: add(Type::Int(Int::UInt)),
            long: add(Type::Int(Int::Long)),
            ulong: add(Type::Int(Int::ULong)),
            float: add(Type::Float),
            double: add(Type::Double),
            llong: add(Type::Int(Int::LongLong)),
            ullong: add(Type::Int(Int::ULongLong)),
            float4: add(Type::Vector(true)),
            int4: add(Type::Vector(false)),
        };
        TypeTable {
            types,
            index,
            records: EntityMap::new(),
            known,
        }
    }
}

impl TypeTable {
    /// The type.
    pub fn get(&self, id: TypeId) -> &Type {
        &self.types[id].0
    }

    /// The numbers of all types.
    pub fn ids(&self) -> impl Iterator<Item = TypeId> + use<> {
        self.types.keys()
    }

    /// A struct or union.
    pub fn record(&self, id: RecordId) -> &Record {
        &self.records[id]
    }

    /// The type's number, made where it is new.
    pub fn id(&mut self, ty: Type) -> TypeId {
        if let Some(&id) = self.index.get(&ty) {
            return id;
        }
        let below = match &ty {
            Type::Pointer(to) => self.depth(to.ty),
            Type::Array(of, _) => self.depth(of.ty),
            Type::Function(signature) => {
                let params = signature.params.iter().chain([&signature.result]);
                params.map(|&t| self.depth(t)).max().unwrap_or(0)
            }
            _ => 0,
        };
        let id = self.types.push((ty.clone(), below + 1));
        self.index.insert(ty, id);
        id
    }

    /// How many steps of derivation a type has.
    pub fn depth(&self, id: TypeId) -> u32 {
        self.types[id].1
    }

    /// The type of an integer.
    pub fn int(&mut self, int: Int) -> TypeId {
        self.id(Type::Int(int))
    }

    /// A pointer to a type.
    pub fn pointer(&mut self, to: QualType) -> TypeId {
        self.id(Type::Pointer(to))
    }

    /// The same type, where the qualifiers of an array are those of its elements (C17 6.7.3).
    pub fn qualified(&mut self, ty: QualType) -> QualType {
        match *self.get(ty.ty) {
            Type::Array(of, length) if ty.quals != Quals::NONE => {
                let quals = of.quals.and(ty.quals);
                let of = self.qualified(QualType { quals, ..of });
                QualType::plain(self.id(Type::Array(of, length)))
            }
            _ => ty,
        }
    }

    /// An array without the qualifiers of its elements, and with these itself; any other type as it
    /// is.
    pub fn bare(&mut self, ty: QualType) -> QualType {
        match *self.get(ty.ty) {
            Type::Array(of, length) => {
                let of = self.bare(of);
                QualType {
                    ty: self.id(Type::Array(QualType::plain(of.ty), length)),
                    quals: ty.quals.and(of.quals),
                }
            }
            _ => ty,
        }
    }

    /// Size in bytes; `None` where it has none or it is not known.
    pub fn size(&self, id: TypeId) -> Option<u32> {
        Some(match self.get(id) {
            Type::Error => 4,
            Type::Void | Type::Function(_) | Type::Array(_, None) => return None,
            Type::Bool => 1,
            Type::Int(int) => int.size(),
            Type::Float | Type::Pointer(_) => 4,
            Type::Double => 8,
            Type::Vector(_) => 16,
            Type::Array(of, Some(length)) => self.size(of.ty)?.checked_mul(*length)?,
            Type::Record(record) => {
                self.records[*record].fields.as_ref()?;
                self.records[*record].size
            }
        })
    }

    /// Alignment in bytes.
    pub fn align(&self, id: TypeId) -> u32 {
        match self.get(id) {
            Type::Array(of, _) => self.align(of.ty),
            Type::Record(record) => self.records[*record].align,
            _ => self.size(id).unwrap_or(1),
        }
    }

    /// True if it is `_Bool` or an integer.
    pub fn is_integer(&self, id: TypeId) -> bool {
        matches!(self.get(id), Type::Bool | Type::Int(_) | Type::Error)
    }

    /// True if it is `float` or `double`.
    pub fn is_floating(&self, id: TypeId) -> bool {
        matches!(self.get(id), Type::Float | Type::Double)
    }

    /// True if it is a number.
    pub fn is_arithmetic(&self, id: TypeId) -> bool {
        self.is_integer(id) || self.is_floating(id)
    }

    /// True if its values are pairs of words.
    pub fn is_wide(&self, id: TypeId) -> bool {
        match self.get(id) {
            Type::Double => true,
            Type::Int(int) => int.size() == 8,
            _ => false,
        }
    }

    /// Returns the type that a pointer points to.
    pub fn pointee(&self, id: TypeId) -> Option<QualType> {
        match self.get(id) {
            Type::Pointer(to) => Some(*to),
            _ => None,
        }
    }

    /// True if it is arithmetic or a pointer.
    pub fn is_scalar(&self, id: TypeId) -> bool {
        self.is_arithmetic(id) || self.pointee(id).is_some()
    }

    /// The lanes of a vector: `Some(true)` for floats.
    pub fn vector(&self, id: TypeId) -> Option<bool> {
        match self.get(id) {
            Type::Vector(float) => Some(*float),
            _ => None,
        }
    }

    /// True if comparisons and divisions of its values are unsigned: unsigned integers and
    /// pointers.
    pub fn is_unsigned(&self, id: TypeId) -> bool {
        match self.get(id) {
            Type::Int(int) => !int.signed(),
            Type::Bool | Type::Pointer(_) => true,
            _ => false,
        }
    }

    /// The member of this name, members of anonymous members included.
    pub fn field(&self, record: RecordId, name: &str) -> Option<Found> {
        let fields = self.records[record].fields.as_ref()?;
        fields.iter().find_map(|field| match &field.name {
            Some(found) => (**found == *name).then_some(Found {
                offset: field.offset,
                ty: field.ty,
                bits: field.bits,
            }),
            None => match self.get(field.ty.ty) {
                Type::Record(inner) => self.field(*inner, name).map(|found| Found {
                    offset: field.offset + found.offset,
                    ..found
                }),
                _ => None,
            },
        })
    }

    /// The type as C writes it.
    pub fn show(&self, ty: QualType) -> String {
        self.declares(ty, "")
    }

    /// The declaration of a name with this type, as C writes it.
    pub fn declares(&self, ty: QualType, name: &str) -> String {
        let (mut ty, mut declarator) = (ty, name.to_owned());
        loop {
            let inner = match self.get(ty.ty) {
                Type::Pointer(to) => {
                    declarator = format!("*{}{declarator}", words(ty.quals, true));
                    *to
                }
                Type::Array(of, length) => {
                    let length = length.map_or(String::new(), |n| n.to_string());
                    declarator = format!("{}[{length}]", grouped(declarator));
                    QualType {
                        ty: of.ty,
                        quals: of.quals.and(ty.quals),
                    }
                }
                Type::Function(signature) => {
                    let params = signature.params.iter();
                    let mut params: Vec<_> = params.map(|&p| self.show_plain(p)).collect();
                    if signature.variadic {
                        params.push("...".to_owned());
                    } else if params.is_empty() && !signature.open {
                        params.push("void".to_owned());
                    }
                    let params = params.join(", ");
                    declarator = format!("{}({params})", grouped(declarator));
                    QualType::plain(signature.result)
                }
                base => {
                    let base = self.base_name(base);
                    let space = if declarator.is_empty() { "" } else { " " };
                    return format!("{}{base}{space}{declarator}", words(ty.quals, false));
                }
            };
            ty = inner;
        }
    }

    /// The type as C writes it.
    pub fn show_plain(&self, ty: TypeId) -> String {
        self.show(QualType::plain(ty))
    }

    fn base_name(&self, ty: &Type) -> String {
        match ty {
            Type::Void => "void".to_owned(),
            Type::Bool => "_Bool".to_owned(),
            Type::Int(int) => int.name().to_owned(),
            Type::Float => "float".to_owned(),
            Type::Double => "double".to_owned(),
            Type::Vector(true) => "float4".to_owned(),
            Type::Vector(false) => "int4".to_owned(),
            Type::Record(record) => self.record_words(*record),
            _ => "an unknown type".to_owned(),
        }
    }

    fn record_words(&self, record: RecordId) -> String {
        let record = &self.records[record];
        let kind = if record.union { "union" } else { "struct" };
        match &record.tag {
            Some(tag) => format!("{kind} {tag}"),
            None => format!("an unnamed {kind}"),
        }
    }

    /// A record as a sentence names it: in quotes where it has a tag.
    pub fn record_name(&self, record: RecordId) -> String {
        let words = self.record_words(record);
        match self.records[record].tag {
            Some(_) => format!("`{words}`"),
            None => words,
        }
    }
}

/// A declarator in parentheses where it starts with a pointer.
fn grouped(declarator: String) -> String {
    if declarator.starts_with('*') {
        format!("({declarator})")
    } else {
        declarator
    }
}

/// Qualifiers with a space after each; of a pointer where `own`.
fn words(quals: Quals, own: bool) -> String {
    let list = [
        (quals.global, "__srp_global "),
        (quals.constant, "const "),
        (quals.volatile, "volatile "),
        (quals.restrict && own, "restrict "),
    ];
    list.iter()
        .filter(|(on, _)| *on)
        .map(|(_, word)| *word)
        .collect()
}
