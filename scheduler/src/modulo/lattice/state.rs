//! Where everything is: positions of nodes, and the tree of each value from its unit to its consumers.

use super::array::Array;
use super::prices::{Kind, Prices};
use super::{EARLY, LATE, MOST_OPEN, OPEN};
use crate::modulo::problem::{Position, Problem};
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_ir::dfg::Node;
use std::collections::BTreeMap;

/// A kind of goods, and the cycle and unit of one.
type Good = (Kind, i32, u16);

/// A value in a unit's output, or in its file, in a cycle of iteration 0.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Point {
    pub(super) time: i32,
    pub(super) lane: u16,
    pub(super) in_file: bool,
}

impl Point {
    /// What it takes: a register in that cycle, or the issue slot of the cycle before.
    fn good(self) -> Good {
        match self.in_file {
            true => (Kind::Register, self.time, self.lane),
            false => (Kind::Issue, self.time - 1, self.lane),
        }
    }
}

/// All points of a value, and how many of its ways go through each.
#[derive(Clone, Default)]
pub(super) struct Tree(Vec<(Point, u16)>);

impl Tree {
    pub(super) fn points(&self) -> impl Iterator<Item = (Point, u16)> {
        self.0.iter().copied()
    }
}

/// A value on its way to one consumer: all operands of it that are the same value.
pub(super) struct Net {
    pub(super) from: Node,
    pub(super) to: Node,
    /// Cycles that the consumer's iteration comes after the producer's.
    pub(super) span: i32,
    /// The edges of the problem.
    pub(super) edges: Vec<usize>,
}

/// A way of a value: its points from the consumer back to the producer.
pub(super) type Way = Vec<Point>;

/// Something that was done, to be undone.
enum Done {
    Lifted(Node, Position),
    Put(Node),
    Released(usize, Way),
    Taken(usize),
}

/// Positions, ways, and the prices that follow from them.
pub(super) struct State<'a, 'p> {
    pub(super) problem: &'a Problem<'p>,
    pub(super) array: &'a Array,
    pub(super) prices: Prices,
    /// Who takes each issue slot: nodes that issue in it, and nodes whose values a move carries on in it.
    takers: Vec<Vec<Node>>,
    pub(super) ii: i32,
    pub(super) nets: Vec<Net>,
    pub(super) nets_of: EntityMap<Node, Vec<usize>>,
    pub(super) at: EntityMap<Node, Position>,
    placed: EntityMap<Node, bool>,
    has_result: EntityMap<Node, bool>,
    pub(super) trees: EntityMap<Node, Tree>,
    /// The way of each net; `None` where it is open.
    pub(super) ways: Vec<Option<Way>>,
    /// Nets without a way, and the rise for good of the price of each.
    pub(super) open: usize,
    pub(super) open_history: Vec<i32>,
    /// Cycles by which memory orders are not kept, of all together.
    pub(super) early: i64,
    done: Vec<Done>,
}

impl<'a, 'p> State<'a, 'p> {
    /// Nothing is placed.
    pub(super) fn new(problem: &'a Problem<'p>, array: &'a Array, ii: u32) -> State<'a, 'p> {
        let nets = nets(problem, ii as i32);
        let count = problem.dfg.nodes.len();
        let mut nets_of = EntityMap::filled(count, Vec::new());
        for (i, net) in nets.iter().enumerate() {
            nets_of[net.from].push(i);
            if net.to != net.from {
                nets_of[net.to].push(i);
            }
        }
        let nodes = problem.dfg.nodes.values();
        State {
            prices: Prices::new(array, ii),
            takers: vec![Vec::new(); ii as usize * array.lanes],
            ii: ii as i32,
            at: EntityMap::filled(count, (Fu::new(0), 0)),
            placed: EntityMap::filled(count, false),
            has_result: nodes.map(|node| node.op.result().is_some()).collect(),
            trees: EntityMap::filled(count, Tree::default()),
            ways: vec![None; nets.len()],
            open: nets.len(),
            open_history: vec![0; nets.len()],
            early: 0,
            done: Vec::new(),
            nets,
            nets_of,
            problem,
            array,
        }
    }

    /// The lane of a node's unit, and its cycle.
    pub(super) fn place(&self, node: Node) -> (u16, i32) {
        let (fu, time) = self.at[node];
        (fu.index() as u16, time)
    }

    /// The cycle in which a net's value is there, and that in which it is read.
    pub(super) fn ends(&self, net: &Net) -> (i32, i32) {
        let (_, issued) = self.at[net.from];
        let (_, read) = self.at[net.to];
        (issued + 1, read + net.span)
    }

    fn take_point(&mut self, node: Node, point: Point) -> i32 {
        let tree = &mut self.trees[node].0;
        if let Some((_, count)) = tree.iter_mut().find(|(p, _)| *p == point) {
            *count += 1;
            return 0;
        }
        tree.push((point, 1));
        self.take_good(node, point.good())
    }

