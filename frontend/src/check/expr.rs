//! Expressions.

use super::{Checker, Operand, Symbol};
use crate::ast::{self, Prefix};
use crate::ctype::{Int, QualType, Type, TypeId};
use crate::message::{CONSTANT_RANGE, DOUBLE_AS_FLOAT, OPERANDS, UNDECLARED};
use crate::token::{FloatConst, IntConst};
use crate::typed::*;
use srp_archdesc::diagnostic::Span;

/// Names that stand for the name of the enclosing function, as a string.
const FUNCTION_NAME: [&str; 3] = ["__func__", "__FUNCTION__", "__PRETTY_FUNCTION__"];

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
            K::Float(float) => self.float(*float, span),
            K::Char(value) => self.int_const(*value as u32 as u64, self.types.known.int, span),
            K::Str(bytes) => return Operand::Place(self.string(bytes, span)),
            K::WideStr(chars) => return Operand::Place(self.wide_string(chars, span)),
            K::Name(name) => return self.name(name, span),
            K::Call(callee, args) => self.call(*callee, args, span),
            K::Index(a, i) => return self.index(*a, *i, span),
            K::Member(a, name, at, arrow) => return self.member(*a, name, *at, *arrow, span),
            K::Prefix(op, a) => return self.prefix(*op, *a, span),
            K::Postfix(a, step) => self.step(*a, *step, true, span),
            K::Cast(name, a) => {
                let ty = self.type_name(name);
                let a = if ty.ty == self.types.known.void {
                    // So programs say that something is not used.
                    self.quietly(|checker| checker.value(*a))
                } else {
                    self.value(*a)
                };
                self.cast(a, ty.ty, span)
            }
            K::SizeofExpr(a) => {
                let operand = self.unevaluated(*a);
                if let Operand::Place(place) = operand
                    && let PlaceKind::Bits(..) = self.body.places[place].kind
                {
                    self.error(OPERANDS, span, "a bit-field has no size in bytes", "");
                }
                let ty = self.operand_type(operand);
                self.size_of(ty, span)
            }
            K::SizeofType(name) => {
                let ty = self.type_name(name).ty;
                self.size_of(ty, span)
            }
            K::AlignofType(name) => {
                let ty = self.type_name(name).ty;
                self.align_of(ty, span)
            }
            K::AlignofExpr(a) => {
                let operand = self.operand(*a);
                let ty = self.operand_type(operand);
                let own = match operand {
                    Operand::Place(place) => match self.body.places[place].kind {
                        PlaceKind::Local(local) => self.body.locals[local].align,
                        PlaceKind::Object(object) => self.objects[object].align,
                        _ => 1,
                    },
                    _ => 1,
                };
                let align = self.types.align(ty).max(own);
                self.int_const(align.into(), self.types.known.ulong, span)
            }
            K::SameType(names) => {
                let [a, b] = [&names.0, &names.1].map(|name| {
                    let ty = self.type_name(name).ty;
                    (ty, self.enumeration_of(&name.specs))
                });
                // GNU: an enumeration is compatible with its integer, and with no other enumeration.
                let others = a.1.is_some() && b.1.is_some() && a.1 != b.1;
                let same = self.types.compatible(a.0, b.0) && !others;
                self.int_const(same.into(), self.types.known.int, span)
            }
            K::VaArg(list, name) => return self.next_argument(*list, name, span),
            K::Statements(body) => self.statements(*body, span),
            K::Generic(e, list) => return self.generic(*e, list, span),
            K::Otherwise(a, b) => self.otherwise(*a, *b, span),
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
    pub(super) fn operand_type(&self, operand: Operand) -> TypeId {
        match operand {
            Operand::Place(place) => self.body.places[place].ty.ty,
            Operand::Function(function, _) => self.functions[function].ty,
            Operand::Value(e) => self.ty(e),
        }
    }

    /// An integer constant: of the first type that holds it.
    fn int(&mut self, int: IntConst, span: Span) -> ExprId {
        let signed = [Int::Int, Int::Long, Int::LongLong];
        let unsigned = [Int::UInt, Int::ULong, Int::ULongLong];
        let fits = |ty: &Int| {
            let bits = 8 * ty.size() - u32::from(ty.signed());
            int.value >> (bits - 1) <= 1
        };
        let from = usize::from(int.longs.min(2));
        let candidates = (from..3).flat_map(|i| match (int.unsigned, int.decimal) {
            (true, _) => vec![unsigned[i]],
            (false, true) => vec![signed[i]],
            (false, false) => vec![signed[i], unsigned[i]],
        });
        match candidates.into_iter().find(fits) {
            Some(ty) => {
                let ty = self.types.int(ty);
                self.int_const(int.value, ty, span)
            }
            None => {
                let text = "the constant does not fit in a `long long`";
                let help = "write it with `u` at the end to make it `unsigned`";
                self.error_help(CONSTANT_RANGE, span, text, help);
                self.error_value(span)
            }
        }
    }

    /// A floating constant.
    fn float(&mut self, float: FloatConst, span: Span) -> ExprId {
        let known = self.types.known;
        let (bits, single) = match float {
            FloatConst::Single(bits) => {
                return self.make(ExprKind::Const(bits.into()), known.float, span);
            }
            FloatConst::Double { double, single } | FloatConst::LongDouble { double, single } => {
                (double, single)
            }
        };
        if self.double_is_float || self.single_constants {
            let text = "the constant is a `float`, as asked for";
            self.note(DOUBLE_AS_FLOAT, span, text);
            return self.make(ExprKind::Const(single.into()), known.float, span);
        }
        self.make(ExprKind::Const(bits), known.double, span)
    }

    /// A wide string literal: an array of `int` with static storage.
    fn wide_string(&mut self, chars: &[u32], span: Span) -> PlaceId {
        let ended = chars.iter().chain([&0]);
        let bytes: Vec<u8> = ended.flat_map(|c| c.to_le_bytes()).collect();
        let int = QualType::plain(self.types.known.int);
        let length = Some(chars.len() as u32 + 1);
        let ty = QualType::plain(self.types.id(Type::Array(int, length)));
        let object = self.objects.push(Object {
            name: ".str".to_owned(),
            ty,
            image: Image {
                bytes,
                addresses: Vec::new(),
            },
            defined: true,
            optional: self.in_library,
            align: 1,
            pos: self.sources.pos(span),
        });
        self.place(PlaceKind::Object(object), ty, span)
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
                    optional: self.in_library,
                    align: 1,
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
            None if FUNCTION_NAME.contains(&name) && self.context.function.is_some() => {
                let function = self.context.function.clone().unwrap_or_else(|| "".into());
                Operand::Place(self.string(function.as_bytes(), span))
            }
            // It would follow from what the parser has said.
            None if self.unit.misunderstood.contains(name) => {
                Operand::Value(self.error_value(span))
            }
            None => {
                let text = match name.starts_with("__srp_") {
                    true => format!("`{name}` is an operation and can only be called"),
                    false => format!("`{name}` is not declared"),
                };
                let advice = self.advice_for_name(name);
                self.error_advice(UNDECLARED, span, text, advice);
                Operand::Value(self.error_value(span))
            }
        }
    }

    fn align_of(&mut self, ty: TypeId, span: Span) -> ExprId {
        let align = self.types.align(ty);
        self.int_const(align.into(), self.types.known.ulong, span)
    }

    fn size_of(&mut self, ty: TypeId, span: Span) -> ExprId {
        // GNU: `void` and functions have size 1.
        if let Type::Void | Type::Function(_) = self.types.get(ty) {
            return self.int_const(1, self.types.known.ulong, span);
        }
        match self.types.size(ty) {
            Some(size) => self.int_const(size.into(), self.types.known.ulong, span),
            None => {
                let text = format!("{} has no size", self.show(ty));
                self.error(OPERANDS, span, text, "");
                self.error_value(span)
            }
        }
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
        let float = self.types.is_floating(ty) || vector == Some(true);
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

    fn conditional(
        &mut self,
        c: ast::ExprId,
        a: ast::ExprId,
        b: ast::ExprId,
        span: Span,
    ) -> ExprId {
        let c = self.condition(c);
        let (a, b) = self.branch(|checker| (checker.value(a), checker.value(b)));
        self.choice(c, a, b, span)
    }

    /// `a ?: b`: the first where it is not zero, computed once.
    fn otherwise(&mut self, a: ast::ExprId, b: ast::ExprId, span: Span) -> ExprId {
        let a = self.value(a);
        let a = self.require_scalar(a, "a condition");
        let b = self.branch(|checker| checker.value(b));
        let ty = QualType::plain(self.ty(a));
        if self.is_error(ty.ty) || self.context.function.is_none() {
            return self.choice(a, a, b, span);
        }
        let local = self.body.locals.push(Local {
            name: "condition".into(),
            ty,
            in_memory: false,
            align: 1,
        });
        let place = self.place(PlaceKind::Local(local), ty, span);
        let condition = self.make(ExprKind::Assign(place, a), ty.ty, span);
        let again = self.read_place(place);
        self.choice(condition, again, b, span)
    }

    /// `c ? a : b`.
    fn choice(&mut self, c: ExprId, a: ExprId, b: ExprId, span: Span) -> ExprId {
        let (ta, tb) = (self.ty(a), self.ty(b));
        if self.is_error(ta) || self.is_error(tb) || self.is_error(self.ty(c)) {
            return self.error_value(span);
        }
        let void = self.types.known.void;
        let ty = if self.types.is_arithmetic(ta) && self.types.is_arithmetic(tb) {
            Some(self.common(ta, tb))
        } else if ta == void || tb == void {
            Some(void)
        } else if ta == tb || self.types.pointee(ta).is_none() && self.types.compatible(ta, tb) {
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
        let (a, b) = match self.types.get(ty) {
            Type::Record(_) => (a, b),
            _ => (self.convert(a, ty), self.convert(b, ty)),
        };
        self.make(ExprKind::Conditional(c, a, b), ty, span)
    }

    /// `({ … })`: the value of its last expression.
    fn statements(&mut self, body: ast::StmtId, span: Span) -> ExprId {
        if self.context.function.is_none() {
            let text = "statements in an expression stand in functions only";
            self.error(OPERANDS, span, text, "");
            return self.error_value(span);
        }
        let ast::StmtKind::Block(list) = &self.unit.stmts[body].kind else {
            return self.error_value(span);
        };
        let (firsts, last) = match list.split_last() {
            Some((&last, firsts)) => match self.unit.stmts[last].kind {
                ast::StmtKind::Expr(e) => (firsts, Some(e)),
                _ => (list.as_slice(), None),
            },
            None => (list.as_slice(), None),
        };
        self.scopes.push(super::Scope::default());
        let (first, _) = self.block(firsts, span);
        let value = last.map(|e| self.value(e));
        self.close_scope();
        let ty = value.map_or(self.types.known.void, |value| self.ty(value));
        self.make(ExprKind::Statements(vec![first], value), ty, span)
    }

    /// `_Generic`: the expression beside the type of the first.
    fn generic(
        &mut self,
        e: ast::ExprId,
        list: &[(Option<ast::TypeName>, ast::ExprId)],
        span: Span,
    ) -> Operand {
        let operand = self.unevaluated(e);
        let value = self.quietly(|checker| checker.read(operand));
        let wanted = self.ty(value);
        let mut chosen = None;
        for (name, e) in list {
            match name {
                None => chosen = chosen.or(Some(*e)),
                Some(name) => {
                    let ty = self.type_name(name).ty;
                    if self.types.compatible(ty, wanted) {
                        chosen = Some(*e);
                        break;
                    }
                }
            }
        }
        match chosen {
            Some(e) => self.operand(e),
            None => {
                if !self.is_error(wanted) {
                    let text = format!("no alternative is for {}", self.show(wanted));
                    self.error(OPERANDS, span, text, "");
                }
                Operand::Value(self.error_value(span))
            }
        }
    }

    /// `__builtin_va_arg`: the argument that a list of arguments comes to next. Arguments lie one
    /// after another, each at a multiple of its alignment and of a word.
    fn next_argument(&mut self, list: ast::ExprId, name: &ast::TypeName, span: Span) -> Operand {
        let ty = self.type_name(name);
        let place = self.assignable(list);
        let Some(place) = place.filter(|_| !self.is_error(ty.ty)) else {
            return Operand::Value(self.error_value(span));
        };
        let known = self.types.known;
        let list_ty = self.body.places[place].ty.ty;
        if list_ty != self.va_list() || !self.complete(ty.ty, span, "an argument") {
            if list_ty != self.va_list() {
                let text = format!("a list of arguments is wanted, not {}", self.show(list_ty));
                self.error(OPERANDS, span, text, "");
            }
            return Operand::Value(self.error_value(span));
        }
        // A float is passed as a double.
        let single = *self.types.get(ty.ty) == Type::Float;
        let ty = match single {
            true => QualType::plain(known.double),
            false => ty,
        };
        let size = self.types.size(ty.ty).unwrap_or(0).next_multiple_of(4);
        let align = self.types.align(ty.ty).max(4);
        let before = self.read_place(place);
        let mut address = self.convert_bits(before, known.uint, span);
        if align > 4 {
            let more = self.int_const((align - 1).into(), known.uint, span);
            let mask = self.int_const(align.wrapping_neg().into(), known.uint, span);
            let sum = ExprKind::Binary(BinaryOp::Add, address, more);
            address = self.make(sum, known.uint, span);
            let rounded = ExprKind::Binary(BinaryOp::And, address, mask);
            address = self.make(rounded, known.uint, span);
        }
        let size = self.int_const(size.into(), known.uint, span);
        let after = self.make(
            ExprKind::Binary(BinaryOp::Add, address, size),
            known.uint,
            span,
        );
        let after = self.convert_bits(after, list_ty, span);
        let stepped = self.make(ExprKind::Assign(place, after), list_ty, span);
        let pointer = self.types.pointer(ty);
        let pointer = self.convert_bits(stepped, pointer, span);
        let pointer_ty = self.ty(pointer);
        let back = ExprKind::Offset(pointer, size, -1);
        let pointer = self.make(back, pointer_ty, span);
        let place = self.deref(pointer, span);
        if single {
            let value = self.read_place(place);
            return Operand::Value(self.convert(value, known.float));
        }
        Operand::Place(place)
    }

    /// A word as another type of one word.
    fn convert_bits(&mut self, e: ExprId, ty: TypeId, span: Span) -> ExprId {
        self.make(ExprKind::Convert(e), ty, span)
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
                optional: self.in_library,
                align: 1,
                pos: self.sources.pos(span),
            });
            PlaceKind::Object(object)
        } else {
            let local = self.body.locals.push(Local {
                name: "literal".into(),
                ty,
                in_memory: false,
                align: 1,
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
        for &Part { offset, value, .. } in &init.parts {
            if self.ty(value) == ty {
                return value;
            }
            lanes[(offset / 4 % 4) as usize] = value;
        }
        self.make(ExprKind::Build(lanes), ty, span)
    }
}
