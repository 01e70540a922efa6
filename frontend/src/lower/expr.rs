//! Scalar and vector expressions.

use super::function::Lowering;
use crate::ctype::{Int, Type, TypeId};
use crate::operator::{self, Class, Plan};
use crate::typed::{BinaryOp, ExprId, ExprKind, Step, Update};
use srp_archdesc::isa::{Kind, Opcode, Ty};
use srp_ir::program::{InstKind, Symbol, Value};

impl Lowering<'_> {
    /// Computes an expression for what it does.
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
            _ => {
                self.value(e);
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

    /// The value of an expression of a scalar, pointer or vector type.
    pub(super) fn value(&mut self, e: ExprId) -> Value {
        let mut chain = Vec::new();
        let mut first = e;
        while let Some(left) = self.left(first) {
            chain.push(first);
            first = left;
        }
        let mut value = self.start(first);
        for e in chain.into_iter().rev() {
            value = self.go_on(e, value);
        }
        value
    }

    /// The value of an expression that does not go on from another.
    fn start(&mut self, e: ExprId) -> Value {
        let body = self.body;
        let expr = &body.exprs[e];
        self.pos = expr.pos;
        match &expr.kind {
            ExprKind::Const(bits) => self.word(*bits),
            ExprKind::Load(place) => {
                let location = self.location(*place);
                self.pos = expr.pos;
                let access = self.access(expr.ty);
                self.load(location, access)
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
            ExprKind::Conditional(c, a, b) => self.choose(*c, *a, *b, expr.ty),
            ExprKind::Assign(place, value) => {
                let value = self.value(*value);
                let location = self.location(*place);
                self.pos = expr.pos;
                let access = self.access(expr.ty);
                self.store(location, access, value);
                value
            }
            ExprKind::Update(update) => self.update(update, e),
            ExprKind::Comma(..) => {
                let last = self.comma(e);
                self.value(last)
            }
            ExprKind::Call(callee, args) => {
                let result = self.call(*callee, args, None);
                result.expect("a call whose value is used has one")
            }
            ExprKind::Operation(op, args, imm) => self.operation(*op, args, *imm, e),
            ExprKind::Build(lanes) => {
                let lanes = lanes.map(|lane| self.value(lane));
                self.pos = expr.pos;
                self.build(lanes)
            }
            ExprKind::Lane(vector, index) => self.lane(*vector, *index, expr.pos),
            ExprKind::Aggregate(_) => unreachable!("a struct has no scalar value"),
            ExprKind::Binary(..)
            | ExprKind::Compare(..)
            | ExprKind::Offset(..)
            | ExprKind::Distance(..)
            | ExprKind::Convert(_)
            | ExprKind::Splat(_)
            | ExprKind::Negate(_)
            | ExprKind::Complement(_) => unreachable!("these go on from their left operand"),
        }
    }

    /// The value of an expression from that of its left operand.
    fn go_on(&mut self, e: ExprId, left: Value) -> Value {
        let body = self.body;
        let expr = &body.exprs[e];
        match &expr.kind {
            ExprKind::Binary(op, _, right) => {
                let right = self.value(*right);
                self.pos = expr.pos;
                let class = self.class(expr.ty);
                self.binary(*op, class, left, right)
            }
            ExprKind::Compare(relation, l, right) => {
                let class = self.class(body.exprs[*l].ty);
                let right = self.value(*right);
                self.pos = expr.pos;
                if class.is_vector() {
                    return self.vector_relation(*relation, class, left, right);
                }
                let truth = self.relation(*relation, class, left, right);
                self.op(Opcode::Ptoi, &[truth])
            }
            ExprKind::Offset(_, index, scale) => {
                let index = self.value(*index);
                self.pos = expr.pos;
                self.scaled(left, index, *scale)
            }
            ExprKind::Distance(_, right, size) => {
                let right = self.value(*right);
                self.pos = expr.pos;
                let bytes = self.op(Opcode::Sub, &[left, right]);
                self.divided(bytes, *size)
            }
            ExprKind::Convert(a) => {
                self.pos = expr.pos;
                self.convert(left, body.exprs[*a].ty, expr.ty)
            }
            ExprKind::Splat(_) => {
                self.pos = expr.pos;
                self.op(Opcode::Vsplat, &[left])
            }
            ExprKind::Negate(_) => {
                self.pos = expr.pos;
                self.negate(left, expr.ty)
            }
            ExprKind::Complement(_) => {
                self.pos = expr.pos;
                let ones = self.word(u32::MAX);
                if self.checked.types.vector(expr.ty).is_some() {
                    let ones = self.op(Opcode::Vsplat, &[ones]);
                    return self.op(Opcode::Vxor, &[left, ones]);
                }
                self.op(Opcode::Xor, &[left, ones])
            }
            _ => unreachable!("only expressions with a left operand come here"),
        }
    }

    /// What the values of a type are to the opcodes.
    pub(super) fn class(&self, ty: TypeId) -> Class {
        Class::of(self.checked.types.get(ty))
    }

    fn negate(&mut self, value: Value, ty: TypeId) -> Value {
        match self.class(ty) {
            Class::Float => self.op(Opcode::Fneg, &[value]),
            Class::Float4 => self.op(Opcode::Vfneg, &[value]),
            Class::Int4 => {
                let zero = self.word(0);
                let zero = self.op(Opcode::Vsplat, &[zero]);
                self.op(Opcode::Vsub, &[zero, value])
            }
            Class::Signed | Class::Unsigned => {
                let zero = self.word(0);
                self.op(Opcode::Sub, &[zero, value])
            }
        }
    }

    /// `l op r`.
    pub(super) fn binary(&mut self, op: BinaryOp, class: Class, l: Value, r: Value) -> Value {
        match operator::binary(op, class).expect("the checker refuses operators without a plan") {
            Plan::Direct(op) => self.op(op, &[l, r]),
            Plan::Guarded(op) => {
                let guard = self.always();
                self.op(op, &[guard, l, r])
            }
            Plan::Lanes => {
                let scalar = match class {
                    Class::Float4 => Class::Float,
                    _ => Class::Signed,
                };
                let lanes = [0, 1, 2, 3].map(|lane| {
                    let l = self.op_imm(Opcode::Vext, &[l], lane);
                    let r = self.op_imm(Opcode::Vext, &[r], lane);
                    self.binary(op, scalar, l, r)
                });
                self.build(lanes)
            }
        }
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

    /// A value of one type in another.
    pub(super) fn convert(&mut self, value: Value, from: TypeId, to: TypeId) -> Value {
        let types = &self.checked.types;
        let (source, target) = (types.get(from), types.get(to));
        if *target == Type::Bool {
            if *source == Type::Bool {
                return value;
            }
            let truth = self.not_zero(value, from);
            return self.op(Opcode::Ptoi, &[truth]);
        }
        if let (Type::Int(a), Type::Int(b)) = (source, target)
            && fits(*a, *b)
        {
            return value;
        }
        let value = match operator::conversion(source, target) {
            Some(op) => self.op(op, &[value]),
            None => value,
        };
        match target {
            Type::Int(int) if *source != Type::Bool => self.cut(value, *int),
            _ => value,
        }
    }

    /// `c ? a : b` of scalars or vectors.
    fn choose(&mut self, c: ExprId, a: ExprId, b: ExprId, ty: TypeId) -> Value {
        let (then, other) = (self.new_block(&[]), self.new_block(&[]));
        let join = self.new_block(&[self.access(ty).ty()]);
        self.branch(c, then, other);
        for (block, arm) in [(then, a), (other, b)] {
            self.enter(block);
            let value = self.value(arm);
            self.jump(join, vec![value]);
        }
        self.enter(join);
        self.func.blocks[join].params[0]
    }

    /// A compound assignment, `++` or `--`.
    fn update(&mut self, update: &Update, e: ExprId) -> Value {
        let body = self.body;
        let expr = &body.exprs[e];
        let operand = self.value(update.operand);
        let location = self.location(update.place);
        self.pos = expr.pos;
        let access = self.access(expr.ty);
        let before = self.load(location, access);
        let after = match update.step {
            Step::Pointer(scale) => self.scaled(before, operand, scale),
            Step::Arithmetic(op, compute) => {
                let left = self.convert(before, expr.ty, compute);
                let class = self.class(compute);
                let result = self.binary(op, class, left, operand);
                self.convert(result, compute, expr.ty)
            }
        };
        self.store(location, access, after);
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

/// Whether every value of one integer type is one of the other.
fn fits(from: Int, to: Int) -> bool {
    let wide = to.size() == 4;
    let same = from.signed() == to.signed();
    wide || from.size() <= to.size() && same || from.size() < to.size() && !from.signed()
}
