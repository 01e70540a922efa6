//! Infix operators, assignment, increment.

use super::Checker;
use crate::ast::{self, Infix};
use crate::ctype::{Type, TypeId};
use crate::message::{DIVISION_BY_ZERO, DOUBLE_CONSTANT, OPERANDS, SHIFT_RANGE};
use crate::operator::{self, Class};
use crate::typed::*;
use srp_archdesc::diagnostic::Span;

/// Kinds of infix operators other than assignments and short circuits.
enum Kind {
    Arithmetic(BinaryOp),
    Relation(Relation),
    Logical(bool),
    Comma,
}

fn kind(op: Infix) -> Kind {
    use BinaryOp as B;
    use Kind::*;
    match op {
        Infix::Mul => Arithmetic(B::Mul),
        Infix::Div => Arithmetic(B::Div),
        Infix::Rem => Arithmetic(B::Rem),
        Infix::Add => Arithmetic(B::Add),
        Infix::Sub => Arithmetic(B::Sub),
        Infix::Shl => Arithmetic(B::Shl),
        Infix::Shr => Arithmetic(B::Shr),
        Infix::And => Arithmetic(B::And),
        Infix::Xor => Arithmetic(B::Xor),
        Infix::Or => Arithmetic(B::Or),
        Infix::Lt => Relation(self::Relation::Lt),
        Infix::Gt => Relation(self::Relation::Gt),
        Infix::Le => Relation(self::Relation::Le),
        Infix::Ge => Relation(self::Relation::Ge),
        Infix::Eq => Relation(self::Relation::Eq),
        Infix::Ne => Relation(self::Relation::Ne),
        Infix::LogicalAnd => Logical(false),
        Infix::LogicalOr => Logical(true),
        Infix::Comma => Comma,
    }
}

