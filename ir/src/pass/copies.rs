//! Copies of a few bytes. `memcpy` is how C takes the bits of a value of another type (C17 6.5), and words that no alignment is
//! known of; the library's function has loops. Here the bytes are loaded, and stored, by units as wide as is known to be
//! aligned on one of the two sides: a variable on one side is one word then, which can stay in a register.

use super::defs::Defs;
use super::prune::prune;
use super::rename::Renames;
use super::rewrite::is_library;
use crate::program::*;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Opcode;

/// Bytes that are written out at most, between addresses of words, and between others.
const MOST: u32 = 64;
const MOST_ALONE: u32 = 16;

/// Bytes of the widest unit.
const WIDEST: u32 = 4;

/// A function of the library that writes bytes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Way {
    /// `memcpy`, `memmove`.
    Copy,
    /// `memset`.
    Fill,
}

/// The functions of a program that write bytes.
pub(super) struct Copies(EntityMap<Func, Option<Way>>);

impl Copies {
    /// Those of the library.
    pub(super) fn of(program: &Program) -> Copies {
        let ways = program.funcs.values().map(|func| {
            let file = program.files.get(func.pos.file)?;
            match func.name.as_str() {
                _ if !is_library(file) => None,
                "memcpy" | "memmove" => Some(Way::Copy),
                "memset" => Some(Way::Fill),
                _ => None,
            }
        });
        Copies(ways.collect())
    }

    /// True for a call that may be written out by [`copies`], and need not be inlined for that.
    pub(super) fn are_few(&self, func: &Function, callee: Func, args: &[Value]) -> bool {
        let (Some(Some(_)), &[_, _, bytes]) = (self.0.get(callee), args) else {
            return false;
        };
        let bytes = Defs::of(func).word(func, bytes);
        bytes.is_some_and(|bytes| bytes <= MOST)
    }
}

/// Writes out copies of a constant, small number of bytes.
pub(crate) fn copies(program: &mut Program) -> bool {
    let functions = Copies::of(program);
    if functions.0.values().all(Option::is_none) {
        return false;
    }
    let Program { globals, funcs, .. } = &mut *program;
    let mut changed = false;
    for func in funcs.values_mut() {
        changed |= copies_in(func, &functions, globals);
    }
    if changed {
        prune(program);
    }
    changed
}

fn copies_in(
    func: &mut Function,
    functions: &Copies,
    globals: &EntityMap<Global, GlobalData>,
) -> bool {
    let called = |func: &Function, inst: Inst| match &func.insts[inst].kind {
        InstKind::Call {
            callee: Callee::Func(callee),
            args,
        } if args.len() == 3 => Some((functions.0[*callee]?, [args[0], args[1], args[2]])),
        _ => None,
    };
    let insts = func.layout.iter().flat_map(|&b| &func.blocks[b].insts);
    if insts.copied().all(|inst| called(func, inst).is_none()) {
        return false;
    }
    let defs = Defs::of(func);
    let aligned = Alignments::of(func, &defs, globals);
    let mut renames = Renames::default();
    let mut changed = false;
    for block in func.layout.clone() {
        let mut insts = Vec::new();
        for inst in std::mem::take(&mut func.blocks[block].insts) {
            let written = called(func, inst).and_then(|(way, [to, from, bytes])| {
                let bytes = defs.word(func, bytes)?;
                let from = match way {
                    Way::Copy => Source::Memory(from, aligned.at(from)),
                    Way::Fill => Source::Byte(from),
                };
                let most = match from.is_aligned() && aligned.at(to) >= WIDEST {
                    true => MOST,
                    false => MOST_ALONE,
                };
                (bytes <= most).then_some((to, from, bytes))
            });
            let Some((to, from, bytes)) = written else {
                insts.push(inst);
                continue;
            };
            let InstData { results, pos, .. } = func.insts[inst].clone();
            let mut writer = Writer { func, insts, pos };
            writer.write(from, (to, aligned.at(to)), bytes);
            insts = writer.insts;
            changed = true;
            if let [result] = results[..] {
                renames.replace(result, renames.find(to));
            }
        }
        func.blocks[block].insts = insts;
    }
    renames.apply(func);
    changed
}

/// For each value, as an address, the power of two that it is certainly a multiple of, up to [`WIDEST`].
struct Alignments(EntityMap<Value, u32>);

impl Alignments {
    /// The greatest solution of the definitions.
    fn of(func: &Function, defs: &Defs, globals: &EntityMap<Global, GlobalData>) -> Alignments {
        let mut aligned = Alignments(EntityMap::filled(func.values.len(), WIDEST));
        for &param in &func.blocks[func.entry()].params {
            aligned.0[param] = 1;
        }
        loop {
            let mut changed = false;
            let mut lower = |aligned: &mut Alignments, value: Value, to: u32| {
                changed |= to < aligned.0[value];
                aligned.0[value] = to.min(aligned.0[value]);
            };
            for &block in &func.layout {
                for &inst in &func.blocks[block].insts {
                    let InstData { kind, results, .. } = &func.insts[inst];
                    let of = aligned.made(func, defs, globals, kind);
                    results.iter().for_each(|&r| lower(&mut aligned, r, of));
                }
                for target in func.blocks[block].end.targets() {
                    let params = &func.blocks[target.block].params;
                    for (&param, &arg) in params.iter().zip(&target.args) {
                        let of = aligned.at(arg);
                        lower(&mut aligned, param, of);
                    }
                }
            }
            if !changed {
                return aligned;
            }
        }
    }

    fn at(&self, value: Value) -> u32 {
        self.0[value]
    }

