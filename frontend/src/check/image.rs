//! The bytes that an object with static storage holds at the start.

use super::Checker;
use super::constant::Constant;
use crate::ctype::{Type, TypeId};
use crate::message::{LIMIT, NOT_CONSTANT};
use crate::typed::*;

/// Largest initial image of an object, bytes.
pub(super) const MAX_IMAGE: u32 = 1 << 24;

impl Checker<'_> {
    /// True if an initial value extends into a member of unknown length.
    pub(super) fn reaches_past_end(&self, ty: TypeId, init: &Init) -> bool {
        let size = self.types.size(ty).unwrap_or(u32::MAX);
        let end = |part: &Part| {
            let ty = self.ty(part.value);
            if self.is_error(ty) {
                return 0;
            }
            let bytes = self.types.size(ty).unwrap_or(0);
            part.offset.saturating_add(bytes)
        };
        init.parts
            .iter()
            .any(|part| part.bits.is_none() && end(part) > size)
    }

    /// True if the last member of a struct has no length.
    fn is_open(&self, ty: TypeId) -> bool {
        let Type::Record(record) = self.types.get(ty) else {
            return false;
        };
        let fields = self.types.records[*record].fields.as_ref();
        let last = fields.and_then(|fields| fields.last());
        last.is_some_and(|field| match self.types.get(field.ty.ty) {
            Type::Array(_, length) => length.unwrap_or(0) == 0,
            _ => self.is_open(field.ty.ty),
        })
    }

    /// Returns the initial image of an object from its initialiser's stores.
    pub(super) fn image(&mut self, ty: TypeId, init: &Init) -> Image {
        let mut image = Image::default();
        let size = self.types.size(ty).unwrap_or(0);
        for &Part {
            offset,
            bits: field,
            value,
        } in &init.parts
        {
            let span = self.span(value);
            let value_ty = self.ty(value);
            let bytes = match field {
                Some(field) => field.unit,
                None => self.types.size(value_ty).unwrap_or(0),
            };
            let end = offset.saturating_add(bytes);
            if end > size && !self.is_open(ty) || end > MAX_IMAGE {
                self.error(LIMIT, span, "the initial value is too large", "");
                return image;
            }
            if image.bytes.len() < end as usize {
                image.bytes.resize(end as usize, 0);
            }
            let range = offset as usize..end as usize;
            image
                .addresses
                .retain(|(at, ..)| !range.contains(&(*at as usize)));
            match self.constant(value) {
                Some(Constant::Scalar(bits)) => {
                    let unit = &mut image.bytes[range];
                    let bits = match field {
                        Some(field) => field.insert(little_endian(unit), bits),
                        None => bits,
                    };
                    unit.copy_from_slice(&bits.to_le_bytes()[..bytes.min(8) as usize]);
                }
                Some(Constant::Vector(lanes)) => {
                    let all: Vec<u8> = lanes.iter().flat_map(|w| w.to_le_bytes()).collect();
                    image.bytes[range].copy_from_slice(&all);
                }
                Some(Constant::Address(address, more)) if bytes == 4 && field.is_none() => {
                    image.bytes[range].fill(0);
                    image.addresses.push((offset, address, more));
                }
                _ => {
                    if !self.constant_record(value, offset, &mut image) {
                        let text = "the initial value of a static object must be constant";
                        self.error(NOT_CONSTANT, span, text, "");
                    }
                }
            }
        }
        image
    }

    /// A struct as initial value: constant where it is an object made by `(type){ … }` at file
    /// level.
    fn constant_record(&mut self, value: ExprId, offset: u32, image: &mut Image) -> bool {
        let ExprKind::Aggregate(place) = self.body.exprs[value].kind else {
            return self.is_error(self.ty(value));
        };
        let PlaceKind::Object(object) = self.body.places[place].kind else {
            return false;
        };
        if self.objects[object].name != ".literal" {
            return false;
        }
        let inner = self.objects[object].image.clone();
        let start = offset as usize;
        image.bytes[start..start + inner.bytes.len()].copy_from_slice(&inner.bytes);
        let shifted = inner.addresses.into_iter();
        image
            .addresses
            .extend(shifted.map(|(at, address, more)| (at + offset, address, more)));
        true
    }
}

/// The number that bytes are.
fn little_endian(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .rev()
        .fold(0, |number, &byte| number << 8 | u64::from(byte))
}
