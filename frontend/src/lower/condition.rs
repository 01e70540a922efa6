//! Conditions: expressions as predicates, and as ways to go.

use super::function::Lowering;
use crate::ctype::{Type, TypeId};
use crate::operator::{self, Class};
use crate::typed::{ExprId, ExprKind, Relation};
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::program::{Bits, Block, Target, Terminator, Value};

impl Lowering<'_> {
    /// Emits a predicate: true if the expression is not zero.
    pub(super) fn pred(&mut self, e: ExprId) -> Value {
        let body = self.body;
        let expr = &body.exprs[e];
        self.pos = expr.pos;
        match &expr.kind {
            ExprKind::Const(bits) => {
                let truth = self.const_truth(*bits, expr.ty);
                self.constant(Bits::Pred(truth))
            }
            ExprKind::Compare(relation, l, r) => {
                let class = self.class(body.exprs[*l].ty);
                let (l, r) = (self.scalar(*l), self.scalar(*r));
                self.pos = expr.pos;
                self.scalar_relation(*relation, class, l, r)
            }
            ExprKind::LogicalNot(a) => {
                let truth = self.pred(*a);
                self.pos = expr.pos;
                self.op(Opcode::Pnot, &[truth])
            }
            ExprKind::Logical(or, ..) => self.logical(*or, e),
            ExprKind::Operation(op, args, imm) if op.result() == Some(Ty::Pred) => {
                let args = self.operands(*op, args);
                self.pos = expr.pos;
                self.op_imm(*op, &args, *imm)
            }
            ExprKind::Convert(a) if *self.checked.types.get(expr.ty) == Type::Bool => self.pred(*a),
            _ => {
                let value = self.scalar(e);
                self.pos = expr.pos;
                self.scalar_not_zero(value, expr.ty)
            }
        }
    }

    /// True if a constant is not zero.
    fn const_truth(&self, bits: u64, ty: TypeId) -> bool {
        crate::check::truth(bits, self.checked.types.get(ty))
    }

    /// A relation of single words.
    pub(super) fn relation(
        &mut self,
        relation: Relation,
        class: Class,
        l: Value,
        r: Value,
    ) -> Value {
        let (op, swap, _) = operator::relation(relation, class);
        let (l, r) = if swap { (r, l) } else { (l, r) };
        self.op(op, &[l, r])
    }

    /// The operands of a chain of one logical operator, in order.
    fn logical_operands(&self, or: bool, e: ExprId) -> Vec<ExprId> {
        let mut operands = Vec::new();
        let mut first = e;
        loop {
            match self.body.exprs[first].kind {
                ExprKind::Logical(same, left, right) if same == or => {
                    operands.push(right);
                    first = left;
                }
                _ => break,
            }
        }
        operands.push(first);
        operands.reverse();
        operands
    }

    /// `&&` or `||` as a predicate: operands after the first are computed only where they count.
    fn logical(&mut self, or: bool, e: ExprId) -> Value {
        let operands = self.logical_operands(or, e);
        let join = self.new_block(&[Ty::Pred]);
        let (last, firsts) = operands
            .split_last()
            .expect("there are two operands at least");
        for &operand in firsts {
            let cond = self.pred(operand);
            let decided = self.constant(Bits::Pred(or));
            let next = self.new_block(&[]);
            let decided = Target {
                block: join,
                args: vec![decided],
            };
            let undecided = Target {
                block: next,
                args: Vec::new(),
            };
            let (then, other) = match or {
                true => (decided, undecided),
                false => (undecided, decided),
            };
            self.end(Terminator::Branch { cond, then, other });
            self.enter(next);
        }
        let value = self.pred(*last);
        self.jump(join, vec![value]);
        self.enter(join);
        self.func.blocks[join].params[0]
    }

    /// Goes one way where an expression is not zero, another where it is.
    pub(super) fn branch(&mut self, e: ExprId, then: Block, other: Block) {
        let body = self.body;
        let expr = &body.exprs[e];
        self.pos = expr.pos;
        match &expr.kind {
            ExprKind::Const(bits) => {
                let truth = self.const_truth(*bits, expr.ty);
                self.jump(if truth { then } else { other }, Vec::new());
            }
            ExprKind::LogicalNot(a) => self.branch(*a, other, then),
            ExprKind::Logical(or, ..) => {
                let operands = self.logical_operands(*or, e);
                let (last, firsts) = operands
                    .split_last()
                    .expect("there are two operands at least");
                for &operand in firsts {
                    let next = self.new_block(&[]);
                    match or {
                        true => self.branch(operand, then, next),
                        false => self.branch(operand, next, other),
                    }
                    self.enter(next);
                }
                self.branch(*last, then, other);
            }
            _ => {
                let cond = self.pred(e);
                self.pos = expr.pos;
                self.go(cond, then, other);
            }
        }
    }
}
