//! Constant folding, and the identities that hold bit for bit.
//!
//! There are no float identities but those of constants: `x + 0` changes −0 and `x · 1` a NaN.
//! Integers wrap, so sums may be regrouped: the constants of an address move into the immediate of
//! its load or store.

use super::defs::Defs;
use super::order::Stage;
use super::rename::Renames;
use crate::flow::Cfg;
use crate::program::*;
use srp_archdesc::arch::Precision;
use srp_archdesc::isa::{Effect, Opcode, Ty};
use srp_archdesc::ops;

mod compare;
mod divide;
mod integer;
mod lanes;
mod memory;
mod predicate;

/// How deep simplifications may ask for others.
const MAX_DEPTH: u32 = 12;

/// How far back they look for what a value may be.
const LOOK_BACK: u32 = 6;

/// Replaces operations by constants or by simpler operations that give the same bits on a machine
/// of this precision.
pub(crate) fn fold(func: &mut Function, precision: &Precision, stage: Stage) -> bool {
    let order = Cfg::of(func).order;
    let defs = Defs::within(func, &order);
    let mut folder = Folder {
        func,
        precision,
        stage,
        defs,
        renames: Renames::default(),
        out: Vec::new(),
        pos: Pos::nowhere(),
        depth: 0,
        changed: false,
    };
    for block in order {
        folder.block(block);
    }
    let Folder {
        func,
        mut renames,
        changed,
        ..
    } = folder;
    renames.apply(func);
    changed
}

struct Folder<'a> {
    func: &'a mut Function,
    precision: &'a Precision,
    stage: Stage,
    defs: Defs,
    renames: Renames,
    /// The instructions of the block so far.
    out: Vec<Inst>,
    /// The position that new instructions get.
    pos: Pos,
    depth: u32,
    changed: bool,
}

/// An operation as rules look at it: up to three operands, the last one repeated.
type Shape = (Opcode, [Value; 3], i32);

