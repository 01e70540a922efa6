//! Placement: one attempt to give every node of a loop a unit and a cycle at one II, with every
//! value routed.
//!
//! Iterative modulo scheduling (Rau 1994) with edge-centric routing (Park et al. 2008): a node goes
//! where its values can be routed most cheaply to and from everything placed already. Where nothing
//! fits, it is forced in; whatever is in its way is routed anew or, failing that, displaced and
//! placed again later.

use super::noise::noise;
use super::order::Freedom;
use super::problem::{Edge, Problem};
use super::registers::{Keeper, Registers};
use super::route::{Request, Route, Router};
use super::table::{Issuer, Item, Table};
use rustc_hash::FxHashMap;
use srp_archdesc::arch::{Fu, FuOp};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::Ty;
use srp_archdesc::resource::Place;
use srp_ir::dfg::{Initial, Node, Operand};
use srp_ir::dre::scheduled::Reg;
use std::collections::{BTreeMap, BTreeSet};

/// Extra cycles beyond one II in which a place is looked for: room for routes.
const ROUTING_SLACK: i32 = 6;
/// Positions that are tried by routing before the node is forced.
const TRIES: usize = 12;
/// Successful positions compared.
const CHOICES: usize = 2;
/// Routes of one value that are tried, each without the files that were full.
const DETOURS: usize = 3;

/// Where and when everything is, at one II.
pub(super) struct Placement {
    pub(super) table: Table,
    /// Unit and issue cycle of each node; cycles may be negative.
    pub(super) at: EntityMap<Node, (Fu, i32)>,
    /// The route of each edge.
    pub(super) routes: Vec<Route>,
    /// The registers of values and loop invariants.
    pub(super) registers: Registers,
}

/// What most often stood in the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Obstacle {
    /// No unit was free for this node.
    Unit(Node),
    /// This edge found no route.
    Route(usize),
    /// Values did not fit in the registers of this place.
    Registers(Place),
}

/// One attempt.
pub(super) struct Attempt<'a, 'p> {
    problem: &'a Problem<'p>,
    table: Table,
    freedom: &'a Freedom,
    seed: u32,
    at: EntityMap<Node, Option<(Fu, i32)>>,
    routes: Vec<Option<Route>>,
    registers: Registers,
    router: &'a mut Router,
    history: EntityMap<Place, u32>,
    forced: FxHashMap<(Node, Fu, usize), u32>,
    scarcity: EntityMap<Fu, u32>,
    obstacles: BTreeMap<Obstacle, u32>,
    /// How often each node had to be forced.
    trouble: EntityMap<Node, u32>,
}

impl<'a, 'p> Attempt<'a, 'p> {
    pub(super) fn new(
        problem: &'a Problem<'p>,
        ii: u32,
        seed: u32,
        freedom: &'a Freedom,
        fixed: &[Reg],
        router: &'a mut Router,
    ) -> Attempt<'a, 'p> {
        let mut table = Table::new(problem, ii);
        for ty in Ty::ALL {
            let count = problem.dfg.live_ins.iter().filter(|l| l.ty == ty).count() as u32;
            if let Some(rf) = problem.arch.central(ty) {
                table.keep(problem.graph.file[rf], count);
            }
        }
        Attempt {
            table,
            freedom,
            seed,
            at: EntityMap::filled(problem.dfg.nodes.len(), None),
            routes: vec![None; problem.edges.len()],
            registers: Registers::new(problem, ii, fixed),
            router,
            history: EntityMap::filled(problem.graph.places.len(), 0),
            forced: FxHashMap::default(),
            scarcity: scarcity(problem),
            obstacles: BTreeMap::new(),
            trouble: EntityMap::filled(problem.dfg.nodes.len(), 0),
            problem,
        }
    }

