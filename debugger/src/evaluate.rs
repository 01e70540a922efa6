//! Expressions at a frame: where what they name lies, its type, and its value.

use crate::breakpoint::Memory;
use crate::expression::{Expression, Operand, never};
use crate::locals::Spot;
use crate::session::Session;
use crate::show::{FrameOf, Variable, shown};
use crate::typed::{Bytes, Writer, field_bits, number};
use srp_archdesc::isa::Ty;
use srp_csimgen::preamble::ops::V4;
use srp_ir::described::{Described, Field, Kind, TypeRef};

/// Most bytes of an object that are looked at.
const MOST_BYTES: u32 = 1 << 22;

/// The thing that an operand names.
#[derive(Clone, Debug)]
pub(crate) enum Named {
    /// A number, or a register, without a C type.
    Plain(Ty, V4),
    /// The address of something, as a number.
    Address(u32, Option<TypeRef>),
    /// Words of a core's memory without a type.
    Words(u32, u32),
    /// Something with a type.
    Typed(Typed),
}

/// A value with a type, and its address if it has one.
#[derive(Clone, Debug)]
pub(crate) struct Typed {
    ty: TypeRef,
    bytes: Bytes,
    address: Option<u32>,
    /// The bits of the first bytes that it is.
    bits: Option<(u32, u32, u32)>,
    note: String,
    why: Option<String>,
}

/// Where expressions are looked at.
#[derive(Clone, Debug)]
pub(crate) struct At {
    pub(crate) core: u32,
    pub(crate) of: FrameOf,
    pub(crate) spot: Spot,
}

