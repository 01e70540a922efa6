//! Where everything is, and what it takes: positions of nodes, routes of values, and the market they
//! take it from.

use super::deliver::Own;
use super::lanes::Lanes;
use super::market::{Good, Market};
use super::tiles::Tiles;
use crate::modulo::needs::Needs;
use crate::modulo::problem::{Position, Problem, Tag};
use crate::modulo::registers;
use crate::modulo::route::Route;
use crate::modulo::table::Item;
use rustc_hash::FxHashMap;
use srp_archdesc::arch::{FileKind, Fu, FuOp};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::resource::Place;
use srp_ir::dfg::{Initial, Node};
use srp_ir::dre::scheduled::Reg;
use std::collections::BTreeMap;

/// A way of a value: the items that it takes from the producer on, the consumer's read path, and which copies
/// in a file it reads.
#[derive(Clone)]
pub(super) struct Path {
    pub(super) items: Vec<Item>,
    pub(super) read: u32,
    pub(super) tag: Tag,
}

impl Path {
    /// The route, with its stays in files.
    pub(super) fn route(&self) -> Route {
        Route::new(self.items.clone(), self.read, self.tag)
    }
}

/// Positions, routes, and the prices that follow from them.
pub(super) struct State<'a, 'p> {
    pub(super) problem: &'a Problem<'p>,
    pub(super) lanes: &'a Lanes,
    pub(super) market: Market,
    pub(super) ii: i32,
    /// The cycle by which everything has landed, if there is one; no node is issued outside of its freedom then.
    pub(super) deadline: Option<i32>,
    /// Where operations begin on units without a slot to spare.
    pub(super) tiles: EntityMap<Fu, Option<Tiles>>,
    /// Cycles for which a value can stay in a file that does not rotate.
    pub(super) longest_stay: i32,
    pub(super) at: EntityMap<Node, Position>,
    /// True for each node that is placed.
    placed: EntityMap<Node, bool>,
    /// The route of each edge; `None` where it is open.
    pub(super) routes: Vec<Option<Path>>,
    /// Edges without a route.
    pub(super) open: usize,
    /// Cycles by which memory orders are not kept, of all together.
    pub(super) early: i64,
    /// Items of each value, counted.
    items: EntityMap<Node, FxHashMap<Item, u32>>,
    /// Registers that are set before the loop to something, and for how many nodes.
    constants: FxHashMap<(Place, Initial), u32>,
    scratch: Vec<Good>,
    /// Lists of routes that were dropped, to be filled again.
    spare: Vec<Vec<Item>>,
}

impl<'a, 'p> State<'a, 'p> {
    /// All registers free but `fixed`, and nothing placed.
    pub(super) fn new(
        problem: &'a Problem<'p>,
        lanes: &'a Lanes,
        ii: u32,
        fixed: &[Reg],
    ) -> State<'a, 'p> {
        let mut market = Market::new(problem, lanes, ii);
        let mut taken: BTreeMap<Place, u32> = BTreeMap::new();
        for reg in fixed {
            *taken.entry(problem.graph.file[reg.file]).or_default() += 1;
        }
        for (place, count) in taken {
            market.reserve(lanes.of[place], count);
        }
        let nodes = problem.dfg.nodes.len();
        State {
            market,
            lanes,
            ii: ii as i32,
            deadline: None,
            tiles: EntityMap::filled(problem.srp.fus.len(), None),
            longest_stay: registers::longest_stay(problem, ii),
            at: EntityMap::filled(nodes, (Fu::new(0), 0)),
            placed: EntityMap::filled(nodes, false),
            routes: vec![None; problem.edges.len()],
            open: problem.edges.len(),
            early: 0,
            items: EntityMap::filled(nodes, FxHashMap::default()),
            constants: FxHashMap::default(),
            scratch: Vec::new(),
            spare: Vec::new(),
            problem,
        }
    }

    /// The cycle in which a node's result stands in its unit's output first.
    pub(super) fn ready(&self, node: Node) -> i32 {
        let (fu, time) = self.at[node];
        time + self.problem.timing(node, fu).latency as i32
    }