    /// Places everything in this order, or says what stood in the way most often.
    pub(super) fn run(&mut self, order: &[Node]) -> Result<Placement, Option<Obstacle>> {
        let mut rank = EntityMap::filled(order.len(), 0);
        order.iter().enumerate().for_each(|(i, &n)| rank[n] = i);
        let mut queue: BTreeSet<(usize, Node)> = order.iter().map(|&n| (rank[n], n)).collect();
        let mut budget = 60 + 3 * order.len();
        while let Some((_, node)) = queue.pop_first() {
            if budget == 0 {
                return Err(self.worst());
            }
            budget -= 1;
            if self.place(node) {
                continue;
            }
            self.trouble[node] += 1;
            let Some(displaced) = self.force(node) else {
                return Err(self.worst());
            };
            queue.extend(displaced.into_iter().map(|n| (rank[n], n)));
        }
        // A position that was forced and given up again can leave an edge behind.
        self.placement().ok_or_else(|| self.worst())
    }

    /// Everything as it stands, if it is complete.
    fn placement(&self) -> Option<Placement> {
        Some(Placement {
            at: self.at.values().copied().collect::<Option<_>>()?,
            routes: self.routes.iter().cloned().collect::<Option<_>>()?,
            registers: self.registers.clone(),
            table: self.table.clone(),
        })
    }

    /// The file whose registers did not suffice, if any.
    fn full(&self) -> Option<Place> {
        self.obstacles.keys().find_map(|obstacle| match obstacle {
            Obstacle::Registers(place) => Some(*place),
            _ => None,
        })
    }

    /// Adds what gave trouble in this attempt to what did before.
    pub(super) fn report(&self, trouble: &mut EntityMap<Node, u32>) {
        for (node, &times) in self.trouble.iter() {
            trouble[node] += times;
        }
    }

    fn worst(&self) -> Option<Obstacle> {
        self.obstacles
            .iter()
            .max_by_key(|&(o, &n)| (n, std::cmp::Reverse(*o)))
            .map(|(o, _)| *o)
    }

    /// The cycles in which a node may be issued, the best first.
    fn window(&self, node: Node) -> Vec<i32> {
        let ii = self.table.ii as i32;
        let (mut earliest, mut latest) = (None::<i32>, None::<i32>);
        let mut after = |t: i32| earliest = Some(earliest.map_or(t, |e| e.max(t)));
        let mut before = |t: i32| latest = Some(latest.map_or(t, |l| l.min(t)));
        let own_latency = self.problem.min_latency(node) as i32;
        for &e in &self.problem.edges_of[node] {
            let edge = &self.problem.edges[e];
            let Some(to) = edge.to().filter(|&to| to != edge.from) else {
                continue;
            };
            let span = ii * edge.distance as i32;
            if to == node {
                if let Some((fu, t)) = self.at[edge.from] {
                    after(t + self.problem.timing(edge.from, fu).latency as i32 - span);
                }
            } else if let Some((_, t)) = self.at[to] {
                before(t + span - own_latency);
            }
        }
        for &o in &self.problem.orders_of[node] {
            let order = &self.problem.orders[o];
            let span = ii * order.distance as i32;
            if order.to == node && order.from != node {
                if let Some((_, t)) = self.at[order.from] {
                    after(t + order.delay as i32 - span);
                }
            } else if let Some((_, t)) = self.at[order.to] {
                before(t + span - order.delay as i32);
            }
        }
        let reach = ii + ROUTING_SLACK;
        match (earliest, latest) {
            (Some(e), Some(l)) => (e..=l.min(e + reach - 1)).collect(),
            (None, Some(l)) => (l - reach + 1..=l).rev().collect(),
            (Some(e), None) => (e..e + reach).collect(),
            (None, None) => {
                let e = self.freedom.earliest[node];
                (e..e + ii).collect()
            }
        }
    }

