//! Structs, unions and enumerations.

use super::{Checker, Symbol, Tag};
use crate::ast::{EnumSpec, Member, RecordSpec};
use crate::ctype::{Field, Int, MAX_TYPE_DEPTH, QualType, Record, RecordId, Type, TypeId};
use crate::message::{BAD_TYPE, CONSTANT_RANGE, LIMIT, REDECLARED, UNDECLARED, UNSUPPORTED};
use crate::source::Name;
use srp_archdesc::diagnostic::Span;

impl Checker<'_> {
    /// The type of a struct or union specifier. `alone`: nothing else is declared, so that a tag
    /// without members is declared anew in this scope.
    pub(super) fn record(&mut self, spec: &RecordSpec, span: Span, alone: bool) -> TypeId {
        let plain = self.types.known.error;
        self.attributed(plain, &spec.attributes);
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
        self.types.id(Type::Record(record))
    }

    fn new_record(&mut self, tag: Option<Name>, union: bool, span: Span) -> RecordId {
        self.types.records.push(Record {
            tag,
            union,
            fields: None,
            size: 0,
            align: 1,
            span,
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

    /// Lays out the members of a record.
    fn members(&mut self, record: RecordId, members: &[Member]) {
        let union = self.types.records[record].union;
        let (mut fields, mut size, mut align) = (Vec::<Field>::new(), 0u64, 1u32);
        let mut spans = Vec::new();
        for (name, ty, span) in self.member_types(members) {
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
            let own = self.types.align(ty.ty);
            let bytes = u64::from(self.types.size(ty.ty).unwrap_or(0));
            let offset = if union {
                0
            } else {
                size.next_multiple_of(own.into())
            };
            size = if union {
                size.max(bytes)
            } else {
                offset + bytes
            };
            align = align.max(own);
            fields.push(Field {
                name,
                ty,
                offset: offset as u32,
            });
            spans.push(span);
        }
        let size = size.next_multiple_of(align.into());
        let nested = fields.iter().map(|f| self.nesting(f.ty.ty)).max();
        if size > i32::MAX as u64 || nested.unwrap_or(0) >= MAX_TYPE_DEPTH {
            let span = self.types.records[record].span;
            self.error(LIMIT, span, "the type is too large or nests too deep", "");
            fields.clear();
        }
        let record = &mut self.types.records[record];
        record.fields = Some(fields);
        record.size = u32::try_from(size).unwrap_or(0);
        record.align = align;
    }

    /// How deep records and arrays nest in an object of this type.
    fn nesting(&self, ty: TypeId) -> u32 {
        match self.types.get(ty) {
            Type::Array(of, _) => 1 + self.nesting(of.ty),
            Type::Record(record) => {
                let fields = self.types.records[*record].fields.as_deref();
                let inner = fields.unwrap_or(&[]).iter().map(|f| self.nesting(f.ty.ty));
                1 + inner.max().unwrap_or(0)
            }
            _ => 0,
        }
    }

    fn member_types(&mut self, members: &[Member]) -> Vec<(Option<Name>, QualType, Span)> {
        let mut list = Vec::new();
        for member in members {
            let base = self.specs(&member.specs, false);
            if member.declarators.is_empty() {
                let record = matches!(self.types.get(base.ty.ty), Type::Record(_));
                if record && self.complete(base.ty.ty, member.span, "a member") {
                    list.push((None, base.ty, member.span));
                } else if !self.is_error(base.ty.ty) {
                    self.error(BAD_TYPE, member.span, "a member needs a name", "");
                }
                continue;
            }
            for item in &member.declarators {
                let span = item.declarator.span;
                if let Some(width) = item.width {
                    let at = span.to(self.unit.exprs[width].span);
                    self.error(UNSUPPORTED, at, "bit-fields are not supported", "");
                    continue;
                }
                let ty = self.declared_type(base.ty, &item.declarator);
                let ty = QualType {
                    ty: self.attributed(ty.ty, &item.attributes),
                    quals: ty.quals,
                };
                if self.is_error(ty.ty) || !self.complete(ty.ty, span, "a member") {
                    continue;
                }
                if ty.quals.global {
                    let text = "a member lies where its struct does";
                    let help = "`__srp_global` is for what a pointer points to";
                    self.error_help(BAD_TYPE, span, text, help);
                }
                let name = item.declarator.name.as_ref().map(|(name, _)| name.clone());
                list.push((name, ty, span));
            }
        }
        list
    }

    /// The integer type of an `enum` specifier: as GCC's, `unsigned` unless a constant is
    /// negative.
    pub(super) fn enumeration(&mut self, spec: &EnumSpec, span: Span) -> TypeId {
        let Some(constants) = &spec.constants else {
            let Some((tag, at)) = &spec.tag else {
                return self.types.known.error;
            };
            return match self.lookup_tag(tag) {
                Some((Tag::Enum(ty), _)) => ty,
                Some((_, other)) => {
                    self.other_tag(tag, *at, other);
                    self.types.known.error
                }
                None => {
                    let text = format!("`enum {tag}` is not defined");
                    self.error(UNDECLARED, *at, text, "");
                    self.types.known.error
                }
            };
        };
        let int = self.types.known.int;
        let (mut next, mut negative) = (Some(0i32), false);
        for constant in constants {
            let value = match constant.value {
                Some(e) => self.const_int(e, "the value of an enumeration constant"),
                None => next.map(|value| (value as u32, int)),
            };
            let value = match value {
                Some((bits, ty)) if !self.types.is_unsigned(ty) || bits <= i32::MAX as u32 => {
                    bits as i32
                }
                None if constant.value.is_some() => 0,
                _ => {
                    let text = "the constant does not fit in an `int`";
                    self.error(CONSTANT_RANGE, constant.span, text, "");
                    0
                }
            };
            negative |= value < 0;
            next = value.checked_add(1);
            self.declare(
                &constant.name,
                Symbol::Constant(value as u32, int),
                constant.span,
            );
        }
        let ty = self.types.int(if negative { Int::Int } else { Int::UInt });
        if let Some((tag, at)) = &spec.tag {
            let (tag, at) = (tag.clone(), *at);
            if let Some(&(_, before)) = self.scope().tags.get(&tag) {
                self.other_tag(&tag, span, before);
            }
            self.scope().tags.insert(tag, (Tag::Enum(ty), at));
        }
        ty
    }
}
