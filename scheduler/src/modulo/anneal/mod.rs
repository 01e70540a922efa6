//! Placement by simulated annealing: units and cycles for all nodes at once. The price of a
//! placement is a lower bound on the costs of its routes, as if each route were alone.
//!
//! Placing one node after the other is quick, but it fills a crowded array with nodes whose
//! neighbours then have to stay far away. Here every node moves until the whole is good (Kirkpatrick
//! et al. 1983; of mappers, DRESC, Mei et al. 2002). An estimate takes the place of the router,
//! which makes a move some hundred times cheaper; [`place`](super::place) then routes for real,
//! and places again what fails. All arithmetic is in integers, so that every host agrees.

mod crowding;
mod price;
mod propose;
mod slots;
mod stage;
mod ways;

use super::noise::noise;
use super::order::Freedom;
use super::problem::{Position, Problem};
use crowding::capacity;
use srp_archdesc::arch::{Fu, Resource};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::Ty;
use srp_archdesc::resource::Place;
use srp_ir::dfg::Node;
use ways::{Way, between, near, ways};

/// The price of a value that comes too late, and of every cycle by which it does.
const LATE: u32 = 90;
const LATE_CYCLE: u32 = 20;
/// The first temperature, as a price.
const HOT: u32 = 240;
/// Temperatures, and the ratio of each to the one before, in 65536ths: the last is 8.
const STEPS: u32 = 48;
const COOLING: u64 = 61052;
/// Nodes of a loop in which values rarely wait for long: every other run does without
/// [`restage`](Anneal::restage), so that not all runs go the same way.
const SMALL: usize = 40;

/// A value edge between two different nodes.
struct Wire {
    from: Node,
    to: Node,
    ty: Ty,
    /// Cycles by which the consumer's iteration is later.
    span: i32,
    weight: u32,
}

/// One run.
pub(super) struct Anneal<'a, 'p> {
    problem: &'a Problem<'p>,
    ii: i32,
    ways: [Vec<Way>; 3],
    /// Units that a value from each unit reaches without a move, by type.
    near: EntityMap<Fu, Vec<Fu>>,
    /// Units through which one move takes a value from a unit to another.
    between: Vec<Vec<Fu>>,
    wires: Vec<Wire>,
    wires_of: EntityMap<Node, Vec<u32>>,
    at: EntityMap<Node, Position>,
    /// Who holds each unit's issue slot.
    issue: EntityMap<Fu, Vec<Option<Node>>>,
    /// Whose result lands in each output.
    lands: EntityMap<Place, Vec<Option<Node>>>,
    shared: EntityMap<Resource, Vec<u32>>,
    results: EntityMap<Node, Option<Ty>>,
    /// Cycles for which each value needs a register, and their sum over the values of each unit.
    life: EntityMap<Node, i32>,
    load: EntityMap<Fu, i32>,
    /// Cycles of registers that each unit has.
    capacity: EntityMap<Fu, i32>,
    seed: u64,
    draws: u64,
}

impl<'a, 'p> Anneal<'a, 'p> {
    /// A first placement without regard to routes; `None` where even that finds no room.
    pub(super) fn new(
        problem: &'a Problem<'p>,
        ii: u32,
        freedom: &Freedom,
        seed: u32,
        weights: &[u32],
    ) -> Option<Anneal<'a, 'p>> {
        let slots = ii as usize;
        let units = problem.srp.fus.len();
        let mut anneal = Anneal {
            problem,
            ii: ii as i32,
            ways: Ty::ALL.map(|ty| ways(problem, ty)),
            near: near(problem),
            between: between(problem),
            wires: Vec::new(),
            wires_of: EntityMap::filled(problem.dfg.nodes.len(), Vec::new()),
            at: EntityMap::filled(problem.dfg.nodes.len(), (Fu::new(0), 0)),
            issue: EntityMap::filled(units, vec![None; slots]),
            lands: EntityMap::filled(problem.graph.places.len(), vec![None; slots]),
            shared: EntityMap::filled(problem.srp.resources.len(), vec![0; slots]),
            results: problem.dfg.nodes.values().map(|n| n.op.result()).collect(),
            life: EntityMap::filled(problem.dfg.nodes.len(), 0),
            load: EntityMap::filled(units, 0),
            capacity: problem
                .srp
                .fus
                .keys()
                .map(|fu| capacity(problem, fu, ii))
                .collect(),
            seed: u64::from(seed),
            draws: 0,
        };
        anneal.add_wires(weights);
        anneal.start(freedom)?;
        anneal.count_all();
        Some(anneal)
    }

    fn add_wires(&mut self, weights: &[u32]) {
        for (edge, &weight) in self.problem.edges.iter().zip(weights) {
            let Some(to) = edge.to().filter(|&to| to != edge.from) else {
                continue;
            };
            let index = self.wires.len() as u32;
            self.wires.push(Wire {
                from: edge.from,
                to,
                ty: edge.ty,
                span: self.ii * edge.distance as i32,
                weight,
            });
            self.wires_of[edge.from].push(index);
            self.wires_of[to].push(index);
        }
    }

