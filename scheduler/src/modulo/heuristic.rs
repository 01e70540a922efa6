//! The heuristic's way through the IIs: up from the bound in growing steps until one works, then down
//! again while the effort lasts.
//!
//! Attempts at one II take turns between the two ways of [`place`](super::place), and each learns
//! from those before: nodes that gave trouble are placed earlier (squeaky wheel optimisation, Joslin
//! and Clements 1999), and edges that found no route weigh more.

use super::anneal::{self, Anneal};
use super::finish;
use super::obstacle::{FailedIi, Obstacle, Unschedulable};
use super::order::{Freedom, order};
use super::place::{Attempt, Conflict, LIGHTEST};
use super::problem::Problem;
use super::route::Router;
use super::{MAX_STAGES, Options};
use srp_archdesc::Watch;
use srp_archdesc::entity::EntityMap;
use srp_ir::dfg::Node;
use srp_ir::dre::scheduled::{ModuloSchedule, Reg};
use std::collections::BTreeMap;

/// The part of the way down to the bound that is tried in one leap, and attempts at it.
const LEAPS: u32 = 4;
const LEAP_ATTEMPTS: u32 = 3;
/// Attempts at each II on the way down, at most.
const ATTEMPTS: u32 = 64;
/// Proposals of the annealing for each node and temperature: at first, and how often they double.
const PROPOSALS: u32 = 20;
const DOUBLINGS: u32 = 3;

/// How an attempt goes about it.
#[derive(Clone, Copy)]
enum Way {
    /// Node by node.
    OneByOne,
    /// From annealed positions.
    AllAtOnce,
}

/// The search over IIs.
pub(super) struct Heuristic<'a, 'p> {
    problem: &'a Problem<'p>,
    live_ins: &'a [Reg],
    fixed: &'a [Reg],
    router: Router,
    levels: BTreeMap<u32, Level>,
}

/// What is known of one II.
struct Level {
    freedom: Freedom,
    /// Attempts so far, by way.
    attempts: [u32; 2],
    trouble: EntityMap<Node, u32>,
    /// Weights of the edges.
    weights: Vec<u32>,
    /// What was most often in the way of the first attempt that failed; `Some(None)` where that was
    /// nothing in particular.
    failed: Option<Option<Conflict>>,
}

impl<'a, 'p> Heuristic<'a, 'p> {
    pub(super) fn new(
        problem: &'a Problem<'p>,
        live_ins: &'a [Reg],
        fixed: &'a [Reg],
    ) -> Heuristic<'a, 'p> {
        Heuristic {
            problem,
            live_ins,
            fixed,
            router: Router::default(),
            levels: BTreeMap::new(),
        }
    }

    /// A schedule with the first II that works, by quick attempts.
    pub(super) fn first(
        &mut self,
        bound: u32,
        options: &Options,
        watch: &dyn Watch,
    ) -> Result<ModuloSchedule, Unschedulable> {
        let deepest = self.problem.srp.contexts;
        for way in [Way::OneByOne, Way::AllAtOnce] {
            let mut ii = bound;
            while ii <= deepest {
                let limit = self.router.expanded + options.effort;
                if let Some(schedule) = self.attempt(ii, way, limit, watch) {
                    return Ok(schedule);
                }
                if watch.cancelled() {
                    let failed = self.failed(deepest);
                    return Err(Unschedulable::Stopped { failed });
                }
                ii += 1 + (ii - bound) / 3;
            }
        }
        Err(match self.failed(deepest) {
            Some(failed) => Unschedulable::NotFound {
                up_to: deepest,
                failed,
            },
            None => Unschedulable::Contexts {
                bound,
                contexts: deepest,
            },
        })
    }

    /// Betters a schedule with so many steps: in leaps as long as these work, then II by II.
    pub(super) fn improve(
        &mut self,
        best: &mut ModuloSchedule,
        bound: u32,
        effort: u64,
        watch: &dyn Watch,
    ) {
        let limit = self.router.expanded + effort;
        let mut leap = (best.ii - bound).div_ceil(LEAPS);
        while best.ii > bound && leap > 0 {
            let ii = best.ii - leap.min(best.ii - bound);
            let (attempts, limit) = match leap {
                1 => (ATTEMPTS, limit),
                _ => (LEAP_ATTEMPTS, limit.min(self.router.expanded + effort / 4)),
            };
            match self.attempts(ii, attempts, limit, watch) {
                Some(schedule) => *best = schedule,
                None => leap /= 2,
            }
        }
    }

    /// Attempts at one II, at least one, by both ways in turns.
    fn attempts(
        &mut self,
        ii: u32,
        attempts: u32,
        limit: u64,
        watch: &dyn Watch,
    ) -> Option<ModuloSchedule> {
        for attempt in 0..attempts {
            if attempt > 0 && self.router.expanded >= limit || watch.cancelled() {
                break;
            }
            let way = match attempt % 3 {
                0 => Way::OneByOne,
                _ => Way::AllAtOnce,
            };
            if let Some(schedule) = self.attempt(ii, way, limit, watch) {
                return Some(schedule);
            }
        }
        None
    }

    /// The next attempt at an II by one way.
    fn attempt(
        &mut self,
        ii: u32,
        way: Way,
        limit: u64,
        watch: &dyn Watch,
    ) -> Option<ModuloSchedule> {
        let problem = self.problem;
        let level = (self.levels.entry(ii)).or_insert_with(|| Level::new(problem, ii));
        let seed = level.attempts[way as usize];
        level.attempts[way as usize] += 1;
        let (freedom, router) = (&level.freedom, &mut self.router);
        let mut attempt = Attempt::new(problem, ii, seed, freedom, self.fixed, router);
        let result = match way {
            Way::OneByOne => attempt.one_by_one(&order(problem, freedom, seed, &level.trouble)),
            Way::AllAtOnce => {
                let proposals = PROPOSALS << seed.min(DOUBLINGS);
                let start = Anneal::new(problem, ii, freedom, seed, &level.weights);
                match start.map(|anneal| anneal.run(proposals)) {
                    Some(positions) => {
                        let spent = anneal::effort(problem, proposals);
                        attempt.all_at_once(&positions, spent, limit, watch)
                    }
                    None => Err(None),
                }
            }
        };
        attempt.report(&mut level.trouble, &mut level.weights);
        match result {
            Ok(placement) => {
                let schedule = finish::finish(problem, &placement, self.live_ins);
                (schedule.stages() <= MAX_STAGES).then_some(schedule)
            }
            Err(conflict) => {
                level.failed = level.failed.or(Some(conflict));
                None
            }
        }
    }

    /// The largest II up to this one that did not work.
    pub(super) fn failed(&self, up_to: u32) -> Option<FailedIi> {
        let failed = |(_, level): &(&u32, &Level)| level.failed.is_some();
        let (&ii, level) = self.levels.range(..=up_to).rfind(failed)?;
        let obstacle = Obstacle::of(self.problem, level.failed?);
        Some(FailedIi { ii, obstacle })
    }
}

impl Level {
    fn new(problem: &Problem<'_>, ii: u32) -> Level {
        Level {
            freedom: Freedom::at(problem, ii),
            attempts: [0; 2],
            trouble: EntityMap::filled(problem.dfg.nodes.len(), 0),
            weights: vec![LIGHTEST; problem.edges.len()],
            failed: None,
        }
    }
}