impl Session<'_> {
    pub(crate) fn described(&self) -> &Described {
        &self.code.variables.described
    }

    fn at(&self, core: u32, of: FrameOf) -> At {
        let spot = self.spot(core, of);
        At { core, of, spot }
    }

    /// An expression of which each name has a value somewhere.
    ///
    /// # Errors
    ///
    /// A sentence that says what is wrong.
    pub fn parsed(&self, text: &str) -> Result<Expression, String> {
        let expression = Expression::parse(text).map_err(|error| error.to_string())?;
        match self.unknown_name(&expression) {
            Some(name) => Err(never(name)),
            None => Ok(expression),
        }
    }

    /// The value of an expression at a frame.
    ///
    /// # Errors
    ///
    /// A sentence that says what is wrong.
    pub fn evaluate(&self, core: u32, of: FrameOf, text: &str) -> Result<String, String> {
        let expression = self.parsed(text)?;
        let at = self.at(core, of);
        let Some((comparison, right)) = &expression.right else {
            return self.write(&self.find(&at, &expression.left)?, text);
        };
        let (left, right) = self.numbers(&at, &expression.left, right)?;
        Ok(comparison.holds(left, right).to_string())
    }

    /// The type of an expression, and what a struct has where `all`.
    ///
    /// # Errors
    ///
    /// A sentence that says what is wrong.
    pub fn type_of(&self, core: u32, of: FrameOf, text: &str, all: bool) -> Result<String, String> {
        let expression = self.parsed(text)?;
        let ty = match self.find(&self.at(core, of), &expression.left)? {
            Named::Typed(typed) => typed.ty,
            Named::Address(_, Some(to)) => {
                return Ok(format!("{} *", self.described().types[to].name));
            }
            _ => return Ok("a word without a type".to_owned()),
        };
        let data = &self.described().types[ty];
        let mut text = data.name.clone();
        if let (Kind::Record(fields), true) = (&data.kind, all) {
            for field in fields {
                let name = &self.described().types[field.ty].name;
                let bits = field
                    .bits
                    .map_or(String::new(), |(_, _, width)| format!(" : {width}"));
                text += &format!("\n  +{} {name} {}{bits}", field.offset, field.name);
            }
            text += &format!("\n  {} bytes", data.size);
        }
        Ok(text)
    }

    /// The variables that can be named at a frame, with their values, or why they have none.
    pub(crate) fn locals(&self, core: u32, of: FrameOf) -> Vec<Variable> {
        let at = self.at(core, of);
        let mut seen: Vec<Variable> = Vec::new();
        for variable in self.in_scope(&at.spot) {
            let name = &self.described().variables[variable].name;
            // One that is declared further in hides it.
            if !seen.iter().any(|known| known.name == *name) {
                let typed = self.variable(&at, variable);
                let value = self.value_of(&typed);
                let parts = value.as_ref().map_or(Vec::new(), |_| self.lanes(&typed));
                let value = value.unwrap_or_else(|why| format!("no value here{why}"));
                let shown = Variable::plain(name.clone(), value);
                seen.push(Variable { parts, ..shown });
            }
        }
        seen.reverse();
        seen
    }

    /// The lanes of a vector.
    fn lanes(&self, of: &Typed) -> Vec<Variable> {
        let Kind::Vector { lane } = self.described().types[of.ty].kind else {
            return Vec::new();
        };
        let value = |n: u32| Writer::new(self.described()).write(lane, &of.bytes.part(4 * n, 4));
        let lanes = (0..4).map(|n| Variable::plain(format!("[{n}]"), value(n)));
        lanes.collect()
    }

    pub(crate) fn variable(&self, at: &At, variable: usize) -> Typed {
        let (bytes, note, why) = self.bytes_of(at.core, at.of, &at.spot, variable);
        Typed {
            ty: self.described().variables[variable].ty,
            bytes,
            address: None,
            bits: None,
            note,
            why,
        }
    }

    fn write(&self, named: &Named, text: &str) -> Result<String, String> {
        match named {
            Named::Plain(ty, value) => Ok(shown(*ty, *value)),
            Named::Address(address, Some(to)) => Ok(format!(
                "({} *) {address:#x}",
                self.described().types[*to].name
            )),
            Named::Address(address, None) => Ok(format!("{address:#x}")),
            Named::Words(..) => {
                let (ty, value) = self.plain_value(named).ok_or_else(|| no_value(text))?;
                Ok(shown(ty, value))
            }
            Named::Typed(typed) => self.write_typed(typed, text),
        }
    }

    fn write_typed(&self, typed: &Typed, text: &str) -> Result<String, String> {
        let value = self.value_of(typed);
        value.map_err(|why| format!("{}{why}", no_value(text)))
    }

    /// A value with its note; the error is the end of a sentence that says that there is none.
    fn value_of(&self, typed: &Typed) -> Result<String, String> {
        let data = &self.described().types[typed.ty];
        if data.size > 0 && typed.bytes.are_all_unknown() {
            let why = typed.why.as_ref();
            return Err(why.map_or(String::new(), |why| format!(": {why}")));
        }
        let value = match typed.bits {
            Some(bits) => {
                let signed = matches!(data.kind, Kind::Integer { signed: true, .. });
                let value = field_bits(&typed.bytes, bits, signed);
                value.map_or("?".to_owned(), |value| value.to_string())
            }
            None => Writer::new(self.described()).write(typed.ty, &typed.bytes),
        };
        Ok(match typed.note.as_str() {
            "" => value,
            note => format!("{value} ({note})"),
        })
    }

    /// Memory of a type.
    pub(crate) fn in_memory(&self, at: &At, address: u32, ty: TypeRef) -> Typed {
        let size = self.described().types[ty].size.min(MOST_BYTES);
        let bytes = self.machine.read(at.core, address, size);
        let missing = (bytes.len() < size as usize).then(|| format!("{address:#x} is no memory"));
        Typed {
            ty,
            bytes: Bytes::known(bytes, size),
            address: Some(address),
            bits: None,
            note: String::new(),
            why: missing,
        }
    }

    fn find(&self, at: &At, operand: &Operand) -> Result<Named, String> {
        match operand {
            Operand::Integer(bits) => Ok(Named::Plain(Ty::Word, word(*bits))),
            Operand::Real(value) => Ok(Named::Plain(Ty::Word, word(value.to_bits()))),
            Operand::Name(name) => self.by_name(at, name),
            Operand::Of(inner) => match self.find(at, inner)? {
                Named::Words(_, address) => Ok(Named::Address(address, None)),
                Named::Typed(Typed {
                    address: Some(address),
                    bits: None,
                    ty,
                    ..
                }) => Ok(Named::Address(address, Some(ty))),
                _ => Err(format!("`{inner}` has no address: it is in registers")),
            },
            Operand::At(inner) => {
                let pointer = self.find(at, inner)?;
                self.element(at, &pointer, 0, inner)
            }
            Operand::Element(inner, index) => {
                let array = self.find(at, inner)?;
                let index = self.number(at, index, false)? as i64;
                if let Operand::Name(name) = &**inner
                    && let Some(found) = self.register(at.core, name, Some(index))
                {
                    return found;
                }
                self.element(at, &array, index, inner)
            }
            Operand::Member(inner, name) => {
                if let Some(dotted) = operand
                    .dotted()
                    .filter(|name| self.is_object_or_store(name))
                {
                    return self.by_name(at, &dotted);
                }
                self.member(&self.find(at, inner)?, inner, name)
            }
        }
    }

    /// An element of an array or a vector, or what a pointer points to.
    fn element(&self, at: &At, of: &Named, index: i64, text: &Operand) -> Result<Named, String> {
        let typed = match of {
            Named::Typed(typed) => typed,
            Named::Address(address, Some(to)) => {
                let size = self.described().types[*to].size;
                return Ok(Named::Typed(self.in_memory(
                    at,
                    moved(*address, index, size),
                    *to,
                )));
            }
            Named::Address(address, None) => {
                return Ok(Named::Words(at.core, moved(*address, index, 4)));
            }
            Named::Words(core, address) => {
                return Ok(Named::Words(*core, moved(*address, index, 4)));
            }
            Named::Plain(_, value) => {
                return Ok(Named::Words(at.core, moved(value.0[0], index, 4)));
            }
        };
        let types = &self.described().types;
        match types[typed.ty].kind {
            Kind::Array { of, length } => {
                if let Some(address) = typed.address {
                    let element = moved(address, index, types[of].size);
                    return Ok(Named::Typed(self.in_memory(at, element, of)));
                }
                self.part(typed, index, of, length, text)
            }
            Kind::Vector { lane } => self.part(typed, index, lane, 4, text),
            Kind::Pointer { to } => {
                let bits = typed.bytes.number(4);
                let known = || self.write_typed(typed, &text.to_string()).err();
                let Some(address) = bits else {
                    return Err(known().unwrap_or_else(|| no_value(&text.to_string())));
                };
                let address = moved(address as u32, index, types[to].size);
                Ok(Named::Typed(self.in_memory(at, address, to)))
            }
            _ => Err(format!(
                "`{text}` is {}, which has no elements",
                types[typed.ty].name
            )),
        }
    }

    fn part(
        &self,
        of: &Typed,
        index: i64,
        ty: TypeRef,
        length: u32,
        text: &Operand,
    ) -> Result<Named, String> {
        if !(0..i64::from(length)).contains(&index) {
            return Err(format!(
                "`{text}` has elements 0 to {}",
                length.saturating_sub(1)
            ));
        }
        Ok(self.inner(of, index as u32 * self.described().types[ty].size, ty))
    }

    fn inner(&self, of: &Typed, offset: u32, ty: TypeRef) -> Named {
        let size = self.described().types[ty].size;
        Named::Typed(Typed {
            ty,
            bytes: of.bytes.part(offset, size),
            address: of.address.map(|address| address.wrapping_add(offset)),
            ..of.clone()
        })
    }

    fn member(&self, of: &Named, text: &Operand, name: &str) -> Result<Named, String> {
        let types = &self.described().types;
        let Named::Typed(of) = of else {
            return Err(format!("`{text}` has no members"));
        };
        if matches!(types[of.ty].kind, Kind::Vector { .. })
            && let Some(lane) = ["x", "y", "z", "w"].iter().position(|lane| *lane == name)
        {
            return self.part(of, lane as i64, lane_type(types, of.ty), 4, text);
        }
        let Some(Field {
            ty, offset, bits, ..
        }) = self.described().member(of.ty, name)
        else {
            return Err(format!(
                "`{text}` is {}, which has no member `{name}`",
                types[of.ty].name
            ));
        };
        Ok(match (bits, self.inner(of, offset, ty)) {
            (Some(bits), Named::Typed(inner)) => Named::Typed(Typed {
                bytes: of.bytes.part(offset, bits.0),
                bits: Some(bits),
                ..inner
            }),
            (_, inner) => inner,
        })
    }

    fn plain_value(&self, named: &Named) -> Option<(Ty, V4)> {
        match named {
            Named::Plain(ty, value) => Some((*ty, *value)),
            Named::Words(core, address) => {
                let bytes = self.machine.read(*core, *address, 4).try_into().ok()?;
                Some((Ty::Word, word(u32::from_le_bytes(bytes))))
            }
            _ => None,
        }
    }

    /// An operand as a number: a word without a type is a float where the other side is one.
    fn number(&self, at: &At, operand: &Operand, is_real: bool) -> Result<f64, String> {
        let text = operand.to_string();
        match (self.find(at, operand)?, operand) {
            (_, Operand::Real(value)) => Ok(f64::from(*value)),
            (Named::Typed(typed), _) => {
                let value = match typed.bits {
                    Some(bits) => {
                        let kind = &self.described().types[typed.ty].kind;
                        let signed = matches!(kind, Kind::Integer { signed: true, .. });
                        field_bits(&typed.bytes, bits, signed).map(|value| value as f64)
                    }
                    None => number(self.described(), typed.ty, &typed.bytes),
                };
                value.ok_or_else(|| match self.write_typed(&typed, &text) {
                    Err(why) => why,
                    Ok(_) => format!("`{text}` is no number"),
                })
            }
            (Named::Address(address, _), _) => Ok(f64::from(address)),
            (named, _) => {
                let (_, value) = self.plain_value(&named).ok_or_else(|| no_value(&text))?;
                let is_register = !matches!(operand, Operand::Integer(_));
                Ok(match is_real && is_register {
                    true => f64::from(f32::from_bits(value.0[0])),
                    false => f64::from(value.0[0] as i32),
                })
            }
        }
    }

    fn numbers(&self, at: &At, left: &Operand, right: &Operand) -> Result<(f64, f64), String> {
        let is_real = [left, right].iter().any(|o| matches!(o, Operand::Real(_)));
        Ok((
            self.number(at, left, is_real)?,
            self.number(at, right, is_real)?,
        ))
    }

    /// True if a condition holds where a core stands.
    pub(crate) fn holds(&self, condition: &Expression, core: u32, iteration: Option<u64>) -> bool {
        let of = match iteration {
            Some(iteration) => FrameOf::Iteration(iteration),
            None => {
                let depth = self.cores[core as usize].get().marks.calls.len();
                FrameOf::Call(depth - 1)
            }
        };
        let at = self.at(core, of);
        let Some((comparison, right)) = &condition.right else {
            return self
                .number(&at, &condition.left, false)
                .is_ok_and(|value| value != 0.0);
        };
        let numbers = self.numbers(&at, &condition.left, right);
        numbers.is_ok_and(|(left, right)| comparison.holds(left, right))
    }

    /// The memory that an expression names.
    ///
    /// # Errors
    ///
    /// A sentence that says what is wrong.
    pub fn watched(&self, core: u32, of: FrameOf, text: &str) -> Result<Memory, String> {
        let expression = self.parsed(text)?;
        let named = self.find(&self.at(core, of), &expression.left)?;
        let (address, bytes, ty) = match named {
            Named::Typed(Typed {
                ty,
                address: Some(address),
                bits,
                why: None,
                ..
            }) => match bits {
                Some((unit, ..)) => (address, unit, None),
                None => (address, self.described().types[ty].size, Some(ty)),
            },
            Named::Words(_, address) => (address, 4, None),
            Named::Plain(_, value) if matches!(expression.left, Operand::Integer(_)) => {
                (value.0[0], 4, None)
            }
            _ => {
                return Err(format!(
                    "`{text}` lies nowhere in memory: it is in registers, or is no object"
                ));
            }
        };
        Ok(Memory { address, bytes, ty })
    }

    /// Bytes of memory as their type has them.
    pub(crate) fn shown_bytes(&self, bytes: &[u8], ty: Option<TypeRef>) -> String {
        let Some(ty) = ty.filter(|&ty| ty < self.described().types.len()) else {
            let bytes = bytes.iter().rev().map(|byte| format!("{byte:02x}"));
            return format!("0x{}", bytes.collect::<String>());
        };
        let bytes = Bytes::known(bytes, bytes.len() as u32);
        Writer::new(self.described()).write(ty, &bytes)
    }
}

pub(crate) fn word(bits: u32) -> V4 {
    V4([bits, 0, 0, 0])
}

fn moved(address: u32, index: i64, size: u32) -> u32 {
    address.wrapping_add((index as u32).wrapping_mul(size))
}

fn no_value(text: &str) -> String {
    format!("`{text}` has no value here")
}

fn lane_type(types: &[srp_ir::described::Type], ty: TypeRef) -> TypeRef {
    match types[ty].kind {
        Kind::Vector { lane } => lane,
        _ => ty,
    }
}
