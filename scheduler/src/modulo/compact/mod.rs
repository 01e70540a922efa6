//! The second objective: a schedule is as short as it can be made at its II, then takes few contexts, moves and
//! registers ([`Value`]).
//!
//! [`compact`] takes a placement to one that is worth no less. A [lower bound](bound) says where it can stop, and
//! between which cycles each node lies in a schedule of some length. A step sets a shorter length and places anew
//! what lies outside, by one of the two ways of the first search: by *squeezing*
//! ([`Attempt::squeeze`]), which is quick where there is room, and by *negotiation* ([`Negotiation::from`]), which
//! exchanges slots where there is none. Both leave all other nodes where they are, unless these are in the way. A
//! step that succeeds doubles the next one; two that fail halve it. They hold on to the first cycle and to the last
//! in turns.
//!
//! A schedule that was found without regard to its length can be far from the bound, and such that small steps lead
//! nowhere. So it is *melted* first: hot negotiations, in which most of it may move, halve what lies between the
//! schedule and the length that they have failed at. They begin with the whole schedule [pressed together](times).
//! In small loops the exact way decides in the end.

mod bound;
mod queue;
mod tighten;
mod times;
mod value;

use super::exact::{self, Answer, Scope, Solver};
use super::negotiate::{Lanes, Negotiation};
use super::place::{Attempt, Placement};
use super::problem::Problem;
use super::route::Router;
pub(super) use bound::Bound;
use srp_archdesc::Watch;
use srp_ir::dfg::Node;
use srp_ir::dre::scheduled::Reg;
pub(super) use tighten::tighten;
use value::Value;

/// Steps of one squeeze for each node.
const SQUEEZE: u64 = 20;
/// Negotiations by which most of a schedule may move; by which it is changed in parts; and where its length stays.
const HOT: Heat = Heat {
    presses: true,
    stage: 10,
    steps: 200,
    most: 6000,
};
const WARM: Heat = Heat {
    presses: false,
    stage: 14,
    steps: 12,
    most: 200,
};
const COOL: Heat = Heat { stage: 24, ..WARM };
/// Times that a schedule is melted; the part of a launch, one in so many, that it is melted for again; and that part
/// between it and what it failed at, and the fewest cycles, from which on it is.
const MELTINGS: u32 = 2;
const AGAIN: u64 = 50;
const LEAST_MELTED: u64 = 200;
const FEWEST_MELTED: u32 = 4;
/// Failures after which that ends: the lengths that are left then are soon reached in parts.
const MOST_FAILED: u32 = 2;
/// The effort of a change, and the fewest changes for each node.
const CHANGE: u64 = 30;
const LEAST_STEPS: u64 = 12;
/// Nodes times units beyond which a try takes minutes.
const LARGEST: usize = 1 << 20;
/// Steps for each try beside its search.
const TRY: u64 = 100;
/// Steps of one cycle in vain, one way, after which the next way has its turn, or all is over.
const PATIENCE: u32 = 2;
const MOST_PATIENCE: u32 = 100;
/// Tries in vain after which a schedule of a length counts as simple.
const MOST_IN_VAIN: u32 = 4;
/// Iterations of a launch that lengths are held against: packets have as many rays.
const LAUNCH: u64 = 64;
/// The part of a launch's cycles, one in so many, that is worth all of the effort.
const WORTHWHILE: u64 = 25;
const LEAST_WORTH: u64 = 8;
/// The part of the effort that is kept for the length as it is, one in so many.
const KEPT: u64 = 4;
/// Nodes of the largest loop that the exact way is asked about, and its conflicts for a length.
const LARGEST_EXACT: usize = 24;
const CONFLICTS: u64 = 2000;

/// How hard to try.
pub(super) struct Limits<'a> {
    /// Steps, as the router counts them.
    pub(super) effort: u64,
    /// Steps of the exact way.
    pub(super) exact: u64,
    pub(super) watch: &'a dyn Watch,
}

/// A placement, and the fewest cycles that an iteration can take at its II.
pub(super) struct Compacted {
    pub(super) placement: Placement,
    pub(super) least: u32,
}

