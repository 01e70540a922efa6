//! Expressions.

use super::{Checker, Operand, Symbol};
use crate::ast::{self, Prefix};
use crate::ctype::{Int, QualType, Type, TypeId};
use crate::message::{
    CONSTANT_RANGE, INDEX_RANGE, MEMBER, NOT_ASSIGNABLE, OPERANDS, UNDECLARED, UNSUPPORTED,
};
use crate::token::{FloatConst, IntConst};
use crate::typed::*;
use srp_archdesc::diagnostic::Span;

impl Checker<'_> {
    /// An expression as a value.
    pub(super) fn value(&mut self, e: ast::ExprId) -> ExprId {
        let operand = self.operand(e);
        self.read(operand)
    }

    /// An expression.
    pub(super) fn operand(&mut self, e: ast::ExprId) -> Operand {
        let unit = self.unit;
        let ast::Expr { kind, span, .. } = &unit.exprs[e];
        let span = *span;
        use ast::ExprKind as K;
        let value = match kind {
            K::Int(int) => self.int(*int, span),
            K::Float(FloatConst::Single(bits)) => {
                let ty = self.types.known.float;
                self.make(ExprKind::Const(*bits), ty, span)
            }
            K::Float(_) => {
                let text = "`double` constants are not supported";
                self.error_help(
                    UNSUPPORTED,
                    span,
                    text,
                    "write it with `f` at the end: `0.5f`",
                );
                self.error_value(span)
            }
            K::Char(value) => self.int_const(*value as u32, self.types.known.int, span),
            K::Str(bytes) => return Operand::Place(self.string(bytes, span)),
            K::Name(name) => return self.name(name, span),
            K::Call(callee, args) => self.call(*callee, args, span),
            K::Index(a, i) => return self.index(*a, *i, span),
            K::Member(a, name, at, arrow) => return self.member(*a, name, *at, *arrow, span),
            K::Prefix(op, a) => return self.prefix(*op, *a, span),
            K::Postfix(a, step) => self.step(*a, *step, true, span),
            K::Cast(name, a) => {
                let ty = self.type_name(name);
                let a = self.value(*a);
                self.cast(a, ty.ty, span)
            }
            K::SizeofExpr(a) => {
                let operand = self.operand(*a);
                let ty = self.operand_type(operand);
                self.size_of(ty, span)
            }
            K::SizeofType(name) => {
                let ty = self.type_name(name).ty;
                self.size_of(ty, span)
            }
            K::AlignofType(name) => {
                let ty = self.type_name(name).ty;
                let align = self.types.align(ty);
                self.int_const(align, self.types.known.uint, span)
            }
            K::Compound(name, init) => {
                let ty = self.type_name(name);
                return self.compound_literal(ty, init, span);
            }
            K::Infix(..) => self.chain(e),
            K::Assign(op, a, v) => self.assign(*op, *a, *v, span),
            K::Conditional(c, a, b) => self.conditional(*c, *a, *b, span),
            K::Error => self.error_value(span),
        };
        Operand::Value(value)
    }

    /// The type of an operand before it is read.
    fn operand_type(&self, operand: Operand) -> TypeId {
        match operand {
            Operand::Place(place) => self.body.places[place].ty.ty,
            Operand::Function(function, _) => self.functions[function].ty,
            Operand::Value(e) => self.ty(e),
        }
    }

    fn int(&mut self, int: IntConst, span: Span) -> ExprId {
        let value = u32::try_from(int.value);
        let fits_signed = int.value <= i32::MAX as u64;
        let ty = match (int.longs, int.unsigned || !fits_signed) {
            (0, false) => Int::Int,
            (0, true) => Int::UInt,
            (_, false) => Int::Long,
            (_, true) => Int::ULong,
        };
        if int.longs > 1 {
            self.error(UNSUPPORTED, span, "`long long` is not supported", "");
            return self.error_value(span);
        }
        let needs_suffix = int.decimal && !int.unsigned && !fits_signed;
        match value {
            Ok(value) if !needs_suffix => {
                let ty = self.types.int(ty);
                self.int_const(value, ty, span)
            }
            Ok(_) => {
                let text = "the constant does not fit in an `int`";
                let help = "write it with `u` at the end to make it `unsigned`";
                self.error_help(CONSTANT_RANGE, span, text, help);
                self.error_value(span)
            }
            Err(_) => {
                self.error(
                    CONSTANT_RANGE,
                    span,
                    "the constant does not fit in 32 bits",
                    "",
                );
                self.error_value(span)
            }
        }
    }

    /// A string literal: an array of `char` with static storage.
    pub(super) fn string(&mut self, bytes: &[u8], span: Span) -> PlaceId {
        let mut bytes = bytes.to_vec();
        bytes.push(0);
        let char = QualType::plain(self.types.known.char);
        let ty = QualType::plain(self.types.id(Type::Array(char, Some(bytes.len() as u32))));
        let object = match self.strings.get(&bytes) {
            Some(&object) => object,
            None => {
                let object = self.objects.push(Object {
                    name: ".str".to_owned(),
                    ty,
                    image: Image {
                        bytes: bytes.clone(),
                        addresses: Vec::new(),
                    },
                    defined: true,
                    pos: self.sources.pos(span),
                });
                self.strings.insert(bytes, object);
                object
            }
        };
        self.place(PlaceKind::Object(object), ty, span)
    }

    fn name(&mut self, name: &str, span: Span) -> Operand {
        match self.lookup(name) {
            Some((Symbol::Local(local), _)) => {
                let ty = self.body.locals[local].ty;
                Operand::Place(self.place(PlaceKind::Local(local), ty, span))
            }
            Some((Symbol::Object(object), _)) => {
                self.externals.use_object(object, span);
                let ty = self.objects[object].ty;
                Operand::Place(self.place(PlaceKind::Object(object), ty, span))
            }
            Some((Symbol::Function(function), _)) => {
                self.externals.use_function(function, span);
                Operand::Function(function, span)
            }
            Some((Symbol::Constant(bits, ty), _)) => Operand::Value(self.int_const(bits, ty, span)),
            Some((Symbol::Typedef(_), at)) => {
                let text = format!("`{name}` is a type, not a value");
                let message = self.sources.error(OPERANDS, span, text, "");
                let message = self.sources.also(message, at, "declared here");
                self.messages.push(message);
                Operand::Value(self.error_value(span))
            }
            None if name == "__func__" && self.context.function.is_some() => {
                let function = self.context.function.clone().unwrap_or_else(|| "".into());
                Operand::Place(self.string(function.as_bytes(), span))
            }
            None => {
                let text = match name.starts_with("__srp_") {
                    true => format!("`{name}` is an operation and can only be called"),
                    false => format!("`{name}` is not declared"),
                };
                self.error(UNDECLARED, span, text, "");
                Operand::Value(self.error_value(span))
            }
        }
    }

    fn size_of(&mut self, ty: TypeId, span: Span) -> ExprId {
        match self.types.size(ty) {
            Some(size) => self.int_const(size, self.types.known.uint, span),
            None => {
                let text = format!("{} has no size", self.show(ty));
                self.error(OPERANDS, span, text, "");
                self.error_value(span)
            }
        }
    }

    fn index(&mut self, a: ast::ExprId, i: ast::ExprId, span: Span) -> Operand {
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
        let (length, index) = (length?, self.const_value(index)?);
        let size = self.types.size(of.ty)?;
        if index < length {
            let quals = of.quals.and(self.body.places[place].ty.quals);
            let ty = QualType { ty: of.ty, quals };
            return Some(self.place(PlaceKind::Member(place, index * size), ty, span));
        }
        if index > length || !past_end {
            let text = format!("index {} is outside the array of {length}", index as i32);
            self.warning(INDEX_RANGE, span, text);
        }
        None
    }

    fn element(&mut self, base: ExprId, index: ExprId, span: Span) -> Operand {
        let pointer = self.offset(base, index, 1, span);
        Operand::Place(self.deref(pointer, span))
    }

    /// What a pointer points to.
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
        let function = matches!(self.types.get(target.ty), Type::Function(_));
        if !complete && !function && target.ty != self.types.known.void {
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
        let index = self.promote(index);
        let fixed = self.const_value(index);
        if fixed.is_some_and(|i| i > 3) {
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

    fn member(&mut self, a: ast::ExprId, name: &str, at: Span, arrow: bool, span: Span) -> Operand {
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
                        _ => message,
                    };
                    self.messages.push(message);
                }
                return Operand::Value(self.error_value(span));
            }
        };
        let Some((offset, ty)) = self.types.field(record, name) else {
            let text = format!("{} has no member `{name}`", self.show(outer.ty));
            self.error(MEMBER, at, text, "");
            return Operand::Value(self.error_value(span));
        };
        let ty = QualType {
            ty: ty.ty,
            quals: ty.quals.and(outer.quals),
        };
        Operand::Place(self.place(PlaceKind::Member(base, offset), ty, span))
    }

    fn prefix(&mut self, op: Prefix, a: ast::ExprId, span: Span) -> Operand {
        let value = match op {
            Prefix::Increment => self.step(a, 1, false, span),
            Prefix::Decrement => self.step(a, -1, false, span),
            Prefix::AddressOf => {
                self.past_end = matches!(self.unit.exprs[a].kind, ast::ExprKind::Index(..));
                let operand = self.operand(a);
                self.past_end = false;
                self.address(operand, span)
            }
            Prefix::Deref => {
                let pointer = self.value(a);
                return Operand::Place(self.deref(pointer, span));
            }
            Prefix::Plus | Prefix::Minus | Prefix::BitNot => self.sign(op, a, span),
            Prefix::Not => {
                let a = self.condition(a);
                self.make(ExprKind::LogicalNot(a), self.types.known.int, span)
            }
        };
        Operand::Value(value)
    }

    fn sign(&mut self, op: Prefix, a: ast::ExprId, span: Span) -> ExprId {
        let a = self.value(a);
        let ty = self.ty(a);
        let vector = self.types.vector(ty);
        let float = *self.types.get(ty) == Type::Float || vector == Some(true);
        let number = self.types.is_arithmetic(ty) || vector.is_some();
        if !number || op == Prefix::BitNot && float {
            let text = format!("`{}` does not take {}", op.text(), self.show(ty));
            self.error(OPERANDS, span, text, "");
            return self.error_value(span);
        }
        let a = self.promote(a);
        let ty = self.ty(a);
        match op {
            Prefix::Plus => a,
            Prefix::Minus => self.make(ExprKind::Negate(a), ty, span),
            _ => self.make(ExprKind::Complement(a), ty, span),
        }
    }

    fn address(&mut self, operand: Operand, span: Span) -> ExprId {
        match operand {
            Operand::Function(..) => self.read(operand),
            Operand::Place(place) => {
                let Place { kind, ty, .. } = &self.body.places[place];
                let ty = *ty;
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
    pub(super) fn assignable(&mut self, a: ast::ExprId, span: Span) -> Option<PlaceId> {
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
        let _ = span;
        if let Some(local) = self.root(place) {
            self.context.assigned.push(local);
        }
        Some(place)
    }

    fn has_const_member(&self, ty: TypeId) -> bool {
        match self.types.get(ty) {
            Type::Record(record) => {
                let fields = self.types.records[*record].fields.as_deref();
                fields
                    .unwrap_or(&[])
                    .iter()
                    .any(|f| f.ty.quals.constant || self.has_const_member(f.ty.ty))
            }
            Type::Array(of, _) => of.quals.constant || self.has_const_member(of.ty),
            _ => false,
        }
    }

    fn is_temporary(&self, mut place: PlaceId) -> bool {
        loop {
            match &self.body.places[place].kind {
                PlaceKind::Temporary(_) => return true,
                PlaceKind::Member(outer, _) | PlaceKind::Lane(outer, _) => place = *outer,
                _ => return false,
            }
        }
    }

    fn conditional(
        &mut self,
        c: ast::ExprId,
        a: ast::ExprId,
        b: ast::ExprId,
        span: Span,
    ) -> ExprId {
        let c = self.condition(c);
        let (a, b) = (self.value(a), self.value(b));
        let (ta, tb) = (self.ty(a), self.ty(b));
        if self.is_error(ta) || self.is_error(tb) || self.is_error(self.ty(c)) {
            return self.error_value(span);
        }
        let ty = if self.types.is_arithmetic(ta) && self.types.is_arithmetic(tb) {
            Some(self.common(ta, tb))
        } else if ta == tb || self.types.compatible(ta, tb) {
            Some(ta)
        } else {
            self.common_pointer(a, b)
        };
        let Some(ty) = ty else {
            let text = format!(
                "`?:` cannot choose between {} and {}",
                self.show(ta),
                self.show(tb)
            );
            self.error(OPERANDS, span, text, "");
            return self.error_value(span);
        };
        let (a, b) = (self.convert(a, ty), self.convert(b, ty));
        self.make(ExprKind::Conditional(c, a, b), ty, span)
    }

    /// An object made by `(type){ … }`.
    fn compound_literal(&mut self, ty: QualType, init: &ast::Initialiser, span: Span) -> Operand {
        if self.is_error(ty.ty) {
            return Operand::Value(self.error_value(span));
        }
        let Some((ty, parts)) = self.initialise(ty, init, span) else {
            return Operand::Value(self.error_value(span));
        };
        if self.types.vector(ty.ty).is_some() {
            let value = self.vector_of_parts(ty.ty, &parts, span);
            return Operand::Value(value);
        }
        let place = if self.context.function.is_none() {
            let image = self.image(ty.ty, &parts);
            let object = self.objects.push(Object {
                name: ".literal".to_owned(),
                ty,
                image,
                defined: true,
                pos: self.sources.pos(span),
            });
            PlaceKind::Object(object)
        } else {
            let local = self.body.locals.push(Local {
                name: "literal".into(),
                ty,
                in_memory: false,
            });
            PlaceKind::Literal(local, parts)
        };
        Operand::Place(self.place(place, ty, span))
    }

    /// The vector that an initialiser of a vector gives.
    fn vector_of_parts(&mut self, ty: TypeId, init: &Init, span: Span) -> ExprId {
        let known = self.types.known;
        let lane_ty = match self.types.vector(ty) {
            Some(true) => known.float,
            _ => known.int,
        };
        let zero = self.int_const(0, lane_ty, span);
        let mut lanes = [zero; 4];
        for &(offset, value) in &init.parts {
            if self.ty(value) == ty {
                return value;
            }
            lanes[(offset / 4 % 4) as usize] = value;
        }
        self.make(ExprKind::Build(lanes), ty, span)
    }
}