impl Checker<'_> {
    /// An infix expression; its left side is gone along without recursion.
    pub(super) fn chain(&mut self, e: ast::ExprId) -> ExprId {
        let mut links = Vec::new();
        let mut first = e;
        while let ast::ExprKind::Infix(op, left, right) = self.unit.exprs[first].kind {
            links.push((op, right, self.unit.exprs[first].span));
            first = left;
        }
        let mut left = self.value(first);
        for (op, right, span) in links.into_iter().rev() {
            left = self.infix(op, left, right, span);
        }
        left
    }

    fn infix(&mut self, op: Infix, left: ExprId, right: ast::ExprId, span: Span) -> ExprId {
        match kind(op) {
            Kind::Arithmetic(binary) => {
                let right = self.value(right);
                self.arithmetic(op, binary, left, right, span)
            }
            Kind::Relation(relation) => {
                let right = self.value(right);
                self.relation(op, relation, left, right, span)
            }
            Kind::Logical(or) => {
                let what = format!("an operand of `{}`", op.text());
                let left = self.require_scalar(left, &what);
                let right = self.branch(|checker| checker.value(right));
                let right = self.require_scalar(right, &what);
                self.make(
                    ExprKind::Logical(or, left, right),
                    self.types.known.int,
                    span,
                )
            }
            Kind::Comma => {
                let right = self.value(right);
                let ty = self.ty(right);
                self.make(ExprKind::Comma(left, right), ty, span)
            }
        }
    }

    fn no_operator(&mut self, op: Infix, l: TypeId, r: TypeId, span: Span) -> ExprId {
        let text = format!(
            "`{}` does not take {} and {}",
            op.text(),
            self.show(l),
            self.show(r)
        );
        self.error(OPERANDS, span, text, "");
        self.error_value(span)
    }

    /// Brings two operands to one type: scalars by the usual conversions, a scalar beside a
    /// vector into all lanes. `None` where that cannot be, which is said.
    fn balance(
        &mut self,
        op: Infix,
        l: ExprId,
        r: ExprId,
        span: Span,
    ) -> Option<(ExprId, ExprId, TypeId)> {
        let (lt, rt) = (self.ty(l), self.ty(r));
        if self.is_error(lt) || self.is_error(rt) {
            return None;
        }
        let vectors = (self.types.vector(lt), self.types.vector(rt));
        match vectors {
            (Some(_), Some(_)) if lt == rt => return Some((l, r, lt)),
            (Some(_), None) if self.types.is_arithmetic(rt) => {
                return self.splat(r, lt).map(|r| (l, r, lt));
            }
            (None, Some(_)) if self.types.is_arithmetic(lt) => {
                return self.splat(l, rt).map(|l| (l, r, rt));
            }
            (None, None) if self.types.is_arithmetic(lt) && self.types.is_arithmetic(rt) => {
                self.warn_double(l, r);
                self.warn_double(r, l);
                let ty = self.common(lt, rt);
                return Some((self.convert(l, ty), self.convert(r, ty), ty));
            }
            _ => {}
        }
        self.no_operator(op, lt, rt, span);
        None
    }

    /// Warns of a constant whose type alone makes the operation with a `float` one of `double`.
    fn warn_double(&mut self, constant: ExprId, other: ExprId) {
        let known = self.types.known;
        let makes_double = self.ty(constant) == known.double && self.ty(other) == known.float;
        if makes_double && self.const_value(constant).is_some() {
            let at = self.span(constant);
            let text =
                "a `double` beside a `float`: the operation is one of `double`, which is software";
            let message = self.sources.warning(DOUBLE_CONSTANT, at, text, "");
            let help = "write it with an `f` behind it, as in `0.5f`, or compile with `-fsingle-precision-constant`";
            self.messages.push(message.help(help));
        }
    }

    /// A scalar in all lanes of a vector, where nothing is lost in that.
    fn splat(&mut self, e: ExprId, vector: TypeId) -> Option<ExprId> {
        let (from, span) = (self.ty(e), self.span(e));
        let known = self.types.known;
        let float = self.types.is_floating(from);
        let lane = match (self.types.vector(vector)?, float) {
            (true, true) => known.float,
            (false, false) => known.int,
            (true, false) => {
                // Constants that a float holds exactly are plain; others need a word.
                let exact = |number: i128| number.unsigned_abs() <= 1 << 24;
                if !self.const_number(e).is_some_and(exact) {
                    let text = "an integer beside a `float4` may lose bits";
                    self.error_help(OPERANDS, span, text, "cast it to `float`");
                    return None;
                }
                known.float
            }
            (false, true) => {
                let text = "a `float` beside an `int4` loses its fraction";
                self.error_help(OPERANDS, span, text, "cast it to `int`");
                return None;
            }
        };
        let e = self.convert(e, lane);
        Some(self.make(ExprKind::Splat(e), vector, span))
    }

    pub(super) fn arithmetic(
        &mut self,
        op: Infix,
        binary: BinaryOp,
        l: ExprId,
        r: ExprId,
        span: Span,
    ) -> ExprId {
        let (lt, rt) = (self.ty(l), self.ty(r));
        let pointers = (
            self.types.pointee(lt).is_some(),
            self.types.pointee(rt).is_some(),
        );
        let is_step = |ty| self.types.is_integer(ty) || self.is_error(ty);
        match (binary, pointers) {
            (_, (false, false)) => {}
            (_, (true, false)) if !is_step(rt) => return self.no_operator(op, lt, rt, span),
            (_, (false, true)) if !is_step(lt) => return self.no_operator(op, lt, rt, span),
            (BinaryOp::Add, (true, false)) => return self.offset(l, r, 1, span),
            (BinaryOp::Add, (false, true)) => return self.offset(r, l, 1, span),
            (BinaryOp::Sub, (true, false)) => return self.offset(l, r, -1, span),
            (BinaryOp::Sub, (true, true)) => return self.distance(l, r, span),
            _ => return self.no_operator(op, lt, rt, span),
        }
        if let BinaryOp::Shl | BinaryOp::Shr = binary
            && self.types.is_integer(lt)
            && self.types.is_integer(rt)
        {
            return self.shift(binary, l, r, span);
        }
        let Some((l, r, ty)) = self.balance(op, l, r, span) else {
            return self.error_value(span);
        };
        if operator::binary(binary, Class::of(self.types.get(ty))).is_none() {
            return self.no_operator(op, lt, rt, span);
        }
        if let BinaryOp::Div | BinaryOp::Rem = binary {
            self.warn_zero(r);
        }
        self.make(ExprKind::Binary(binary, l, r), ty, span)
    }

    /// A shift: each operand is promoted by itself.
    fn shift(&mut self, op: BinaryOp, l: ExprId, r: ExprId, span: Span) -> ExprId {
        if self.is_error(self.ty(l)) || self.is_error(self.ty(r)) {
            return self.error_value(span);
        }
        let (l, r) = (self.promote(l), self.promote(r));
        let ty = self.ty(l);
        let width = 8 * self.types.size(ty).unwrap_or(4);
        let count = self.const_number(r);
        if count.is_some_and(|count| !(0..i128::from(width)).contains(&count)) {
            let at = self.span(r);
            self.warning(
                SHIFT_RANGE,
                at,
                format!("the count of a shift must be below {width}"),
            );
        }
        self.make(ExprKind::Binary(op, l, r), ty, span)
    }

    fn warn_zero(&mut self, divisor: ExprId) {
        if self.types.is_integer(self.ty(divisor)) && self.const_value(divisor) == Some(0) {
            let at = self.span(divisor);
            self.warning(DIVISION_BY_ZERO, at, "division by zero traps");
        }
    }

    /// A pointer plus or minus an integer times the size of its target.
    pub(super) fn offset(&mut self, p: ExprId, i: ExprId, sign: i32, span: Span) -> ExprId {
        let (pt, it) = (self.ty(p), self.ty(i));
        if self.is_error(pt) || self.is_error(it) {
            return self.error_value(span);
        }
        let Some(scale) = self.step_size(pt, span) else {
            return self.error_value(span);
        };
        if !self.types.is_integer(it) {
            let text = format!("an index is an integer, not {}", self.show(it));
            self.error(OPERANDS, self.span(i), text, "");
            return self.error_value(span);
        }
        let i = self.word_index(i);
        if self.const_value(i) == Some(0) {
            return p;
        }
        let kind = ExprKind::Offset(p, i, sign.wrapping_mul(scale as i32));
        self.make(kind, pt, span)
    }

    /// An integer as wide as a pointer, to be added to one.
    fn word_index(&mut self, e: ExprId) -> ExprId {
        let e = self.promote(e);
        if !self.types.is_wide(self.ty(e)) {
            return e;
        }
        let int = self.types.known.int;
        self.convert(e, int)
    }

    /// Bytes between neighbours that a pointer of this type steps over.
    fn step_size(&mut self, pointer: TypeId, span: Span) -> Option<u32> {
        let Some(to) = self.types.pointee(pointer) else {
            let text = format!("{} is no pointer or array", self.show(pointer));
            self.error(OPERANDS, span, text, "");
            return None;
        };
        // GNU: a step over `void` or a function is one byte.
        if matches!(self.types.get(to.ty), Type::Void | Type::Function(_)) {
            return Some(1);
        }
        let size = self.types.size(to.ty);
        if size.is_none() {
            let text = format!("{} has no size to step over", self.show(to.ty));
            self.error(OPERANDS, span, text, "");
        }
        size
    }

    fn distance(&mut self, l: ExprId, r: ExprId, span: Span) -> ExprId {
        let (lt, rt) = (self.ty(l), self.ty(r));
        let same = match (self.types.pointee(lt), self.types.pointee(rt)) {
            (Some(a), Some(b)) => {
                a.quals.global == b.quals.global && self.types.compatible(a.ty, b.ty)
            }
            _ => false,
        };
        if !same {
            return self.no_operator(Infix::Sub, lt, rt, span);
        }
        let Some(size) = self.step_size(lt, span) else {
            return self.error_value(span);
        };
        let kind = ExprKind::Distance(l, r, size.max(1));
        self.make(kind, self.types.known.long, span)
    }

    fn relation(
        &mut self,
        op: Infix,
        relation: Relation,
        l: ExprId,
        r: ExprId,
        span: Span,
    ) -> ExprId {
        let int = self.types.known.int;
        let (lt, rt) = (self.ty(l), self.ty(r));
        if self.types.pointee(lt).is_some() || self.types.pointee(rt).is_some() {
            return match self.common_pointer(l, r) {
                Some(ty) => {
                    let (l, r) = (self.convert(l, ty), self.convert(r, ty));
                    self.make(ExprKind::Compare(relation, l, r), int, span)
                }
                None if self.is_error(lt) || self.is_error(rt) => self.error_value(span),
                None => self.no_operator(op, lt, rt, span),
            };
        }
        self.suspect_relation(relation, l, r, span);
        let Some((l, r, ty)) = self.balance(op, l, r, span) else {
            return self.error_value(span);
        };
        let result = match self.types.vector(ty) {
            Some(_) => self.types.known.int4,
            None => int,
        };
        self.make(ExprKind::Compare(relation, l, r), result, span)
    }

    pub(super) fn assign(
        &mut self,
        op: Option<Infix>,
        a: ast::ExprId,
        v: ast::ExprId,
        span: Span,
    ) -> ExprId {
        let unset = self.unset(a);
        let without = unset.map(|local| (local, self.context.unset[&local]));
        if let (Some(local), Some(_)) = (unset, op) {
            self.suspect_read(local, self.unit.exprs[a].span);
        }
        let place = self.assignable(a);
        // It has its value after the right side is computed.
        if op.is_none() {
            self.context.unset.extend(without);
        }
        let value = self.value(v);
        if let Some(local) = unset {
            self.context.unset.remove(&local);
        }
        let Some(place) = place else {
            return self.error_value(span);
        };
        let ty = self.body.places[place].ty.ty;
        let Some(op) = op else {
            let value = self.assign_to(value, ty, "the left side");
            return self.make(ExprKind::Assign(place, value), ty, span);
        };
        let Kind::Arithmetic(binary) = kind(op) else {
            return self.error_value(span);
        };
        if self.types.pointee(ty).is_some() {
            return self.step_pointer(op, binary, place, value, false, span);
        }
        let before = self.read_place(place);
        // What `a op b` would be says which type it is done in, and what is wrong with it.
        let computed = self.arithmetic(op, binary, before, value, span);
        let (operand, compute) = match self.body.exprs[computed].kind {
            ExprKind::Binary(_, _, operand) => (operand, self.ty(computed)),
            _ => {
                let fits = self.assign_to(computed, ty, "the result");
                return self.error_value(self.span(fits));
            }
        };
        if self.types.vector(compute).is_some() && compute != ty {
            let text = format!("a vector does not fit in {}", self.show(ty));
            self.error(OPERANDS, span, text, "");
            return self.error_value(span);
        }
        let update = Update {
            place,
            step: Step::Arithmetic(binary, compute),
            operand,
            post: false,
        };
        self.make(ExprKind::Update(update), ty, span)
    }

    fn step_pointer(
        &mut self,
        op: Infix,
        binary: BinaryOp,
        place: PlaceId,
        operand: ExprId,
        post: bool,
        span: Span,
    ) -> ExprId {
        let ty = self.body.places[place].ty.ty;
        let sign = match binary {
            BinaryOp::Add => 1,
            BinaryOp::Sub => -1,
            _ => return self.no_operator(op, ty, self.ty(operand), span),
        };
        if !self.types.is_integer(self.ty(operand)) {
            return self.no_operator(op, ty, self.ty(operand), span);
        }
        let Some(size) = self.step_size(ty, span) else {
            return self.error_value(span);
        };
        let operand = self.word_index(operand);
        let update = Update {
            place,
            step: Step::Pointer(sign * size as i32),
            operand,
            post,
        };
        self.make(ExprKind::Update(update), ty, span)
    }

    /// `++` and `--`.
    pub(super) fn step(&mut self, a: ast::ExprId, by: i32, post: bool, span: Span) -> ExprId {
        if let Some(local) = self.unset(a) {
            self.suspect_read(local, self.unit.exprs[a].span);
        }
        let Some(place) = self.assignable(a) else {
            return self.error_value(span);
        };
        let ty = self.body.places[place].ty.ty;
        let (op, binary) = match by {
            1 => (Infix::Add, BinaryOp::Add),
            _ => (Infix::Sub, BinaryOp::Sub),
        };
        let one = self.int_const(1, self.types.known.int, span);
        if self.types.pointee(ty).is_some() {
            return self.step_pointer(op, binary, place, one, post, span);
        }
        if !self.types.is_arithmetic(ty) && self.types.vector(ty).is_none() {
            let sign = if by > 0 { "++" } else { "--" };
            let text = format!("`{sign}` does not take {}", self.show(ty));
            self.error(OPERANDS, span, text, "");
            return self.error_value(span);
        }
        let compute = match self.types.vector(ty) {
            Some(_) => ty,
            None => self.promoted(ty),
        };
        let operand = match self.types.vector(ty) {
            Some(_) => match self.splat(one, ty) {
                Some(operand) => operand,
                None => return self.error_value(span),
            },
            None => self.convert(one, compute),
        };
        let update = Update {
            place,
            step: Step::Arithmetic(binary, compute),
            operand,
            post,
        };
        self.make(ExprKind::Update(update), ty, span)
    }
}
