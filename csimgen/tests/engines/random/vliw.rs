//! Random VLIW code.

use super::{Constants, Dice, Shape, files, immediate, opcodes, safe_operand};
use srp_archdesc::Arch;
use srp_archdesc::arch::{FileKind, Fu, RegFile, Resource};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::dre::scheduled::*;
use srp_ir::program::{Bits, Pos};
use std::collections::{BTreeMap, BTreeSet};

/// VLIW code in the making, and what is under way in it. Cycles are numbers of bundles.
pub(super) struct Code<'a> {
    arch: &'a Arch,
    pub(super) bundles: EntityMap<Bundle, BundleData>,
    /// Results, by the cycle in which they arrive.
    landing: BTreeSet<(usize, Reg)>,
    arrivals: BTreeMap<(usize, RegFile), u32>,
    /// The cycle from which a unit can issue.
    busy: BTreeMap<Fu, usize>,
    shared: BTreeMap<(usize, Resource), u32>,
    /// The cycle from which nothing is under way.
    quiet: usize,
}

impl<'a> Code<'a> {
    pub(super) fn new(arch: &'a Arch) -> Code<'a> {
        Code {
            arch,
            bundles: EntityMap::new(),
            landing: BTreeSet::new(),
            arrivals: BTreeMap::new(),
            busy: BTreeMap::new(),
            shared: BTreeMap::new(),
            quiet: 0,
        }
    }

    /// The bundle that comes next.
    pub(super) fn next(&self) -> Bundle {
        Bundle::new(self.bundles.len())
    }

    pub(super) fn bundle(&mut self, ops: Vec<SlotOp>) {
        self.bundles.push(BundleData { ops, control: None });
    }

    /// A bundle with nothing but a transfer.
    pub(super) fn transfer(&mut self, control: Control) {
        self.bundles.push(BundleData {
            ops: Vec::new(),
            control: Some((control, Pos::nowhere())),
        });
    }

    /// Empty bundles until nothing is under way.
    pub(super) fn idle(&mut self) {
        while self.bundles.len() < self.quiet {
            self.bundle(Vec::new());
        }
    }

    /// A bundle with one operation, as soon as that can issue.
    pub(super) fn operation(&mut self, fu: Fu, op: Opcode, srcs: &[Src], dst: Option<Reg>) {
        let op = slot_op(fu, op, srcs, dst);
        while !self.take(&op, &mut BTreeSet::new()) {
            self.bundle(Vec::new());
        }
        self.bundle(vec![op]);
    }

    /// Sets a register to a constant.
    pub(super) fn set(&mut self, reg: Reg, value: Bits) {
        let op = Opcode::mov(value.ty());
        let srp = &self.arch.srp;
        let writers = &srp.files[reg.file].writers;
        let mut slots = srp.slots().into_iter();
        let slot = slots.find(|fu| srp.fus[*fu].runs(op).is_some() && writers.contains(fu));
        let slot = slot.expect("a slot that sets registers");
        self.operation(slot, op, &[Src::Const(value)], Some(reg));
    }

    /// Adds an operation in each slot where one can issue. None of them writes a register of `kept` or number
    /// 0 of its file.
    pub(super) fn random_bundle(&mut self, dice: &mut Dice, shape: &Shape, kept: &[Reg]) {
        let mut ops: Vec<SlotOp> = Vec::new();
        let mut read = BTreeSet::new();
        for fu in self.arch.srp.slots() {
            let op = self.random_operation(dice, shape, fu);
            let fits = op.dst.is_none_or(|reg| !kept.contains(&reg))
                && op.dst.is_some() == op.op.result().is_some()
                && self.take(&op, &mut read);
            if fits {
                ops.push(op);
            }
        }
        self.bundle(ops);
    }

    fn random_operation(&self, dice: &mut Dice, shape: &Shape, fu: Fu) -> SlotOp {
        let op = dice.pick(&opcodes(self.arch, shape, fu));
        let op = op.expect("a unit that does something");
        let register = |dice: &mut Dice, ty: Ty| {
            let fits = |f: RegFile| {
                let spec = &self.arch.srp.files[f];
                spec.kind == FileKind::Central && spec.holds(ty) && spec.readers.contains(&fu)
            };
            let file = dice.pick(&files(self.arch, fits))?;
            let index = 1 + dice.roll(self.arch.srp.files[file].size as usize - 2) as u32;
            Some(Reg { file, index })
        };
        let mut srcs = Vec::new();
        for (number, kind) in op.info().operands.iter().enumerate() {
            let constant = safe_operand(dice, op, number);
            srcs.push(match (constant, dice.roll(4)) {
                (Some(bits), _) => Src::Const(bits),
                (None, 0) => Src::Const(dice.constant(kind.ty())),
                (None, _) => {
                    register(dice, kind.ty()).map_or(Src::Const(Bits::zero(kind.ty())), Src::Reg)
                }
            });
        }
        let dst = op.result().and_then(|ty| register(dice, ty));
        let mut made = slot_op(fu, op, &srcs, dst);
        made.imm = immediate(dice, op);
        made
    }

    /// True if an operation can issue in the next bundle, whose operations so far read these registers. If
    /// so, it is under way.
    fn take(&mut self, op: &SlotOp, read: &mut BTreeSet<Reg>) -> bool {
        let cycle = self.bundles.len();
        let srp = &self.arch.srp;
        let how = srp.fus[op.fu].runs(op.op).expect("chosen so");
        let mut constants = Constants::default();
        let mut now_read = read.clone();
        for src in &op.srcs {
            match *src {
                Src::Reg(reg) => drop(now_read.insert(reg)),
                Src::Const(bits) if !constants.take(bits, self.arch, op.fu) => return false,
                Src::Const(_) => {}
            }
        }
        let reads = |file| now_read.iter().filter(|reg| reg.file == file).count() as u32;
        let ports = srp.files.iter().all(|(f, s)| reads(f) <= s.read_ports);
        let free = self.busy.get(&op.fu).is_none_or(|&from| from <= cycle);
        let taken = (cycle..cycle + how.interval as usize)
            .flat_map(|c| how.uses.iter().map(move |&resource| (c, resource)));
        let taken: Vec<(usize, Resource)> = taken.collect();
        let used = |key: &(usize, Resource)| self.shared.get(key).copied().unwrap_or(0);
        let left = taken.iter().all(|k| used(k) < srp.resources[k.1].count);
        let lands = cycle + how.latency as usize;
        let arrives = op.dst.is_none_or(|dst| {
            let count = self.arrivals.get(&(lands, dst.file)).copied();
            let writable = srp.files[dst.file].writers.contains(&op.fu);
            let port = count.unwrap_or(0) < srp.files[dst.file].write_ports;
            writable && port && !self.landing.contains(&(lands, dst))
        });
        if !(ports && free && left && arrives) {
            return false;
        }
        *read = now_read;
        self.busy.insert(op.fu, cycle + how.interval as usize);
        for key in taken {
            *self.shared.entry(key).or_insert(0) += 1;
        }
        if let Some(dst) = op.dst {
            self.landing.insert((lands, dst));
            *self.arrivals.entry((lands, dst.file)).or_insert(0) += 1;
        }
        let ends = lands.max(cycle + how.interval as usize);
        self.quiet = self.quiet.max(ends);
        true
    }
}

fn slot_op(fu: Fu, op: Opcode, srcs: &[Src], dst: Option<Reg>) -> SlotOp {
    SlotOp {
        fu,
        op,
        srcs: srcs.to_vec(),
        imm: 0,
        dst,
        pos: Pos::nowhere(),
    }
}