    /// Positions of a node with an estimate of their cost, cheapest first. Positions whose unit is
    /// taken are left out unless `occupied` asks for them.
    fn positions(&self, node: Node, occupied: bool) -> Vec<(u32, Fu, i32)> {
        let mut positions = Vec::new();
        for (late, &time) in self.window(node).iter().enumerate() {
            for &fu in &self.problem.units[node] {
                if !occupied && !self.is_free(node, fu, time) {
                    continue;
                }
                let Some(distance) = self.distance(node, fu, time) else {
                    continue;
                };
                let jitter = noise(
                    u64::from(self.seed),
                    node.index() as u64,
                    (fu.index() * 977 + late) as u64,
                );
                let mut cost = 10 * distance + 3 * late as u32 + self.scarcity[fu] + jitter % 8;
                if occupied {
                    cost += 25 * u32::from(!self.is_free(node, fu, time));
                    let key = (node, fu, self.table.slot(time));
                    cost += 40 * self.forced.get(&key).copied().unwrap_or(0);
                }
                positions.push((cost, fu, time));
            }
        }
        positions.sort_unstable();
        positions
    }

    fn result_item(&self, node: Node, fu: Fu, time: i32) -> Option<Item> {
        let op = self.problem.dfg.nodes[node].op;
        let place = self.problem.graph.result_place(fu, op)?;
        Some(Item::Out(
            place,
            time + self.problem.timing(node, fu).latency as i32,
        ))
    }

    fn is_free(&self, node: Node, fu: Fu, time: i32) -> bool {
        self.table.issues(fu, time, self.problem.timing(node, fu))
            && self
                .result_item(node, fu, time)
                .is_none_or(|i| self.table.fits(node, i, None))
    }

    /// How far a position is from the placed neighbours, in cycles that routes need at least;
    /// `None` where one of them cannot be reached in time.
    fn distance(&self, node: Node, fu: Fu, time: i32) -> Option<u32> {
        let problem = self.problem;
        let mut sum = 0;
        for &e in &problem.edges_of[node] {
            let edge = &problem.edges[e];
            let Some(to) = edge.to().filter(|&to| to != edge.from) else {
                continue;
            };
            let (from, target) = if to == node {
                (self.at[edge.from], Some((fu, time)))
            } else {
                (Some((fu, time)), self.at[to])
            };
            let (Some((from_fu, from_time)), Some((to_fu, to_time))) = (from, target) else {
                continue;
            };
            let op = problem.dfg.nodes[edge.from].op;
            let place = problem.graph.result_place(from_fu, op)?;
            let ready = from_time + problem.timing(edge.from, from_fu).latency as i32;
            let reach = problem.reach(edge.ty, place, to_fu);
            let arrival = to_time + self.table.ii as i32 * edge.distance as i32;
            if ready + reach as i32 > arrival {
                return None;
            }
            sum += reach;
        }
        Some(sum)
    }

    /// Places a node where its routes are cheapest; false where no position works.
    fn place(&mut self, node: Node) -> bool {
        let positions = self.positions(node, false);
        if positions.is_empty() {
            *self.obstacles.entry(Obstacle::Unit(node)).or_insert(0) += 1;
            return false;
        }
        let mut found: Vec<(u32, Fu, i32)> = Vec::new();
        for &(estimate, fu, time) in positions.iter().take(TRIES) {
            if let Some(cost) = self.try_position(node, fu, time) {
                found.push((estimate + cost, fu, time));
                self.remove(node);
                if found.len() == CHOICES {
                    break;
                }
            }
        }
        // Registers are packed otherwise by now, so that even these may fail.
        found.sort_unstable();
        (found.iter()).any(|&(_, fu, time)| self.try_position(node, fu, time).is_some())
    }

    /// Places a node here and routes its edges to placed neighbours; the cost of the routes, or
    /// `None`, and nothing changed, where that fails.
    fn try_position(&mut self, node: Node, fu: Fu, time: i32) -> Option<u32> {
        if !self.is_free(node, fu, time) || !self.occupy(node, fu, time) {
            return None;
        }
        let mut sum = 0;
        for e in self.edges_by_slack(node) {
            match self.route(e) {
                Some(cost) => sum += cost,
                None => {
                    *self.obstacles.entry(Obstacle::Route(e)).or_insert(0) += 1;
                    self.remove(node);
                    return None;
                }
            }
        }
        Some(sum)
    }

