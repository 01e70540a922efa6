//! Scheduling by negotiation on arrays of units alike, as other mappers know them: the fast way for large graphs.
//!
//! It is [`negotiate`](super::negotiate) where all is simple. Every operation and move takes one cycle, so that the
//! issue slot of a unit and its output in the next cycle are one good: an array is nothing but slots and
//! registers ([`array`]). Deliveries to all units in a cycle are then a few sums and minima of vectors
//! ([`delivery`]), values are trees of points ([`state`]), and a step takes one or two microseconds where it takes
//! ten to thirty there.
//!
//! A step takes a node out with all its ways, draws a new position from the costs of all ([`survey`]), routes for real,
//! and keeps that or goes back (*heat bath*; Geman and Geman 1984). What is taken too often grows dearer
//! ([`prices`]) as the temperature falls. Few conflicts that are left in the end are mended ([`mend`]). Nodes keep within a horizon somewhat longer than the longest path, as
//! values that live long take the registers of many iterations. All numbers are integers, so that every host
//! agrees.

mod array;
mod delivery;
mod mend;
mod prices;
mod spread;
mod state;
mod step;
mod survey;
mod trace;

use super::noise::noise;
use super::order::Freedom;
use super::place::{self, Conflict, Placement};
use super::problem::Problem;
use super::rows::{NEVER, wide};
use super::start;
pub(in crate::modulo) use array::Array;
use srp_archdesc::Watch;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::resource::Place;
use srp_ir::dfg::Node;
use srp_ir::dre::scheduled::Reg;
use state::State;
use survey::{Horizon, Survey};

/// The cost of what cannot be.
const FAR: i32 = NEVER as i32 * 64;

/// Stages of one temperature each.
const STAGES: i32 = 100;
/// How runs go about it, in turn, as graphs differ in what they yield to: deep ones to few changes at a time, those
/// with values of many consumers to many. What gathers nodes in hot first stages at a small penalty is never undone, so
/// that both begin not far from where they end.
const MANNERS: [Manner; 2] = [
    Manner {
        half: (499, 333),
        penalty: (30, 200),
        links: 0,
    },
    Manner {
        half: (887, 444),
        penalty: (60, 300),
        links: 3,
    },
];
/// The stages after which a run is given up that has not had fewer conflicts for so many: it is frozen.
const COLD: i32 = 40;
const FROZEN: i32 = 12;
/// The stage from which a run is given up if half of the nodes are in conflict.
const HOPELESS: i32 = 33;

/// Nodes in conflict at the end of a run up to which it is mended, and the stages that this takes at most.
const MENDABLE: usize = 12;
const MENDING: i32 = 60;

/// Costs of a net without a way: the cost beyond the penalty, the rise for good in each stage, and the most of it.
const OPEN: i32 = 900;
const OPEN_RISE: i32 = 40;
const MOST_OPEN: i32 = 6000;
/// The cost of each cycle by which the ends of a net are too near to each other.
const LATE: Late = Late { each: 40, most: 60 };
/// The cost of each cycle by which a memory order is not kept.
const EARLY: i32 = 40;

/// Steps in a hundred that take a node in conflict, as long as some are.
const IN_CONFLICT: u32 = 25;
/// Steps from one count of conflicts to the next.
const COUNTED: u64 = 64;

/// Cycles that a value has more than it needs at the start.
const ROOM: i32 = 1;
/// By how many IIs the horizon is longer than the schedule at the start, by rounds of all manners.
const SLACKS: [i32; 2] = [3, 4];

/// Lanes of rows, and parts of a step, that take as long as a step of the router.
const LANES_PER_STEP: u64 = 250;
const STEPS_PER_STEP: u64 = 4;

/// How a run goes about it: temperature and price of overuse in the first stage and in the last, and moves in a step.
struct Manner {
    /// By how many 16ths a cost has to rise to be half as likely: an issue slot costs 16. It falls in a line.
    half: (i32, i32),
    /// The price of a use beyond what there is. It rises with the square of the stage.
    penalty: (i32, i32),
    /// The most nodes and values that move on for the one that a step moves.
    links: usize,
}

impl Manner {
    const LAST: i32 = STAGES - 1;

