//! Random functions around one loop, of every form that the array takes: all exit tests, parameters
//! of all types that follow one another, affine and other addresses, guards, values used afterwards.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use srp_archdesc::isa::{Class, Effect, Opcode, Ty};
use srp_ir::program::*;

/// Bytes of each object.
const OBJECT: u32 = 8192;
/// Addresses of the loop start here in their object.
const MIDDLE: i32 = 4096;
/// Iterations that addresses are made for; loops that run longer may trap.
const MOST: i32 = 16;

struct Maker {
    rng: Pcg32,
    func: Function,
    block: Block,
    words: Vec<Value>,
    preds: Vec<Value>,
    vecs: Vec<Value>,
    /// Addresses of objects.
    objects: Vec<Value>,
}

/// A program of one function with a marked loop. Arguments are three words and a pointer to the
/// first global.
pub(crate) fn program(seed: u64) -> Program {
    let mut rng = Pcg32::new(seed, 7);
    let mut program = Program::default();
    program.files.push("loop.c".to_owned());
    for name in ["a", "b"] {
        let init = (0..OBJECT).map(|_| rng.next_u32() as u8).collect();
        program.globals.push(GlobalData {
            name: name.to_owned(),
            size: OBJECT,
            align: 16,
            init,
            relocs: Vec::new(),
            pos: pos(1),
        });
    }
    let func = Function::new("f", &[Ty::Word; 4], Vec::new(), pos(2));
    let block = func.entry();
    let mut maker = Maker {
        rng,
        func,
        block,
        words: Vec::new(),
        preds: Vec::new(),
        vecs: Vec::new(),
        objects: Vec::new(),
    };
    maker.make(&program);
    program.funcs.push(maker.func);
    program
}

fn pos(line: u32) -> Pos {
    Pos {
        line,
        column: 1,
        ..Pos::nowhere()
    }
}

/// A loop parameter whose next value is decided when the body stands.
struct Carried {
    value: Value,
    next: Option<Value>,
}

impl Maker {
    fn below(&mut self, n: u32) -> u32 {
        self.rng.next_u32() % n
    }

    fn chance(&mut self, percent: u32) -> bool {
        self.below(100) < percent
    }

    fn pool(&mut self, ty: Ty) -> &mut Vec<Value> {
        match ty {
            Ty::Pred => &mut self.preds,
            Ty::Word => &mut self.words,
            Ty::Vec => &mut self.vecs,
        }
    }

    /// Any value of a type; late ones are likelier.
    fn pick(&mut self, ty: Ty) -> Value {
        let len = self.pool(ty).len() as u32;
        let (a, b) = (self.below(len), self.below(len));
        self.pool(ty)[a.max(b) as usize]
    }

    fn any_ty(&mut self) -> Ty {
        match self.below(8) {
            0..=1 => Ty::Pred,
            2 => Ty::Vec,
            _ => Ty::Word,
        }
    }

    fn constant(&mut self, bits: Bits) -> Value {
        self.func.append_const(self.block, bits, pos(3))
    }

    fn word(&mut self, w: i32) -> Value {
        self.constant(Bits::Word(w as u32))
    }

    fn op(&mut self, op: Opcode, args: &[Value], imm: i32) -> Option<Value> {
        let line = 10 + self.func.insts.len() as u32;
        self.func.append_op(self.block, op, args, imm, pos(line))
    }

    fn op2(&mut self, op: Opcode, a: Value, b: Value) -> Value {
        self.op(op, &[a, b], 0).expect("has a result")
    }

    fn make(&mut self, program: &Program) {
        let params = self.func.blocks[self.block].params.clone();
        self.words.extend(&params[..3]);
        self.outer_values(program, params[3]);
        // The induction variable: start and stride.
        let start = match self.below(4) {
            0 => params[0],
            1 => self.op2(Opcode::Add, params[0], params[1]),
            _ => {
                let w = self.below(7) as i32 - 3;
                self.word(w)
            }
        };
        let strides = [1, 1, 1, -1, -1, 2, 4, -4, 3, -3, 12, -6, 8, 5];
        let stride = strides[self.below(strides.len() as u32) as usize];
        let body = self.func.add_block();
        let after = self.func.add_block();
        let i = self.func.add_param(body, Ty::Word);
        let mut carried = self.carried(body);
        self.func.blocks[body].kernel = Some(KernelMark {
            name: "k".to_owned(),
            pos: pos(4),
            required: true,
            nest: false,
            slower: None,
            restrict: Vec::new(),
            independence: Default::default(),
        });
        let entry_args: Vec<Value> = self.entry_args(start, &carried);
        self.enter_loop(body, entry_args);
        self.block = body;
        self.words.push(i);
        for c in &carried {
            let ty = self.func.values[c.value];
            self.pool(ty).push(c.value);
        }
        self.pointers(&mut carried);
        for _ in 0..2 + self.below(14) {
            self.body_step(i, stride);
        }
        let step = self.word(stride);
        let next = self.op2(Opcode::Add, i, step);
        let (cond, sense) = self.exit_test(i, next, stride, start);
        let mut nexts = vec![next];
        for c in &carried {
            let ty = self.func.values[c.value];
            let next = match c.next {
                Some(next) => next,
                None if self.chance(25) => c.value,
                None => self.pick(ty),
            };
            nexts.push(next);
        }
        self.leave_loop(body, after, cond, sense, nexts, i);
    }

