//! The cost of a node at every position: the operation itself, the delivery of its operands, and
//! that of its result.

mod distances;
mod kind;
mod rows;

use super::deliver::{Deliver, Goal, Map, Own};
use super::state::State;
use super::{LATE, MOST_LATE};
use crate::modulo::problem::{self, Edge, Position, Problem, longest_way_out};
use crate::modulo::rows::{NEVER, wide};
use crate::modulo::scale::{LIGHTEST, Scale};
use distances::Distances;
use kind::Kind;
use rows::{add, least_of, operation_row};
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::Ty;
use srp_ir::dfg::Node;

/// The cost of what cannot be.
const FAR: i32 = NEVER as i32 * 64;

/// Cycles before the first in which the neighbours allow a node, and beyond two IIs after it, that are
/// looked at too: neighbours move later.
const BEFORE: i32 = 3;
const AFTER: i32 = 4;
/// Cycles beyond an II that are looked at at a time.
const PART: i32 = 4;
/// Cycles that are of interest, at most.
pub(super) const WIDEST: i32 = 64;

/// The costs of all positions of one node, with buffers that are used again.
pub(super) struct Survey {
    distances: Distances,
    map: Map,
    own: Own,
    /// The first cycle, and costs by cycle and unit.
    from: i32,
    cycles: usize,
    stride: usize,
    totals: Vec<i32>,
    kinds: EntityMap<Node, Kind>,
    /// The least of each row of costs.
    mins: Vec<i32>,
    /// Positions that may be drawn: sums of weights up to each, and where it is among the costs.
    chances: Vec<(u64, u32)>,
    /// The earlier edge that each is like in everything but the operand, if there is one.
    twins: Vec<Option<usize>>,
    /// Lanes of rows that have been computed, the measure of effort.
    pub(super) lanes: u64,
    /// The cost of each edge while it has no route.
    pub(super) open: Vec<i32>,
}

/// The first of the edges that are like each: from one node to another, as far apart.
fn twins(problem: &Problem<'_>) -> Vec<Option<usize>> {
    let same = |a: &Edge, b: &Edge| {
        a.to().is_some()
            && (a.from, a.to(), a.distance, a.tag) == (b.from, b.to(), b.distance, b.tag)
    };
    let edges = &problem.edges;
    let first = |e: usize| {
        let like = problem.edges_of[edges[e].from].iter().copied();
        like.filter(|&other| other < e)
            .find(|&other| same(&edges[other], &edges[e]))
    };
    (0..edges.len()).map(first).collect()
}

impl Survey {
    pub(super) fn new(state: &State<'_, '_>, open: i32) -> Survey {
        let (problem, stride) = (state.problem, state.lanes.stride);
        Survey {
            distances: Distances::of(problem, stride),
            kinds: problem
                .nodes()
                .map(|n| Kind::of(state, n, stride))
                .collect(),
            mins: Vec::new(),
            chances: Vec::new(),
            map: Map::default(),
            own: Own::default(),
            from: 0,
            cycles: 0,
            stride,
            totals: Vec::new(),
            twins: twins(problem),
            lanes: 0,
            open: vec![open; problem.edges.len()],
        }
    }

    /// Cycles by which the ends of an edge are too near to each other for any route.
    fn lateness(&self, state: &State<'_, '_>, e: usize) -> i32 {
        let edge = &state.problem.edges[e];
        let Some(to) = edge.to() else { return 0 };
        let (fu, time) = state.at[to];
        let arrival = time + state.ii * edge.distance as i32;
        let (from, _) = state.at[edge.from];
        let reach = self.distances.between(edge.ty, from, fu);
        (state.ready(edge.from) + reach - arrival).clamp(0, MOST_LATE)
    }

    /// Returns the cost of an edge that has no route.
    pub(super) fn price_of_open(&self, state: &State<'_, '_>, e: usize) -> i32 {
        self.open[e] + LATE * self.lateness(state, e)
    }

    /// The cycles in which a node may be looked for: within its freedom, if there is one.
    fn window(
        &self,
        state: &State<'_, '_>,
        node: Node,
        within: Option<(i32, i32)>,
        random: u32,
    ) -> (i32, i32) {
        let (from, to) = self.window_between_neighbours(state, node, random);
        let Some((first, last)) = within else {
            return (from, to);
        };
        let more = to - from;
        let from = from.min(last - more).max(first);
        (from, (from + more).min(last))
    }