    fn take_good(&mut self, node: Node, (kind, time, lane): Good) -> i32 {
        if kind == Kind::Issue {
            self.takers[self.prices.index(time, lane)].push(node);
        }
        self.prices.take(kind, time, lane)
    }

    fn give_back_good(&mut self, node: Node, (kind, time, lane): Good) -> i32 {
        if kind == Kind::Issue {
            let takers = &mut self.takers[self.prices.index(time, lane)];
            let at = takers.iter().position(|&taker| taker == node);
            takers.swap_remove(at.expect("only goods that were taken are given back"));
        }
        self.prices.give_back(kind, time, lane)
    }

    fn release_point(&mut self, node: Node, point: Point) -> i32 {
        let tree = &mut self.trees[node].0;
        let at = tree.iter().position(|(p, _)| *p == point);
        let at = at.expect("only points that were taken are released");
        tree[at].1 -= 1;
        if tree[at].1 > 0 {
            return 0;
        }
        tree.swap_remove(at);
        self.give_back_good(node, point.good())
    }

    /// Where a value comes out.
    pub(super) fn root(&self, node: Node) -> Point {
        let (lane, time) = self.place(node);
        Point {
            time: time + 1,
            lane,
            in_file: false,
        }
    }

    /// Puts a node somewhere; returns the cost.
    pub(super) fn put(&mut self, node: Node, (fu, time): Position) -> i32 {
        self.done.push(Done::Put(node));
        self.put_silently(node, (fu, time))
    }

    fn put_silently(&mut self, node: Node, (fu, time): Position) -> i32 {
        self.at[node] = (fu, time);
        self.placed[node] = true;
        let early = self.earliness(node);
        self.early += early;
        let price = match self.has_result[node] {
            true => self.take_point(node, self.root(node)),
            false => self.take_good(node, (Kind::Issue, time, fu.index() as u16)),
        };
        price + price_of_early(early)
    }

    /// Takes a node away whose nets have no ways; returns its cost.
    pub(super) fn lift(&mut self, node: Node) -> i32 {
        self.done.push(Done::Lifted(node, self.at[node]));
        self.lift_silently(node)
    }

    fn lift_silently(&mut self, node: Node) -> i32 {
        let early = self.earliness(node);
        self.early -= early;
        self.placed[node] = false;
        let (fu, time) = self.at[node];
        let price = match self.has_result[node] {
            true => self.release_point(node, self.root(node)),
            false => self.give_back_good(node, (Kind::Issue, time, fu.index() as u16)),
        };
        price + price_of_early(early)
    }

    /// Takes a way; returns the cost of those points that its value did not have.
    pub(super) fn take(&mut self, net: usize, way: Way) -> i32 {
        self.done.push(Done::Taken(net));
        self.take_silently(net, way)
    }

    fn take_silently(&mut self, net: usize, way: Way) -> i32 {
        let from = self.nets[net].from;
        let cost = way.iter().map(|&point| self.take_point(from, point)).sum();
        self.ways[net] = Some(way);
        self.open -= 1;
        cost
    }

    /// Takes the way of a net away; returns its cost, or that of having none.
    pub(super) fn release(&mut self, net: usize) -> i32 {
        match self.release_silently(net) {
            Some((way, cost)) => {
                self.done.push(Done::Released(net, way));
                cost
            }
            None => self.price_of_open(net),
        }
    }

    fn release_silently(&mut self, net: usize) -> Option<(Way, i32)> {
        let way = self.ways[net].take()?;
        self.open += 1;
        let from = self.nets[net].from;
        let points = way.iter();
        let cost = points.map(|&point| self.release_point(from, point)).sum();
        Some((way, cost))
    }

    /// Forgets how to undo.
    pub(super) fn commit(&mut self) {
        self.done.clear();
    }

    /// Undoes all since the last [`commit`](Self::commit).
    pub(super) fn undo(&mut self) {
        while let Some(done) = self.done.pop() {
            match done {
                Done::Lifted(node, at) => {
                    self.put_silently(node, at);
                }
                Done::Put(node) => {
                    self.lift_silently(node);
                }
                Done::Released(net, way) => {
                    self.take_silently(net, way);
                }
                Done::Taken(net) => {
                    self.release_silently(net);
                }
            }
        }
    }

    /// Returns the cost of a net without a way, wherever its ends are.
    pub(super) fn price_of_open_anywhere(&self, net: usize) -> i32 {
        (OPEN + self.prices.penalty + self.open_history[net]).min(MOST_OPEN)
    }

    /// Returns the cost of a net without a way.
    pub(super) fn price_of_open(&self, net: usize) -> i32 {
        let anywhere = self.price_of_open_anywhere(net);
        let net = &self.nets[net];
        let (ready, read) = self.ends(net);
        let ((from, _), (to, _)) = (self.place(net.from), self.place(net.to));
        let reach = self.array.from[usize::from(from)][usize::from(to)];
        let late = ready + i32::from(reach) - read;
        anywhere + LATE.of(late)
    }

