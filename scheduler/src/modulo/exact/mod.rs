//! The exact way: a formula says that a schedule with a given II exists, and a SAT solver decides it. There are
//! two formulas: the *timed* one has the cycles of a schedule up to a horizon, the [*folded*](fold) one has them
//! modulo some laps of the II.
//!
//! *The timed formula.*
//! A variable stands for each thing that a placement may take: a node's unit and cycle, a value in
//! an output or in a register file, a move, a write. Whatever a value has must come from somewhere,
//! so that every model of the formula holds a route for every edge ([`encode`]); a model is read
//! back into routes ([`decode`]), which then take their registers as those of the heuristic do.
//!
//! Everything that the formula demands is necessary, but register files are asked only not to hold
//! more values in a cycle than they have registers. So *unsatisfiable* is a proof that no schedule
//! exists with this II in which no operation is issued later than `slack` cycles after its latest
//! start in the shortest schedule with unlimited units; a model whose values find no registers
//! proves nothing, and the formula is tightened. Beyond some [horizon] nothing new appears.
//!
//! *The folded formula* is satisfied by every schedule, however long, but a model of it is no schedule: it only
//! proves.

mod budget;
#[cfg(feature = "cadical")]
mod cadical;
mod decode;
mod encode;
mod fold;
mod formula;
mod horizon;
mod names;
mod solver;

pub use fold::Fold;
pub(super) use fold::applies as fold_applies;
pub(super) use horizon::is_complete;

use super::Certificate;
use super::order::Freedom;
use super::place::Placement;
use super::problem::Problem;
use serde::{Deserialize, Serialize};
use solver::Outcome;
use srp_archdesc::Watch;
use srp_archdesc::entity::EntityMap;
use srp_ir::dre::scheduled::Reg;

/// The formula that says that a schedule exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Scope {
    /// Of schedules in which every operation is issued within some cycles of its latest start on the critical
    /// path.
    Timed {
        /// These cycles.
        slack: u32,
    },
    /// Of schedules of any length, by a clock.
    Folded(Fold),
}

/// A SAT solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Solver {
    /// Plain Rust, and it writes proofs.
    #[default]
    Batsat,
    /// CaDiCaL: for finding and proving; certificates are batsat's all the same.
    #[cfg(feature = "cadical")]
    Cadical,
}

/// A question to the solver.
pub(super) struct Question<'a> {
    pub(super) ii: u32,
    pub(super) scope: Scope,
    /// The cycles in which each node may be issued and the one by which all has landed, if not the horizon.
    pub(super) within: Option<(Freedom, i32)>,
    /// Conflicts after which the solver gives up.
    pub(super) conflicts: u64,
    /// Steps after which it gives up.
    pub(super) effort: u64,
    /// Tells tries of one question apart: the order in which the solver looks at variables.
    pub(super) seed: u32,
    /// Registers that hold something else.
    pub(super) fixed: &'a [Reg],
    /// Variables have names.
    pub(super) named: bool,
    pub(super) solver: Solver,
    /// Asked now and then; true gives up.
    pub(super) watch: &'a dyn Watch,
}

impl Question<'_> {
    /// True if something may land in a cycle.
    fn may_land(&self, time: i32) -> bool {
        let within = self.within.as_ref();
        within.is_none_or(|&(_, deadline)| time <= deadline)
    }

    /// Variables of the largest formula that may be made: no more than fit, nor than the effort allows.
    fn largest_formula(&self) -> usize {
        let affordable = self.effort.saturating_mul(VARIABLES_A_STEP);
        usize::try_from(affordable).map_or(LARGEST_FORMULA, |most| most.min(LARGEST_FORMULA))
    }
}

/// The answer to a question.
pub(super) enum Answer {
    /// A placement.
    Placed(Box<Placement>),
    /// There is none in the scope.
    Impossible,
    /// The folded formula has a model, or is not of this machine.
    Silent,
    /// The solver gave up.
    Unknown,
    /// The formula would be too large.
    TooLarge,
}

