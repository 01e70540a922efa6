//! The low-level form of one function between code selection and scheduling: machine operations
//! over registers, physical or virtual, in blocks.
//!
//! Registers have one numbering: the central registers of the machine first, as
//! [`Target`](super::target::Target) counts them, virtual ones behind. Addresses inside the stack
//! frame stay symbolic ([`FrameTerm`]) until all spills are known.

use srp_archdesc::entity;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::check::sequence::Storage;
use srp_ir::program::{Bits, Func, Kernel, Pos, Slot};
use std::collections::BTreeMap;

entity! {
    /// A register: physical or virtual.
    Vreg = "r";
    /// A block of low-level code.
    Label = "L";
}

/// One function.
pub(super) struct Code {
    /// Its name, for messages.
    pub(super) name: String,
    /// The registers; the physical ones first.
    pub(super) regs: EntityMap<Vreg, RegData>,
    /// The blocks; not all need be in `order`.
    pub(super) blocks: EntityMap<Label, CodeBlock>,
    /// The blocks in order of layout, the entry first.
    pub(super) order: Vec<Label>,
    /// The stack frame.
    pub(super) frame: Frame,
}

/// A register.
#[derive(Clone, Copy, Debug)]
pub(super) struct RegData {
    /// Its type; for a physical register the widest type of its file.
    pub(super) ty: Ty,
    /// How far spilling has come.
    pub(super) split: Split,
    /// Its place on the stack, once it has one.
    pub(super) home: Option<u32>,
}

/// How far a value's live range has been cut by spilling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Split {
    /// Not at all.
    Whole,
    /// Into one piece a block.
    Block,
    /// Into single uses: it cannot be spilled again.
    Atom,
}

/// A block: operations, then one way to end.
#[derive(Clone, Debug)]
pub(super) struct CodeBlock {
    pub(super) insts: Vec<Inst>,
    pub(super) end: End,
    pub(super) end_pos: Pos,
    /// Loops around it.
    pub(super) depth: u32,
}

/// How a block ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum End {
    Jump(Label),
    /// To `then` if `cond` is `sense`, else to `other`.
    Branch {
        cond: Vreg,
        sense: bool,
        then: Label,
        other: Label,
    },
    /// To the address in the link register; these registers hold the results.
    Return(Vec<Vreg>),
    /// The program ends with this status.
    Halt(Vreg),
    Unreachable,
    StackOverflow,
}

/// An operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Arg {
    Reg(Vreg),
    Const(Bits),
    /// A word known when the frame is laid out.
    Frame(FrameTerm, i32),
}

/// A number that depends on the layout of the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum FrameTerm {
    /// The size of the frame.
    Size,
    /// The size of the frame, negated.
    NegSize,
    /// The offset of an item from the stack pointer.
    At(FrameItem),
    /// The lowest value that the stack pointer may have in this function.
    Limit,
}

/// Something in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum FrameItem {
    /// A variable.
    Slot(Slot),
    /// The place of a spilled value.
    Home(u32),
    /// The saved link register.
    Link,
    /// Byte of the area for arguments and results of calls made.
    Outgoing(u32),
    /// Byte of the caller's area for arguments and results.
    Incoming(u32),
}

/// One operation.
#[derive(Clone, Debug)]
pub(super) struct Inst {
    pub(super) kind: Kind,
    /// Operands; of calls and launches, the registers that pass values.
    pub(super) args: Vec<Arg>,
    /// The immediate, to which `frame` is added.
    pub(super) imm: i32,
    /// Part of the immediate that depends on the frame.
    pub(super) frame: Option<FrameTerm>,
    /// Registers defined: at most one by an operation.
    pub(super) defs: Vec<Vreg>,
    /// Registers that hold nothing of use afterwards.
    pub(super) clobbers: Vec<Vreg>,
    /// The storage that it accesses, if any.
    pub(super) storage: Storage,
    pub(super) pos: Pos,
}

/// Kinds of an [`Inst`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Op(Opcode),
    Call(Func),
    /// A call of the function whose address is in the link register.
    CallLink,
    Launch(Kernel),
}

impl Inst {
    /// An operation without a result yet.
    pub(super) fn op(op: Opcode, args: Vec<Arg>, pos: Pos) -> Inst {
        Inst {
            kind: Kind::Op(op),
            args,
            imm: 0,
            frame: None,
            defs: Vec::new(),
            clobbers: Vec::new(),
            storage: Storage::Anywhere,
            pos,
        }
    }

