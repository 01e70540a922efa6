//! Calls: of functions, of pointers, and of operations (`__srp_…`), whose types come from the
//! opcode table.

use super::{Checker, Operand, Symbol};
use crate::ast;
use crate::ctype::{QualType, Signature, Type, TypeId};
use crate::library;
use crate::message::{CALL, FAST_UNIT, IMPLICIT_FUNCTION, NOT_CONSTANT};
use crate::operator::Support;
use crate::source::Name;
use crate::typed::*;
use srp_archdesc::diagnostic::{Diagnostic, Severity, Span};
use srp_archdesc::isa::{Class, Kind, Opcode};
use srp_archdesc::nearest::nearest;
use srp_archdesc::structure::Special;

/// The meaning of an operation's name.
enum Operation {
    /// An opcode; vectors, and words that are never looked into, hold floats where true.
    Opcode(Opcode, bool),
    /// A vector of four scalars: of floats where true.
    Build(bool),
    /// The same bits: from a vector where the first is true, to floats where the second is.
    Bits(bool, bool),
}

/// The operation of this name, without `__srp_`.
///
/// An opcode's own name means floats in vectors that are never looked into; with `i` at the end
/// it means integers. Words that are never looked into are integers beside scalars, with `f` at
/// the end floats.
fn operation(name: &str) -> Option<Operation> {
    match name {
        "float4" => return Some(Operation::Build(true)),
        "int4" => return Some(Operation::Build(false)),
        "bits" => return Some(Operation::Bits(false, false)),
        "float" => return Some(Operation::Bits(false, true)),
        "bits4" => return Some(Operation::Bits(true, false)),
        "asfloat4" => return Some(Operation::Bits(true, true)),
        _ => {}
    }
    let usable = |op: &Opcode| !op.is_guarded() || matches!(op, Opcode::Tex | Opcode::Prefetch);
    let has = |op: Opcode, kind: Kind| {
        let info = op.info();
        info.operands.contains(&kind) || info.result == Some(kind)
    };
    if let Some(op) = Opcode::parse(name).filter(usable) {
        return Some(Operation::Opcode(op, has(op, Kind::V)));
    }
    let (base, float) = match name.strip_suffix('i') {
        Some(base) => (base, false),
        None => (name.strip_suffix('f')?, true),
    };
    let op = Opcode::parse(base).filter(usable)?;
    let vector = has(op, Kind::V);
    let fits = if float {
        !vector && has(op, Kind::W)
    } else {
        vector
    };
    fits.then_some(Operation::Opcode(op, float))
}

/// The names of all operations, without `__srp_`.
fn operation_names() -> impl Iterator<Item = &'static str> {
    let names = library::known_names().filter_map(|known| known.name.strip_prefix("srp_"));
    let opcodes = Opcode::ALL.iter().map(|op| op.name());
    names
        .chain(opcodes)
        .filter(|name| operation(name).is_some())
}

/// True if C takes an opcode's integer result as unsigned.
fn unsigned_result(op: Opcode) -> bool {
    use Opcode::*;
    let is_pair = op.class() == Class::Pair;
    is_pair || matches!(op, Minu | Maxu | Mulhu | Ftou | Shr)
}

