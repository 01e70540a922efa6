//! A checker of refutations: every clause of the proof must follow from those before it by unit propagation (RUP,
//! Goldberg and Novikov 2003), and the last is the empty one.

/// A literal as an index: twice the variable, one more where it is negated.
fn index(literal: i32) -> usize {
    2 * literal.unsigned_abs() as usize + usize::from(literal < 0)
}

/// Clauses, and where each literal occurs.
pub(super) struct Clauses {
    clauses: Vec<Vec<i32>>,
    occurrences: Vec<Vec<usize>>,
}

impl Clauses {
    pub(super) fn read(formula: &str) -> Clauses {
        let mut lines = formula.lines().skip_while(|line| line.starts_with('c'));
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
    pub(super) fn implies(&self, clause: &[i32]) -> bool {
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
    pub(super) fn refuted_by(&mut self, proof: &str) -> bool {
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