    /// Edges of a placed node whose other end is placed too, those with the least time first.
    fn edges_by_slack(&self, node: Node) -> Vec<usize> {
        let ii = self.table.ii as i32;
        let mut edges: Vec<(i32, usize)> = Vec::new();
        for &e in &self.problem.edges_of[node] {
            let edge = &self.problem.edges[e];
            let Some((_, from)) = self.at[edge.from] else {
                continue;
            };
            let span = match edge.to() {
                None => i32::MAX,
                Some(to) => match self.at[to] {
                    Some((_, t)) => t + ii * edge.distance as i32 - from,
                    None => continue,
                },
            };
            if self.routes[e].is_none() {
                edges.push((span, e));
            }
        }
        edges.sort_unstable();
        edges.into_iter().map(|(_, e)| e).collect()
    }

    /// Takes the unit, the output and the invariants of a node. False, and nothing taken, where the
    /// invariants do not fit.
    fn occupy(&mut self, node: Node, fu: Fu, time: i32) -> bool {
        if !self.take_constants(node, fu) {
            return false;
        }
        let reads = invariant_reads(self.problem, node, fu);
        if !self.table.take_reads(&reads, time) {
            self.release_constants(node, fu);
            return false;
        }
        let timing = self.problem.timing(node, fu);
        self.table.take_issue(fu, time, timing, Issuer::Node(node));
        if let Some(item) = self.result_item(node, fu, time) {
            self.table.take(node, item, None);
        }
        self.at[node] = Some((fu, time));
        true
    }

    /// Takes a node out again, with all its routes.
    fn remove(&mut self, node: Node) {
        let Some((fu, time)) = self.at[node] else {
            return;
        };
        for i in 0..self.problem.edges_of[node].len() {
            self.unroute(self.problem.edges_of[node][i]);
        }
        self.table
            .release_issue(fu, time, self.problem.timing(node, fu));
        if let Some(item) = self.result_item(node, fu, time) {
            self.table.release(node, item, None);
        }
        self.table
            .release_reads(&invariant_reads(self.problem, node, fu), time);
        self.release_constants(node, fu);
        self.at[node] = None;
    }

    fn release_constants(&mut self, node: Node, fu: Fu) {
        self.release_these(&self.constants_of(node, fu));
    }

    /// The registers of static files that a node on this unit needs set.
    fn constants_of(&self, node: Node, fu: Fu) -> Vec<(Place, Initial)> {
        constants_of(self.problem, node, fu)
    }

    fn take_constants(&mut self, node: Node, fu: Fu) -> bool {
        let wanted = self.constants_of(node, fu);
        for (i, &(place, value)) in wanted.iter().enumerate() {
            if !self.keep(place, Keeper::Invariant(value)) {
                self.release_these(&wanted[..i]);
                *self
                    .obstacles
                    .entry(Obstacle::Registers(place))
                    .or_insert(0) += 1;
                return false;
            }
        }
        true
    }

    fn release_these(&mut self, constants: &[(Place, Initial)]) {
        for &(place, value) in constants {
            self.unkeep(place, Keeper::Invariant(value));
        }
    }

    /// Gives something a register of its own.
    fn keep(&mut self, place: Place, keeper: Keeper) -> bool {
        let new = !self.registers.kept(place).any(|(k, _)| k == keeper);
        if new && !self.table.keep(place, 1) {
            return false;
        }
        let kept = self.registers.keep(place, keeper);
        if !kept && new {
            self.table.unkeep(place, 1);
        }
        kept
    }

    fn unkeep(&mut self, place: Place, keeper: Keeper) {
        self.registers.unkeep(place, keeper);
        if !self.registers.kept(place).any(|(k, _)| k == keeper) {
            self.table.unkeep(place, 1);
        }
    }

    /// Routes an edge whose ends are placed; its cost. Files whose registers do not suffice for the
    /// cheapest route are left out and the next best is tried, a few times.
    fn route(&mut self, e: usize) -> Option<u32> {
        let edge = &self.problem.edges[e];
        let request = self.request(edge);
        let mut banned = Vec::new();
        while banned.len() < DETOURS {
            let (route, cost) =
                self.router
                    .route(self.problem, &self.table, &request, &self.history, &banned)?;
            if !self.take(edge, &route) {
                return None;
            }
            let Some(full) = self.hold(edge, &route) else {
                self.routes[e] = Some(route);
                return Some(cost);
            };
            self.give_back(edge, &route.items);
            *self.obstacles.entry(Obstacle::Registers(full)).or_insert(0) += 1;
            banned.push(full);
        }
        None
    }

