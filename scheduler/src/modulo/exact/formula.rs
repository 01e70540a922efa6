//! [`Formula`]: clauses as they are collected, and the usual cardinality constraints.
//!
//! Literals are those of DIMACS files: variables count from 1, a minus sign negates.

use std::io::{self, Write};

/// A literal.
pub(super) type Lit = i32;

/// A formula in conjunctive normal form.
#[derive(Default)]
pub(super) struct Formula {
    variables: i32,
    /// The name of each variable, where names are kept.
    names: Option<Vec<String>>,
    /// All clauses, each ended by a zero.
    literals: Vec<Lit>,
    clauses: usize,
}

impl Formula {
    /// A formula that keeps the names of its variables, or does not ask for them.
    pub(super) fn new(named: bool) -> Formula {
        Formula {
            names: named.then(Vec::new),
            ..Formula::default()
        }
    }

    /// A new variable. Its name says what it stands for: words of a kind, a node, a place, a cycle.
    pub(super) fn variable(&mut self, name: impl FnOnce() -> String) -> Lit {
        self.variables += 1;
        if let Some(names) = &mut self.names {
            names.push(name());
        }
        self.variables
    }

    pub(super) fn variables(&self) -> usize {
        self.variables as usize
    }

    pub(super) fn clause(&mut self, literals: impl IntoIterator<Item = Lit>) {
        self.literals.extend(literals);
        self.literals.push(0);
        self.clauses += 1;
    }

    pub(super) fn clauses(&self) -> impl Iterator<Item = &[Lit]> {
        // The last piece of the split is what follows the last zero: nothing.
        self.literals.split(|&l| l == 0).take(self.clauses)
    }

    /// At most one of these holds: a ladder of prefixes (Sinz 2005), or pairs where they are few. A prefix has the
    /// label and its number as its name.
    pub(super) fn at_most_one(&mut self, literals: &[Lit], label: impl Fn() -> String) {
        if literals.len() <= 5 {
            for (i, &a) in literals.iter().enumerate() {
                for &b in &literals[..i] {
                    self.clause([-a, -b]);
                }
            }
            return;
        }
        let mut before: Option<Lit> = None;
        for (i, &l) in literals.iter().enumerate() {
            if let Some(before) = before {
                self.clause([-l, -before]);
            }
            if i + 1 == literals.len() {
                break;
            }
            let prefix = self.variable(|| format!("{} {i}.0", label()));
            self.clause([-l, prefix]);
            if let Some(before) = before {
                self.clause([-before, prefix]);
            }
            before = Some(prefix);
        }
    }

    /// At most `most` of these hold: a sequential counter (Sinz 2005). A digit has the label, the number of its
    /// literal and what it counts to as its name.
    pub(super) fn at_most(&mut self, most: u32, literals: &[Lit], label: impl Fn() -> String) {
        let most = most as usize;
        match most {
            _ if literals.len() <= most => return,
            0 => return literals.iter().for_each(|&l| self.clause([-l])),
            1 => return self.at_most_one(literals, label),
            _ => {}
        }
        let mut counted: Vec<Lit> = Vec::new();
        for (i, &l) in literals.iter().enumerate() {
            let next: Vec<Lit> = (0..most)
                .map(|k| self.variable(|| format!("{} {i}.{k}", label())))
                .collect();
            self.clause([-l, next[0]]);
            for (k, &c) in counted.iter().enumerate() {
                self.clause([-c, next[k]]);
                match next.get(k + 1) {
                    Some(&more) => self.clause([-l, -c, more]),
                    None => self.clause([-l, -c]),
                }
            }
            counted = next;
        }
    }

    /// Writes the formula in DIMACS form, after the names of its variables, each in a comment: `c var NUMBER NAME`.
    pub(super) fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        for (number, name) in (1..).zip(self.names.iter().flatten()) {
            writeln!(out, "c var {number} {name}")?;
        }
        writeln!(out, "p cnf {} {}", self.variables, self.clauses)?;
        for clause in self.clauses() {
            for literal in clause {
                write!(out, "{literal} ")?;
            }
            writeln!(out, "0")?;
        }
        Ok(())
    }
}
