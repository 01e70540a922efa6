//! [`Program`]: SSA with block parameters, a source position on every instruction.
//!
//! There are no φ-functions: a block has parameters, and each jump to it brings their values.
//! Values have a storage type only ([`Ty`]); whether a word is an integer or a float is the
//! operation's business, so there are no casts that do nothing.

use serde::{Deserialize, Serialize};
use srp_archdesc::entity;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Opcode, Ty};
use std::fmt;

mod terminator;

pub use terminator::{Target, Terminator};

entity! {
    /// A source file.
    SourceFile = "file";
    /// A function.
    Func = "fn";
    /// A global object.
    Global = "g";
    /// A basic block of one function.
    Block = "bb";
    /// An instruction of one function.
    Inst = "i";
    /// A value of one function.
    Value = "v";
    /// A stack slot of one function.
    Slot = "ss";
    /// A kernel: a loop that runs on the array.
    Kernel = "k";
}

/// A source position: the file, and the line and column (in characters) from 1. Line 0 is
/// *nowhere*: made by the compiler.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Pos {
    /// The file.
    pub file: SourceFile,
    /// Line, from 1; 0 where there is no position.
    pub line: u32,
    /// Column in characters, from 1; 0 where there is no position.
    pub column: u32,
}

/// The bits of a constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Bits {
    /// A predicate.
    Pred(bool),
    /// A word.
    Word(u32),
    /// A vector, lane 0 first.
    Vec([u32; 4]),
}

impl Bits {
    /// The storage of the constant.
    pub fn ty(self) -> Ty {
        match self {
            Bits::Pred(_) => Ty::Pred,
            Bits::Word(_) => Ty::Word,
            Bits::Vec(_) => Ty::Vec,
        }
    }

    /// The zero of a type.
    pub fn zero(ty: Ty) -> Bits {
        match ty {
            Ty::Pred => Bits::Pred(false),
            Ty::Word => Bits::Word(0),
            Ty::Vec => Bits::Vec([0; 4]),
        }
    }

    /// As four words; predicates are 0 or 1, and lanes beyond the type are 0.
    pub fn lanes(self) -> [u32; 4] {
        match self {
            Bits::Pred(p) => [u32::from(p), 0, 0, 0],
            Bits::Word(w) => [w, 0, 0, 0],
            Bits::Vec(v) => v,
        }
    }

    /// The constant of type `ty` in the low lanes: the inverse of [`lanes`](Self::lanes).
    pub fn of_lanes(ty: Ty, lanes: [u32; 4]) -> Bits {
        match ty {
            Ty::Pred => Bits::Pred(lanes[0] != 0),
            Ty::Word => Bits::Word(lanes[0]),
            Ty::Vec => Bits::Vec(lanes),
        }
    }
}

/// As operations take it.
impl From<Bits> for srp_archdesc::ops::Value {
    fn from(bits: Bits) -> Self {
        Self(bits.lanes())
    }
}

/// `true`, `0x2a`, `0x1:0x2:0x3:0x4` (lane 0 first).
impl fmt::Display for Bits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Bits::Pred(p) => write!(f, "{p}"),
            Bits::Word(w) => write!(f, "{w:#x}"),
            Bits::Vec([a, b, c, d]) => write!(f, "{a:#x}:{b:#x}:{c:#x}:{d:#x}"),
        }
    }
}

/// A whole program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Program {
    /// The names of the source files, as the user gave them.
    pub files: EntityMap<SourceFile, String>,
    /// Objects with static storage.
    pub globals: EntityMap<Global, GlobalData>,
    /// Functions.
    pub funcs: EntityMap<Func, Function>,
    /// Where execution starts: `main`, if there is one.
    pub main: Option<Func>,
}

