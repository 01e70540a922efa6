//! Taking and giving back: units, outputs, constants and read ports of nodes, and the routes of
//! values with their registers.

use super::{Attempt, Conflict};
use crate::modulo::problem::{Edge, longest_way_out};
use crate::modulo::registers::Keeper;
use crate::modulo::route::{Request, Route};
use crate::modulo::table::{Issuer, Item};
use srp_archdesc::arch::{Fu, FuOp};
use srp_archdesc::resource::Place;
use srp_ir::dfg::{Initial, Node};

/// Routes of one value that are tried, each without the files that were full.
const DETOURS: usize = 3;
/// Iterations that a value crosses without meeting itself on its way, mostly.
const FAR: u32 = 8;

impl<'p> Attempt<'_, 'p> {
    /// Those of some edges that have no route yet and whose ends are placed, the ones with the least
    /// time first.
    pub(super) fn by_slack(&self, edges: impl IntoIterator<Item = usize>) -> Vec<usize> {
        let ii = self.table.ii as i32;
        let mut found: Vec<(i32, usize)> = Vec::new();
        for e in edges {
            let edge = &self.problem.edges[e];
            let Some((_, from)) = self.at[edge.from].filter(|_| self.routes[e].is_none()) else {
                continue;
            };
            let span = match edge.to() {
                None => i32::MAX,
                Some(to) => match self.at[to] {
                    Some((_, t)) => t + ii * edge.distance as i32 - from,
                    None => continue,
                },
            };
            found.push((span, e));
        }
        found.sort_unstable();
        found.into_iter().map(|(_, e)| e).collect()
    }

    /// Edges of a placed node whose other end is placed too, those with the least time first.
    pub(super) fn edges_by_slack(&self, node: Node) -> Vec<usize> {
        self.by_slack(self.problem.edges_of[node].iter().copied())
    }

    /// Routes those of some edges that can be routed.
    pub(super) fn route_all(&mut self, edges: impl IntoIterator<Item = usize>) {
        for e in self.by_slack(edges) {
            if self.route(e).is_none() {
                self.count_conflict(Conflict::Route(e));
            }
        }
    }

    /// Takes the unit, the output and the invariants of a node. False, and nothing taken, where the
    /// invariants do not fit.
    pub(super) fn occupy(&mut self, node: Node, fu: Fu, time: i32) -> bool {
        if !self.take_needs(node, fu, time) {
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
    pub(super) fn remove(&mut self, node: Node) {
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
        if let Some(needs) = self.problem.needs(node, fu) {
            self.table.release_reads(&needs.reads, time);
            self.release_these(&needs.constants);
        }
        self.at[node] = None;
        if let Some(journal) = &mut self.journal {
            journal.nodes.push((node, (fu, time)));
        }
    }

    /// Takes the registers and read ports of a node on a unit; false, and nothing taken, where they do not suffice.
    fn take_needs(&mut self, node: Node, fu: Fu, time: i32) -> bool {
        let Some(needs) = self.problem.needs(node, fu) else {
            return true;
        };
        for (i, &(place, value)) in needs.constants.iter().enumerate() {
            if !self.keep(place, Keeper::Invariant(value)) {
                self.release_these(&needs.constants[..i]);
                self.count_conflict(Conflict::Registers(place));
                return false;
            }
        }
        if let Err(place) = self.table.take_reads(&needs.reads, time) {
            self.release_these(&needs.constants);
            self.count_conflict(Conflict::ReadPorts(place));
            return false;
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
    pub(super) fn route(&mut self, e: usize) -> Option<u32> {
        let edge = &self.problem.edges[e];
        let request = self.request(edge);
        let mut banned = Vec::new();
        let distance = edge.distance;
        let mut is_careful = false;
        while banned.len() < DETOURS {
            let found =
                (self.router).route(self.problem, &self.table, &request, &banned, is_careful);
            let full = match found {
                Some((route, cost)) => match self.take_route(e, route) {
                    Ok(()) => return Some(cost),
                    Err(full) => full,
                },
                None if banned.is_empty() => return None,
                None => None,
            };
            match full {
                Some(full) => banned.push(full),
                None if is_careful || distance <= FAR => return None,
                None => {
                    banned.clear();
                    is_careful = true;
                }
            }
        }
        None
    }

    /// Takes a route with its registers. If that is impossible, it takes nothing, and returns the
    /// file that has too few registers, if that is the reason.
    pub(super) fn take_route(&mut self, e: usize, route: Route) -> Result<(), Option<Place>> {
        let edge = &self.problem.edges[e];
        if !self.take(edge, &route) {
            return Err(None);
        }
        if let Some(full) = self.hold(edge, &route) {
            self.give_back(edge, &route.items);
            self.count_conflict(match self.registers.lacks_copies(full) {
                true => Conflict::Copies(full),
                false => Conflict::Registers(full),
            });
            return Err(Some(full));
        }
        self.routes[e] = Some(route);
        Ok(())
    }

    /// Takes the items of a route; false, and nothing taken, where it is in its own way one II
    /// later.
    pub(super) fn take(&mut self, edge: &Edge, route: &Route) -> bool {
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

    pub(super) fn give_back(&mut self, edge: &Edge, items: &[Item]) {
        for &item in items {
            let timing = self.item_timing(edge, item);
            self.table.release(edge.from, item, timing);
        }
    }

    /// Gives a route its registers; the first file that has none, and nothing given.
    pub(super) fn hold(&mut self, edge: &Edge, route: &Route) -> Option<Place> {
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
        let until = match target {
            Some((_, arrival)) => arrival,
            None => ready + longest_way_out(self.table.ii as i32),
        };
        Request {
            from: edge.from,
            ty: edge.ty,
            fu,
            ready,
            target,
            until: self.deadline.map_or(until, |deadline| until.min(deadline)),
            tag: edge.tag,
        }
    }

    fn item_timing(&self, edge: &Edge, item: Item) -> Option<&'p FuOp> {
        match item {
            Item::Move(fu, ..) => self.problem.move_timing(fu, edge.ty),
            _ => None,
        }
    }

    pub(super) fn unroute(&mut self, e: usize) {
        let Some(route) = self.routes[e].take() else {
            return;
        };
        let edge = &self.problem.edges[e];
        self.let_go(edge, &route, route.runs.len());
        self.give_back(edge, &route.items);
        if let Some(journal) = &mut self.journal {
            journal.routes.push((e, route));
        }
    }
}