    /// The alignment of what an instruction gives.
    fn made(
        &self,
        func: &Function,
        defs: &Defs,
        globals: &EntityMap<Global, GlobalData>,
        kind: &InstKind,
    ) -> u32 {
        match kind {
            InstKind::Const(Bits::Word(word)) => multiple_of(*word),
            InstKind::SymbolAddr(Symbol::Global(global), offset) => {
                globals[*global].align.min(multiple_of(*offset as u32))
            }
            InstKind::SlotAddr(slot, offset) => {
                func.slots[*slot].align.min(multiple_of(*offset as u32))
            }
            InstKind::Op { op, args, .. } => match (op, &args[..]) {
                (Opcode::Mov, &[a]) => self.at(a),
                (Opcode::Add | Opcode::Sub | Opcode::Or, &[a, b]) => self.at(a).min(self.at(b)),
                (Opcode::And, &[a, b]) => self.at(a).max(self.at(b)),
                (Opcode::Sel, &[_, a, b]) => self.at(a).min(self.at(b)),
                (Opcode::Mul, &[a, b]) => self.at(a) * self.at(b),
                (Opcode::Shl, &[a, by]) => match defs.word(func, by).map(|by| by % 32) {
                    Some(by) => self.at(a) << by.min(2),
                    None => self.at(a),
                },
                _ => 1,
            },
            _ => 1,
        }
        .min(WIDEST)
    }
}

/// The power of two that a word is a multiple of, up to [`WIDEST`].
fn multiple_of(word: u32) -> u32 {
    1 << word.trailing_zeros().min(WIDEST.ilog2())
}

/// The source of bytes.
#[derive(Clone, Copy)]
enum Source {
    /// An address, and its alignment.
    Memory(Value, u32),
    /// The low bits of a word, each of them.
    Byte(Value),
}

impl Source {
    fn is_aligned(self) -> bool {
        match self {
            Source::Memory(_, aligned) => aligned >= WIDEST,
            Source::Byte(_) => true,
        }
    }
}

/// Makes instructions in a row.
struct Writer<'f> {
    func: &'f mut Function,
    insts: Vec<Inst>,
    pos: Pos,
}

impl Writer<'_> {
    /// Writes bytes to an address of some alignment. All are read before any is written, as `memmove` wants it.
    fn write(&mut self, from: Source, (to, aligned): (Value, u32), bytes: u32) {
        let always = self.constant(Bits::Pred(true));
        let mut units = Vec::new();
        let mut at = 0;
        while at < bytes {
            let is_unit = |&unit: &u32| {
                let is_known = match from {
                    Source::Memory(_, from) => from.max(aligned) >= unit,
                    Source::Byte(_) => aligned >= unit,
                };
                at % unit == 0 && at + unit <= bytes && is_known
            };
            let unit = [4, 2, 1].into_iter().find(is_unit).expect("bytes are");
            let word = match from {
                Source::Memory(base, aligned) => self.load(always, base, at, (unit, aligned)),
                Source::Byte(byte) => self.repeated(byte, unit),
            };
            units.push((at, unit, word));
            at += unit;
        }
        for (at, unit, word) in units {
            let part = unit.min(aligned);
            for offset in (0..unit).step_by(part as usize) {
                let part_of = match offset {
                    0 => word,
                    _ => {
                        let by = self.constant(Bits::Word(8 * offset));
                        self.op(Opcode::Shr, &[word, by])
                    }
                };
                let store = match part {
                    1 => Opcode::Sb,
                    2 => Opcode::Sh,
                    _ => Opcode::Sw,
                };
                self.access(store, &[always, to, part_of], at + offset);
            }
        }
    }

    /// The bytes of a unit at an address of some alignment, the first one lowest.
    fn load(&mut self, always: Value, base: Value, at: u32, (unit, aligned): (u32, u32)) -> Value {
        let part = unit.min(aligned);
        let load = match part {
            1 => Opcode::Lbu,
            2 => Opcode::Lhu,
            _ => Opcode::Lw,
        };
        let mut word = None;
        for offset in (0..unit).step_by(part as usize) {
            let loaded = self.access(load, &[always, base], at + offset);
            let loaded = loaded.expect("a load has a result");
            word = Some(match word {
                None => loaded,
                Some(low) => {
                    let by = self.constant(Bits::Word(8 * offset));
                    let high = self.op(Opcode::Shl, &[loaded, by]);
                    self.op(Opcode::Or, &[low, high])
                }
            });
        }
        word.expect("a unit has a byte")
    }

    /// A byte in each place of a unit.
    fn repeated(&mut self, byte: Value, unit: u32) -> Value {
        if unit == 1 {
            return byte;
        }
        let mask = self.constant(Bits::Word(0xff));
        let byte = self.op(Opcode::And, &[byte, mask]);
        let everywhere = self.constant(Bits::Word(0x0101_0101));
        self.op(Opcode::Mul, &[byte, everywhere])
    }

    fn constant(&mut self, bits: Bits) -> Value {
        let inst = (self.func).make_inst(InstKind::Const(bits), &[bits.ty()], self.pos);
        self.insts.push(inst);
        self.func.insts[inst].results[0]
    }

    fn op(&mut self, op: Opcode, args: &[Value]) -> Value {
        self.access(op, args, 0).expect("it has a result")
    }

    fn access(&mut self, op: Opcode, args: &[Value], imm: u32) -> Option<Value> {
        let kind = InstKind::Op {
            op,
            args: args.to_vec(),
            imm: imm as i32,
        };
        let inst = (self.func).make_inst(kind, op.result().as_slice(), self.pos);
        self.insts.push(inst);
        self.func.insts[inst].results.first().copied()
    }
}
