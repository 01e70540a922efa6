//! Schedules of loops. The cache keeps each, so that it is searched for once.

use crate::Session;
use crate::cache::{Key, Kind};
use crate::session::Timed;
use srp_archdesc::arch::{Arch, Srp};
use srp_archdesc::threads;
use srp_archdesc::watch::{Event, Stage, Watch};
use srp_ir::dfg::Dfg;
use srp_scheduler::{LoopResult, modulo};
use std::cmp::Reverse;

/// Names the sources of the scheduler.
const SCHEDULER: &str = env!("SRP_SCHEDULER_ID");

/// Schedules a loop, or takes its schedule from the cache. The same loop in another program or file, or on
/// another machine with the same SRP, has the same schedule.
pub fn schedule_loop(
    dfg: &Dfg,
    srp: &Srp,
    options: &modulo::Options,
    session: &Session<'_>,
    watch: &dyn Watch,
) -> LoopResult {
    let anonymous = dfg.anonymous();
    let key = Key::of(Kind::Loops)
        .text(SCHEDULER)
        .value(&anonymous)
        .value(srp)
        .value(options)
        .finish();
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

/// Schedules loops of a program.
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
        let result = schedule_loop(dfg, &arch.srp, options, session, watch);
        watch.tell(Event::ItemEnds(&dfg.name));
        stage.done(1);
        result
    };
    let results = threads::each(session.threads, dfgs.len(), || (), one);
    let mut results: Vec<(usize, LoopResult)> = order.iter().copied().zip(results).collect();
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}
