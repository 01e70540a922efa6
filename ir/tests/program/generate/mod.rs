//! Random programs: structured control flow, bounded loops, every opcode, memory and ports, none of
//! which traps or depends on where the stack is.

mod control;

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Class, Effect, Kind, Opcode, Space, Ty};
use srp_ir::interp::{self, FlatWorld, Options, Outcome, Trap};
use srp_ir::layout::Layout;
use srp_ir::program::*;

/// Bytes of each global, of each array slot, and of the window of system memory that is used.
const WINDOW: u32 = 64;
/// Bytes of system memory: behind the window, the descriptor of the texture that it is.
const MEMORY: usize = WINDOW as usize + 16;
/// Bytes of SRAM.
const SRAM: u32 = 64 << 10;
/// The port that programs write values to.
const TRACE: i32 = 20;
/// The port that programs read from; it has this many words.
const SOURCE: i32 = 21;

/// A program with a `main` of two words and a result of each type, made from a seed.
pub(crate) fn program(seed: u64) -> Program {
    let mut program = Program::default();
    program.files.push("random.c".to_owned());
    let mut rng = Pcg32::new(seed, 54);
    for name in ["table", "state"] {
        let init = (0..WINDOW).map(|_| rng.next_u32() as u8).collect();
        program.globals.push(GlobalData {
            name: name.to_owned(),
            size: WINDOW,
            align: 16,
            init,
            relocs: Vec::new(),
            pos: Pos::nowhere(),
        });
    }
    let count = 1 + rng.next_u32() % 3;
    for number in 0..=count {
        let name = match number == count {
            true => "main".to_owned(),
            false => format!("part{number}"),
        };
        let func = Maker::new(&program, &mut rng, &name).make();
        program.funcs.push(func);
    }
    program.main = Some(Func::new(count as usize));
    program
}

/// A program whose `main` computes on two words by operations that have many identities, on few
/// values and constants that matter to them, and writes each result to the trace port.
pub(crate) fn expressions(seed: u64) -> Program {
    let mut program = Program::default();
    program.files.push("random.c".to_owned());
    let mut rng = Pcg32::new(seed, 55);
    let mut maker = Maker::new(&program, &mut rng, "main");
    maker.func.results.clear();
    let ops: Vec<Opcode> = Opcode::ALL
        .iter()
        .copied()
        .filter(|op| has_identities(*op))
        .collect();
    let flag = maker.scope[0];
    let zero = maker.word(0);
    maker.value_of(Opcode::Lt, &[flag, zero]);
    maker.value_of(Opcode::Vsplat, &[flag]);
    for _ in 0..40 {
        let op = ops[maker.below(ops.len() as u32) as usize];
        let kinds = op.info().operands.iter();
        let args: Vec<Value> = kinds.map(|k| maker.simple(k.ty())).collect();
        let value = maker.operation(op, args);
        let ty = maker.func.values[value];
        let word = match ty {
            Ty::Pred => {
                maker
                    .func
                    .append_op(maker.block, Opcode::Ptoi, &[value], 0, Pos::nowhere())
            }
            Ty::Word => Some(value),
            Ty::Vec => maker
                .func
                .append_op(maker.block, Opcode::Vext, &[value], 2, Pos::nowhere()),
        };
        let word = word.expect("an opcode with a result");
        maker
            .func
            .append_op(maker.block, Opcode::Out, &[word], TRACE, Pos::nowhere());
        // Few values, so that they meet often.
        while maker.scope.len() > 14 {
            let at = maker.below(14);
            maker.scope.remove(at as usize);
        }
    }
    maker.end(Terminator::Return(vec![]));
    let func = maker.func;
    program.main = Some(program.funcs.push(func));
    program
}

fn has_identities(op: Opcode) -> bool {
    let lanes = [
        Opcode::Vext,
        Opcode::Vins,
        Opcode::Swz,
        Opcode::Vsplat,
        Opcode::Vblend,
    ];
    let class = matches!(
        op.class(),
        Class::Fadd | Class::Alu | Class::Imul | Class::Idiv | Class::Pred | Class::Valu
    );
    op.is_pure() && (class || lanes.contains(&op))
}

