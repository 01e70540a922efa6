//! Constant expressions. Scalars are folded as they are made, by what the opcodes compute, so
//! that a constant is always an [`ExprKind::Const`]; addresses and vectors are found on demand.

use super::Checker;
use crate::ctype::{Int, Type, TypeId, TypeTable};
use crate::message::NOT_CONSTANT;
use crate::operator::{self, Class, Plan};
use crate::typed::*;
use srp_archdesc::arch::Precision;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Opcode;
use srp_archdesc::ops::{self, Value};

/// Depth to which addresses and vectors are looked into.
const MAX_DEPTH: u32 = 100;

/// A constant that can stand in an image.
#[derive(Clone, Copy, Debug)]
pub(super) enum Constant {
    /// The bits of a scalar, as in [`ExprKind::Const`].
    Scalar(u64),
    Vector([u32; 4]),
    Address(Address, i32),
}

/// Evaluates an opcode without guard on constants. Special functions are not folded here, since
/// their precision depends on the machine.
fn eval(op: Opcode, args: &[Value]) -> Option<Value> {
    ops::eval(op, args, 0, &Precision::EXACT).ok().flatten()
}

fn words(op: Opcode, args: &[u32]) -> Option<u32> {
    let args: Vec<Value> = args.iter().map(|&w| Value::word(w)).collect();
    eval(op, &args).map(|v| v.as_word())
}

/// True if a constant of this type is not zero.
pub(crate) fn truth(bits: u64, ty: &Type) -> bool {
    match ty {
        // Both zeros are zero.
        Type::Float => bits as u32 & 0x7fff_ffff != 0,
        Type::Double => bits << 1 != 0,
        _ => bits != 0,
    }
}

/// The number that a constant of an integer or pointer type is.
pub(super) fn number(bits: u64, ty: &Type) -> i128 {
    match ty {
        Type::Int(int) => int.number(bits),
        _ => i128::from(bits),
    }
}

/// The bits of a double; all that are no numbers are one.
pub(super) fn double_bits(value: f64) -> u64 {
    if value.is_nan() {
        0x7ff8_0000_0000_0000
    } else {
        value.to_bits()
    }
}

/// The bits of a float; all that are no numbers are one.
fn float_bits(value: f32) -> u64 {
    let bits = if value.is_nan() {
        0x7fc0_0000
    } else {
        value.to_bits()
    };
    u64::from(bits)
}

/// A constant of one scalar type in another.
pub(super) fn converted(bits: u64, from: &Type, to: &Type) -> Option<u64> {
    if *to == Type::Bool {
        return Some(u64::from(truth(bits, from)));
    }
    let float = match from {
        Type::Float => Some(f64::from(f32::from_bits(bits as u32))),
        Type::Double => Some(f64::from_bits(bits)),
        _ => None,
    };
    Some(match (float, to) {
        (Some(value), Type::Double) => double_bits(value),
        (Some(value), Type::Float) => float_bits(value as f32),
        (Some(value), Type::Int(int)) => int.wrap(truncated(value, *int)),
        (None, Type::Double) => double_bits(number(bits, from) as f64),
        (None, Type::Float) => float_bits(number(bits, from) as f32),
        (None, Type::Int(int)) => int.wrap(number(bits, from) as u64),
        // Pointers.
        _ => u64::from(bits as u32),
    })
}

/// A floating number as an integer, as the opcodes and the library make it: toward zero,
/// saturating; a type smaller than a word takes the low bits of an `int`.
fn truncated(value: f64, int: Int) -> u64 {
    match (int.size(), int.signed()) {
        (8, true) => value as i64 as u64,
        (8, false) => value as u64,
        (4, false) => u64::from(value as u32),
        _ => value as i32 as u64,
    }
}

/// Evaluates `l op r` on constants of one type; `None` for a division by zero.
pub(super) fn binary(op: BinaryOp, class: Class, l: u64, r: u64) -> Option<u64> {
    match operator::binary(op, class)? {
        Plan::Direct(op) => words(op, &[l as u32, r as u32]).map(u64::from),
        Plan::Guarded(op) => words(op, &[1, l as u32, r as u32]).map(u64::from),
        Plan::Lanes => None,
        Plan::Pairs | Plan::Support(_) if class == Class::Double => {
            double_binary(op, f64::from_bits(l), f64::from_bits(r))
        }
        Plan::Pairs | Plan::Support(_) => long_binary(op, class == Class::Long, l, r),
    }
}

fn double_binary(op: BinaryOp, l: f64, r: f64) -> Option<u64> {
    let value = match op {
        BinaryOp::Add => l + r,
        BinaryOp::Sub => l - r,
        BinaryOp::Mul => l * r,
        BinaryOp::Div => l / r,
        _ => return None,
    };
    Some(double_bits(value))
}