impl Checker<'_> {
    pub(super) fn call(&mut self, callee: ast::ExprId, args: &[ast::ExprId], span: Span) -> ExprId {
        if let ast::ExprKind::Name(name) = &self.unit.exprs[callee].kind {
            let known = self.lookup(name).is_some();
            if let (false, Some(operation)) = (known, name.strip_prefix("__srp_")) {
                return self.operation_call(name, operation, args, span);
            }
            if !known {
                if let Some(value) = self.builtin_call(name, args, span) {
                    return value;
                }
                let at = self.unit.exprs[callee].span;
                self.implicit_function(name, at);
            }
        }
        let named = match &self.unit.exprs[callee].kind {
            ast::ExprKind::Name(name) => Some(name),
            _ => None,
        };
        let (callee, ty) = match self.operand(callee) {
            Operand::Function(function, _) => {
                (Callee::Function(function), self.functions[function].ty)
            }
            other => {
                let pointer = self.read(other);
                let ty = self.ty(pointer);
                let target = self.types.pointee(ty).map_or(ty, |to| to.ty);
                (Callee::Pointer(pointer), target)
            }
        };
        let values: Vec<_> = args.iter().map(|&arg| self.value(arg)).collect();
        let signature = match self.types.get(ty) {
            Type::Function(signature) => signature.clone(),
            other => {
                if *other != Type::Error {
                    let text = format!("{} cannot be called", self.show(ty));
                    self.error(CALL, span, text, "");
                }
                return self.error_value(span);
            }
        };
        let more = signature.variadic || signature.open;
        if values.len() < signature.params.len() && !signature.open
            || values.len() > signature.params.len() && !more
        {
            let least = if signature.variadic { "at least " } else { "" };
            let text = format!(
                "the function takes {least}{}, not {}",
                arguments(signature.params.len()),
                values.len()
            );
            let message = self.sources.error(CALL, span, text, "");
            let message = self.with_declaration(message, named, ty);
            self.messages.push(message);
            return self.error_value(span);
        }
        self.check_format(&callee, args, &values);
        let fixed = match signature.open {
            true => &[][..],
            false => signature.params.as_slice(),
        };
        let converted = values
            .iter()
            .enumerate()
            .map(|(i, &value)| match fixed.get(i) {
                Some(&param) => self.assign_to(value, param, &format!("argument {}", i + 1)),
                None => self.passed(value),
            });
        let converted: Vec<_> = converted.collect();
        if signature.result != self.types.known.void && !self.is_error(signature.result) {
            self.complete(signature.result, span, "the result of a function");
        }
        self.make(ExprKind::Call(callee, converted), signature.result, span)
    }

    /// A message about a call with the declaration of what is called.
    fn with_declaration(
        &self,
        message: Diagnostic,
        called: Option<&Name>,
        ty: TypeId,
    ) -> Diagnostic {
        let name = called.map_or("", |name| name);
        let declared = self.types.declares(QualType::plain(ty), name);
        let message = message.note(format!("the function is `{declared}`"));
        match self.lookup(name) {
            Some((_, at)) if !self.is_library(at) => {
                self.sources.also(message, at, "declared here")
            }
            _ => message,
        }
    }

    /// An argument that no parameter says the type of.
    fn passed(&mut self, value: ExprId) -> ExprId {
        let ty = self.ty(value);
        match self.types.get(ty) {
            Type::Float
                if self
                    .externals
                    .names
                    .contains_key(Support::FloatToDouble.name()) =>
            {
                self.convert(value, self.types.known.double)
            }
            Type::Float => {
                let span = self.span(value);
                let text = "a `float` is passed to a function that is not declared with its type";
                self.error(CALL, span, text, "");
                value
            }
            Type::Void => {
                let span = self.span(value);
                self.error(CALL, span, "an argument is a value, not `void`", "");
                self.error_value(span)
            }
            _ => self.promote(value),
        }
    }

    /// Declares a function that is called without having been: as the library has it, or else as
    /// one that takes anything and returns an `int`.
    fn implicit_function(&mut self, name: &Name, span: Span) {
        let plain = library::plain(name);
        let builtin = **name != *plain;
        if !builtin {
            let text = format!("the function `{name}` is called but not declared");
            let advice = self.advice_for_function(name);
            if !self.is_library(span) {
                let message = self.sources.warning(IMPLICIT_FUNCTION, span, text, "");
                self.messages.push(match &advice {
                    Some(advice) => message.help(advice.clone()),
                    None => message,
                });
            }
            self.implicit.insert(span, advice);
        }
        let externals = &self.externals.names;
        let found = externals.get(name).or_else(|| externals.get(plain));
        if let Some(&symbol @ Symbol::Function(function)) = found
            && (self.functions[function].optional || builtin)
        {
            self.scopes[1].names.insert(name.clone(), (symbol, span));
            return;
        }
        let signature = Signature {
            open: true,
            ..Signature::of(self.types.known.int, Vec::new())
        };
        let ty = self.types.id(Type::Function(signature));
        let scopes = self.scopes.split_off(2);
        self.declare_function(name, ty, None, false, span);
        self.scopes.extend(scopes);
    }

    fn operation_call(
        &mut self,
        name: &str,
        operation_name: &str,
        args: &[ast::ExprId],
        span: Span,
    ) -> ExprId {
        let values: Vec<_> = args.iter().map(|&arg| self.value(arg)).collect();
        let known = self.types.known;
        match operation(operation_name) {
            Some(Operation::Opcode(op, float)) => {
                let op = self.on_unit(op, span);
                self.opcode_call(name, op, float, &values, span)
            }
            Some(Operation::Build(float)) => {
                let (lane, vector) = match float {
                    true => (known.float, known.float4),
                    false => (known.int, known.int4),
                };
                let Some(lanes) = self.operands(name, &[lane; 4], &values, span) else {
                    return self.error_value(span);
                };
                let lanes = [lanes[0], lanes[1], lanes[2], lanes[3]];
                self.make(ExprKind::Build(lanes), vector, span)
            }
            Some(Operation::Bits(vector, to_float)) => {
                let (from, to) = match (vector, to_float) {
                    (false, false) => (known.float, known.uint),
                    (false, true) => (known.uint, known.float),
                    (true, false) => (known.float4, known.int4),
                    (true, true) => (known.int4, known.float4),
                };
                let Some(operands) = self.operands(name, &[from], &values, span) else {
                    return self.error_value(span);
                };
                if vector {
                    self.make(ExprKind::Convert(operands[0]), to, span)
                } else {
                    let kind = ExprKind::Operation(Opcode::Mov, operands, 0);
                    self.make(kind, to, span)
                }
            }
            None => {
                let text = format!("there is no operation `{name}`");
                let names = operation_names().filter(|known| known.len() > 2);
                let near = nearest(operation_name, names);
                let advice = near.map(|near| format!("did you mean `__srp_{near}`?"));
                self.error_advice(CALL, span, text, advice);
                self.error_value(span)
            }
        }
    }

    /// An operation that the machine has a unit for: the ordinary one in place of a fast one that it lacks.
    fn on_unit(&mut self, op: Opcode, span: Span) -> Opcode {
        if self.choices.has(op) {
            return op;
        }
        let ordinary = Special::of(op).map(|special| special.ordinary().opcodes()[0]);
        let ordinary = ordinary.unwrap_or(op);
        let text = format!("the machine has no unit for `{op}`: its `{ordinary}` computes this");
        let mut message = self.sources.warning(FAST_UNIT, span, text, "");
        message.severity = Severity::Note;
        self.messages.push(message);
        ordinary
    }

    /// Operands converted to the types that an operation takes.
    fn operands(
        &mut self,
        name: &str,
        types: &[TypeId],
        values: &[ExprId],
        span: Span,
    ) -> Option<Vec<ExprId>> {
        if values.len() != types.len() {
            let text = format!(
                "`{name}` takes {}, not {}",
                arguments(types.len()),
                values.len()
            );
            self.error(CALL, span, text, "");
            return None;
        }
        let pairs = values.iter().zip(types).enumerate();
        let operands = pairs
            .map(|(i, (&value, &ty))| self.assign_to(value, ty, &format!("argument {}", i + 1)));
        Some(operands.collect())
    }

    fn opcode_call(
        &mut self,
        name: &str,
        op: Opcode,
        float: bool,
        values: &[ExprId],
        span: Span,
    ) -> ExprId {
        let info = op.info();
        // A swizzle has four lane numbers, anything else with an immediate one constant: a port
        // before the operands, a lane after them.
        let constants = match (info.immediate, op) {
            (false, _) => 0,
            (true, Opcode::Swz) => 4,
            (true, _) => 1,
        };
        // A guard is always true.
        let kinds = &info.operands[usize::from(op.is_guarded())..];
        let operands = kinds.len();
        if values.len() != operands + constants {
            let text = format!(
                "`{name}` takes {}, not {}",
                arguments(operands + constants),
                values.len()
            );
            self.error(CALL, span, text, "");
            return self.error_value(span);
        }
        let (constants, values) = match info.class {
            Class::Io => values.split_at(constants),
            _ => {
                let (values, constants) = values.split_at(operands);
                (constants, values)
            }
        };
        let limit = if info.class == Class::Io {
            i32::MAX as u64
        } else {
            3
        };
        let mut imm = 0;
        for (i, &constant) in constants.iter().enumerate() {
            match self.const_value(constant) {
                Some(bits) if bits <= limit && self.types.is_integer(self.ty(constant)) => {
                    imm |= (bits as u32) << (2 * i);
                }
                _ => {
                    let text = format!("`{name}` takes a constant from 0 to {limit} here");
                    self.error(NOT_CONSTANT, self.span(constant), text, "");
                    return self.error_value(span);
                }
            }
        }
        let mut args = Vec::new();
        if op.is_guarded() {
            args.push(self.int_const(1, self.types.known.int, span));
        }
        for (i, (&value, &kind)) in values.iter().zip(kinds).enumerate() {
            let what = format!("argument {}", i + 1);
            args.push(match kind {
                Kind::P => self.require_scalar(value, &what),
                _ => {
                    let ty = self.kind_type(kind, float, false);
                    self.assign_to(value, ty, &what)
                }
            });
        }
        let result = match info.result {
            Some(kind) => self.kind_type(kind, float, unsigned_result(op)),
            None => self.types.known.void,
        };
        self.make(ExprKind::Operation(op, args, imm as i32), result, span)
    }

    /// The C type of an operand or result.
    fn kind_type(&self, kind: Kind, float: bool, unsigned: bool) -> TypeId {
        let known = self.types.known;
        match kind {
            Kind::P => known.int,
            Kind::I if unsigned => known.uint,
            Kind::I => known.int,
            Kind::F => known.float,
            Kind::W if float => known.float,
            Kind::W => known.int,
            Kind::I4 => known.int4,
            Kind::F4 => known.float4,
            Kind::V if float => known.float4,
            Kind::V => known.int4,
        }
    }

    /// Turns a function or array type into the pointer type as which it is passed.
    pub(super) fn decayed(&mut self, ty: QualType) -> QualType {
        match self.types.get(ty.ty).clone() {
            Type::Array(of, _) => {
                let to = QualType {
                    ty: of.ty,
                    quals: of.quals.and(ty.quals),
                };
                QualType::plain(self.types.pointer(to))
            }
            Type::Function(_) => QualType::plain(self.types.pointer(ty)),
            _ => ty,
        }
    }
}

/// `no arguments`, `1 argument`, `2 arguments`.
fn arguments(count: usize) -> String {
    match count {
        0 => "no arguments".to_owned(),
        1 => "1 argument".to_owned(),
        n => format!("{n} arguments"),
    }
}
