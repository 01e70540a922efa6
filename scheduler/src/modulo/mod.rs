//! Modulo scheduling of kernels onto the array: where and when each operation of a loop runs, and
//! over which links and registers its values travel, so that an iteration starts every II cycles.
//!
//! [`bounds`] says which II cannot be beaten; from there up, [`place`] makes attempts that differ in
//! the order of nodes and in noise, until one succeeds. The result is data; `check` tells whether it is right.

mod bounds;
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
use order::{Freedom, order};
use place::{Attempt, Obstacle};
use problem::{Goal, Problem};
use route::Router;
use srp_archdesc::arch::Arch;
use srp_archdesc::entity::EntityMap;
use srp_ir::dfg::{Dfg, Node};
use srp_ir::dre::scheduled::{ModuloSchedule, Reg};

/// How hard to try.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Steps of the router over all attempts at one loop, about 3 million a second. The first II
    /// that works is looked for beyond them.
    pub effort: u64,
}

impl Default for Options {
    fn default() -> Self {
        Options { effort: 5_000_000 }
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
pub fn schedule(dfg: &Dfg, arch: &Arch, options: &Options) -> Result<Scheduled, Unschedulable> {
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
    match search.run(bounds.min_ii(), options.effort) {
        Ok((schedule, obstacle)) => Ok(Scheduled {
            schedule,
            bounds,
            obstacle,
        }),
        Err(why) => Err(Unschedulable { node: None, why }),
    }
}

/// Attempts at each II on the way up to the first that works.
const FIRST_ATTEMPTS: u32 = 4;
/// Attempts at each II on the way down from there.
const ATTEMPTS: u32 = 64;

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
    fn run(&mut self, bound: u32, effort: u64) -> Result<(ModuloSchedule, Option<String>), String> {
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
        while best.ii > bound {
            let ii = best.ii - 1;
            match self.attempts(ii, ATTEMPTS, effort) {
                Ok(schedule) => best = schedule,
                Err(worst) => return Ok((best, Some(describe(self.problem, ii, worst)))),
            }
        }
        Ok((best, None))
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
