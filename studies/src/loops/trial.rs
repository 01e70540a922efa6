//! Changes that lower a loop's II, found by really scheduling it again.

use super::Subject;
use super::changes::{Advice, Change, Lowered, WhatIf};
use super::measure::Names;
use super::model::{LoopReport, Ordered, Report};
use crate::bases::{Bases, Made};
use srp_archdesc::arch::{Arch, Srp};
use srp_archdesc::watch::Stage;
use srp_ir::dfg::{Dfg, Order};
use srp_ir::dre::scheduled::ModuloSchedule;
use srp_scheduler::modulo;
use srp_scheduler::what_if;
use srp_toolchain::{Session, schedule_loop};

/// Steps of the search for the II that is left without aliases: enough to see what order it is of.
const RESTRICT_EFFORT: u64 = 200_000;

/// A change that lowers an II.
#[derive(Clone, Debug, PartialEq)]
enum Remedy {
    /// Another machine.
    Machine(Made),
    /// Knowledge that accesses to different objects never meet, which nothing shows.
    Apart,
    /// Knowledge that iterations never meet in an element of an object either.
    Independent,
}

/// A machine that changes are tried on.
#[derive(Clone, Copy)]
pub(super) struct Machine<'a> {
    pub(super) arch: &'a Arch,
    /// The text of its file, where there is one.
    pub(super) text: Option<&'a str>,
}

impl Remedy {
    fn in_words(&self, bases: &Bases<'_>) -> String {
        match self {
            Remedy::Machine(made) => bases.in_words(made),
            Remedy::Apart => {
                "accesses known never to meet (named arrays, or `restrict` pointers)".to_owned()
            }
            Remedy::Independent => {
                "iterations known never to meet in an element (`#pragma srp independent`)"
                    .to_owned()
            }
        }
    }

    /// The settings of the machine's file that make it.
    fn settings(&self, bases: &Bases<'_>) -> Vec<String> {
        match self {
            Remedy::Machine(made) => bases.settings(made),
            Remedy::Apart | Remedy::Independent => Vec::new(),
        }
    }

    /// The entry of a report.
    fn change(&self, ii: u32, bases: &Bases<'_>) -> Change {
        match self {
            Remedy::Machine(made) => Change::of(made, ii, bases),
            Remedy::Apart | Remedy::Independent => Change {
                what: self.in_words(bases),
                set: Vec::new(),
                ii,
                mm2: None,
            },
        }
    }
}

/// The outcome of trying remedies for a loop.
struct Tried {
    kernel: String,
    /// Its II; `None` where it is not on the array.
    ii: Option<u32>,
    /// How many were tried.
    count: u32,
    /// Those that help, with the II that they give.
    remedies: Vec<(Remedy, u32)>,
}

impl Tried {
    fn report(&self, bases: &Bases<'_>) -> WhatIf {
        let change = |(remedy, ii): &(Remedy, u32)| remedy.change(*ii, bases);
        WhatIf {
            tried: self.count,
            changes: self.remedies.iter().map(change).collect(),
        }
    }
}

/// Tries changes of the machine, and of the facts known of the accesses, for every loop of a report, and for
/// loops that the machine kept from the array.
pub(super) fn try_changes(
    report: &mut Report,
    subject: &Subject<'_>,
    machine: Machine<'_>,
    session: &Session<'_>,
) {
    let srp = &machine.arch.srp;
    let bases = Bases::of(machine.arch, machine.text);
    let all = report.loops.len() + report.not_pipelined.len();
    let stage = Stage::of(session.watch, "what if", all as u64);
    let (mut on_array, mut refused) = (Vec::new(), Vec::new());
    for l in &mut report.loops {
        if let Some((schedule, _)) = subject.find(&l.kernel) {
            let names = Names(subject.files);
            let tried = of_loop(l, schedule, &names, (srp, &bases), session);
            l.what_if = Some(tried.report(&bases));
            on_array.push(tried);
        }
        stage.done(1);
    }
    for n in &mut report.not_pipelined {
        if let Some(dfg) = subject.refused(&n.kernel) {
            let tried = of_machine(dfg, None, &bases, session);
            n.what_if = Some(tried.report(&bases));
            refused.push(tried);
        }
        stage.done(1);
    }
    report.complete &= !session.watch.cancelled();
    report.advice = advice(refused.iter().chain(&on_array), &bases);
}

/// Tries what II each loop has whose bound is lower where its pointers are `restrict`.
pub(super) fn try_restrict(
    report: &mut Report,
    subject: &Subject<'_>,
    arch: &Arch,
    session: &Session<'_>,
) {
    let srp = &arch.srp;
    for l in &mut report.loops {
        let (Some(bound), Some((schedule, _))) = (l.restrict_bound, subject.find(&l.kernel)) else {
            continue;
        };
        if bound >= l.ii || session.watch.cancelled() {
            continue;
        }
        let Some(relaxed) = subject.relaxed(&schedule.dfg) else {
            continue;
        };
        let options = modulo::Options {
            effort: RESTRICT_EFFORT,
            exact_effort: 0,
            compaction: 0,
            ..modulo::Options::default()
        };
        let found = schedule_loop(&relaxed, srp, &options, session, session.watch);
        l.restrict_ii = (found.ok())
            .map(|found| found.schedule.ii)
            .filter(|ii| *ii < l.ii);
    }
}

