//! Initialisers: which value goes to which offset.

use super::Checker;
use super::image::MAX_IMAGE;
use crate::ast::{self, Designator, Initialiser, InitialiserKind};
use crate::ctype::{BitRange, QualType, Type, TypeId};
use crate::message::{INITIALISER, LIMIT};
use crate::typed::*;
use srp_archdesc::diagnostic::Span;

/// Zeros after a string that are set one by one.
const MAX_FILLED: u32 = 64;

/// A part of an object: its type and where it is.
#[derive(Clone, Copy)]
struct Child {
    ty: TypeId,
    offset: u32,
    bits: Option<BitRange>,
}

impl Child {
    fn whole(ty: TypeId, offset: u32) -> Child {
        Child {
            ty,
            offset,
            bits: None,
        }
    }
}

/// One list in braces being gone through.
struct List<'u> {
    items: &'u [(Vec<Designator>, Initialiser)],
    at: usize,
    /// The designators of the current item were followed already.
    entered: bool,
    /// The value of the current item, where it was computed to see its type.
    value: Option<ExprId>,
    /// The elements that a range still gives the current item to.
    repeat: Option<(u32, u32)>,
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
    /// Returns the object's type, with its length known, and the stores that its initialiser makes.
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
        let reached = self.whole(Child::whole(ty.ty, 0), init, &mut out);
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
        out.zero = !self.covers(&out, size);
        Some((ty, out))
    }

    /// True if the parts of an initial value cover every byte of an object.
    fn covers(&self, init: &Init, size: u32) -> bool {
        let range = |part: &Part| {
            let bytes = self.types.size(self.ty(part.value)).unwrap_or(0);
            (part.offset, part.offset.saturating_add(bytes))
        };
        if init.parts.iter().any(|part| part.bits.is_some()) {
            return false;
        }
        let mut ranges: Vec<_> = init.parts.iter().map(range).collect();
        ranges.sort_unstable();
        let mut end = 0;
        for (from, to) in ranges {
            if from > end {
                return false;
            }
            end = end.max(to);
        }
        end >= size
    }

    /// Initialises an object or part; the number of elements reached, for an array.
    fn whole(&mut self, child: Child, init: &Initialiser, out: &mut Init) -> u32 {
        let Child { ty, offset, .. } = child;
        match &init.kind {
            InitialiserKind::Expr(e) => {
                if let Some(length) = self.string_part(ty, offset, *e, out) {
                    return length;
                }
                if let Type::Array(..) = self.types.get(ty) {
                    return self.array_value(ty, offset, *e, init.span, out);
                }
                let value = self.value(*e);
                self.part(child, value, out);
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
                    repeat: None,
                };
                if self.child_count(ty).is_none() {
                    return self.braced_scalar(child, init, items, out);
                }
                self.fill(ty, offset, &mut list, true, &[], out)
            }
        }
    }

    /// GNU: an array is initialised by a compound literal of its type.
    fn array_value(
        &mut self,
        ty: TypeId,
        offset: u32,
        e: ast::ExprId,
        span: Span,
        out: &mut Init,
    ) -> u32 {
        let unit = self.unit;
        if let ast::ExprKind::Compound(name, list) = &unit.exprs[e].kind {
            let of = self.type_name(name).ty;
            if self.types.compatible(of, ty) {
                let length = match self.types.get(of) {
                    Type::Array(_, Some(length)) => Some(*length),
                    _ => None,
                };
                let reached = self.whole(Child::whole(of, offset), list, out);
                return length.unwrap_or(reached);
            }
        }
        let value = self.value(e);
        if !self.is_error(self.ty(value)) {
            let text = "an array is initialised by `{ … }`";
            self.error(INITIALISER, span, text, "");
        }
        0
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
        child: Child,
        init: &Initialiser,
        items: &[(Vec<Designator>, Initialiser)],
        out: &mut Init,
    ) -> u32 {
        match items {
            [] => {}
            [(path, only)] if path.is_empty() => {
                self.whole(child, only, out);
            }
            _ => {
                let text = format!("{} takes one value", self.show(child.ty));
                self.error(INITIALISER, init.span, text, "");
            }
        }
        0
    }

    /// Sets a part to a value.
    fn part(&mut self, child: Child, value: ExprId, out: &mut Init) {
        let value = self.assign_to(value, child.ty, "the object");
        out.parts.push(Part {
            offset: child.offset,
            bits: child.bits,
            value,
        });
    }

    fn takes_string(&self, ty: TypeId, e: ast::ExprId) -> bool {
        let unit = match self.unit.exprs[e].kind {
            ast::ExprKind::Str(_) => 1,
            ast::ExprKind::WideStr(_) => 4,
            _ => return false,
        };
        match self.types.get(ty) {
            Type::Array(of, _) => match self.types.get(of.ty) {
                Type::Int(int) => int.size() == unit,
                _ => false,
            },
            _ => false,
        }
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
        let (chars, size): (Vec<u32>, u32) = match kind {
            ast::ExprKind::Str(bytes) => (bytes.iter().map(|&b| b.into()).collect(), 1),
            ast::ExprKind::WideStr(chars) => (chars.to_vec(), 4),
            _ => return None,
        };
        let Type::Array(of, length) = self.types.get(ty).clone() else {
            return None;
        };
        let length = length.unwrap_or(chars.len() as u32 + 1);
        if chars.len() as u32 > length {
            let text = format!("the string has {} characters, not {length}", chars.len());
            self.error(INITIALISER, *span, text, "");
            return Some(length);
        }
        // What the string does not reach is zero, whatever was set before.
        let ended = chars.iter().copied().chain(std::iter::repeat(0));
        let few = length.min(chars.len() as u32 + MAX_FILLED);
        for (i, unit) in ended.take(few as usize).enumerate() {
            let value = self.int_const(unit.into(), self.types.known.int, *span);
            let value = self.convert(value, of.ty);
            let child = Child::whole(of.ty, offset + i as u32 * size);
            self.part(child, value, out);
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

    /// A part of an aggregate at an offset, by its number.
    fn child(&self, ty: TypeId, offset: u32, index: u32) -> Option<Child> {
        let whole = |ty, more: u32| Some(Child::whole(ty, offset.checked_add(more)?));
        match self.types.get(ty) {
            Type::Array(of, _) => {
                let size = self.types.size(of.ty)?;
                whole(of.ty, size.checked_mul(index)?)
            }
            Type::Vector(float) => {
                let known = self.types.known;
                whole(if *float { known.float } else { known.int }, 4 * index)
            }
            Type::Record(record) => {
                let fields = self.types.records[*record].fields.as_ref()?;
                let field = fields.get(index as usize)?;
                Some(Child {
                    bits: field.bits,
                    ..whole(field.ty.ty, field.offset)?
                })
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
            (Designator::Index(e) | Designator::Range(e, _), Type::Array(_, length)) => {
                let (index, _) = self.const_int(*e, "the index")?;
                let end = length.map_or(i128::from(i32::MAX), i128::from);
                let index = u32::try_from(index).ok().filter(|&i| i128::from(i) < end);
                let Some(index) = index else {
                    let at = self.unit.exprs[*e].span;
                    self.error(INITIALISER, at, "the index is outside the array", "");
                    return None;
                };
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
                let advice = self.advice_for_member(record, name);
                self.error_advice(INITIALISER, *at, text, advice);
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
                        if let Designator::Range(_, last) = first {
                            let last = self.range_end(ty, found, *last);
                            list.repeat = Some((found, last));
                            self.repeat(ty, offset, list, &path[1..], out);
                            index = last + 1;
                            reached = reached.max(index);
                            path = &[];
                            continue;
                        }
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
            let Some(child) = self.child(ty, offset, index).filter(|_| !full) else {
                if braced {
                    let text = format!("more values than {} has parts", self.show(ty));
                    self.error(INITIALISER, init.span, text, "");
                    list.at = list.items.len();
                }
                break;
            };
            if child.offset > i32::MAX as u32 {
                self.error(LIMIT, init.span, "the object is larger than memory", "");
                list.at = list.items.len();
                break;
            }
            if rest.is_empty() {
                self.next_part(child, list, out);
            } else {
                self.fill(child.ty, child.offset, list, false, rest, out);
            }
            index += 1;
            reached = reached.max(index);
        }
        reached
    }

    /// The last index of a range of elements.
    fn range_end(&mut self, ty: TypeId, first: u32, last: ast::ExprId) -> u32 {
        let length = match self.types.get(ty) {
            Type::Array(_, Some(length)) => i128::from(*length),
            _ => i128::from(MAX_IMAGE),
        };
        let at = self.unit.exprs[last].span;
        match self.const_int(last, "the index") {
            Some((last, _)) if last >= i128::from(first) && last < length => last as u32,
            Some(_) => {
                self.error(
                    INITIALISER,
                    at,
                    "the range is empty or outside the array",
                    "",
                );
                first
            }
            None => first,
        }
    }

    /// Gives the current item to each element of a range.
    fn repeat(
        &mut self,
        ty: TypeId,
        offset: u32,
        list: &mut List<'_>,
        rest: &[Designator],
        out: &mut Init,
    ) {
        let Some((first, last)) = list.repeat.take() else {
            return;
        };
        let at = list.at;
        for index in first..=last {
            list.at = at;
            list.entered = true;
            let Some(child) = self.child(ty, offset, index) else {
                break;
            };
            if out.parts.len() > MAX_IMAGE as usize / 16 {
                let span = list.items[at].1.span;
                self.error(LIMIT, span, "the initial value is too large", "");
                break;
            }
            if rest.is_empty() {
                self.next_part(child, list, out);
            } else {
                self.fill(child.ty, child.offset, list, false, rest, out);
            }
        }
        if list.at == at {
            list.next();
        }
    }

    /// Initialises one part from the current item of a list, or from several where the part is an
    /// aggregate without braces of its own.
    fn next_part(&mut self, child: Child, list: &mut List<'_>, out: &mut Init) {
        let Child { ty, offset, .. } = child;
        let Some((_, init)) = list.current() else {
            return;
        };
        let InitialiserKind::Expr(e) = init.kind else {
            self.whole(child, init, out);
            list.next();
            return;
        };
        if self.string_part(ty, offset, e, out).is_some() {
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
            return self.part(child, value, out);
        }
        // Braces left out: the part takes as many values as it has parts.
        list.entered = true;
        let before = list.at;
        self.fill(ty, offset, list, false, &[], out);
        if list.at == before {
            list.next();
        }
    }
}
