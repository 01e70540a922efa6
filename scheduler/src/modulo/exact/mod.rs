//! The exact way: one formula says that a schedule with a given II exists, no longer than a given
//! horizon, and a SAT solver decides it.
//!
//! A variable stands for each thing that a placement may take: a node's unit and cycle, a value in
//! an output or in a register file, a move, a write. Whatever a value has must come from somewhere,
//! so that every model of the formula holds a route for every edge ([`encode`]); a model is read
//! back into routes ([`decode`]), which then take their registers as those of the heuristic do.
//!
//! Everything that the formula demands is necessary, but register files are asked only not to hold
//! more values in a cycle than they have registers. So *unsatisfiable* is a proof that no schedule
//! exists with this II in which no operation is issued later than `slack` cycles after its latest
//! start in the shortest schedule with unlimited units; a model whose values find no registers
//! proves nothing, and the formula is tightened.

mod budget;
mod decode;
mod encode;
mod formula;

use super::Certificate;
use super::order::Freedom;
use super::place::Placement;
use super::problem::Problem;
use batsat::{Callbacks, ClauseKind, Solver, SolverInterface, lbool};
use formula::{Formula, Lit};
use srp_archdesc::Watch;
use srp_archdesc::entity::EntityMap;
use srp_ir::dre::scheduled::Reg;

/// A question to the solver.
pub(super) struct Question<'a> {
    pub(super) ii: u32,
    /// Cycles beyond the critical path in which operations may be issued.
    pub(super) slack: u32,
    /// Conflicts after which the solver gives up.
    pub(super) conflicts: u64,
    /// Steps after which it gives up.
    pub(super) effort: u64,
    /// Tells tries of one question apart: the order in which the solver looks at variables.
    pub(super) seed: u32,
    /// Registers that hold something else.
    pub(super) fixed: &'a [Reg],
    /// Asked now and then; true gives up.
    pub(super) watch: &'a dyn Watch,
}

impl Question<'_> {
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
    /// There is none within the horizon.
    Impossible,
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
    mut proof: Option<Certificate<'_>>,
) -> (Answer, u64) {
    let freedom = Freedom::at(problem, question.ii);
    let mut spare = EntityMap::filled(problem.graph.places.len(), 0);
    let mut spent = 0;
    for tightening in 0..=TIGHTENINGS {
        let Some(encoding) = encode::encode(problem, question, &freedom, &spare) else {
            let largest = question.largest_formula();
            let answer = match largest < LARGEST_FORMULA {
                true => Answer::Unknown,
                false => Answer::TooLarge,
            };
            return (answer, spent + largest as u64 / VARIABLES_A_STEP);
        };
        let proof = proof.as_mut().filter(|_| tightening == 0);
        let variables = encoding.formula.variables() as u64;
        spent += variables / VARIABLES_A_STEP;
        let price = CONFLICT + variables / VARIABLES_A_CONFLICT_STEP;
        let affordable = question.effort.saturating_sub(spent) / price;
        let limit = question.conflicts.min(affordable);
        let (outcome, conflicts) = run(
            &encoding.formula,
            limit,
            question.seed,
            question.watch,
            proof,
        );
        spent += conflicts * price;
        match outcome {
            Outcome::Unsatisfiable if tightening == 0 => return (Answer::Impossible, spent),
            Outcome::Unsatisfiable | Outcome::GaveUp => return (Answer::Unknown, spent),
            Outcome::Model(model) => {
                match decode::decode(problem, question, &freedom, &encoding, &model) {
                    Ok(placement) => return (Answer::Placed(Box::new(placement)), spent),
                    Err(full) if full.is_empty() => return (Answer::Unknown, spent),
                    Err(full) => full.into_iter().for_each(|file| spare[file] += 1),
                }
            }
        }
    }
    (Answer::Unknown, spent)
}

/// The result of a run of the solver.
enum Outcome {
    /// For each variable, from 1 (index 0 is unused): true if it holds.
    Model(Vec<bool>),
    Unsatisfiable,
    GaveUp,
}

/// Counts conflicts, and writes the proof.
struct Search<'a, 'p> {
    conflicts: u64,
    limit: u64,
    watch: &'a dyn Watch,
    proof: Option<&'a mut Certificate<'p>>,
    /// True if a line of the proof could not be written.
    failed: bool,
}

impl Search<'_, '_> {
    fn line(&mut self, deleted: bool, clause: &[batsat::Lit]) {
        let Some(proof) = &mut self.proof else {
            return;
        };
        let mut line = String::from(if deleted { "d " } else { "" });
        for &literal in clause {
            line.push_str(&format!("{} ", dimacs(literal)));
        }
        self.failed |= writeln!(proof.steps, "{line}0").is_err();
    }
}

impl Callbacks for Search<'_, '_> {
    fn on_new_clause(&mut self, clause: &[batsat::Lit], kind: ClauseKind) {
        if kind == ClauseKind::Learnt {
            self.conflicts += 1;
            self.line(false, clause);
        }
    }

    fn on_delete_clause(&mut self, clause: &[batsat::Lit]) {
        self.line(true, clause);
    }

    fn stop(&self) -> bool {
        self.conflicts >= self.limit || self.failed || self.watch.cancelled()
    }
}

fn dimacs(literal: batsat::Lit) -> Lit {
    let variable = literal.var().idx() as Lit + 1;
    if literal.sign() { variable } else { -variable }
}

/// Runs the solver; returns its result and its conflicts.
fn run(
    formula: &Formula,
    limit: u64,
    seed: u32,
    watch: &dyn Watch,
    mut proof: Option<&mut Certificate<'_>>,
) -> (Outcome, u64) {
    let mut failed = false;
    if let Some(proof) = &mut proof {
        failed = formula.write(proof.formula).is_err();
    }
    let watch = Search {
        conflicts: 0,
        limit,
        watch,
        proof,
        failed,
    };
    let options = batsat::SolverOpts {
        rnd_init_act: seed > 0,
        random_seed: f64::from(seed) + 91_648_253.0,
        ..batsat::SolverOpts::default()
    };
    let mut solver = Solver::new(options, watch);
    let variables: Vec<batsat::Var> = (0..formula.variables())
        .map(|_| solver.new_var_default())
        .collect();
    let literal = |l: &Lit| batsat::Lit::new(variables[l.unsigned_abs() as usize - 1], *l > 0);
    let mut consistent = true;
    for clause in formula.clauses() {
        let mut clause: Vec<batsat::Lit> = clause.iter().map(literal).collect();
        consistent &= solver.add_clause_reuse(&mut clause);
    }
    let answer = if consistent {
        solver.solve_limited(&[])
    } else {
        lbool::FALSE
    };
    let model = (answer == lbool::TRUE).then(|| {
        let holds = variables
            .iter()
            .map(|&v| solver.value_var(v) == lbool::TRUE);
        std::iter::once(false).chain(holds).collect()
    });
    let watch = solver.cb_mut();
    if answer == lbool::FALSE {
        watch.line(false, &[]);
    }
    let conflicts = watch.conflicts;
    let outcome = match model {
        _ if watch.failed => Outcome::GaveUp,
        Some(model) => Outcome::Model(model),
        None if answer == lbool::FALSE => Outcome::Unsatisfiable,
        None => Outcome::GaveUp,
    };
    (outcome, conflicts)
}
