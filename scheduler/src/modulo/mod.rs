//! Modulo scheduling of kernels onto the array: where and when each operation of a loop runs, and
//! over which links and registers its values travel, so that an iteration starts every II cycles.
//!
//! `bounds` says which II cannot be beaten; from there up, `heuristic` makes attempts at a
//! placement until one succeeds, and then down again; `exact` closes the gap or proves that it
//! cannot be closed. `compact` makes the schedule short, and looks for a smaller II from there. On an array much larger than
//! the loop all that happens in a `corner` of it first. The result is data; `check` tells whether it is right.

mod admit;
mod anneal;
mod bounds;
mod compact;
mod corner;
mod exact;
mod finish;
mod heuristic;
mod lattice;
mod level;
mod negotiate;
mod noise;
mod obstacle;
mod order;
mod place;
mod problem;
mod record;
mod registers;
mod route;
mod rows;
mod scale;
mod slots;
mod start;
mod table;
mod worklist;

pub use admit::admit;
pub use bounds::Bounds;
pub use exact::{Fold, Scope, Solver};
pub use obstacle::{Destination, FailedIi, Obstacle, Operation, Unschedulable};
pub use record::{Asked, Outcome, Search, Stopped};

use crate::abi;
use admit::{live_in_registers, storage};
use compact::{Bound, Compacted};
use corner::Known;
use exact::Answer;
use heuristic::Heuristic;
use place::Placement;
use problem::Problem;
use serde::{Deserialize, Serialize};
use srp_archdesc::arch::Srp;
use srp_archdesc::watch::{Event, Watch, Worked};
use srp_ir::dfg::Dfg;
use srp_ir::dre::scheduled::{ModuloSchedule, Reg};
use std::io::Write;
use std::time::Duration;
use worklist::{Limits, Task, Worklist};

/// How hard to try. Everything is counted in steps, so that the same input gives the same schedule
/// however fast the machine is; only a watch that ends the work can change that.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Options {
    /// Steps of the heuristic for every 32 operations of a loop, up to 128, about 3 million a second.
    /// The first II that works is looked for beyond them.
    pub effort: u64,
    /// Steps of the exact search over all IIs of one loop, some 10 thousand a second; 0 leaves it
    /// out. A conflict is some steps, the more the larger the formula, and so is making one.
    pub exact_effort: u64,
    /// Steps for each operation of a loop that go into a shorter schedule at its II, with fewer contexts and moves; with
    /// 0 the schedule stays as it was found.
    pub compaction: u64,
    /// Cycles beyond the critical path in which the exact search may issue operations.
    pub slack: u32,
    /// Where all these steps do not reach the bound: go on by the exact way, with horizons up to
    /// [`FARTHEST`] and by folded formulas, for so much [processor time](Watch::worked) of the watch. Every loop
    /// has all of it.
    pub beyond: Option<Duration>,
    /// Modulo variable expansion (Lam 1988): a kernel is repeated as often as a value that lives longer than
    /// the II needs registers, in files that do not rotate. Without it such values need another way.
    pub expansion: bool,
    /// The SAT solver of the exact way.
    pub solver: Solver,
}

/// Cycles beyond the critical path up to which the exact search goes in the end.
pub const FARTHEST: u32 = 15;

/// Steps for each operation that an attempt at the first II that works has at least: with fewer, IIs are missed
/// at which a schedule is soon found.
const FIRST: u64 = 8_000;
/// Operations of a loop that gets the effort once, and of one that gets the most.
const FEW: u64 = 32;
const MANY: usize = 128;
/// The effort goes once to a loop that could save one cycle in so many, and so many times at most to one that
/// could save more.
const WORTHWHILE: u32 = 8;
const MOST_WORTH: u64 = 6;
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

impl Default for Options {
    fn default() -> Self {
        Options {
            effort: 350_000,
            exact_effort: 8_000,
            compaction: 5_000,
            slack: 3,
            beyond: None,
            expansion: true,
            solver: Solver::default(),
        }
    }
}

/// Largest number of overlapping iterations: what the stage predicates of an engine hold.
pub const MAX_STAGES: u32 = 64;

