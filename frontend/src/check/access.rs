//! Places: elements, lanes, members, targets of pointers; addresses, and assignability.

use super::{Checker, Operand};
use crate::ast;
use crate::ctype::{QualType, Type, TypeId};
use crate::message::{INDEX_RANGE, MEMBER, NOT_ASSIGNABLE, OPERANDS};
use crate::typed::*;
use srp_archdesc::diagnostic::Span;

impl Checker<'_> {
    pub(super) fn index(&mut self, a: ast::ExprId, i: ast::ExprId, span: Span) -> Operand {
        let past_end = std::mem::take(&mut self.past_end);
        let base = self.operand(a);
        let base_ty = self.operand_type(base);
        if let Some(float) = self.types.vector(base_ty) {
            return self.lane(base, float, i, span);
        }
        if let (Operand::Place(place), Type::Array(of, length)) =
            (base, self.types.get(base_ty).clone())
        {
            let index = self.value(i);
            if let Some(element) = self.fixed_element(place, of, length, index, past_end, span) {
                return Operand::Place(element);
            }
            let base = self.read(base);
            return self.element(base, index, span);
        }
        let base = self.read(base);
        let index = self.value(i);
        if self.types.pointee(self.ty(index)).is_some() {
            return self.element(index, base, span);
        }
        self.element(base, index, span)
    }

    /// An element of an array at a constant index: a part of the same place.
    fn fixed_element(
        &mut self,
        place: PlaceId,
        of: QualType,
        length: Option<u32>,
        index: ExprId,
        past_end: bool,
        span: Span,
    ) -> Option<PlaceId> {
        let (length, index) = (length?, self.const_number(index)?);
        let size = self.types.size(of.ty)?;
        if (0..i128::from(length)).contains(&index) {
            let quals = of.quals.and(self.body.places[place].ty.quals);
            let ty = QualType { ty: of.ty, quals };
            let offset = index as u32 * size;
            return Some(self.place(PlaceKind::Member(place, offset), ty, span));
        }
        // The last member of a struct may stand for more than it says.
        let grows = length <= 1 && !matches!(self.body.places[place].kind, PlaceKind::Local(_));
        if (index != i128::from(length) || !past_end) && !grows {
            let text = format!("index {index} is outside the array of {length}");
            self.warning(INDEX_RANGE, span, text);
        }
        None
    }

    fn element(&mut self, base: ExprId, index: ExprId, span: Span) -> Operand {
        let pointer = self.offset(base, index, 1, span);
        Operand::Place(self.deref(pointer, span))
    }

    /// Returns the place that a pointer points to.
    pub(super) fn deref(&mut self, pointer: ExprId, span: Span) -> PlaceId {
        let ty = self.ty(pointer);
        let target = match self.types.pointee(ty) {
            Some(target) => target,
            None => {
                if !self.is_error(ty) {
                    let text = format!("{} is no pointer", self.show(ty));
                    let message = self.sources.error(OPERANDS, span, text, "");
                    let message = match self.types.get(ty) {
                        Type::Record(_) => message.help("a struct's own members are `.`"),
                        _ => message,
                    };
                    self.messages.push(message);
                }
                QualType::plain(self.types.known.error)
            }
        };
        if let ExprKind::AddressOf(place) = self.body.exprs[pointer].kind
            && self.body.places[place].ty == target
        {
            return place;
        }
        let complete = self.types.size(target.ty).is_some();
        // These are used through their address only.
        let kept = matches!(
            self.types.get(target.ty),
            Type::Function(_) | Type::Array(_, None)
        );
        if !complete && !kept && target.ty != self.types.known.void {
            let text = format!("{} is not defined here", self.show(target.ty));
            self.error(OPERANDS, span, text, "");
        }
        self.place(PlaceKind::Deref(pointer), target, span)
    }

    /// A lane of a vector.
    fn lane(&mut self, base: Operand, float: bool, i: ast::ExprId, span: Span) -> Operand {
        let known = self.types.known;
        let ty = if float { known.float } else { known.int };
        let index = self.value(i);
        if !self.types.is_integer(self.ty(index)) {
            let text = format!(
                "a lane number is an integer, not {}",
                self.show(self.ty(index))
            );
            self.error(OPERANDS, self.span(index), text, "");
            return Operand::Value(self.error_value(span));
        }
        let index = self.convert(index, known.int);
        let fixed = self.const_number(index);
        if fixed.is_some_and(|i| !(0..4).contains(&i)) {
            let text = "lanes are numbered from 0 to 3";
            self.error(OPERANDS, self.span(index), text, "");
            return Operand::Value(self.error_value(span));
        }
        match base {
            Operand::Place(place) => {
                if fixed.is_none() {
                    self.mark_in_memory(place);
                }
                let quals = self.body.places[place].ty.quals;
                let kind = PlaceKind::Lane(place, index);
                Operand::Place(self.place(kind, QualType { ty, quals }, span))
            }
            _ => {
                let base = self.read(base);
                Operand::Value(self.make(ExprKind::Lane(base, index), ty, span))
            }
        }
    }

    pub(super) fn member(
        &mut self,
        a: ast::ExprId,
        name: &str,
        at: Span,
        arrow: bool,
        span: Span,
    ) -> Operand {
        let base = if arrow {
            let pointer = self.value(a);
            self.deref(pointer, span)
        } else {
            match self.operand(a) {
                Operand::Place(place) => place,
                other => {
                    let value = self.read(other);
                    let ty = QualType::plain(self.ty(value));
                    self.place(PlaceKind::Temporary(value), ty, span)
                }
            }
        };
        let outer = self.body.places[base].ty;
        let record = match self.types.get(outer.ty) {
            Type::Record(record) => *record,
            ty => {
                if *ty != Type::Error {
                    let text = format!("{} has no members", self.show(outer.ty));
                    let message = self.sources.error(MEMBER, span, text, "");
                    let pointer = self.types.pointee(outer.ty).map(|to| self.types.get(to.ty));
                    let message = match pointer {
                        Some(Type::Record(_)) => {
                            message.help("the members of what a pointer points to are `->`")
                        }
                        _ if matches!(ty, Type::Vector(_)) => message.help(
                            "the lanes of a vector `v` are `v[0]` to `v[3]`; `srp_swizzle(v, 3, 2, 1, 0)` orders them anew",
                        ),
                        _ => message,
                    };
                    self.messages.push(message);
                }
                return Operand::Value(self.error_value(span));
            }
        };
        let Some(found) = self.types.field(record, name) else {
            let text = format!("{} has no member `{name}`", self.show(outer.ty));
            let advice = self.advice_for_member(record, name);
            self.error_advice(MEMBER, at, text, advice);
            return Operand::Value(self.error_value(span));
        };
        let ty = QualType {
            ty: found.ty.ty,
            quals: found.ty.quals.and(outer.quals),
        };
        let kind = match found.bits {
            Some(bits) => PlaceKind::Bits(base, found.offset, bits),
            None => PlaceKind::Member(base, found.offset),
        };
        Operand::Place(self.place(kind, ty, span))
    }

    pub(super) fn address(&mut self, operand: Operand, span: Span) -> ExprId {
        match operand {
            Operand::Function(..) => self.read(operand),
            Operand::Place(place) => {
                let Place { kind, ty, .. } = &self.body.places[place];
                let ty = *ty;
                if let PlaceKind::Bits(..) = kind {
                    self.error(OPERANDS, span, "a bit-field has no address", "");
                    return self.error_value(span);
                }
                if let PlaceKind::Lane(..) | PlaceKind::Temporary(_) = kind {
                    self.error(OPERANDS, span, "this has no address", "");
                    return self.error_value(span);
                }
                let pointer = self.types.pointer(ty);
                self.address_of(place, pointer, span)
            }
            Operand::Value(e) => {
                if !self.is_error(self.ty(e)) {
                    self.error(OPERANDS, span, "a value has no address", "");
                }
                self.error_value(span)
            }
        }
    }

    /// The place that an operator assigns to; an error where it cannot be assigned.
    pub(super) fn assignable(&mut self, a: ast::ExprId) -> Option<PlaceId> {
        let operand = self.operand(a);
        let at = self.unit.exprs[a].span;
        let place = match operand {
            Operand::Place(place) => place,
            Operand::Value(e) if self.is_error(self.ty(e)) => return None,
            _ => {
                self.error(NOT_ASSIGNABLE, at, "a value cannot be assigned to", "");
                return None;
            }
        };
        let ty = self.body.places[place].ty;
        let why = match self.types.get(ty.ty) {
            Type::Error => return None,
            Type::Array(..) => Some("an array cannot be assigned to"),
            Type::Void => Some("`void` cannot be assigned to"),
            Type::Function(_) => Some("a function cannot be assigned to"),
            _ if ty.quals.constant => Some("this is `const`"),
            _ if self.has_const_member(ty.ty) => Some("this has `const` members"),
            _ => None,
        };
        let temporary = self.is_temporary(place);
        let why = why.or(temporary.then_some("a value cannot be assigned to"));
        if let Some(why) = why {
            self.error(NOT_ASSIGNABLE, at, why, "");
            return None;
        }
        if let Some(local) = self.root(place) {
            self.context.assigned.push(local);
            self.context.unset.remove(&local);
        }
        Some(place)
    }

    /// True if an object of the type has a constant part.
    pub(super) fn has_const_member(&self, ty: TypeId) -> bool {
        match self.types.get(ty) {
            Type::Record(record) => self.types.records[*record].constant,
            Type::Array(of, _) => of.quals.constant || self.has_const_member(of.ty),
            _ => false,
        }
    }

    fn is_temporary(&self, mut place: PlaceId) -> bool {
        loop {
            match &self.body.places[place].kind {
                PlaceKind::Temporary(_) => return true,
                PlaceKind::Member(outer, _)
                | PlaceKind::Bits(outer, ..)
                | PlaceKind::Lane(outer, _) => place = *outer,
                _ => return false,
            }
        }
    }
}