/// Runs `main` of a random program in a world of its own. Step limits are generous: a program that
/// reaches them is a mistake of the generator.
pub(crate) fn run(program: &Program) -> (Result<Outcome, Trap>, FlatWorld) {
    let layout = Layout::of(program, SRAM).expect("random programs are small");
    let mut world = FlatWorld::new(&layout, SRAM);
    world.memory = (0..WINDOW).map(|i| (i * 37) as u8).collect();
    for word in [interp::SYSTEM_BASE, 4, 4, 0] {
        world.memory.extend(word.to_le_bytes());
    }
    assert_eq!(world.memory.len(), MEMORY);
    world.inputs.insert(
        SOURCE as u32,
        (1..100_000)
            .map(|i: u32| i.wrapping_mul(0x9e37_79b9))
            .collect(),
    );
    let mut options = Options::new(&layout);
    options.steps = 4_000_000;
    let args = [Bits::Word(7), Bits::Word(0xffff_fff5)];
    let main = program.main.expect("random programs have a main");
    let outcome = interp::run(program, main, &args, &mut world, &options);
    // The stack is nobody's business.
    world.sram.truncate(layout.image.len());
    (outcome, world)
}

struct Maker<'a> {
    program: &'a Program,
    rng: &'a mut Pcg32,
    func: Function,
    /// The block being filled.
    block: Block,
    /// Values that may be used here.
    scope: Vec<Value>,
    line: u32,
    /// Statements still to be made.
    budget: u32,
    loops: u32,
    array: Slot,
}

impl<'a> Maker<'a> {
    fn new(program: &'a Program, rng: &'a mut Pcg32, name: &str) -> Self {
        let results = match name {
            "main" => vec![Ty::Word, Ty::Pred, Ty::Vec],
            _ => vec![Ty::Word],
        };
        let line = 100 * program.funcs.len() as u32 + 1;
        let pos = Pos {
            file: SourceFile::new(0),
            line,
            column: 1,
        };
        let mut func = Function::new(name, &[Ty::Word, Ty::Word], results, pos);
        let array = func.slots.push(SlotData {
            name: "array".to_owned(),
            size: WINDOW,
            align: 16,
        });
        let block = func.entry();
        Maker {
            program,
            rng,
            scope: func.blocks[block].params.clone(),
            func,
            block,
            line,
            budget: 40,
            loops: 0,
            array,
        }
    }

    fn make(mut self) -> Function {
        self.scope
            .push(self.func.values.keys().next().expect("two parameters"));
        for (slot, size, count) in [("word", 4, 2), ("vec", 16, 2)] {
            for number in 0..count {
                self.func.slots.push(SlotData {
                    name: format!("{slot}{number}"),
                    size,
                    align: size,
                });
            }
        }
        // Every byte of every slot is written before it is read.
        for slot in self.func.slots.keys() {
            let size = self.func.slots[slot].size;
            let guard = self.constant(Bits::Pred(true));
            for at in (0..size).step_by(4) {
                let value = self.any(Ty::Word);
                let address = self.slot_address(slot, at as i32);
                self.op(Opcode::Sw, &[guard, address, value], 0);
            }
        }
        self.statements(0);
        let tys = self.func.results.clone();
        let results = tys.into_iter().map(|ty| self.any(ty)).collect();
        self.end(Terminator::Return(results));
        self.func
    }

    fn below(&mut self, limit: u32) -> u32 {
        self.rng.next_u32() % limit
    }

    fn pos(&mut self) -> Pos {
        self.line += 1;
        Pos {
            file: SourceFile::new(0),
            line: self.line,
            column: 1 + self.line % 7,
        }
    }

    fn op(&mut self, op: Opcode, args: &[Value], imm: i32) -> Option<Value> {
        let pos = self.pos();
        let result = self.func.append_op(self.block, op, args, imm, pos);
        self.scope.extend(result);
        result
    }

    fn value_of(&mut self, op: Opcode, args: &[Value]) -> Value {
        self.op(op, args, 0).expect("an opcode with a result")
    }

