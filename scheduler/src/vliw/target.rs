//! The VLIW engine as code selection, allocation and list scheduling see it: the operations of each
//! slot, and all central registers under one numbering.

use super::VliwError;
use crate::abi;
use srp_archdesc::arch::{FileKind, Fu, FuOp, RegFile, Srp};
use srp_archdesc::isa::{Class, Opcode, Ty};
use srp_ir::dre::scheduled::{Reg, Src};
use std::collections::{BTreeMap, BTreeSet};

/// The machine, with derived data that every step needs.
pub(super) struct Target<'a> {
    pub(super) srp: &'a Srp,
    /// The slots in order.
    pub(super) slots: Vec<Fu>,
    /// The central file of each type, by `Ty as usize`.
    files: [RegFile; 3],
    /// The central registers: the physical ones of the register numbering.
    regs: Vec<Reg>,
    /// The number of the first register of each central file.
    base: BTreeMap<RegFile, u32>,
    /// Registers that an allocator may hand out, by number, for each file.
    pub(super) allocatable: BTreeMap<RegFile, Vec<u32>>,
    /// The most constants an operation can have, by opcode; `None` where no slot runs it.
    constants: Vec<Option<u32>>,
}

impl<'a> Target<'a> {
    /// The VLIW engine of `srp`.
    pub(super) fn of(srp: &'a Srp) -> Result<Target<'a>, VliwError> {
        if srp.slots().is_empty() {
            return Err(VliwError::NoSlots);
        }
        for ty in Ty::ALL {
            if srp.central(ty).is_none() {
                return Err(VliwError::NoCentralFile(ty));
            }
        }
        let files = Ty::ALL.map(|ty| abi::file(srp, ty));
        let mut regs = Vec::new();
        let mut base = BTreeMap::new();
        let mut allocatable = BTreeMap::new();
        for (file, spec) in srp.files.iter() {
            if spec.kind != FileKind::Central {
                continue;
            }
            let first = regs.len() as u32;
            base.insert(file, first);
            regs.extend((0..spec.size).map(|index| Reg { file, index }));
            let ty = Ty::ALL.into_iter().find(|&ty| abi::file(srp, ty) == file);
            let count = ty.map_or(0, |ty| abi::allocatable(srp, ty));
            allocatable.insert(file, (first..first + count).collect());
        }
        if srp.files[files[Ty::Word as usize]].size < abi::RESERVED_WORDS {
            return Err(VliwError::FewRegisters);
        }
        let mut target = Target {
            srp,
            slots: srp.slots(),
            files,
            regs,
            base,
            allocatable,
            constants: Vec::new(),
        };
        let slow = |(_, how): (Fu, &FuOp)| how.interval > srp.branch_delay + 1;
        if target.branch_slots().next().is_none() || target.branch_slots().any(slow) {
            return Err(VliwError::NoBranchUnit);
        }
        target.constants = Opcode::ALL.iter().map(|&op| target.room(op)).collect();
        Ok(target)
    }

    /// The central file of `ty`.
    pub(super) fn file(&self, ty: Ty) -> RegFile {
        self.files[ty as usize]
    }

    /// How many physical registers there are.
    pub(super) fn physical(&self) -> u32 {
        self.regs.len() as u32
    }

    /// The number of a central register.
    pub(super) fn number(&self, reg: Reg) -> Option<u32> {
        let base = self.base.get(&reg.file)?;
        (reg.index < self.srp.files[reg.file].size).then_some(base + reg.index)
    }

    /// The central register with this number.
    pub(super) fn reg(&self, number: u32) -> Reg {
        self.regs[number as usize]
    }

    /// The most constants of words and vectors that `op` can have as operands; `None` where no slot runs it on the
    /// files that control code keeps its operands in.
    pub(super) fn max_constants(&self, op: Opcode) -> Option<u32> {
        self.constants[op as usize]
    }

    fn room(&self, op: Opcode) -> Option<u32> {
        let info = op.info();
        let fits = |fu: Fu| {
            let spec = &self.srp.fus[fu];
            spec.runs(op).is_some()
                && info.operands.iter().all(|kind| {
                    let file = self.file(kind.ty());
                    self.srp.files[file].readers.contains(&fu)
                })
                && op
                    .result()
                    .is_none_or(|ty| self.writes(fu, ty, self.file(ty)))
        };
        let slots = self.slots.iter().filter(|&&fu| fits(fu));
        slots.map(|&fu| self.srp.fus[fu].constants).max()
    }

    fn writes(&self, fu: Fu, ty: Ty, file: RegFile) -> bool {
        let spec = &self.srp.fus[fu];
        let produces = ty.bits() <= spec.width || (ty == Ty::Pred && spec.pred_out);
        produces && self.srp.files[file].writers.contains(&fu)
    }

    /// How `fu` runs this operation with these operands, if it can at all.
    pub(super) fn runs(&self, fu: Fu, op: Opcode, srcs: &[Src], dst: Option<Reg>) -> Option<&FuOp> {
        let spec = &self.srp.fus[fu];
        let how = spec.runs(op)?;
        let constants: BTreeSet<_> = srcs
            .iter()
            .filter_map(|src| match src {
                Src::Const(bits) if bits.ty() != Ty::Pred => Some(bits),
                Src::Const(_) | Src::Reg(_) => None,
            })
            .collect();
        let reads = srcs.iter().all(|src| match src {
            Src::Const(_) => true,
            Src::Reg(reg) => self.srp.files[reg.file].readers.contains(&fu),
        });
        let ports = reads_by_file(srcs)
            .into_iter()
            .all(|(file, regs)| regs.len() as u32 <= self.srp.files[file].read_ports);
        let writes = dst.is_none_or(|dst| {
            let ty = op.result().expect("only a result has a destination");
            self.writes(fu, ty, dst.file) && self.srp.files[dst.file].write_ports > 0
        });
        let shared = how
            .uses
            .iter()
            .all(|&r| self.srp.resources[r].count >= uses(how, r));
        let fits = constants.len() as u32 <= spec.constants;
        (fits && reads && ports && writes && shared).then_some(how)
    }

    /// The slots that have a branch unit.
    pub(super) fn branch_slots(&self) -> impl Iterator<Item = (Fu, &FuOp)> {
        self.slots
            .iter()
            .filter_map(|&fu| Some((fu, self.srp.fus[fu].op(Class::Branch)?)))
    }

    /// The stack pointer's number.
    pub(super) fn sp(&self) -> u32 {
        self.number(abi::stack_pointer(self.srp))
            .expect("the stack pointer is a central register")
    }

    /// The link register's number.
    pub(super) fn link(&self) -> u32 {
        self.number(abi::link(self.srp))
            .expect("the link register is a central register")
    }
}

/// How often an operation uses a shared resource in a cycle.
pub(super) fn uses(how: &FuOp, resource: srp_archdesc::arch::Resource) -> u32 {
    how.uses.iter().filter(|&&r| r == resource).count() as u32
}

/// The distinct registers read, by file.
pub(super) fn reads_by_file(srcs: &[Src]) -> BTreeMap<RegFile, BTreeSet<u32>> {
    let mut reads: BTreeMap<RegFile, BTreeSet<u32>> = BTreeMap::new();
    for src in srcs {
        if let Src::Reg(reg) = src {
            reads.entry(reg.file).or_default().insert(reg.index);
        }
    }
    reads
}
