//! Scheduling by negotiation: units, cycles and routes of a loop all at once, where everything may be
//! taken too often at a price that rises until nothing is.
//!
//! Every node has a place and most values have routes from the start, although they are in each
//! other's way. A step takes a node and all its values out, computes the cost of delivering its operands to,
//! and its result from, every unit in every cycle of a window ([`deliver`]), draws one of these positions
//! with a probability that falls with its cost (*heat bath*; Metropolis et al. 1953, Geman and Geman
//! 1984), routes for real, and keeps that or goes back. What is taken too often grows dearer
//! ([`market`]), as the temperature falls. All numbers are integers, so that every host agrees.
//!
//! The last conflicts are those that no step mends by itself. Two kinds are mended by many nodes at once: an operation that is
//! issued before its operand is ready is moved with all that follow or precede it ([`push`]), and where operations fill a unit that
//! they hold for several cycles, none begins between two of the others ([`tiles`]).

mod deliver;
mod lanes;
mod market;
mod push;
mod shorten;
mod state;
mod survey;
mod tiles;
mod trace;

use super::noise::noise;
use super::order::Freedom;
use super::place::{self, Conflict, Placement};
use super::problem::{Position, Problem};
use super::route::Route;
use super::scale::Scale;
use super::start;
pub(in crate::modulo) use lanes::Lanes;
use market::Good;
use srp_archdesc::Watch;
use srp_archdesc::entity::Entity;
use srp_archdesc::resource::Place;
use srp_ir::dfg::Node;
use srp_ir::dre::scheduled::Reg;
use state::{Path, State};
use survey::Survey;

/// Stages of one temperature each.
const STAGES: u32 = 40;
/// By how many 16ths a cost has to rise to be half as likely, in the first stage: a move costs 64.
/// Each stage has so many 65536ths of the one before.
const HALF: u32 = 1220;
const COOLING: u32 = 62_740;
/// Stages beyond these while few nodes are in conflict, and how few.
const MORE_STAGES: u32 = 40;
const FEW: usize = 12;
/// Stages without one conflict less after which a run is frozen, and more of them where hardly a node is in
/// conflict, so that rising prices may still tell; the stage that a frozen run goes back to.
const FROZEN: u32 = 4;
const NEARLY: usize = 4;
const NEARLY_FROZEN: u32 = 12;
const REHEATED: u32 = 14;
/// How few nodes are in conflict where chains of operations are moved ([`push`](Negotiation::push)).
const FEW_TO_PUSH: usize = 8;
/// How many nodes of a thousand may be in conflict after some stages: of 430 runs at 33 loops and IIs these bounds
/// end 137 of the 261 that fail, which are a quarter of all work, and 4 of the 169 others.
const HOPELESS: [(u32, usize); 3] = [(12, 300), (16, 130), (20, 92)];
/// The price of a use beyond the capacity in the first stage and in the last.
const PENALTY: (i32, i32) = (10, 800);
/// The rise for good of the price of an overused resource, at the beginning of each stage, and while hardly a node is in
/// conflict whenever conflicts are counted.
const HISTORY: i16 = 12;

/// Costs of an edge without a route: the cost beyond the penalty, larger than that of any route
/// with a little overuse; the rise for good, as often; and the cost of each cycle by which the
/// edge is too short for a route.
const OPEN: i32 = 900;
const OPEN_HISTORY: i32 = 40;
const MOST_OPEN: i32 = 4000;
const LATE: i32 = 40;
const MOST_LATE: i32 = 60;

/// Amounts of work that take as long as a step of the router: lanes of rows of costs, and a part of
/// a step.
const LANES_PER_STEP: u64 = 500;
const STEPS_PER_STEP: u64 = 20;

/// Cycles that a value has more than it needs at the start.
const ROOM: i32 = 1;

/// Steps between two counts of the conflicts.
const COUNTED: u64 = 64;

/// Steps in a hundred that take a node in conflict, as long as some are. Of the others, where hardly a node is, those
/// that take a neighbour of such a node.
const IN_CONFLICT: u32 = 50;
const NEXT_TO_CONFLICT: u32 = 50;
/// Steps in a hundred that leave a node as it is where it was drawn to its own place and is in no
/// conflict; the others route it again.
const AS_IT_IS: u32 = 85;

/// Returns the cost of violating a memory order by so many cycles.
fn price_of_early(cycles: i64) -> i64 {
    match cycles {
        0 => 0,
        _ => i64::from(OPEN) + i64::from(LATE) * cycles,
    }
}