/// An object with static storage in SRAM.
#[derive(Clone, Debug, PartialEq)]
pub struct GlobalData {
    /// Its name; unique.
    pub name: String,
    /// Size in bytes.
    pub size: u32,
    /// Alignment in bytes, a power of two.
    pub align: u32,
    /// The first bytes; the rest is zero.
    pub init: Vec<u8>,
    /// Words of `init` that hold addresses.
    pub relocs: Vec<Reloc>,
    /// Where it was defined.
    pub pos: Pos,
}

/// A word in a global's initial value that holds an address.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reloc {
    /// Byte offset of the word.
    pub offset: u32,
    /// The symbol that it points to.
    pub symbol: Symbol,
    /// Added to the address of the symbol.
    pub addend: i32,
}

/// Something with an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Symbol {
    /// A global object.
    Global(Global),
    /// A function.
    Func(Func),
}

/// A function. The parameters of its first block are its parameters.
///
/// Always holds, and [`verify`](crate::verify()) checks it: every block but the entry is reached by
/// jumps that bring exactly its parameters; definitions dominate uses; operands have the types that
/// the opcode table asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    /// Its name; unique.
    pub name: String,
    /// Types of the results.
    pub results: Vec<Ty>,
    /// The source asks that no call of it is inlined.
    pub noinline: bool,
    /// Blocks; `layout` says which are part of the function and in what order.
    pub blocks: EntityMap<Block, BlockData>,
    /// The blocks in order; the first is the entry.
    pub layout: Vec<Block>,
    /// Instructions; those listed in a block of the layout are part of the function.
    pub insts: EntityMap<Inst, InstData>,
    /// Types of the values.
    pub values: EntityMap<Value, Ty>,
    /// Stack slots.
    pub slots: EntityMap<Slot, SlotData>,
    /// Where it was defined.
    pub pos: Pos,
}

/// A basic block.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockData {
    /// Parameters.
    pub params: Vec<Value>,
    /// Instructions in order.
    pub insts: Vec<Inst>,
    /// How it ends.
    pub end: Terminator,
    /// Position of the terminator.
    pub end_pos: Pos,
    /// Set on the header of a loop that should run on the array.
    pub kernel: Option<KernelMark>,
}

/// A wish to run the loop with this header on the array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KernelMark {
    /// Name of the kernel: unique in the program.
    pub name: String,
    /// Position of the loop statement.
    pub pos: Pos,
    /// Asked for by a pragma, so that a failure is worth a message.
    pub required: bool,
    /// It has loops inside it, and the mark counts only if those are unrolled.
    pub nest: bool,
    /// The `restrict` pointers in scope around the loop, by the numbers, from 1, of the `mov`s that
    /// make their values: while the loop runs, what is reached through one of them is reached in no
    /// other way, if it is written (C17 6.7.3.1).
    pub restrict: Vec<u32>,
    /// The estimate because of which it does not run in chunks, though only running it tells where it ends.
    pub slower: Option<Estimate>,
    /// Statements of the source about its iterations.
    pub independence: Independence,
}

/// Cycles that some iterations of a loop are estimated to take on either engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Estimate {
    /// How many.
    pub iterations: u32,
    /// On the array, with all launches.
    pub array: u32,
    /// On the VLIW engine.
    pub vliw: u32,
}

/// Independence of the memory accesses of a loop's iterations, as pragmas state it. It is believed
/// only where nothing else shows how far apart two accesses meet.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Independence {
    /// No iteration accesses what another writes.
    pub all: bool,
    /// Groups of variables, each by the number, from 1, of the `mov`s that make its address. No
    /// iteration accesses by a variable of a group what another writes by one, nor what the same
    /// writes by another variable of the group.
    pub groups: Vec<Vec<u32>>,
}

impl Independence {
    /// True when nothing is said.
    pub fn is_none(&self) -> bool {
        !self.all && self.groups.is_empty()
    }
}

/// A stack slot: storage in SRAM for the time of one call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SlotData {
    /// Name of the variable, for listings, or that of [temporaries](SlotData::temporary).
    pub name: String,
    /// Size in bytes.
    pub size: u32,
    /// Alignment in bytes, a power of two up to 16.
    pub align: u32,
}

