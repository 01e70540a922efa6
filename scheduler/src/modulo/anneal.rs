//! Placement by simulated annealing: units and cycles for all nodes at once, judged by what the
//! routes between them would cost at least if nothing else were in their way.
//!
//! Placing one node after the other is quick, but it fills a crowded array with nodes whose
//! neighbours then have to stay far away. Here every node moves until the whole is good (Kirkpatrick
//! et al. 1983; of mappers, DRESC, Mei et al. 2002). An estimate takes the place of the router,
//! which makes a move some hundred times cheaper; [`place`](super::place) then routes for real,
//! and places again what fails. All arithmetic is in integers, so that every host agrees.

use super::noise::noise;
use super::order::Freedom;
use super::problem::{Position, Problem, UNREACHABLE};
use super::route::{self, MOVE};
use srp_archdesc::arch::{Fu, FuOp, Resource};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::Ty;
use srp_archdesc::resource::Place;
use srp_ir::dfg::Node;

/// The price of a value that comes too late, and of every cycle by which it does.
const LATE: u32 = 90;
const LATE_CYCLE: u32 = 20;
/// The price of a value that has no way to its consumer at all.
const NO_WAY: u32 = 100_000;
/// The price of a cycle in which a value waits in an output, where nothing else lands: less than the
/// router's, since a placement with time to spare is easier to route.
const STANDING: u32 = 4;
/// The first temperature, as a price.
const HOT: u32 = 240;
/// Temperatures, and what each is of the one before, in 65536ths: the last is 8.
const STEPS: u32 = 48;
const COOLING: u64 = 61052;
/// Nodes of a loop in which values rarely wait for long: every other run does without
/// [`restage`](Anneal::restage), so that not all runs go the same way.
const SMALL: usize = 40;
/// The part of a unit's registers, in 16ths, beyond which it counts as crowded: the estimate does not
/// see how values get in each other's way.
const PART: u32 = 6;
/// Cycles beyond the least in which a node without consumers may be put.
const SPREAD: i32 = 3;

