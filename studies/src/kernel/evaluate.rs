//! Evaluates a program on real numbers: its intermediate form as the front end gives it, before any pass,
//! run on a [`Number`].
//!
//! Words are either bits or a number that has not been rounded. Functions of `math.h` are taken for what they
//! compute, not for how. A program that looks at the bits of a number sees those of the nearest float; from
//! there on, it computes with that. Where intervals leave a decision open, the run follows
//! [`Decisions`].

use super::decisions::Decisions;
use super::memory::{Memory, Watched, Word, Words, bits};
use crate::real::{Number, Operation, Relation, Undefined};
use srp_archdesc::arch::Precision;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Class, Effect, Opcode};
use srp_archdesc::ops::{self, V4 as Lanes};
use srp_archdesc::ports;
use srp_ir::layout::Layout;
use srp_ir::program::{
    Block, Callee, Func, Function, Inst, InstKind, Program, Symbol, Terminator, Value,
};
use std::collections::BTreeMap;

/// Operations that a run may take.
const MOST_STEPS: u64 = 20_000_000;

/// Calls that may be open at once.
const MOST_CALLS: usize = 200;

fn truth<N>(holds: bool) -> Words<N> {
    bits(Lanes([u32::from(holds), 0, 0, 0]))
}

/// Why a run has no result.
pub(super) enum Stop {
    /// A number cannot be had.
    Undefined(Undefined),
    /// The program has ended itself.
    Exit,
}

impl From<Undefined> for Stop {
    fn from(undefined: Undefined) -> Stop {
        Stop::Undefined(undefined)
    }
}

fn stop(why: impl Into<String>) -> Stop {
    Stop::Undefined(Undefined(why.into()))
}

/// A function of the library by its name, and its operands.
fn library(program: &Program, func: Func) -> Option<(Operation, usize)> {
    let data = &program.funcs[func];
    let file = program.files.get(data.pos.file)?;
    srp_kernels::libc::at(file)?;
    let mut named = Operation::NAMED.iter();
    let (op, _, operands, _) = named.find(|(.., function)| *function == data.name)?;
    Some((*op, *operands))
}

/// A program that can be run on numbers.
pub(super) struct Meaning<'a> {
    program: &'a Program,
    layout: &'a Layout,
    library: EntityMap<Func, Option<(Operation, usize)>>,
}

impl<'a> Meaning<'a> {
    pub(super) fn of(program: &'a Program, layout: &'a Layout) -> Meaning<'a> {
        let library = program.funcs.keys().map(|func| library(program, func));
        Meaning {
            program,
            layout,
            library: library.collect(),
        }
    }

    /// The same with functions of `math.h` for how they compute.
    pub(super) fn literal(program: &'a Program, layout: &'a Layout) -> Meaning<'a> {
        Meaning {
            program,
            layout,
            library: program.funcs.keys().map(|_| None).collect(),
        }
    }

    /// Runs `main` on a memory whose words at some addresses are these.
    pub(super) fn run<N: Number>(
        &self,
        words: &BTreeMap<u32, Word<N>>,
        context: &N::Context,
        decisions: &mut Decisions,
    ) -> Result<Memory<N>, Undefined> {
        self.run_watched(words, Vec::new(), context, decisions)
    }

    /// The same, with an eye on the accesses to some bytes.
    pub(super) fn run_watched<N: Number>(
        &self,
        words: &BTreeMap<u32, Word<N>>,
        watched: Vec<Watched>,
        context: &N::Context,
        decisions: &mut Decisions,
    ) -> Result<Memory<N>, Undefined> {
        let mut run = Run {
            meaning: self,
            memory: Memory::new(words.clone(), self.layout.image.clone(), watched),
            context,
            decisions,
            steps: 0,
        };
        let Some(main) = self.program.main else {
            return Err(Undefined("there is no `main`".to_owned()));
        };
        let entry = &self.program.funcs[main].blocks[self.program.funcs[main].entry()];
        let args = entry
            .params
            .iter()
            .map(|_| bits(Lanes::default()))
            .collect();
        match run.call(main, args, self.layout.stack_top, 0) {
            Ok(_) | Err(Stop::Exit) => Ok(run.memory),
            Err(Stop::Undefined(undefined)) => Err(undefined),
        }
    }
}