/// A placement at the same II that is worth no less.
pub(super) fn compact(
    problem: &Problem<'_>,
    fixed: &[Reg],
    placement: Placement,
    limits: &Limits<'_>,
) -> Compacted {
    let value = Value::of(problem, &placement);
    let mut compaction = Compaction {
        bound: Bound::at(problem, placement.ii, value.length),
        problem: problem.clone(),
        fixed,
        limits,
        best: placement,
        value,
        router: Router::default(),
        tries: 0,
    };
    compaction.run();
    Compacted {
        placement: compaction.best,
        least: compaction.bound.length,
    }
}

struct Compaction<'a, 'p> {
    /// A copy, whose `most_copies` the last steps lower.
    problem: Problem<'p>,
    fixed: &'a [Reg],
    limits: &'a Limits<'a>,
    bound: Bound,
    best: Placement,
    value: Value,
    router: Router,
    tries: u32,
}

/// A way to a shorter schedule.
#[derive(Clone, Copy)]
enum Way<'l> {
    Squeeze,
    Negotiate(&'l Lanes, Heat),
}

/// How a negotiation goes about it.
#[derive(Clone, Copy)]
struct Heat {
    /// True if it starts from the whole schedule pressed together; else only what lies outside has moved.
    presses: bool,
    /// The stage that it starts from.
    stage: u32,
    /// Changes for each node, over all stages.
    steps: u64,
    /// Steps of the search for each node, at most.
    most: u64,
}

impl Compaction<'_, '_> {
    fn run(&mut self) {
        let size = self.problem.dfg.nodes.len() * self.problem.srp.fus.len();
        if self.limits.effort == 0 || size > LARGEST {
            return;
        }
        let lanes = Lanes::of(&self.problem);
        self.melt(&lanes);
        self.shorten(Way::Squeeze, PATIENCE);
        self.shorten(Way::Negotiate(&lanes, WARM), MOST_PATIENCE);
        self.decide();
        self.simplify(&lanes);
    }

    /// Cycles beyond the bound.
    fn gap(&self) -> u32 {
        self.value.length - self.bound.length
    }

    fn is_over(&self, effort: u64) -> bool {
        self.router.expanded >= effort || self.limits.watch.cancelled()
    }

    /// Cycles of a launch.
    fn launch(&self) -> u64 {
        (LAUNCH - 1) * u64::from(self.best.ii) + u64::from(self.value.length)
    }

    /// How much of the effort the rest of the length is worth: all where a launch would save a good part.
    fn worth(&self) -> u64 {
        let effort = self.limits.effort - self.limits.effort / KEPT;
        let launch = self.launch();
        let part = u64::from(self.gap()) * WORTHWHILE;
        let part = part.clamp(launch / LEAST_WORTH, launch);
        (u128::from(effort) * u128::from(part) / u128::from(launch)) as u64
    }

    /// Halves the cycles between the schedule and a length that it failed at, until there are few, and again from other
    /// seeds. Each try has an effort of its own.
    fn melt(&mut self, lanes: &Lanes) {
        for round in 0..MELTINGS {
            let part = |one_in: u64| (self.launch() / one_in) as u32;
            if round > 0 && self.gap() < part(AGAIN) {
                return;
            }
            let least = part(LEAST_MELTED).max(FEWEST_MELTED);
            let (mut failed, mut failures) = (0, 0);
            while self.gap() >= failed + least
                && failures < MOST_FAILED
                && !self.limits.watch.cancelled()
            {
                let beyond = (failed + self.gap()) / 2;
                let target = self.bound.length + beyond;
                if !self.attempt(Way::Negotiate(lanes, HOT), target, self.worth()) {
                    failed = beyond;
                    failures += 1;
                }
                self.router.expanded = 0;
            }
        }
    }

    /// Shortens the schedule by one way, until so many steps to the next cycle were in vain.
    fn shorten(&mut self, way: Way<'_>, patience: u32) {
        let (mut step, mut failures) = (1, 0);
        while self.gap() > 0 && failures < patience && !self.is_over(self.worth()) {
            step = step.min(self.gap());
            let target = self.value.length - step;
            if self.attempt(way, target, self.worth()) {
                (step, failures) = (2 * step, 0);
                continue;
            }
            failures += 1;
            if step > 1 && failures % 2 == 0 {
                (step, failures) = (step / 2, 0);
            }
        }
    }