impl Folder<'_> {
    fn block(&mut self, block: Block) {
        self.out.clear();
        for inst in std::mem::take(&mut self.func.blocks[block].insts) {
            self.inst(inst);
        }
        self.func.blocks[block].insts = std::mem::take(&mut self.out);
        let renames = &self.renames;
        let end = &mut self.func.blocks[block].end;
        end.for_each_use_mut(|v| *v = renames.find(*v));
        // A branch on what is not, is the other branch.
        if let Terminator::Branch { cond, .. } = *end
            && let Some((Opcode::Pnot, [p, ..], _)) = self.op_of(cond)
            && let Terminator::Branch { cond, then, other } = &mut self.func.blocks[block].end
        {
            *cond = p;
            std::mem::swap(then, other);
            self.changed = true;
        }
    }

    fn inst(&mut self, inst: Inst) {
        let data = &mut self.func.insts[inst];
        let renames = &self.renames;
        data.kind.for_each_use_mut(|v| *v = renames.find(*v));
        self.pos = data.pos;
        let InstKind::Op { op, args, imm } = &data.kind else {
            return self.out.push(inst);
        };
        let (op, args, imm) = (*op, args.clone(), *imm);
        match op.info().effect {
            Effect::Pure => match self.simplify(op, &args, imm) {
                Some(value) => self.replace(inst, value),
                None => {
                    self.constant_last(inst);
                    self.out.push(inst);
                }
            },
            Effect::Load | Effect::Store => self.access(inst, op, args, imm),
            Effect::Prefetch | Effect::Io => self.out.push(inst),
        }
    }

    /// Drops an instruction, since `value` is its result.
    fn replace(&mut self, inst: Inst, value: Value) {
        let result = self.func.insts[inst].results[0];
        self.renames.replace(result, value);
        self.changed = true;
    }

    /// Puts a constant first operand of a commutative operation second.
    fn constant_last(&mut self, inst: Inst) {
        if let InstKind::Op { op, args, .. } = &self.func.insts[inst].kind
            && op.info().commutative
            && self.bits(args[0]).is_some()
            && self.bits(args[1]).is_none()
            && let InstKind::Op { args, .. } = &mut self.func.insts[inst].kind
        {
            args.swap(0, 1);
            self.changed = true;
        }
    }

    /// The instruction that defines a value.
    fn kind_of(&self, value: Value) -> Option<&InstKind> {
        self.defs.kind(self.func, value)
    }

    /// The constant that a value is.
    fn bits(&self, value: Value) -> Option<Bits> {
        match self.kind_of(value)? {
            InstKind::Const(bits) => Some(*bits),
            _ => None,
        }
    }

    fn word(&self, value: Value) -> Option<u32> {
        match self.bits(value)? {
            Bits::Word(word) => Some(word),
            _ => None,
        }
    }

    fn pred(&self, value: Value) -> Option<bool> {
        match self.bits(value)? {
            Bits::Pred(pred) => Some(pred),
            _ => None,
        }
    }

    /// The operation that gives a value.
    fn op_of(&self, value: Value) -> Option<Shape> {
        match self.kind_of(value)? {
            InstKind::Op { op, args, imm } => Some((*op, shape(args)?, *imm)),
            _ => None,
        }
    }

    /// True if two values are certainly the same.
    fn same(&self, a: Value, b: Value) -> bool {
        a == b || self.bits(a).is_some_and(|bits| self.bits(b) == Some(bits))
    }

    /// A constant, made here.
    fn constant(&mut self, bits: Bits) -> Value {
        self.make(InstKind::Const(bits), bits.ty())
    }

    fn int(&mut self, word: u32) -> Value {
        self.constant(Bits::Word(word))
    }

    fn truth(&mut self, pred: bool) -> Value {
        self.constant(Bits::Pred(pred))
    }

    fn make(&mut self, kind: InstKind, ty: Ty) -> Value {
        let inst = self.func.make_inst(kind, &[ty], self.pos);
        self.out.push(inst);
        self.defs.add(self.func, inst);
        self.func.insts[inst].results[0]
    }

    /// The value of an operation, made here if it does not simplify to one that is there.
    fn build(&mut self, op: Opcode, args: &[Value]) -> Value {
        self.build_imm(op, args, 0)
    }

    fn build_imm(&mut self, op: Opcode, args: &[Value], imm: i32) -> Value {
        if let Some(value) = self.simplify(op, args, imm) {
            return value;
        }
        let ty = op.result().expect("pure operations have a result");
        let args = args.to_vec();
        self.make(InstKind::Op { op, args, imm }, ty)
    }

    /// A simpler value with the same bits, if there is one.
    fn simplify(&mut self, op: Opcode, args: &[Value], imm: i32) -> Option<Value> {
        if self.depth == MAX_DEPTH {
            return None;
        }
        self.depth += 1;
        let value = self.evaluate(op, args, imm).or_else(|| {
            let mut operands = shape(args)?;
            if op.info().commutative && self.bits(operands[0]).is_some() {
                operands.swap(0, 1);
            }
            self.rules(op, operands, imm)
        });
        self.depth -= 1;
        value
    }

    /// The value of an operation on constants.
    fn evaluate(&mut self, op: Opcode, args: &[Value], imm: i32) -> Option<Value> {
        let constants: Option<Vec<ops::Value>> = args
            .iter()
            .map(|&arg| self.bits(arg).map(ops::Value::from))
            .collect();
        let value = ops::eval(op, &constants?, imm, self.precision).ok()??;
        Some(self.constant(Bits::of_lanes(op.result()?, value.0)))
    }

    fn rules(&mut self, op: Opcode, args: [Value; 3], imm: i32) -> Option<Value> {
        use Opcode::*;
        let [a, b, c] = args;
        match op {
            Mov | Pmov | Vmov => (imm == 0).then_some(a),
            Sel | Psel | Vsel => self.selection(op, a, b, c),
            Add | Sub | And | Or | Xor | Shl | Shr | Sar | Min | Max | Minu | Maxu | Mul => {
                self.integer(op, a, b)
            }
            Eq | Ne | Lt | Le | Ltu | Leu => self.comparison(op, a, b),
            Feq | Fne | Flt | Fle => self.two_valued(op, a, b),
            Fdiv => self.quotient(a, b),
            Div | Divu | Rem | Remu => self.division(op, a, b, c),
            Pand | Por | Pxor | Pnot | Ptoi => self.predicate(op, a, b),
            Vext | Vins | Swz | Vblend | Vadd | Vsub | Vand | Vor | Vxor => {
                self.lanes(op, args, imm)
            }
            _ => None,
        }
    }
}

fn shape(args: &[Value]) -> Option<[Value; 3]> {
    let last = *args.last()?;
    let mut shape = [last; 3];
    for (to, &arg) in shape.iter_mut().zip(args) {
        *to = arg;
    }
    Some(shape)
}