/// How far a run has cooled down. A run in which no conflict has gone for some stages is frozen, and goes on
/// from a higher temperature, where all is cheaper but for what it has learned.
struct Cooling {
    /// The stage, which sets the prices, and the costs in it by how many 256ths of a 16th are half as likely.
    stage: u32,
    half: u32,
    /// The fewest nodes in conflict since it was hot, and the stages since then.
    fewest: usize,
    since: u32,
}

impl Default for Cooling {
    fn default() -> Cooling {
        Cooling {
            stage: 0,
            half: HALF << 8,
            fewest: usize::MAX,
            since: 0,
        }
    }
}

impl Cooling {
    /// Goes to the next stage after one that left so many nodes in conflict.
    fn go_on(&mut self, conflicts: usize) {
        self.since += 1;
        if conflicts < self.fewest {
            self.fewest = conflicts;
            self.since = 0;
        }
        let patience = match conflicts {
            0..=NEARLY => NEARLY_FROZEN,
            _ => FROZEN,
        };
        if self.since >= patience && self.stage > REHEATED {
            *self = Cooling::default();
            (0..REHEATED).for_each(|_| self.cool());
        } else if self.stage + 1 < STAGES {
            self.cool();
        }
    }

    fn cool(&mut self) {
        self.stage += 1;
        self.half = ((u64::from(self.half) * u64::from(COOLING)) >> 16) as u32;
    }
}

/// A run at one II.
pub(super) struct Negotiation<'a, 'p> {
    problem: &'a Problem<'p>,
    freedom: &'a Freedom,
    fixed: &'a [Reg],
    state: State<'a, 'p>,
    survey: Survey,
    seed: u64,
    draws: u64,
    open_history: Vec<i32>,
    /// The price of a use beyond the capacity in this stage.
    penalty: i32,
    /// Nodes in conflict when they were counted last.
    conflicts: Vec<Node>,
    /// Lists that every step uses again: the routes that a node was taken out with, its edges by how far apart
    /// their ends are, and what a node takes.
    taken_out: Vec<(usize, Path)>,
    by_span: Vec<(i32, usize)>,
    goods: Vec<Good>,
    /// Steps so far.
    steps: u64,
    /// True when the run was given up for its conflicts.
    pub(super) is_hopeless: bool,
}

impl<'a, 'p> Negotiation<'a, 'p> {
    pub(super) fn new(
        problem: &'a Problem<'p>,
        lanes: &'a Lanes,
        ii: u32,
        freedom: &'a Freedom,
        fixed: &'a [Reg],
        seed: u32,
    ) -> Negotiation<'a, 'p> {
        let mut run = Negotiation::empty(problem, lanes, ii, freedom, fixed, seed);
        run.state.tiles = tiles::tiles(problem, ii, seed);
        let earliest = start::times(problem, ii, ROOM);
        for node in problem.nodes() {
            let units = &problem.units[node];
            let fits = |fu: &&srp_archdesc::arch::Fu| problem.timing(node, **fu).interval <= ii;
            let fitting: Vec<_> = units.iter().filter(fits).copied().collect();
            let Some(&unit) = fitting.get(run.below(fitting.len().max(1) as u32) as usize) else {
                continue;
            };
            run.state.put(node, (unit, earliest[node]));
        }
        run
    }

    /// A run in which no node has a place yet.
    fn empty(
        problem: &'a Problem<'p>,
        lanes: &'a Lanes,
        ii: u32,
        freedom: &'a Freedom,
        fixed: &'a [Reg],
        seed: u32,
    ) -> Negotiation<'a, 'p> {
        let state = State::new(problem, lanes, ii, fixed);
        Negotiation {
            survey: Survey::new(&state, OPEN),
            state,
            problem,
            freedom,
            fixed,
            seed: u64::from(seed),
            draws: 0,
            open_history: vec![0; problem.edges.len()],
            penalty: PENALTY.0,
            conflicts: Vec::new(),
            taken_out: Vec::new(),
            by_span: Vec::new(),
            goods: Vec::new(),
            steps: 0,
            is_hopeless: false,
        }
    }

    fn random(&mut self) -> u32 {
        self.draws += 1;
        noise(self.seed, self.draws, 0x4e67)
    }

    /// A number below `below`.
    fn below(&mut self, below: u32) -> u32 {
        ((u64::from(self.random()) * u64::from(below)) >> 32) as u32
    }