    /// Tries one way to a length; true if that found something better.
    fn attempt(&mut self, way: Way<'_>, length: u32, effort: u64) -> bool {
        let at_end = self.tries % 2 == 1;
        let seed = self.tries / 2;
        self.tries += 1;
        let Compaction {
            problem,
            best,
            router,
            limits,
            fixed,
            ..
        } = self;
        let start = match at_end {
            false => best.start(),
            true => best.start() + (self.value.length - length) as i32,
        };
        let deadline = start + length as i32;
        let freedom = self.bound.freedom(start, deadline);
        router.expanded += TRY;
        if freedom.is_empty() {
            return false;
        }
        let left = effort.saturating_sub(router.expanded);
        let nodes = problem.dfg.nodes.len() as u64;
        let watch = limits.watch;
        let found = match way {
            Way::Squeeze => {
                let mut order: Vec<Node> = problem.nodes().collect();
                order.sort_by_key(|&n| (freedom.latest[n], problem.units[n].len(), n));
                let limit = router.expanded + left.min(SQUEEZE * nodes);
                let mut attempt = Attempt::new(problem, best.ii, seed, &freedom, fixed, router);
                attempt.squeeze(best, &order, deadline, limit, watch)
            }
            Way::Negotiate(lanes, heat) => {
                let times = match heat.presses {
                    true => {
                        let end = best.start() + self.value.length as i32;
                        let was = self.bound.freedom(best.start(), end);
                        times::press(problem, best, &was, &freedom)
                    }
                    false => times::cut(best, &freedom),
                };
                let (from, by) = ((&*best, &times), (&freedom, deadline));
                let mut run =
                    Negotiation::from(problem, lanes, from, by, fixed, best.ii, self.tries);
                let limit = left.min(heat.most * nodes);
                // A run that is cut off before it is cold was in vain.
                let steps = heat.steps.min((limit / nodes / CHANGE).max(LEAST_STEPS));
                let found = run.shorten(heat.stage, steps, limit, watch);
                router.expanded += run.effort();
                found
            }
        };
        found.is_ok_and(|placement| self.take(placement))
    }

    /// Takes a placement if it is worth more.
    fn take(&mut self, placement: Placement) -> bool {
        let value = Value::of(&self.problem, &placement);
        let is_better = value < self.value;
        if is_better {
            (self.best, self.value) = (placement, value);
        }
        is_better
    }

    /// Asks the exact way for the next shorter schedule of a small loop, and so on, until there is none.
    fn decide(&mut self) {
        if self.problem.dfg.nodes.len() > LARGEST_EXACT {
            return;
        }
        let mut left = self.limits.exact;
        while self.gap() > 0 && left > 0 && !self.limits.watch.cancelled() {
            let length = self.value.length - 1;
            let question = exact::Question {
                ii: self.best.ii,
                scope: Scope::Timed { slack: 0 },
                within: Some((self.bound.freedom(0, length as i32), length as i32)),
                conflicts: CONFLICTS,
                effort: left,
                seed: 0,
                named: false,
                solver: Solver::Batsat,
                fixed: self.fixed,
                watch: self.limits.watch,
            };
            let (answer, spent) = exact::solve(&self.problem, &question, None);
            left = left.saturating_sub(spent.max(1));
            match answer {
                Answer::Impossible => self.bound.length = self.value.length,
                Answer::Placed(placement) => {
                    if !self.take(*placement) {
                        return;
                    }
                }
                Answer::Silent | Answer::Unknown | Answer::TooLarge => return,
            }
        }
    }

    /// Looks for fewer contexts, then for fewer moves and registers, at the same length.
    fn simplify(&mut self, lanes: &Lanes) {
        self.repeat(lanes, |value| {
            (value.copies > 1).then_some(value.copies / 2)
        });
        self.repeat(lanes, |value| Some(value.copies));
    }

    /// Negotiates at the same length, with at most so many copies, until it has been in vain too often.
    fn repeat(&mut self, lanes: &Lanes, most_copies: impl Fn(&Value) -> Option<u32>) {
        let mut in_vain = 0;
        while in_vain < MOST_IN_VAIN
            && !self.is_over(self.limits.effort)
            && let Some(most) = most_copies(&self.value)
        {
            self.problem.most_copies = most;
            let way = Way::Negotiate(lanes, COOL);
            match self.attempt(way, self.value.length, self.limits.effort) {
                true => in_vain = 0,
                false => in_vain += 1,
            }
        }
    }
}
