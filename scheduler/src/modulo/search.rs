//! The search for a schedule on one array, in acts: the heuristic's first II that works, smaller ones by the heuristic
//! and by the exact way, a shorter schedule, from which smaller IIs may follow, and beyond the limits both ways in turns.

use super::compact::{self, Compacted};
use super::effort::{self, worth};
use super::finish;
use super::heuristic::Heuristic;
use super::obstacle::Unschedulable;
use super::place::Placement;
use super::record::{self, Stopped};
use super::task::Task;
use super::worklist::{Limits, Worklist};
use super::{FARTHEST, Options, Scheduled};
use srp_archdesc::watch::{Event, Watch, Worked};

/// Operations of the largest loop that the exact way is tried on within the limits: for larger ones
/// making the formula takes most of the effort, and what is left hardly ever finds or proves anything.
const LARGEST_EXACT: usize = 80;
/// IIs from the bound on that the exact way is asked about where the heuristic has found nothing.
const EXACT_RANGE: u32 = 4;
/// The part of the exact search's steps, one in so many, that goes into a shorter schedule at the II.
const EXACT_COMPACTION: u64 = 2;
/// The part of the slots, in hundredths, beyond which there is no room for a smaller II from a short schedule.
const FULL: usize = 94;
/// Steps of the heuristic between two rounds of the exact way, beyond the limits.
const HEURISTIC_TURN: u64 = 10_000_000;

/// The best schedule that is found, with an II up to `deepest`.
///
/// # Errors
///
/// There is no such schedule, or the search ended before it had one.
pub(super) fn search(
    task: &Task<'_>,
    deepest: u32,
    options: &Options,
    watch: &dyn Watch,
) -> Result<Scheduled, Unschedulable> {
    let mut search = Search::new(task, deepest, options, watch);
    let mut best = search.first()?;
    search.improve(&mut best);
    search.exact(&mut best);
    let short = search.tighten(&mut best);
    let in_time = search.beyond(&mut best);
    Ok(search.finish(best, short, in_time))
}

struct Search<'a, 'p> {
    task: &'a Task<'p>,
    /// The least II that there may be, and the largest that is of use.
    bound: u32,
    deepest: u32,
    options: &'a Options,
    watch: &'a dyn Watch,
    heuristic: Heuristic<'a, 'p>,
    worklist: Worklist<'a, 'p>,
}

impl<'a, 'p> Search<'a, 'p> {
    fn new(
        task: &'a Task<'p>,
        deepest: u32,
        options: &'a Options,
        watch: &'a dyn Watch,
    ) -> Search<'a, 'p> {
        Search {
            task,
            bound: task.bounds.min_ii(),
            deepest,
            options,
            watch,
            heuristic: Heuristic::new(&task.problem, &task.fixed, deepest),
            worklist: Worklist::new(task, options),
        }
    }

    /// A schedule with the first II that works.
    fn first(&mut self) -> Result<Placement, Unschedulable> {
        let effort = effort::of_first(self.options.effort, self.operations());
        let found = self.heuristic.first(self.bound, effort, self.watch);
        let found = found.or_else(|why| self.first_exact().ok_or(why))?;
        self.watch.tell(Event::Reaches(found.ii));
        Ok(found)
    }

    /// A schedule near the bound by the exact way, which may know of one where there is little room.
    fn first_exact(&mut self) -> Option<Placement> {
        if !self.is_small() {
            return None;
        }
        let below = self.bound.saturating_add(EXACT_RANGE);
        let mut limits = self.limits(self.options.exact_effort);
        self.worklist
            .search(below.min(self.deepest + 1), &mut limits)
    }

    /// Lowers the II by the heuristic.
    fn improve(&mut self, best: &mut Placement) {
        let steps = self.steps();
        self.heuristic.improve(best, self.bound, steps, self.watch);
    }

    /// Lowers the II of a small loop by the exact way, and asks folded formulas about those that are left.
    fn exact(&mut self, best: &mut Placement) {
        if !self.is_small() {
            return;
        }
        let effort = worth(self.options.exact_effort, best.ii, self.bound);
        let mut limits = self.limits(effort);
        if let Some(better) = self.worklist.search(best.ii, &mut limits) {
            *best = better;
        }
        self.watch.tell(Event::Reaches(best.ii));
        self.worklist.fold(best.ii, &mut limits);
    }