    /// Runs from hot to cold with so many steps for each node.
    /// Ends early when so much effort has been spent ([`effort`](Self::effort)).
    pub(super) fn run(
        &mut self,
        steps: u64,
        limit: u64,
        watch: &dyn Watch,
    ) -> Result<Placement, Option<Conflict>> {
        self.cool_down(Cooling::default(), steps, limit, watch)
    }

    /// The same from a temperature on.
    fn cool_down(
        &mut self,
        mut cooling: Cooling,
        steps: u64,
        limit: u64,
        watch: &dyn Watch,
    ) -> Result<Placement, Option<Conflict>> {
        let nodes = self.problem.dfg.nodes.len() as u64;
        let each = (nodes * steps).div_ceil(u64::from(STAGES)).max(1);
        for stage in 0..STAGES + MORE_STAGES {
            if stage >= STAGES && self.conflicts.len() > FEW {
                break;
            }
            self.reprice(cooling.stage);
            let half = cooling.half as i32 >> 8;
            for step in 0..each {
                if step % COUNTED == 0 {
                    self.find_conflicts();
                    if let Some(placement) = self.settled() {
                        return Ok(placement);
                    }
                    if watch.cancelled() || self.effort() > limit {
                        return Err(self.worst());
                    }
                    if self.conflicts.len() <= FEW_TO_PUSH {
                        self.push(half);
                    }
                    if step > 0 && (1..=NEARLY).contains(&self.conflicts.len()) {
                        self.remember();
                    }
                }
                self.step(half);
            }
            if self.has_too_many_conflicts(stage) {
                self.is_hopeless = true;
                break;
            }
            cooling.go_on(self.conflicts.len());
        }
        self.settled().ok_or_else(|| self.worst())
    }

    /// True when so many nodes are in conflict after a stage that runs hardly ever recover.
    fn has_too_many_conflicts(&self, stage: u32) -> bool {
        let nodes = self.problem.dfg.nodes.len();
        let few = HOPELESS.iter().find(|&&(after, _)| after == stage);
        few.is_some_and(|&(_, few)| self.conflicts.len() * 1000 > nodes * few)
    }

    /// Raises the prices for a stage.
    fn reprice(&mut self, stage: u32) {
        let (part, whole) = (stage as i32, STAGES as i32 - 1);
        self.penalty = PENALTY.0 + (PENALTY.1 - PENALTY.0) * part * part / (whole * whole);
        self.state.market.reprice(self.penalty as i16);
        self.remember();
    }

    /// Raises the prices of what is in conflict for good.
    fn remember(&mut self) {
        self.state.market.remember(HISTORY);
        for (e, history) in self.open_history.iter_mut().enumerate() {
            if self.state.routes[e].is_none() {
                *history += OPEN_HISTORY;
            }
            self.survey.open[e] = (OPEN + self.penalty + *history).min(MOST_OPEN);
        }
    }

    /// The placement, if nothing is in conflict any more. A file whose registers do not suffice after
    /// all counts as smaller from then on.
    fn settled(&mut self) -> Option<Placement> {
        if self.state.market.excess > 0 || self.state.open > 0 || self.state.early > 0 {
            return None;
        }
        match self.settle() {
            Ok(placement) => {
                debug_assert!(self.is_in_time(&placement));
                Some(placement)
            }
            Err(full) => {
                for place in full {
                    self.state.market.shrink(self.state.lanes.of[place]);
                }
                None
            }
        }
    }

    /// Returns the first conflict: an edge without a route, or a node on an overused resource.
    fn worst(&self) -> Option<Conflict> {
        let open = self.state.routes.iter().position(Option::is_none);
        let node = || self.conflicts.first().copied();
        open.map(Conflict::Route)
            .or_else(|| node().map(Conflict::Unit))
    }

    /// The effort so far, in steps of the router that take as long.
    pub(super) fn effort(&self) -> u64 {
        self.survey.lanes / LANES_PER_STEP + self.steps * STEPS_PER_STEP
    }

    fn find_conflicts(&mut self) {
        let (state, goods) = (&self.state, &mut self.goods);
        self.conflicts.clear();
        let nodes = self.problem.nodes();
        self.conflicts
            .extend(nodes.filter(|&node| state.is_in_conflict(node, goods)));
    }

    /// The placement, or the file of each route whose registers do not suffice after all.
    fn settle(&self) -> Result<Placement, Vec<Place>> {
        let routes = self.state.routes.iter();
        let routes: Option<Vec<Route>> = routes.map(|path| Some(path.as_ref()?.route())).collect();
        let routes = routes.expect("no edge is open");
        place::adopt(
            self.problem,
            self.state.ii as u32,
            self.freedom,
            self.fixed,
            &self.state.at,
            routes,
        )
    }