/// Variables of the largest formula that is tried: about half a gigabyte of memory.
const LARGEST_FORMULA: usize = 500_000;
/// Steps that a conflict takes in a small formula, and variables for which it takes one more.
const CONFLICT: u64 = 3;
const VARIABLES_A_CONFLICT_STEP: u64 = 40_000;
/// Variables that are made in a step.
const VARIABLES_A_STEP: u64 = 50;
/// Times that a formula is tightened because a model's values found no registers.
const TIGHTENINGS: u32 = 6;

/// Answers a question, with the steps that it took. The formula and, line by line, the proof go
/// to `proof`.
pub(super) fn solve(
    problem: &Problem<'_>,
    question: &Question<'_>,
    proof: Option<Certificate<'_>>,
) -> (Answer, u64) {
    match question.scope {
        Scope::Timed { slack } => timed(problem, question, slack, proof),
        Scope::Folded(fold) => folded(problem, question, fold, proof),
    }
}

/// The answer where a formula is larger than what the effort allows, or than what fits.
fn too_large(question: &Question<'_>) -> (Answer, u64) {
    let largest = question.largest_formula();
    let answer = match largest < LARGEST_FORMULA {
        true => Answer::Unknown,
        false => Answer::TooLarge,
    };
    (answer, largest as u64 / VARIABLES_A_STEP)
}

/// Runs the solver on a formula, as long as what is left of the question's effort lasts, and adds its steps.
fn run(
    formula: &formula::Formula,
    question: &Question<'_>,
    spent: &mut u64,
    proof: Option<&mut Certificate<'_>>,
) -> Outcome {
    let variables = formula.variables() as u64;
    *spent += variables / VARIABLES_A_STEP;
    let price = CONFLICT + variables / VARIABLES_A_CONFLICT_STEP;
    let affordable = question.effort.saturating_sub(*spent) / price;
    let limit = question.conflicts.min(affordable);
    let (seed, watch) = (question.seed, question.watch);
    let (outcome, conflicts) = match question.solver {
        Solver::Batsat => solver::run(formula, limit, seed, watch, proof),
        #[cfg(feature = "cadical")]
        Solver::Cadical => cadical::run(formula, limit, seed, watch),
    };
    *spent += conflicts * price;
    outcome
}

fn folded(
    problem: &Problem<'_>,
    question: &Question<'_>,
    fold: Fold,
    mut proof: Option<Certificate<'_>>,
) -> (Answer, u64) {
    if !fold::applies(problem) {
        return (Answer::Silent, 0);
    }
    let (ii, largest) = (question.ii, question.largest_formula());
    let Some(formula) = fold::encode(problem, ii, fold, question.named, largest) else {
        return too_large(question);
    };
    let mut spent = 0;
    let answer = match run(&formula, question, &mut spent, proof.as_mut()) {
        Outcome::Unsatisfiable => Answer::Impossible,
        Outcome::Model(_) => Answer::Silent,
        Outcome::GaveUp => Answer::Unknown,
    };
    (answer, spent)
}

fn timed(
    problem: &Problem<'_>,
    question: &Question<'_>,
    slack: u32,
    mut proof: Option<Certificate<'_>>,
) -> (Answer, u64) {
    let at_ii;
    let freedom = match &question.within {
        Some((within, _)) => within,
        None => {
            at_ii = Freedom::at(problem, question.ii);
            &at_ii
        }
    };
    let mut spare = EntityMap::filled(problem.graph.places.len(), 0);
    let mut spent = 0;
    for tightening in 0..=TIGHTENINGS {
        let Some(encoding) = encode::encode(problem, question, slack, freedom, &spare) else {
            let (answer, more) = too_large(question);
            return (answer, spent + more);
        };
        let proof = proof.as_mut().filter(|_| tightening == 0);
        match run(&encoding.formula, question, &mut spent, proof) {
            Outcome::Unsatisfiable if tightening == 0 => return (Answer::Impossible, spent),
            Outcome::Unsatisfiable | Outcome::GaveUp => return (Answer::Unknown, spent),
            Outcome::Model(model) => {
                match decode::decode(problem, question, freedom, &encoding, &model) {
                    Ok(placement) => return (Answer::Placed(Box::new(placement)), spent),
                    Err(full) if full.is_empty() => return (Answer::Unknown, spent),
                    Err(full) => full.into_iter().for_each(|file| spare[file] += 1),
                }
            }
        }
    }
    (Answer::Unknown, spent)
}