    /// Puts every node into the first free slot, those with the fewest units first.
    fn start(&mut self, freedom: &Freedom) -> Option<()> {
        let mut order: Vec<Node> = self.problem.nodes().collect();
        order.sort_by_key(|&n| (self.problem.units[n].len(), freedom.earliest[n], n));
        for node in order {
            let from = freedom.earliest[node];
            let units = &self.problem.units[node];
            let first = self.draw(units.len() as u32) as usize;
            let turned = units[first..].iter().chain(&units[..first]);
            let position = (from..from + self.ii)
                .flat_map(|t| turned.clone().map(move |&fu| (fu, t)))
                .find(|&(fu, t)| self.is_free(node, fu, t))?;
            self.put(node, position);
        }
        Some(())
    }

    /// A number below `below`.
    fn draw(&mut self, below: u32) -> u32 {
        self.draws += 1;
        let random = noise(self.seed, self.draws, 0xa11);
        ((u64::from(random) * u64::from(below)) >> 32) as u32
    }

    /// True if a change of the price is accepted at a temperature: a worse price with probability
    /// exp(−change / temperature), by a logarithm good to some percent.
    fn accepts(&mut self, change: i64, temperature: u32) -> bool {
        if change <= 0 {
            return true;
        }
        self.draws += 1;
        let random = noise(self.seed, self.draws, 0xacc) | 1;
        // −log2 of the number as a fraction of 2^32, in 256ths: zeros in front, and a straight line
        // between powers of two.
        let zeros = random.leading_zeros();
        let mantissa = (random << zeros) >> 23 & 0xff;
        let log = i64::from(256 * (zeros + 1) - mantissa);
        // ln 2 is 177/256.
        change * 256 * 256 < i64::from(temperature) * log * 177
    }

    /// Tries to move a node, or to exchange two.
    fn step(&mut self, temperature: u32) {
        let nodes = self.at.len() as u32;
        let node = Node::new(self.draw(nodes) as usize);
        let old = self.at[node];
        let new = self.propose(node);
        if new == old {
            return;
        }
        let before_old = self.predecessor(node);
        let whole = |a: &Self, beside: &[Option<Node>]| i64::from(a.price_around(&[node], beside));
        self.lift(node);
        if self.is_free(node, new.0, new.1) {
            self.put(node, new);
            let beside = [before_old, self.predecessor(node)];
            let after = whole(self, &beside) + self.recount(&[node], &[(node, old.0)]);
            self.lift(node);
            self.put(node, old);
            let change = after - whole(self, &beside);
            if self.accepts(change, temperature) {
                self.lift(node);
                self.put(node, new);
            } else {
                self.recount(&[node], &[(node, new.0)]);
            }
            return;
        }
        self.put(node, old);
        self.exchange(node, old, new, temperature);
    }

    /// Exchanges a node and the node in its new position, if that is possible and accepted.
    fn exchange(&mut self, node: Node, old: Position, new: Position, temperature: u32) {
        let Some(other) = self.occupant(node, new).filter(|&other| other != node) else {
            return;
        };
        if self.problem.units[other].binary_search(&old.0).is_err() {
            return;
        }
        let theirs = self.at[other];
        // The cycle of our old slot that is nearest to theirs.
        let apart = (old.1 - theirs.1).rem_euclid(self.ii);
        let nearest = if 2 * apart > self.ii {
            theirs.1 + apart - self.ii
        } else {
            theirs.1 + apart
        };
        let (a, b) = (self.predecessor(node), self.predecessor(other));
        self.lift(node);
        self.lift(other);
        if self.is_free(node, new.0, new.1) {
            self.put(node, new);
            if self.is_free(other, old.0, nearest) {
                self.put(other, (old.0, nearest));
                let beside = [a, b, self.predecessor(node), self.predecessor(other)];
                let after = i64::from(self.price_around(&[node, other], &beside))
                    + self.recount(&[node, other], &[(node, old.0), (other, theirs.0)]);
                self.lift(node);
                self.lift(other);
                self.put(node, old);
                self.put(other, theirs);
                let change = after - i64::from(self.price_around(&[node, other], &beside));
                if self.accepts(change, temperature) {
                    self.lift(node);
                    self.lift(other);
                    self.put(node, new);
                    self.put(other, (old.0, nearest));
                } else {
                    self.recount(&[node, other], &[(node, new.0), (other, old.0)]);
                }
                return;
            }
            self.lift(node);
        }
        self.put(node, old);
        self.put(other, theirs);
    }

    /// Anneals with so many proposals for each node at each temperature; each node's position then.
    pub(super) fn run(mut self, proposals: u32) -> EntityMap<Node, Position> {
        for temperature in temperatures() {
            for _ in 0..self.at.len() as u32 * proposals {
                self.step(temperature);
            }
            if self.at.len() > SMALL || self.seed % 2 == 1 {
                self.restage(temperature);
            }
            self.count_all();
        }
        self.at
    }
}

/// Steps of a run, as the router counts them.
pub(super) fn effort(problem: &Problem<'_>, proposals: u32) -> u64 {
    problem.dfg.nodes.len() as u64 * u64::from(proposals * STEPS)
}

/// From [`HOT`] down, each the same share of the one before.
fn temperatures() -> impl Iterator<Item = u32> {
    std::iter::successors(Some(u64::from(HOT) << 16), |t| Some((t * COOLING) >> 16))
        .map(|t| (t >> 16) as u32)
        .take(STEPS as usize)
}
