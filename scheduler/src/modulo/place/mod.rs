//! Placement: one attempt to give every node of a loop a unit and a cycle at one II, with every
//! value routed.
//!
//! There are two ways. [`Attempt::one_by_one`] is iterative modulo scheduling (Rau 1994) with
//! edge-centric routing (Park et al. 2008): a node goes where its values can be routed most cheaply
//! to and from everything placed already; where nothing fits it is [forced](force) in, and what is
//! in its way is routed anew or displaced and placed again later. [`Attempt::all_at_once`] takes
//! positions for all nodes, routes what can be routed, and [repairs](repair) the rest. The first is
//! quick where there is room, the second finds its way where there is little.

mod force;
mod position;
mod repair;
mod sequence;
mod span;
mod squeeze;
mod take;

use super::order::Freedom;
use super::problem::{Position, Problem};
use super::registers::Registers;
use super::route::{Route, Router};
use super::table::Table;
use repair::Journal;
use rustc_hash::FxHashMap;
use srp_archdesc::Watch;
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::Ty;
use srp_archdesc::resource::Place;
use srp_ir::dfg::Node;
use srp_ir::dre::scheduled::Reg;
use std::collections::{BTreeMap, BTreeSet};

/// Best positions that are all tried by routing before the node is forced.
const TRIES: usize = 12;
/// Successful positions compared.
const CHOICES: usize = 2;
/// The weight of an edge that failed again and again, and that of others, for the next attempt.
const HEAVIEST: u32 = 6;
pub(super) const LIGHTEST: u32 = 2;

/// Where and when everything is, at one II.
#[derive(Clone)]
pub(in crate::modulo) struct Placement {
    /// Initiation interval.
    pub(in crate::modulo) ii: u32,
    pub(in crate::modulo) table: Table,
    /// Unit and issue cycle of each node; cycles may be negative.
    pub(in crate::modulo) at: EntityMap<Node, Position>,
    /// The route of each edge.
    pub(in crate::modulo) routes: Vec<Route>,
    /// The registers of values and loop invariants.
    pub(in crate::modulo) registers: Registers,
}

/// Kinds of conflicts, counted to find the most frequent one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::modulo) enum Conflict {
    /// No unit was free for this node.
    Unit(Node),
    /// Units were free for this node, but not the outputs in the cycles in which its result lands.
    Output(Node),
    /// No unit that was free for this node was near enough to its neighbours.
    Reach(Node),
    /// This edge found no route.
    Route(usize),
    /// Values did not fit in the registers of this place.
    Registers(Place),
    /// A value lives so long in this place that it needs more copies of the loop than there are contexts for.
    Copies(Place),
    /// This place has too few read ports for constants and values from outside the loop.
    ReadPorts(Place),
}

/// One attempt.
pub(in crate::modulo) struct Attempt<'a, 'p> {
    problem: &'a Problem<'p>,
    table: Table,
    freedom: &'a Freedom,
    seed: u32,
    at: EntityMap<Node, Option<Position>>,
    routes: Vec<Option<Route>>,
    registers: Registers,
    router: &'a mut Router,
    forced: FxHashMap<(Node, Fu, usize), u32>,
    scarcity: EntityMap<Fu, u32>,
    conflicts: BTreeMap<Conflict, u32>,
    /// How often each node had to be forced.
    times_forced: EntityMap<Node, u32>,
    /// The cycle by which everything has landed, if no node may be issued outside of its freedom.
    deadline: Option<i32>,
    /// Changes made by the current move, while they are recorded.
    journal: Option<Journal>,
}

impl<'a, 'p> Attempt<'a, 'p> {
    pub(in crate::modulo) fn new(
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
            if let Some(rf) = problem.srp.central(ty) {
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
            forced: FxHashMap::default(),
            scarcity: scarcity(problem),
            conflicts: BTreeMap::new(),
            times_forced: EntityMap::filled(problem.dfg.nodes.len(), 0),
            deadline: None,
            journal: None,
            problem,
        }
    }

    /// Places the nodes in this order, or returns the most frequent conflict: when too many had to make room, the router
    /// has made `limit` steps, or the watch ends it.
    pub(in crate::modulo) fn one_by_one(
        &mut self,
        order: &[Node],
        limit: u64,
        watch: &dyn Watch,
    ) -> Result<Placement, Option<Conflict>> {
        self.place_all(order, order.iter().copied(), limit, watch)
    }

    /// Places these nodes, and again those that have to make room, by their rank in the order.
    fn place_all(
        &mut self,
        order: &[Node],
        nodes: impl Iterator<Item = Node>,
        limit: u64,
        watch: &dyn Watch,
    ) -> Result<Placement, Option<Conflict>> {
        let mut rank = EntityMap::filled(order.len(), 0);
        order.iter().enumerate().for_each(|(i, &n)| rank[n] = i);
        let mut queue: BTreeSet<(usize, Node)> = nodes.map(|n| (rank[n], n)).collect();
        let mut budget = 60 + 3 * order.len();
        while let Some((_, node)) = queue.pop_first() {
            if budget == 0 || self.router.expanded > limit || watch.cancelled() {
                return Err(self.worst());
            }
            budget -= 1;
            if self.place(node) {
                continue;
            }
            self.times_forced[node] += 1;
            let Some(displaced) = self.force(node) else {
                return Err(self.worst());
            };
            queue.extend(displaced.into_iter().map(|n| (rank[n], n)));
        }
        // A position that was forced and given up again can leave an edge behind.
        self.placement().ok_or_else(|| self.worst())
    }