    /// The same with a result.
    pub(super) fn to(mut self, dst: Vreg) -> Inst {
        self.defs.push(dst);
        self
    }

    /// The move of `src` to `dst`.
    pub(super) fn mov(ty: Ty, dst: Vreg, src: Arg, pos: Pos) -> Inst {
        Inst::op(Opcode::mov(ty), vec![src], pos).to(dst)
    }

    /// An access, relative to the stack pointer, to the compiler's own storage.
    pub(super) fn private(op: Opcode, args: Vec<Arg>, item: FrameItem, pos: Pos) -> Inst {
        Inst {
            frame: Some(FrameTerm::At(item)),
            storage: Storage::Compiler,
            ..Inst::op(op, args, pos)
        }
    }

    /// The registers read.
    pub(super) fn uses(&self) -> impl Iterator<Item = Vreg> + '_ {
        self.args.iter().filter_map(|arg| match arg {
            Arg::Reg(reg) => Some(*reg),
            Arg::Const(_) | Arg::Frame(..) => None,
        })
    }

    /// Destination and source, if it moves one register to another.
    pub(super) fn as_copy(&self) -> Option<(Vreg, Vreg)> {
        let Kind::Op(Opcode::Mov | Opcode::Pmov | Opcode::Vmov) = self.kind else {
            return None;
        };
        match (&self.defs[..], &self.args[..]) {
            ([dst], [Arg::Reg(src)]) => Some((*dst, *src)),
            _ => None,
        }
    }

    /// True if it may be dropped if nobody reads its results.
    pub(super) fn is_droppable(&self) -> bool {
        match self.kind {
            Kind::Op(op) => op.is_pure() && op.class() != srp_archdesc::Class::Idiv,
            Kind::Call(_) | Kind::CallLink | Kind::Launch(_) => false,
        }
    }
}

impl End {
    /// The blocks it may go to.
    pub(super) fn targets(&self) -> impl Iterator<Item = Label> + use<> {
        let (a, b) = match *self {
            End::Jump(to) => (Some(to), None),
            End::Branch { then, other, .. } => (Some(then), Some(other)),
            End::Return(_) | End::Halt(_) | End::Unreachable | End::StackOverflow => (None, None),
        };
        a.into_iter().chain(b)
    }

    /// Replaces the blocks it may go to.
    pub(super) fn retarget(&mut self, mut f: impl FnMut(Label) -> Label) {
        match self {
            End::Jump(to) => *to = f(*to),
            End::Branch { then, other, .. } => {
                *then = f(*then);
                *other = f(*other);
            }
            End::Return(_) | End::Halt(_) | End::Unreachable | End::StackOverflow => {}
        }
    }

    /// The registers read, but for the link register.
    pub(super) fn uses(&self) -> impl Iterator<Item = Vreg> + '_ {
        let (one, many): (Option<Vreg>, &[Vreg]) = match self {
            End::Branch { cond, .. } => (Some(*cond), &[]),
            End::Halt(status) => (Some(*status), &[]),
            End::Return(results) => (None, results),
            End::Jump(_) | End::Unreachable | End::StackOverflow => (None, &[]),
        };
        one.into_iter().chain(many.iter().copied())
    }

    /// Replaces the registers read.
    pub(super) fn rename(&mut self, mut f: impl FnMut(Vreg) -> Vreg) {
        match self {
            End::Branch { cond, .. } => *cond = f(*cond),
            End::Halt(status) => *status = f(*status),
            End::Return(results) => results.iter_mut().for_each(|r| *r = f(*r)),
            End::Jump(_) | End::Unreachable | End::StackOverflow => {}
        }
    }
}

impl Code {
    /// A fresh virtual register.
    pub(super) fn fresh(&mut self, ty: Ty, split: Split) -> Vreg {
        self.regs.push(RegData {
            ty,
            split,
            home: None,
        })
    }

    /// Predecessors of each block of the layout.
    pub(super) fn predecessors(&self) -> EntityMap<Label, Vec<Label>> {
        let mut preds = EntityMap::filled(self.blocks.len(), Vec::new());
        for &from in &self.order {
            for to in self.blocks[from].end.targets() {
                preds[to].push(from);
            }
        }
        preds
    }