/// A schedule, and how it stands to its bounds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scheduled {
    /// The schedule.
    pub schedule: ModuloSchedule,
    /// The bounds of the II.
    pub bounds: Bounds,
    /// Fewest cycles of an iteration at this II.
    pub least_length: u32,
    /// Why the II below was not reached; `None` where the II is the bound.
    pub why_not_lower: Option<FailedIi>,
    /// The IIs from the bound on that were proved impossible.
    pub impossible: Vec<Impossible>,
    /// What the exact way tried.
    pub search: Search,
}

/// A proof that there is no schedule with an II, as `docs/proofs.md` defines it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Impossible {
    /// The II.
    pub ii: u32,
    /// The formula that was refuted.
    pub scope: Scope,
    /// True if there is none of any length. Else there is none in which every operation is issued within
    /// [`slack`](Self::slack) cycles of its latest start on the critical path.
    pub outright: bool,
}

impl Impossible {
    /// Cycles beyond the critical path up to which there is no schedule; `None` where there is none at any length.
    pub fn slack(&self) -> Option<u32> {
        match self.scope {
            Scope::Timed { slack } if !self.outright => Some(slack),
            Scope::Timed { .. } | Scope::Folded(_) => None,
        }
    }
}

/// The lower bounds of a loop's II on a machine.
pub fn bounds(dfg: &Dfg, srp: &Srp) -> Bounds {
    Bounds::of(&Problem::new(dfg, srp))
}

/// The fewest cycles of an iteration of any schedule at the II of this one: the longest path with the least transport,
/// and operations that queue for units.
pub fn least_length(schedule: &ModuloSchedule, srp: &Srp) -> u32 {
    Bound::at(
        &Problem::new(&schedule.dfg, srp),
        schedule.ii,
        schedule.length,
    )
    .length
}

/// True if a loop is so large, and the array, or the corner where it is looked for first, so regular, that it is looked
/// for on a lattice, with a patience of its own beyond the effort.
pub fn is_on_lattice(dfg: &Dfg, srp: &Srp) -> bool {
    let problem = Problem::new(dfg, srp);
    match corner::first(&problem, &Bounds::of(&problem)) {
        Some(corner) => heuristic::array(&Problem::new(dfg, &corner.srp)).is_some(),
        None => heuristic::array(&problem).is_some(),
    }
}

/// Schedules a loop. Where the watch ends the search, it gives the best schedule so far.
///
/// # Errors
///
/// The loop cannot run on the array, or the search ended before it had a schedule.
pub fn schedule(
    dfg: &Dfg,
    srp: &Srp,
    options: &Options,
    watch: &dyn Watch,
) -> Result<Scheduled, Unschedulable> {
    let problem = prepared(dfg, srp, options);
    live_in_registers(dfg, srp)?;
    if let Some(node) = problem.nodes().find(|n| problem.units[*n].is_empty()) {
        return Err(Unschedulable::NoUnit(Operation::of(dfg, node)));
    }
    storage(&problem)?;
    let bounds = Bounds::of(&problem);
    match corner::search(&problem, &bounds, options, watch)? {
        Some(known) if known.is_enough => Ok(known.scheduled(&problem, bounds)),
        known => whole(dfg, srp, options, watch, known),
    }
}

fn prepared<'a>(dfg: &'a Dfg, srp: &'a Srp, options: &Options) -> Problem<'a> {
    let mut problem = Problem::new(dfg, srp);
    if !options.expansion {
        problem.most_copies = 1;
    }
    problem
}