struct Run<'a, N: Number> {
    meaning: &'a Meaning<'a>,
    memory: Memory<N>,
    context: &'a N::Context,
    decisions: &'a mut Decisions,
    steps: u64,
}

/// The values of an open call.
struct Frame<'f, N> {
    function: &'f Function,
    values: Vec<Words<N>>,
    /// Where its stack slots begin.
    slots: Vec<u32>,
    stack: u32,
    depth: usize,
}

impl<N: Number> Run<'_, N> {
    fn call(
        &mut self,
        func: Func,
        args: Vec<Words<N>>,
        stack: u32,
        depth: usize,
    ) -> Result<Vec<Words<N>>, Stop> {
        if let Some((op, operands)) = self.meaning.library[func] {
            let args: Vec<N> = args.iter().take(operands).map(|a| a[0].number()).collect();
            let result = N::apply(op, &args, self.context)?;
            let mut words = bits(Lanes::default());
            words[0] = Word::Real(result);
            return Ok(vec![words]);
        }
        if depth == MOST_CALLS {
            return Err(stop("too many calls are open at once"));
        }
        let function = &self.meaning.program.funcs[func];
        let mut stack = stack;
        let slots = function.slots.values().map(|slot| {
            stack = stack.wrapping_sub(slot.size) & !(slot.align.max(4) - 1);
            stack
        });
        let slots: Vec<u32> = slots.collect();
        if (stack as usize) < self.meaning.layout.image.len()
            || stack > self.meaning.layout.stack_top
        {
            return Err(stop("the stack is used up"));
        }
        let mut frame = Frame {
            function,
            values: vec![bits(Lanes::default()); function.values.len()],
            slots,
            stack,
            depth,
        };
        let mut block = function.entry();
        frame.bring(block, args);
        loop {
            for &inst in &function.blocks[block].insts {
                self.steps += 1;
                if self.steps > MOST_STEPS {
                    return Err(stop("the program runs for too long"));
                }
                self.instruction(&mut frame, inst)?;
            }
            let target = match &function.blocks[block].end {
                Terminator::Jump(target) => target,
                Terminator::Branch { cond, then, other } => {
                    match frame.get(*cond)[0].bits()? != 0 {
                        true => then,
                        false => other,
                    }
                }
                Terminator::Return(values) => {
                    return Ok(values.iter().map(|&v| frame.get(v).clone()).collect());
                }
                Terminator::Unreachable => return Err(stop("unreachable code is reached")),
            };
            let args = target.args.iter().map(|&v| frame.get(v).clone()).collect();
            frame.bring(target.block, args);
            block = target.block;
        }
    }

    fn instruction(&mut self, frame: &mut Frame<'_, N>, inst: Inst) -> Result<(), Stop> {
        let data = &frame.function.insts[inst];
        let result = match &data.kind {
            InstKind::Const(constant) => bits((*constant).into()),
            InstKind::SymbolAddr(symbol, offset) => {
                let address = self.meaning.layout.address(*symbol);
                bits(Lanes([address.wrapping_add_signed(*offset), 0, 0, 0]))
            }
            InstKind::SlotAddr(slot, offset) => {
                let address = frame.slots[srp_archdesc::entity::Entity::index(*slot)];
                bits(Lanes([address.wrapping_add_signed(*offset), 0, 0, 0]))
            }
            InstKind::Op { op, args, imm } => {
                let args: Vec<Words<N>> = args.iter().map(|&v| frame.get(v).clone()).collect();
                match self.operate(*op, &args, *imm)? {
                    Some(words) => words,
                    None => return Ok(()),
                }
            }
            InstKind::Call { callee, args } => {
                let func = match callee {
                    Callee::Func(func) => *func,
                    Callee::Indirect(target, _) => {
                        let address = frame.get(*target)[0].bits()?;
                        let mut all = self.meaning.program.funcs.keys();
                        let is =
                            |f: &Func| self.meaning.layout.address(Symbol::Func(*f)) == address;
                        all.find(is).ok_or_else(|| stop("a call of no function"))?
                    }
                };
                let args = args.iter().map(|&v| frame.get(v).clone()).collect();
                let results = self.call(func, args, frame.stack, frame.depth + 1)?;
                for (&to, words) in data.results.iter().zip(results) {
                    frame.set(to, words);
                }
                return Ok(());
            }
            InstKind::Launch { .. } => return Err(stop("the program is divided")),
        };
        if let Some(&to) = data.results.first() {
            frame.set(to, result);
        }
        Ok(())
    }

    fn operate(
        &mut self,
        op: Opcode,
        args: &[Words<N>],
        imm: i32,
    ) -> Result<Option<Words<N>>, Stop> {
        match op.info().effect {
            Effect::Pure => self.pure(op, args, imm).map(Some),
            Effect::Io if op == Opcode::Out && imm as u32 == ports::EXIT => Err(Stop::Exit),
            Effect::Io => Ok(op.result().map(|_| bits(Lanes::default()))),
            Effect::Prefetch => Ok(None),
            Effect::Load | Effect::Store => {
                let Some(bytes) = op.access_bytes() else {
                    return Err(stop("the program filters textures"));
                };
                let is_load = op.info().effect == Effect::Load;
                if args[0][0].bits()? == 0 {
                    return Ok(is_load.then(|| bits(Lanes::default())));
                }
                let address = args[1][0].bits()?.wrapping_add_signed(imm);
                if !is_load {
                    self.memory.store(address, bytes, &args[2])?;
                    return Ok(None);
                }
                let loaded = self.memory.load(address, bytes)?;
                match bytes < 4 {
                    true => {
                        let raw = Lanes([loaded[0].bits()?, 0, 0, 0]);
                        Ok(Some(bits(ops::loaded(op, raw))))
                    }
                    false => Ok(Some(loaded)),
                }
            }
        }
    }

    fn pure(&mut self, op: Opcode, args: &[Words<N>], imm: i32) -> Result<Words<N>, Stop> {
        use Opcode::*;
        let zero = || Word::Bits(0);
        let lane = (imm & 3) as usize;
        Ok(match op {
            Mov | Pmov | Vmov => args[0].clone(),
            Sel | Vsel | Psel => args[if args[0][0].bits()? != 0 { 1 } else { 2 }].clone(),
            Vsplat => std::array::from_fn(|_| args[0][0].clone()),
            Vext => [args[0][lane].clone(), zero(), zero(), zero()],
            Vins => {
                let mut words = args[0].clone();
                words[lane] = args[1][0].clone();
                words
            }
            Swz => std::array::from_fn(|i| args[0][(imm as u32 >> (2 * i) & 3) as usize].clone()),
            Vblend => {
                let mut words = args[2].clone();
                for (i, word) in words.iter_mut().enumerate() {
                    match args[0][i].bits()? {
                        0 => {}
                        u32::MAX => *word = args[1][i].clone(),
                        mask => {
                            let (a, b) = (args[1][i].bits()?, word.bits()?);
                            *word = Word::Bits(a & mask | b & !mask);
                        }
                    }
                }
                words
            }
            Itof | Utof | Vitof => {
                let lanes = if op == Vitof { 4 } else { 1 };
                each(lanes, |i| {
                    let word = args[0][i].bits()?;
                    let n = if op == Utof {
                        i64::from(word)
                    } else {
                        i64::from(word as i32)
                    };
                    Ok(Word::Real(N::of_integer(n, self.context)))
                })?
            }
            Ftoi | Ftou | Vftoi => {
                let lanes = if op == Vftoi { 4 } else { 1 };
                each(lanes, |i| {
                    let whole = args[0][i].number().whole();
                    let whole = whole
                        .ok_or_else(|| stop("an integer depends on a number that is not known"))?;
                    Ok(Word::Bits(match op {
                        Ftou => whole.clamp(0, i64::from(u32::MAX)) as u32,
                        _ => whole.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32 as u32,
                    }))
                })?
            }
            Feq | Fne | Flt | Fle | Vfeq | Vfne | Vflt | Vfle => self.compared(op, args)?,
            Dot3 | Dot4 => {
                let lanes = if op == Dot3 { 3 } else { 4 };
                let mut sum: Option<N> = None;
                for (a, b) in args[0].iter().zip(&args[1]).take(lanes) {
                    let pair = [a.number(), b.number()];
                    let product = N::apply(Operation::Mul, &pair, self.context)?;
                    sum = Some(match sum {
                        Some(sum) => N::apply(Operation::Add, &[sum, product], self.context)?,
                        None => product,
                    });
                }
                [sum.map_or(zero(), Word::Real), zero(), zero(), zero()]
            }
            And | Or | Xor | Vand | Vor | Vxor => self.bitwise(op, args)?,
            _ if matches!(op.class(), Class::Pair | Class::Vpair) => self.pair(op, args)?,
            _ => match float(op) {
                Some((operation, lanes)) => each(lanes, |i| {
                    let numbers: Vec<N> = args.iter().map(|a| a[i].number()).collect();
                    let unit = match op.class() {
                        Class::Fast => N::of_fast_unit,
                        _ => N::of_unit,
                    };
                    Ok(Word::Real(unit(operation, &numbers, self.context)?))
                })?,
                None => {
                    let mut plain = Vec::new();
                    for arg in args {
                        let mut lanes = Lanes::default();
                        for (to, word) in lanes.0.iter_mut().zip(arg) {
                            *to = word.bits()?;
                        }
                        plain.push(lanes);
                    }
                    let result = ops::eval(op, &plain, imm, &Precision::EXACT);
                    let result = result.map_err(|_| stop("an integer is divided by zero"))?;
                    bits(result.unwrap_or_default())
                }
            },
        })
    }

    /// Halves put together, taken apart, or computed with.
    fn pair(&mut self, op: Opcode, args: &[Words<N>]) -> Result<Words<N>, Stop> {
        use Opcode::*;
        let operation = match op {
            Hadd | Vhadd => Operation::Add,
            Hsub | Vhsub => Operation::Sub,
            Hmul | Vhmul => Operation::Mul,
            Hfma | Vhfma => Operation::Fma,
            Hmin | Vhmin => Operation::Min,
            _ => Operation::Max,
        };
        let lanes = if op.class() == Class::Pair { 1 } else { 4 };
        each(lanes, |i| {
            Ok(match op {
                Hpack | Vhpack => {
                    let [low, high] = [0, 1].map(|k| args[k][i].number().half());
                    Word::Pair(Box::new([low?, high?]))
                }
                Hlow | Vhlow => Word::Real(args[0][i].halves()?[0].clone()),
                Hhigh | Vhhigh => Word::Real(args[0][i].halves()?[1].clone()),
                _ => {
                    let words = args.iter().map(|arg| arg[i].halves());
                    let words = words.collect::<Result<Vec<_>, _>>()?;
                    let half = |k: usize| -> Result<N, Undefined> {
                        let numbers: Vec<N> = words.iter().map(|word| word[k].clone()).collect();
                        N::apply(operation, &numbers, self.context)?.half()
                    };
                    Word::Pair(Box::new([half(0)?, half(1)?]))
                }
            })
        })
    }

    fn compared(&mut self, op: Opcode, args: &[Words<N>]) -> Result<Words<N>, Stop> {
        use Opcode::*;
        use Relation::{Equal, Greater, Less, Unordered};
        let of: &[Relation] = match op {
            Feq | Vfeq => &[Equal],
            Fne | Vfne => &[Less, Greater, Unordered],
            Flt | Vflt => &[Less],
            _ => &[Less, Equal],
        };
        let is_vector = matches!(op, Vfeq | Vfne | Vflt | Vfle);
        let mut holds = |i: usize| {
            let relation = args[0][i].number().relate(&args[1][i].number());
            self.decisions.holds(relation, of)
        };
        if !is_vector {
            return Ok(truth(holds(0)));
        }
        Ok([0, 1, 2, 3].map(|i| Word::Bits(if holds(i) { u32::MAX } else { 0 })))
    }

    /// Logic on bits; of a number, its sign may be taken away, set or turned.
    fn bitwise(&mut self, op: Opcode, args: &[Words<N>]) -> Result<Words<N>, Stop> {
        use Opcode::*;
        const SIGN: u32 = 1 << 31;
        let lanes = if matches!(op, And | Or | Xor) { 1 } else { 4 };
        each(lanes, |i| {
            let (a, b) = (&args[0][i], &args[1][i]);
            let (number, mask) = match (a, b) {
                (Word::Real(number), Word::Bits(mask)) | (Word::Bits(mask), Word::Real(number)) => {
                    (number, *mask)
                }
                _ => (&a.number(), 0),
            };
            let one = std::slice::from_ref(number);
            let changed = match (op, mask) {
                (And | Vand, m) if m == !SIGN => Some(N::apply(Operation::Abs, one, self.context)?),
                (Xor | Vxor, SIGN) => Some(N::apply(Operation::Neg, one, self.context)?),
                (Or | Vor, SIGN) => {
                    let magnitude = N::apply(Operation::Abs, one, self.context)?;
                    Some(N::apply(Operation::Neg, &[magnitude], self.context)?)
                }
                _ => None,
            };
            if let (Some(number), Word::Real(_), _) | (Some(number), _, Word::Real(_)) =
                (changed, a, b)
            {
                return Ok(Word::Real(number));
            }
            let (a, b) = (a.bits()?, b.bits()?);
            Ok(Word::Bits(match op {
                And | Vand => a & b,
                Or | Vor => a | b,
                _ => a ^ b,
            }))
        })
    }
}