    fn half(&self, stage: i32) -> i32 {
        self.half.0 + (self.half.1 - self.half.0) * stage / Manner::LAST
    }

    fn penalty(&self, stage: i32) -> i32 {
        let (first, last) = self.penalty;
        first + (last - first) * stage * stage / (Manner::LAST * Manner::LAST)
    }
}

/// The cost of too little time for a way.
struct Late {
    each: i32,
    /// Cycles after which it rises no more.
    most: i32,
}

impl Late {
    fn of(&self, cycles: i32) -> i32 {
        self.each * cycles.clamp(0, self.most)
    }
}

/// A run at one II.
pub(super) struct Search<'a, 'p> {
    problem: &'a Problem<'p>,
    freedom: &'a Freedom,
    fixed: &'a [Reg],
    state: State<'a, 'p>,
    survey: Survey,
    horizon: Horizon,
    manner: &'static Manner,
    seed: u64,
    draws: u64,
    /// Nodes in conflict when they were counted last.
    conflicts: Vec<Node>,
    /// Lists that every step uses again.
    to_route: Vec<usize>,
    clashes: Vec<(usize, Node)>,
    moved: Vec<Node>,
    steps: u64,
}

impl<'a, 'p> Search<'a, 'p> {
    /// Puts every node somewhere.
    pub(super) fn new(
        problem: &'a Problem<'p>,
        array: &'a Array,
        ii: u32,
        freedom: &'a Freedom,
        fixed: &'a [Reg],
        seed: u32,
    ) -> Search<'a, 'p> {
        let times = start::times(problem, ii, ROOM);
        let mut search = Search {
            state: State::new(problem, array, ii),
            survey: Survey::default(),
            horizon: horizon(freedom, &times, ii, seed),
            manner: &MANNERS[seed as usize % MANNERS.len()],
            problem,
            freedom,
            fixed,
            seed: u64::from(seed),
            draws: 0,
            conflicts: Vec::new(),
            to_route: Vec::new(),
            clashes: Vec::new(),
            moved: Vec::new(),
            steps: 0,
        };
        let units = spread::units(problem, array, &times, ii, seed);
        for node in problem.nodes() {
            search.state.put(node, (units[node], times[node]));
        }
        search.state.commit();
        search
    }

    fn random(&mut self) -> u32 {
        self.draws += 1;
        noise(self.seed, self.draws, 0x1a77)
    }

    /// A number below `below`.
    fn below(&mut self, below: u32) -> u32 {
        ((u64::from(self.random()) * u64::from(below)) >> 32) as u32
    }

    /// Runs from hot to cold with so many steps for each node.
    /// Ends early when so much effort has been spent ([`effort`](Self::effort)), or nothing moves any more.
    pub(super) fn run(
        &mut self,
        steps: u64,
        limit: u64,
        watch: &dyn Watch,
    ) -> Result<Placement, Option<Conflict>> {
        let nodes = self.problem.dfg.nodes.len() as u64;
        let each = (nodes * steps).div_ceil(STAGES as u64).max(1);
        let manner = self.manner;
        let (mut fewest, mut since) = (usize::MAX, 0);
        for stage in 0..STAGES {
            self.reprice(manner.penalty(stage));
            for step in 0..each {
                if step % COUNTED == 0 {
                    self.find_conflicts();
                    if let Some(placement) = self.settled() {
                        return Ok(placement);
                    }
                    if watch.cancelled() || self.effort() > limit {
                        return Err(self.worst());
                    }
                }
                self.step(manner.half(stage));
            }
            since += 1;
            if self.conflicts.len() < fewest {
                (fewest, since) = (self.conflicts.len(), 0);
            }
            let many = self.conflicts.len() * 2 > nodes as usize;
            if stage >= COLD && since >= FROZEN || stage >= HOPELESS && many {
                break;
            }
        }
        self.find_conflicts();
        if self.conflicts.len() <= MENDABLE {
            let found = self.mend(manner, each, limit, watch);
            return found.ok_or_else(|| self.worst());
        }
        self.settled().ok_or_else(|| self.worst())
    }

    /// Raises the prices for a stage.
    fn reprice(&mut self, penalty: i32) {
        self.state.prices.reprice(penalty);
        for net in 0..self.state.nets.len() {
            if self.state.ways[net].is_none() {
                let history = &mut self.state.open_history[net];
                *history = (*history + OPEN_RISE).min(MOST_OPEN);
            }
        }
    }

