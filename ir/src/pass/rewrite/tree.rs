//! Expressions: what the instructions of a function compute, and what is to be computed instead.

use crate::program::*;
use rustc_hash::FxHashMap;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Opcode, Ty};
use std::collections::BTreeSet;

/// An expression of floats, in one word or in each lane of a vector.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Tree {
    /// A value that is computed already.
    Value(Value),
    /// A constant, the same in all lanes.
    Constant(f32),
    /// An operation of words: the vector's is taken for it where the expression is of vectors.
    Op(Opcode, Vec<Tree>),
}

impl Tree {
    pub(super) fn sum(a: Tree, b: Tree) -> Tree {
        match (a, b) {
            (Tree::Constant(0.0), x) | (x, Tree::Constant(0.0)) => x,
            (Tree::Constant(a), Tree::Constant(b)) => Tree::Constant(a + b),
            (a, b) => Tree::Op(Opcode::Fadd, vec![a, b]),
        }
    }

    pub(super) fn difference(a: Tree, b: Tree) -> Tree {
        match (a, b) {
            (x, Tree::Constant(0.0)) => x,
            (Tree::Constant(a), Tree::Constant(b)) => Tree::Constant(a - b),
            (Tree::Constant(0.0), x) => x.negated(),
            (a, b) => Tree::Op(Opcode::Fsub, vec![a, b]),
        }
    }

    pub(super) fn product(a: Tree, b: Tree) -> Tree {
        match (a, b) {
            (Tree::Constant(1.0), x) | (x, Tree::Constant(1.0)) => x,
            (a, b) => Tree::Op(Opcode::Fmul, vec![a, b]),
        }
    }

    pub(super) fn quotient(a: Tree, b: Tree) -> Tree {
        Tree::Op(Opcode::Fdiv, vec![a, b])
    }

    pub(super) fn negated(self) -> Tree {
        match self {
            Tree::Constant(c) => Tree::Constant(-c),
            tree => Tree::Op(Opcode::Fneg, vec![tree]),
        }
    }

    /// a · b + c, fused or not.
    pub(super) fn scaled_sum(a: Tree, b: Tree, c: Tree, is_fused: bool) -> Tree {
        match (&c, is_fused) {
            (Tree::Constant(0.0), _) => Tree::product(a, b),
            (_, true) => Tree::Op(Opcode::Fma, vec![a, b, c]),
            (_, false) => Tree::sum(Tree::product(a, b), c),
        }
    }

    /// Makes the instructions, in order, and returns the value. Equal parts are made several times.
    pub(super) fn build(
        &self,
        func: &mut Function,
        ty: Ty,
        pos: Pos,
        made: &mut Vec<Inst>,
    ) -> Value {
        let (kind, ty) = match self {
            Tree::Value(value) => return *value,
            Tree::Constant(c) => {
                let bits = match ty {
                    Ty::Vec => Bits::Vec([c.to_bits(); 4]),
                    _ => Bits::Word(c.to_bits()),
                };
                (InstKind::Const(bits), ty)
            }
            Tree::Op(op, args) => {
                let args = args.iter().map(|arg| arg.build(func, ty, pos, made));
                let args = args.collect();
                let op = match ty {
                    Ty::Vec => in_lanes(*op).expect("rules for vectors take operations of lanes"),
                    _ => *op,
                };
                (InstKind::Op { op, args, imm: 0 }, ty)
            }
        };
        let inst = func.make_inst(kind, &[ty], pos);
        made.push(inst);
        func.insts[inst].results[0]
    }

    /// Operations, and those of the longest way through them; what is there already takes none.
    pub(super) fn size(&self) -> (usize, usize) {
        match self {
            Tree::Op(_, args) => {
                let mut size = (1, 0);
                for arg in args {
                    let (count, depth) = arg.size();
                    size = (size.0 + count, size.1.max(depth));
                }
                (size.0, size.1 + 1)
            }
            _ => (0, 0),
        }
    }
}

/// The operation of the lanes of vectors that one of words is.
fn in_lanes(op: Opcode) -> Option<Opcode> {
    Some(match op {
        Opcode::Fadd => Opcode::Vfadd,
        Opcode::Fsub => Opcode::Vfsub,
        Opcode::Fmul => Opcode::Vfmul,
        Opcode::Fma => Opcode::Vfma,
        Opcode::Fneg => Opcode::Vfneg,
        _ => return None,
    })
}

/// The operation of words that one of lanes is; others are themselves.
fn of_words(op: Opcode) -> Opcode {
    match op {
        Opcode::Vfadd => Opcode::Fadd,
        Opcode::Vfsub => Opcode::Fsub,
        Opcode::Vfmul => Opcode::Fmul,
        Opcode::Vfma => Opcode::Fma,
        Opcode::Vfneg => Opcode::Fneg,
        op => op,
    }
}

