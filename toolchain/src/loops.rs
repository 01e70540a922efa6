//! Schedules of loops that are kept from one program to the next.

use crate::Session;
use crate::session::Timed;
use srp_archdesc::arch::{Arch, Srp};
use srp_archdesc::entity::Entity;
use srp_archdesc::threads;
use srp_archdesc::watch::{Event, Stage, Watch};
use srp_ir::dfg::Dfg;
use srp_ir::dre::Dre;
use srp_ir::program::Kernel;
use srp_scheduler::{LoopResult, modulo};
use std::sync::{Mutex, PoisonError};

/// Loops and what came of scheduling them.
#[derive(Default)]
pub(crate) struct Loops(Mutex<Vec<Known>>);

/// A loop that was scheduled: everything that the result depends on, and the result.
struct Known {
    dfg: Dfg,
    srp: Srp,
    options: modulo::Options,
    result: LoopResult,
}

impl Loops {
    fn get(&self, dfg: &Dfg, srp: &Srp, options: &modulo::Options) -> Option<LoopResult> {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let same = |k: &&Known| k.dfg == *dfg && k.options == *options && k.srp == *srp;
        known.iter().find(same).map(|k| k.result.clone())
    }

    fn add(&self, dfg: &Dfg, srp: &Srp, options: &modulo::Options, result: &LoopResult) {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.push(Known {
            dfg: dfg.clone(),
            srp: srp.clone(),
            options: *options,
            result: result.clone(),
        });
    }
}

/// Schedules all loops of a program, those apart that are known.
pub(crate) fn schedule_all(
    dre: &Dre,
    arch: &Arch,
    options: &modulo::Options,
    session: &Session<'_>,
    watch: &Timed<'_>,
) -> Vec<LoopResult> {
    let srp = &arch.srp;
    let stage = Stage::of(watch, "scheduling", dre.kernels.len() as u64);
    let one = |(): &mut (), index| {
        let dfg = &dre.kernels[Kernel::new(index)];
        watch.tell(Event::ItemBegins(&dfg.name));
        let result = session.loops.get(dfg, srp, options).unwrap_or_else(|| {
            let result = modulo::schedule(dfg, srp, options, watch);
            // What was cut short depends on when.
            if !watch.cancelled() {
                session.loops.add(dfg, srp, options, &result);
            }
            result
        });
        watch.tell(Event::ItemEnds(&dfg.name));
        stage.done(1);
        result
    };
    threads::each(session.threads, dre.kernels.len(), || (), one)
}