    fn constant(&mut self, bits: Bits) -> Value {
        let pos = self.pos();
        let value = self.func.append_const(self.block, bits, pos);
        self.scope.push(value);
        value
    }

    fn word(&mut self, word: u32) -> Value {
        self.constant(Bits::Word(word))
    }

    fn end(&mut self, end: Terminator) {
        let pos = self.pos();
        self.func.blocks[self.block].end = end;
        self.func.blocks[self.block].end_pos = pos;
    }

    /// A value of a type: mostly one in scope, lately made ones more often, else a constant.
    fn any(&mut self, ty: Ty) -> Value {
        let fits: Vec<Value> = self
            .scope
            .iter()
            .copied()
            .filter(|&v| self.func.values[v] == ty)
            .collect();
        if !fits.is_empty() && self.below(8) != 0 {
            let back = self
                .below(fits.len() as u32)
                .min(self.below(fits.len() as u32));
            return fits[fits.len() - 1 - back as usize];
        }
        let word = |maker: &mut Self| match maker.below(4) {
            0 => maker.rng.next_u32(),
            1 => (maker.below(64) as f32 - 32.0).to_bits(),
            2 => 1 << maker.below(32),
            _ => maker.below(5).wrapping_sub(1),
        };
        let lanes = [word(self), word(self), word(self), word(self)];
        self.constant(match ty {
            Ty::Pred => Bits::Pred(lanes[0] & 1 != 0),
            _ => Bits::of_lanes(ty, lanes),
        })
    }

    fn slot_address(&mut self, slot: Slot, offset: i32) -> Value {
        let pos = self.pos();
        let kind = InstKind::SlotAddr(slot, offset);
        let inst = self.func.append(self.block, kind, &[Ty::Word], pos);
        // Not in scope: what a program computes must not depend on where its stack is.
        self.func.insts[inst].results[0]
    }

    fn statements(&mut self, depth: u32) {
        for _ in 0..1 + self.below(6) {
            if self.budget == 0 {
                return;
            }
            self.budget -= 1;
            match self.below(16) {
                0 | 1 if depth < 4 => self.branch(depth),
                2 if depth < 4 => self.short_circuit(depth),
                3 | 4 if self.loops < 3 => self.looped(depth),
                5 => self.call(),
                6 => self.port(),
                7..=10 => self.memory(),
                _ => self.compute(),
            }
        }
    }

    fn compute(&mut self) {
        for _ in 0..1 + self.below(4) {
            let op = Opcode::ALL[self.below(Opcode::ALL.len() as u32) as usize];
            if !op.is_pure() {
                continue;
            }
            let kinds = op.info().operands.iter();
            let args: Vec<Value> = kinds.map(|k: &Kind| self.any(k.ty())).collect();
            self.operation(op, args);
        }
    }

    /// A value, or one of the few constants that have identities.
    fn simple(&mut self, ty: Ty) -> Value {
        if self.below(2) == 0 {
            return self.any(ty);
        }
        let words = [0, 1, 2, 8, 16, 24, 31, 32, 0xff, 0x8000_0000, u32::MAX];
        let word = words[self.below(words.len() as u32) as usize];
        let lanes = if self.below(2) == 0 {
            [0; 4]
        } else {
            [u32::MAX; 4]
        };
        self.constant(match ty {
            Ty::Pred => Bits::Pred(word & 1 != 0),
            Ty::Word => Bits::Word(word),
            Ty::Vec => Bits::Vec(lanes),
        })
    }

    /// A pure operation, with a divisor that is not 0.
    fn operation(&mut self, op: Opcode, mut args: Vec<Value>) -> Value {
        if op.class() == Class::Idiv {
            if self.below(2) == 0 {
                let zero = self.word(0);
                args[0] = self.value_of(Opcode::Ne, &[args[2], zero]);
            } else {
                let bit = 1 << self.below(32);
                args[2] = self.word(bit);
            }
        }
        let imm = match op {
            Opcode::Vext | Opcode::Vins => self.below(4),
            Opcode::Swz => self.below(256),
            _ => 0,
        };
        self.op(op, &args, imm as i32)
            .expect("pure opcodes have a result")
    }

