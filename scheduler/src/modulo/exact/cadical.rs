//! CaDiCaL (Biere et al.) as the solver: a second opinion, C++, without a proof.

use super::formula::Formula;
use super::solver::Outcome;
use cadical::{Callbacks, Solver};
use srp_archdesc::Watch;

/// Counts conflicts by the clauses that they teach.
struct Search<'a> {
    conflicts: u64,
    watch: &'a dyn Watch,
}

impl Callbacks for Search<'_> {
    fn terminate(&mut self) -> bool {
        self.watch.cancelled()
    }

    fn max_length(&self) -> i32 {
        i32::MAX
    }

    fn learn(&mut self, _: &[i32]) {
        self.conflicts += 1;
    }
}

/// Runs the solver; returns its result and its conflicts.
pub(super) fn run(formula: &Formula, limit: u64, seed: u32, watch: &dyn Watch) -> (Outcome, u64) {
    let mut solver: Solver<Search<'_>> = Solver::new();
    solver.set_callbacks(Some(Search {
        conflicts: 0,
        watch,
    }));
    // Among equals the seed decides which phase is tried first.
    let flip = |l: i32| if seed % 2 == 1 { -l } else { l };
    for clause in formula.clauses() {
        solver.add_clause(clause.iter().map(|&l| flip(l)));
    }
    let limit = i32::try_from(limit).unwrap_or(i32::MAX);
    let known = solver.set_limit("conflicts", limit);
    known.expect("the solver counts conflicts");
    let answer = solver.solve();
    let conflicts = solver.get_callbacks().map_or(0, |search| search.conflicts);
    let outcome = match answer {
        Some(true) => {
            let holds = |v: i32| solver.value(flip(v)) == Some(true);
            // A literal that is flipped holds where its variable does not.
            let model = (1..=formula.variables() as i32).map(holds);
            Outcome::Model(std::iter::once(false).chain(model).collect())
        }
        Some(false) => Outcome::Unsatisfiable,
        None => Outcome::GaveUp,
    };
    (outcome, conflicts)
}