/// The instructions that make the values of a function.
pub(super) struct Made {
    by: FxHashMap<Value, Inst>,
    pub(super) uses: EntityMap<Value, u32>,
}

impl Made {
    pub(super) fn of(func: &Function) -> Made {
        let by = super::listed(func)
            .flat_map(|(_, inst)| func.insts[inst].results.iter().map(move |&v| (v, inst)));
        Made {
            by: by.collect(),
            uses: super::super::fast_math::uses(func),
        }
    }

    /// The operation, as one of words, and the operands that make a value.
    pub(super) fn operation<'f>(
        &self,
        func: &'f Function,
        value: Value,
    ) -> Option<(Opcode, &'f [Value])> {
        operation(func, *self.by.get(&value)?)
    }

    /// The float that a value always is, in all lanes.
    pub(super) fn constant(&self, func: &Function, value: Value) -> Option<f32> {
        match func.insts[*self.by.get(&value)?].kind {
            InstKind::Const(Bits::Word(word)) => Some(f32::from_bits(word)),
            InstKind::Const(Bits::Vec([a, b, c, d])) if a == b && b == c && c == d => {
                Some(f32::from_bits(a))
            }
            _ => None,
        }
    }

    /// A value as an expression.
    pub(super) fn tree(&self, func: &Function, value: Value) -> Tree {
        match self.constant(func, value) {
            Some(c) => Tree::Constant(c),
            None => Tree::Value(value),
        }
    }

    /// The instructions of sums and products that an instruction's result is made of, without itself.
    pub(super) fn below(&self, func: &Function, inst: Inst) -> BTreeSet<Inst> {
        let mut found = BTreeSet::new();
        let mut open = vec![inst];
        while let Some(at) = open.pop() {
            let Some((op, args)) = operation(func, at) else {
                continue;
            };
            if !is_sum_or_product(op) {
                continue;
            }
            let parts = args.iter().filter_map(|v| self.by.get(v).copied());
            open.extend(parts.filter(|&part| found.insert(part)));
        }
        found
    }
}

fn is_sum_or_product(op: Opcode) -> bool {
    use Opcode::{Fadd, Fma, Fmul, Fneg, Fsub};
    matches!(op, Fadd | Fsub | Fmul | Fma | Fneg)
}

/// The operation, as one of words, and the operands of an instruction.
pub(super) fn operation(func: &Function, inst: Inst) -> Option<(Opcode, &[Value])> {
    match &func.insts[inst].kind {
        InstKind::Op { op, args, .. } => Some((of_words(*op), args)),
        _ => None,
    }
}

/// Functions of the C library by what they compute.
pub(super) struct Library {
    powers: BTreeSet<Func>,
    roots: BTreeSet<Func>,
}

impl Library {
    pub(super) fn of(program: &Program) -> Library {
        let named = |name: &str| {
            let funcs = program.funcs.iter().filter(|(_, func)| {
                let file = program.files.get(func.pos.file);
                func.name == name && file.is_some_and(|file| super::is_library(file))
            });
            funcs.map(|(at, _)| at).collect()
        };
        Library {
            powers: named("powf"),
            roots: named("sqrtf"),
        }
    }
}

/// The expressions of a function.
pub(super) struct Expressions<'a> {
    pub(super) func: &'a Function,
    pub(super) made: Made,
    library: &'a Library,
}

impl<'a> Expressions<'a> {
    pub(super) fn of(func: &'a Function, library: &'a Library) -> Expressions<'a> {
        Expressions {
            func,
            made: Made::of(func),
            library,
        }
    }

    /// The operand of a value that is a square root, by the unit or the library.
    pub(super) fn root(&self, value: Value) -> Option<Value> {
        if let Some((Opcode::Sqrt, &[arg])) = self.made.operation(self.func, value) {
            return Some(arg);
        }
        let root = self.called(*self.made.by.get(&value)?, &self.library.roots)?;
        root.first().copied()
    }

    /// The operands of a call of `powf`.
    pub(super) fn power(&self, inst: Inst) -> Option<&'a [Value]> {
        self.called(inst, &self.library.powers)
    }

    /// The operands of a call of one of some functions.
    fn called(&self, inst: Inst, functions: &BTreeSet<Func>) -> Option<&'a [Value]> {
        match &self.func.insts[inst].kind {
            InstKind::Call {
                callee: Callee::Func(callee),
                args,
            } if functions.contains(callee) => Some(args),
            _ => None,
        }
    }
}
