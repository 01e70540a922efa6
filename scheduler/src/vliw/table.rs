//! The reservation table of a region: the resources taken in each cycle.

use super::region::Transfer;
use super::target::{Target, reads_by_file};
use srp_archdesc::arch::{Fu, FuOp, RegFile};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::Effect;
use srp_ir::check::sequence::Step;
use srp_ir::dre::scheduled::{Reg, Src};
use std::collections::BTreeMap;

/// Units, shared resources and ports taken in each cycle of a region.
pub(super) struct Table<'a> {
    target: &'a Target<'a>,
    rows: Vec<Row>,
}

#[derive(Clone, Default)]
struct Row {
    /// Units that cannot issue.
    busy: Vec<Fu>,
    /// Uses of each shared resource.
    shared: BTreeMap<usize, u32>,
    /// Registers read.
    reads: Vec<Reg>,
    /// Results that arrive, by file.
    writes: BTreeMap<RegFile, u32>,
    /// A port to the outside is used.
    io: bool,
}

impl<'a> Table<'a> {
    /// A table with nothing taken.
    pub(super) fn new(target: &'a Target<'a>) -> Table<'a> {
        Table {
            target,
            rows: Vec::new(),
        }
    }

    fn row(&mut self, cycle: u32) -> &mut Row {
        let cycle = cycle as usize;
        if self.rows.len() <= cycle {
            self.rows.resize(cycle + 1, Row::default());
        }
        &mut self.rows[cycle]
    }

    fn at(&self, cycle: u32) -> Option<&Row> {
        self.rows.get(cycle as usize)
    }

    /// True if `op` can issue in `cycle` on `fu`.
    pub(super) fn fits(&self, cycle: u32, fu: Fu, how: &FuOp, op: &Step) -> bool {
        let is_io = op.op.info().effect == Effect::Io;
        let io = is_io && self.at(cycle).is_some_and(|row| row.io);
        !io && self.fits_unit(cycle, fu, how)
            && self.fits_reads(cycle, &op.srcs)
            && op
                .dst
                .is_none_or(|dst| self.fits_write(cycle + how.latency, dst))
    }

    /// Takes the resources of `op` when it issues in `cycle` on `fu`.
    pub(super) fn take(&mut self, cycle: u32, fu: Fu, how: &FuOp, op: &Step) {
        self.take_unit(cycle, fu, how);
        self.take_reads(cycle, &op.srcs);
        self.row(cycle).io |= op.op.info().effect == Effect::Io;
        if let Some(dst) = op.dst {
            self.take_write(cycle + how.latency, dst);
        }
    }

    /// True if `transfer` can issue in `cycle`.
    pub(super) fn fits_transfer(&self, cycle: u32, transfer: Transfer) -> bool {
        let write = transfer.writes(self.target);
        self.branch_unit(cycle).is_some()
            && self.fits_reads(cycle, &self.transfer_reads(transfer))
            && write.is_none_or(|link| self.fits_write(self.arrival(cycle), link))
    }

    /// Takes the resources of `transfer` when it issues in `cycle`, if they are free.
    pub(super) fn take_transfer(&mut self, cycle: u32, transfer: Transfer) {
        let Some((fu, how)) = self.branch_unit(cycle) else {
            return;
        };
        self.take_unit(cycle, fu, how);
        self.take_reads(cycle, &self.transfer_reads(transfer));
        if let Some(link) = transfer.writes(self.target) {
            self.take_write(self.arrival(cycle), link);
        }
    }

    /// When the target of a transfer in `cycle` issues.
    fn arrival(&self, cycle: u32) -> u32 {
        cycle + self.target.srp.branch_delay + 1
    }

    fn transfer_reads(&self, transfer: Transfer) -> Vec<Src> {
        let read = transfer.reads(self.target);
        read.map(Src::Reg).into_iter().collect()
    }

    /// The branch unit that a transfer in `cycle` takes: that of the first slot that is free then.
    fn branch_unit(&self, cycle: u32) -> Option<(Fu, &'a FuOp)> {
        let is_free = |fu| self.at(cycle).is_none_or(|row| !row.busy.contains(&fu));
        let (fu, how) = self.target.branch_slots().find(|&(fu, _)| is_free(fu))?;
        self.fits_unit(cycle, fu, how).then_some((fu, how))
    }

    fn fits_unit(&self, cycle: u32, fu: Fu, how: &FuOp) -> bool {
        (cycle..cycle + how.interval).all(|c| {
            self.at(c).is_none_or(|row| {
                let fits = |&r: &srp_archdesc::arch::Resource| {
                    let taken = row.shared.get(&r.index()).copied().unwrap_or(0);
                    taken + super::target::uses(how, r) <= self.target.srp.resources[r].count
                };
                !row.busy.contains(&fu) && how.uses.iter().all(fits)
            })
        })
    }

    fn take_unit(&mut self, cycle: u32, fu: Fu, how: &FuOp) {
        for c in cycle..cycle + how.interval {
            let row = self.row(c);
            row.busy.push(fu);
            for r in &how.uses {
                *row.shared.entry(r.index()).or_insert(0) += 1;
            }
        }
    }

    fn fits_reads(&self, cycle: u32, srcs: &[Src]) -> bool {
        let before = self.at(cycle).map_or(&[][..], |row| &row.reads);
        let all: Vec<Src> = before
            .iter()
            .map(|&r| Src::Reg(r))
            .chain(srcs.iter().copied())
            .collect();
        reads_by_file(&all)
            .into_iter()
            .all(|(file, regs)| regs.len() as u32 <= self.target.srp.files[file].read_ports)
    }

    fn take_reads(&mut self, cycle: u32, srcs: &[Src]) {
        let regs = srcs.iter().filter_map(|src| match src {
            Src::Reg(reg) => Some(*reg),
            Src::Const(_) => None,
        });
        self.row(cycle).reads.extend(regs);
    }

    fn fits_write(&self, cycle: u32, dst: Reg) -> bool {
        let row = self.at(cycle);
        let taken = row.and_then(|row| row.writes.get(&dst.file)).copied();
        taken.unwrap_or(0) < self.target.srp.files[dst.file].write_ports
    }

    fn take_write(&mut self, cycle: u32, dst: Reg) {
        *self.row(cycle).writes.entry(dst.file).or_insert(0) += 1;
    }
}
