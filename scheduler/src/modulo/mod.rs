//! Modulo scheduling of kernels onto the array: where and when each operation of a loop runs, and
//! over which links and registers its values travel, so that an iteration starts every II cycles.
//!
//! [`bounds`] says which II cannot be beaten; from there up, [`place`] makes attempts that differ in
//! the order of nodes and in noise, until one succeeds. The result is data; `check` tells whether it is right.

mod bounds;
mod exact;
mod finish;
mod noise;
mod order;
mod place;
mod problem;
mod registers;
mod route;
mod table;

pub use bounds::Bounds;

use crate::abi;
use exact::Answer;
use order::{Freedom, order};
use place::{Attempt, Obstacle};
use problem::{Goal, Problem};
use route::Router;
use srp_archdesc::arch::Arch;
use srp_archdesc::entity::EntityMap;
use srp_ir::dfg::{Dfg, Node};
use srp_ir::dre::scheduled::{ModuloSchedule, Reg};
use std::collections::BTreeMap;
use std::io::Write;

/// How hard to try. Everything is counted in steps, so that the same input gives the same schedule
/// however fast the machine is; only `stop` can change that.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Steps of the router over all attempts of the heuristic at one loop, about 3 million a
    /// second. The first II that works is looked for beyond them.
    pub effort: u64,
    /// Steps of the exact search over all IIs of one loop, some 10 thousand a second; 0 leaves it
    /// out. A conflict is some steps, the more the larger the formula, and so is making one.
    pub exact_effort: u64,
    /// Cycles beyond the critical path in which the exact search may issue operations.
    pub slack: u32,
    /// Asked now and then: true ends the search with the best schedule so far.
    pub stop: &'a (dyn Fn() -> bool + Sync),
    /// Where all these steps do not reach the bound: go on by the exact way, with horizons up to
    /// [`FARTHEST`], until this says stop. It is started anew for every loop.
    pub beyond: Option<&'a (dyn Fn() -> Stop + Sync)>,
}

/// Says when to stop.
pub type Stop = Box<dyn Fn() -> bool>;

/// Cycles beyond the critical path up to which the exact search goes in the end.
pub const FARTHEST: u32 = 15;

impl Default for Options<'_> {
    fn default() -> Self {
        Options {
            effort: 2_000_000,
            exact_effort: 80_000,
            slack: 3,
            stop: &|| false,
            beyond: None,
        }
    }
}

/// Largest number of overlapping iterations: what the stage predicates of an engine hold.
pub const MAX_STAGES: u32 = 64;

/// A schedule, and how it stands to its bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Scheduled {
    /// The schedule.
    pub schedule: ModuloSchedule,
    /// The bounds of the II.
    pub bounds: Bounds,
    /// Why the II below was not reached, in words; `None` where the II is the bound.
    pub obstacle: Option<String>,
    /// The IIs from the bound on that were proved impossible.
    pub impossible: Vec<Impossible>,
}

/// A proof that there is no schedule: with this II, in which every operation is issued within
/// `slack` cycles of its latest start on the critical path, and register files hold no more values
/// in any cycle than they have registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Impossible {
    /// The II.
    pub ii: u32,
    /// Cycles beyond the critical path.
    pub slack: u32,
}

/// A loop that has no schedule on this machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Unschedulable {
    /// The node that it fails on, if it is one.
    pub node: Option<Node>,
    /// Why, in words.
    pub why: String,
}

/// The lower bounds of a loop's II on a machine.
pub fn bounds(dfg: &Dfg, arch: &Arch) -> Bounds {
    Bounds::of(&Problem::new(dfg, arch))
}

/// Schedules a loop.
pub fn schedule(dfg: &Dfg, arch: &Arch, options: &Options<'_>) -> Result<Scheduled, Unschedulable> {
    let problem = Problem::new(dfg, arch);
    let live_ins = live_in_registers(dfg, arch)?;
    for node in problem.nodes() {
        if problem.units[node].is_empty() {
            let op = dfg.nodes[node].op;
            let why = format!("no unit of the array runs `{op}` (class {})", op.class());
            return Err(Unschedulable {
                node: Some(node),
                why,
            });
        }
    }
    let bounds = Bounds::of(&problem);
    let fixed = live_ins.iter().copied().chain(abi::reserved(arch));
    let mut search = Search {
        problem: &problem,
        live_ins: &live_ins,
        fixed: fixed.collect(),
        router: Router::default(),
    };
    let (mut schedule, mut obstacle) =
        (search.run(bounds.min_ii(), options)).map_err(|why| Unschedulable { node: None, why })?;
    let mut exact = Exact::new(bounds.min_ii(), options.slack);
    let mut improve = |exact: &mut Exact, limits: Limits<'_>| {
        if let Some(better) = search.exactly(exact, schedule.ii, limits) {
            obstacle = obstacle.take().filter(|_| better.ii > bounds.min_ii());
            schedule = better;
        }
    };
    let steps = Limits {
        effort: options.exact_effort,
        stop: options.stop,
    };
    improve(&mut exact, steps);
    if let Some(beyond) = options.beyond {
        exact.extend(FARTHEST);
        let limits = Limits {
            effort: u64::MAX,
            stop: &beyond(),
        };
        improve(&mut exact, limits);
    }
    let impossible = exact.impossible(schedule.ii);
    Ok(Scheduled {
        schedule,
        bounds,
        obstacle,
        impossible,
    })
}