    /// Values from before the loop.
    fn outer_values(&mut self, program: &Program, pointer: Value) {
        for bits in [Bits::Word(3), Bits::Word(0x4048_f5c3), Bits::Pred(true)] {
            let value = self.constant(bits);
            self.pool(bits.ty()).push(value);
        }
        let splat = self.op(Opcode::Vsplat, &[self.words[0]], 0);
        self.vecs.extend(splat);
        let less = self.op2(Opcode::Lt, self.words[0], self.words[1]);
        self.preds.push(less);
        for global in program.globals.keys() {
            let kind = InstKind::SymbolAddr(Symbol::Global(global), MIDDLE);
            let inst = self.func.append(self.block, kind, &[Ty::Word], pos(3));
            self.objects.push(self.func.insts[inst].results[0]);
        }
        let slot = self.func.slots.push(SlotData {
            name: "local".to_owned(),
            size: OBJECT,
            align: 16,
        });
        let kind = InstKind::SlotAddr(slot, MIDDLE);
        let inst = self.func.append(self.block, kind, &[Ty::Word], pos(3));
        self.objects.push(self.func.insts[inst].results[0]);
        let middle = self.word(MIDDLE);
        let inside = self.op2(Opcode::Add, pointer, middle);
        self.objects.push(inside);
    }

    fn carried(&mut self, body: Block) -> Vec<Carried> {
        let count = self.below(5);
        let mut list = Vec::new();
        for _ in 0..count {
            let ty = self.any_ty();
            let value = self.func.add_param(body, ty);
            list.push(Carried { value, next: None });
        }
        // Pointers that advance.
        for _ in 0..self.below(3) {
            let value = self.func.add_param(body, Ty::Word);
            list.push(Carried {
                value,
                next: Some(value),
            });
        }
        list
    }

    fn entry_args(&mut self, start: Value, carried: &[Carried]) -> Vec<Value> {
        let mut args = vec![start];
        for c in carried {
            let ty = self.func.values[c.value];
            args.push(match c.next {
                Some(_) => {
                    let n = self.below(self.objects.len() as u32);
                    self.objects[n as usize]
                }
                None => self.pick(ty),
            });
        }
        args
    }

    /// Jumps into the loop, from one or two places.
    fn enter_loop(&mut self, body: Block, args: Vec<Value>) {
        let to_loop = |args: &[Value]| Target {
            block: body,
            args: args.to_vec(),
        };
        let data = &mut self.func.blocks[self.block];
        if self.rng.next_u32() % 100 < 70 {
            data.end = Terminator::Jump(to_loop(&args));
            return;
        }
        // The other way in brings other first values for what is no pointer.
        let mut other = args.clone();
        for arg in &mut other[1..] {
            if !self.objects.contains(arg) {
                let ty = self.func.values[*arg];
                *arg = self.pick(ty);
            }
        }
        let cond = self.preds[1];
        self.func.blocks[self.block].end = Terminator::Branch {
            cond,
            then: to_loop(&args),
            other: to_loop(&other),
        };
    }

    /// Pointer parameters advance by a multiple of 16.
    fn pointers(&mut self, carried: &mut [Carried]) {
        for c in carried.iter_mut().filter(|c| c.next.is_some()) {
            let bytes = [16, -16, 0, 32][self.below(4) as usize];
            let step = self.word(bytes);
            c.next = Some(self.op2(Opcode::Add, c.value, step));
            self.words.pop_if(|w| *w == c.value);
            self.words.retain(|w| *w != c.value);
            self.objects.push(c.value);
        }
    }

    fn body_step(&mut self, i: Value, stride: i32) {
        match self.below(10) {
            0..=3 => self.access(i, stride),
            _ => self.compute(),
        }
    }

    fn compute(&mut self) {
        loop {
            let op = Opcode::ALL[self.below(Opcode::ALL.len() as u32) as usize];
            let info = op.info();
            if info.effect != Effect::Pure || op.class() == Class::Idiv {
                continue;
            }
            let args: Vec<Value> = info.operands.iter().map(|k| self.pick(k.ty())).collect();
            let imm = if info.immediate {
                self.below(4) as i32
            } else {
                0
            };
            if let Some(result) = self.op(op, &args, imm) {
                let ty = self.func.values[result];
                self.pool(ty).push(result);
            }
            return;
        }
    }