fn long_binary(op: BinaryOp, signed: bool, l: u64, r: u64) -> Option<u64> {
    let (a, b) = (l as i64, r as i64);
    Some(match op {
        BinaryOp::Add => l.wrapping_add(r),
        BinaryOp::Sub => l.wrapping_sub(r),
        BinaryOp::Mul => l.wrapping_mul(r),
        BinaryOp::Div | BinaryOp::Rem if r == 0 => return None,
        BinaryOp::Div if signed => a.wrapping_div(b) as u64,
        BinaryOp::Div => l / r,
        BinaryOp::Rem if signed => a.wrapping_rem(b) as u64,
        BinaryOp::Rem => l % r,
        BinaryOp::And => l & r,
        BinaryOp::Or => l | r,
        BinaryOp::Xor => l ^ r,
        BinaryOp::Shl => l.wrapping_shl(r as u32),
        BinaryOp::Shr if signed => a.wrapping_shr(r as u32) as u64,
        BinaryOp::Shr => l.wrapping_shr(r as u32),
    })
}

/// A relation of constants of one scalar type.
fn compare(relation: Relation, l: u64, r: u64, ty: &Type) -> bool {
    use std::cmp::Ordering::*;
    let order = match ty {
        Type::Float => f32::from_bits(l as u32).partial_cmp(&f32::from_bits(r as u32)),
        Type::Double => f64::from_bits(l).partial_cmp(&f64::from_bits(r)),
        _ => Some(number(l, ty).cmp(&number(r, ty))),
    };
    match relation {
        Relation::Eq => order == Some(Equal),
        Relation::Ne => order != Some(Equal),
        Relation::Lt => order == Some(Less),
        Relation::Le => matches!(order, Some(Less | Equal)),
        Relation::Gt => order == Some(Greater),
        Relation::Ge => matches!(order, Some(Greater | Equal)),
    }
}

/// The value of an expression whose operands are constants.
pub(super) fn fold(
    kind: &ExprKind,
    ty: TypeId,
    exprs: &EntityMap<ExprId, Expr>,
    types: &TypeTable,
) -> Option<u64> {
    let known = |e: &ExprId| match exprs[*e].kind {
        ExprKind::Const(bits) => Some(bits),
        _ => None,
    };
    let type_of = |e: &ExprId| types.get(exprs[*e].ty);
    match kind {
        ExprKind::Convert(a) => converted(known(a)?, type_of(a), types.get(ty)),
        ExprKind::Negate(a) => Some(match type_of(a) {
            Type::Float => u64::from(words(Opcode::Fneg, &[known(a)? as u32])?),
            Type::Double => double_bits(-f64::from_bits(known(a)?)),
            Type::Int(int) => int.wrap(known(a)?.wrapping_neg()),
            _ => return None,
        }),
        ExprKind::Complement(a) => match type_of(a) {
            Type::Int(int) => Some(int.wrap(!known(a)?)),
            _ => None,
        },
        ExprKind::LogicalNot(a) => Some(u64::from(!truth(known(a)?, type_of(a)))),
        ExprKind::Binary(op, l, r) => binary(*op, Class::of(types.get(ty)), known(l)?, known(r)?),
        ExprKind::Compare(relation, l, r) => {
            if Class::of(type_of(l)).is_vector() {
                return None;
            }
            let truth = compare(*relation, known(l)?, known(r)?, type_of(l));
            Some(u64::from(truth))
        }
        ExprKind::Logical(or, l, r) => match (truth(known(l)?, type_of(l)), or) {
            (true, true) => Some(1),
            (false, false) => Some(0),
            _ => Some(u64::from(truth(known(r)?, type_of(r)))),
        },
        ExprKind::Conditional(c, a, b) => known(if truth(known(c)?, type_of(c)) { a } else { b }),
        ExprKind::Offset(p, i, scale) => {
            let offset = (known(i)? as u32).wrapping_mul(*scale as u32);
            Some(u64::from((known(p)? as u32).wrapping_add(offset)))
        }
        _ => None,
    }
}

