//! `--what-if`: changes that lower a loop's II, found by really scheduling it again.

use super::hint;
use super::model::{Change, LoopReport, Ordered, Report, WhatIf};
use crate::interrupt;
use crate::pipeline::Effort;
use crate::talk::Progress;
use srp_archdesc::arch::Arch;
use srp_ir::dfg::{Dfg, Order};
use srp_ir::dre::scheduled::ModuloSchedule;
use srp_scheduler::modulo;
use srp_scheduler::what_if::what_if;

/// Tries changes of the machine, and of what is known of the accesses, for every loop of a report.
pub(super) fn try_changes(report: &mut Report, schedules: &[&ModuloSchedule], arch: &Arch) {
    let progress = Progress::steps("what if", report.loops.len() as u64);
    for (done, l) in report.loops.iter_mut().enumerate() {
        progress.at(done as u64);
        let Some(schedule) = schedules.iter().find(|s| s.dfg.name == l.kernel) else {
            continue;
        };
        l.what_if = Some(interrupt::looked_for(|| of_loop(l, schedule, arch)));
        l.hint = hint::of(l);
    }
    report.complete = report.complete && !interrupt::requested();
    report.advice = hint::advice(&report.loops);
}

fn of_loop(l: &LoopReport, schedule: &ModuloSchedule, arch: &Arch) -> WhatIf {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let found =
        Effort::Steps.with(|options| what_if(&schedule.dfg, arch, schedule.ii, &options, threads));
    let machine = found.changes.into_iter();
    let mut changes: Vec<Change> = machine
        .map(|c| Change {
            what: c.what,
            ii: c.ii,
        })
        .collect();
    let mut tried = found.tried;
    if let Some(free) = without_doubtful_orders(&schedule.dfg, &l.ordered) {
        tried += 1;
        changes.extend(unordered(&free, arch, schedule.ii));
    }
    changes.sort_by_key(|c| c.ii);
    WhatIf { tried, changes }
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
    if interrupt::requested() || modulo::bounds(free, arch).min_ii() >= ii {
        return None;
    }
    let scheduled = Effort::Steps.with(|options| modulo::schedule(free, arch, &options));
    let reached = scheduled.ok()?.schedule.ii;
    (reached < ii).then(|| Change {
        what: "accesses known never to meet (named arrays, not pointers)".to_owned(),
        ii: reached,
    })
}
