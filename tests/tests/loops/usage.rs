//! Compares the usage that is reported for a schedule with a plain run of it.

use srp_archdesc::arch::{Arch, Carrier, FileKind, Input, RegFile};
use srp_ir::dre::scheduled::{ModuloSchedule, PlacedHop, Reg, RegAt, Source};
use srp_scheduler::abi;
use srp_scheduler::usage::{LinkUse, Usage, opcode, usage};
use std::collections::{BTreeMap, BTreeSet};

/// Events of a register, by cycle.
#[derive(Default)]
struct Events {
    /// Cycles in which something new stands in it.
    written: BTreeSet<i64>,
    /// Cycles in which it is read.
    read: BTreeSet<i64>,
}

/// Runs the loop for as long as it takes to repeat, and compares a round in the middle.
pub(super) fn agrees(schedule: &ModuloSchedule, arch: &Arch, seed: &str) {
    let ii = i64::from(schedule.ii);
    let largest = arch.srp.files.values().map(|f| f.size).max().unwrap_or(1);
    let rounds = i64::from(schedule.stages() + 2 * largest) + 8;
    let run = run(schedule, arch, 2 * rounds);
    let fixed: BTreeSet<Reg> = (schedule.live_in_regs.iter())
        .chain(&schedule.live_out_regs)
        .copied()
        .chain(abi::reserved(&arch.srp))
        .collect();
    let used = usage(schedule, &arch.srp);
    for (file, spec) in arch.srp.files.iter() {
        for slot in 0..ii {
            let cycle = rounds * ii + slot;
            let live = (0..spec.size).filter(|&index| {
                let reg = Reg { file, index };
                fixed.contains(&reg) || run.get(&reg).is_some_and(|events| is_live(events, cycle))
            });
            let (live, name) = (live.count() as u32, &spec.name);
            let said = used.files[file].live[slot as usize];
            assert_eq!(
                said, live,
                "seed {seed}: registers of {name} in slot {slot}"
            );
            let read = |events: &&Events| events.read.contains(&cycle);
            let written = |events: &&Events| events.written.contains(&cycle);
            let own = |file: RegFile| run.iter().filter(move |(reg, _)| reg.file == file);
            let read = own(file).map(|(_, e)| e).filter(read).count();
            let written = own(file).map(|(_, e)| e).filter(written).count();
            // With registers in turn, rounds differ; the most of any counts.
            assert!(
                read as u32 <= used.files[file].reads[slot as usize],
                "seed {seed}: {name}"
            );
            assert_eq!(
                written as u32, used.files[file].writes[slot as usize],
                "seed {seed}: {name}"
            );
        }
        assert!(
            used.files[file].worst().0 <= spec.size,
            "seed {seed}: {}",
            spec.name
        );
    }
    for (fu, unit) in used.units.iter() {
        assert!(
            unit.busy() <= schedule.ii,
            "seed {seed}: {}",
            arch.srp.fus[fu].name
        );
    }
    for (resource, uses) in used.resources.iter() {
        let most = uses.iter().max().copied().unwrap_or(0);
        assert!(
            most <= arch.srp.resources[resource].count,
            "seed {seed}: too many uses"
        );
    }
    carriers(schedule, &used, seed);
}

/// Compares what links and wires carry with what is taken from them.
fn carriers(schedule: &ModuloSchedule, used: &Usage, seed: &str) {
    let taken = |is: fn(&Source) -> bool, over: fn(&Carrier) -> bool, hops: usize| {
        let operands = schedule.ops.values().flat_map(|op| &op.operands);
        let transfers = schedule.transfers.iter().map(|t| &t.over);
        operands.filter(|s| is(s)).count() + transfers.filter(|o| over(o)).count() + hops
    };
    let from_wires = |hop: &&PlacedHop| matches!(hop.from, Input::Wire(_));
    let of_links = taken(
        |s| matches!(s, Source::Out(Some(_))),
        |o| matches!(o, Carrier::Link(_)),
        0,
    );
    let of_wires = taken(
        |s| matches!(s, Source::Wire(_)),
        |o| matches!(o, Carrier::Wire(_)),
        schedule.hops.iter().filter(from_wires).count(),
    );
    let carried = |all: std::slice::Iter<'_, LinkUse>| all.map(|l| l.carried.len()).sum::<usize>();
    for (taken, carried) in [
        (of_links, carried(used.links.values())),
        (of_wires, carried(used.wires.values())),
    ] {
        assert!(carried <= taken, "seed {seed}: links");
        assert_eq!(carried == 0, taken == 0, "seed {seed}: links");
    }
    // A wire takes nothing for nobody.
    let slots: u32 = used.wires.values().map(|wire| wire.slots()).sum();
    assert_eq!(slots as usize, schedule.hops.len(), "seed {seed}: wires");
}

/// True if the value of a register in a cycle is read before it is written again.
fn is_live(events: &Events, cycle: i64) -> bool {
    let next_read = events.read.range(cycle..).next();
    let next_write = events.written.range(cycle + 1..).next();
    match (next_read, next_write) {
        (Some(read), Some(write)) => read < write,
        (Some(_), None) => true,
        (None, _) => false,
    }
}

/// Reads and writes of every register in so many iterations.
fn run(schedule: &ModuloSchedule, arch: &Arch, iterations: i64) -> BTreeMap<Reg, Events> {
    let mut run: BTreeMap<Reg, Events> = BTreeMap::new();
    let register = |at: RegAt, iteration: i64| {
        let spec = &arch.srp.files[at.file];
        let rotating = spec.kind == FileKind::Rotating;
        Reg {
            file: at.file,
            index: at.physical(iteration, rotating, spec.size),
        }
    };
    for iteration in 0..iterations {
        let start = i64::from(schedule.ii) * iteration;
        let mut write = |at: RegAt, cycle: u32| {
            let events = run.entry(register(at, iteration)).or_default();
            events.written.insert(start + i64::from(cycle));
        };
        for op in schedule.ops.values() {
            let latency = arch.srp.fus[op.fu]
                .timing(opcode(schedule, op))
                .expect("the unit runs it")
                .latency;
            op.writes
                .iter()
                .for_each(|&at| write(at, op.time + latency));
        }
        for transfer in &schedule.transfers {
            let delay = arch.srp.delay(transfer.over);
            write(transfer.to, transfer.time + delay + 1);
        }
        for op in schedule.ops.values() {
            for source in &op.operands {
                if let Source::Reg { reg, distance } = *source {
                    let from = register(reg, iteration - i64::from(distance));
                    let events = run.entry(from).or_default();
                    events.read.insert(start + i64::from(op.time));
                }
            }
        }
    }
    run
}