impl Checker<'_> {
    /// Returns the truth of a constant condition; `None` if the condition is not constant.
    pub(super) fn const_truth(&self, e: ExprId) -> Option<bool> {
        let ty = self.types.get(self.ty(e));
        self.const_value(e).map(|bits| truth(bits, ty))
    }

    /// The value of an integer constant expression and its type; an error for any other expression.
    pub(super) fn const_int(
        &mut self,
        e: crate::ast::ExprId,
        what: &str,
    ) -> Option<(i128, TypeId)> {
        self.const_int_or(e, what, None)
    }

    /// The same; the error has advice.
    pub(super) fn const_int_or(
        &mut self,
        e: crate::ast::ExprId,
        what: &str,
        advice: Option<&str>,
    ) -> Option<(i128, TypeId)> {
        let value = self.value(e);
        let ty = self.ty(value);
        if self.is_error(ty) {
            return None;
        }
        match self.const_value(value) {
            Some(bits) if self.types.is_integer(ty) => Some((number(bits, self.types.get(ty)), ty)),
            _ => {
                let span = self.span(value);
                let text = format!("{what} must be an integer constant");
                self.error_advice(NOT_CONSTANT, span, text, advice.map(str::to_owned));
                None
            }
        }
    }

    /// The constant that an expression is, addresses and vectors included.
    pub(super) fn constant(&self, e: ExprId) -> Option<Constant> {
        self.constant_at(e, 0)
    }

    fn constant_at(&self, e: ExprId, depth: u32) -> Option<Constant> {
        if depth > MAX_DEPTH {
            return None;
        }
        let expr = &self.body.exprs[e];
        let of = |e: ExprId| self.constant_at(e, depth + 1);
        match &expr.kind {
            ExprKind::Const(bits) => Some(Constant::Scalar(*bits)),
            ExprKind::Function(function) => {
                Some(Constant::Address(Address::Function(*function), 0))
            }
            ExprKind::AddressOf(place) => self.constant_address(*place, depth + 1),
            ExprKind::Convert(a) => {
                let same_size = self.types.size(expr.ty) == self.types.size(self.ty(*a));
                let bool = *self.types.get(expr.ty) == Type::Bool;
                of(*a).filter(|_| same_size && !bool)
            }
            ExprKind::Offset(p, i, scale) => match (of(*p)?, of(*i)?) {
                (Constant::Address(address, offset), Constant::Scalar(i)) => {
                    let more = (i as i32).wrapping_mul(*scale);
                    Some(Constant::Address(address, offset.wrapping_add(more)))
                }
                _ => None,
            },
            ExprKind::Splat(a) => match of(*a)? {
                Constant::Scalar(bits) => Some(Constant::Vector([bits as u32; 4])),
                _ => None,
            },
            ExprKind::Build(lanes) => {
                let mut words = [0; 4];
                for (word, &lane) in words.iter_mut().zip(lanes) {
                    match of(lane)? {
                        Constant::Scalar(bits) => *word = bits as u32,
                        _ => return None,
                    }
                }
                Some(Constant::Vector(words))
            }
            ExprKind::Negate(a) => {
                let op = match Class::of(self.types.get(expr.ty)) {
                    Class::Float4 => Opcode::Vfneg,
                    _ => return None,
                };
                let a = self.constant_vector(*a, depth)?;
                eval(op, &[a]).map(|v| Constant::Vector(v.0))
            }
            ExprKind::Binary(op, l, r) => {
                let class = Class::of(self.types.get(expr.ty));
                let Plan::Direct(op) = operator::binary(*op, class)? else {
                    return None;
                };
                let l = self.constant_vector(*l, depth)?;
                let r = self.constant_vector(*r, depth)?;
                eval(op, &[l, r]).map(|v| Constant::Vector(v.0))
            }
            ExprKind::Conditional(c, a, b) => match self.const_truth(*c)? {
                true => of(*a),
                false => of(*b),
            },
            _ => None,
        }
    }

    fn constant_vector(&self, e: ExprId, depth: u32) -> Option<Value> {
        match self.constant_at(e, depth + 1)? {
            Constant::Vector(lanes) => Some(ops::semantics::lanes::V4(lanes)),
            _ => None,
        }
    }

    /// The address of a place, where it is constant.
    pub(super) fn constant_address(&self, place: PlaceId, depth: u32) -> Option<Constant> {
        if depth > MAX_DEPTH {
            return None;
        }
        match &self.body.places[place].kind {
            PlaceKind::Object(object) => Some(Constant::Address(Address::Object(*object), 0)),
            PlaceKind::Deref(pointer) => self.constant_at(*pointer, depth + 1),
            PlaceKind::Member(outer, offset) => match self.constant_address(*outer, depth + 1)? {
                Constant::Address(address, more) => {
                    let offset = more.wrapping_add_unsigned(*offset);
                    Some(Constant::Address(address, offset))
                }
                Constant::Scalar(base) => {
                    let address = (base as u32).wrapping_add(*offset);
                    Some(Constant::Scalar(address.into()))
                }
                Constant::Vector(_) => None,
            },
            _ => None,
        }
    }
}
