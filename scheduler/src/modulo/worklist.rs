//! The worklist of the exact way: the IIs and formulas that are still open, and the search that
//! asks them in turn.

use super::exact::{self, Answer, Fold, Question, Scope, Solver};
use super::place::Placement;
use super::record::{Asked, Outcome};
use super::task::Task;
use super::{Impossible, Options};
use srp_archdesc::Watch;
use std::collections::BTreeMap;

/// Conflicts of the first question.
const FIRST_CONFLICTS: u64 = 1000;
/// Steps of a question in the first round, where IIs share what there is: a conflict of a large formula takes more
/// of them.
const SHARE: u64 = 16_000;
/// The folded formulas, each with the round from which on it is asked. Few laps are soon answered; parity, which two
/// tell, often decides.
const FOLDS: &[(u32, Fold)] = &[
    (0, Fold { laps: 1, depth: 2 }),
    (1, Fold { laps: 1, depth: 4 }),
    (1, Fold { laps: 2, depth: 4 }),
    (3, Fold { laps: 3, depth: 6 }),
    (5, Fold { laps: 8, depth: 8 }),
];
/// The longest horizon that is asked before folded formulas.
const SOON: u32 = 3;
/// Rounds for which timed formulas with more slack wait where those with less have no answer.
const PATIENCE: u32 = 2;

/// How far an exact search goes.
pub(super) struct Limits<'a> {
    /// Steps.
    pub(super) effort: u64,
    pub(super) watch: &'a dyn Watch,
}

/// Results of the exact way for the IIs below a schedule's.
pub(super) struct Worklist<'a, 'p> {
    task: &'a Task<'p>,
    bound: u32,
    /// The longest horizon to ask about.
    slack: u32,
    solver: Solver,
    /// The folded formulas of this machine.
    folds: &'static [(u32, Fold)],
    /// Folded formulas are asked too, and the II below the best is asked first.
    thorough: bool,
    /// Every question that was asked.
    asked: BTreeMap<(u32, Scope), Asked>,
    /// Every question is asked in rounds, each with more conflicts than the one before, so that a
    /// hard one does not keep the others waiting.
    round: u32,
}

impl<'a, 'p> Worklist<'a, 'p> {
    pub(super) fn new(task: &'a Task<'p>, options: &Options) -> Worklist<'a, 'p> {
        Worklist {
            task,
            bound: task.bounds.min_ii(),
            slack: options.slack,
            solver: options.solver,
            folds: match exact::fold_applies(&task.problem) {
                true => FOLDS,
                false => &[],
            },
            thorough: false,
            asked: BTreeMap::new(),
            round: 0,
        }
    }

    /// Goes on to longer horizons and to folded formulas, in rounds that begin anew.
    pub(super) fn extend(&mut self, slack: u32) {
        self.slack = slack.max(self.slack);
        self.thorough = true;
        self.round = 0;
    }

    /// True if no question is left below an II.
    pub(super) fn is_settled(&self, below: u32) -> bool {
        self.open(below, u32::BITS).is_empty()
    }

    /// Looks for a schedule with a smaller II than `best`, for one round where the search is thorough; goes on where
    /// it was left. Takes what it spends from the limits.
    pub(super) fn search(&mut self, best: u32, limits: &mut Limits<'_>) -> Option<Placement> {
        let mut found: Option<Placement> = None;
        loop {
            let below = found.as_ref().map_or(best, |f| f.ii);
            if self.is_settled(below) {
                return found;
            }
            for (ii, scope) in self.open(below, self.round) {
                if found.as_ref().is_some_and(|f| ii >= f.ii) || self.is_ruled_out(ii) {
                    continue;
                }
                if limits.effort == 0 || limits.watch.cancelled() {
                    return found;
                }
                found = self.ask(ii, scope, limits).or(found);
            }
            self.round += 1;
            if self.thorough {
                return found;
            }
        }
    }

    /// Asks folded formulas, few laps first, about the IIs below a schedule's that are impossible up to a horizon.
    pub(super) fn fold(&mut self, below: u32, limits: &mut Limits<'_>) {
        loop {
            let small = self.folds.iter().take(FOLDS.len() - 1);
            let scopes = small.map(|&(_, fold)| Scope::Folded(fold));
            let all = scopes.flat_map(|scope| (self.bound..below).map(move |ii| (ii, scope)));
            let is_open = |&(ii, scope): &(u32, Scope)| {
                self.is_timed_out(ii) && !self.is_ruled_out(ii) && self.is_open(ii, scope)
            };
            let open: Vec<(u32, Scope)> = all.filter(is_open).collect();
            if open.is_empty() {
                return;
            }
            for (ii, scope) in open.into_iter() {
                if limits.effort == 0 || limits.watch.cancelled() {
                    return;
                }
                if !self.is_ruled_out(ii) {
                    self.ask(ii, scope, limits);
                }
            }
            self.round += 1;
        }
    }

    /// True if a question below an II, which is not impossible for another reason, has no answer.
    pub(super) fn leaves_unknown(&self, below: u32) -> bool {
        let mut asked = self.asked.values();
        asked.any(|asked| {
            let is_below = asked.ii < below && !self.is_ruled_out(asked.ii);
            is_below && asked.outcome == Outcome::Unknown && self.is_open(asked.ii, asked.scope)
        })
    }