    /// Takes the items of a route; false, and nothing taken, where it is in its own way one II
    /// later.
    fn take(&mut self, edge: &Edge, route: &Route) -> bool {
        for (i, &item) in route.items.iter().enumerate() {
            let timing = self.item_timing(edge, item);
            if !self.table.fits(edge.from, item, timing) {
                self.give_back(edge, &route.items[..i]);
                return false;
            }
            self.table.take(edge.from, item, timing);
        }
        true
    }

    fn give_back(&mut self, edge: &Edge, items: &[Item]) {
        for &item in items {
            let timing = self.item_timing(edge, item);
            self.table.release(edge.from, item, timing);
        }
    }

    /// Gives a route its registers; the first file that has none, and nothing given.
    fn hold(&mut self, edge: &Edge, route: &Route) -> Option<Place> {
        if let Some((place, tag)) = route.kept
            && !self.registers.keep(place, Keeper::LiveOut(edge.from, tag))
        {
            return Some(place);
        }
        for (i, &(place, tag, run)) in route.runs.iter().enumerate() {
            if !self.registers.hold(place, edge, tag, run) {
                self.let_go(edge, route, i);
                return Some(place);
            }
        }
        None
    }

    /// Gives the registers of a route back: of the first `runs` of its runs.
    fn let_go(&mut self, edge: &Edge, route: &Route, runs: usize) {
        for &(place, tag, run) in &route.runs[..runs] {
            self.registers.release(place, edge.from, tag, run);
        }
        if let Some((place, tag)) = route.kept {
            self.registers
                .unkeep(place, Keeper::LiveOut(edge.from, tag));
        }
    }

    fn request(&self, edge: &Edge) -> Request {
        let (fu, time) = self.at[edge.from].expect("only edges with placed ends are routed");
        let ready = time + self.problem.timing(edge.from, fu).latency as i32;
        let target = edge.to().map(|to| {
            let (fu, time) = self.at[to].expect("only edges with placed ends are routed");
            (fu, time + self.table.ii as i32 * edge.distance as i32)
        });
        Request {
            from: edge.from,
            ty: edge.ty,
            fu,
            ready,
            target,
            tag: edge.tag,
        }
    }

