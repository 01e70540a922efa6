//! Modulo scheduling of kernels onto the array: where and when each operation of a loop runs, and
//! over which links and registers its values travel, so that an iteration starts every II cycles.
//!
//! [`bounds`] says which II cannot be beaten; from there up, [`place`] makes attempts that differ in
//! the order of nodes and in noise, until one succeeds and its values find registers
//! ([`registers`]). The result is data; `check` tells whether it is right.

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
use place::{Attempt, Obstacle};
use problem::{Goal, Problem};
use srp_archdesc::arch::Arch;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::resource::Place;
use srp_ir::dfg::{Dfg, Node};
use srp_ir::dre::scheduled::{ModuloSchedule, Reg};
use std::ops::Range;

/// How hard to try.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Attempts at each II on the way up to the first that works.
    pub first_attempts: u32,
    /// Attempts at each II on the way down from there.
    pub attempts: u32,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            first_attempts: 4,
            attempts: 24,
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
    let search = Search {
        problem: &problem,
        live_ins: &live_ins,
        options,
    };
    match search.run(bounds.min_ii()) {
        Ok((schedule, obstacle)) => Ok(Scheduled {
            schedule,
            bounds,
            obstacle,
        }),
        Err(why) => Err(Unschedulable { node: None, why }),
    }
}

/// Units times nodes up to which all attempts are made; beyond, fewer in proportion, because each
/// takes longer.
const FULL_EFFORT: u32 = 2400;

/// The search over IIs.
struct Search<'a, 'p> {
    problem: &'a Problem<'p>,
    live_ins: &'a [Reg],
    options: &'a Options,
}

impl Search<'_, '_> {
    /// Goes up from the bound in growing steps, with few attempts each, until an II works; then
    /// down again with many, until one does not.
    fn run(&self, bound: u32) -> Result<(ModuloSchedule, Option<String>), String> {
        let size = (self.problem.arch.fus.len() * self.problem.dfg.nodes.len()).max(1) as u32;
        let affordable = |attempts: u32| (attempts * FULL_EFFORT / size).clamp(1, attempts.max(1));
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
            match self.attempts(ii, 0..affordable(self.options.first_attempts)) {
                Ok(schedule) => break schedule,
                Err(worst) => obstacle = Some(describe(self.problem, ii, worst)),
            }
            ii += 1 + (ii - bound) / 3;
        };
        while best.ii > bound {
            let ii = best.ii - 1;
            match self.attempts(ii, 0..affordable(self.options.attempts)) {
                Ok(schedule) => best = schedule,
                Err(worst) => return Ok((best, Some(describe(self.problem, ii, worst)))),
            }
        }
        Ok((best, None))
    }

    /// Attempts at one II; what was in the way most often where none succeeds.
    fn attempts(&self, ii: u32, seeds: Range<u32>) -> Result<ModuloSchedule, Option<Obstacle>> {
        let problem = self.problem;
        let mut history: EntityMap<Place, u32> = EntityMap::filled(problem.graph.places.len(), 0);
        let mut worst = None;
        for seed in seeds {
            let placement = match Attempt::new(problem, ii, seed, &history).run() {
                Ok(placement) => placement,
                Err(obstacle) => {
                    worst = worst.or(obstacle);
                    continue;
                }
            };
            match finish::finish(problem, &placement, self.live_ins) {
                Ok(schedule) => {
                    let contexts = schedule.contexts();
                    if contexts <= problem.arch.contexts && schedule.stages() <= MAX_STAGES {
                        return Ok(schedule);
                    }
                }
                Err(place) => {
                    history[place] += 8;
                    worst = Some(Obstacle::Registers(place));
                }
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
