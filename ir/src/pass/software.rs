//! Operations of classes that no unit runs: vectors by lanes, scalars by functions of the library.
//!
//! The functions are ordinary C (`software.c` of the library), so what follows inlines them, unrolls
//! them and makes them part of kernels as anything else that a loop calls. They give the bits that
//! a unit gives.

use super::Remark;
use super::rename::Renames;
use crate::program::*;
use srp_archdesc::isa::{Class, Kind, Opcode, Ty};
use std::collections::BTreeMap;

/// The name of the remarks that tell it.
pub const SOFTWARE: &str = "software";

/// Replaces every operation of these classes. A program that lacks the function of an operation
/// keeps it.
pub(crate) fn software(
    program: &mut Program,
    classes: &[Class],
    remarks: &mut Vec<Remark>,
) -> bool {
    if classes.is_empty() {
        return false;
    }
    let by_name: BTreeMap<&str, Func> = (program.funcs.iter())
        .map(|(id, func)| (func.name.as_str(), id))
        .collect();
    let functions = Opcode::ALL.iter().filter_map(|&op| {
        let function = by_name.get(op.software()?.as_str())?;
        Some((op, *function))
    });
    let library = Library {
        classes,
        functions: functions.collect(),
    };
    let mut changed = false;
    for func in program.funcs.values_mut() {
        let counts = library.replace_in(func);
        changed |= !counts.is_empty();
        // The library's own functions are no concern of the user's.
        if func.name.starts_with("__srp_") {
            continue;
        }
        for (class, ops) in counts {
            let ops: Vec<String> = (ops.iter())
                .map(|(op, count)| format!("`{op}` {count}×"))
                .collect();
            remarks.push(Remark {
                pos: func.pos,
                pass: SOFTWARE,
                message: format!(
                    "no unit runs class `{class}`, so {} computes in software: {}",
                    func.name,
                    ops.join(", ")
                ),
            });
        }
    }
    changed
}

/// How often each operation of each class was replaced.
type Counts = BTreeMap<Class, BTreeMap<Opcode, u32>>;

/// The functions that stand in for operations.
struct Library<'a> {
    classes: &'a [Class],
    functions: BTreeMap<Opcode, Func>,
}

impl Library<'_> {
    fn lacks(&self, op: Opcode) -> bool {
        let class = op.class();
        self.classes.contains(&class)
    }

    /// Replaces the operations of one function, and counts them.
    fn replace_in(&self, func: &mut Function) -> Counts {
        let mut counts = Counts::new();
        let mut renames = Renames::default();
        for block in func.layout.clone() {
            let mut out = Vec::new();
            for inst in std::mem::take(&mut func.blocks[block].insts) {
                let InstKind::Op { op, args, .. } = &func.insts[inst].kind else {
                    out.push(inst);
                    continue;
                };
                let (op, args) = (*op, args.clone());
                let pos = func.insts[inst].pos;
                let mut code = Code {
                    library: self,
                    func,
                    out: &mut out,
                    pos,
                };
                match self.lacks(op).then(|| code.computed(op, &args)).flatten() {
                    Some(new) => {
                        renames.replace(func.insts[inst].results[0], new);
                        *(counts.entry(op.class()).or_default())
                            .entry(op)
                            .or_default() += 1;
                    }
                    None => out.push(inst),
                }
            }
            func.blocks[block].insts = out;
        }
        renames.apply(func);
        counts
    }
}

/// Where instructions are put.
struct Code<'a> {
    library: &'a Library<'a>,
    func: &'a mut Function,
    out: &'a mut Vec<Inst>,
    pos: Pos,
}

