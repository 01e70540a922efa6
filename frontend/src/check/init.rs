//! Initialisers: which value goes to which offset.

use super::Checker;
use super::constant::Constant;
use crate::ast::{self, Designator, Initialiser, InitialiserKind};
use crate::ctype::{QualType, Type, TypeId};
use crate::message::{INITIALISER, LIMIT, NOT_CONSTANT};
use crate::typed::*;
use srp_archdesc::diagnostic::Span;

/// Largest initial image of an object, bytes.
const MAX_IMAGE: u32 = 1 << 24;

/// One list in braces being gone through.
struct List<'u> {
    items: &'u [(Vec<Designator>, Initialiser)],
    at: usize,
    /// The designators of the current item were followed already.
    entered: bool,
    /// The value of the current item, where it was computed to see its type.
    value: Option<ExprId>,
}

impl<'u> List<'u> {
    fn current(&self) -> Option<&'u (Vec<Designator>, Initialiser)> {
        self.items.get(self.at)
    }

    /// The designators still to follow.
    fn path(&self) -> &'u [Designator] {
        match self.current() {
            Some((path, _)) if !self.entered => path,
            _ => &[],
        }
    }

    fn next(&mut self) {
        self.at += 1;
        self.entered = false;
        self.value = None;
    }
}

impl Checker<'_> {
    /// What an initialiser does to an object, and the object's type with its length known.
    pub(super) fn initialise(
        &mut self,
        ty: QualType,
        init: &Initialiser,
        span: Span,
    ) -> Option<(QualType, Init)> {
        let mut out = Init::default();
        let length = match *self.types.get(ty.ty) {
            Type::Array(of, None) => Some(of),
            _ => None,
        };
        if length.is_none() && !self.complete(ty.ty, span, "an object") {
            return None;
        }
        let before = self.messages.errors();
        let reached = self.whole(ty.ty, 0, init, &mut out);
        if self.messages.errors() > before {
            return None;
        }
        let ty = match length {
            Some(of) => QualType {
                ty: self.types.id(Type::Array(of, Some(reached))),
                quals: ty.quals,
            },
            None => ty,
        };
        let size = match self.types.size(ty.ty) {
            Some(size) if size <= i32::MAX as u32 => size,
            _ => {
                self.error(LIMIT, span, "the object is larger than memory", "");
                return None;
            }
        };
        let mut covered: Vec<_> = out
            .parts
            .iter()
            .map(|&(offset, e)| (offset, self.types.size(self.ty(e)).unwrap_or(0)))
            .collect();
        covered.sort_unstable();
        covered.dedup();
        let bytes: u64 = covered.iter().map(|&(_, size)| u64::from(size)).sum();
        out.zero = bytes < u64::from(size);
        Some((ty, out))
    }

    /// Initialises an object or part; the number of elements reached, for an array.
    fn whole(&mut self, ty: TypeId, offset: u32, init: &Initialiser, out: &mut Init) -> u32 {
        match &init.kind {
            InitialiserKind::Expr(e) => {
                if let Some(length) = self.string_part(ty, offset, *e, out) {
                    return length;
                }
                let value = self.value(*e);
                if let Type::Array(..) = self.types.get(ty) {
                    let text = "an array is initialised by `{ … }`";
                    self.error(INITIALISER, init.span, text, "");
                    return 0;
                }
                self.part(ty, offset, value, out);
                0
            }
            InitialiserKind::List(items) => {
                if let Some(only) = self.braced_string(ty, items) {
                    return self.string_part(ty, offset, only, out).unwrap_or(0);
                }
                let mut list = List {
                    items,
                    at: 0,
                    entered: false,
                    value: None,
                };
                if self.child_count(ty).is_none() {
                    return self.braced_scalar(ty, offset, init, items, out);
                }
                self.fill(ty, offset, &mut list, true, &[], out)
            }
        }
    }

    /// The string of `{ "text" }` for an array of characters.
    fn braced_string(
        &self,
        ty: TypeId,
        items: &[(Vec<Designator>, Initialiser)],
    ) -> Option<ast::ExprId> {
        match items {
            [(path, only)] if path.is_empty() => match only.kind {
                InitialiserKind::Expr(e) if self.takes_string(ty, e) => Some(e),
                _ => None,
            },
            _ => None,
        }
    }

    fn braced_scalar(
        &mut self,
        ty: TypeId,
        offset: u32,
        init: &Initialiser,
        items: &[(Vec<Designator>, Initialiser)],
        out: &mut Init,
    ) -> u32 {
        match items {
            [] => {}
            [(path, only)] if path.is_empty() => {
                self.whole(ty, offset, only, out);
            }
            _ => {
                let text = format!("{} takes one value", self.show(ty));
                self.error(INITIALISER, init.span, text, "");
            }
        }
        0
    }

    /// Sets a part to a value.
    fn part(&mut self, ty: TypeId, offset: u32, value: ExprId, out: &mut Init) {
        let value = self.assign_to(value, ty, "the object");
        out.parts.push((offset, value));
    }

    fn takes_string(&self, ty: TypeId, e: ast::ExprId) -> bool {
        let string = matches!(self.unit.exprs[e].kind, ast::ExprKind::Str(_));
        let chars = match self.types.get(ty) {
            Type::Array(of, _) => match self.types.get(of.ty) {
                Type::Int(int) => int.size() == 1,
                _ => false,
            },
            _ => false,
        };
        string && chars
    }

    /// Sets an array of characters to a string; its length.
    fn string_part(
        &mut self,
        ty: TypeId,
        offset: u32,
        e: ast::ExprId,
        out: &mut Init,
    ) -> Option<u32> {
        if !self.takes_string(ty, e) {
            return None;
        }
        let unit = self.unit;
        let ast::Expr { kind, span, .. } = &unit.exprs[e];
        let (ast::ExprKind::Str(bytes), Type::Array(of, length)) =
            (kind, self.types.get(ty).clone())
        else {
            return None;
        };
        let length = length.unwrap_or(bytes.len() as u32 + 1);
        if bytes.len() as u32 > length {
            let text = format!("the string has {} characters, not {length}", bytes.len());
            self.error(INITIALISER, *span, text, "");
            return Some(length);
        }
        let terminated = bytes.iter().chain([&0]).take(length as usize);
        for (i, &byte) in terminated.enumerate() {
            let value = self.int_const(byte.into(), self.types.known.int, *span);
            let value = self.convert(value, of.ty);
            out.parts.push((offset + i as u32, value));
        }
        Some(length)
    }

    /// How many parts an aggregate or vector has; `None` for a scalar. An array of unknown
    /// length takes any number.
    fn child_count(&self, ty: TypeId) -> Option<u32> {
        match self.types.get(ty) {
            Type::Array(_, length) => Some(length.unwrap_or(u32::MAX)),
            Type::Vector(_) => Some(4),
            Type::Record(record) => {
                let record = &self.types.records[*record];
                let count = record.fields.as_ref().map_or(0, Vec::len) as u32;
                Some(if record.union { count.min(1) } else { count })
            }
            _ => None,
        }
    }

    /// Type and offset of a part of an aggregate, by its number.
    fn child(&self, ty: TypeId, index: u32) -> Option<(TypeId, u32)> {
        match self.types.get(ty) {
            Type::Array(of, _) => {
                let size = self.types.size(of.ty)?;
                Some((of.ty, size.checked_mul(index)?))
            }
            Type::Vector(float) => {
                let known = self.types.known;
                Some((if *float { known.float } else { known.int }, 4 * index))
            }
            Type::Record(record) => {
                let fields = self.types.records[*record].fields.as_ref()?;
                let field = fields.get(index as usize)?;
                Some((field.ty.ty, field.offset))
            }
            _ => None,
        }
    }

    /// The number of the part that a designator names, and whether the designator is used up (it
    /// is not by an anonymous member).
    fn designated(
        &mut self,
        ty: TypeId,
        designator: &Designator,
        span: Span,
    ) -> Option<(u32, bool)> {
        match (designator, self.types.get(ty).clone()) {
            (Designator::Index(e), Type::Array(_, length)) => {
                let (index, _) = self.const_int(*e, "the index")?;
                let inside = match length {
                    Some(length) => index < length,
                    None => index <= i32::MAX as u32,
                };
                if !inside {
                    let at = self.unit.exprs[*e].span;
                    self.error(INITIALISER, at, "the index is outside the array", "");
                    return None;
                }
                Some((index, true))
            }
            (Designator::Member(name, at), Type::Record(record)) => {
                let fields = self.types.records[record]
                    .fields
                    .clone()
                    .unwrap_or_default();
                for (i, field) in fields.iter().enumerate() {
                    let inner = self.types.get(field.ty.ty);
                    match (&field.name, inner) {
                        (Some(found), _) if found == name => return Some((i as u32, true)),
                        (None, Type::Record(inner)) if self.types.field(*inner, name).is_some() => {
                            return Some((i as u32, false));
                        }
                        _ => {}
                    }
                }
                let text = format!("{} has no member `{name}`", self.show(ty));
                self.error(INITIALISER, *at, text, "");
                None
            }
            _ => {
                let text = format!("{} has no such part", self.show(ty));
                self.error(INITIALISER, span, text, "");
                None
            }
        }
    }

    /// Fills an aggregate from a list, starting where `path` says, and until it is full or, inside
    /// braces of its own, the list ends. The number of elements reached.
    fn fill(
        &mut self,
        ty: TypeId,
        offset: u32,
        list: &mut List<'_>,
        braced: bool,
        path: &[Designator],
        out: &mut Init,
    ) -> u32 {
        let (mut index, mut reached) = (0u32, 0u32);
        let mut path = path;
        while let Some((_, init)) = list.current() {
            if path.is_empty() && !list.path().is_empty() {
                if !braced {
                    break;
                }
                path = list.path();
                list.entered = true;
            }
            let designated = !path.is_empty();
            let mut rest: &[Designator] = &[];
            if let Some(first) = path.first() {
                match self.designated(ty, first, init.span) {
                    Some((found, used)) => {
                        index = found;
                        rest = if used { &path[1..] } else { path };
                    }
                    None => {
                        list.next();
                        path = &[];
                        continue;
                    }
                }
                path = &[];
            }
            let full = !designated && self.child_count(ty).is_none_or(|count| index >= count);
            let Some((child, at)) = self.child(ty, index).filter(|_| !full) else {
                if braced {
                    let text = format!("more values than {} has parts", self.show(ty));
                    self.error(INITIALISER, init.span, text, "");
                    list.at = list.items.len();
                }
                break;
            };
            let Some(at) = offset.checked_add(at).filter(|&at| at <= i32::MAX as u32) else {
                self.error(LIMIT, init.span, "the object is larger than memory", "");
                list.at = list.items.len();
                break;
            };
            if rest.is_empty() {
                self.next_part(child, at, list, out);
            } else {
                self.fill(child, at, list, false, rest, out);
            }
            index += 1;
            reached = reached.max(index);
        }
        reached
    }

    /// Initialises one part from the current item of a list, or from several where the part is an
    /// aggregate without braces of its own.
    fn next_part(&mut self, ty: TypeId, offset: u32, list: &mut List<'_>, out: &mut Init) {
        let Some((_, init)) = list.current() else {
            return;
        };
        let InitialiserKind::Expr(e) = init.kind else {
            self.whole(ty, offset, init, out);
            list.next();
            return;
        };
        if list.value.is_none() && self.string_part(ty, offset, e, out).is_some() {
            list.next();
            return;
        }
        let value = match list.value {
            Some(value) => value,
            None => {
                let value = self.value(e);
                list.value = Some(value);
                value
            }
        };
        let from = self.ty(value);
        let same = self.types.compatible(from, ty) || self.is_error(from);
        if same || self.child_count(ty).is_none_or(|count| count == 0) {
            list.next();
            return self.part(ty, offset, value, out);
        }
        // Braces left out: the part takes as many values as it has parts.
        list.entered = true;
        let before = list.at;
        self.fill(ty, offset, list, false, &[], out);
        if list.at == before {
            list.next();
        }
    }

    /// The initial image of an object from what an initialiser does.
    pub(super) fn image(&mut self, ty: TypeId, init: &Init) -> Image {
        let mut image = Image::default();
        let size = self.types.size(ty).unwrap_or(0);
        for &(offset, value) in &init.parts {
            let span = self.span(value);
            let value_ty = self.ty(value);
            let bytes = self.types.size(value_ty).unwrap_or(0);
            let end = offset.saturating_add(bytes);
            if end > size || end > MAX_IMAGE {
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
                Some(Constant::Word(bits)) => {
                    let all = bits.to_le_bytes();
                    image.bytes[range].copy_from_slice(&all[..bytes.min(4) as usize]);
                }
                Some(Constant::Vector(lanes)) => {
                    let all: Vec<u8> = lanes.iter().flat_map(|w| w.to_le_bytes()).collect();
                    image.bytes[range].copy_from_slice(&all);
                }
                Some(Constant::Address(address, more)) if bytes == 4 => {
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
