//! Hints: advice for a lower II, from the facts of a loop.

use super::changes::WhatIf;
use super::model::{LoopReport, Ordered, Position, Status};
use super::resource::resource_name;
use crate::{proofs, settings};
use srp_archdesc::arch::Srp;
use srp_archdesc::isa::Class;
use srp_scheduler::LoopFacts;
use srp_scheduler::demand::{Demand, Need};
use srp_scheduler::modulo::Obstacle;

/// The changes that advice may be about.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Scope {
    Loop,
    LoopOrMachine,
}

/// Returns the advice for a loop.
pub(super) fn of(l: &LoopReport, facts: &LoopFacts, srp: &Srp) -> String {
    if l.ii == 1 {
        return "an iteration starts every cycle: only more work in each is faster (#pragma srp unroll)".to_owned();
    }
    if 2 * l.software > l.operations {
        let classes: Vec<String> = (srp.in_software().iter())
            .map(|class| format!("`{class}`"))
            .collect();
        return format!(
            "units for what it computes in software; the machine has none of {}",
            classes.join(", ")
        );
    }
    if let Some(ii) = l.restrict_ii {
        return format!(
            "II = {ii} if what its pointers point to does not overlap: `restrict` on them, or report it with \
             its caller (for kernels of a frame: `srp report --frame`)"
        );
    }
    match &l.what_if {
        Some(what_if) => tried(l, what_if, facts, srp),
        None => untried(l, facts, srp, Scope::LoopOrMachine),
    }
}

/// Returns advice from the changes that were tried.
fn tried(l: &LoopReport, what_if: &WhatIf, facts: &LoopFacts, srp: &Srp) -> String {
    match what_if.changes.first() {
        Some(best) => format!(
            "{} would give {}{}{}",
            best.what,
            best.result(),
            settings::in_brackets(&best.set),
            match l.status {
                Status::Open if best.ii >= l.bound() => {
                    "; a longer search (--optimal) may find that on this machine too"
                }
                _ => "",
            }
        ),
        None => {
            let tried = what_if.tried;
            format!(
                "none of {tried} changes that were tried would help: {}",
                untried(l, facts, srp, Scope::Loop)
            )
        }
    }
}

/// Returns advice from the bounds alone.
fn untried(l: &LoopReport, facts: &LoopFacts, srp: &Srp, scope: Scope) -> String {
    let by_resources = by_resources(facts, srp, scope);
    let by_recurrence = match through_memory(l) {
        Some(ThroughMemory::OneObject) => {
            "iterations that may meet in an element of one array wait for each other: `#pragma srp independent` if they \
             never meet; counts that meet can go to several arrays with names of their own, added up behind the loop"
        }
        Some(ThroughMemory::Objects) => {
            "accesses along the recurrence to arrays that are known to differ (named ones, or `restrict` pointers)"
        }
        None => "fewer or faster operations along the recurrence",
    };
    match l.status {
        Status::Least => format!(
            "every II from the bound of {} on is proved impossible on this machine{}",
            l.bound(),
            match scope {
                Scope::LoopOrMachine => ": more links, registers or units",
                Scope::Loop => "",
            }
        ),
        Status::Proved => format!(
            "II = {} is proved {}; the bound is {}; --optimal looks further",
            l.ii - 1,
            proofs::reach(l.horizon()),
            l.bound()
        ),
        Status::Open if scope == Scope::Loop => {
            "a longer search (--optimal), or fewer operations".to_owned()
        }
        Status::Open => open(l, facts.why_not_lower.as_ref().map(|f| &f.obstacle)),
        Status::Bound if l.res_mii == l.rec_mii => {
            format!("both {by_resources}, and {by_recurrence}")
        }
        Status::Bound if l.res_mii > l.rec_mii => by_resources,
        Status::Bound => by_recurrence.to_owned(),
    }
}

