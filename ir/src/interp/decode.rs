//! A program made ready to be run: operands as numbers, addresses resolved.

use crate::layout::Layout;
use crate::program::{Block, Func, Function, Inst, InstKind, Program, Slot};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Effect, Opcode};
use srp_archdesc::ops::Value;

/// Most operands of an opcode.
pub(super) const MAX_OPERANDS: usize = 3;

/// No value.
pub(super) const NONE: u32 = u32::MAX;

/// A [verified](crate::verify()) program made ready to be run, any number of times.
#[derive(Clone, Debug)]
pub struct Code<'a> {
    pub(super) program: &'a Program,
    pub(super) layout: &'a Layout,
    pub(super) funcs: EntityMap<Func, FuncCode>,
}

/// A function made ready.
#[derive(Clone, Debug)]
pub(super) struct FuncCode {
    /// Bytes of its stack slots, a multiple of 16.
    pub(super) frame: u64,
    pub(super) blocks: EntityMap<Block, Vec<Step>>,
}

/// An instruction made ready.
#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    /// A constant, or the address of a symbol.
    Const { to: u32, value: Value },
    /// The address of a stack slot: this much beyond the stack pointer.
    Slot { to: u32, offset: u32 },
    /// An operation.
    Op(OpStep),
    /// A call or a launch.
    Other(Inst),
}

/// An operation made ready. Values are numbered in their function.
#[derive(Clone, Copy, Debug)]
pub(super) struct OpStep {
    pub(super) op: Opcode,
    /// True if its only effect is its result.
    pub(super) pure: bool,
    pub(super) args: [u32; MAX_OPERANDS],
    /// Its result, or [`NONE`].
    pub(super) to: u32,
    pub(super) imm: i32,
    pub(super) inst: Inst,
}

impl<'a> Code<'a> {
    /// Makes a program ready whose globals lie as in `layout`.
    pub fn of(program: &'a Program, layout: &'a Layout) -> Code<'a> {
        let func = |func: &Function| FuncCode::of(func, layout);
        Code {
            program,
            layout,
            funcs: program.funcs.values().map(func).collect(),
        }
    }
}

impl FuncCode {
    fn of(func: &Function, layout: &Layout) -> FuncCode {
        let (offsets, frame) = frame(func);
        let steps = |insts: &[Inst]| {
            let steps = insts.iter().map(|&i| step(func, i, &offsets, layout));
            steps.collect()
        };
        FuncCode {
            frame,
            blocks: func
                .blocks
                .values()
                .map(|block| steps(&block.insts))
                .collect(),
        }
    }
}

/// Where the slots of a function lie in its frame, and the size of the frame.
fn frame(func: &Function) -> (EntityMap<Slot, u32>, u64) {
    let mut next = 0u64;
    let mut offsets = EntityMap::new();
    for slot in func.slots.values() {
        next = next.next_multiple_of(u64::from(slot.align.max(1)));
        offsets.push(u32::try_from(next).unwrap_or(u32::MAX));
        next += u64::from(slot.size);
    }
    (offsets, next.next_multiple_of(16))
}

fn step(func: &Function, inst: Inst, offsets: &EntityMap<Slot, u32>, layout: &Layout) -> Step {
    let data = &func.insts[inst];
    let to = data.results.first().map_or(NONE, |v| v.index() as u32);
    match &data.kind {
        InstKind::Const(bits) => Step::Const {
            to,
            value: Value::from(*bits),
        },
        InstKind::SymbolAddr(symbol, offset) => Step::Const {
            to,
            value: Value::word(layout.address(*symbol).wrapping_add_signed(*offset)),
        },
        InstKind::SlotAddr(slot, offset) => Step::Slot {
            to,
            offset: offsets[*slot].wrapping_add_signed(*offset),
        },
        InstKind::Op { op, args, imm } => {
            let mut numbers = [0; MAX_OPERANDS];
            for (number, arg) in numbers.iter_mut().zip(args) {
                *number = arg.index() as u32;
            }
            Step::Op(OpStep {
                op: *op,
                pure: op.info().effect == Effect::Pure,
                args: numbers,
                to,
                imm: *imm,
                inst,
            })
        }
        InstKind::Call { .. } | InstKind::Launch { .. } => Step::Other(inst),
    }
}
