//! Structs, unions and enumerations.

use super::{Checker, Symbol, Tag};
use crate::ast::{Attribute, EnumSpec, Member, RecordSpec, Spec, Specs};
use crate::ctype::{
    BitRange, Field, Int, MAX_TYPE_DEPTH, QualType, Record, RecordId, Type, TypeId,
};
use crate::message::{BAD_TYPE, CONSTANT_RANGE, LIMIT, REDECLARED};
use crate::source::Name;
use crate::typed::MAX_LOCAL_ALIGN;
use srp_archdesc::diagnostic::Span;

/// A member to be laid out; a bit-field has a width.
struct Laid {
    name: Option<Name>,
    ty: QualType,
    span: Span,
    width: Option<u32>,
    /// The alignment asked for, or 1.
    align: u32,
}

/// Where a bit-field of a type of so many bytes goes that may start at bit `start`: the offset of
/// its unit, its bits there, and the first bit after it.
fn bit_field(start: u64, bytes: u32, width: u32) -> (u64, Option<BitRange>, u64) {
    let unit = 8 * u64::from(bytes);
    if width == 0 {
        return (0, None, start.next_multiple_of(unit));
    }
    let first = match start % unit + u64::from(width) > unit {
        true => start.next_multiple_of(unit),
        false => start,
    };
    // A word of a larger unit where it fits in one.
    let word = bytes == 8 && first % 32 + u64::from(width) <= 32;
    let bytes = if word { 4 } else { bytes };
    let offset = first / (8 * u64::from(bytes)) * u64::from(bytes);
    let bits = BitRange {
        unit: bytes,
        shift: (first - 8 * offset) as u32,
        width,
    };
    (offset, Some(bits), first + u64::from(width))
}