/// Returns what lowers the bound of units and resources: of each that sets it, for one alone changes nothing.
fn by_resources(facts: &LoopFacts, srp: &Srp, scope: Scope) -> String {
    let bounds = &facts.bounds;
    let binding: Vec<&Demand> = (bounds.demands.iter())
        .filter(|d| d.bound == bounds.resources)
        .collect();
    // What is asked of some classes is asked of more with these among them, or of all where every unit may run them.
    let covers = |other: &Demand, d: &Demand| match &d.need {
        Need::Units(classes) => {
            let is_all = other.need == Need::Array && other.offered == d.offered;
            is_all || other.need != d.need && other.is_of(classes)
        }
        Need::Array | Need::Shared(_) => false,
    };
    let own = binding
        .iter()
        .filter(|d| !binding.iter().any(|other| covers(other, d)));
    let of = |need: &Need| {
        let name = resource_name(need, srp);
        match need {
            Need::Array => (
                "more units".to_owned(),
                "operations",
                "operations".to_owned(),
            ),
            Need::Shared(_) => (
                format!("more of {name}"),
                "uses of it",
                format!("uses of {name}"),
            ),
            Need::Units(_) => {
                let more = format!("more units for {name}");
                (more, "such operations", format!("operations of {name}"))
            }
        }
    };
    let keeps = |need: &Need| match need {
        // More units are of no use to an operation that keeps its own.
        Need::Units(of) => keeps_its_unit(of, bounds.resources, srp),
        _ => false,
    };
    let needs: Vec<&Need> = own.map(|d| &d.need).collect();
    match needs[..] {
        [need] if keeps(need) => {
            let classes = resource_name(need, srp);
            format!("a shorter interval of {classes}, or none of these operations")
        }
        [] | [_] => {
            let need = needs.first().copied().unwrap_or(&Need::Array);
            let (more, of_it, fewer) = of(need);
            match scope {
                Scope::LoopOrMachine => format!("{more}, or fewer {of_it}"),
                Scope::Loop => format!("fewer {fewer}"),
            }
        }
        _ => {
            let each = needs.iter().map(|need| match (scope, of(need)) {
                _ if keeps(need) => format!("a shorter interval of {}", resource_name(need, srp)),
                (Scope::LoopOrMachine, (more, ..)) => more,
                (Scope::Loop, (.., fewer)) => format!("fewer {fewer}"),
            });
            let each: Vec<String> = each.collect();
            format!("{}: each alone sets the bound", each.join(" and "))
        }
    }
}

/// True if an operation of some classes keeps its unit for all of an II, whichever runs it.
fn keeps_its_unit(classes: &[Class], ii: u32, srp: &Srp) -> bool {
    let interval = |class: Class| {
        let ops = srp.fus.values().filter_map(|fu| fu.op(class));
        ops.map(|op| op.interval).min()
    };
    ii > 1 && classes.iter().any(|&class| interval(class) == Some(ii))
}

/// Returns advice for a loop whose II is above its bounds with nothing proved.
fn open(l: &LoopReport, failed: Option<&Obstacle>) -> String {
    let (Some(failed), Some(told)) = (failed, &l.why_not_lower) else {
        let bound = l.bound();
        return format!(
            "the bound is {bound}: a longer search (--optimal), or more links or registers"
        );
    };
    let remedy = match failed {
        Obstacle::Registers { .. } => "larger register files, or fewer values that live long",
        Obstacle::Copies { .. } => {
            "more contexts, a file that rotates, or links without delay, so that values are there sooner"
        }
        Obstacle::NoRoute { .. } => "more links, or registers to wait in",
        Obstacle::ReadPorts { .. } => "more read ports, or `constants` in contexts",
        Obstacle::NoUnit(_) => "more units for it",
        Obstacle::NoOutput(_) => "more units for it, or operations of one latency on each",
        Obstacle::NoReach(_) => "more links, or registers to wait in",
        Obstacle::AttemptsExhausted | Obstacle::CutShort => "more links or registers",
    };
    format!("{}: {remedy}, or a longer search (--optimal)", told.text)
}

/// Accesses that are kept in order for want of knowledge, and that a recurrence passes through.
enum ThroughMemory {
    /// To one object.
    OneObject,
    /// To what may be one object.
    Objects,
}

/// Returns the accesses that the recurrence passes through.
fn through_memory(l: &LoopReport) -> Option<ThroughMemory> {
    let ends = |o: &Ordered, at: &Position| o.first == *at || o.second == *at;
    let steps = |o: &Ordered| l.recurrence.iter().filter(|step| ends(o, &step.at)).count();
    let any = |step: &Position| l.ordered.iter().any(|o| ends(o, step));
    let passed = l.recurrence.iter().filter(|step| any(&step.at)).count();
    let in_one = l.ordered.iter().any(|o| o.in_one_object && steps(o) > 1);
    match (passed > 1, in_one) {
        (true, true) => Some(ThroughMemory::OneObject),
        (true, false) => Some(ThroughMemory::Objects),
        (false, _) => None,
    }
}
