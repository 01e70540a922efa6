//! The worklist of the exact way: the IIs and horizons that are still open, and the search that
//! asks them in turn.

use super::exact::{self, Answer};
use super::finish;
use super::problem::Problem;
use super::{Impossible, MAX_STAGES};
use srp_archdesc::Watch;
use srp_ir::dre::scheduled::{ModuloSchedule, Reg};
use std::collections::BTreeMap;

/// Conflicts of the first question.
const FIRST_CONFLICTS: u64 = 1000;

/// How far an exact search goes.
pub(super) struct Limits<'a> {
    /// Steps.
    pub(super) effort: u64,
    pub(super) watch: &'a dyn Watch,
}

/// Results of the exact way for the IIs below a schedule's.
pub(super) struct Worklist {
    bound: u32,
    /// The longest horizon to ask about.
    slack: u32,
    /// The longest horizon of a proof, by II.
    proved: BTreeMap<u32, u32>,
    /// Horizons from which on there is no answer to be had, by II.
    hopeless: BTreeMap<u32, u32>,
    /// Every question is asked in rounds, each with more conflicts than the one before, so that a
    /// hard one does not keep the others waiting.
    round: u32,
}

impl Worklist {
    pub(super) fn new(bound: u32, slack: u32) -> Worklist {
        Worklist {
            bound,
            slack,
            proved: BTreeMap::new(),
            hopeless: BTreeMap::new(),
            round: 0,
        }
    }

    pub(super) fn extend(&mut self, slack: u32) {
        self.slack = slack.max(self.slack);
    }

    /// True if no question is left below an II.
    pub(super) fn is_settled(&self, below: u32) -> bool {
        self.open(below, u32::BITS).is_empty()
    }

    /// Looks for a schedule with a smaller II than `best`; goes on where it was left.
    pub(super) fn search(
        &mut self,
        problem: &Problem<'_>,
        live_ins: &[Reg],
        fixed: &[Reg],
        best: u32,
        limits: Limits<'_>,
    ) -> Option<ModuloSchedule> {
        let mut found: Option<ModuloSchedule> = None;
        let mut left = limits.effort;
        loop {
            let below = found.as_ref().map_or(best, |f| f.ii);
            if self.is_settled(below) {
                return found;
            }
            let conflicts = FIRST_CONFLICTS.saturating_mul(2u64.saturating_pow(self.round));
            for Impossible { ii, slack } in self.open(below, self.round) {
                if found.as_ref().is_some_and(|f| ii >= f.ii) {
                    break;
                }
                if left == 0 || limits.watch.cancelled() {
                    return found;
                }
                let question = exact::Question {
                    ii,
                    slack,
                    conflicts,
                    effort: left,
                    seed: self.round,
                    fixed,
                    watch: limits.watch,
                };
                let (answer, spent) = exact::solve(problem, &question, None);
                left -= spent.min(left);
                match answer {
                    Answer::Placed(placement) => {
                        let schedule = finish::finish(problem, &placement, live_ins);
                        if schedule.stages() <= MAX_STAGES {
                            found = Some(schedule);
                        } else {
                            self.give_up(ii, slack);
                        }
                    }
                    Answer::Impossible => self.prove(ii, slack),
                    Answer::Unknown => {}
                    Answer::TooLarge => self.give_up(ii, slack),
                }
            }
            self.round += 1;
        }
    }

    fn prove(&mut self, ii: u32, slack: u32) {
        let most = self.proved.entry(ii).or_insert(slack);
        *most = slack.max(*most);
    }

    fn give_up(&mut self, ii: u32, slack: u32) {
        let least = self.hopeless.entry(ii).or_insert(slack);
        *least = slack.min(*least);
    }

    /// The questions below an II that are open in a round, those with a short horizon first at each
    /// II: they are soon answered. Each round goes a step further.
    fn open(&self, below: u32, round: u32) -> Vec<Impossible> {
        let slacks = || {
            (0..u32::BITS)
                .map(|k| (1 << k) - 1)
                .take_while(|&s| s <= self.slack)
                .take(round as usize + 1)
        };
        let is_open = |q: &Impossible| {
            self.proved.get(&q.ii).is_none_or(|&s| s < q.slack)
                && self.hopeless.get(&q.ii).is_none_or(|&s| s > q.slack)
        };
        (self.bound..below)
            .flat_map(|ii| slacks().map(move |slack| Impossible { ii, slack }))
            .filter(is_open)
            .collect()
    }

    /// The proofs below an II.
    pub(super) fn impossible(&self, below: u32) -> Vec<Impossible> {
        let proved = self.proved.range(..below);
        proved
            .map(|(&ii, &slack)| Impossible { ii, slack })
            .collect()
    }
}