/// The first lanes; the others are zero.
fn each<N>(
    lanes: usize,
    mut word: impl FnMut(usize) -> Result<Word<N>, Stop>,
) -> Result<Words<N>, Stop> {
    let mut words = bits(Lanes::default());
    for (i, to) in words.iter_mut().enumerate().take(lanes) {
        *to = word(i)?;
    }
    Ok(words)
}

/// The operation on numbers that an opcode is, and its lanes.
fn float(op: Opcode) -> Option<(Operation, usize)> {
    use Opcode::*;
    Some(match op {
        Fadd => (Operation::Add, 1),
        Fsub => (Operation::Sub, 1),
        Fmul => (Operation::Mul, 1),
        Fma => (Operation::Fma, 1),
        Fdiv | FdivFast => (Operation::Div, 1),
        Fmin => (Operation::Min, 1),
        Fmax => (Operation::Max, 1),
        Fneg => (Operation::Neg, 1),
        Fabs => (Operation::Abs, 1),
        Ffloor => (Operation::Floor, 1),
        Rcp | RcpFast => (Operation::Rcp, 1),
        Rsqrt | RsqrtFast => (Operation::Rsqrt, 1),
        Sqrt | SqrtFast => (Operation::Sqrt, 1),
        Exp2 => (Operation::Exp2, 1),
        Log2 => (Operation::Log2, 1),
        Sin => (Operation::Sin, 1),
        Cos => (Operation::Cos, 1),
        Vfadd => (Operation::Add, 4),
        Vfsub => (Operation::Sub, 4),
        Vfmul => (Operation::Mul, 4),
        Vfma => (Operation::Fma, 4),
        Vfmin => (Operation::Min, 4),
        Vfmax => (Operation::Max, 4),
        Vfneg => (Operation::Neg, 4),
        Vfabs => (Operation::Abs, 4),
        Vffloor => (Operation::Floor, 4),
        _ => return None,
    })
}

impl<N: Number> Frame<'_, N> {
    fn get(&self, value: Value) -> &Words<N> {
        &self.values[srp_archdesc::entity::Entity::index(value)]
    }

    fn set(&mut self, value: Value, words: Words<N>) {
        self.values[srp_archdesc::entity::Entity::index(value)] = words;
    }

    /// Gives a block's parameters their values.
    fn bring(&mut self, block: Block, args: Vec<Words<N>>) {
        let function = self.function;
        for (&param, words) in function.blocks[block].params.iter().zip(args) {
            self.set(param, words);
        }
    }
}