/// The cheapest ways of a value from a unit's output to an operand of another unit.
#[derive(Clone, Copy)]
struct Way {
    /// Fewest cycles.
    reach: u32,
    /// Price beyond holding the value, if it goes on at once.
    direct: u32,
    /// The same by way of a register file in which it can wait, with its cycles.
    held: u32,
    held_reach: u32,
}

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
        let units = problem.arch.fus.len();
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
            shared: EntityMap::filled(problem.arch.resources.len(), vec![0; slots]),
            results: problem.dfg.nodes.values().map(|n| n.op.result()).collect(),
            life: EntityMap::filled(problem.dfg.nodes.len(), 0),
            load: EntityMap::filled(units, 0),
            capacity: problem
                .arch
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

    fn slot(&self, time: i32) -> usize {
        time.rem_euclid(self.ii) as usize
    }

    fn timing(&self, node: Node, fu: Fu) -> &'p FuOp {
        self.problem.timing(node, fu)
    }

    /// Cycles in which a node holds its unit.
    fn holds(&self, node: Node, (fu, time): Position) -> impl Iterator<Item = usize> + use<> {
        let ii = self.ii;
        let interval = self.timing(node, fu).interval as i32;
        (0..interval).map(move |k| (time + k).rem_euclid(ii) as usize)
    }

    fn is_free(&self, node: Node, fu: Fu, time: i32) -> bool {
        let timing = self.timing(node, fu);
        timing.interval <= self.ii as u32
            && self.holds(node, (fu, time)).all(|slot| {
                let room =
                    |&r: &Resource| self.shared[r][slot] < self.problem.arch.resources[r].count;
                self.issue[fu][slot].is_none() && timing.uses.iter().all(room)
            })
            && self
                .landing(node, (fu, time))
                .is_none_or(|(place, slot)| self.lands[place][slot].is_none())
    }

    /// The output and the slot in which a node's result lands.
    fn landing(&self, node: Node, (fu, time): Position) -> Option<(Place, usize)> {
        let place = self.results[node].map(|ty| out_of(self.problem, ty, fu))?;
        Some((
            place,
            self.slot(time + self.timing(node, fu).latency as i32),
        ))
    }

    /// Whose value stands in the output in which a node's result lands, when it does: nobody, or
    /// the last that landed there before.
    fn predecessor(&self, node: Node) -> Option<Node> {
        let (place, slot) = self.landing(node, self.at[node])?;
        let slots = self.ii as usize;
        (1..slots).find_map(|k| self.lands[place][(slot + slots - k) % slots])
    }

    fn put(&mut self, node: Node, position: Position) {
        self.at[node] = position;
        self.mark(node, position, Some(node), 1);
    }

    fn lift(&mut self, node: Node) {
        self.mark(node, self.at[node], None, u32::MAX);
    }

    /// Sets who holds the slots of a position, and adds `by` (modulo 2^32) to what it shares.
    fn mark(&mut self, node: Node, position: Position, holder: Option<Node>, by: u32) {
        if let Some((place, slot)) = self.landing(node, position) {
            self.lands[place][slot] = holder;
        }
        for slot in self.holds(node, position) {
            self.issue[position.0][slot] = holder;
            for &r in &self.timing(node, position.0).uses {
                self.shared[r][slot] = self.shared[r][slot].wrapping_add(by);
            }
        }
    }

    /// Whose slot the position takes, where it is exactly one node's.
    fn occupant(&self, node: Node, position: Position) -> Option<Node> {
        let mut found = None;
        for slot in self.holds(node, position) {
            match (self.issue[position.0][slot], found) {
                (Some(other), None) => found = Some(other),
                (Some(other), Some(before)) if other != before => return None,
                _ => {}
            }
        }
        found
    }

    /// What the route of a wire costs at least.
    fn price(&self, wire: &Wire) -> u32 {
        let ((from, issued), (to, read)) = (self.at[wire.from], self.at[wire.to]);
        let way =
            self.ways[wire.ty as usize][from.index() * self.problem.arch.fus.len() + to.index()];
        if way.reach == UNREACHABLE {
            return NO_WAY;
        }
        let ready = issued + self.timing(wire.from, from).latency as i32;
        let spare = read + wire.span - ready - way.reach as i32;
        if spare < 0 {
            return (LATE + LATE_CYCLE * spare.unsigned_abs() + way.direct) * wire.weight;
        }
        let gap = (spare + way.reach as i32) as u32;
        let waiting = if way.held_reach > gap {
            u32::MAX
        } else {
            way.held + route::holding_price(gap)
        };
        let mut price = way.direct;
        if spare > 0 {
            price = if self.stands(wire.from, ready, spare) {
                waiting.min(way.direct + STANDING * spare as u32)
            } else {
                waiting.min(way.direct + route::move_price(1))
            };
        }
        if (MOVE..2 * MOVE).contains(&price)
            && !self.has_room(wire.ty, from, to, ready, ready + gap as i32)
        {
            price += LATE;
        }
        price * wire.weight
    }

    /// Cycles for which a value needs a register: none where it can stay in its unit's output for as
    /// long as somebody needs it.
    fn lifetime(&self, node: Node) -> i32 {
        let (fu, issued) = self.at[node];
        let ready = issued + self.timing(node, fu).latency as i32;
        let from_here = (self.wires_of[node].iter())
            .map(|&w| &self.wires[w as usize])
            .filter(|wire| wire.from == node);
        let longest = from_here
            .map(|wire| self.at[wire.to].1 + wire.span - ready)
            .max();
        let longest = longest.unwrap_or(0).max(0);
        if self.stands(node, ready, longest) {
            0
        } else {
            longest
        }
    }

    /// Counts all registers anew.
    fn count_all(&mut self) {
        self.load.values_mut().for_each(|load| *load = 0);
        for node in self.problem.nodes() {
            self.life[node] = self.lifetime(node);
            self.load[self.at[node].0] += self.life[node];
        }
    }

    /// What the registers that a unit has too few of cost: as much as moving their values away.
    fn crowd(&self, fu: Fu) -> i64 {
        let over = (self.load[fu] - self.capacity[fu]).max(0);
        i64::from(over) * i64::from(MOVE) / i64::from(self.ii)
    }

    /// Counts the registers of nodes and of the values they read anew; by how much the price of
    /// crowds has risen.
    fn recount(&mut self, nodes: &[Node], homes: &[(Node, Fu)]) -> i64 {
        let mut change = 0;
        let mut add = |a: &mut Self, fu: Fu, by: i32| {
            if by != 0 {
                change -= a.crowd(fu);
                a.load[fu] += by;
                change += a.crowd(fu);
            }
        };
        for &(node, home) in homes {
            let life = self.life[node];
            add(self, home, -life);
            let fu = self.at[node].0;
            add(self, fu, life);
        }
        for &node in nodes {
            for k in 0..=self.wires_of[node].len() {
                let value = match k {
                    0 => node,
                    _ => self.wires[self.wires_of[node][k - 1] as usize].from,
                };
                if k > 0 && value == node {
                    continue;
                }
                let life = self.lifetime(value);
                let more = life - self.life[value];
                self.life[value] = life;
                let fu = self.at[value].0;
                add(self, fu, more);
            }
        }
        change
    }

    /// Whether a value can stay in its unit's output for some cycles after it lands there.
    fn stands(&self, node: Node, ready: i32, cycles: i32) -> bool {
        let Some(ty) = self.results[node] else {
            return false;
        };
        let lands = &self.lands[out_of(self.problem, ty, self.at[node].0)];
        cycles < self.ii && (1..=cycles).all(|k| lands[self.slot(ready + k)].is_none())
    }

    /// Whether a unit can move a value that stands in an output from `ready` on to a consumer that
    /// reads it at `arrival`. The unit takes it from the output while it stands there, or, its own,
    /// from its registers; and keeps it in its output until it is read, or, the consumer's own, in
    /// its registers.
    fn has_room(&self, ty: Ty, from: Fu, to: Fu, ready: i32, arrival: i32) -> bool {
        let gone = (ready..arrival).find(|&t| self.is_overwritten(ty, from, t + 1));
        let gone = gone.unwrap_or(arrival).min(arrival - 1);
        let between = &self.between[from.index() * self.problem.arch.fus.len() + to.index()];
        between.iter().any(|&fu| {
            let last = if fu == from { arrival - 1 } else { gone };
            for t in (ready.max(last - self.ii + 1)..=last).rev() {
                let free =
                    self.issue[fu][self.slot(t)].is_none() && !self.is_overwritten(ty, fu, t + 1);
                let kept =
                    || fu == to || (t + 2..=arrival).all(|t| !self.is_overwritten(ty, fu, t));
                if free && kept() {
                    return true;
                }
            }
            false
        })
    }

    /// Whether a result lands in a unit's output in a cycle.
    fn is_overwritten(&self, ty: Ty, fu: Fu, time: i32) -> bool {
        self.lands[out_of(self.problem, ty, fu)][self.slot(time)].is_some()
    }

    /// The price of everything around nodes, and of the values whose stay in an output they end.
    fn price_around(&self, nodes: &[Node], beside: &[Option<Node>]) -> u32 {
        let mut sum = 0;
        let mut seen: [Option<Node>; 6] = [None; 6];
        let all = nodes
            .iter()
            .copied()
            .chain(beside.iter().flatten().copied());
        for (k, node) in all.enumerate() {
            if seen[..k].contains(&Some(node)) {
                continue;
            }
            seen[k] = Some(node);
            for &w in &self.wires_of[node] {
                let wire = &self.wires[w as usize];
                let other = if wire.from == node {
                    wire.to
                } else {
                    wire.from
                };
                if !seen[..k].contains(&Some(other)) {
                    sum += self.price(wire);
                }
            }
            if k < nodes.len() {
                for &o in &self.problem.orders_of[node] {
                    let order = &self.problem.orders[o];
                    let other = if order.from == node {
                        order.to
                    } else {
                        order.from
                    };
                    if !seen[..k].contains(&Some(other)) {
                        sum += self.order_price(o);
                    }
                }
            }
        }
        sum
    }

    fn order_price(&self, o: usize) -> u32 {
        let order = &self.problem.orders[o];
        let least = self.at[order.from].1 + order.delay as i32;
        let short = least - self.at[order.to].1 - self.ii * order.distance as i32;
        if short > 0 {
            LATE + LATE_CYCLE * short as u32
        } else {
            0
        }
    }

    /// The first and last cycle in which a node on this unit is in time, so far as its neighbours
    /// say.
    fn window(&self, node: Node, fu: Fu) -> (Option<i32>, Option<i32>) {
        let (mut first, mut last) = (None::<i32>, None::<i32>);
        let latency = self.timing(node, fu).latency as i32;
        let mut not_before = |t: i32| first = Some(first.map_or(t, |f| f.max(t)));
        let mut not_after = |t: i32| last = Some(last.map_or(t, |l| l.min(t)));
        let units = self.problem.arch.fus.len();
        for &w in &self.wires_of[node] {
            let wire = &self.wires[w as usize];
            let reach = |from: Fu, to: Fu| {
                let way = self.ways[wire.ty as usize][from.index() * units + to.index()];
                way.reach.min(units as u32) as i32
            };
            if wire.to == node {
                let (from, t) = self.at[wire.from];
                let ready = t + self.timing(wire.from, from).latency as i32;
                not_before(ready + reach(from, fu) - wire.span);
            } else {
                let (to, t) = self.at[wire.to];
                not_after(t + wire.span - reach(fu, to) - latency);
            }
        }
        for &o in &self.problem.orders_of[node] {
            let order = &self.problem.orders[o];
            let span = self.ii * order.distance as i32;
            if order.to == node && order.from != node {
                not_before(self.at[order.from].1 + order.delay as i32 - span);
            } else if order.to != node {
                not_after(self.at[order.to].1 + span - order.delay as i32);
            }
        }
        (first, last)
    }

    /// A unit for a node: mostly one next to a neighbour of the node's.
    fn propose_unit(&mut self, node: Node) -> Fu {
        let count = self.wires_of[node].len() as u32;
        if count > 0 && self.draw(4) > 0 {
            let drawn = self.draw(count) as usize;
            let wire = &self.wires[self.wires_of[node][drawn] as usize];
            let other = if wire.to == node { wire.from } else { wire.to };
            let (unit, _) = self.at[other];
            let drawn = self.draw(self.near[unit].len() as u32) as usize;
            let fu = self.near[unit][drawn];
            if self.problem.units[node].binary_search(&fu).is_ok() {
                return fu;
            }
        }
        let drawn = self.draw(self.problem.units[node].len() as u32) as usize;
        self.problem.units[node][drawn]
    }

    fn propose(&mut self, node: Node) -> Position {
        let fu = self.propose_unit(node);
        let ii = self.ii;
        let (from, to) = match self.window(node, fu) {
            (Some(first), Some(last)) if first <= last => (first, last.min(first + ii - 1)),
            (Some(first), Some(last)) => (last, first),
            (Some(first), None) => (first, first + (ii - 1).min(SPREAD)),
            (None, Some(last)) => (last - (ii - 1).min(SPREAD), last),
            (None, None) => (self.at[node].1, self.at[node].1 + ii - 1),
        };
        let width = (to - from + 1).min(2 * ii + 2) as u32;
        (fu, from + self.draw(width) as i32)
    }

    /// Whether a change of the price is taken at a temperature: a worse one with probability
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

    /// Exchanges a node and the one that is where it should go, if that is possible and taken.
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

    /// Tries to bring the ends of every value that waits for an II or more closer together: moves one
    /// of them, with all that has to go with it, to the next iteration or the one before. That
    /// changes no slot, so nothing is in the way.
    fn restage(&mut self, temperature: u32) {
        for w in 0..self.wires.len() {
            for (later, whole) in [(true, false), (false, false), (true, true), (false, true)] {
                let wire = &self.wires[w];
                if self.slack(wire) >= self.ii {
                    let (start, end) = if later {
                        (wire.from, wire.to)
                    } else {
                        (wire.to, wire.from)
                    };
                    self.shift(start, end, later, whole, temperature);
                }
            }
        }
    }

    /// Cycles that a value has beyond what its way takes.
    fn slack(&self, wire: &Wire) -> i32 {
        let ((from, issued), (to, read)) = (self.at[wire.from], self.at[wire.to]);
        let units = self.problem.arch.fus.len();
        let way = self.ways[wire.ty as usize][from.index() * units + to.index()];
        let latency = self.timing(wire.from, from).latency as i32;
        read + wire.span - issued - latency - way.reach.min(units as u32) as i32
    }

    /// Shifts a node by an II, later or earlier, and with it every node that would otherwise come
    /// too late or too early; not `end`.
    fn shift(&mut self, start: Node, end: Node, later: bool, whole: bool, temperature: u32) {
        let mut moved = vec![false; self.at.len()];
        let mut list = vec![start];
        moved[start.index()] = true;
        let mut next = 0;
        while let Some(&node) = list.get(next) {
            next += 1;
            let wires = self.wires_of[node].iter().map(|&w| {
                let wire = &self.wires[w as usize];
                (wire.from, wire.to, self.slack(wire))
            });
            let orders = self.problem.orders_of[node].iter().map(|&o| {
                let order = &self.problem.orders[o];
                let span = self.ii * order.distance as i32;
                let slack = self.at[order.to].1 + span - self.at[order.from].1 - order.delay as i32;
                (order.from, order.to, slack)
            });
            for (from, to, slack) in wires.chain(orders) {
                let (here, there) = if later { (from, to) } else { (to, from) };
                let other = if here == node { there } else { here };
                if (here == node || whole) && slack < self.ii && !moved[other.index()] {
                    moved[other.index()] = true;
                    list.push(other);
                }
            }
            if moved[end.index()] {
                return;
            }
        }
        let boundary: Vec<usize> = (0..self.wires.len())
            .filter(|&w| moved[self.wires[w].from.index()] != moved[self.wires[w].to.index()])
            .collect();
        let sum = |a: &Self| -> i64 {
            boundary
                .iter()
                .map(|&w| i64::from(a.price(&a.wires[w])))
                .sum()
        };
        let before = sum(self);
        let by = if later { self.ii } else { -self.ii };
        list.iter().for_each(|&n| self.at[n].1 += by);
        let change = sum(self) - before;
        if !self.accepts(change, temperature) {
            list.iter().for_each(|&n| self.at[n].1 -= by);
        }
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

/// Cycles of registers, out of each II, that a unit has for results of its own: a share of each file
/// that it writes.
fn capacity(problem: &Problem<'_>, fu: Fu, ii: u32) -> i32 {
    let share = |&file: &Place| {
        let writers = problem
            .graph
            .writes
            .values()
            .filter(|w| w.contains(&file))
            .count();
        let size = problem
            .graph
            .as_file(file)
            .map_or(0, |rf| problem.arch.files[rf].size);
        size / writers.max(1) as u32
    };
    (problem.graph.writes[fu].iter().map(share).sum::<u32>() * ii * PART / 16) as i32
}

/// Where a unit's results of a type stand.
fn out_of(problem: &Problem<'_>, ty: Ty, fu: Fu) -> Place {
    match ty {
        Ty::Pred => problem.graph.pred_out[fu],
        Ty::Word | Ty::Vec => problem.graph.out[fu],
    }
}

/// The ways of a type between all units.
fn ways(problem: &Problem<'_>, ty: Ty) -> Vec<Way> {
    let units = || problem.arch.fus.keys();
    let mut ways = Vec::new();
    for from in units() {
        let out = out_of(problem, ty, from);
        let wide = |&&file: &&_| problem.graph.places[file].width >= ty.bits();
        let files: Vec<_> = problem.graph.writes[from].iter().filter(wide).collect();
        for to in units() {
            let held = files
                .iter()
                .map(|&&f| (problem.detour(ty, f, to), problem.reach(ty, f, to)));
            let (held, held_reach) = held.min().unwrap_or((UNREACHABLE, UNREACHABLE));
            ways.push(Way {
                reach: problem.reach(ty, out, to),
                direct: problem.detour(ty, out, to),
                held,
                held_reach,
            });
        }
    }
    ways
}

/// The units that each unit's results reach without a move, itself among them.
fn near(problem: &Problem<'_>) -> EntityMap<Fu, Vec<Fu>> {
    let reaches = |from: Fu, to: Fu| {
        let from = problem.graph.out[from];
        from_direct(problem, from, to)
    };
    let near = |from: Fu| {
        let there = |&to: &Fu| to == from || reaches(from, to) || reaches(to, from);
        problem.arch.fus.keys().filter(there).collect()
    };
    problem.arch.fus.keys().map(near).collect()
}

fn from_direct(problem: &Problem<'_>, from: Place, to: Fu) -> bool {
    problem.detour(Ty::Word, from, to) == 0
}

/// The units over which one move brings a value from each unit to each other.
fn between(problem: &Problem<'_>) -> Vec<Vec<Fu>> {
    let units: Vec<Fu> = problem.arch.fus.keys().collect();
    let direct = |from: Fu, to: Fu| from == to || from_direct(problem, problem.graph.out[from], to);
    let mut all = Vec::new();
    for &from in &units {
        for &to in &units {
            let through = |&&m: &&Fu| direct(from, m) && direct(m, to);
            all.push(units.iter().filter(through).copied().collect());
        }
    }
    all
}