impl Code<'_> {
    fn make(&mut self, kind: InstKind, ty: Ty) -> Value {
        let inst = self.func.make_inst(kind, &[ty], self.pos);
        self.out.push(inst);
        self.func.insts[inst].results[0]
    }

    fn constant(&mut self, bits: u32) -> Value {
        self.make(InstKind::Const(Bits::Word(bits)), Ty::Word)
    }

    fn op(&mut self, op: Opcode, args: &[Value], imm: i32) -> Value {
        let ty = op.result().expect("these operations have results");
        let args = args.to_vec();
        self.make(InstKind::Op { op, args, imm }, ty)
    }

    /// The result of an operation of a class that no unit runs; `None` where nothing stands in for it.
    fn computed(&mut self, op: Opcode, args: &[Value]) -> Option<Value> {
        if let Some(scalar) = by_lanes(op) {
            return self.lanes(scalar, args);
        }
        match op {
            Opcode::Dot3 => self.dot(3, args),
            Opcode::Dot4 => self.dot(4, args),
            Opcode::Div | Opcode::Divu | Opcode::Rem | Opcode::Remu => {
                let (guard, operands) = args.split_first()?;
                let result = self.call(op, operands)?;
                let none = self.constant(0);
                Some(self.op(Opcode::Sel, &[*guard, result, none], 0))
            }
            _ => self.call(op, args),
        }
    }

    /// A scalar operation: by a unit, or by the function that stands in for it.
    fn scalar(&mut self, op: Opcode, args: &[Value]) -> Option<Value> {
        match self.library.lacks(op) {
            true => self.call(op, args),
            false => Some(self.op(op, args, 0)),
        }
    }

    fn call(&mut self, op: Opcode, args: &[Value]) -> Option<Value> {
        let callee = Callee::Func(*self.library.functions.get(&op)?);
        let args = args.to_vec();
        let result = self.make(InstKind::Call { callee, args }, Ty::Word);
        if op.result() != Some(Ty::Pred) {
            return Some(result);
        }
        let zero = self.constant(0);
        Some(self.op(Opcode::Ne, &[result, zero], 0))
    }

    /// A vector of what a scalar operation makes of each lane; predicates are lanes of ones.
    fn lanes(&mut self, scalar: Opcode, args: &[Value]) -> Option<Value> {
        let mut vector = None;
        for lane in 0..4 {
            let lanes: Vec<Value> = (args.iter())
                .map(|&arg| self.op(Opcode::Vext, &[arg], lane))
                .collect();
            let mut result = self.scalar(scalar, &lanes)?;
            if scalar.info().result == Some(Kind::P) {
                let (ones, zero) = (self.constant(u32::MAX), self.constant(0));
                result = self.op(Opcode::Sel, &[result, ones, zero], 0);
            }
            vector = Some(match vector {
                None => self.op(Opcode::Vsplat, &[result], 0),
                Some(vector) => self.op(Opcode::Vins, &[vector, result], lane),
            });
        }
        vector
    }

    /// The sum of the products of so many lanes, each step rounded.
    fn dot(&mut self, lanes: i32, args: &[Value]) -> Option<Value> {
        let mut sum = None;
        for lane in 0..lanes {
            let [a, b] = [args[0], args[1]].map(|arg| self.op(Opcode::Vext, &[arg], lane));
            let product = self.scalar(Opcode::Fmul, &[a, b])?;
            sum = Some(match sum {
                None => product,
                Some(sum) => self.scalar(Opcode::Fadd, &[sum, product])?,
            });
        }
        sum
    }
}

/// The operation that does to each lane what one on vectors does to all.
fn by_lanes(op: Opcode) -> Option<Opcode> {
    use Opcode::*;
    Some(match op {
        Vadd => Add,
        Vsub => Sub,
        Vand => And,
        Vor => Or,
        Vxor => Xor,
        Vshl => Shl,
        Vshr => Shr,
        Vsar => Sar,
        Vmin => Min,
        Vmax => Max,
        Veq => Eq,
        Vlt => Lt,
        Vltu => Ltu,
        Vmul => Mul,
        Vfadd => Fadd,
        Vfsub => Fsub,
        Vfmin => Fmin,
        Vfmax => Fmax,
        Vfneg => Fneg,
        Vfabs => Fabs,
        Vffloor => Ffloor,
        Vfeq => Feq,
        Vfne => Fne,
        Vflt => Flt,
        Vfle => Fle,
        Vitof => Itof,
        Vftoi => Ftoi,
        Vfmul => Fmul,
        Vfma => Fma,
        _ => return None,
    })
}