    /// A load or store, aligned and inside its object.
    fn access(&mut self, i: Value, stride: i32) {
        use Opcode::*;
        let ops = [Lw, Lw, Sw, Sw, Lbu, Sb, Lh, Sh, Lv, Sv, Sw, Sb];
        let op = ops[self.below(ops.len() as u32) as usize];
        let bytes = op.access_bytes().expect("an access") as i32;
        let n = self.below(self.objects.len() as u32);
        let base = self.objects[n as usize];
        let offset = (self.below(9) as i32 - 4) * bytes;
        let address = match self.below(6) {
            // The same place in each iteration, or wherever the pointer is.
            0 => base,
            // Some element, wherever.
            1 => {
                let w = self.pick(Ty::Word);
                let mask = self.word(0x70);
                let index = self.op2(And, w, mask);
                self.op2(Add, base, index)
            }
            // An element that the loop variable counts: the factor keeps it inside.
            _ => {
                let mut factor = bytes * (self.below(3) as i32 + 1);
                if factor * (MOST + 1) * stride.abs() > MIDDLE / 2 {
                    factor = bytes;
                }
                if self.chance(30) {
                    factor = -factor;
                }
                let scaled = if factor > 0 && factor.count_ones() == 1 {
                    let shift = self.word(factor.trailing_zeros() as i32);
                    self.op2(Shl, i, shift)
                } else {
                    let factor = self.word(factor);
                    self.op2(Mul, i, factor)
                };
                if self.chance(50) {
                    self.op2(Add, base, scaled)
                } else {
                    self.op2(Sub, base, scaled)
                }
            }
        };
        let guard = if self.chance(60) {
            self.preds[0]
        } else {
            self.pick(Ty::Pred)
        };
        let mut args = vec![guard, address];
        if let Some(kind) = op.info().operands.get(2) {
            args.push(self.pick(kind.ty()));
        }
        if let Some(result) = self.op(op, &args, offset) {
            let ty = self.func.values[result];
            self.pool(ty).push(result);
        }
        if self.chance(30) {
            let not = self.op(Pnot, &[guard], 0);
            self.preds.extend(not);
        }
    }

    /// The condition of the back edge, and whether it goes on while that is true.
    fn exit_test(&mut self, i: Value, next: Value, stride: i32, start: Value) -> (Value, bool) {
        use Opcode::*;
        let tested = if self.chance(75) { next } else { i };
        let trips = 1 + self.below(MOST as u32) as i32;
        // A bound that ends the loop after about as many iterations, from what is outside.
        let distance = self.word(stride * trips);
        let bound = self.op2(Add, start, distance);
        let bound = if self.chance(50) {
            bound
        } else {
            // The same through another value, so that it is not known to be related.
            let zero = self.word(0);
            let lost = self.op2(Max, bound, bound);
            self.op2(Or, lost, zero)
        };
        let up = stride > 0;
        let unsigned = self.chance(20);
        let (lt, le) = if unsigned { (Ltu, Leu) } else { (Lt, Le) };
        let (a, b) = if up { (tested, bound) } else { (bound, tested) };
        let (op, a, b, sense) = match self.below(6) {
            0 => (Ne, tested, bound, true),
            1 => (Eq, bound, tested, false),
            2 => (lt, a, b, true),
            3 => (le, a, b, true),
            4 => (le, b, a, false),
            _ => (lt, b, a, false),
        };
        let cond = self.op2(op, a, b);
        if self.chance(15) {
            let not = self.op(Pnot, &[cond], 0).expect("has a result");
            (not, !sense)
        } else {
            (cond, sense)
        }
    }

    /// Ends the loop and returns some of its values.
    fn leave_loop(
        &mut self,
        body: Block,
        after: Block,
        cond: Value,
        sense: bool,
        nexts: Vec<Value>,
        i: Value,
    ) {
        let mut results = vec![i, nexts[0]];
        for ty in [Ty::Word, Ty::Word, Ty::Pred, Ty::Vec, Ty::Word] {
            let value = self.pick(ty);
            if !self.objects.contains(&value) {
                results.push(value);
            }
        }
        let passed = self.pick(Ty::Word);
        let param = self.func.add_param(after, Ty::Word);
        results.push(param);
        let back = Target {
            block: body,
            args: nexts,
        };
        let exit = Target {
            block: after,
            args: vec![passed],
        };
        let (then, other) = if sense { (back, exit) } else { (exit, back) };
        self.func.blocks[body].end = Terminator::Branch { cond, then, other };
        self.func.blocks[body].end_pos = pos(90);
        self.func.results = results.iter().map(|v| self.func.values[*v]).collect();
        self.func.blocks[after].end = Terminator::Return(results);
    }
}