    /// The first cycle in which those before a node let it be issued, and the last in which those behind it do: by its
    /// operands, its result, and memory orders, without what transport takes. `None` where there are no such.
    pub(super) fn between_neighbours(&self, node: Node) -> (Option<i32>, Option<i32>) {
        let problem = self.problem;
        let latency = problem.min_latency(node) as i32;
        let (mut first, mut last) = (None::<i32>, None::<i32>);
        let mut not_before = |time: i32| first = Some(first.map_or(time, |f| f.max(time)));
        let mut not_after = |time: i32| last = Some(last.map_or(time, |l| l.min(time)));
        for &e in &problem.edges_of[node] {
            let edge = &problem.edges[e];
            let Some(to) = edge.to().filter(|&to| to != edge.from) else {
                continue;
            };
            let span = self.ii * edge.distance as i32;
            match to == node {
                true => not_before(self.ready(edge.from) - span),
                false => not_after(self.at[to].1 + span - latency),
            }
        }
        for &o in &problem.orders_of[node] {
            let order = &problem.orders[o];
            if order.from == order.to {
                continue;
            }
            let delay = order.delay as i32 - self.ii * order.distance as i32;
            match order.to == node {
                true => not_before(self.at[order.from].1 + delay),
                false => not_after(self.at[order.to].1 - delay),
            }
        }
        (first, last)
    }

    /// True when a value that lives from one cycle to another may outlive its stay in a file that does not rotate.
    pub(super) fn lives_long(&self, from: i32, to: i32) -> bool {
        to - from >= self.longest_stay
    }

    /// True when a value can go this way; `lives_long` as by [`lives_long`](Self::lives_long).
    pub(super) fn admits(&self, node: Node, path: &Path, lives_long: bool) -> bool {
        let overstays = lives_long && self.overstays(path);
        !overstays && !self.is_written_otherwise(node, path)
    }

    /// True when a way has a value stay in a file for longer than there can be registers for.
    fn overstays(&self, path: &Path) -> bool {
        path.route().runs.iter().any(|&(place, _, (first, last))| {
            let file = self.problem.graph.as_file(place);
            let rotates = |file| self.problem.srp.files[file].kind == FileKind::Rotating;
            last - first >= self.longest_stay && !file.is_some_and(rotates)
        })
    }

    /// The price of the registers that a node needs set before the loop on a unit.
    pub(super) fn price_of_constants(&self, needs: &Needs) -> i32 {
        let new = |wanted: &&(Place, Initial)| !self.constants.contains_key(*wanted);
        let price = |&(place, _): &(Place, Initial)| self.price_throughout(self.lanes.of[place]);
        needs.constants.iter().filter(new).map(price).sum()
    }

    /// The price of a register of a file in every slot.
    pub(super) fn price_throughout(&self, lane: usize) -> i32 {
        let price = |t: i32| self.market.price(self.market.hold_good(t, lane));
        (0..self.ii).map(price).sum()
    }

    fn take_all(&mut self, goods: &[Good]) -> i32 {
        let mut sum = 0;
        for &good in goods {
            sum += self.market.price(good);
            self.market.take(good);
        }
        sum
    }

    fn give_all_back(&mut self, goods: &[Good]) -> i32 {
        let mut sum = 0;
        for &good in goods {
            self.market.give_back(good);
            sum += self.market.price(good);
        }
        sum
    }

    /// All that a node takes on a unit but its result's output and its constants.
    fn goods_of_node(&self, node: Node, fu: Fu, time: i32, goods: &mut Vec<Good>) {
        let timing = self.problem.timing(node, fu);
        self.market.goods_of_operation(fu, time, timing, goods);
        if let Some(needs) = self.problem.needs(node, fu) {
            let read = |place: &Place| self.market.read_good(time, self.lanes.of[*place]);
            goods.extend(needs.reads.iter().map(read));
        }
    }