/// The name of temporaries, which no variable of C can have.
const TEMPORARY: &str = ".temporary";

impl SlotData {
    /// A slot of no variable.
    pub fn temporary(size: u32, align: u32) -> SlotData {
        SlotData {
            name: TEMPORARY.to_owned(),
            size,
            align,
        }
    }

    /// True for a slot of no variable.
    pub fn is_temporary(&self) -> bool {
        self.name == TEMPORARY
    }
}

/// One instruction.
#[derive(Clone, Debug, PartialEq)]
pub struct InstData {
    /// The operation.
    pub kind: InstKind,
    /// Values it defines: one for most, none for stores, any number for calls and launches.
    pub results: Vec<Value>,
    /// Where it comes from.
    pub pos: Pos,
}

/// Kinds of instructions.
#[derive(Clone, Debug, PartialEq)]
pub enum InstKind {
    /// A constant.
    Const(Bits),
    /// An operation of the opcode table.
    Op {
        /// Which.
        op: Opcode,
        /// Operands, as the table has them.
        args: Vec<Value>,
        /// The immediate, 0 where the opcode has none. A `mov` with the number of a
        /// [`restrict`](KernelMark::restrict) pointer makes its value, one with that of a variable
        /// of an [`Independence`] its address.
        imm: i32,
    },
    /// The address of a global or a function, plus an offset in bytes.
    SymbolAddr(Symbol, i32),
    /// The address of a stack slot, plus an offset in bytes.
    SlotAddr(Slot, i32),
    /// A call.
    Call {
        /// Who is called.
        callee: Callee,
        /// Arguments.
        args: Vec<Value>,
    },
    /// Runs a kernel of the [`Dre`](crate::dre::Dre) on the array; only in control code after the split.
    Launch {
        /// Which.
        kernel: Kernel,
        /// Its live-in values, in the order of [`Dfg::live_ins`](crate::dfg::Dfg::live_ins).
        args: Vec<Value>,
    },
}

/// Who is called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Callee {
    /// A known function.
    Func(Func),
    /// The function at this address, with results of these types.
    Indirect(Value, Vec<Ty>),
}

impl InstKind {
    /// The operands.
    pub fn args(&self) -> &[Value] {
        match self {
            InstKind::Op { args, .. } | InstKind::Launch { args, .. } => args,
            InstKind::Call { args, .. } => args,
            InstKind::Const(_) | InstKind::SymbolAddr(..) | InstKind::SlotAddr(..) => &[],
        }
    }

    /// Calls `f` on every value used, a call's target included.
    pub fn for_each_use(&self, mut f: impl FnMut(Value)) {
        if let InstKind::Call {
            callee: Callee::Indirect(target, _),
            ..
        } = self
        {
            f(*target);
        }
        self.args().iter().copied().for_each(f);
    }

    /// Calls `f` on every value used, mutably.
    pub fn for_each_use_mut(&mut self, mut f: impl FnMut(&mut Value)) {
        match self {
            InstKind::Op { args, .. } | InstKind::Launch { args, .. } => {
                args.iter_mut().for_each(f);
            }
            InstKind::Call { callee, args } => {
                if let Callee::Indirect(target, _) = callee {
                    f(target);
                }
                args.iter_mut().for_each(f);
            }
            InstKind::Const(_) | InstKind::SymbolAddr(..) | InstKind::SlotAddr(..) => {}
        }
    }

    /// True if its only effect is to define its results.
    pub fn is_pure(&self) -> bool {
        match self {
            InstKind::Const(_) | InstKind::SymbolAddr(..) | InstKind::SlotAddr(..) => true,
            // A division may trap, but only under its guard, which moves with it.
            InstKind::Op { op, .. } => op.is_pure(),
            InstKind::Call { .. } | InstKind::Launch { .. } => false,
        }
    }
}

