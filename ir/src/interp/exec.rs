//! The loop that runs a program.

use super::decode::{Code, FuncCode, NONE, OpStep, Step};
use super::observe::{Done, Observer, Values};
use super::{
    End, Kernels, MAX_TOLD_CALLS, Options, Outcome, Profile, Stop, Trap, TrapKind, World, operate,
    pure,
};
use crate::dre::scheduled::FUNC_BASE;
use crate::program::{
    self, Bits, Block, Callee, Func, Function, Inst, InstKind, Pos, Program, Symbol, Target,
    Terminator,
};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Ty;
use srp_archdesc::ops::Value;

/// Most values of all open calls.
const MAX_VALUES: usize = 1 << 24;

/// A call in progress.
struct Frame {
    func: Func,
    block: Block,
    /// Index of the next instruction in the block.
    next: usize,
    /// Where its values start.
    base: usize,
    /// The stack pointer: where its slots start.
    sp: u32,
}

pub(super) struct Machine<'a, W, O> {
    code: &'a Code<'a>,
    program: &'a Program,
    world: &'a mut W,
    kernels: &'a mut dyn Kernels,
    observer: &'a mut O,
    options: &'a Options<'a>,
    /// Values of all open calls.
    values: Vec<Value>,
    callers: Vec<Frame>,
    profile: Profile,
    steps_left: u64,
    /// Values on their way to parameters or results.
    moving: Vec<Value>,
}

impl<'a, W: World, O: Observer<W>> Machine<'a, W, O> {
    pub(super) fn new(
        code: &'a Code<'a>,
        world: &'a mut W,
        kernels: &'a mut dyn Kernels,
        observer: &'a mut O,
        options: &'a Options<'a>,
    ) -> Self {
        Machine {
            code,
            program: code.program,
            world,
            kernels,
            observer,
            options,
            values: Vec::new(),
            callers: Vec::new(),
            profile: Profile::new(code.program),
            steps_left: options.steps,
            moving: Vec::new(),
        }
    }

    pub(super) fn run(mut self, func: Func, args: &[Bits]) -> Result<Outcome, Trap> {
        let tys: Vec<Ty> = args.iter().map(|bits| bits.ty()).collect();
        if !self.fits(func, &tys, None) {
            return Err(TrapKind::BadCall(self.address(func)).nowhere());
        }
        self.moving = args.iter().map(|bits| Value::from(*bits)).collect();
        let mut frame = self
            .enter(func, self.code.layout.stack_top)
            .map_err(|kind| kind.nowhere())?;
        let end = loop {
            match self.run_block(&mut frame) {
                Ok(None) => {}
                Ok(Some(results)) => break End::Returned(results),
                Err((Stop::Exit(status), _)) => break End::Exited(status),
                Err((Stop::Trap(kind), pos)) => {
                    return Err(Trap {
                        kind,
                        func: Some(frame.func),
                        pos,
                        calls: self.open_calls(),
                    });
                }
            }
        };
        self.profile.steps = self.options.steps - self.steps_left;
        Ok(Outcome {
            end,
            profile: self.profile,
        })
    }

    /// Who called whom, innermost first.
    fn open_calls(&self) -> Vec<(Func, Pos)> {
        let call = |frame: &Frame| {
            let func = &self.program.funcs[frame.func];
            let call = func.blocks[frame.block].insts[frame.next - 1];
            (frame.func, func.insts[call].pos)
        };
        let callers = self.callers.iter().rev().take(MAX_TOLD_CALLS);
        callers.map(call).collect()
    }

    fn address(&self, func: Func) -> u32 {
        self.code.layout.address(Symbol::Func(func))
    }

    /// True if a function exists, takes these arguments and, if asked, has these results.
    fn fits(&self, func: Func, args: &[Ty], results: Option<&[Ty]>) -> bool {
        let Some(data) = self.program.funcs.get(func) else {
            return false;
        };
        let params = &data.blocks[data.entry()].params;
        params
            .iter()
            .map(|&p| data.values[p])
            .eq(args.iter().copied())
            && results.is_none_or(|tys| tys == data.results)
    }