    /// The output that a node's result stands in.
    fn result_item(&self, node: Node, fu: Fu, time: i32) -> Option<Item> {
        let op = self.problem.dfg.nodes[node].op;
        let place = self.problem.graph.result_place(fu, op)?;
        let latency = self.problem.timing(node, fu).latency as i32;
        Some(Item::Out(place, time + latency))
    }

    /// Puts a node somewhere; returns the cost.
    pub(super) fn put(&mut self, node: Node, (fu, time): Position) -> i32 {
        let mut goods = std::mem::take(&mut self.scratch);
        goods.clear();
        self.goods_of_node(node, fu, time, &mut goods);
        let mut cost = self.take_all(&goods);
        self.scratch = goods;
        if let Some(item) = self.result_item(node, fu, time) {
            cost += self.take_item(node, item, None);
        }
        cost += self.count_constants(node, fu, true);
        self.at[node] = (fu, time);
        self.placed[node] = true;
        self.early += self.earliness(node);
        cost
    }

    /// Takes a node away; returns its cost. Its edges have no routes any more.
    pub(super) fn lift(&mut self, node: Node) -> i32 {
        self.early -= self.earliness(node);
        let (fu, time) = self.at[node];
        let mut goods = std::mem::take(&mut self.scratch);
        goods.clear();
        self.goods_of_node(node, fu, time, &mut goods);
        let mut cost = self.give_all_back(&goods);
        self.scratch = goods;
        if let Some(item) = self.result_item(node, fu, time) {
            cost += self.release_item(node, item, None);
        }
        cost += self.count_constants(node, fu, false);
        self.placed[node] = false;
        cost
    }

    /// Takes a node's constants, or gives them back; returns their cost.
    fn count_constants(&mut self, node: Node, fu: Fu, take: bool) -> i32 {
        let Some(needs) = self.problem.needs(node, fu) else {
            return 0;
        };
        let mut goods = Vec::new();
        for &wanted in &needs.constants {
            let count = self.constants.entry(wanted).or_insert(0);
            let changes = *count == u32::from(!take);
            *count = if take { *count + 1 } else { *count - 1 };
            if *count == 0 {
                self.constants.remove(&wanted);
            }
            if changes {
                let lane = self.lanes.of[wanted.0];
                goods.extend((0..self.ii).map(|t| self.market.hold_good(t, lane)));
            }
        }
        match take {
            true => self.take_all(&goods),
            false => self.give_all_back(&goods),
        }
    }

    /// Cycles by which a node's memory orders are not kept with nodes that are placed.
    pub(super) fn earliness(&self, node: Node) -> i64 {
        let issued = |n: Node| (n == node || self.placed[n]).then(|| self.at[n].1);
        let missing = |&o: &usize| {
            let order = &self.problem.orders[o];
            let (from, to) = (issued(order.from)?, issued(order.to)?);
            let span = self.ii * order.distance as i32;
            Some(i64::from((from + order.delay as i32 - to - span).max(0)))
        };
        let orders = &self.problem.orders_of[node];
        orders.iter().filter_map(missing).sum()
    }

    /// Takes the items of a route; returns the cost of those that its value did not have.
    pub(super) fn take(&mut self, e: usize, route: Path) -> i32 {
        let mut cost = 0;
        for &item in &route.items {
            let timing = self.item_timing(e, item);
            cost += self.take_item(self.problem.edges[e].from, item, timing);
        }
        self.routes[e] = Some(route);
        self.open -= 1;
        cost
    }

    /// Gives the route of an edge back, if it has one; returns its cost.
    pub(super) fn release(&mut self, e: usize) -> Option<(Path, i32)> {
        let route = self.routes[e].take()?;
        self.open += 1;
        let mut cost = 0;
        for &item in &route.items {
            let timing = self.item_timing(e, item);
            cost += self.release_item(self.problem.edges[e].from, item, timing);
        }
        Some((route, cost))
    }

    /// A list to fill with the items of a route.
    pub(super) fn new_list(&mut self) -> Vec<Item> {
        self.spare.pop().unwrap_or_default()
    }

    /// Keeps the list of a route that is dropped.
    pub(super) fn drop_list(&mut self, mut list: Vec<Item>) {
        list.clear();
        self.spare.push(list);
    }