/// Changes of the machine alone that bring an II below `ii`, or a loop onto the array.
fn of_machine(dfg: &Dfg, ii: Option<u32>, bases: &Bases<'_>, session: &Session<'_>) -> Tried {
    let options = modulo::Options::default();
    let on = (session.threads, session.watch);
    let found = bases.try_changes(dfg, ii.unwrap_or(u32::MAX), &options, on);
    let remedy = |change: what_if::Change| {
        let ii = change.ii;
        (Remedy::Machine(change.into()), ii)
    };
    Tried {
        kernel: dfg.name.clone(),
        ii,
        count: found.tried,
        remedies: found.changes.into_iter().map(remedy).collect(),
    }
}

fn of_loop(
    l: &LoopReport,
    schedule: &ModuloSchedule,
    names: &Names<'_>,
    (srp, bases): (&Srp, &Bases<'_>),
    session: &Session<'_>,
) -> Tried {
    let mut tried = of_machine(&schedule.dfg, Some(schedule.ii), bases, session);
    let apart: Vec<&Ordered> = l.ordered.iter().filter(|o| !o.in_one_object).collect();
    let all: Vec<&Ordered> = l.ordered.iter().collect();
    let mut last = schedule.ii;
    for (remedy, ordered) in [(Remedy::Apart, apart), (Remedy::Independent, all)] {
        if let Some(free) = without_orders(&schedule.dfg, &ordered, names) {
            tried.count += 1;
            if let Some(ii) = unordered(&free, last, srp, session) {
                tried.remedies.push((remedy, ii));
                last = ii;
            }
        }
    }
    tried.remedies.sort_by_key(|&(_, ii)| ii);
    tried
}

/// The loop without some of the orders that are kept only for want of knowledge; `None` where it has none of these.
fn without_orders(dfg: &Dfg, ordered: &[&Ordered], names: &Names<'_>) -> Option<Dfg> {
    let place = |node| names.position(dfg.nodes[node].pos);
    let doubtful = |o: &Order| {
        let (from, to) = (place(o.from), place(o.to));
        ordered.iter().any(|Ordered { first, second, .. }| {
            (&from, &to) == (first, second) || (&to, &from) == (first, second)
        })
    };
    let mut free = dfg.clone();
    free.order.retain(|o| !doubtful(o));
    (free.order.len() < dfg.order.len()).then_some(free)
}

/// The II of a loop without some of its orders, where it is below `ii`.
fn unordered(free: &Dfg, ii: u32, srp: &Srp, session: &Session<'_>) -> Option<u32> {
    if session.watch.cancelled() || modulo::bounds(free, srp).min_ii() >= ii {
        return None;
    }
    let options = modulo::Options::default();
    let scheduled = schedule_loop(free, srp, &options, session, session.watch);
    let reached = scheduled.ok()?.schedule.ii;
    (reached < ii).then_some(reached)
}

/// Returns the changes that help several loops or one, each with the loops whose II it lowers: those first
/// that bring loops onto the array, then those that help most loops.
fn advice<'a>(tried: impl Iterator<Item = &'a Tried>, bases: &Bases<'_>) -> Vec<Advice> {
    let mut remedies: Vec<(&Remedy, Vec<Lowered>)> = Vec::new();
    for Tried {
        kernel,
        ii,
        remedies: helping,
        ..
    } in tried
    {
        for (remedy, to) in helping {
            let lowered = Lowered {
                kernel: kernel.clone(),
                from: *ii,
                to: *to,
            };
            match remedies.iter_mut().find(|(known, _)| *known == remedy) {
                Some((_, lowers)) => lowers.push(lowered),
                None => remedies.push((remedy, vec![lowered])),
            }
        }
    }
    let cycles = |l: &Lowered| l.from.map_or(0, |from| from - l.to);
    let saved = |lowers: &[Lowered]| lowers.iter().map(cycles).sum::<u32>();
    let new = |lowers: &[Lowered]| lowers.iter().filter(|l| l.from.is_none()).count();
    remedies
        .sort_by_key(|(_, lowers)| std::cmp::Reverse((new(lowers), lowers.len(), saved(lowers))));
    let advice = |(remedy, lowers): (&Remedy, Vec<Lowered>)| Advice {
        what: remedy.in_words(bases),
        set: remedy.settings(bases),
        lowers,
    };
    remedies.into_iter().map(advice).collect()
}