/// Schedules a loop on the whole array, with a smaller II than that of a known schedule, or gives that.
fn whole(
    dfg: &Dfg,
    srp: &Srp,
    options: &Options,
    watch: &dyn Watch,
    known: Option<Known>,
) -> Result<Scheduled, Unschedulable> {
    let problem = prepared(dfg, srp, options);
    let live_ins = live_in_registers(dfg, srp)?;
    let bounds = Bounds::of(&problem);
    let bound = bounds.min_ii();
    let deepest = known
        .as_ref()
        .map_or(srp.contexts, |known| known.schedule.ii - 1);
    let fixed: Vec<Reg> = (live_ins.iter().copied())
        .chain(abi::reserved(srp))
        .collect();
    let mut heuristic = Heuristic::new(&problem, &fixed, deepest);
    let mut worklist = Worklist::new(&problem, bound, options);
    let task = Task {
        problem: &problem,
        fixed: &fixed,
    };
    let is_small = problem.dfg.nodes.len() <= LARGEST_EXACT;
    let limits = |effort: u64| Limits { effort, watch };
    let operations = problem.dfg.nodes.len();
    let first = options.effort.max(FIRST * operations as u64);
    let mut schedule = match heuristic.first(bound, first, watch) {
        Ok(schedule) => schedule,
        Err(why) => {
            // The exact way may know of one where there is little room.
            let below = bound.saturating_add(EXACT_RANGE).min(deepest + 1);
            let found = match is_small {
                true => worklist.search(task, below, &mut limits(options.exact_effort)),
                false => None,
            };
            match (found, known) {
                (Some(found), _) => found,
                (None, Some(known)) => return Ok(known.scheduled(&problem, bounds)),
                (None, None) => return Err(why),
            }
        }
    };
    watch.tell(Event::Reaches(schedule.ii));
    let steps = options.effort.saturating_mul(operations.min(MANY) as u64) / FEW;
    heuristic.improve(&mut schedule, bound, steps, watch);
    if is_small {
        let mut limits = limits(worth(options.exact_effort, schedule.ii, bound));
        schedule = worklist
            .search(task, schedule.ii, &mut limits)
            .unwrap_or(schedule);
        watch.tell(Event::Reaches(schedule.ii));
        worklist.fold(task, schedule.ii, &mut limits);
    }
    let compaction = compact::Limits {
        effort: options.compaction.saturating_mul(operations as u64),
        exact: options.exact_effort / EXACT_COMPACTION,
        watch,
    };
    let compact = |schedule| {
        compact::compact(
            &mut prepared(dfg, srp, options),
            &fixed,
            schedule,
            &compaction,
        )
    };
    let mut compacted = None;
    if !is_small && options.compaction > 0 && !heuristic.is_on_lattice() {
        let short = tightened(task, bound, schedule, (steps, watch), compact);
        schedule = short.placement.clone();
        compacted = Some(short);
    }
    let mut in_time = !watch.cancelled();
    if let Some(time) = options.beyond {
        worklist.extend(FARTHEST);
        let watch = &Worked::new(watch, time);
        while schedule.ii > bound && !worklist.is_settled(schedule.ii) && !watch.cancelled() {
            let mut limits = Limits {
                effort: u64::MAX,
                watch,
            };
            if let Some(better) = worklist.search(task, schedule.ii, &mut limits) {
                schedule = better;
            }
            if !worklist.is_settled(schedule.ii) {
                heuristic.improve(&mut schedule, bound, HEURISTIC_TURN, watch);
            }
        }
        in_time = worklist.is_settled(schedule.ii) || !watch.cancelled();
    }
    let impossible = worklist.impossible(schedule.ii);
    let outright = impossible.iter().filter(|proof| proof.outright).count() as u32;
    let stopped = match schedule.ii.saturating_sub(bound) {
        0 => Stopped::AtBound,
        open if open == outright => Stopped::Impossible,
        _ if worklist.is_settled(schedule.ii) && !worklist.leaves_unknown(schedule.ii) => {
            Stopped::NothingLeft
        }
        _ if in_time => Stopped::Steps,
        _ => Stopped::Time,
    };
    let asked = worklist.asked();
    let why_not_lower = heuristic
        .why_not_lower(schedule.ii)
        .filter(|_| schedule.ii > bound);
    let compacted = compacted
        .filter(|short: &Compacted| short.placement.ii == schedule.ii)
        .unwrap_or_else(|| compact(schedule));
    let schedule = finish::finish(&problem, &compacted.placement, &live_ins);
    debug_assert_eq!(schedule.length, compacted.placement.length(&problem));
    Ok(Scheduled {
        impossible,
        search: Search { asked, stopped },
        why_not_lower,
        least_length: compacted.least,
        schedule,
        bounds,
    })
}