    /// Drops operations whose results nobody reads.
    pub(super) fn drop_dead(&mut self) {
        let mut uses: EntityMap<Vreg, u32> = EntityMap::filled(self.regs.len(), 0);
        for &label in &self.order {
            let block = &self.blocks[label];
            let inner = block.insts.iter().flat_map(Inst::uses);
            inner.chain(block.end.uses()).for_each(|r| uses[r] += 1);
        }
        let mut changed = true;
        while changed {
            changed = false;
            for &label in self.order.iter().rev() {
                let mut kept = Vec::new();
                for inst in std::mem::take(&mut self.blocks[label].insts)
                    .into_iter()
                    .rev()
                {
                    let is_dead = |r: &Vreg| self.regs[*r].split != Split::Atom && uses[*r] == 0;
                    if inst.is_droppable() && inst.defs.iter().all(is_dead) {
                        inst.uses().for_each(|r| uses[r] -= 1);
                        changed = true;
                    } else {
                        kept.push(inst);
                    }
                }
                kept.reverse();
                self.blocks[label].insts = kept;
            }
        }
    }
}

/// A stack frame: from the stack pointer up, the outgoing area, then everything else.
#[derive(Clone, Debug, Default)]
pub(super) struct Frame {
    /// Size and alignment of the variables.
    pub(super) slots: Vec<(u32, u32)>,
    /// Types of the spilled values.
    pub(super) homes: Vec<Ty>,
    /// True if the link register is saved.
    pub(super) saves_link: bool,
    /// Bytes of the outgoing area.
    pub(super) outgoing: u32,
}

/// Alignment of frames, that of vectors.
pub(super) const FRAME_ALIGN: u64 = 16;

/// A frame with its offsets.
pub(super) struct FrameLayout {
    /// Size in bytes, a multiple of [`FRAME_ALIGN`].
    pub(super) size: u32,
    offsets: BTreeMap<FrameItem, u32>,
}

impl Frame {
    /// Gives every item its offset; `None` where the frame does not fit in the address space.
    pub(super) fn layout(&self) -> Option<FrameLayout> {
        use srp_archdesc::entity::Entity;
        let slots = self.slots.iter().enumerate();
        let mut items: Vec<(FrameItem, u32, u32)> = slots
            .map(|(i, &(size, align))| (FrameItem::Slot(Slot::new(i)), size, align))
            .collect();
        items.extend(self.homes.iter().enumerate().map(|(i, &ty)| {
            let bytes = stack_bytes(ty);
            (FrameItem::Home(i as u32), bytes, bytes)
        }));
        if self.saves_link {
            items.push((FrameItem::Link, 4, 4));
        }
        items.sort_by_key(|&(item, _, align)| (std::cmp::Reverse(align), item));
        let mut next = u64::from(self.outgoing);
        let mut offsets = BTreeMap::new();
        for (item, size, align) in items {
            next = next.next_multiple_of(u64::from(align.max(1)));
            offsets.insert(item, u32::try_from(next).ok()?);
            next += u64::from(size);
        }
        let size = next.next_multiple_of(FRAME_ALIGN);
        // Offsets into the caller's frame must be numbers as well.
        let size = u32::try_from(size).ok().filter(|&s| s < 1 << 30)?;
        Some(FrameLayout { size, offsets })
    }
}

impl FrameLayout {
    /// The value of a term, where the stack pointer must not sink below `limit`.
    pub(super) fn resolve(&self, term: FrameTerm, limit: u32) -> i32 {
        match term {
            FrameTerm::Size => self.size as i32,
            FrameTerm::NegSize => -(self.size as i32),
            FrameTerm::Limit => limit as i32,
            FrameTerm::At(FrameItem::Outgoing(byte)) => byte as i32,
            FrameTerm::At(FrameItem::Incoming(byte)) => (self.size + byte) as i32,
            FrameTerm::At(item) => self.offsets[&item] as i32,
        }
    }
}

/// Bytes that a value takes on the stack. Predicates are words there.
pub(super) fn stack_bytes(ty: Ty) -> u32 {
    match ty {
        Ty::Pred | Ty::Word => 4,
        Ty::Vec => 16,
    }
}