impl BlockData {
    /// An empty block that is not terminated yet.
    pub fn unreachable() -> BlockData {
        BlockData {
            params: Vec::new(),
            insts: Vec::new(),
            end: Terminator::Unreachable,
            end_pos: Pos::nowhere(),
            kernel: None,
        }
    }
}

impl Pos {
    /// No position.
    pub fn nowhere() -> Pos {
        use srp_archdesc::entity::Entity;
        Pos {
            file: SourceFile::new(0),
            line: 0,
            column: 0,
        }
    }
}

impl Program {
    /// `file:line:column`, or `-` for no position.
    pub fn show_pos(&self, pos: Pos) -> String {
        match self.files.get(pos.file) {
            Some(file) if pos.line > 0 => format!("{file}:{}:{}", pos.line, pos.column),
            _ => "-".to_owned(),
        }
    }

    /// The function with this name.
    pub fn func(&self, name: &str) -> Option<Func> {
        self.funcs
            .iter()
            .find(|(_, f)| f.name == name)
            .map(|(func, _)| func)
    }

    /// The global with this name.
    pub fn global(&self, name: &str) -> Option<Global> {
        self.globals
            .iter()
            .find(|(_, g)| g.name == name)
            .map(|(global, _)| global)
    }
}

impl Function {
    /// An empty function: one entry block with parameters of these types that is yet unreachable.
    pub fn new(name: &str, params: &[Ty], results: Vec<Ty>, pos: Pos) -> Function {
        let mut func = Function {
            name: name.to_owned(),
            results,
            noinline: false,
            blocks: EntityMap::new(),
            layout: Vec::new(),
            insts: EntityMap::new(),
            values: EntityMap::new(),
            slots: EntityMap::new(),
            pos,
        };
        let entry = func.add_block();
        for &ty in params {
            func.add_param(entry, ty);
        }
        func
    }

    /// The entry block.
    pub fn entry(&self) -> Block {
        self.layout[0]
    }

    /// Zeros for its parameters, which `main` is called with.
    pub fn zero_arguments(&self) -> Vec<Bits> {
        let params = self.blocks[self.entry()].params.iter();
        params
            .map(|&param| Bits::zero(self.values[param]))
            .collect()
    }

    /// Appends an empty, unterminated (hence [`Terminator::Unreachable`]) block to the layout.
    pub fn add_block(&mut self) -> Block {
        let block = self.blocks.push(BlockData::unreachable());
        self.layout.push(block);
        block
    }

    /// Adds a parameter to a block; the jumps to it are the caller's business.
    pub fn add_param(&mut self, block: Block, ty: Ty) -> Value {
        let value = self.values.push(ty);
        self.blocks[block].params.push(value);
        value
    }

    /// Makes an instruction, in no block yet, with results of these types.
    pub fn make_inst(&mut self, kind: InstKind, results: &[Ty], pos: Pos) -> Inst {
        let results = results.iter().map(|&ty| self.values.push(ty)).collect();
        self.insts.push(InstData { kind, results, pos })
    }

    /// Appends an instruction to a block; its results are in [`InstData::results`].
    pub fn append(&mut self, block: Block, kind: InstKind, results: &[Ty], pos: Pos) -> Inst {
        let inst = self.make_inst(kind, results, pos);
        self.blocks[block].insts.push(inst);
        inst
    }

    /// Appends an operation; `Some` value where the opcode has a result.
    pub fn append_op(
        &mut self,
        block: Block,
        op: Opcode,
        args: &[Value],
        imm: i32,
        pos: Pos,
    ) -> Option<Value> {
        let kind = InstKind::Op {
            op,
            args: args.to_vec(),
            imm,
        };
        let inst = self.append(block, kind, op.result().as_slice(), pos);
        self.insts[inst].results.first().copied()
    }

    /// Appends a constant.
    pub fn append_const(&mut self, block: Block, bits: Bits, pos: Pos) -> Value {
        let inst = self.append(block, InstKind::Const(bits), &[bits.ty()], pos);
        self.insts[inst].results[0]
    }
}