    /// Takes these positions, routes between them and moves nodes until all is routed or the router
    /// has made `limit` steps, `spent` of them for the positions. Otherwise returns the most
    /// frequent conflict.
    pub(in crate::modulo) fn all_at_once(
        &mut self,
        positions: &EntityMap<Node, Position>,
        spent: u64,
        limit: u64,
        watch: &dyn Watch,
    ) -> Result<Placement, Option<Conflict>> {
        self.router.expanded += spent;
        self.begin_with(positions);
        self.repair(limit, watch).ok_or_else(|| self.worst())
    }

    /// Takes positions found otherwise, if they are free and keep the memory orders, and routes as
    /// many edges between them as possible.
    fn begin_with(&mut self, positions: &EntityMap<Node, Position>) {
        for (node, &(fu, time)) in positions.iter() {
            if self.is_free(node, fu, time) && self.keeps_orders(node, time) {
                self.occupy(node, fu, time);
            }
        }
        self.route_all(0..self.routes.len());
    }

    /// Everything as it stands, if it is complete.
    fn placement(&self) -> Option<Placement> {
        Some(Placement {
            ii: self.table.ii,
            at: self.at.values().copied().collect::<Option<_>>()?,
            routes: self.routes.iter().cloned().collect::<Option<_>>()?,
            registers: self.registers.clone(),
            table: self.table.clone(),
        })
    }

    /// The file whose registers did not suffice, if any.
    fn full(&self) -> Option<Place> {
        let full = self.conflicts.keys().filter_map(|conflict| match conflict {
            Conflict::Registers(place) | Conflict::Copies(place) => Some(*place),
            _ => None,
        });
        full.min()
    }

    /// Adds the forced nodes of this attempt to those of earlier ones, and raises the weights of
    /// edges that found no route.
    pub(in crate::modulo) fn report(
        &self,
        times_forced: &mut EntityMap<Node, u32>,
        weights: &mut [u32],
    ) {
        for (node, &times) in self.times_forced.iter() {
            times_forced[node] += times;
        }
        for conflict in self.conflicts.keys() {
            if let Conflict::Route(e) = conflict {
                weights[*e] = (weights[*e] + 1).min(HEAVIEST);
            }
        }
    }

    fn count_conflict(&mut self, conflict: Conflict) {
        *self.conflicts.entry(conflict).or_insert(0) += 1;
    }

    fn worst(&self) -> Option<Conflict> {
        self.conflicts
            .iter()
            .max_by_key(|&(o, &n)| (n, std::cmp::Reverse(*o)))
            .map(|(o, _)| *o)
    }

    /// Places a node where its routes are cheapest; false where no position works.
    fn place(&mut self, node: Node) -> bool {
        let positions = self.positions(node, false);
        if positions.is_empty() {
            self.count_conflict(self.why_nowhere(node));
            return false;
        }
        let mut found: Vec<(u32, Fu, i32)> = Vec::new();
        for rank in ranks().take_while(|&rank| rank < positions.len()) {
            let (estimate, fu, time) = positions[rank];
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
                    self.count_conflict(Conflict::Route(e));
                    self.remove(node);
                    return None;
                }
            }
        }
        Some(sum)
    }
}

/// The placement of units, cycles and routes that were found otherwise. If registers do not suffice
/// for them, returns the file of each route that got none as the error.
pub(super) fn adopt(
    problem: &Problem<'_>,
    ii: u32,
    freedom: &Freedom,
    fixed: &[Reg],
    at: &EntityMap<Node, Position>,
    routes: Vec<Route>,
) -> Result<Placement, Vec<Place>> {
    let mut router = Router::default();
    let mut attempt = Attempt::new(problem, ii, 0, freedom, fixed, &mut router);
    attempt.registers.look_harder();
    let mut full = Vec::new();
    for (node, &(fu, time)) in at.iter() {
        if !attempt.occupy(node, fu, time) {
            return Err(attempt.full().into_iter().collect());
        }
    }
    for (edge, route) in problem.edges.iter().zip(&routes) {
        if !attempt.take(edge, route) {
            return Err(full);
        }
        if let Some(place) = attempt.hold(edge, route) {
            full.push(place);
        }
    }
    if !full.is_empty() {
        return Err(full);
    }
    attempt.routes = routes.into_iter().map(Some).collect();
    attempt.placement().ok_or_else(Vec::new)
}

/// The ranks of the positions that are tried: all of the first, then fewer and fewer.
fn ranks() -> impl Iterator<Item = usize> {
    std::iter::successors(Some(0), |&rank: &usize| {
        Some(rank + 1 + rank.saturating_sub(TRIES) / 4)
    })
}

/// How precious each unit is: the share of the demand for its classes that rests on it.
fn scarcity(problem: &Problem<'_>) -> EntityMap<Fu, u32> {
    let mut scarcity = EntityMap::filled(problem.srp.fus.len(), 0);
    for node in problem.nodes() {
        let units = &problem.units[node];
        for &fu in units {
            scarcity[fu] += 40 / units.len() as u32;
        }
    }
    scarcity
}
