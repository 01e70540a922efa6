//! Conversions.

use super::constant::Constant;
use super::{Checker, Operand};
use crate::ctype::{Int, QualType, Quals, Type, TypeId};
use crate::message::{
    CONVERSION, DISCARDED_QUALIFIER, OPERANDS, OVERFLOW, POINTER_SIGN, POINTER_TYPES,
};
use crate::typed::*;

impl Checker<'_> {
    /// An operand as a value: places are read, arrays and functions become pointers.
    pub(super) fn read(&mut self, operand: Operand) -> ExprId {
        match operand {
            Operand::Value(e) => e,
            Operand::Function(function, span) => {
                let ty = QualType::plain(self.functions[function].ty);
                let pointer = self.types.pointer(ty);
                self.make(ExprKind::Function(function), pointer, span)
            }
            Operand::Place(place) => {
                let Place { kind, span, .. } = &self.body.places[place];
                if let PlaceKind::Local(local) = *kind {
                    self.suspect_read(local, *span);
                }
                self.read_place(place)
            }
        }
    }

    pub(super) fn read_place(&mut self, place: PlaceId) -> ExprId {
        let Place { ty, span, .. } = self.body.places[place];
        match *self.types.get(ty.ty) {
            Type::Array(of, _) => {
                let element = QualType {
                    ty: of.ty,
                    quals: of.quals.and(ty.quals),
                };
                let pointer = self.types.pointer(element);
                self.address_of(place, pointer, span)
            }
            Type::Function(_) => {
                let pointer = self.types.pointer(ty);
                match self.body.places[place].kind {
                    PlaceKind::Deref(target) => target,
                    _ => self.make(ExprKind::AddressOf(place), pointer, span),
                }
            }
            Type::Record(_) => self.make(ExprKind::Aggregate(place), ty.ty, span),
            // What computes the pointer still happens.
            Type::Void => match self.body.places[place].kind {
                PlaceKind::Deref(pointer) => self.make(ExprKind::Convert(pointer), ty.ty, span),
                _ => self.make(ExprKind::Const(0), ty.ty, span),
            },
            _ => {
                let value = self.make(ExprKind::Load(place), ty.ty, span);
                self.narrowed(place, value)
            }
        }
    }

    /// The value of a bit-field of less bits than an `int` as the `int` that it promotes to, of more
    /// bits in the type of that many.
    fn narrowed(&mut self, place: PlaceId, value: ExprId) -> ExprId {
        let PlaceKind::Bits(_, _, bits) = self.body.places[place].kind else {
            return value;
        };
        let own = match *self.types.get(self.ty(value)) {
            Type::Int(own) => own,
            _ => return value,
        };
        let narrow = match bits.width {
            ..=31 => Int::Int,
            32 if own.size() == 8 => Int::of_size(4, own.signed()),
            width @ 33..=63 => Int::of_width(width, own.signed()),
            _ => return value,
        };
        let narrow = self.types.int(narrow);
        self.convert(value, narrow)
    }

    /// The address of a place as a pointer of this type.
    pub(super) fn address_of(
        &mut self,
        place: PlaceId,
        pointer: TypeId,
        span: srp_archdesc::diagnostic::Span,
    ) -> ExprId {
        self.mark_in_memory(place);
        if let PlaceKind::Deref(target) = self.body.places[place].kind {
            if self.ty(target) == pointer {
                return target;
            }
            return self.make(ExprKind::Convert(target), pointer, span);
        }
        // A member of what a constant address points to is a constant too, as in `offsetof`.
        let kind = match self.constant_address(place, 0) {
            Some(Constant::Scalar(bits)) => ExprKind::Const(bits),
            _ => ExprKind::AddressOf(place),
        };
        self.make(kind, pointer, span)
    }

    /// Notes that the variable of a place must have an address.
    pub(super) fn mark_in_memory(&mut self, place: PlaceId) {
        if let Some(local) = self.root(place) {
            self.body.locals[local].in_memory = true;
            self.context.unset.remove(&local);
        }
        let mut root = place;
        while let PlaceKind::Member(outer, _) | PlaceKind::Lane(outer, _) =
            self.body.places[root].kind
        {
            root = outer;
        }
        if let PlaceKind::Temporary(e) = self.body.places[root].kind {
            self.body.places[root].kind = PlaceKind::Stored(e);
        }
    }

    /// The variable that a place is a part of.
    pub(super) fn root(&self, mut place: PlaceId) -> Option<LocalId> {
        loop {
            match &self.body.places[place].kind {
                PlaceKind::Local(local) | PlaceKind::Literal(local, _) => return Some(*local),
                PlaceKind::Member(outer, _)
                | PlaceKind::Bits(outer, ..)
                | PlaceKind::Lane(outer, _) => place = *outer,
                PlaceKind::Object(_)
                | PlaceKind::Deref(_)
                | PlaceKind::Temporary(_)
                | PlaceKind::Stored(_) => return None,
            }
        }
    }

    /// A value in another type that it is known to convert to.
    pub(super) fn convert(&mut self, e: ExprId, ty: TypeId) -> ExprId {
        let from = self.ty(e);
        if from == ty || self.is_error(from) || self.is_error(ty) {
            return e;
        }
        let span = self.span(e);
        self.make(ExprKind::Convert(e), ty, span)
    }

    /// The integer promotions.
    pub(super) fn promoted(&self, ty: TypeId) -> TypeId {
        match self.types.get(ty) {
            Type::Bool => self.types.known.int,
            Type::Int(int) if int.size() < 4 => self.types.known.int,
            _ => ty,
        }
    }

    pub(super) fn promote(&mut self, e: ExprId) -> ExprId {
        let ty = self.promoted(self.ty(e));
        self.convert(e, ty)
    }

    /// The usual arithmetic conversions of two arithmetic types.
    pub(super) fn common(&mut self, a: TypeId, b: TypeId) -> TypeId {
        let (a, b) = (self.promoted(a), self.promoted(b));
        match (self.types.get(a), self.types.get(b)) {
            (Type::Error, _) | (_, Type::Error) => self.types.known.error,
            (Type::Double, _) | (_, Type::Double) => self.types.known.double,
            (Type::Float, _) | (_, Type::Float) => self.types.known.float,
            (&Type::Int(x), &Type::Int(y)) if x.size().max(y.size()) == 8 => {
                let most = x.width().max(y.width());
                let unsigned = |int: Int| int.width() == most && !int.signed();
                let signed = !unsigned(x) && !unsigned(y);
                self.types.int(Int::of_width(most, signed))
            }
            (Type::Int(x), Type::Int(y)) => {
                let long = [x, y].iter().any(|i| matches!(i, Int::Long | Int::ULong));
                let unsigned = !x.signed() || !y.signed();
                let int = match (long, unsigned) {
                    (false, false) => Int::Int,
                    (false, true) => Int::UInt,
                    (true, false) => Int::Long,
                    (true, true) => Int::ULong,
                };
                self.types.int(int)
            }
            _ => a,
        }
    }

    /// True if a value is a null pointer constant.
    fn is_null(&self, e: ExprId) -> bool {
        let pointee = self.types.pointee(self.ty(e));
        let void = pointee.is_some_and(|to| to == QualType::plain(self.types.known.void));
        self.const_value(e) == Some(0) && (void || self.types.is_integer(self.ty(e)))
    }

    /// A value converted as by assignment; `what` names what it is for.
    pub(super) fn assign_to(&mut self, e: ExprId, to: TypeId, what: &str) -> ExprId {
        let from = self.ty(e);
        if from == to || self.is_error(from) || self.is_error(to) {
            return e;
        }
        let arithmetic = self.types.is_arithmetic(from) && self.types.is_arithmetic(to);
        let to_bool = *self.types.get(to) == Type::Bool && self.types.pointee(from).is_some();
        if arithmetic || to_bool {
            self.warn_overflow(e, to);
            return self.convert(e, to);
        }
        if self.types.pointee(to).is_some() {
            return self.assign_pointer(e, to, what);
        }
        if let (Type::Record(_), Type::Record(_)) = (self.types.get(from), self.types.get(to))
            && self.types.compatible(from, to)
        {
            return e;
        }
        let span = self.span(e);
        let text = format!("{what} is {}, not {}", self.show(to), self.show(from));
        let message = self.sources.error(CONVERSION, span, text, "");
        let message = match self.conversion_help(from, to) {
            Some(help) => message.help(help),
            None => message,
        };
        self.messages.push(message);
        self.error_value(span)
    }

    /// Warns of a constant that has more bits than the integer type it is converted to.
    fn warn_overflow(&mut self, e: ExprId, to: TypeId) {
        let (Some(number), Type::Int(int)) = (self.const_number(e), self.types.get(to)) else {
            return;
        };
        let bits = int.width();
        if number < -(1 << (bits - 1)) || number >= 1 << bits {
            let text = format!("{number} does not fit in {}", self.show(to));
            let span = self.span(e);
            self.warning(OVERFLOW, span, text);
        }
    }

    fn conversion_help(&self, from: TypeId, to: TypeId) -> Option<&'static str> {
        match (self.types.get(from), self.types.get(to)) {
            (Type::Float, Type::Vector(true)) => Some("`srp_splat` puts a float in all lanes"),
            (_, Type::Vector(false)) if self.types.is_integer(from) => {
                Some("`srp_splati` puts an int in all lanes")
            }
            (Type::Vector(false), Type::Vector(true)) => {
                Some("`srp_itof4` converts the lanes, `srp_asfloat4` keeps their bits")
            }
            (Type::Vector(true), Type::Vector(false)) => {
                Some("`srp_ftoi4` converts the lanes, `srp_bits4` keeps their bits")
            }
            (Type::Vector(_), _) => Some("`v[i]` is lane i"),
            (Type::Pointer(_), _) if self.types.is_integer(to) => {
                Some("a cast makes an integer of a pointer")
            }
            _ => None,
        }
    }

    fn assign_pointer(&mut self, e: ExprId, to: TypeId, what: &str) -> ExprId {
        if self.is_null(e) {
            return self.convert(e, to);
        }
        let (from, span) = (self.ty(e), self.span(e));
        let (Some(source), Some(target)) = (self.types.pointee(from), self.types.pointee(to))
        else {
            let text = format!("{what} is {}, not {}", self.show(to), self.show(from));
            let help = match self.types.is_integer(from) {
                true => "a cast makes a pointer of an integer",
                false => "only pointers and 0 convert to a pointer",
            };
            self.error_help(CONVERSION, span, text, help);
            return self.error_value(span);
        };
        // Qualifiers of the elements are as good as those of the array (C23 6.7.4.1).
        let (source, target) = (self.types.bare(source), self.types.bare(target));
        if source.quals.global != target.quals.global && !self.is_function(source.ty) {
            let text = format!("{what} is {}, not {}", self.show(to), self.show(from));
            let help = "pointers to SRAM and to system memory do not convert to each other";
            self.error_help(CONVERSION, span, text, help);
            return self.error_value(span);
        }
        let void = self.types.known.void;
        let either_void = source.ty == void || target.ty == void;
        if !either_void && self.same_size_integers(source.ty, target.ty) {
            let text = format!("{what} is {}, not {}", self.show(to), self.show(from));
            self.warning(POINTER_SIGN, span, text);
        } else if !either_void && !self.types.compatible(source.ty, target.ty) {
            let text = format!("{what} is {}, not {}", self.show(to), self.show(from));
            self.error_help(CONVERSION, span, text, "a cast converts between pointers");
            return self.error_value(span);
        }
        if !target.quals.covers(source.quals) {
            let text = format!("{} loses qualifiers as {}", self.show(from), self.show(to));
            self.warning(DISCARDED_QUALIFIER, span, text);
        }
        self.convert(e, to)
    }

    /// True if two types are different integers of one size.
    fn same_size_integers(&self, a: TypeId, b: TypeId) -> bool {
        match (self.types.get(a), self.types.get(b)) {
            (Type::Int(x), Type::Int(y)) => x != y && x.size() == y.size(),
            _ => false,
        }
    }

    fn is_function(&self, ty: TypeId) -> bool {
        matches!(self.types.get(ty), Type::Function(_))
    }

    /// A value converted by a cast.
    pub(super) fn cast(
        &mut self,
        e: ExprId,
        to: TypeId,
        span: srp_archdesc::diagnostic::Span,
    ) -> ExprId {
        let from = self.ty(e);
        if self.is_error(from) || self.is_error(to) {
            return self.error_value(span);
        }
        if to == self.types.known.void {
            return self.make(ExprKind::Convert(e), to, span);
        }
        if let Some(value) = self.union_of(e, to, span) {
            return value;
        }
        let pointers = (self.types.pointee(from), self.types.pointee(to));
        let fits = match pointers {
            (Some(a), Some(b)) => {
                if a.quals.global != b.quals.global && !self.is_null(e) {
                    let text = format!("{} does not convert to {}", self.show(from), self.show(to));
                    let help = "pointers to SRAM and to system memory are different; \
                                an address in system memory is an `unsigned`";
                    self.error_help(CONVERSION, span, text, help);
                    return self.error_value(span);
                }
                true
            }
            (Some(_), None) => self.types.is_integer(to),
            (None, Some(_)) => self.types.is_integer(from),
            (None, None) => {
                self.types.is_arithmetic(from) && self.types.is_arithmetic(to)
                    || self.types.vector(from).is_some() && self.types.vector(to).is_some()
                    || from == to && matches!(self.types.get(to), Type::Record(_))
            }
        };
        if !fits {
            let text = format!("{} does not convert to {}", self.show(from), self.show(to));
            let message = self.sources.error(CONVERSION, span, text, "");
            let message = match self.conversion_help(from, to) {
                Some(help) => message.help(help),
                None => message,
            };
            self.messages.push(message);
            return self.error_value(span);
        }
        if from == to {
            return e;
        }
        self.make(ExprKind::Convert(e), to, span)
    }

    /// GNU: a value as the member of its type of a union.
    fn union_of(
        &mut self,
        e: ExprId,
        to: TypeId,
        span: srp_archdesc::diagnostic::Span,
    ) -> Option<ExprId> {
        let from = self.ty(e);
        let Type::Record(record) = *self.types.get(to) else {
            return None;
        };
        let record = &self.types.records[record];
        if !record.union || from == to {
            return None;
        }
        let fields = record.fields.as_deref().unwrap_or(&[]);
        let mut members = fields.iter().filter(|field| field.bits.is_none());
        members.find(|field| self.types.compatible(field.ty.ty, from))?;
        self.context.function.as_ref()?;
        let ty = QualType::plain(to);
        let local = self.body.locals.push(Local {
            name: "literal".into(),
            ty,
            in_memory: false,
            align: 1,
        });
        let init = Init {
            zero: self.types.size(from) != self.types.size(to),
            parts: vec![Part {
                offset: 0,
                bits: None,
                value: e,
            }],
        };
        let place = self.place(PlaceKind::Literal(local, init), ty, span);
        Some(self.read_place(place))
    }

    /// A condition: any scalar.
    pub(super) fn condition(&mut self, e: crate::ast::ExprId) -> ExprId {
        let value = self.value(e);
        self.require_scalar(value, "a condition")
    }

    /// The value, if it is a scalar; else an error.
    pub(super) fn require_scalar(&mut self, e: ExprId, what: &str) -> ExprId {
        let (ty, span) = (self.ty(e), self.span(e));
        if self.types.is_scalar(ty) {
            return e;
        }
        let text = format!("{what} must be a number or pointer, not {}", self.show(ty));
        match self.types.vector(ty) {
            Some(_) => {
                let help = "a relation of vectors is a mask: `srp_blend` selects lane by lane";
                self.error_help(OPERANDS, span, text, help);
            }
            None => self.error(OPERANDS, span, text, ""),
        }
        self.error_value(span)
    }

    /// Returns the common type of two pointers, for relations and `?:`; `None` if there is none.
    pub(super) fn common_pointer(&mut self, a: ExprId, b: ExprId) -> Option<TypeId> {
        let (ta, tb) = (self.ty(a), self.ty(b));
        let pointees = (self.types.pointee(ta), self.types.pointee(tb));
        match pointees {
            (Some(_), _) if self.is_null(b) => Some(ta),
            (_, Some(_)) if self.is_null(a) => Some(tb),
            (Some(x), Some(y)) if x.quals.global == y.quals.global => {
                let void = self.types.known.void;
                let ty = if self.types.compatible(x.ty, y.ty) {
                    x.ty
                } else {
                    if x.ty != void && y.ty != void {
                        let span = self.span(b);
                        let text = format!(
                            "{} and {} point to different things",
                            self.show(ta),
                            self.show(tb)
                        );
                        self.warning(POINTER_TYPES, span, text);
                    }
                    void
                };
                let quals = Quals {
                    restrict: false,
                    ..x.quals.and(y.quals)
                };
                Some(self.types.pointer(QualType { ty, quals }))
            }
            _ => None,
        }
    }
}