/// Where a certificate of impossibility is written.
pub struct Certificate<'a> {
    /// The formula, as DIMACS CNF.
    pub formula: &'a mut dyn Write,
    /// The proof that it cannot be satisfied, as DRAT (Wetzler, Heule and Hunt 2014).
    pub steps: &'a mut dyn Write,
}

/// Proves again that there is no schedule, and writes the certificate; false where `stop` came
/// first, it could not be written, or it is not so.
pub fn certify(
    dfg: &Dfg,
    arch: &Arch,
    claim: Impossible,
    stop: &(dyn Fn() -> bool + Sync),
    certificate: Certificate<'_>,
) -> bool {
    let Ok(live_ins) = live_in_registers(dfg, arch) else {
        return false;
    };
    let fixed: Vec<Reg> = live_ins.into_iter().chain(abi::reserved(arch)).collect();
    let question = exact::Question {
        ii: claim.ii,
        slack: claim.slack,
        conflicts: u64::MAX,
        effort: u64::MAX,
        seed: 0,
        fixed: &fixed,
        stop,
    };
    let (answer, _) = exact::solve(&Problem::new(dfg, arch), &question, Some(certificate));
    matches!(answer, Answer::Impossible)
}

/// Attempts at each II on the way up to the first that works.
const FIRST_ATTEMPTS: u32 = 4;
/// Attempts at each II on the way down from there.
const ATTEMPTS: u32 = 64;

/// Conflicts of the exact search's first question.
const FIRST_CONFLICTS: u64 = 1000;

/// The search over IIs.
struct Search<'a, 'p> {
    problem: &'a Problem<'p>,
    live_ins: &'a [Reg],
    fixed: Vec<Reg>,
    router: Router,
}

impl Search<'_, '_> {
    /// Goes up from the bound in growing steps, with few attempts each, until an II works; then
    /// down again with what is left of the effort, until one does not.
    fn run(
        &mut self,
        bound: u32,
        options: &Options<'_>,
    ) -> Result<(ModuloSchedule, Option<String>), String> {
        let effort = options.effort;
        let deepest = self.problem.arch.contexts;
        let mut obstacle = None;
        let mut ii = bound;
        let mut best = loop {
            if ii > deepest {
                return Err(match obstacle {
                    Some(obstacle) => format!("no II up to {deepest} was found: {obstacle}"),
                    None => format!("its II is at least {bound}; there are {deepest} contexts"),
                });
            }
            let share = self.router.expanded + effort / 8;
            match self.attempts(ii, FIRST_ATTEMPTS, share) {
                Ok(schedule) => break schedule,
                Err(worst) => obstacle = Some(describe(self.problem, ii, worst)),
            }
            ii += 1 + (ii - bound) / 3;
        };
        while best.ii > bound && !(options.stop)() {
            let ii = best.ii - 1;
            match self.attempts(ii, ATTEMPTS, effort) {
                Ok(schedule) => best = schedule,
                Err(worst) => return Ok((best, Some(describe(self.problem, ii, worst)))),
            }
        }
        Ok((best, None))
    }

