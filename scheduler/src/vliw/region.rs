//! Regions: stretches of operations that end with at most one control transfer, in registers of
//! the machine. They are what the list scheduler packs.

use super::lir::{Arg, CodeBlock, End, FrameLayout, Inst, Kind, Label, Vreg};
use super::target::Target;
use crate::abi;
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Opcode;
use srp_ir::check::sequence::Step;
use srp_ir::dre::scheduled::{Reg, Src};
use srp_ir::program::{Bits, Func, Kernel, Pos};

/// A control transfer without the number of its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Transfer {
    Jump(Label),
    Branch { cond: Reg, sense: bool, to: Label },
    Call(Func),
    CallLink,
    Launch(Kernel),
    Return,
    Halt(Reg),
    Unreachable,
    StackOverflow,
}

impl Transfer {
    /// The register it reads when it issues.
    pub(super) fn reads(self, target: &Target<'_>) -> Option<Reg> {
        match self {
            Transfer::Branch { cond, .. } => Some(cond),
            Transfer::CallLink | Transfer::Return => Some(abi::link(target.srp)),
            Transfer::Halt(status) => Some(status),
            _ => None,
        }
    }

    /// The register it writes when its target issues.
    pub(super) fn writes(self, target: &Target<'_>) -> Option<Reg> {
        matches!(self, Transfer::Call(_) | Transfer::CallLink).then(|| abi::link(target.srp))
    }
}

/// Operations and the transfer after them.
#[derive(Clone, Debug, Default)]
pub(super) struct Region {
    pub(super) ops: Vec<Step>,
    pub(super) exit: Option<(Transfer, Pos)>,
}

/// Values that are filled in once all frames are known.
pub(super) struct Frames<'a> {
    pub(super) layout: &'a FrameLayout,
    /// The lowest value of the stack pointer.
    pub(super) limit: u32,
}

/// The regions of a block that `next` follows in the layout.
pub(super) fn regions(
    block: &CodeBlock,
    next: Option<Label>,
    target: &Target<'_>,
    frames: &Frames<'_>,
) -> Vec<Region> {
    let mut regions = Vec::new();
    let mut region = Region::default();
    for inst in &block.insts {
        let exit = match inst.kind {
            Kind::Op(op) => {
                region.ops.extend(concrete(op, inst, target, frames));
                continue;
            }
            Kind::Call(func) => Transfer::Call(func),
            Kind::CallLink => Transfer::CallLink,
            Kind::Launch(kernel) => Transfer::Launch(kernel),
        };
        region.exit = Some((exit, inst.pos));
        regions.push(std::mem::take(&mut region));
    }
    let reg = |r: Vreg| target.reg(r.index() as u32);
    let mut then_jump = None;
    let exit = match block.end {
        End::Jump(to) if next == Some(to) => None,
        End::Jump(to) => Some(Transfer::Jump(to)),
        End::Branch {
            cond,
            sense,
            then,
            other,
        } => {
            let (sense, to, rest) = if next == Some(then) {
                (!sense, other, then)
            } else {
                (sense, then, other)
            };
            then_jump = (next != Some(rest)).then_some(Transfer::Jump(rest));
            let cond = reg(cond);
            Some(Transfer::Branch { cond, sense, to })
        }
        End::Return(_) => Some(Transfer::Return),
        End::Halt(status) => Some(Transfer::Halt(reg(status))),
        End::Unreachable => Some(Transfer::Unreachable),
        End::StackOverflow => Some(Transfer::StackOverflow),
    };
    region.exit = exit.map(|exit| (exit, block.end_pos));
    regions.push(region);
    regions.extend(then_jump.map(|exit| Region {
        ops: Vec::new(),
        exit: Some((exit, block.end_pos)),
    }));
    regions
}

/// The operation with registers of the machine and numbers for the frame's terms; `None` where it
/// does nothing.
fn concrete(op: Opcode, inst: &Inst, target: &Target<'_>, frames: &Frames<'_>) -> Option<Step> {
    let resolve = |term| frames.layout.resolve(term, frames.limit);
    let src = |arg: &Arg| match *arg {
        Arg::Reg(reg) => Src::Reg(target.reg(reg.index() as u32)),
        Arg::Const(bits) => Src::Const(bits),
        Arg::Frame(term, offset) => {
            Src::Const(Bits::Word(resolve(term).wrapping_add(offset) as u32))
        }
    };
    let srcs: Vec<Src> = inst.args.iter().map(src).collect();
    let dst = inst.defs.first().map(|r| target.reg(r.index() as u32));
    // The adjustment of an empty frame.
    let zero = Src::Const(Bits::Word(0));
    if op == Opcode::Add && srcs[1] == zero && Some(srcs[0]) == dst.map(Src::Reg) {
        return None;
    }
    Some(Step {
        op,
        srcs,
        imm: inst.imm.wrapping_add(inst.frame.map_or(0, resolve)),
        dst,
        storage: inst.storage,
        pos: inst.pos,
    })
}
