//! Values as C has them: bytes with a type, written as debuggers write them.

use srp_ir::described::{Described, Field, Kind, TypeRef};

/// Most elements of arrays that are written.
pub(crate) const MOST: usize = 200;

/// How deep records and arrays in each other are written.
const DEEPEST: u32 = 16;

/// Bytes, as far as they are known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Bytes(Vec<Option<u8>>);

impl Bytes {
    pub(crate) fn unknown(size: u32) -> Bytes {
        Bytes(vec![None; size as usize])
    }

    /// The bytes that there are of this many.
    pub(crate) fn known(bytes: &[u8], size: u32) -> Bytes {
        let mut known = Bytes::unknown(size);
        known.set(0, bytes);
        known
    }

    pub(crate) fn set(&mut self, offset: u32, bytes: &[u8]) {
        for (to, byte) in self.0.iter_mut().skip(offset as usize).zip(bytes) {
            *to = Some(*byte);
        }
    }

    /// A part of them.
    pub(crate) fn part(&self, offset: u32, size: u32) -> Bytes {
        let mut part = Bytes::unknown(size);
        for (to, byte) in part.0.iter_mut().zip(self.0.iter().skip(offset as usize)) {
            *to = *byte;
        }
        part
    }

    pub(crate) fn are_all_unknown(&self) -> bool {
        self.0.iter().all(Option::is_none)
    }

    /// The first as a number, the lowest byte first, where all of them are known.
    pub(crate) fn number(&self, size: u32) -> Option<u64> {
        let bytes = self.0.get(..size.min(8) as usize)?;
        let shifted = |(i, byte): (u32, &Option<u8>)| Some(u64::from((*byte)?) << (8 * i));
        (0..).zip(bytes).map(shifted).sum()
    }
}

/// The bits of a bit-field, extended to a number of its type.
pub(crate) fn field_bits(
    bytes: &Bytes,
    (unit, shift, width): (u32, u32, u32),
    signed: bool,
) -> Option<i128> {
    let bits = bytes.number(unit)? >> shift & (u64::MAX >> (64 - width));
    Some(extended(bits, width, signed))
}

fn extended(bits: u64, width: u32, signed: bool) -> i128 {
    match signed && width > 0 && bits >> (width - 1) & 1 == 1 {
        true => i128::from(bits) - (1i128 << width),
        false => i128::from(bits),
    }
}

/// A number of a type, where it is one.
pub(crate) fn number(described: &Described, ty: TypeRef, bytes: &Bytes) -> Option<f64> {
    let data = &described.types[ty];
    let bits = bytes.number(data.size)?;
    match data.kind {
        Kind::Integer { signed, .. } => Some(extended(bits, 8 * data.size, signed) as f64),
        Kind::Float => Some(f64::from(f32::from_bits(bits as u32))),
        Kind::Double => Some(f64::from_bits(bits)),
        Kind::Pointer { .. } => Some(bits as f64),
        _ => None,
    }
}

/// A float as it reads back; without a fraction it keeps its point.
fn float(value: f32) -> String {
    format!("{value:?}")
}

/// Writes values of one expression: of all arrays together only so many elements.
pub(crate) struct Writer<'a> {
    described: &'a Described,
    left: usize,
}