    /// The placement, if nothing is in conflict any more. A file whose registers do not suffice after all counts as
    /// smaller from then on.
    fn settled(&mut self) -> Option<Placement> {
        if !self.state.is_free_of_conflicts() {
            return None;
        }
        match self.settle() {
            Ok(placement) => Some(placement),
            Err(full) => {
                let files = self.state.array.files.iter().enumerate();
                for (lane, file) in files {
                    if file.is_some_and(|(file, _)| full.contains(&file)) {
                        self.state.prices.shrink(lane as u16);
                    }
                }
                None
            }
        }
    }

    /// The placement, or the files whose registers do not suffice after all.
    fn settle(&self) -> Result<Placement, Vec<Place>> {
        let (ii, state) = (self.state.ii as u32, &self.state);
        let routes = state.routes();
        place::adopt(
            self.problem,
            ii,
            self.freedom,
            self.fixed,
            &state.at,
            routes,
        )
    }

    /// Returns the first conflict: an edge without a route, or a node on an overused resource.
    fn worst(&self) -> Option<Conflict> {
        let open = self.state.ways.iter().position(Option::is_none);
        let open = open.map(|net| Conflict::Route(self.state.nets[net].edges[0]));
        open.or_else(|| self.conflicts.first().map(|&node| Conflict::Unit(node)))
    }

    /// The effort so far, in steps of the router that take as long.
    pub(super) fn effort(&self) -> u64 {
        self.survey.work / LANES_PER_STEP + self.steps * STEPS_PER_STEP
    }

    /// The effort of a step so far.
    pub(super) fn effort_of_step(&self) -> u64 {
        self.effort().div_ceil(self.steps.max(1))
    }

    fn find_conflicts(&mut self) {
        self.conflicts.clear();
        if !self.state.is_free_of_conflicts() {
            let nodes = self.problem.nodes();
            let state = &self.state;
            let nodes = nodes.filter(|&node| state.is_in_conflict(node));
            self.conflicts.extend(nodes);
        }
    }

    /// Routes a net whose ends are placed, and takes the way where it costs less than none; returns what that costs.
    fn route(&mut self, net: usize) -> i32 {
        let open = self.state.price_of_open(net);
        let (state, map) = (&self.state, &mut self.survey.map);
        let ends = &state.nets[net];
        let (ready, read) = state.ends(ends);
        if read < ready {
            return open;
        }
        let tree = &state.trees[ends.from];
        wide!(map.forward(state.array, &state.prices, tree, (ready, read))
            => map.forward_wide(state.array, &state.prices, tree, (ready, read)));
        self.survey.work += map.work();
        let (unit, _) = state.place(ends.to);
        if i32::from(map.read(read, unit)) >= open {
            return open;
        }
        let way = self.state.trace(net, &self.survey.map);
        self.state.take(net, way)
    }
}

/// An II that is likely to be found, by the hops of values between nodes that are spread over the array. Two of
/// three hops of a value are on the way to one consumer only.
pub(super) fn likely_ii(problem: &Problem<'_>, array: &Array, bound: u32) -> u32 {
    let times = start::times(problem, bound, ROOM);
    let units = spread::units(problem, array, &times, bound, 0);
    let hops = spread::hops(problem, array, &units);
    let slots = problem.dfg.nodes.len() as u64 + hops * 2 / 3;
    slots.div_ceil(problem.srp.fus.len() as u64) as u32
}

/// The cycles in which nodes may be: as early as all could be, and some IIs later than they begin at.
fn horizon(freedom: &Freedom, times: &EntityMap<Node, i32>, ii: u32, seed: u32) -> Horizon {
    let end = |times: &EntityMap<Node, i32>| times.values().copied().max().unwrap_or(0);
    let slack = SLACKS[seed as usize / MANNERS.len() % SLACKS.len()] * ii as i32;
    let later = (end(times) - end(&freedom.earliest)).max(0) + slack;
    let latest = freedom.latest.values().map(|&latest| latest + later);
    Horizon {
        earliest: freedom.earliest.clone(),
        latest: latest.collect(),
    }
}
