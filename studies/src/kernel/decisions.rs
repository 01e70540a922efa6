//! Decisions that intervals leave open: every way that a program may take is taken.

use crate::real::Relation;

/// Ways through a program that are followed, at most.
const MOST_WAYS: usize = 256;

/// The decisions of one run. Those that nothing decides follow a list, and go one way where it ends.
#[derive(Clone, Debug, Default)]
pub(super) struct Decisions {
    open: Vec<bool>,
    next: usize,
}

impl Decisions {
    /// The outcome of a decision that holds of some relations.
    pub(super) fn holds(&mut self, relation: Relation, of: &[Relation]) -> bool {
        if relation != Relation::Unknown {
            return of.contains(&relation);
        }
        if self.next == self.open.len() {
            self.open.push(true);
        }
        self.next += 1;
        self.open[self.next - 1]
    }

    /// The list of the next run; false where there is none.
    fn advance(&mut self) -> bool {
        self.next = 0;
        while let Some(last) = self.open.pop() {
            if last {
                self.open.push(false);
                return true;
            }
        }
        false
    }
}

/// Runs a program once for each way that it may take. The error is the first run's that fails, or `too_many`
/// where there are too many ways.
pub(super) fn each_way<R, E>(
    too_many: impl Fn(usize) -> E,
    mut run: impl FnMut(&mut Decisions) -> Result<R, E>,
) -> Result<Vec<R>, E> {
    let mut decisions = Decisions::default();
    let mut results = Vec::new();
    loop {
        results.push(run(&mut decisions)?);
        if !decisions.advance() {
            return Ok(results);
        }
        if results.len() == MOST_WAYS {
            return Err(too_many(MOST_WAYS));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_ways_are_taken_once() {
        let run = |decisions: &mut Decisions| {
            let mut decide = || decisions.holds(Relation::Unknown, &[]);
            let first = decide();
            Ok::<_, ()>((first, first && decide()))
        };
        let ways = each_way(|_| (), run).expect("three ways");
        assert_eq!(ways, [(true, true), (true, false), (false, false)]);
        let endless = |decisions: &mut Decisions| {
            while decisions.holds(Relation::Unknown, &[]) && decisions.next < 10_000 {}
            Ok(())
        };
        assert_eq!(each_way(|n| n, endless), Err(MOST_WAYS));
    }
}
