//! Calls that are known without a declaration: `__builtin_…`. What the library has as functions is
//! not among them.

use super::{Checker, Symbol};
use crate::ast;
use crate::ctype::{QualType, Type};
use crate::library;
use crate::message::{CALL, NOT_CONSTANT};
use crate::typed::*;
use srp_archdesc::diagnostic::Span;
use srp_archdesc::isa::Opcode;

/// Returns the number that the library's overflow function gives to the operation of
/// `add_overflow`, `smull_overflow` and the like.
fn overflow_operation(name: &str) -> Option<u64> {
    let name = name.strip_suffix("_overflow")?;
    let operation = |name: &str| {
        ["add", "sub", "mul"]
            .iter()
            .position(|&known| known == name)
    };
    let typed = || {
        let name = name.strip_prefix(['s', 'u'])?;
        operation(
            name.strip_suffix("ll")
                .or(name.strip_suffix('l'))
                .unwrap_or(name),
        )
    };
    // `mul` ends in `l` itself.
    let typed = || typed().or_else(|| operation(name.strip_prefix(['s', 'u'])?));
    operation(name).or_else(typed).map(|n| n as u64)
}

impl Checker<'_> {
    /// A call that is known without a declaration: `__builtin_…`.
    pub(super) fn builtin_call(
        &mut self,
        name: &str,
        args: &[ast::ExprId],
        span: Span,
    ) -> Option<ExprId> {
        let known = self.types.known;
        let builtin = name.strip_prefix("__builtin_")?;
        match (builtin, args) {
            ("expect" | "expect_with_probability", &[value, expected, ..]) => {
                Some(self.expected(value, expected, span))
            }
            ("assume_aligned", &[pointer, ..]) => Some(self.value(pointer)),
            ("prefetch", &[pointer, ref hints @ ..]) => Some(self.prefetch(pointer, hints, span)),
            ("object_size", &[_, kind]) => {
                let unknown = match self.const_int(kind, "the kind of a size") {
                    Some((0 | 1, _)) => u64::from(u32::MAX),
                    _ => 0,
                };
                Some(self.int_const(unknown, known.ulong, span))
            }
            ("choose_expr", &[condition, a, b]) => {
                match self.const_int(condition, "the condition") {
                    Some((0, _)) => Some(self.value(b)),
                    Some(_) => Some(self.value(a)),
                    None => Some(self.error_value(span)),
                }
            }
            (name, &[a, b, result]) if overflow_operation(name).is_some() => {
                let operation = overflow_operation(name)?;
                Some(self.overflow(operation, a, b, result, span))
            }
            ("constant_p", &[value]) => {
                let value = self.value(value);
                let constant = self.constant(value).is_some();
                Some(self.int_const(constant.into(), known.int, span))
            }
            ("unreachable", &[]) => Some(self.make(ExprKind::Unreachable, known.void, span)),
            ("trap", &[]) => Some(self.make(ExprKind::Unreachable, known.void, span)),
            ("va_start", &[list, ..]) => Some(self.va_start(list, span)),
            ("va_end", &[list]) => {
                let list = self.value(list);
                Some(self.make(ExprKind::Convert(list), known.void, span))
            }
            ("va_copy", &[to, from]) => Some(self.assign(None, to, from, span)),
            ("huge_val" | "inf", &[]) => {
                let bits = f64::INFINITY.to_bits();
                Some(self.make(ExprKind::Const(bits), known.double, span))
            }
            ("huge_valf" | "inff", &[]) => {
                let bits = f32::INFINITY.to_bits().into();
                Some(self.make(ExprKind::Const(bits), known.float, span))
            }
            ("nan", &[_]) => {
                let bits = super::constant::double_bits(f64::NAN);
                Some(self.make(ExprKind::Const(bits), known.double, span))
            }
            ("nanf", &[_]) => Some(self.make(ExprKind::Const(0x7fc0_0000), known.float, span)),
            _ => None,
        }
    }

    /// `__builtin_prefetch`: the operation where the pointer leads to system memory; nothing where it leads to SRAM,
    /// which has no lines. Whether a write is to follow, and how soon, changes nothing.
    fn prefetch(&mut self, pointer: ast::ExprId, hints: &[ast::ExprId], span: Span) -> ExprId {
        let known = self.types.known;
        let pointer = self.value(pointer);
        for &hint in hints {
            self.const_int(hint, "a hint of a prefetch");
        }
        let ty = self.ty(pointer);
        match self.types.pointee(ty) {
            Some(target) if target.quals.global => {
                let guard = self.int_const(1, known.int, span);
                let address = self.cast(pointer, known.uint, span);
                let operation = ExprKind::Operation(Opcode::Prefetch, vec![guard, address], 0);
                self.make(operation, known.void, span)
            }
            Some(_) => self.make(ExprKind::Convert(pointer), known.void, span),
            None if self.is_error(ty) => self.error_value(span),
            None => {
                let text = format!("what is prefetched is {}, not a pointer", self.show(ty));
                let at = self.span(pointer);
                self.error(CALL, at, text, "");
                self.error_value(span)
            }
        }
    }

    /// `__builtin_expect`: the first value, after both are computed.
    fn expected(&mut self, value: ast::ExprId, expected: ast::ExprId, span: Span) -> ExprId {
        let value = self.value(value);
        let expected = self.value(expected);
        if self.const_value(expected).is_some() || self.context.function.is_none() {
            return value;
        }
        let kept = self.kept(value, span);
        let again = self.read_place(kept.1);
        let ty = self.ty(value);
        let both = self.make(ExprKind::Comma(expected, again), ty, span);
        self.make(ExprKind::Comma(kept.0, both), ty, span)
    }

    /// A value put into a variable of its own: the assignment, and the variable.
    fn kept(&mut self, value: ExprId, span: Span) -> (ExprId, PlaceId) {
        let ty = QualType::plain(self.ty(value));
        let local = self.body.locals.push(Local {
            name: "kept".into(),
            ty,
            in_memory: false,
            align: 1,
        });
        let place = self.place(PlaceKind::Local(local), ty, span);
        let assign = self.make(ExprKind::Assign(place, value), ty.ty, span);
        (assign, place)
    }

    /// `__builtin_add_overflow` and the like: sets the target of `result`; true if the exact result
    /// does not fit there.
    fn overflow(
        &mut self,
        operation: u64,
        a: ast::ExprId,
        b: ast::ExprId,
        result: ast::ExprId,
        span: Span,
    ) -> ExprId {
        let known = self.types.known;
        let (a, b, result) = (self.value(a), self.value(b), self.value(result));
        let target = self.types.pointee(self.ty(result)).map(|to| to.ty);
        let into = match target.map(|ty| self.types.get(ty)) {
            Some(&Type::Int(int)) => Some(int),
            _ => None,
        };
        let support = self.externals.names.get(library::OVERFLOW).copied();
        let integers = [a, b].iter().all(|&e| self.types.is_integer(self.ty(e)));
        let (Some(into), Some(Symbol::Function(support)), true) = (into, support, integers) else {
            let text = "two integers and a pointer to one are wanted";
            self.error(CALL, span, text, "");
            return self.error_value(span);
        };
        if self.context.function.is_none() {
            self.error(NOT_CONSTANT, span, "this is computed in functions only", "");
            return self.error_value(span);
        }
        self.externals.use_function(support, span);
        let mut first = Vec::new();
        let mut args = vec![self.int_const(operation, known.int, span)];
        for operand in [a, b] {
            args.extend(self.signed_bits(operand, &mut first, span));
        }
        let (assign, target) = self.kept(result, span);
        first.push(assign);
        let zero = self.int_const(0, known.ullong, span);
        let (assign, low) = self.kept(zero, span);
        first.push(assign);
        let pointer = self.types.pointer(QualType::plain(known.ullong));
        args.push(self.int_const(8 * u64::from(into.size()), known.int, span));
        args.push(self.int_const(into.signed().into(), known.int, span));
        args.push(self.address_of(low, pointer, span));
        let call = ExprKind::Call(Callee::Function(support), args);
        let call = self.make(call, known.int, span);
        let (assign, flag) = self.kept(call, span);
        first.push(assign);
        let target = self.read_place(target);
        let target = self.deref(target, span);
        let low = self.read_place(low);
        let ty = self.body.places[target].ty.ty;
        let low = self.convert(low, ty);
        first.push(self.make(ExprKind::Assign(target, low), ty, span));
        let flag = self.read_place(flag);
        let flag = self.convert(flag, known.bool);
        first.into_iter().rev().fold(flag, |rest, step| {
            self.make(ExprKind::Comma(step, rest), known.bool, span)
        })
    }

    /// An integer as 64 bits, and whether it is negative; `first` gets what is to be done before.
    fn signed_bits(&mut self, e: ExprId, first: &mut Vec<ExprId>, span: Span) -> [ExprId; 2] {
        let known = self.types.known;
        let (assign, place) = self.kept(e, span);
        first.push(assign);
        let [value, again] = [(); 2].map(|()| self.read_place(place));
        let bits = self.convert(value, known.ullong);
        let negative = if self.types.is_unsigned(self.ty(again)) {
            self.int_const(0, known.int, span)
        } else {
            let zero = self.int_const(0, self.ty(again), span);
            self.make(
                ExprKind::Compare(Relation::Lt, again, zero),
                known.int,
                span,
            )
        };
        [bits, negative]
    }

    fn va_start(&mut self, list: ast::ExprId, span: Span) -> ExprId {
        let ty = self.va_list();
        let Some(place) = self.assignable(list) else {
            return self.error_value(span);
        };
        if !self.context.variadic || self.body.places[place].ty.ty != ty {
            let text = "`va_start` sets a `va_list` in a function with `...`";
            self.error(CALL, span, text, "");
            return self.error_value(span);
        }
        let start = self.make(ExprKind::Variadic, ty, span);
        let value = self.make(ExprKind::Assign(place, start), ty, span);
        self.make(ExprKind::Convert(value), self.types.known.void, span)
    }
}