    /// Takes a node out, and puts it where it is drawn to, or back.
    fn step(&mut self, half: i32) {
        self.steps += 1;
        let any = self.conflicts.is_empty() || self.below(100) >= IN_CONFLICT;
        let node = match any {
            true => self.any_node(),
            false => self.node_in_conflict(),
        };
        let old = self.state.at[node];
        let old_cost = self.take_out(node);
        let random = self.random();
        let within = self.within(node);
        self.survey.look(&self.state, node, within, random);
        let random = self.random();
        let drawn = self.survey.draw(half, random);
        let Some(new) = drawn else {
            self.put_back(node, old);
            return;
        };
        if new == old && any && self.below(100) < AS_IT_IS {
            self.put_back(node, old);
            return;
        }
        let new_cost = self.put_in(node, new);
        let random = self.random();
        if Scale::of(half).accepts(new_cost - old_cost, random) {
            let dropped = self.taken_out.drain(..);
            dropped.for_each(|(_, path)| self.state.drop_list(path.items));
            return;
        }
        for i in 0..self.problem.edges_of[node].len() {
            if let Some((path, _)) = self.state.release(self.problem.edges_of[node][i]) {
                self.state.drop_list(path.items);
            }
        }
        self.state.lift(node);
        self.put_back(node, old);
    }

    /// A node in conflict; there are some.
    fn node_in_conflict(&mut self) -> Node {
        let i = self.below(self.conflicts.len() as u32);
        self.conflicts[i as usize]
    }

    /// Any node; where hardly any are in conflict, more often one of their neighbours than the others.
    fn any_node(&mut self) -> Node {
        let hardly = !self.conflicts.is_empty() && self.conflicts.len() <= NEARLY;
        if hardly && self.below(100) < NEXT_TO_CONFLICT {
            let node = self.node_in_conflict();
            let edges = &self.problem.edges_of[node];
            let drawn = self.below(edges.len().max(1) as u32) as usize;
            let Some(&e) = edges.get(drawn) else {
                return node;
            };
            let edge = &self.problem.edges[e];
            return match edge.from == node {
                true => edge.to().unwrap_or(node),
                false => edge.from,
            };
        }
        Node::new(self.below(self.problem.dfg.nodes.len() as u32) as usize)
    }

    /// The cycles in which a node has to lie, if there is a deadline.
    fn within(&self, node: Node) -> Option<(i32, i32)> {
        let freedom = || (self.freedom.earliest[node], self.freedom.latest[node]);
        self.state.deadline.map(|_| freedom())
    }

    /// Takes out a node and the routes of its edges, which it keeps in `taken_out`; returns their cost.
    fn take_out(&mut self, node: Node) -> i32 {
        let mut cost = 0;
        for i in 0..self.problem.edges_of[node].len() {
            let e = self.problem.edges_of[node][i];
            match self.state.release(e) {
                Some((route, price)) => {
                    cost += price;
                    self.taken_out.push((e, route));
                }
                None => cost += self.survey.price_of_open(&self.state, e),
            }
        }
        cost += price_of_early(self.state.earliness(node)) as i32;
        cost += self.state.lift(node);
        cost
    }

    /// Puts a node back with the routes that it was taken out with.
    fn put_back(&mut self, node: Node, old: Position) {
        self.state.put(node, old);
        for (e, route) in self.taken_out.drain(..) {
            self.state.take(e, route);
        }
    }

    /// Puts a node somewhere and routes its edges; returns the cost.
    fn put_in(&mut self, node: Node, at: Position) -> i32 {
        let mut cost = self.state.put(node, at);
        cost += price_of_early(self.state.earliness(node)) as i32;
        let mut edges = std::mem::take(&mut self.by_span);
        edges.clear();
        for &e in &self.problem.edges_of[node] {
            let edge = &self.problem.edges[e];
            let span = match edge.to() {
                Some(to) => {
                    let arrival = self.state.at[to].1 + self.state.ii * edge.distance as i32;
                    arrival - self.state.ready(edge.from)
                }
                None => i32::MAX,
            };
            edges.push((span, e));
        }
        edges.sort_unstable();
        for &(_, e) in &edges {
            cost += self.survey.route(&mut self.state, e);
        }
        self.by_span = edges;
        cost
    }
}