    /// Opens a call with the values in `moving` as arguments; `sp` is the caller's.
    fn enter(&mut self, func: Func, sp: u32) -> Result<Frame, TrapKind> {
        let values = self.values.len() + self.program.funcs[func].values.len();
        if self.callers.len() >= self.options.depth || values > MAX_VALUES {
            return Err(TrapKind::StackOverflow);
        }
        let floor = self.code.layout.image.len() as u64;
        let sp = u64::from(sp)
            .checked_sub(self.code.funcs[func].frame)
            .filter(|&sp| sp >= floor)
            .ok_or(TrapKind::StackOverflow)?;
        let data = &self.program.funcs[func];
        let frame = Frame {
            func,
            block: data.entry(),
            next: 0,
            base: self.values.len(),
            sp: sp as u32,
        };
        self.values
            .resize(frame.base + data.values.len(), Value::default());
        self.observer.enter(frame.base, data.values.len());
        self.profile.calls[func] += 1;
        self.profile.blocks[func][frame.block] += 1;
        self.place(&frame, &data.blocks[frame.block].params);
        Ok(frame)
    }

    /// Takes the values in `moving`.
    fn place(&mut self, frame: &Frame, to: &[program::Value]) {
        for (value, &to) in self.moving.iter().zip(to) {
            self.values[frame.base + to.index()] = *value;
        }
    }

    /// Puts values into `moving`.
    fn pick(&mut self, frame: &Frame, from: &[program::Value]) {
        self.moving.clear();
        let values = &self.values[frame.base..];
        self.moving.extend(from.iter().map(|v| values[v.index()]));
    }

    fn value(&self, frame: &Frame, value: program::Value) -> Value {
        self.values[frame.base + value.index()]
    }

    fn take_step(&mut self) -> Result<(), Stop> {
        self.steps_left = self
            .steps_left
            .checked_sub(1)
            .ok_or(Stop::Trap(TrapKind::StepLimit))?;
        Ok(())
    }

    /// Runs to the end of a block or into a call; results if the first call returned.
    fn run_block(&mut self, frame: &mut Frame) -> Result<Option<Vec<Bits>>, (Stop, Pos)> {
        let func = &self.program.funcs[frame.func];
        let code: &'a FuncCode = &self.code.funcs[frame.func];
        let block = &func.blocks[frame.block];
        let steps = &code.blocks[frame.block];
        let at = |step: &Step| match step {
            Step::Op(OpStep { inst, .. }) | Step::Other(inst) => func.insts[*inst].pos,
            Step::Const { .. } | Step::Slot { .. } => Pos::nowhere(),
        };
        while let Some(step) = steps.get(frame.next) {
            if self.take_step().is_err() {
                let pos = func.insts[block.insts[frame.next]].pos;
                return Err((Stop::Trap(TrapKind::StepLimit), pos));
            }
            frame.next += 1;
            match step {
                Step::Const { to, value } => self.set(frame, *to, *value),
                Step::Slot { to, offset } => {
                    self.set(frame, *to, Value::word(frame.sp.wrapping_add(*offset)));
                }
                Step::Op(op) => self.op(frame, op).map_err(|stop| (stop, at(step)))?,
                Step::Other(inst) => {
                    if let Some(callee) = self.leave_block(frame, func, *inst)? {
                        self.callers.push(std::mem::replace(frame, callee));
                        return Ok(None);
                    }
                }
            }
        }
        let at_end = |stop| (stop, block.end_pos);
        self.take_step().map_err(at_end)?;
        match &block.end {
            Terminator::Jump(target) => self.jump(frame, target),
            Terminator::Branch { cond, then, other } => {
                let taken = self.value(frame, *cond).as_pred();
                let number = frame.base + cond.index();
                self.observer.branch(number, taken, block.end_pos);
                self.jump(frame, if taken { then } else { other });
            }
            Terminator::Return(results) => return Ok(self.leave(frame, results)),
            Terminator::Unreachable => return Err(at_end(Stop::Trap(TrapKind::Unreachable))),
        }
        Ok(None)
    }

    /// A value that has no operands.
    #[inline]
    fn set(&mut self, frame: &Frame, to: u32, value: Value) {
        let to = frame.base + to as usize;
        self.values[to] = value;
        self.observer.constant(to);
    }