    /// An access at a place of its own in its window, computed or constant.
    fn memory(&mut self) {
        let accesses = |op: &&Opcode| op.space().is_some() || **op == Opcode::Prefetch;
        let ops: Vec<Opcode> = Opcode::ALL.iter().filter(accesses).copied().collect();
        let op = ops[self.below(ops.len() as u32) as usize];
        if op == Opcode::Tex {
            let guard = self.any(Ty::Pred);
            let none = self.below(4) == 0;
            let texture = self.word(if none {
                0
            } else {
                interp::SYSTEM_BASE + WINDOW
            });
            let coordinates = self.any(Ty::Vec);
            self.op(op, &[guard, texture, coordinates], 0);
            return;
        }
        if op == Opcode::Prefetch {
            // Anywhere, mapped or not.
            let (guard, address) = (self.any(Ty::Pred), self.any(Ty::Word));
            self.op(op, &[guard, address], 0);
            return;
        }
        let bytes = op.access_bytes().expect("an access");
        let mut at = bytes * self.below(WINDOW / bytes);
        let base = match (op.space(), self.below(3)) {
            (Some(Space::Cached), _) => self.word(interp::SYSTEM_BASE),
            (_, 0) => {
                let slot = Slot::new(self.below(self.func.slots.len() as u32) as usize);
                let size = self.func.slots[slot].size;
                if size < bytes {
                    return;
                }
                at %= size;
                let part = self.below(at + 1);
                at -= part;
                self.slot_address(slot, part as i32)
            }
            (_, 1) => self.slot_address(self.array, 0),
            _ => {
                let pos = self.pos();
                let global = Global::new(self.below(2) as usize);
                let kind = InstKind::SymbolAddr(Symbol::Global(global), 0);
                let inst = self.func.append(self.block, kind, &[Ty::Word], pos);
                self.func.insts[inst].results[0]
            }
        };
        let mut address = base;
        if self.below(3) == 0 && !self.is_slot_part(base) {
            let index = self.any(Ty::Word);
            let mask = self.word(WINDOW - bytes);
            let index = self.value_of(Opcode::And, &[index, mask]);
            // Not in scope, as slot addresses are not.
            address = self.value_of(Opcode::Add, &[base, index]);
            self.scope.pop();
            at = 0;
        }
        let guard = match self.below(3) {
            0 => self.any(Ty::Pred),
            _ => self.constant(Bits::Pred(true)),
        };
        let mut args = vec![guard, address];
        if op.info().effect == Effect::Store {
            let ty = op.info().operands[2].ty();
            args.push(self.any(ty));
        }
        self.op(op, &args, at as i32);
    }

    /// True if a value is the address of a slot smaller than the window, or of a place inside a
    /// slot.
    fn is_slot_part(&self, base: Value) -> bool {
        self.func.insts.values().any(|inst| match inst.kind {
            InstKind::SlotAddr(slot, offset) => {
                let small = self.func.slots[slot].size < WINDOW;
                inst.results.contains(&base) && (small || offset != 0)
            }
            _ => false,
        })
    }

    fn port(&mut self) {
        if self.below(3) == 0 {
            self.op(Opcode::In, &[], SOURCE);
        } else {
            let value = self.any(Ty::Word);
            self.op(Opcode::Out, &[value], TRACE);
        }
    }

    fn call(&mut self) {
        let count = self.program.funcs.len() as u32;
        if count == 0 || self.loops > 1 {
            return;
        }
        let func = Func::new(self.below(count) as usize);
        let args = vec![self.any(Ty::Word), self.any(Ty::Word)];
        let pos = self.pos();
        let callee = match self.below(4) {
            0 => {
                let kind = InstKind::SymbolAddr(Symbol::Func(func), 0);
                let inst = self.func.append(self.block, kind, &[Ty::Word], pos);
                Callee::Indirect(self.func.insts[inst].results[0], vec![Ty::Word])
            }
            _ => Callee::Func(func),
        };
        let kind = InstKind::Call { callee, args };
        let inst = self.func.append(self.block, kind, &[Ty::Word], pos);
        self.scope.push(self.func.insts[inst].results[0]);
    }
}
