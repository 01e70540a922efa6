//! The SAT solver: runs it on a formula, counts its conflicts, and writes what it learns as the proof.

use super::formula::{Formula, Lit};
use crate::modulo::Certificate;
use batsat::{Callbacks, ClauseKind, Solver, SolverInterface, lbool};
use srp_archdesc::Watch;

/// The result of a run of the solver.
pub(super) enum Outcome {
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
pub(super) fn run(
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
