//! Constant expressions. Scalars are folded as they are made, by what the opcodes compute, so
//! that a constant is always an [`ExprKind::Const`]; addresses and vectors are found on demand.

use super::Checker;
use crate::ctype::{Type, TypeId, TypeTable};
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
    Word(u32),
    Vector([u32; 4]),
    Address(Address, i32),
}

/// What an opcode without guard gives on constants. The precision of special functions is the
/// machine's, so that these are not folded here.
fn eval(op: Opcode, args: &[Value]) -> Option<Value> {
    ops::eval(op, args, 0, &Precision::EXACT).ok().flatten()
}

fn words(op: Opcode, args: &[u32]) -> Option<u32> {
    let args: Vec<Value> = args.iter().map(|&w| Value::word(w)).collect();
    eval(op, &args).map(|v| v.as_word())
}

/// Whether a constant of this type is not zero.
fn truth(bits: u32, ty: &Type) -> bool {
    match ty {
        Type::Float => words(Opcode::Fne, &[bits, 0]) != Some(0),
        _ => bits != 0,
    }
}

/// A constant of one scalar type in another.
pub(super) fn converted(bits: u32, from: &Type, to: &Type) -> Option<u32> {
    if *to == Type::Bool {
        return Some(u32::from(truth(bits, from)));
    }
    let bits = match operator::conversion(from, to) {
        Some(op) => words(op, &[bits])?,
        None => bits,
    };
    Some(match to {
        Type::Int(int) => int.wrap(bits),
        _ => bits,
    })
}

/// What `l op r` gives on constants; `None` for a division by zero.
pub(super) fn binary(op: BinaryOp, class: Class, l: u32, r: u32) -> Option<u32> {
    match operator::binary(op, class)? {
        Plan::Direct(op) => words(op, &[l, r]),
        Plan::Guarded(op) => words(op, &[1, l, r]),
        Plan::Lanes => None,
    }
}

/// The value of an expression whose operands are constants.
pub(super) fn fold(
    kind: &ExprKind,
    ty: TypeId,
    exprs: &EntityMap<ExprId, Expr>,
    types: &TypeTable,
) -> Option<u32> {
    let known = |e: &ExprId| match exprs[*e].kind {
        ExprKind::Const(bits) => Some(bits),
        _ => None,
    };
    let type_of = |e: &ExprId| types.get(exprs[*e].ty);
    match kind {
        ExprKind::Convert(a) => converted(known(a)?, type_of(a), types.get(ty)),
        ExprKind::Negate(a) => match type_of(a) {
            Type::Float => words(Opcode::Fneg, &[known(a)?]),
            _ => Some(known(a)?.wrapping_neg()),
        },
        ExprKind::Complement(a) => Some(!known(a)?),
        ExprKind::LogicalNot(a) => Some(u32::from(!truth(known(a)?, type_of(a)))),
        ExprKind::Binary(op, l, r) => binary(*op, Class::of(types.get(ty)), known(l)?, known(r)?),
        ExprKind::Compare(relation, l, r) => {
            let class = Class::of(type_of(l));
            if class.is_vector() {
                return None;
            }
            let (op, swap, invert) = operator::relation(*relation, class);
            let (l, r) = (known(l)?, known(r)?);
            let (l, r) = if swap { (r, l) } else { (l, r) };
            Some(words(op, &[l, r])? ^ u32::from(invert))
        }
        ExprKind::Logical(or, l, r) => match (truth(known(l)?, type_of(l)), or) {
            (true, true) => Some(1),
            (false, false) => Some(0),
            _ => Some(u32::from(truth(known(r)?, type_of(r)))),
        },
        ExprKind::Conditional(c, a, b) => known(if truth(known(c)?, type_of(c)) { a } else { b }),
        ExprKind::Offset(p, i, scale) => {
            let offset = known(i)?.wrapping_mul(*scale as u32);
            Some(known(p)?.wrapping_add(offset))
        }
        _ => None,
    }
}

impl Checker<'_> {
    /// Whether a constant condition is true; `None` where it is not constant.
    pub(super) fn const_truth(&self, e: ExprId) -> Option<bool> {
        let ty = self.types.get(self.ty(e));
        self.const_value(e).map(|bits| truth(bits, ty))
    }

    /// The value of an integer constant expression; what is not one is an error.
    pub(super) fn const_int(&mut self, e: crate::ast::ExprId, what: &str) -> Option<(u32, TypeId)> {
        let value = self.value(e);
        let ty = self.ty(value);
        if self.is_error(ty) {
            return None;
        }
        match self.const_value(value) {
            Some(bits) if self.types.is_integer(ty) => Some((bits, ty)),
            _ => {
                let span = self.span(value);
                let text = format!("{what} must be an integer constant");
                self.error(NOT_CONSTANT, span, text, "");
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
            ExprKind::Const(bits) => Some(Constant::Word(*bits)),
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
                (Constant::Address(address, offset), Constant::Word(i)) => {
                    let more = (i as i32).wrapping_mul(*scale);
                    Some(Constant::Address(address, offset.wrapping_add(more)))
                }
                _ => None,
            },
            ExprKind::Splat(a) => match of(*a)? {
                Constant::Word(bits) => Some(Constant::Vector([bits; 4])),
                _ => None,
            },
            ExprKind::Build(lanes) => {
                let mut words = [0; 4];
                for (word, &lane) in words.iter_mut().zip(lanes) {
                    match of(lane)? {
                        Constant::Word(bits) => *word = bits,
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
    fn constant_address(&self, place: PlaceId, depth: u32) -> Option<Constant> {
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
                Constant::Word(base) => Some(Constant::Word(base.wrapping_add(*offset))),
                Constant::Vector(_) => None,
            },
            _ => None,
        }
    }
}
