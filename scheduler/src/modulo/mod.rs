//! Modulo scheduling of kernels onto the array: where and when each operation of a loop runs, and
//! over which links and registers its values travel, so that an iteration starts every II cycles.
//!
//! `bounds` says which II cannot be beaten. A `search` on one array has these acts: from the bound up, `heuristic` makes
//! attempts at a placement until one succeeds, and then down again; `exact` closes the gap or proves that it
//! cannot be closed; `compact` makes the schedule short, and looks for a smaller II from there. On an array much larger than
//! the loop all that happens in a `corner` of it first. The result is data; `check` tells whether it is right.

mod admit;
mod anneal;
mod bounds;
mod compact;
mod corner;
mod effort;
mod exact;
mod finish;
mod heuristic;
mod lattice;
mod level;
mod needs;
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
mod search;
mod seen;
mod slots;
mod start;
mod table;
mod task;
mod ways;
mod worklist;

pub use admit::admit;
pub use bounds::Bounds;
pub use exact::{Fold, Scope, Solver};
pub use obstacle::{Destination, FailedIi, Obstacle, Operation, Unschedulable};
pub use record::{Asked, Outcome, Search, Stopped};
pub use seen::seen_by;

use admit::fixed_registers;
use compact::Bound;
use exact::Answer;
use problem::Problem;
use serde::{Deserialize, Serialize};
use srp_archdesc::arch::Srp;
use srp_archdesc::watch::Watch;
use srp_ir::dfg::Dfg;
use srp_ir::dre::scheduled::{ModuloSchedule, Reg};
use std::io::Write;
use std::time::Duration;
use task::Task;

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
    let srp = &seen_by(dfg, srp);
    let task = Task::new(dfg, srp, options)?;
    match corner::search(&task, options, watch)? {
        None => search::search(&task, srp.contexts, options, watch),
        Some(known) if known.is_enough => Ok(known.scheduled(&task)),
        Some(known) => {
            let better = search::search(&task, known.schedule.ii - 1, options, watch);
            better.or_else(|_| Ok(known.scheduled(&task)))
        }
    }
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
    let srp = &seen_by(dfg, srp);
    let Ok(fixed) = fixed_registers(dfg, srp) else {
        return false;
    };
    let question = exact::Question {
        named: true,
        ..question((claim.ii, claim.scope), &fixed, Solver::Batsat, watch)
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
    let srp = &seen_by(dfg, srp);
    let fixed = fixed_registers(dfg, srp)?;
    let question = question((ii, scope), &fixed, solver, watch);
    let problem = Problem::new(dfg, srp);
    let (answer, _) = exact::solve(&problem, &question, None);
    Ok(Outcome::of(&answer, &problem, ii, scope))
}

/// A question without an end but the watch's.
fn question<'a>(
    (ii, scope): (u32, Scope),
    fixed: &'a [Reg],
    solver: Solver,
    watch: &'a dyn Watch,
) -> exact::Question<'a> {
    exact::Question {
        ii,
        scope,
        within: None,
        conflicts: u64::MAX,
        effort: u64::MAX,
        seed: 0,
        fixed,
        named: false,
        solver,
        watch,
    }
}