impl Checker<'_> {
    /// The type of a struct or union specifier. `alone`: nothing else is declared, so that a tag
    /// without members is declared anew in this scope.
    pub(super) fn record(&mut self, spec: &RecordSpec, span: Span, alone: bool) -> TypeId {
        let record = match &spec.tag {
            Some((tag, at)) => {
                let here = alone || spec.members.is_some();
                match self.tagged_record(tag, *at, spec.union, here) {
                    Some(record) => record,
                    None => return self.types.known.error,
                }
            }
            None => self.new_record(None, spec.union, span),
        };
        if let Some(members) = &spec.members {
            if self.types.records[record].fields.is_some() {
                let at = self.types.records[record].span;
                let tag = spec.tag.as_ref().map_or("", |(tag, _)| tag);
                let text = format!("`{tag}` is defined a second time");
                let message = self.sources.error(REDECLARED, span, text, "");
                let message = self.sources.also(message, at, "declared here");
                self.messages.push(message);
                return self.types.known.error;
            }
            self.types.records[record].span = span;
            self.members(record, members);
        }
        if !spec.attributes.is_empty() {
            self.align_record(record, &spec.attributes);
        }
        self.types.id(Type::Record(record))
    }

    /// Follows the attributes of a record.
    pub(super) fn align_record(&mut self, record: RecordId, attributes: &[Attribute]) {
        let whole = self.types.id(Type::Record(record));
        let (_, align) = self.attributed(whole, attributes);
        let span = self.types.records[record].span;
        self.set_record_align(record, align, span);
    }

    /// Gives a record at least this alignment.
    fn set_record_align(&mut self, record: RecordId, align: u32, span: Span) {
        if align > MAX_LOCAL_ALIGN {
            let text = format!("a struct is aligned to at most {MAX_LOCAL_ALIGN} bytes");
            self.error(BAD_TYPE, span, text, "");
            return;
        }
        let record = &mut self.types.records[record];
        if align > record.align {
            record.align = align;
            record.size = record.size.next_multiple_of(align);
        }
    }

    /// Gives the type that a `typedef` names an alignment, which only a struct without a tag can
    /// have, whose size it divides: another type is the same type by any name.
    pub(super) fn align_typedef(&mut self, ty: TypeId, align: u32, span: Span) {
        if align <= 1 {
            return;
        }
        match *self.types.get(ty) {
            Type::Record(record)
                if self.types.records[record].tag.is_none()
                    && self.types.records[record].size.is_multiple_of(align) =>
            {
                self.set_record_align(record, align, span);
            }
            _ if align <= self.types.align(ty) => {}
            _ => self.no_alignment(align, span),
        }
    }

    fn new_record(&mut self, tag: Option<Name>, union: bool, span: Span) -> RecordId {
        self.types.records.push(Record {
            tag,
            union,
            fields: None,
            size: 0,
            align: 1,
            nesting: 1,
            constant: false,
            span,
            unit: self.number,
        })
    }

    /// The record of a tag: that of this scope where `here`, else that of any around.
    fn tagged_record(
        &mut self,
        tag: &Name,
        span: Span,
        union: bool,
        here: bool,
    ) -> Option<RecordId> {
        let found = match here {
            true => self.scope().tags.get(tag).copied(),
            false => self.lookup_tag(tag),
        };
        match found {
            Some((Tag::Record(record), _)) if self.types.records[record].union == union => {
                Some(record)
            }
            Some((_, at)) => {
                self.other_tag(tag, span, at);
                None
            }
            None => {
                let record = self.new_record(Some(tag.clone()), union, span);
                let tag = tag.clone();
                self.scope().tags.insert(tag, (Tag::Record(record), span));
                Some(record)
            }
        }
    }

    fn other_tag(&mut self, tag: &str, span: Span, at: Span) {
        let text = format!("`{tag}` is another kind of tag");
        let message = self.sources.error(REDECLARED, span, text, "");
        let message = self.sources.also(message, at, "declared here");
        self.messages.push(message);
    }

    /// Lays out the members of a record, bit-fields as the x86-64 ABI does: one after another, each
    /// within an aligned unit of its type.
    fn members(&mut self, record: RecordId, members: &[Member]) {
        let union = self.types.records[record].union;
        let (mut fields, mut end, mut align) = (Vec::<Field>::new(), 0u64, 1u32);
        let mut spans = Vec::new();
        let list = self.member_types(members);
        let count = list.len();
        for (number, member) in list.into_iter().enumerate() {
            let Laid { name, ty, span, .. } = member;
            if let Some(name) = &name {
                let before = fields.iter().position(|f| f.name.as_ref() == Some(name));
                if let Some(before) = before {
                    let text = format!("a second member `{name}`");
                    let message = self.sources.error(REDECLARED, span, text, "");
                    let message = self.sources.also(message, spans[before], "declared here");
                    self.messages.push(message);
                    continue;
                }
            }
            let own = self.types.align(ty.ty).max(member.align);
            let flexible = matches!(self.types.get(ty.ty), Type::Array(_, None));
            if flexible && (union || number + 1 < count) {
                let text = "an array of unknown length is the last member of a struct only";
                self.error(BAD_TYPE, span, text, "");
                continue;
            }
            let bytes = u64::from(self.types.size(ty.ty).unwrap_or(0));
            let start = if union { 0 } else { end };
            let (offset, bits, after) = match member.width {
                None => {
                    let offset = start.next_multiple_of(8 * u64::from(own));
                    (offset / 8, None, offset + 8 * bytes)
                }
                Some(width) => {
                    let (offset, bits, after) = bit_field(start, bytes as u32, width);
                    (offset, bits, after)
                }
            };
            end = end.max(after);
            // Only what has a name is aligned; the rest fills.
            if member.width.is_none() || name.is_some() {
                align = align.max(own);
            }
            if member.width.is_some() && name.is_none() {
                continue;
            }
            fields.push(Field {
                name,
                ty,
                offset: u32::try_from(offset).unwrap_or(u32::MAX),
                bits,
            });
            spans.push(span);
        }
        let size = end.div_ceil(8).next_multiple_of(align.into());
        let nested = fields.iter().map(|f| self.nesting(f.ty.ty)).max();
        if size > i32::MAX as u64 || nested.unwrap_or(0) >= MAX_TYPE_DEPTH {
            let span = self.types.records[record].span;
            self.error(LIMIT, span, "the type is too large or nests too deep", "");
            fields.clear();
        }
        let constant = fields
            .iter()
            .any(|f| f.ty.quals.constant || self.has_const_member(f.ty.ty));
        let record = &mut self.types.records[record];
        record.nesting = 1 + nested.unwrap_or(0);
        record.constant = constant;
        record.fields = Some(fields);
        record.size = u32::try_from(size).unwrap_or(0);
        record.align = align;
    }

    /// How deep records and arrays nest in an object of this type.
    fn nesting(&self, ty: TypeId) -> u32 {
        match self.types.get(ty) {
            Type::Array(of, _) => 1 + self.nesting(of.ty),
            Type::Record(record) => self.types.records[*record].nesting,
            _ => 0,
        }
    }

    fn member_types(&mut self, members: &[Member]) -> Vec<Laid> {
        let mut list = Vec::new();
        for member in members {
            let base = self.specs(&member.specs, false);
            if member.declarators.is_empty() {
                let record = matches!(self.types.get(base.ty.ty), Type::Record(_));
                if record && self.complete(base.ty.ty, member.span, "a member") {
                    list.push(Laid {
                        name: None,
                        ty: base.ty,
                        span: member.span,
                        width: None,
                        align: base.align,
                    });
                } else if !self.is_error(base.ty.ty) {
                    self.error(BAD_TYPE, member.span, "a member needs a name", "");
                }
                continue;
            }
            for item in &member.declarators {
                let span = item.declarator.span;
                let ty = self.declared_type(base.ty, &item.declarator);
                let (attributed, align) = self.attributed(ty.ty, &item.attributes);
                let ty = QualType {
                    ty: attributed,
                    quals: ty.quals,
                };
                let flexible = matches!(self.types.get(ty.ty), Type::Array(_, None));
                if self.is_error(ty.ty) || !flexible && !self.complete(ty.ty, span, "a member") {
                    continue;
                }
                if ty.quals.global {
                    let text = "a member lies where its struct does";
                    let help = "`__srp_global` is for what a pointer points to";
                    self.error_help(BAD_TYPE, span, text, help);
                }
                let name = item.declarator.name.as_ref().map(|(name, _)| name.clone());
                let width = match item.width {
                    None => None,
                    Some(width) => match self.width(ty, width, span, name.is_some()) {
                        Some(width) => Some(width),
                        None => continue,
                    },
                };
                list.push(Laid {
                    name,
                    ty,
                    span,
                    width,
                    align: align.max(base.align).min(MAX_LOCAL_ALIGN),
                });
            }
        }
        list
    }

    /// The width of a bit-field; an error where it is none of its type.
    fn width(
        &mut self,
        ty: QualType,
        width: crate::ast::ExprId,
        span: Span,
        named: bool,
    ) -> Option<u32> {
        let at = self.unit.exprs[width].span;
        let (width, _) = self.const_int(width, "the width of a bit-field")?;
        let largest = match self.types.get(ty.ty) {
            Type::Bool => 1,
            Type::Int(int) => 8 * int.size(),
            _ => {
                let text = format!("a bit-field is an integer, not {}", self.show(ty.ty));
                self.error(BAD_TYPE, span, text, "");
                return None;
            }
        };
        let smallest = i128::from(named);
        if !(smallest..=i128::from(largest)).contains(&width) {
            let text = format!("the width of this bit-field is from {smallest} to {largest}");
            self.error(BAD_TYPE, at, text, "");
            return None;
        }
        u32::try_from(width).ok()
    }

    /// Ends a scope: every tag that it announced must have been declared.
    pub(super) fn close_scope(&mut self) {
        let scope = self.scopes.pop().unwrap_or_default();
        let announced = scope
            .tags
            .iter()
            .filter_map(|(tag, (kind, at))| match kind {
                Tag::Announced(_) => Some((*at, tag.clone())),
                _ => None,
            });
        let mut announced: Vec<_> = announced.collect();
        announced.sort();
        for (at, tag) in announced {
            let text = format!("the constants of `enum {tag}` are listed nowhere in its scope");
            self.error(BAD_TYPE, at, text, "");
        }
    }

    /// The place of the enumeration that some specifiers name, or that is derived from by what they name, once they are
    /// checked.
    pub(super) fn enumeration_of(&self, specs: &Specs) -> Option<Span> {
        let one = |(spec, span): &(Spec, Span)| match spec {
            Spec::Enum(spec) => match &spec.tag {
                Some((tag, _)) => self.lookup_tag(tag).map(|(_, at)| at),
                None => Some(*span),
            },
            Spec::Named(name) => {
                let (_, at) = self.lookup(name)?;
                self.enumerations.get(&at).copied()
            }
            Spec::TypeofType(name) => self.enumeration_of(&name.specs),
            _ => None,
        };
        specs.list.iter().find_map(one)
    }

    /// The integer type of an `enum` specifier: as GCC's, `unsigned` unless a constant is
    /// negative.
    pub(super) fn enumeration(&mut self, spec: &EnumSpec, span: Span) -> TypeId {
        let Some(constants) = &spec.constants else {
            let Some((tag, at)) = &spec.tag else {
                return self.types.known.error;
            };
            return match self.lookup_tag(tag) {
                Some((Tag::Enum(ty) | Tag::Announced(ty), _)) => ty,
                Some((_, other)) => {
                    self.other_tag(tag, *at, other);
                    self.types.known.error
                }
                // GNU: the constants may follow.
                None => {
                    let (tag, at) = (tag.clone(), *at);
                    let ty = self.types.known.uint;
                    self.scope().tags.insert(tag, (Tag::Announced(ty), at));
                    ty
                }
            };
        };
        let known = self.types.known;
        let (mut next, mut negative, mut ty) = (0i128, false, known.uint);
        for constant in constants {
            let value = match constant.value {
                Some(e) => match self.const_int(e, "the value of an enumeration constant") {
                    Some((value, _)) => value,
                    None => 0,
                },
                None => next,
            };
            negative |= value < 0;
            // GNU: a constant that fits no `int` has a larger type.
            let own = match value {
                _ if i32::try_from(value).is_ok() => known.int,
                _ if u32::try_from(value).is_ok() => known.uint,
                _ if i64::try_from(value).is_ok() => known.llong,
                _ => {
                    let text = "the constant does not fit in a `long long`";
                    self.error(CONSTANT_RANGE, constant.span, text, "");
                    known.int
                }
            };
            if own == known.llong {
                ty = known.llong;
            }
            next = value + 1;
            let bits = match self.types.get(own) {
                Type::Int(int) => int.wrap(value as u64),
                _ => 0,
            };
            self.declare(&constant.name, Symbol::Constant(bits, own), constant.span);
        }
        if ty == known.uint && negative {
            ty = self.types.int(Int::Int);
        }
        if let Some((tag, at)) = &spec.tag {
            let (tag, at) = (tag.clone(), *at);
            match self.scope().tags.get(&tag) {
                Some((Tag::Announced(before), _)) if *before == ty => {}
                Some(&(_, before)) => self.other_tag(&tag, span, before),
                None => {}
            }
            self.scope().tags.insert(tag, (Tag::Enum(ty), at));
        }
        ty
    }
}