    /// Makes the schedule of a large loop short, and looks from there for one at the next smaller II, until there is none.
    fn tighten(&self, best: &mut Placement) -> Option<Compacted> {
        if self.is_small() || self.options.compaction == 0 || self.heuristic.is_on_lattice() {
            return None;
        }
        let mut short = self.compact(best.clone());
        while let Some(smaller) = self.tightened(&short.placement) {
            short = self.compact(smaller);
        }
        *best = short.placement.clone();
        Some(short)
    }

    /// A schedule at the next smaller II from a short one.
    fn tightened(&self, short: &Placement) -> Option<Placement> {
        let slots = |ii: u32| self.task.problem.srp.fus.len() * ii as usize;
        let has_room = |ii: u32| self.operations() * 100 <= FULL * slots(ii);
        if short.ii == self.bound || !has_room(short.ii - 1) {
            return None;
        }
        let Task { problem, fixed, .. } = self.task;
        let effort = worth(self.steps(), short.ii, self.bound);
        compact::tighten(problem, fixed, short, effort, self.watch)
    }

    /// Lowers the II beyond the limits, by both ways in turns; false where that has ended for the watch, or the time is up.
    fn beyond(&mut self, best: &mut Placement) -> bool {
        let Some(time) = self.options.beyond else {
            return !self.watch.cancelled();
        };
        self.worklist.extend(FARTHEST);
        let watch = &Worked::new(self.watch, time);
        while best.ii > self.bound && !self.worklist.is_settled(best.ii) && !watch.cancelled() {
            let mut limits = Limits {
                effort: u64::MAX,
                watch,
            };
            if let Some(better) = self.worklist.search(best.ii, &mut limits) {
                *best = better;
            }
            if !self.worklist.is_settled(best.ii) {
                self.heuristic
                    .improve(best, self.bound, HEURISTIC_TURN, watch);
            }
        }
        self.worklist.is_settled(best.ii) || !watch.cancelled()
    }

    /// The result of a search whose best schedule may have been made short before.
    fn finish(self, best: Placement, short: Option<Compacted>, in_time: bool) -> Scheduled {
        let ii = best.ii;
        let short = short.filter(|short| short.placement.ii == ii);
        let short = short.unwrap_or_else(|| self.compact(best));
        let Task { problem, fixed, .. } = self.task;
        let schedule = finish::finish(problem, &short.placement, fixed);
        debug_assert_eq!(schedule.length, short.placement.length(problem));
        let why_not_lower = self.heuristic.why_not_lower(ii);
        Scheduled {
            schedule,
            bounds: self.task.bounds.clone(),
            least_length: short.least,
            why_not_lower: why_not_lower.filter(|_| ii > self.bound),
            impossible: self.worklist.impossible(ii),
            search: record::Search {
                asked: self.worklist.asked(),
                stopped: self.stopped(ii, in_time),
            },
        }
    }

    /// The reason why the search ended at an II.
    fn stopped(&self, ii: u32, in_time: bool) -> Stopped {
        let impossible = self.worklist.impossible(ii);
        let outright = impossible.iter().filter(|proof| proof.outright).count() as u32;
        let nothing_left = self.worklist.is_settled(ii) && !self.worklist.leaves_unknown(ii);
        match ii.saturating_sub(self.bound) {
            0 => Stopped::AtBound,
            open if open == outright => Stopped::Impossible,
            _ if nothing_left => Stopped::NothingLeft,
            _ if in_time => Stopped::Steps,
            _ => Stopped::Time,
        }
    }

    /// The schedule made short at its II.
    fn compact(&self, placement: Placement) -> Compacted {
        let limits = compact::Limits {
            effort: (self.options.compaction).saturating_mul(self.operations() as u64),
            exact: self.options.exact_effort / EXACT_COMPACTION,
            watch: self.watch,
        };
        let Task { problem, fixed, .. } = self.task;
        compact::compact(problem, fixed, placement, &limits)
    }

    /// Operations of the loop.
    fn operations(&self) -> usize {
        self.task.problem.dfg.nodes.len()
    }

    /// True if the exact way is tried within the limits.
    fn is_small(&self) -> bool {
        self.operations() <= LARGEST_EXACT
    }

    /// Steps of the heuristic that go into a smaller II.
    fn steps(&self) -> u64 {
        effort::of_improvement(self.options.effort, self.operations())
    }

    /// So much effort of the exact way, within the watch.
    fn limits(&self, effort: u64) -> Limits<'a> {
        Limits {
            effort,
            watch: self.watch,
        }
    }
}
