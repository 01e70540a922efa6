//! Certificates of impossible initiation intervals, held against a checker of their own: every clause
//! of the proof must follow from those before it by unit propagation (RUP, Goldberg and Novikov
//! 2003), and the last is the empty one.

use srp_archdesc::Unwatched;
use srp_ir::split;
use srp_scheduler::modulo::{self, Certificate, Impossible};
use srp_tests::{compiled, machine, root};

/// A literal as an index: twice the variable, one more where it is negated.
fn index(literal: i32) -> usize {
    2 * literal.unsigned_abs() as usize + usize::from(literal < 0)
}

/// Clauses, and where each literal occurs.
struct Clauses {
    clauses: Vec<Vec<i32>>,
    occurrences: Vec<Vec<usize>>,
}

impl Clauses {
    fn read(formula: &str) -> Clauses {
        let mut lines = formula.lines();
        let header = lines.next().expect("a formula has a header");
        let numbers: Vec<usize> = header.split(' ').filter_map(|w| w.parse().ok()).collect();
        let mut clauses = Clauses {
            clauses: Vec::new(),
            occurrences: vec![Vec::new(); 2 * numbers[0] + 2],
        };
        lines.for_each(|line| clauses.add(literals(line)));
        assert_eq!(
            clauses.clauses.len(),
            numbers[1],
            "the header counts the clauses"
        );
        clauses
    }

    fn add(&mut self, clause: Vec<i32>) {
        for &literal in &clause {
            self.occurrences[index(literal)].push(self.clauses.len());
        }
        self.clauses.push(clause);
    }

    /// True if assuming that none of `clause` holds leads to a contradiction by propagation alone.
    fn implies(&self, clause: &[i32]) -> bool {
        let mut holds = vec![false; self.occurrences.len()];
        let mut trail: Vec<i32> = Vec::new();
        let units = self.clauses.iter().filter(|c| c.len() == 1).map(|c| c[0]);
        for literal in clause.iter().map(|l| -l).chain(units) {
            if holds[index(-literal)] {
                return true;
            }
            if !holds[index(literal)] {
                holds[index(literal)] = true;
                trail.push(literal);
            }
        }
        let mut next = 0;
        while let Some(&literal) = trail.get(next) {
            next += 1;
            for &c in &self.occurrences[index(-literal)] {
                let clause = &self.clauses[c];
                if clause.iter().any(|&l| holds[index(l)]) {
                    continue;
                }
                let mut open = clause.iter().filter(|&&l| !holds[index(-l)]);
                match (open.next(), open.next()) {
                    (None, _) => return true,
                    (Some(&unit), None) => {
                        holds[index(unit)] = true;
                        trail.push(unit);
                    }
                    _ => {}
                }
            }
        }
        false
    }

    /// True if a proof holds. Clauses that it deletes are kept, which cannot make it hold.
    fn refuted_by(&mut self, proof: &str) -> bool {
        for line in proof.lines().filter(|line| !line.starts_with('d')) {
            let clause = literals(line);
            if !self.implies(&clause) {
                return false;
            }
            if clause.is_empty() {
                return true;
            }
            self.add(clause);
        }
        false
    }
}

fn literals(line: &str) -> Vec<i32> {
    let numbers = line
        .split_whitespace()
        .map(|w| w.parse().expect("a literal"));
    numbers.take_while(|&l| l != 0).collect()
}

#[test]
fn certificates_hold() {
    let arch = machine("tiny");
    let sources = [root().join("tests/certificate/rays.c")];
    let program = compiled(&sources, &arch).unwrap_or_else(|e| panic!("{e}"));
    let dfg = &split::split(&program)
        .dre
        .kernels
        .into_values()
        .next()
        .expect("a loop");
    let scheduled = modulo::schedule(dfg, &arch.srp, &modulo::Options::default(), &Unwatched);
    let scheduled = scheduled.expect("it has a schedule");
    let bound = scheduled.bounds.min_ii();
    assert!(
        bound < scheduled.schedule.ii,
        "a loop that has nothing to prove proves nothing"
    );
    let claim = Impossible {
        ii: bound,
        slack: 0,
    };
    let (mut formula, mut steps) = (Vec::new(), Vec::new());
    let certificate = Certificate {
        formula: &mut formula,
        steps: &mut steps,
    };
    assert!(modulo::certify(
        dfg,
        &arch.srp,
        claim,
        &Unwatched,
        certificate
    ));
    let formula = String::from_utf8(formula).expect("text");
    let steps = String::from_utf8(steps).expect("text");
    let mut clauses = Clauses::read(&formula);
    assert!(clauses.refuted_by(&steps), "the proof does not hold");
    let clauses = Clauses::read(&formula);
    assert!(
        !clauses.implies(&[]),
        "the formula refutes itself, so that any proof holds"
    );
}