impl<'a> Writer<'a> {
    pub(crate) fn new(described: &'a Described) -> Writer<'a> {
        let left = MOST;
        Writer { described, left }
    }

    /// A value.
    pub(crate) fn write(&mut self, ty: TypeRef, bytes: &Bytes) -> String {
        self.value(ty, bytes, DEEPEST)
    }

    fn value(&mut self, ty: TypeRef, bytes: &Bytes, deep: u32) -> String {
        let described = self.described;
        let data = &described.types[ty];
        match &data.kind {
            Kind::Record(fields) => {
                let fields = fields.iter().map(|field| self.field(field, bytes, deep));
                let fields: Vec<String> = fields.collect();
                format!("{{{}}}", fields.join(", "))
            }
            Kind::Array { .. } if deep == 0 => "{...}".to_owned(),
            Kind::Array { of, length } => self.array(*of, *length, bytes, deep),
            Kind::Vector { lane } => {
                let lanes = (0..4).map(|n| self.value(*lane, &bytes.part(4 * n, 4), deep));
                let lanes: Vec<String> = lanes.collect();
                format!("{{{}}}", lanes.join(", "))
            }
            _ => self.scalar(ty, bytes),
        }
    }

    fn scalar(&self, ty: TypeRef, bytes: &Bytes) -> String {
        let data = &self.described.types[ty];
        let Some(bits) = bytes.number(data.size) else {
            return "?".to_owned();
        };
        match data.kind {
            Kind::Integer { is_bool: true, .. } => (bits != 0).to_string(),
            Kind::Integer {
                signed, is_char, ..
            } => {
                let value = extended(bits, 8 * data.size, signed);
                match is_char {
                    true => format!("{value} '{}'", std::ascii::escape_default(bits as u8)),
                    false => value.to_string(),
                }
            }
            Kind::Float => float(f32::from_bits(bits as u32)),
            Kind::Double => format!("{:?}", f64::from_bits(bits)),
            Kind::Pointer { .. } => format!("({}) {bits:#x}", data.name),
            _ => format!("({}) of no value", data.name),
        }
    }

    fn field(&mut self, field: &Field, bytes: &Bytes, deep: u32) -> String {
        let data = &self.described.types[field.ty];
        let value = match (field.bits, &data.kind) {
            (Some(bits), kind) => {
                let signed = matches!(kind, Kind::Integer { signed: true, .. });
                let value = field_bits(&bytes.part(field.offset, bits.0), bits, signed);
                value.map_or("?".to_owned(), |value| value.to_string())
            }
            (None, Kind::Record(_)) if deep == 0 => "{...}".to_owned(),
            _ => self.value(
                field.ty,
                &bytes.part(field.offset, data.size),
                deep.saturating_sub(1),
            ),
        };
        match field.name.as_str() {
            "" => value,
            name => format!("{name} = {value}"),
        }
    }

    fn array(&mut self, of: TypeRef, length: u32, bytes: &Bytes, deep: u32) -> String {
        let data = &self.described.types[of];
        if matches!(data.kind, Kind::Integer { is_char: true, .. })
            && let Some(text) = self.text(length, bytes)
        {
            return text;
        }
        let is_leaf = !matches!(data.kind, Kind::Array { .. } | Kind::Record(_));
        let mut elements = Vec::new();
        for n in 0..length {
            if self.left == 0 {
                elements.push(format!("... of {length}"));
                break;
            }
            if is_leaf {
                self.left -= 1;
            }
            let part = bytes.part(n * data.size, data.size);
            elements.push(self.value(of, &part, deep - 1));
            if !is_leaf {
                self.left = self.left.saturating_sub(1);
            }
        }
        format!("{{{}}}", elements.join(", "))
    }

    /// Characters up to the zeros at the end.
    fn text(&mut self, length: u32, bytes: &Bytes) -> Option<String> {
        let all: Vec<u8> = bytes.0.iter().copied().collect::<Option<_>>()?;
        let end = all
            .iter()
            .rposition(|&byte| byte != 0)
            .map_or(0, |last| last + 1);
        let shown = end.min(self.left);
        self.left -= shown;
        let mut text = String::new();
        for &byte in &all[..shown] {
            text.extend(std::ascii::escape_default(byte).map(char::from));
        }
        let more = if shown < end {
            format!("... of {length}")
        } else {
            String::new()
        };
        Some(format!("\"{text}\"{more}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use srp_ir::described::Type;

    #[test]
    fn long_arrays_are_cut_and_unknown_bytes_are_marked() {
        let int = Kind::Integer {
            signed: true,
            is_bool: false,
            is_char: false,
        };
        let of = |name: &str, size, kind| Type {
            name: name.to_owned(),
            size,
            kind,
        };
        let described = Described {
            types: vec![
                of("int", 4, int),
                of("int [300]", 1200, Kind::Array { of: 0, length: 300 }),
            ],
            ..Described::default()
        };
        let mut bytes = Bytes::unknown(1200);
        bytes.set(4, &(-7i32).to_le_bytes());
        let text = Writer::new(&described).write(1, &bytes);
        assert!(text.starts_with("{?, -7, ?, "), "{text}");
        assert!(text.ends_with(", ... of 300}"), "{text}");
        assert_eq!(text.matches(", ").count(), MOST);
        assert_eq!(number(&described, 0, &bytes.part(4, 4)), Some(-7.0));
        assert_eq!(number(&described, 0, &bytes.part(0, 4)), None);
        // Three bits from the second on.
        assert_eq!(
            field_bits(&Bytes::known(&[0b1011], 1), (1, 1, 3), true),
            Some(-3)
        );
    }
}
