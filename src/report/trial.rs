//! `--what-if`: changes that lower a loop's II, found by really scheduling it again.

use super::hint;
use super::model::{Change, LoopReport, Ordered, Report, WhatIf};
use crate::interrupt;
use crate::talk::CONSOLE;
use crate::talk::Progress;
use srp_archdesc::arch::Arch;
use srp_ir::dfg::{Dfg, Order};
use srp_ir::dre::scheduled::ModuloSchedule;
use srp_scheduler::modulo::{self, FailedIi};
use srp_scheduler::what_if::what_if;

/// Tries changes of the machine, and of what is known of the accesses, for every loop of a report,
/// and for loops that the machine kept from the array.
pub(super) fn try_changes(
    report: &mut Report,
    schedules: &[(&ModuloSchedule, Option<&FailedIi>)],
    refused: &[Dfg],
    arch: &Arch,
) {
    let all = report.loops.len() + report.not_pipelined.len();
    let progress = Progress::steps("what if", all as u64);
    let mut done = 0;
    let mut step = || {
        progress.at(done);
        done += 1;
    };
    for l in &mut report.loops {
        step();
        let Some((schedule, failed)) = schedules.iter().find(|(s, _)| s.dfg.name == l.kernel)
        else {
            continue;
        };
        l.what_if = Some(interrupt::looked_for(|| of_loop(l, schedule, arch)));
        l.hint = hint::of(l, *failed);
    }
    for n in &mut report.not_pipelined {
        step();
        let dfg = refused.iter().find(|dfg| dfg.name == n.kernel);
        n.what_if = dfg.map(|dfg| interrupt::looked_for(|| of_machine(dfg, arch, u32::MAX)));
    }
    report.complete = report.complete && !interrupt::requested();
    report.advice = hint::advice(report);
}

/// Changes of the machine alone that bring an II below `ii`.
fn of_machine(dfg: &Dfg, arch: &Arch, ii: u32) -> WhatIf {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let found = what_if(
        dfg,
        &arch.srp,
        ii,
        &modulo::Options::default(),
        threads,
        &CONSOLE,
    );
    let change = |c: srp_scheduler::what_if::Change| Change {
        what: c.in_words(&arch.srp),
        ii: c.ii,
    };
    WhatIf {
        tried: found.tried,
        changes: found.changes.into_iter().map(change).collect(),
    }
}

fn of_loop(l: &LoopReport, schedule: &ModuloSchedule, arch: &Arch) -> WhatIf {
    let mut all = of_machine(&schedule.dfg, arch, schedule.ii);
    if let Some(free) = without_doubtful_orders(&schedule.dfg, &l.ordered) {
        all.tried += 1;
        all.changes.extend(unordered(&free, arch, schedule.ii));
    }
    all.changes.sort_by_key(|c| c.ii);
    all
}

/// The loop without the orders that are kept only for want of knowledge; `None` where it has none.
fn without_doubtful_orders(dfg: &Dfg, ordered: &[Ordered]) -> Option<Dfg> {
    let place = |node| {
        let pos = dfg.nodes[node].pos;
        (pos.line, pos.column)
    };
    let doubtful = |o: &Order| {
        let ends = (place(o.from), place(o.to));
        ordered.iter().any(|pair| {
            let first = (pair.first.line, pair.first.column);
            let second = (pair.second.line, pair.second.column);
            ends == (first, second) || ends == (second, first)
        })
    };
    let mut free = dfg.clone();
    free.order.retain(|o| !doubtful(o));
    (free.order.len() < dfg.order.len()).then_some(free)
}

fn unordered(free: &Dfg, arch: &Arch, ii: u32) -> Option<Change> {
    if interrupt::requested() || modulo::bounds(free, &arch.srp).min_ii() >= ii {
        return None;
    }
    let scheduled = modulo::schedule(free, &arch.srp, &modulo::Options::default(), &CONSOLE);
    let reached = scheduled.ok()?.schedule.ii;
    (reached < ii).then(|| Change {
        what: "accesses known never to meet (named arrays, or `restrict` pointers)".to_owned(),
        ii: reached,
    })
}