    fn item_timing(&self, edge: &Edge, item: Item) -> Option<&'p FuOp> {
        match item {
            Item::Move(fu, ..) => self.problem.move_timing(fu, edge.ty),
            _ => None,
        }
    }

    fn unroute(&mut self, e: usize) {
        let Some(route) = self.routes[e].take() else {
            return;
        };
        let edge = &self.problem.edges[e];
        self.let_go(edge, &route, route.runs.len());
        self.give_back(edge, &route.items);
    }

    /// Puts a node somewhere and takes out what is in its way; the nodes to be placed again, or
    /// `None` where there is no position at all.
    fn force(&mut self, node: Node) -> Option<Vec<Node>> {
        let mut displaced = BTreeSet::new();
        let mut positions = self.positions(node, true);
        // Where neighbours leave no room, consumers give way first, then producers.
        for neighbours in [self.consumers(node), self.producers(node)] {
            if !positions.is_empty() {
                break;
            }
            for neighbour in neighbours {
                self.remove(neighbour);
                displaced.insert(neighbour);
            }
            positions = self.positions(node, true);
        }
        let &(_, fu, time) = positions.first()?;
        *self
            .forced
            .entry((node, fu, self.table.slot(time)))
            .or_insert(0) += 1;
        let mut ripped = self.clear(node, fu, time, &mut displaced);
        if !self.occupy(node, fu, time) {
            displaced.insert(node);
            return Some(displaced.into_iter().collect());
        }
        ripped.extend(self.edges_by_slack(node));
        for e in ripped {
            let edge = &self.problem.edges[e];
            let ends = [Some(edge.from), edge.to()];
            if ends.iter().flatten().any(|&n| self.at[n].is_none()) || self.routes[e].is_some() {
                continue;
            }
            if self.route(e).is_none() {
                *self.obstacles.entry(Obstacle::Route(e)).or_insert(0) += 1;
                let victim = if edge.from == node {
                    edge.to().unwrap_or(node)
                } else {
                    edge.from
                };
                self.remove(victim);
                displaced.insert(victim);
            }
        }
        if self.at[node].is_none() {
            displaced.insert(node);
        }
        Some(
            displaced
                .into_iter()
                .filter(|&n| self.at[n].is_none())
                .collect(),
        )
    }

    /// Placed nodes that must come after a node.
    fn consumers(&self, node: Node) -> BTreeSet<Node> {
        let edges = self.problem.edges_of[node]
            .iter()
            .map(|&e| &self.problem.edges[e]);
        let values = edges.filter(|e| e.from == node).filter_map(|e| e.to());
        let orders = self.problem.orders_of[node]
            .iter()
            .map(|&o| &self.problem.orders[o]);
        let orders = orders.filter(|o| o.from == node).map(|o| o.to);
        values
            .chain(orders)
            .filter(|&n| n != node && self.at[n].is_some())
            .collect()
    }

    /// Placed nodes that must come before a node.
    fn producers(&self, node: Node) -> BTreeSet<Node> {
        let edges = self.problem.edges_of[node]
            .iter()
            .map(|&e| &self.problem.edges[e]);
        let values = edges.filter(|e| e.to() == Some(node)).map(|e| e.from);
        let orders = self.problem.orders_of[node]
            .iter()
            .map(|&o| &self.problem.orders[o]);
        let orders = orders.filter(|o| o.to == node).map(|o| o.from);
        values
            .chain(orders)
            .filter(|&n| n != node && self.at[n].is_some())
            .collect()
    }

    /// Makes room for a node: displaces nodes that hold its unit, and rips up routes that hold its
    /// unit or its output; these edges come back.
    fn clear(
        &mut self,
        node: Node,
        fu: Fu,
        time: i32,
        displaced: &mut BTreeSet<Node>,
    ) -> Vec<usize> {
        let timing = self.problem.timing(node, fu);
        let mut ripped = Vec::new();
        for k in 0..timing.interval as i32 {
            match self.table.issuer(fu, time + k) {
                Some(Issuer::Node(other)) => {
                    self.remove(other);
                    displaced.insert(other);
                }
                Some(Issuer::Move(value)) => {
                    let slot = self.table.slot(time + k);
                    self.rip(value, &mut ripped, |table, item| match item {
                        Item::Move(unit, t, ..) => unit == fu && table.slot(t) == slot,
                        _ => false,
                    });
                }
                None => {}
            }
        }
        if let Some(Item::Out(place, lands)) = self.result_item(node, fu, time)
            && let Some(value) = self.table.standing(place, lands)
        {
            let slot = self.table.slot(lands);
            self.rip(value, &mut ripped, |table, item| match item {
                Item::Out(p, t) => p == place && table.slot(t) == slot,
                _ => false,
            });
            if self.table.standing(place, lands) == Some(value) {
                self.remove(value);
                displaced.insert(value);
            }
        }
        self.clear_shared(fu, time, timing, displaced);
        ripped
    }

    /// Displaces nodes until the shared resources of an operation are free.
    fn clear_shared(&mut self, fu: Fu, time: i32, timing: &FuOp, displaced: &mut BTreeSet<Node>) {
        for other in self.problem.nodes() {
            if self.table.issues(fu, time, timing) {
                return;
            }
            let Some((unit, t)) = self.at[other] else {
                continue;
            };
            let theirs = self.problem.timing(other, unit);
            let overlap = (0..timing.interval as i32).any(|k| {
                (0..theirs.interval as i32)
                    .any(|l| self.table.slot(time + k) == self.table.slot(t + l))
            });
            if overlap && theirs.uses.iter().any(|r| timing.uses.contains(r)) {
                self.remove(other);
                displaced.insert(other);
            }
        }
    }

    /// Takes up the routes of a value that have an item in the way.
    fn rip(&mut self, value: Node, ripped: &mut Vec<usize>, hit: impl Fn(&Table, Item) -> bool) {
        for i in 0..self.problem.edges_of[value].len() {
            let e = self.problem.edges_of[value][i];
            if self.problem.edges[e].from != value {
                continue;
            }
            let hits = |route: &Route| route.items.iter().any(|&item| hit(&self.table, item));
            if self.routes[e].as_ref().is_some_and(hits) {
                self.unroute(e);
                ripped.push(e);
            }
        }
    }
}

