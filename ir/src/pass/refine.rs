//! Newton–Raphson steps as operations of the program, for special functions that the machine
//! refines in code. Its unit returns a first approximation; the steps refine it to the same bits as
//! a unit that takes the steps itself ([`elementary`](srp_archdesc::ops::semantics::elementary)).

use super::rename::Renames;
use crate::program::*;
use srp_archdesc::arch::{Approx, Precision, Refine};
use srp_archdesc::isa::{Opcode, Ty};

/// Puts the steps behind every reciprocal and root that is refined in code. Runs once: afterwards
/// these operations are first approximations.
pub(crate) fn refine(func: &mut Function, precision: &Precision) -> bool {
    let mut renames = Renames::default();
    if *precision == precision.in_units() {
        return false;
    }
    for block in func.layout.clone() {
        let mut out = Vec::new();
        for inst in std::mem::take(&mut func.blocks[block].insts) {
            let InstKind::Op { op, args, .. } = &func.insts[inst].kind else {
                out.push(inst);
                continue;
            };
            let (op, args) = (*op, args.clone());
            let Some(newton) = Newton::of(op, precision) else {
                out.push(inst);
                continue;
            };
            let (old, pos) = (func.insts[inst].results[0], func.insts[inst].pos);
            let mut code = Code { func, out, pos };
            let new = match op {
                Opcode::Rcp => code.reciprocal(args[0], newton),
                Opcode::Rsqrt => code.inverse_root(args[0], newton),
                _ => code.root(args[0], newton),
            };
            out = code.out;
            renames.replace(old, new);
        }
        func.blocks[block].insts = out;
    }
    let changed = !renames.is_empty();
    renames.apply(func);
    changed
}

/// The refinement that follows a first approximation.
#[derive(Clone, Copy)]
struct Newton {
    steps: u32,
    fused: bool,
}

impl Newton {
    /// The refinement of an operation, if it is refined in code.
    fn of(op: Opcode, precision: &Precision) -> Option<Newton> {
        let approx = match op {
            Opcode::Rcp => precision.rcp,
            Opcode::Rsqrt => precision.rsqrt,
            Opcode::Sqrt => precision.sqrt,
            _ => return None,
        };
        match approx {
            Approx::Table {
                steps,
                fused,
                refine: Refine::Code,
                ..
            } => Some(Newton { steps, fused }),
            _ => None,
        }
    }
}

/// Where instructions are put.
struct Code<'a> {
    func: &'a mut Function,
    out: Vec<Inst>,
    pos: Pos,
}

impl Code<'_> {
    fn make(&mut self, kind: InstKind, ty: Ty) -> Value {
        let inst = self.func.make_inst(kind, &[ty], self.pos);
        self.out.push(inst);
        self.func.insts[inst].results[0]
    }

    fn op(&mut self, op: Opcode, args: &[Value]) -> Value {
        let ty = op.result().expect("these operations have results");
        let args = args.to_vec();
        self.make(InstKind::Op { op, args, imm: 0 }, ty)
    }

    fn constant(&mut self, x: f32) -> Value {
        self.make(InstKind::Const(Bits::Word(x.to_bits())), Ty::Word)
    }

    /// `better` where `least` is below `measure`, which is neither so where a step had to do with an
    /// infinity nor with a NaN; else `y` as it is.
    fn kept(&mut self, least: f32, measure: Value, better: Value, y: Value) -> Value {
        let least = self.constant(least);
        let sound = self.op(Opcode::Flt, &[least, measure]);
        self.op(Opcode::Sel, &[sound, better, y])
    }

    fn reciprocal(&mut self, x: Value, newton: Newton) -> Value {
        let mut y = self.op(Opcode::Rcp, &[x]);
        for _ in 0..newton.steps {
            y = if newton.fused {
                let (minus, one) = (self.op(Opcode::Fneg, &[x]), self.constant(1.0));
                let error = self.op(Opcode::Fma, &[minus, y, one]);
                let better = self.op(Opcode::Fma, &[y, error, y]);
                self.kept(-1.0, error, better, y)
            } else {
                let (product, two) = (self.op(Opcode::Fmul, &[x, y]), self.constant(2.0));
                let factor = self.op(Opcode::Fsub, &[two, product]);
                let better = self.op(Opcode::Fmul, &[y, factor]);
                self.kept(0.0, factor, better, y)
            };
        }
        y
    }

    fn inverse_root(&mut self, x: Value, newton: Newton) -> Value {
        let mut y = self.op(Opcode::Rsqrt, &[x]);
        for _ in 0..newton.steps {
            let along = self.op(Opcode::Fmul, &[x, y]);
            let half = self.constant(0.5);
            let halved = self.op(Opcode::Fmul, &[y, half]);
            y = if newton.fused {
                let (minus, one) = (self.op(Opcode::Fneg, &[along]), self.constant(1.0));
                let error = self.op(Opcode::Fma, &[minus, y, one]);
                let better = self.op(Opcode::Fma, &[halved, error, y]);
                self.kept(-1.0, error, better, y)
            } else {
                let (square, three) = (self.op(Opcode::Fmul, &[along, y]), self.constant(3.0));
                let factor = self.op(Opcode::Fsub, &[three, square]);
                let better = self.op(Opcode::Fmul, &[halved, factor]);
                self.kept(0.0, factor, better, y)
            };
        }
        y
    }

    /// x · 1/√x; the operand itself where that is 0 or infinite: it is twice itself there.
    fn root(&mut self, x: Value, newton: Newton) -> Value {
        let inverse = self.inverse_root(x, newton);
        let product = self.op(Opcode::Fmul, &[x, inverse]);
        let twice = self.op(Opcode::Fadd, &[inverse, inverse]);
        let itself = self.op(Opcode::Feq, &[inverse, twice]);
        self.op(Opcode::Sel, &[itself, x, product])
    }
}