    /// The cycles in which a node may be looked for, by its neighbours; `random` decides among many.
    fn window_between_neighbours(
        &self,
        state: &State<'_, '_>,
        node: Node,
        random: u32,
    ) -> (i32, i32) {
        let (first, last) = state.between_neighbours(node);
        // All that is of interest, and a part of it that has every slot: any part, half of the time the one
        // next to the operands.
        let whole = (2 * state.ii + BEFORE + AFTER).min(WIDEST);
        let length = (state.ii + PART).min(whole);
        let pick = |room: i32| match random >> 31 {
            0 => ((u64::from(random << 1) * (room.max(0) as u64 + 1)) >> 32) as i32,
            _ => 0,
        };
        let from = match (first, last) {
            (Some(first), Some(last)) => {
                let room = (last - first).clamp(whole - BEFORE - AFTER, WIDEST);
                first.min(last) - BEFORE + pick(room + BEFORE + AFTER - length)
            }
            (Some(first), None) => first - BEFORE + pick(whole - length),
            (None, Some(last)) => last + BEFORE + 1 - length - pick(whole - length),
            (None, None) => state.at[node].1 - length / 2,
        };
        (from, from + length - 1)
    }

    /// Computes what positions of a node cost that has been taken out: those next to its neighbours, between two cycles if
    /// it must lie there.
    pub(super) fn look(
        &mut self,
        state: &State<'_, '_>,
        node: Node,
        within: Option<(i32, i32)>,
        random: u32,
    ) {
        let cycles = self.window(state, node, within, random);
        self.look_between(state, node, cycles);
    }

