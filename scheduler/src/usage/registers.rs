//! Register pressure: which registers hold something that is still needed, slot by slot.
//!
//! In the steady state everything repeats with the II, so it is enough to follow iteration 0. A
//! read finds the result of the latest write to its register; in between, the register is live. A
//! register that is read and never written holds a loop invariant.

use super::{FileUse, timing};
use crate::abi;
use srp_archdesc::arch::{FileKind, FileSpec, RegFile, Srp};
use srp_archdesc::entity::EntityMap;
use srp_ir::dre::scheduled::{ModuloSchedule, Reg, RegAt, Source};
use std::collections::BTreeSet;

/// A value put into a register of its iteration, from cycle `from` of iteration 0 on.
struct Write {
    at: RegAt,
    from: i64,
    /// Cycles from then until it is read last; none where nothing reads it.
    needed: Option<i64>,
}

/// A register read in cycle `time` of iteration 0.
struct Read {
    at: RegAt,
    distance: i64,
    time: i64,
}

/// Returns the use of each file and its ports.
pub(super) fn files(schedule: &ModuloSchedule, srp: &Srp) -> EntityMap<RegFile, FileUse> {
    let (mut writes, mut reads) = accesses(schedule, srp);
    let reserved = abi::reserved(srp);
    let passed = schedule.live_in_regs.iter().chain(&schedule.live_out_regs);
    let fixed: BTreeSet<Reg> = passed.copied().chain(reserved).collect();
    let of_file = |(file, spec): (RegFile, &FileSpec)| {
        let own = fixed.iter().filter(|r| r.file == file).map(|r| r.index);
        let contents = Contents {
            rotating: spec.kind == FileKind::Rotating,
            size: i64::from(spec.size),
            ii: i64::from(schedule.ii),
            writes: std::mem::take(&mut writes[file]),
            reads: std::mem::take(&mut reads[file]),
            kept: own.collect(),
        };
        contents.used(srp.contexts)
    };
    srp.files.iter().map(of_file).collect()
}

type Accesses = (
    EntityMap<RegFile, Vec<Write>>,
    EntityMap<RegFile, Vec<Read>>,
);

/// Writes and reads of each file.
fn accesses(schedule: &ModuloSchedule, srp: &Srp) -> Accesses {
    let mut writes: EntityMap<RegFile, Vec<Write>> =
        srp.files.values().map(|_| Vec::new()).collect();
    let mut reads: EntityMap<RegFile, Vec<Read>> = srp.files.values().map(|_| Vec::new()).collect();
    let mut write = |at: RegAt, from: u32| {
        writes[at.file].push(Write {
            at,
            from: from.into(),
            needed: None,
        });
    };
    for op in schedule.ops.values() {
        let latency = timing(schedule, srp, op).map_or(1, |how| how.latency);
        for &at in &op.writes {
            write(at, op.time + latency);
        }
        for source in &op.operands {
            if let Source::Reg { reg, distance } = *source {
                reads[reg.file].push(Read {
                    at: reg,
                    distance: distance.into(),
                    time: op.time.into(),
                });
            }
        }
    }
    for transfer in &schedule.transfers {
        let delay = srp.delay(transfer.over);
        write(transfer.to, transfer.time + delay + 1);
    }
    (writes, reads)
}

/// One file in the steady state.
struct Contents {
    rotating: bool,
    size: i64,
    ii: i64,
    writes: Vec<Write>,
    reads: Vec<Read>,
    /// Registers that hold one thing throughout.
    kept: BTreeSet<u32>,
}

impl Contents {
    fn used(mut self, contexts: u32) -> FileUse {
        let period = self.period(contexts);
        self.lifetimes(period);
        let ii = self.ii as usize;
        let kept = self.kept.len() as u32;
        let mut used = FileUse {
            live: vec![kept; ii],
            kept,
            reads: (0..self.ii)
                .map(|slot| self.read_in(slot, period))
                .collect(),
            writes: vec![0; ii],
        };
        for write in &self.writes {
            used.writes[write.from.rem_euclid(self.ii) as usize] += 1;
            let own = self.rotating || !self.kept.contains(&write.at.index);
            let cycles = write.needed.filter(|_| own).map_or(0, |needed| needed + 1);
            for (slot, live) in used.live.iter_mut().enumerate() {
                // The cycles of its life that fall into this slot.
                let after = (slot as i64 - write.from).rem_euclid(self.ii);
                *live += (cycles - after + self.ii - 1).max(0).div_euclid(self.ii) as u32;
            }
        }
        used
    }

    /// Iterations after which the names of registers repeat, apart from rotation.
    fn period(&self, contexts: u32) -> i64 {
        if self.rotating {
            return 1;
        }
        let rings = self.writes.iter().map(|w| w.at.ring);
        let rings = rings.chain(self.reads.iter().map(|r| r.at.ring));
        let most = i64::from(contexts.max(1));
        rings.fold(1, |all, ring| lcm(all, i64::from(ring.max(1))).min(most))
    }

    /// Finds out how long each write is needed, and which registers are never written.
    fn lifetimes(&mut self, period: i64) {
        for read in &self.reads {
            for iteration in 0..period {
                let register = self.register(read.at, iteration - read.distance);
                let cycle = read.time + self.ii * iteration;
                let since = |(i, w): (usize, &Write)| Some((self.since(w, register, cycle)?, i));
                let latest = self.writes.iter().enumerate().filter_map(since).min();
                match latest {
                    Some((cycles, i)) => {
                        let needed = &mut self.writes[i].needed;
                        *needed = Some(needed.map_or(cycles, |n| n.max(cycles)));
                    }
                    None => {
                        self.kept.insert(register as u32);
                    }
                }
            }
        }
    }

    /// Cycles that have passed in `cycle` since a write last put a value into a register; `None`
    /// where it never does.
    fn since(&self, write: &Write, register: i64, cycle: i64) -> Option<i64> {
        let first = i64::from(write.at.index);
        let ring = i64::from(write.at.ring.max(1));
        let modulus = if self.rotating { self.size } else { ring };
        if !self.rotating && !(first..first + ring).contains(&register) {
            return None;
        }
        let latest = (cycle - write.from).div_euclid(self.ii);
        let iteration = latest - (latest - (register - first)).rem_euclid(modulus.max(1));
        Some(cycle - write.from - self.ii * iteration)
    }

    fn register(&self, at: RegAt, iteration: i64) -> i64 {
        at.physical(iteration, self.rotating, self.size as u32)
            .into()
    }

    /// The most registers read in a slot by one iteration of the kernel.
    fn read_in(&self, slot: i64, period: i64) -> u32 {
        let here = |r: &&Read| r.time.rem_euclid(self.ii) == slot;
        let of_round = |round: i64| {
            let register = |r: &Read| {
                let iteration = round - r.time.div_euclid(self.ii);
                self.register(r.at, iteration - r.distance)
            };
            let read: BTreeSet<i64> = self.reads.iter().filter(here).map(register).collect();
            read.len() as u32
        };
        (0..period).map(of_round).max().unwrap_or(0)
    }
}

fn lcm(a: i64, b: i64) -> i64 {
    let (mut x, mut y) = (a, b);
    while y != 0 {
        (x, y) = (y, x % y);
    }
    a / x * b
}
