//! Schedules of loops. The cache keeps each, so that it is searched for once.

use crate::Session;
use crate::cache::{Key, Kind};
use crate::session::Timed;
use srp_archdesc::arch::{Arch, Srp};
use srp_archdesc::threads;
use srp_archdesc::watch::{Event, Named, Stage, Watch};
use srp_ir::dfg::Dfg;
use srp_scheduler::{LoopResult, modulo};
use std::cmp::Reverse;

/// Names the sources of the scheduler.
const SCHEDULER: &str = env!("SRP_SCHEDULER_ID");

/// Schedules a loop by itself, or takes its schedule from the cache. The same loop in another program or file, or on
/// another machine that is the same [as the loop sees it](modulo::seen_by), has the same schedule.
pub fn schedule_loop(
    dfg: &Dfg,
    srp: &Srp,
    options: &modulo::Options,
    session: &Session<'_>,
    watch: &dyn Watch,
) -> LoopResult {
    let anonymous = dfg.anonymous();
    let srp = &modulo::seen_by(dfg, srp);
    let key = key_of_seen(&anonymous, srp, options);
    let known = session.cache.get::<LoopResult>(key, watch);
    let result = known.unwrap_or_else(|| {
        let result = modulo::schedule(&anonymous, srp, options, watch);
        // A search that was cut short depends on when.
        if !watch.cancelled() {
            session.cache.put(key, &result, watch);
        }
        result
    });
    match result {
        Ok(mut scheduled) => {
            scheduled.schedule.dfg = dfg.clone();
            if let Some(failed) = &mut scheduled.why_not_lower {
                failed.relocate(dfg);
            }
            Ok(scheduled)
        }
        Err(mut why) => {
            why.relocate(dfg);
            Err(why)
        }
    }
}

/// The key of a loop's schedule by itself.
pub(crate) fn key(dfg: &Dfg, srp: &Srp, options: &modulo::Options) -> Key {
    key_of_seen(&dfg.anonymous(), &modulo::seen_by(dfg, srp), options)
}

fn key_of_seen(anonymous: &Dfg, srp: &Srp, options: &modulo::Options) -> Key {
    Key::of(Kind::Loops)
        .text(SCHEDULER)
        .value(anonymous)
        .value(srp)
        .value(options)
        .finish()
}

/// Schedules all loops of a program.
pub(crate) fn schedule_all(
    dfgs: &[&Dfg],
    arch: &Arch,
    options: &modulo::Options,
    session: &Session<'_>,
    watch: &Timed<'_>,
) -> Vec<LoopResult> {
    let stage = Stage::of(watch, "scheduling", dfgs.len() as u64);
    // The largest begin, so that none is left for one thread at the end.
    let mut order: Vec<usize> = (0..dfgs.len()).collect();
    order.sort_by_key(|&index| Reverse(dfgs[index].nodes.len()));
    let one = |(): &mut (), place: usize| {
        let dfg: &Dfg = dfgs[order[place]];
        watch.tell(Event::ItemBegins(&dfg.name));
        let named = Named::new(watch, &dfg.name);
        let result = schedule_loop(dfg, &arch.srp, options, session, &named);
        watch.tell(Event::ItemEnds(&dfg.name));
        stage.done(1);
        result
    };
    let results = threads::each(session.threads, dfgs.len(), || (), one);
    let mut results: Vec<(usize, LoopResult)> = order.iter().copied().zip(results).collect();
    results.sort_by_key(|(index, _)| *index);
    let mut results: Vec<LoopResult> = results.into_iter().map(|(_, result)| result).collect();
    if arch.srp.shared_contexts {
        share(&mut results, dfgs, &arch.srp, options, session, watch);
    }
    results
}

/// Makes schedules that share the configuration memory fit in it together, as far as they can at their IIs: while they
/// do not, the one with the most contexts is made with half of them, where it repeats its II for the sake of registers.
fn share(
    results: &mut [LoopResult],
    dfgs: &[&Dfg],
    srp: &Srp,
    options: &modulo::Options,
    session: &Session<'_>,
    watch: &dyn Watch,
) {
    let contexts = |result: &LoopResult| {
        let schedule = result.as_ref().ok().map(|scheduled| &scheduled.schedule);
        schedule.map_or((0, 0), |s| (s.contexts(), s.ii))
    };
    let mut settled = vec![false; results.len()];
    let fit = |results: &[LoopResult]| {
        let all = results.iter().map(|result| u64::from(contexts(result).0));
        all.sum::<u64>() <= u64::from(srp.contexts)
    };
    while !fit(results) && !watch.cancelled() {
        let repeats = |&number: &usize| {
            let (all, ii) = contexts(&results[number]);
            !settled[number] && all > ii
        };
        // The first of equals.
        let candidates = (0..results.len()).rev().filter(repeats);
        let Some(most) = candidates.max_by_key(|&number| contexts(&results[number]).0) else {
            return;
        };
        let (all, ii) = contexts(&results[most]);
        let smaller = Srp {
            contexts: (all / 2).max(ii),
            ..srp.clone()
        };
        let found = schedule_loop(dfgs[most], &smaller, options, session, watch);
        match (&mut results[most], found) {
            // What was found of lower IIs holds with all contexts.
            (Ok(scheduled), Ok(found)) if contexts(&Ok(found.clone())).1 == ii => {
                scheduled.schedule = found.schedule;
            }
            _ => settled[most] = true,
        }
    }
}