    /// Looks for a schedule with a smaller II than `best` by the exact way. Every question is asked
    /// in rounds, each with more conflicts than the one before, so that a hard one does not keep
    /// the others waiting.
    fn exactly(&self, exact: &mut Exact, best: u32, limits: Limits<'_>) -> Option<ModuloSchedule> {
        let mut found: Option<ModuloSchedule> = None;
        let mut left = limits.effort;
        for round in 0.. {
            let share = FIRST_CONFLICTS.saturating_mul(2u64.saturating_pow(round));
            let open = exact.open(found.as_ref().map_or(best, |f| f.ii), round);
            if open.is_empty() && round > u32::BITS {
                break;
            }
            for Impossible { ii, slack } in open {
                if found.as_ref().is_some_and(|f| ii >= f.ii) {
                    break;
                }
                if left == 0 || (limits.stop)() {
                    return found;
                }
                let question = exact::Question {
                    ii,
                    slack,
                    conflicts: share,
                    effort: left,
                    seed: round,
                    fixed: &self.fixed,
                    stop: limits.stop,
                };
                let (answer, spent) = exact::solve(self.problem, &question, None);
                left -= spent.min(left);
                match answer {
                    Answer::Placed(placement) => {
                        let schedule = finish::finish(self.problem, &placement, self.live_ins);
                        if schedule.stages() <= MAX_STAGES {
                            found = Some(schedule);
                        } else {
                            exact.give_up(ii, slack);
                        }
                    }
                    Answer::Impossible => exact.prove(ii, slack),
                    Answer::Unknown => {}
                    Answer::TooLarge => exact.give_up(ii, slack),
                }
            }
        }
        found
    }

    /// Attempts at one II, at least one; what was in the way most often where none succeeds. What
    /// gave trouble in one attempt is placed earlier in the next (squeaky wheel optimisation,
    /// Joslin and Clements 1999).
    fn attempts(
        &mut self,
        ii: u32,
        attempts: u32,
        effort: u64,
    ) -> Result<ModuloSchedule, Option<Obstacle>> {
        let problem = self.problem;
        let freedom = Freedom::at(problem, ii);
        let mut trouble = EntityMap::filled(problem.dfg.nodes.len(), 0);
        let mut worst = None;
        for seed in 0..attempts {
            if seed > 0 && self.router.expanded >= effort {
                break;
            }
            let order = order(problem, &freedom, seed, &trouble);
            let mut attempt =
                Attempt::new(problem, ii, seed, &freedom, &self.fixed, &mut self.router);
            let result = attempt.run(&order);
            attempt.report(&mut trouble);
            match result {
                Ok(placement) => {
                    let schedule = finish::finish(problem, &placement, self.live_ins);
                    if schedule.stages() <= MAX_STAGES {
                        return Ok(schedule);
                    }
                }
                Err(obstacle) => worst = worst.or(obstacle),
            }
        }
        Err(worst)
    }
}

/// How far an exact search goes.
struct Limits<'a> {
    /// Steps.
    effort: u64,
    stop: &'a dyn Fn() -> bool,
}

/// What the exact way has found out about the IIs below a schedule's.
struct Exact {
    bound: u32,
    /// The longest horizon to ask about.
    slack: u32,
    /// The longest horizon of a proof, by II.
    proved: BTreeMap<u32, u32>,
    /// Horizons from which on there is no answer to be had, by II.
    hopeless: BTreeMap<u32, u32>,
}

impl Exact {
    fn new(bound: u32, slack: u32) -> Exact {
        Exact {
            bound,
            slack,
            proved: BTreeMap::new(),
            hopeless: BTreeMap::new(),
        }
    }

    fn extend(&mut self, slack: u32) {
        self.slack = slack.max(self.slack);
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
    fn impossible(&self, below: u32) -> Vec<Impossible> {
        let proved = self.proved.range(..below);
        proved
            .map(|(&ii, &slack)| Impossible { ii, slack })
            .collect()
    }
}

/// The central registers that bring the live-ins.
fn live_in_registers(dfg: &Dfg, arch: &Arch) -> Result<Vec<Reg>, Unschedulable> {
    let registers = abi::passing(arch, dfg.live_ins.iter().map(|l| l.ty));
    registers
        .into_iter()
        .collect::<Option<Vec<Reg>>>()
        .ok_or_else(|| Unschedulable {
            node: None,
            why: format!(
                "its {} live-in values do not fit in the central registers",
                dfg.live_ins.len()
            ),
        })
}

/// An obstacle in words.
fn describe(problem: &Problem<'_>, ii: u32, obstacle: Option<Obstacle>) -> String {
    let name = |n: Node| {
        let data = &problem.dfg.nodes[n];
        format!("`{}` of line {}", data.op, data.pos.line)
    };
    let what = match obstacle {
        None => "attempts ran out".to_owned(),
        Some(Obstacle::Unit(node)) => format!("no unit is free for {}", name(node)),
        Some(Obstacle::Registers(place)) => {
            format!(
                "the registers of {} do not suffice",
                problem.graph.name(problem.arch, place)
            )
        }
        Some(Obstacle::Route(e)) => {
            let edge = &problem.edges[e];
            match edge.goal {
                Goal::Operand(to, _) => {
                    format!("no route from {} to {}", name(edge.from), name(to))
                }
                Goal::LiveOut(_) => {
                    format!("no route from {} to a central register", name(edge.from))
                }
            }
        }
    };
    format!("at II = {ii}, {what}")
}