/// The placement of units, cycles and routes that were found otherwise; the file whose registers do
/// not suffice for them.
pub(super) fn adopt(
    problem: &Problem<'_>,
    ii: u32,
    freedom: &Freedom,
    fixed: &[Reg],
    at: &EntityMap<Node, (Fu, i32)>,
    routes: Vec<Route>,
) -> Result<Placement, Place> {
    let mut router = Router::default();
    let mut attempt = Attempt::new(problem, ii, 0, freedom, fixed, &mut router);
    for (node, &(fu, time)) in at.iter() {
        if !attempt.occupy(node, fu, time) {
            return Err(attempt.full().expect("only registers can run out"));
        }
    }
    for (edge, route) in problem.edges.iter().zip(&routes) {
        assert!(attempt.take(edge, route), "routes that were found fit");
        if let Some(full) = attempt.hold(edge, route) {
            return Err(full);
        }
    }
    attempt.routes = routes.into_iter().map(Some).collect();
    Ok(attempt
        .placement()
        .expect("everything is placed and routed"))
}

/// The registers of static files that a node on a unit needs set: invariants that the unit cannot
/// take from a central file, and constants beyond those of its context.
pub(super) fn constants_of(problem: &Problem<'_>, node: Node, fu: Fu) -> Vec<(Place, Initial)> {
    let mut constants = problem.arch.fus[fu].constants;
    let mut wanted = Vec::new();
    for operand in &problem.dfg.nodes[node].operands {
        let (ty, value) = match *operand {
            Operand::Const(bits) if bits.ty() == Ty::Pred => continue,
            Operand::Const(_) if constants > 0 => {
                constants -= 1;
                continue;
            }
            Operand::Const(bits) => (bits.ty(), Initial::Const(bits)),
            Operand::LiveIn(i) => (problem.dfg.live_ins[i as usize].ty, Initial::LiveIn(i)),
            Operand::Node { .. } => continue,
        };
        let central = matches!(value, Initial::LiveIn(_)) && problem.reads_central(fu, ty);
        if !central {
            let place = problem
                .constant_place(fu, ty)
                .expect("the unit was found to run the node");
            wanted.push((place, value));
        }
    }
    wanted
}

/// The files that a node on a unit reads invariants from, once for each register.
pub(super) fn invariant_reads(problem: &Problem<'_>, node: Node, fu: Fu) -> Vec<Place> {
    let from_static = constants_of(problem, node, fu);
    let mut central = Vec::new();
    for operand in &problem.dfg.nodes[node].operands {
        let Operand::LiveIn(i) = *operand else {
            continue;
        };
        let ty = problem.dfg.live_ins[i as usize].ty;
        if problem.reads_central(fu, ty) && !central.iter().any(|&(j, _)| i == j) {
            let file = problem.arch.central(ty).expect("a unit reads it");
            central.push((i, problem.graph.file[file]));
        }
    }
    let central = central.into_iter().map(|(_, place)| place);
    from_static
        .into_iter()
        .map(|(place, _)| place)
        .chain(central)
        .collect()
}

/// How precious each unit is: the share of the demand for its classes that rests on it.
fn scarcity(problem: &Problem<'_>) -> EntityMap<Fu, u32> {
    let mut scarcity = EntityMap::filled(problem.arch.fus.len(), 0);
    for node in problem.nodes() {
        let units = &problem.units[node];
        for &fu in units {
            scarcity[fu] += 40 / units.len() as u32;
        }
    }
    scarcity
}