    fn item_timing(&self, e: usize, item: Item) -> Option<&'p FuOp> {
        match item {
            Item::Move(fu, ..) => self.problem.move_timing(fu, self.problem.edges[e].ty),
            _ => None,
        }
    }

    fn take_item(&mut self, node: Node, item: Item, timing: Option<&FuOp>) -> i32 {
        let count = self.items[node].entry(item).or_insert(0);
        *count += 1;
        if *count > 1 {
            return 0;
        }
        let mut goods = std::mem::take(&mut self.scratch);
        goods.clear();
        self.market
            .goods_of_item(self.lanes, item, timing, &mut goods);
        let cost = self.take_all(&goods);
        self.scratch = goods;
        cost
    }

    fn release_item(&mut self, node: Node, item: Item, timing: Option<&FuOp>) -> i32 {
        let count = self.items[node].get_mut(&item);
        let count = count.expect("only taken items are released");
        *count -= 1;
        if *count > 0 {
            return 0;
        }
        self.items[node].remove(&item);
        let mut goods = std::mem::take(&mut self.scratch);
        goods.clear();
        self.market
            .goods_of_item(self.lanes, item, timing, &mut goods);
        let cost = self.give_all_back(&goods);
        self.scratch = goods;
        cost
    }

    /// True if a route would write a value into a second register of a file in one cycle: a result
    /// is written into at most one register of a file.
    fn is_written_otherwise(&self, node: Node, route: &Path) -> bool {
        let writes = |item: Item| match item {
            Item::Written(place, time, tag, _) => Some((place, time, tag)),
            _ => None,
        };
        let clashes = |(place, time, tag): (Place, i32, Tag)| {
            let others = self.items[node].keys().copied().filter_map(writes);
            let mut others = others.filter(|&(p, t, _)| (p, t) == (place, time));
            others.any(|(.., other)| other != tag)
        };
        let mut written = route.items.iter().copied().filter_map(writes);
        written.any(clashes)
    }

    /// Collects the places of a value from which its further routes may start.
    pub(super) fn own(&self, node: Node, tag: Option<Tag>, own: &mut Own) {
        own.stands.clear();
        own.tagged.clear();
        own.lands.clear();
        let (fu, _) = self.at[node];
        own.lands.push((self.ready(node), fu.index()));
        let ty = self.problem.dfg.ty(node).expect("only values are routed");
        for &item in self.items[node].keys() {
            match item {
                Item::Out(place, time) | Item::Held(place, time, Tag::Plain) => {
                    own.stands.push((time, self.lanes.of[place]));
                }
                Item::Held(place, time, other) if Some(other) == tag => {
                    own.tagged.push((time, self.lanes.of[place]));
                }
                Item::Move(fu, time, ..) => {
                    let timing = self.problem.move_timing(fu, ty);
                    let latency = timing.expect("moves go over movers").latency as i32;
                    own.lands.push((time + latency, fu.index()));
                }
                _ => {}
            }
        }
        own.sort();
    }

    /// True if a node or its values take an overused resource, or one of its edges has no route.
    /// `goods` is a list that is used again.
    pub(super) fn is_in_conflict(&self, node: Node, goods: &mut Vec<Good>) -> bool {
        if self.market.excess == 0 && self.open == 0 && self.early == 0 {
            return false;
        }
        let (fu, time) = self.at[node];
        let edges = &self.problem.edges_of[node];
        if edges.iter().any(|&e| self.routes[e].is_none()) || self.earliness(node) > 0 {
            return true;
        }
        goods.clear();
        self.goods_of_node(node, fu, time, goods);
        let ty = self.problem.dfg.ty(node);
        for &item in self.items[node].keys() {
            let timing = match item {
                Item::Move(fu, ..) => ty.and_then(|ty| self.problem.move_timing(fu, ty)),
                _ => None,
            };
            self.market.goods_of_item(self.lanes, item, timing, goods);
        }
        goods.iter().any(|&good| self.market.is_overused(good))
    }
}