    /// Runs an operation.
    #[inline]
    fn op(&mut self, frame: &Frame, step: &OpStep) -> Result<(), Stop> {
        let args = step.args.map(|arg| frame.base + arg as usize);
        let operands = args.map(|arg| self.values[arg]);
        let precision = &self.options.precision;
        let value = if step.pure {
            pure(step.op, &operands, step.imm, precision)?
        } else {
            operate(step.op, &operands, step.imm, precision, self.world)?
        };
        let value = value.filter(|_| step.to != NONE);
        let result = value.map(|value| (frame.base + step.to as usize, value));
        if let Some((to, value)) = result {
            self.values[to] = value;
        }
        let done = Done {
            func: frame.func,
            inst: step.inst,
            op: step.op,
            imm: step.imm,
            args,
            operands: &operands,
            result,
        };
        self.observer.done(&done, self.world);
        Ok(())
    }

    fn jump(&mut self, frame: &mut Frame, target: &Target) {
        // All arguments are read before the first parameter is written.
        let params = &self.program.funcs[frame.func].blocks[target.block].params;
        self.pick(frame, &target.args);
        self.place(frame, params);
        let of = |values| Values {
            base: frame.base,
            values,
        };
        self.observer.moved(of(&target.args), of(params));
        frame.block = target.block;
        frame.next = 0;
        self.profile.blocks[frame.func][target.block] += 1;
    }

    /// Closes a call; its results if it was the first.
    fn leave(&mut self, frame: &mut Frame, results: &[program::Value]) -> Option<Vec<Bits>> {
        self.pick(frame, results);
        let from = Values {
            base: frame.base,
            values: results,
        };
        let Some(caller) = self.callers.pop() else {
            let tys = &self.program.funcs[frame.func].results;
            let bits = |(value, &ty): (&Value, &Ty)| Bits::of_lanes(ty, value.0);
            return Some(self.moving.iter().zip(tys).map(bits).collect());
        };
        *frame = caller;
        let func = &self.program.funcs[frame.func];
        let call = func.blocks[frame.block].insts[frame.next - 1];
        let to = &func.insts[call].results;
        self.place(frame, to);
        self.observer.moved(
            from,
            Values {
                base: frame.base,
                values: to,
            },
        );
        self.values.truncate(from.base);
        None
    }

    /// Runs a call or a launch; the new frame if it is a call.
    fn leave_block(
        &mut self,
        frame: &Frame,
        func: &Function,
        inst: Inst,
    ) -> Result<Option<Frame>, (Stop, Pos)> {
        let data = &func.insts[inst];
        let here = |stop| (stop, data.pos);
        match &data.kind {
            InstKind::Call { callee, args } => {
                let callee = self.callee(frame, func, callee, args).map_err(here)?;
                self.pick(frame, args);
                let callee = self.enter(callee, frame.sp);
                let callee = callee.map_err(|kind| here(Stop::Trap(kind)))?;
                let to = &self.program.funcs[callee.func];
                let of = |base, values| Values { base, values };
                self.observer.moved(
                    of(frame.base, args),
                    of(callee.base, &to.blocks[callee.block].params),
                );
                Ok(Some(callee))
            }
            InstKind::Launch { kernel, args } => {
                let bits: Vec<Bits> = args
                    .iter()
                    .map(|&arg| Bits::of_lanes(func.values[arg], self.value(frame, arg).0))
                    .collect();
                let outs = self
                    .kernels
                    .launch(*kernel, &bits, self.world, &mut self.steps_left)
                    .map_err(|trap| match trap.pos.line {
                        0 => here(Stop::Trap(trap.kind)),
                        _ => (Stop::Trap(trap.kind), trap.pos),
                    })?;
                self.moving = outs.into_iter().map(Value::from).collect();
                self.place(frame, &data.results);
                for to in &data.results {
                    self.observer.constant(frame.base + to.index());
                }
                Ok(None)
            }
            _ => unreachable!("constants, addresses and operations have steps of their own"),
        }
    }

    fn callee(
        &self,
        frame: &Frame,
        func: &Function,
        callee: &Callee,
        args: &[program::Value],
    ) -> Result<Func, Stop> {
        let (target, results) = match callee {
            Callee::Func(callee) => return Ok(*callee),
            Callee::Indirect(target, results) => (self.value(frame, *target).as_word(), results),
        };
        let tys: Vec<Ty> = args.iter().map(|&arg| func.values[arg]).collect();
        let offset = target.wrapping_sub(FUNC_BASE);
        let callee = Func::new((offset / 4) as usize);
        if offset % 4 == 0 && self.fits(callee, &tys, Some(results)) {
            Ok(callee)
        } else {
            Err(Stop::Trap(TrapKind::BadCall(target)))
        }
    }
}