    fn ask(&mut self, ii: u32, scope: Scope, limits: &mut Limits<'_>) -> Option<Placement> {
        let Task { problem, fixed, .. } = self.task;
        let times = 2u64.saturating_pow(self.round);
        let (conflicts, share) = match self.thorough {
            true => (u64::MAX, SHARE.saturating_mul(times)),
            false => (FIRST_CONFLICTS.saturating_mul(times), u64::MAX),
        };
        let question = Question {
            ii,
            scope,
            conflicts,
            effort: limits.effort.min(share),
            seed: self.round,
            fixed,
            within: None,
            named: false,
            solver: self.solver,
            watch: limits.watch,
        };
        let (answer, spent) = exact::solve(problem, &question, None);
        limits.effort -= spent.min(limits.effort);
        let outcome = Outcome::of(&answer, problem, ii, scope);
        let asked = (self.asked.entry((ii, scope))).or_insert(Asked {
            ii,
            scope,
            outcome,
            times: 0,
            steps: 0,
        });
        asked.outcome = outcome;
        asked.times += 1;
        asked.steps += spent;
        match answer {
            Answer::Placed(found) if outcome == Outcome::Schedule => Some(*found),
            _ => None,
        }
    }

    /// The questions below an II that are open in a round, those with a short horizon first at each
    /// II: they are soon answered. Each round goes a step further.
    fn open(&self, below: u32, round: u32) -> Vec<(u32, Scope)> {
        let mut iis: Vec<u32> = (self.bound..below).collect();
        // From above, where a schedule is the likeliest, and from the bound, in turns.
        if self.thorough
            && let Some(last) = iis.pop()
        {
            iis.insert(0, last);
        }
        let rounds = || 0..=round.min(u32::BITS - 1);
        let timed = || {
            rounds()
                .map(|k| ((1u64 << k) - 1) as u32)
                .take_while(|&slack| slack <= self.slack)
                .map(|slack| Scope::Timed { slack })
        };
        let folded = || {
            let folds = (self.folds.iter()).filter(|&&(from, _)| self.thorough && from <= round);
            folds.map(|&(_, fold)| Scope::Folded(fold))
        };
        // Where a horizon is hard, those beyond are harder.
        let is_due = move |ii: u32, scope: Scope| match scope {
            Scope::Timed { slack } if self.thorough => {
                let unknown = |&(other, outcome): &(u32, Outcome)| {
                    other < slack
                        && outcome == Outcome::Unknown
                        && self.is_open(ii, Scope::Timed { slack: other })
                };
                let waits = self.timed(ii).filter(unknown).count() as u32 * PATIENCE;
                round >= u32::BITS - slack.leading_zeros() + waits
            }
            Scope::Timed { .. } | Scope::Folded(_) => true,
        };
        let scopes = |ii: u32| {
            // The first horizons find most schedules, and folded formulas are soon answered.
            let (first, rest): (Vec<_>, Vec<_>) =
                timed().partition(|&scope| !self.thorough || scope <= Scope::Timed { slack: SOON });
            let all = first.into_iter().chain(folded()).chain(rest);
            all.map(move |scope| (ii, scope))
        };
        (iis.into_iter())
            .filter(|&ii| !self.is_ruled_out(ii))
            .flat_map(scopes)
            .filter(|&(ii, scope)| self.is_open(ii, scope) && is_due(ii, scope))
            .collect()
    }

    /// True if a question may still have an answer: of a timed formula, if no longer one was impossible, and no
    /// shorter one hopeless.
    fn is_open(&self, ii: u32, scope: Scope) -> bool {
        let Scope::Timed { slack } = scope else {
            let asked = self.asked.get(&(ii, scope));
            return asked.is_none_or(|asked| asked.outcome.is_open());
        };
        self.timed(ii).all(|(other, outcome)| match outcome {
            Outcome::Impossible { .. } => other < slack,
            Outcome::TooLarge | Outcome::TooLong => other > slack,
            Outcome::Schedule | Outcome::Silent | Outcome::Unknown => true,
        })
    }

    /// The horizons that were asked about for an II.
    fn timed(&self, ii: u32) -> impl Iterator<Item = (u32, Outcome)> {
        self.of(ii).filter_map(|asked| match asked.scope {
            Scope::Timed { slack } => Some((slack, asked.outcome)),
            Scope::Folded(_) => None,
        })
    }

    /// All that was asked about an II.
    fn of(&self, ii: u32) -> impl Iterator<Item = &Asked> {
        self.asked.values().filter(move |asked| asked.ii == ii)
    }

    /// True if an II is impossible at any length.
    fn is_ruled_out(&self, ii: u32) -> bool {
        let outright = Outcome::Impossible { outright: true };
        self.of(ii).any(|asked| asked.outcome == outright)
    }

    /// True if an II is impossible up to a horizon.
    fn is_timed_out(&self, ii: u32) -> bool {
        let is_impossible = |outcome| matches!(outcome, Outcome::Impossible { .. });
        self.timed(ii).any(|(_, outcome)| is_impossible(outcome))
    }

    /// All that was asked, by II.
    pub(super) fn asked(&self) -> Vec<Asked> {
        self.asked.values().copied().collect()
    }

    /// The proofs below an II: of each the one that says most.
    pub(super) fn impossible(&self, below: u32) -> Vec<Impossible> {
        let of = |ii: u32| {
            let proofs = self.of(ii).filter_map(|asked| match asked.outcome {
                Outcome::Impossible { outright } => Some(Impossible {
                    ii,
                    scope: asked.scope,
                    outright,
                }),
                _ => None,
            });
            // The last of the horizons is the longest.
            proofs.max_by_key(|proof| (proof.outright, proof.slack()))
        };
        (self.bound..below).filter_map(of).collect()
    }
}
