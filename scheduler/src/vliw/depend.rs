//! Which operations of a region must wait for which: registers and memory.

use super::region::Region;
use srp_archdesc::isa::{Effect, Opcode, Space};
use srp_ir::check::sequence::{Step, Storage};
use srp_ir::dre::scheduled::{Reg, Src};
use srp_ir::program::Bits;
use std::collections::BTreeMap;

/// Why an operation waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wait {
    /// It reads the result: issues when that stands, or later.
    Data,
    /// It overwrites what the other reads: issues with it, or later.
    Anti,
    /// It writes the same register: its result stands later.
    Output,
    /// It issues this many cycles later.
    After(u32),
}

/// The dependences of a region. Operations are numbered in program order.
pub(super) struct Depend {
    /// The operations that wait for each operation.
    pub(super) after: Vec<Vec<(usize, Wait)>>,
    /// The operations that each operation waits for.
    pub(super) before: Vec<Vec<(usize, Wait)>>,
    /// The last writer of each register.
    pub(super) writer: BTreeMap<Reg, usize>,
}

/// The address of an access as far as it is known.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Base {
    Zero,
    /// A register, and how often it had been written before.
    Reg(Reg, u32),
}

#[derive(Clone, Copy)]
struct Access {
    index: usize,
    effect: Effect,
    space: Space,
    base: Base,
    offset: i32,
    /// `None`: anywhere.
    bytes: Option<u32>,
    storage: Storage,
}

impl Access {
    fn of(index: usize, op: &Step, writes: &BTreeMap<Reg, u32>) -> Option<Access> {
        let space = op.op.space()?;
        let bytes = op.op.access_bytes();
        let (base, offset) = match op.srcs[1] {
            Src::Const(bits) => match bits {
                Bits::Word(address) => (Base::Zero, op.imm.wrapping_add_unsigned(address)),
                Bits::Pred(_) | Bits::Vec(_) => return None,
            },
            Src::Reg(reg) => {
                let version = writes.get(&reg).copied().unwrap_or(0);
                (Base::Reg(reg, version), op.imm)
            }
        };
        Some(Access {
            index,
            effect: op.op.info().effect,
            space,
            base,
            offset,
            bytes,
            storage: op.storage,
        })
    }

    /// True if the two can never touch the same byte.
    fn is_disjoint(&self, other: &Access) -> bool {
        if self.space != other.space || self.storage.is_apart(other.storage) {
            return true;
        }
        let (Some(bytes), Some(others)) = (self.bytes, other.bytes) else {
            return false;
        };
        // Addresses are numbers modulo 2^32.
        let ahead = other.offset.wrapping_sub(self.offset) as u32;
        self.base == other.base && ahead >= bytes && ahead.wrapping_neg() >= others
    }
}

impl Depend {
    /// The dependences of `region`.
    pub(super) fn of(region: &Region) -> Depend {
        let count = region.ops.len();
        let mut depend = Depend {
            after: vec![Vec::new(); count],
            before: vec![Vec::new(); count],
            writer: BTreeMap::new(),
        };
        let mut readers: BTreeMap<Reg, Vec<usize>> = BTreeMap::new();
        let mut writes: BTreeMap<Reg, u32> = BTreeMap::new();
        let mut memory = Memory::default();
        for (i, op) in region.ops.iter().enumerate() {
            for src in &op.srcs {
                if let Src::Reg(reg) = src {
                    if let Some(&writer) = depend.writer.get(reg) {
                        depend.add(writer, i, Wait::Data);
                    }
                    readers.entry(*reg).or_default().push(i);
                }
            }
            memory.visit(i, op, &writes, &mut depend);
            if let Some(dst) = op.dst {
                for reader in readers.insert(dst, Vec::new()).unwrap_or_default() {
                    depend.add(reader, i, Wait::Anti);
                }
                if let Some(writer) = depend.writer.insert(dst, i) {
                    depend.add(writer, i, Wait::Output);
                }
                *writes.entry(dst).or_insert(0) += 1;
            }
        }
        depend
    }

    fn add(&mut self, from: usize, to: usize, wait: Wait) {
        if from != to && !self.after[from].contains(&(to, wait)) {
            self.after[from].push((to, wait));
            self.before[to].push((from, wait));
        }
    }
}

/// The accesses so far.
#[derive(Default)]
struct Memory {
    accesses: Vec<Access>,
    io: Option<usize>,
}

impl Memory {
    fn visit(&mut self, index: usize, op: &Step, writes: &BTreeMap<Reg, u32>, depend: &mut Depend) {
        if matches!(op.op, Opcode::In | Opcode::Out) {
            // What the outside sees or does lies between the accesses before and after.
            for access in self.accesses.drain(..) {
                depend.add(access.index, index, Wait::After(1));
            }
            if let Some(io) = self.io.replace(index) {
                depend.add(io, index, Wait::After(1));
            }
            return;
        }
        let Some(access) = Access::of(index, op, writes) else {
            return;
        };
        if let Some(io) = self.io {
            depend.add(io, index, Wait::After(1));
        }
        for before in &self.accesses {
            let both_load = before.effect == Effect::Load && access.effect == Effect::Load;
            if both_load || before.is_disjoint(&access) {
                continue;
            }
            // A load reads at the start of its cycle, a store writes at the end.
            let cycles = u32::from(before.effect == Effect::Store);
            depend.add(before.index, index, Wait::After(cycles));
        }
        self.accesses.push(access);
    }
}
