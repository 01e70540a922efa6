//! The loop that runs a program.

use super::{
    End, Kernels, MAX_TOLD_CALLS, Options, Outcome, Profile, Stop, Trap, TrapKind, World, operate,
};
use crate::dre::scheduled::FUNC_BASE;
use crate::program::{
    self, Bits, Block, Callee, Func, Function, Inst, InstKind, Pos, Program, Slot, Symbol, Target,
    Terminator,
};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::Ty;
use srp_archdesc::ops::Value;

/// Most operands of an opcode.
const MAX_OPERANDS: usize = 3;

/// Where the slots of a function lie in its frame.
struct Frames {
    offsets: EntityMap<Slot, u32>,
    /// A multiple of 16.
    size: u64,
}

impl Frames {
    fn of(func: &Function) -> Frames {
        let mut next = 0u64;
        let mut offsets = EntityMap::new();
        for slot in func.slots.values() {
            next = next.next_multiple_of(u64::from(slot.align.max(1)));
            offsets.push(u32::try_from(next).unwrap_or(u32::MAX));
            next += u64::from(slot.size);
        }
        Frames {
            offsets,
            size: next.next_multiple_of(16),
        }
    }
}

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

pub(super) struct Machine<'a> {
    program: &'a Program,
    world: &'a mut dyn World,
    kernels: &'a mut dyn Kernels,
    options: &'a Options<'a>,
    slots: EntityMap<Func, Frames>,
    /// Values of all open calls.
    values: Vec<Value>,
    callers: Vec<Frame>,
    profile: Profile,
    steps_left: u64,
    /// Values on their way to parameters or results.
    moving: Vec<Value>,
}

impl<'a> Machine<'a> {
    pub(super) fn new(
        program: &'a Program,
        world: &'a mut dyn World,
        kernels: &'a mut dyn Kernels,
        options: &'a Options<'a>,
    ) -> Self {
        Machine {
            program,
            world,
            kernels,
            options,
            slots: program.funcs.values().map(Frames::of).collect(),
            values: Vec::new(),
            callers: Vec::new(),
            profile: Profile::new(program),
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
            .enter(func, self.options.layout.stack_top)
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
        self.options.layout.address(Symbol::Func(func))
    }

    /// Whether a function exists, takes these arguments and, if asked, has these results.
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
        if self.callers.len() >= self.options.depth {
            return Err(TrapKind::StackOverflow);
        }
        let floor = self.options.layout.image.len() as u64;
        let sp = u64::from(sp)
            .checked_sub(self.slots[func].size)
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
        let block = &func.blocks[frame.block];
        while let Some(&inst) = block.insts.get(frame.next) {
            let pos = func.insts[inst].pos;
            frame.next += 1;
            self.take_step().map_err(|stop| (stop, pos))?;
            let called = self.inst(frame, func, inst)?;
            if let Some(callee) = called {
                self.callers.push(std::mem::replace(frame, callee));
                return Ok(None);
            }
        }
        let at_end = |stop| (stop, block.end_pos);
        self.take_step().map_err(at_end)?;
        match &block.end {
            Terminator::Jump(target) => self.jump(frame, target),
            Terminator::Branch { cond, then, other } => {
                let taken = self.value(frame, *cond).as_pred();
                self.jump(frame, if taken { then } else { other });
            }
            Terminator::Return(results) => return Ok(self.leave(frame, results)),
            Terminator::Unreachable => return Err(at_end(Stop::Trap(TrapKind::Unreachable))),
        }
        Ok(None)
    }

    fn jump(&mut self, frame: &mut Frame, target: &Target) {
        // All arguments are read before the first parameter is written.
        self.pick(frame, &target.args);
        self.place(
            frame,
            &self.program.funcs[frame.func].blocks[target.block].params,
        );
        frame.block = target.block;
        frame.next = 0;
        self.profile.blocks[frame.func][target.block] += 1;
    }

    /// Closes a call; its results if it was the first.
    fn leave(&mut self, frame: &mut Frame, results: &[program::Value]) -> Option<Vec<Bits>> {
        self.pick(frame, results);
        self.values.truncate(frame.base);
        let Some(caller) = self.callers.pop() else {
            let tys = &self.program.funcs[frame.func].results;
            let bits = |(value, &ty): (&Value, &Ty)| Bits::of_lanes(ty, value.0);
            return Some(self.moving.iter().zip(tys).map(bits).collect());
        };
        *frame = caller;
        let func = &self.program.funcs[frame.func];
        let call = func.blocks[frame.block].insts[frame.next - 1];
        self.place(frame, &func.insts[call].results);
        None
    }

    /// Runs an instruction; the new frame if it is a call.
    fn inst(
        &mut self,
        frame: &Frame,
        func: &Function,
        inst: Inst,
    ) -> Result<Option<Frame>, (Stop, Pos)> {
        let data = &func.insts[inst];
        let here = |stop| (stop, data.pos);
        let result = match &data.kind {
            InstKind::Const(bits) => Some(Value::from(*bits)),
            InstKind::SymbolAddr(symbol, offset) => {
                let address = self.options.layout.address(*symbol);
                Some(Value::word(address.wrapping_add_signed(*offset)))
            }
            InstKind::SlotAddr(slot, offset) => {
                let address = frame.sp.wrapping_add(self.slots[frame.func].offsets[*slot]);
                Some(Value::word(address.wrapping_add_signed(*offset)))
            }
            InstKind::Op { op, args, imm } => {
                let mut operands = [Value::default(); MAX_OPERANDS];
                for (operand, &arg) in operands.iter_mut().zip(args) {
                    *operand = self.value(frame, arg);
                }
                operate(*op, &operands, *imm, &self.options.precision, self.world).map_err(here)?
            }
            InstKind::Call { callee, args } => {
                let callee = self.callee(frame, func, callee, args).map_err(here)?;
                self.pick(frame, args);
                let callee = self.enter(callee, frame.sp);
                return callee.map(Some).map_err(|kind| here(Stop::Trap(kind)));
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
                None
            }
        };
        if let (Some(value), Some(to)) = (result, data.results.first()) {
            self.values[frame.base + to.index()] = value;
        }
        Ok(None)
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
