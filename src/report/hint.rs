//! The sentence that helps: what to do for a lower II, from what is known of a loop.

use super::model::{Advice, LoopReport, Lowered, Position, Report, Status, WhatIf};
use srp_scheduler::modulo::{FailedIi, Obstacle};

/// What to do about a loop, of which the II below may have failed.
pub(super) fn of(l: &LoopReport, failed: Option<&FailedIi>) -> String {
    if l.ii == 1 {
        return "an iteration starts every cycle: nothing is to be gained".to_owned();
    }
    match &l.what_if {
        Some(what_if) => tried(l, what_if, failed),
        None => untried(l, failed),
    }
}

/// What trying changes has shown.
fn tried(l: &LoopReport, what_if: &WhatIf, failed: Option<&FailedIi>) -> String {
    match what_if.changes.first() {
        Some(best) => format!("{} would give II = {}", best.what, best.ii),
        None => {
            let tried = what_if.tried;
            format!(
                "none of {tried} changes that were tried would help: {}",
                untried(l, failed)
            )
        }
    }
}

/// What the bounds say.
fn untried(l: &LoopReport, failed: Option<&FailedIi>) -> String {
    let scarce = l.resources.iter().find(|r| r.bound == l.res_mii);
    let by_resources = match scarce {
        Some(r) if r.shared => format!("more of {}, or fewer uses of it", r.resource),
        Some(r) if r.resource == "all operations" => "more units, or fewer operations".to_owned(),
        Some(r) => format!("more units for {}, or fewer such operations", r.resource),
        None => "more units".to_owned(),
    };
    let by_recurrence = match through_memory(l) {
        true => {
            "accesses along the recurrence to arrays that are known to differ (named ones, or `restrict` pointers)"
        }
        false => "fewer or faster operations along the recurrence",
    };
    match l.status {
        Status::Proved => format!(
            "II = {} is proved impossible up to {} cycles beyond the critical path; the bound is {}; \
             --optimal looks further",
            l.ii - 1,
            l.horizon(),
            l.bound()
        ),
        Status::Open => open(l, failed),
        Status::Bound if l.res_mii == l.rec_mii => {
            format!("both {by_resources}, and {by_recurrence}")
        }
        Status::Bound if l.res_mii > l.rec_mii => by_resources,
        Status::Bound => by_recurrence.to_owned(),
    }
}

/// What to do where the II is above its bounds and nothing is proved.
fn open(l: &LoopReport, failed: Option<&FailedIi>) -> String {
    let Some(failed) = failed else {
        let bound = l.bound();
        return format!(
            "the bound is {bound}: a longer search (--optimal), or more links or registers"
        );
    };
    let remedy = match failed.obstacle {
        Obstacle::Registers { .. } => "larger register files, or fewer values that live long",
        Obstacle::NoRoute { .. } => "more links, or registers to wait in",
        Obstacle::NoUnit(_) => "more units for it",
        Obstacle::AttemptsExhausted => "more links or registers",
    };
    format!("{failed}: {remedy}, or a longer search (--optimal)")
}

/// Whether the recurrence passes through accesses that are kept in order for want of knowledge.
fn through_memory(l: &LoopReport) -> bool {
    let ends = |at: &Position| l.ordered.iter().any(|o| o.first == *at || o.second == *at);
    l.recurrence.iter().filter(|step| ends(&step.at)).count() > 1
}

/// What helps several loops or one: each change with the loops whose II it lowers, those first that
/// bring loops onto the array, then those that help most loops.
pub(super) fn advice(report: &Report) -> Vec<Advice> {
    let mut advice: Vec<Advice> = Vec::new();
    let on_array = report
        .loops
        .iter()
        .map(|l| (&l.kernel, Some(l.ii), &l.what_if));
    let refused = report
        .not_pipelined
        .iter()
        .map(|n| (&n.kernel, None, &n.what_if));
    for (kernel, from, what_if) in refused.chain(on_array) {
        let changes = what_if.iter().flat_map(|w| &w.changes);
        for change in changes {
            let lowered = Lowered {
                kernel: kernel.clone(),
                from,
                to: change.ii,
            };
            match advice.iter_mut().find(|a| a.what == change.what) {
                Some(known) => known.lowers.push(lowered),
                None => advice.push(Advice {
                    what: change.what.clone(),
                    lowers: vec![lowered],
                }),
            }
        }
    }
    let cycles = |l: &Lowered| l.from.map_or(0, |from| from - l.to);
    let saved = |a: &Advice| a.lowers.iter().map(cycles).sum::<u32>();
    let new = |a: &Advice| a.lowers.iter().filter(|l| l.from.is_none()).count();
    advice.sort_by_key(|a| std::cmp::Reverse((new(a), a.lowers.len(), saved(a))));
    advice
}