    /// Computes what every position between two cycles costs of a node that has been taken out.
    pub(super) fn look_between(&mut self, state: &State<'_, '_>, node: Node, cycles: (i32, i32)) {
        wide!(self.look_here(state, node, cycles) => self.look_wide(state, node, cycles));
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn look_wide(&mut self, state: &State<'_, '_>, node: Node, cycles: (i32, i32)) {
        self.look_here(state, node, cycles);
    }

    #[inline(always)]
    fn look_here(&mut self, state: &State<'_, '_>, node: Node, (from, to): (i32, i32)) {
        self.from = from;
        self.cycles = (to - from + 1) as usize;
        self.totals.clear();
        self.totals.resize(self.cycles * self.stride, FAR);
        self.operations(state, node);
        self.orders(state, node);
        for i in 0..state.problem.edges_of[node].len() {
            let e = state.problem.edges_of[node][i];
            let edge = &state.problem.edges[e];
            if self.twins[e].is_some() || edge.to() == Some(edge.from) {
                continue;
            }
            if edge.from == node {
                self.result(state, node, e);
            } else {
                self.operand(state, e);
            }
        }
    }

    /// Adds the cost of the operation by itself.
    #[inline(always)]
    fn operations(&mut self, state: &State<'_, '_>, node: Node) {
        let stride = self.stride;
        let kind = &self.kinds[node];
        let slots = (state.ii as usize).min(self.cycles);
        for group in &kind.groups {
            for slot in 0..slots {
                let time = self.from + slot as i32;
                let issue = state.market.issue_row(state.market.slot(time));
                let totals = &mut self.totals[slot * stride..][..stride];
                match group.result {
                    Some((block, latency)) => {
                        let hold = state.market.hold_row(state.market.slot(time + latency));
                        operation_row(totals, issue, Some(&hold[block..]), &group.mask);
                    }
                    None => operation_row(totals, issue, None, &group.mask),
                }
            }
        }
        for i in 0..self.kinds[node].odd.len() {
            let fu = self.kinds[node].odd[i];
            self.odd_operation(state, node, fu, slots);
        }
        let (first, rest) = self.totals.split_at_mut(slots * stride);
        for rest in rest.chunks_mut(slots * stride) {
            let length = rest.len();
            rest.copy_from_slice(&first[..length]);
        }
    }

    /// Adds its cost on a unit by itself, where it holds more than an issue slot and an output.
    #[inline(always)]
    fn odd_operation(&mut self, state: &State<'_, '_>, node: Node, fu: Fu, slots: usize) {
        let problem = state.problem;
        let timing = problem.timing(node, fu);
        if timing.interval as i32 > state.ii {
            return;
        }
        let needs = state.problem.needs(node, fu);
        let constants = needs.map_or(0, |needs| state.price_of_constants(needs));
        let result = problem.graph.result_place(fu, problem.dfg.nodes[node].op);
        for slot in 0..slots {
            let time = self.from + slot as i32;
            let tiles = state.tiles[fu].filter(|tiles| tiles.suit(timing));
            if tiles.is_some_and(|tiles| !tiles.begin_in(time)) {
                continue;
            }
            let mut price = constants + state.market.operation(fu, time, timing);
            if let Some(place) = result {
                let lane = state.lanes.of[place];
                let lands = time + timing.latency as i32;
                price += state.market.price(state.market.hold_good(lands, lane));
            }
            for &place in needs.map_or(&[][..], |needs| &needs.reads) {
                let lane = state.lanes.of[place];
                price += state.market.price(state.market.read_good(time, lane));
            }
            self.totals[slot * self.stride + fu.index()] = price;
        }
    }

    /// Adds the cost of memory orders that are not kept.
    fn orders(&mut self, state: &State<'_, '_>, node: Node) {
        for &o in &state.problem.orders_of[node] {
            let order = &state.problem.orders[o];
            if order.from == order.to {
                continue;
            }
            let (span, delay) = (state.ii * order.distance as i32, order.delay as i32);
            for cycle in 0..self.cycles {
                let time = self.from + cycle as i32;
                let early = match order.to == node {
                    true => state.at[order.from].1 + delay - span - time,
                    false => time + delay - span - state.at[order.to].1,
                };
                if early > 0 {
                    let price = super::price_of_early(i64::from(early)) as i32;
                    let row = &mut self.totals[cycle * self.stride..][..self.stride];
                    row.iter_mut().for_each(|total| *total += price);
                }
            }
        }
    }

    /// Adds what the delivery of an operand costs.
    #[inline(always)]
    fn operand(&mut self, state: &State<'_, '_>, e: usize) {
        let edge = &state.problem.edges[e];
        let span = state.ii * edge.distance as i32;
        let ready = state.ready(edge.from);
        let last = self.from + self.cycles as i32 - 1 + span;
        if last >= ready {
            state.own(edge.from, edge.tag, &mut self.own);
            let tagged = edge.tag.is_some();
            deliver(state, (ready, last)).forward(
                edge.ty,
                &self.own,
                (ready, last),
                tagged,
                &mut self.map,
            );
        } else {
            self.map.empty();
        }
        let (from, _) = state.at[edge.from];
        let reach = &self.distances.from[edge.ty as usize][from.index()];
        for cycle in 0..self.cycles {
            let arrival = self.from + cycle as i32 + span;
            let row = &mut self.totals[cycle * self.stride..][..self.stride];
            let late = ready - arrival;
            add(row, self.map.inputs_row(arrival), self.open[e], late, reach);
        }
        self.lanes += (self.map.cycles * self.stride) as u64;
    }

    /// Adds what the delivery of the result over an edge costs.
    #[inline(always)]
    fn result(&mut self, state: &State<'_, '_>, node: Node, e: usize) {
        let problem = state.problem;
        let edge = &problem.edges[e];
        let least = problem.min_latency(node) as i32;
        let first = self.from + least;
        let Some(to) = edge.to() else {
            let Some(place) = kept_in(problem, edge.ty) else {
                return;
            };
            let last = self.from + self.cycles as i32 + 2 * state.ii;
            let last = state.deadline.map_or(last, |deadline| last.min(deadline));
            let last = last.max(first);
            let goal = Goal::Keep(
                state.lanes.of[place],
                state.price_throughout(state.lanes.of[place]),
            );
            deliver(state, (first, last)).backward(
                edge.ty,
                goal,
                (first, last),
                true,
                &mut self.map,
            );
            self.add_result(state, node, e, i32::MAX / 2, None);
            return;
        };
        let (fu, time) = state.at[to];
        let arrival = time + state.ii * edge.distance as i32;
        if arrival >= first {
            let goal = Goal::Operand(fu.index());
            let tagged = edge.tag.is_some();
            deliver(state, (first, arrival)).backward(
                edge.ty,
                goal,
                (first, arrival),
                tagged,
                &mut self.map,
            );
        } else {
            self.map.empty();
        }
        self.add_result(state, node, e, arrival, Some(fu));
    }

    #[inline(always)]
    fn add_result(
        &mut self,
        state: &State<'_, '_>,
        node: Node,
        e: usize,
        arrival: i32,
        to: Option<Fu>,
    ) {
        let problem = state.problem;
        let ty = problem.edges[e].ty;
        let open = self.open[e];
        let anywhere = &self.distances.nowhere;
        self.lanes += (self.map.cycles * self.stride) as u64;
        let reach = to.map_or(anywhere, |to| &self.distances.to[ty as usize][to.index()]);
        if let Some(latency) = self.kinds[node].latency {
            for cycle in 0..self.cycles {
                let lands = self.from + cycle as i32 + latency;
                let row = &mut self.totals[cycle * self.stride..][..self.stride];
                let late = lands.saturating_sub(arrival);
                add(row, self.map.lands_row(lands), open, late, reach);
            }
            return;
        }
        for &fu in &problem.units[node] {
            let latency = problem.timing(node, fu).latency as i32;
            let reach = i32::from(reach[fu.index()]);
            for cycle in 0..self.cycles {
                let lands = self.from + cycle as i32 + latency;
                let late = (lands + reach).saturating_sub(arrival).clamp(0, MOST_LATE);
                let cost = i32::from(self.map.lands(lands, fu.index()));
                self.totals[cycle * self.stride + fu.index()] += cost.min(open + LATE * late);
            }
        }
    }

    /// Draws a position: the less it costs beyond the least, the more likely, half as likely for each
    /// `half` 16ths. `random` is a number of 32 bits.
    pub(super) fn draw(&mut self, half: i32, random: u32) -> Option<Position> {
        wide!(self.draw_here(half, random) => self.draw_wide(half, random))
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn draw_wide(&mut self, half: i32, random: u32) -> Option<Position> {
        self.draw_here(half, random)
    }

    #[inline(always)]
    fn draw_here(&mut self, half: i32, random: u32) -> Option<Position> {
        let rows = self.totals.chunks_exact(self.stride);
        self.mins.clear();
        self.mins.extend(rows.clone().map(|row| least_of(row, FAR)));
        let least = self.mins.iter().copied().min()?;
        if least >= FAR {
            return None;
        }
        // What costs more has no weight.
        let most = least + (LIGHTEST + 1) * half / 16;
        let scale = Scale::of(half);
        self.chances.clear();
        let mut sum = 0u64;
        for (cycle, row) in rows.enumerate() {
            if self.mins[cycle] >= most {
                continue;
            }
            for (unit, &cost) in row.iter().enumerate() {
                if cost < most {
                    sum += u64::from(scale.weight(cost - least));
                    self.chances
                        .push((sum, (cycle * self.stride + unit) as u32));
                }
            }
        }
        let drawn = (u64::from(random) * sum) >> 32;
        let index = self.chances.partition_point(|&(up_to, _)| up_to <= drawn);
        let (_, at) = *self.chances.get(index)?;
        let (cycle, unit) = (at as usize / self.stride, at as usize % self.stride);
        Some((Fu::new(unit), self.from + cycle as i32))
    }

    /// Routes an edge whose ends are placed, and takes the route where it costs less than none; what
    /// that costs.
    pub(super) fn route(&mut self, state: &mut State<'_, '_>, e: usize) -> i32 {
        let problem = state.problem;
        let edge = &problem.edges[e];
        let open = self.price_of_open(state, e);
        if let Some(twin) = self.twins[e] {
            return match state.routes[twin].clone() {
                Some(route) => state.take(e, route),
                None => open,
            };
        }
        let ready = state.ready(edge.from);
        let last = match edge.goal {
            problem::Goal::Operand(to, _) => state.at[to].1 + state.ii * edge.distance as i32,
            problem::Goal::LiveOut(_) => {
                let last = ready + longest_way_out(state.ii);
                state.deadline.map_or(last, |deadline| last.min(deadline))
            }
        };
        if last < ready {
            return open;
        }
        state.own(edge.from, edge.tag, &mut self.own);
        let items = state.new_list();
        let lives_long = state.lives_long(ready, last);
        let tagged = edge.tag.is_some();
        deliver(state, (ready, last)).forward_wide(
            edge.ty,
            &self.own,
            (ready, last),
            tagged,
            &mut self.map,
        );
        self.lanes += (self.map.cycles * self.stride) as u64;
        let trace = super::trace::Trace {
            state,
            map: &self.map,
            node: edge.from,
            ty: edge.ty,
            tag: edge.tag,
            lives_long,
        };
        let route = match edge.to() {
            Some(to) => {
                let (fu, _) = state.at[to];
                let row = self.map.inputs_row(last);
                let cost = row.map_or(NEVER, |row| row[fu.index()]);
                (i32::from(cost) < open).then(|| trace.to_operand(fu, last, items))
            }
            None => kept_in(problem, edge.ty).map(|place| trace.to_keep(place, items)),
        };
        match route.flatten() {
            Some(route) if state.admits(edge.from, &route, lives_long) => state.take(e, route),
            _ => open,
        }
    }
}

/// The file in which values of a type are kept after the loop.
fn kept_in(problem: &Problem<'_>, ty: Ty) -> Option<srp_archdesc::resource::Place> {
    problem.srp.central(ty).map(|file| problem.graph.file[file])
}

/// Deliveries of a value in a stretch of cycles.
fn deliver<'s>(state: &'s State<'_, '_>, (from, to): (i32, i32)) -> Deliver<'s> {
    Deliver {
        lanes: state.lanes,
        market: &state.market,
        lives_long: state.lives_long(from, to),
        deadline: state.deadline.unwrap_or(i32::MAX),
    }
}