    /// Cycles by which a node's memory orders are not kept with nodes that are placed.
    fn earliness(&self, node: Node) -> i64 {
        let missing = |&o: &usize| {
            let order = &self.problem.orders[o];
            let are_placed = self.placed[order.from] && self.placed[order.to];
            let (from, to) = (self.at[order.from].1, self.at[order.to].1);
            let span = self.ii * order.distance as i32;
            let early = from + order.delay as i32 - to - span;
            are_placed.then(|| i64::from(early.max(0)))
        };
        let orders = &self.problem.orders_of[node];
        orders.iter().filter_map(missing).sum()
    }

    /// True if a node or its value takes what is taken too often, or something of it has no way.
    pub(super) fn is_in_conflict(&self, node: Node) -> bool {
        let nets = &self.nets_of[node];
        if nets.iter().any(|&net| self.ways[net].is_none()) || self.earliness(node) > 0 {
            return true;
        }
        if !self.has_result[node] {
            let (lane, time) = self.place(node);
            return self.prices.is_overused(Kind::Issue, time, lane);
        }
        let goods = self.trees[node].points().map(|(point, _)| point.good());
        goods
            .into_iter()
            .any(|(kind, time, lane)| self.prices.is_overused(kind, time, lane))
    }

    /// The issue slots that a node takes, with its value's moves.
    fn slots(&self, node: Node) -> impl Iterator<Item = usize> {
        let (lane, time) = self.place(node);
        let issued = (!self.has_result[node]).then_some((Kind::Issue, time, lane));
        let goods = self.trees[node].points().map(|(point, _)| point.good());
        let goods = issued.into_iter().chain(goods);
        goods
            .filter(|(kind, ..)| *kind == Kind::Issue)
            .map(|(_, time, lane)| self.prices.index(time, lane))
    }

    /// Lists the slots that are taken too often by a node, its value or those that it reads, each with another that
    /// takes it too.
    pub(super) fn clashes(&self, node: Node, clashes: &mut Vec<(usize, Node)>) {
        clashes.clear();
        let producers = self.nets_of[node].iter().map(|&net| self.nets[net].from);
        let mut values: Vec<Node> = producers.chain([node]).collect();
        values.sort_unstable();
        values.dedup();
        for value in values {
            for slot in self.slots(value) {
                let takers = &self.takers[slot];
                if takers.len() > 1 {
                    let others = takers.iter().filter(|&&other| other != node);
                    clashes.extend(others.map(|&other| (slot, other)));
                }
            }
        }
    }

    /// One of those that take an issue slot.
    pub(super) fn taker(&self, lane: usize, time: i32, random: u32) -> Option<Node> {
        if lane >= self.array.files.len() {
            return None;
        }
        let takers = &self.takers[self.prices.index(time, lane as u16)];
        takers.get(random as usize % takers.len().max(1)).copied()
    }

    /// True if both ends of a net are placed.
    pub(super) fn is_placed(&self, net: usize) -> bool {
        let net = &self.nets[net];
        self.placed[net.from] && self.placed[net.to]
    }

    /// The slot that a node itself issues in.
    pub(super) fn slot(&self, node: Node) -> usize {
        let (lane, time) = self.place(node);
        self.prices.index(time, lane)
    }

    /// Lists the nets of a value with ways that take an issue slot.
    pub(super) fn ways_through(&self, node: Node, slot: usize, nets: &mut Vec<usize>) {
        let takes = |point: &Point| {
            let (kind, time, lane) = point.good();
            kind == Kind::Issue && self.prices.index(time, lane) == slot
        };
        let passes = |&&net: &&usize| {
            let way = self.ways[net].as_ref();
            self.nets[net].from == node && way.is_some_and(|way| way.iter().any(takes))
        };
        nets.clear();
        nets.extend(self.nets_of[node].iter().filter(passes));
    }

    /// True when nothing is in the way of anything.
    pub(super) fn is_free_of_conflicts(&self) -> bool {
        self.prices.excess == 0 && self.open == 0 && self.early == 0
    }
}

/// The cost of memory orders that are not kept by so many cycles.
pub(super) fn price_of_early(cycles: i64) -> i32 {
    match cycles {
        0 => 0,
        _ => OPEN + EARLY * cycles.min(1000) as i32,
    }
}

/// The nets of a loop.
fn nets(problem: &Problem<'_>, ii: i32) -> Vec<Net> {
    let mut nets: Vec<Net> = Vec::new();
    let mut numbers: BTreeMap<(Node, Node, u32), usize> = BTreeMap::new();
    for (e, edge) in problem.edges.iter().enumerate() {
        let to = edge
            .to()
            .expect("arrays of this kind keep no value after a loop");
        let number = *numbers
            .entry((edge.from, to, edge.distance))
            .or_insert_with(|| {
                nets.push(Net {
                    from: edge.from,
                    to,
                    span: ii * edge.distance as i32,
                    edges: Vec::new(),
                });
                nets.len() - 1
            });
        nets[number].edges.push(e);
    }
    nets
}