/// Makes a schedule short, and looks from there for one at the next smaller II, until there is none.
fn tightened(
    Task { problem, fixed }: Task<'_, '_>,
    bound: u32,
    mut schedule: Placement,
    (effort, watch): (u64, &dyn Watch),
    compact: impl Fn(Placement) -> Compacted,
) -> Compacted {
    let (operations, units) = (problem.dfg.nodes.len(), problem.srp.fus.len());
    let has_room = |ii: u32| operations * 100 <= FULL * units * ii as usize;
    loop {
        let short = compact(schedule);
        let ii = short.placement.ii;
        if ii == bound || !has_room(ii - 1) {
            return short;
        }
        let effort = worth(effort, ii, bound);
        match compact::tighten(problem, fixed, &short.placement, effort, watch) {
            Some(smaller) => schedule = smaller,
            None => return short,
        }
    }
}

/// How much of an effort a better II is worth: it grows with the square of the part of the cycles that the
/// bound would save, since a search for more of them takes longer and brings more.
fn worth(effort: u64, ii: u32, bound: u32) -> u64 {
    let saved = u128::from(WORTHWHILE * (ii - bound));
    let whole = u128::from(ii);
    let worth = u128::from(effort) * saved * saved / (whole * whole);
    u64::try_from(worth).map_or(u64::MAX, |worth| {
        worth.min(effort.saturating_mul(MOST_WORTH))
    })
}

/// Where a certificate of impossibility is written.
pub struct Certificate<'a> {
    /// The formula, as DIMACS CNF.
    pub formula: &'a mut dyn Write,
    /// The proof that it cannot be satisfied, as DRAT (Wetzler, Heule and Hunt 2014).
    pub steps: &'a mut dyn Write,
}

/// Proves again that there is no schedule, and writes the certificate; false where the watch ended
/// that, it could not be written, or it is not so.
pub fn certify(
    dfg: &Dfg,
    srp: &Srp,
    claim: Impossible,
    watch: &dyn Watch,
    certificate: Certificate<'_>,
) -> bool {
    let Ok(live_ins) = live_in_registers(dfg, srp) else {
        return false;
    };
    let fixed: Vec<Reg> = live_ins.into_iter().chain(abi::reserved(srp)).collect();
    let question = exact::Question {
        ii: claim.ii,
        scope: claim.scope,
        within: None,
        conflicts: u64::MAX,
        effort: u64::MAX,
        seed: 0,
        fixed: &fixed,
        named: true,
        solver: Solver::Batsat,
        watch,
    };
    let (answer, _) = exact::solve(&Problem::new(dfg, srp), &question, Some(certificate));
    matches!(answer, Answer::Impossible)
}

/// Asks one question without an end but the watch's, by a solver: what the formula says of an II.
pub fn ask(
    dfg: &Dfg,
    srp: &Srp,
    (ii, scope): (u32, Scope),
    solver: Solver,
    watch: &dyn Watch,
) -> Result<Outcome, Unschedulable> {
    let live_ins = live_in_registers(dfg, srp)?;
    let fixed: Vec<Reg> = live_ins.into_iter().chain(abi::reserved(srp)).collect();
    let question = exact::Question {
        ii,
        scope,
        conflicts: u64::MAX,
        effort: u64::MAX,
        seed: 0,
        within: None,
        fixed: &fixed,
        named: false,
        solver,
        watch,
    };
    let problem = Problem::new(dfg, srp);
    Ok(match exact::solve(&problem, &question, None).0 {
        Answer::Placed(_) => Outcome::Schedule,
        Answer::Impossible => Outcome::Impossible {
            outright: match scope {
                Scope::Folded(_) => true,
                Scope::Timed { slack } => exact::is_complete(&problem, ii, slack),
            },
        },
        Answer::Silent => Outcome::Silent,
        Answer::Unknown => Outcome::Unknown,
        Answer::TooLarge => Outcome::TooLarge,
    })
}
