//! Scalar and vector expressions.

use super::function::{Lowering, values_of};
use super::scalar::Scalar;
use crate::ctype::TypeId;
use crate::operator::{self, Class, Plan};
use crate::typed::{BinaryOp, ExprId, ExprKind, Step, Update};
use srp_archdesc::isa::{Kind, Opcode, Ty};
use srp_ir::program::{InstKind, Symbol, Terminator, Value};

impl Lowering<'_> {
    /// Computes an expression for its effects.
    pub(super) fn effect(&mut self, e: ExprId) {
        let body = self.body;
        let expr = &body.exprs[e];
        self.pos = expr.pos;
        let void = expr.ty == self.checked.types.known.void;
        match &expr.kind {
            _ if self.is_record(expr.ty) => {
                self.aggregate(e);
            }
            ExprKind::Convert(a) if void => self.effect(*a),
            ExprKind::Comma(..) => {
                let last = self.comma(e);
                self.effect(last);
            }
            ExprKind::Call(callee, args) => {
                self.call(*callee, args, None);
            }
            ExprKind::Conditional(c, a, b) if void => {
                let (then, other, join) = (
                    self.new_block(&[]),
                    self.new_block(&[]),
                    self.new_block(&[]),
                );
                self.branch(*c, then, other);
                for (block, arm) in [(then, *a), (other, *b)] {
                    self.enter(block);
                    self.effect(arm);
                    self.jump(join, Vec::new());
                }
                self.enter(join);
            }
            ExprKind::Operation(op, args, imm) if op.result().is_none() => {
                let args = self.operands(*op, args);
                self.pos = expr.pos;
                self.effect_op(*op, &args, *imm);
            }
            ExprKind::Const(_) => {}
            ExprKind::Unreachable => self.end(Terminator::Unreachable),
            ExprKind::Statements(list, last) => {
                list.iter().for_each(|&s| self.stmt(s));
                last.iter().for_each(|&e| self.effect(e));
            }
            _ if void => {}
            _ => {
                self.scalar(e);
            }
        }
    }

    /// Computes all but the last of expressions with commas between; the last.
    fn comma(&mut self, e: ExprId) -> ExprId {
        let mut firsts = Vec::new();
        let (mut next, mut last) = (e, e);
        while let ExprKind::Comma(first, second) = self.body.exprs[next].kind {
            if next == e {
                last = second;
            } else {
                firsts.push(second);
            }
            next = first;
        }
        firsts.push(next);
        for first in firsts.into_iter().rev() {
            self.effect(first);
        }
        last
    }

    /// The operand that is computed first and with which the rest of an expression goes on: the
    /// side that chains of operators grow on.
    fn left(&self, e: ExprId) -> Option<ExprId> {
        match self.body.exprs[e].kind {
            ExprKind::Binary(_, left, _)
            | ExprKind::Compare(_, left, _)
            | ExprKind::Offset(left, ..)
            | ExprKind::Distance(left, ..)
            | ExprKind::Convert(left)
            | ExprKind::Splat(left)
            | ExprKind::Negate(left)
            | ExprKind::Complement(left) => Some(left),
            _ => None,
        }
    }

    /// The value of an expression of one word or a vector.
    pub(super) fn value(&mut self, e: ExprId) -> Value {
        self.scalar(e).single()
    }

    /// The value of an expression of a scalar, pointer or vector type.
    pub(super) fn scalar(&mut self, e: ExprId) -> Scalar {
        let mut chain = Vec::new();
        let mut first = e;
        while let Some(left) = self.left(first) {
            chain.push(first);
            first = left;
        }
        let value = self.start(first);
        let mut value = self.held(first, value);
        for e in chain.into_iter().rev() {
            value = self.go_on(e, value);
            if let ExprKind::Binary(..) | ExprKind::Negate(_) | ExprKind::Complement(_) =
                self.body.exprs[e].kind
            {
                value = self.cut_pair(value, self.body.exprs[e].ty);
            }
        }
        value
    }

    /// The value of an expression that does not go on from another.
    fn start(&mut self, e: ExprId) -> Scalar {
        let body = self.body;
        let expr = &body.exprs[e];
        self.pos = expr.pos;
        Scalar::Single(match &expr.kind {
            ExprKind::Const(bits) => return self.scalar_constant(*bits, expr.ty),
            ExprKind::Load(place) => {
                let field = self.field(*place);
                self.pos = expr.pos;
                return self.read(field);
            }
            ExprKind::AddressOf(place) => {
                let location = self.location(*place);
                self.address(location)
            }
            ExprKind::Function(function) => {
                let symbol = Symbol::Func(self.symbols.func(*function));
                self.inst(InstKind::SymbolAddr(symbol, 0), Ty::Word)
            }
            ExprKind::LogicalNot(_) | ExprKind::Logical(..) => {
                let truth = self.pred(e);
                self.op(Opcode::Ptoi, &[truth])
            }
            ExprKind::Conditional(c, a, b) => return self.choose(*c, *a, *b, expr.ty),
            ExprKind::Assign(place, value) => {
                let value = self.scalar(*value);
                let field = self.field(*place);
                self.pos = expr.pos;
                return self.write(field, value);
            }
            ExprKind::Update(update) => return self.update(update, e),
            ExprKind::Comma(..) => {
                let last = self.comma(e);
                return self.scalar(last);
            }
            ExprKind::Call(callee, args) => {
                let result = self.call(*callee, args, None);
                return result.expect("a call whose value is used has one");
            }
            ExprKind::Operation(op, args, imm) => self.operation(*op, args, *imm, e),
            ExprKind::Build(lanes) => {
                let lanes = lanes.map(|lane| self.value(lane));
                self.pos = expr.pos;
                self.build(lanes)
            }
            ExprKind::Lane(vector, index) => self.lane(*vector, *index, expr.pos),
            ExprKind::Variadic => {
                let start = self.variadic;
                start.expect("checked: the function takes more arguments")
            }
            ExprKind::Statements(list, last) => {
                list.iter().for_each(|&s| self.stmt(s));
                let last = last.expect("checked: the statements have a value");
                return self.scalar(last);
            }
            ExprKind::Unreachable | ExprKind::Aggregate(_) => {
                unreachable!("a struct or nothing has no scalar value")
            }
            ExprKind::Binary(..)
            | ExprKind::Compare(..)
            | ExprKind::Offset(..)
            | ExprKind::Distance(..)
            | ExprKind::Convert(_)
            | ExprKind::Splat(_)
            | ExprKind::Negate(_)
            | ExprKind::Complement(_) => unreachable!("these go on from their left operand"),
        })
    }

    /// The value of an expression from that of its left operand.
    fn go_on(&mut self, e: ExprId, left: Scalar) -> Scalar {
        let body = self.body;
        let expr = &body.exprs[e];
        Scalar::Single(match &expr.kind {
            ExprKind::Binary(op, _, right) => {
                let right = self.scalar(*right);
                self.pos = expr.pos;
                let class = self.class(expr.ty);
                return self.binary(*op, class, left, right);
            }
            ExprKind::Compare(relation, l, right) => {
                let class = self.class(body.exprs[*l].ty);
                let right = self.scalar(*right);
                self.pos = expr.pos;
                if class.is_vector() {
                    let (left, right) = (left.single(), right.single());
                    return Scalar::Single(self.vector_relation(*relation, class, left, right));
                }
                let truth = self.scalar_relation(*relation, class, left, right);
                self.op(Opcode::Ptoi, &[truth])
            }
            ExprKind::Offset(_, index, scale) => {
                let index = self.value(*index);
                self.pos = expr.pos;
                self.scaled(left.single(), index, *scale)
            }
            ExprKind::Distance(_, right, size) => {
                let right = self.value(*right);
                self.pos = expr.pos;
                let bytes = self.op(Opcode::Sub, &[left.single(), right]);
                self.divided(bytes, *size)
            }
            ExprKind::Convert(a) => {
                self.pos = expr.pos;
                return self.convert(left, body.exprs[*a].ty, expr.ty);
            }
            ExprKind::Splat(_) => {
                self.pos = expr.pos;
                self.op(Opcode::Vsplat, &[left.single()])
            }
            ExprKind::Negate(_) => {
                self.pos = expr.pos;
                return self.negate(left, expr.ty);
            }
            ExprKind::Complement(_) => {
                self.pos = expr.pos;
                return self.complement(left, expr.ty);
            }
            _ => unreachable!("only expressions with a left operand come here"),
        })
    }

    /// Returns the class of a type's values.
    pub(super) fn class(&self, ty: TypeId) -> Class {
        Class::of(self.checked.types.get(ty))
    }

    fn negate(&mut self, value: Scalar, ty: TypeId) -> Scalar {
        let class = self.class(ty);
        let single = value.single();
        Scalar::Single(match class {
            Class::Float => self.op(Opcode::Fneg, &[single]),
            Class::Float4 => self.op(Opcode::Vfneg, &[single]),
            Class::Int4 => {
                let zero = self.word(0);
                let zero = self.op(Opcode::Vsplat, &[zero]);
                self.op(Opcode::Vsub, &[zero, single])
            }
            Class::Signed | Class::Unsigned => {
                let zero = self.word(0);
                self.op(Opcode::Sub, &[zero, single])
            }
            Class::Long | Class::ULong => {
                let zero = self.scalar_constant(0, ty);
                return self.pair_binary(BinaryOp::Sub, true, zero, value);
            }
            Class::Double => {
                let sign = self.scalar_constant(1 << 63, ty);
                return self.pair_binary(BinaryOp::Xor, true, value, sign);
            }
        })
    }

    fn complement(&mut self, value: Scalar, ty: TypeId) -> Scalar {
        if self.checked.types.is_wide(ty) {
            let ones = self.scalar_constant(u64::MAX, ty);
            return self.pair_binary(BinaryOp::Xor, true, value, ones);
        }
        let ones = self.word(u32::MAX);
        if self.checked.types.vector(ty).is_some() {
            let ones = self.op(Opcode::Vsplat, &[ones]);
            return Scalar::Single(self.op(Opcode::Vxor, &[value.single(), ones]));
        }
        Scalar::Single(self.op(Opcode::Xor, &[value.single(), ones]))
    }

    /// `l op r`.
    pub(super) fn binary(&mut self, op: BinaryOp, class: Class, l: Scalar, r: Scalar) -> Scalar {
        let plan = operator::binary(op, class).expect("the checker refuses operators without one");
        let (a, b) = (l.single(), r.single());
        Scalar::Single(match plan {
            Plan::Direct(op) => self.op(op, &[a, b]),
            Plan::Guarded(op) => {
                let guard = self.always();
                self.op(op, &[guard, a, b])
            }
            Plan::Pairs => return self.pair_binary(op, class == Class::Long, l, r),
            Plan::Support(support) => {
                let args = [l.values(), r.values()].concat();
                return self.support(support, &args, 2);
            }
            Plan::Lanes => {
                let scalar = match class {
                    Class::Float4 => Class::Float,
                    _ => Class::Signed,
                };
                let lanes = [0, 1, 2, 3].map(|lane| {
                    let l = self.op_imm(Opcode::Vext, &[a], lane);
                    let r = self.op_imm(Opcode::Vext, &[b], lane);
                    self.binary(op, scalar, Scalar::Single(l), Scalar::Single(r))
                        .single()
                });
                self.build(lanes)
            }
        })
    }

    /// An exact quotient of a distance in bytes.
    fn divided(&mut self, bytes: Value, size: u32) -> Value {
        if size == 1 {
            return bytes;
        }
        if size.is_power_of_two() {
            let count = self.word(size.trailing_zeros());
            return self.op(Opcode::Sar, &[bytes, count]);
        }
        let size = self.word(size);
        let guard = self.always();
        self.op(Opcode::Div, &[guard, bytes, size])
    }

    /// `c ? a : b` of scalars or vectors.
    fn choose(&mut self, c: ExprId, a: ExprId, b: ExprId, ty: TypeId) -> Scalar {
        let (then, other) = (self.new_block(&[]), self.new_block(&[]));
        let types = values_of(self.checked, ty).unwrap_or_default();
        let join = self.new_block(&types);
        self.branch(c, then, other);
        for (block, arm) in [(then, a), (other, b)] {
            self.enter(block);
            let value = self.scalar(arm);
            self.jump(join, value.values());
        }
        self.enter(join);
        let values = &self.func.blocks[join].params;
        Scalar::of(values).expect("a scalar is one or two values")
    }

    /// A compound assignment, `++` or `--`.
    fn update(&mut self, update: &Update, e: ExprId) -> Scalar {
        let body = self.body;
        let expr = &body.exprs[e];
        let operand = self.scalar(update.operand);
        let field = self.field(update.place);
        self.pos = expr.pos;
        let before = self.read(field);
        let after = match update.step {
            Step::Pointer(scale) => {
                Scalar::Single(self.scaled(before.single(), operand.single(), scale))
            }
            Step::Arithmetic(op, compute) => {
                let left = self.convert(before, expr.ty, compute);
                let class = self.class(compute);
                let result = self.binary(op, class, left, operand);
                self.convert(result, compute, expr.ty)
            }
        };
        let after = self.write(field, after);
        if update.post { before } else { after }
    }

    /// Operands of an opcode: conditions as predicates.
    pub(super) fn operands(&mut self, op: Opcode, args: &[ExprId]) -> Vec<Value> {
        let kinds = op.info().operands;
        let operands = args.iter().zip(kinds);
        operands
            .map(|(&arg, &kind)| match kind {
                Kind::P => self.pred(arg),
                _ => self.value(arg),
            })
            .collect()
    }

    fn operation(&mut self, op: Opcode, args: &[ExprId], imm: i32, e: ExprId) -> Value {
        let args = self.operands(op, args);
        self.pos = self.body.exprs[e].pos;
        // The same bits in another type.
        if op == Opcode::Mov {
            return args[0];
        }
        let value = self.op_imm(op, &args, imm);
        match op.result() {
            Some(Ty::Pred) => self.op(Opcode::Ptoi, &[value]),
            _ => value,
        }
    }
}
