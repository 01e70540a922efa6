//! The cost of a node at every position: the operation itself, the delivery of its operands, and that of
//! its result.

use super::delivery::Map;
use super::state::{State, price_of_early};
use super::{FAR, LATE};
use crate::modulo::problem::Position;
use crate::modulo::rows::{VECTOR, wide};
use crate::modulo::scale::{LIGHTEST, Scale};
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_ir::dfg::Node;

/// Cycles outside of those that the neighbours allow that are looked at too: neighbours move later.
const AROUND: i32 = 3;
/// Cycles beyond an II that are looked at, at least.
const PART: i32 = 4;

/// First and last cycle in which each node may be.
pub(super) struct Horizon {
    pub(super) earliest: EntityMap<Node, i32>,
    pub(super) latest: EntityMap<Node, i32>,
}

/// The costs of all positions of one node, with buffers that are used again.
#[derive(Default)]
pub(super) struct Survey {
    pub(super) map: Map,
    /// The first cycle, and costs by cycle and lane.
    from: i32,
    totals: Vec<i32>,
    /// The least of each row of costs.
    least: Vec<i32>,
    /// Positions that may be drawn: sums of weights up to each, and where it is among the costs.
    chances: Vec<(u64, u32)>,
    /// Lanes of rows that have been computed, the measure of effort.
    pub(super) work: u64,
}

impl Survey {
    /// The cycles in which a node is looked for, by its neighbours; `random` decides among many.
    fn window(state: &State<'_, '_>, horizon: &Horizon, node: Node, random: u32) -> (i32, i32) {
        let (mut first, mut last) = (None::<i32>, None::<i32>);
        let mut after = |time: i32| first = Some(first.map_or(time, |f: i32| f.max(time)));
        let mut before = |time: i32| last = Some(last.map_or(time, |l: i32| l.min(time)));
        for &net in &state.nets_of[node] {
            let net = &state.nets[net];
            let (ready, read) = state.ends(net);
            match (net.from == node, net.to == node) {
                (true, true) => {}
                (false, _) => after(ready - net.span),
                (true, false) => before(read - 1),
            }
        }
        for &o in &state.problem.orders_of[node] {
            let order = &state.problem.orders[o];
            let weight = order.delay as i32 - state.ii * order.distance as i32;
            match (order.from == node, order.to == node) {
                (true, true) => {}
                (false, _) => after(state.at[order.from].1 + weight),
                (true, false) => before(state.at[order.to].1 - weight),
            }
        }
        let whole = 2 * state.ii + 2 * AROUND + 1;
        let (from, to) = match (first, last) {
            (Some(first), Some(last)) => {
                let length = (last - first + 1 + 2 * AROUND).clamp(state.ii + PART, whole);
                let from = first.min(last) - AROUND;
                let room = (last.max(first) + AROUND - from + 1 - length).max(0);
                let from = from + ((u64::from(random) * (room as u64 + 1)) >> 32) as i32;
                (from, from + length - 1)
            }
            (Some(first), None) => (first - AROUND, first - AROUND + whole - 1),
            (None, Some(last)) => (last + AROUND + 1 - whole, last + AROUND),
            (None, None) => {
                let from = state.at[node].1 - state.ii / 2;
                (from, from + state.ii - 1)
            }
        };
        let (earliest, latest) = (horizon.earliest[node], horizon.latest[node]);
        let from = from.clamp(earliest, latest);
        (from, to.clamp(from, latest))
    }

    /// Computes what every position of a node costs that has been taken out, and draws one: the less it costs beyond
    /// the least, the more likely, half as likely for each `half` 16ths. `None` where no unit runs it.
    pub(super) fn draw(
        &mut self,
        state: &State<'_, '_>,
        horizon: &Horizon,
        node: Node,
        half: i32,
        random: [u32; 2],
    ) -> Option<Position> {
        wide!(self.draw_here(state, horizon, node, half, random)
            => self.draw_wide(state, horizon, node, half, random))
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn draw_wide(
        &mut self,
        state: &State<'_, '_>,
        horizon: &Horizon,
        node: Node,
        half: i32,
        random: [u32; 2],
    ) -> Option<Position> {
        self.draw_here(state, horizon, node, half, random)
    }

    #[inline(always)]
    fn draw_here(
        &mut self,
        state: &State<'_, '_>,
        horizon: &Horizon,
        node: Node,
        half: i32,
        [when, what]: [u32; 2],
    ) -> Option<Position> {
        let (from, to) = Survey::window(state, horizon, node, when);
        self.from = from;
        self.operation(state, node, to);
        for &net in &state.nets_of[node] {
            let ends = &state.nets[net];
            match (ends.from == node, ends.to == node) {
                (true, true) => {}
                (false, _) => self.operand(state, net, to),
                (true, false) => self.result(state, net, to),
            }
        }
        self.orders(state, node);
        self.pick(state.array.lanes, half, what)
    }

    /// Sets the costs of the operation by itself.
    #[inline(always)]
    fn operation(&mut self, state: &State<'_, '_>, node: Node, to: i32) {
        self.totals.clear();
        let mask = &state.array.masks[state.array.runs[node]];
        for time in self.from..=to {
            let row = state.prices.issue_row(time).iter().zip(mask);
            self.totals
                .extend(row.map(|(&price, &mask)| i32::from(price) + mask));
        }
    }

    /// Adds the costs of delivering an operand.
    #[inline(always)]
    fn operand(&mut self, state: &State<'_, '_>, net: usize, to: i32) {
        let open = state.price_of_open_anywhere(net) as i16;
        let net = &state.nets[net];
        let (ready, _) = state.ends(net);
        let last = to + net.span;
        match last >= ready {
            true => {
                let tree = &state.trees[net.from];
                (self.map).forward(state.array, &state.prices, tree, (ready, last));
                self.work += self.map.work();
            }
            false => self.map.empty(),
        }
        let (lane, _) = state.place(net.from);
        let reach = &state.array.from[usize::from(lane)];
        let lanes = state.array.lanes;
        for (cycle, totals) in self.totals.chunks_exact_mut(lanes).enumerate() {
            let read = self.from + cycle as i32 + net.span;
            add(totals, self.map.row(read), reach, ready - read, open);
        }
    }

    /// Adds the costs of delivering the result to a consumer.
    #[inline(always)]
    fn result(&mut self, state: &State<'_, '_>, net: usize, to: i32) {
        let open = state.price_of_open_anywhere(net) as i16;
        let net = &state.nets[net];
        let (unit, issued) = state.place(net.to);
        let (first, read) = (self.from + 1, issued + net.span);
        match read >= first {
            true => {
                (self.map).backward(state.array, &state.prices, unit, (first, read));
                self.work += self.map.work();
            }
            false => self.map.empty(),
        }
        let reach = &state.array.to[usize::from(unit)];
        let lanes = state.array.lanes;
        debug_assert_eq!(self.totals.len() / lanes, (to - self.from + 1) as usize);
        for (cycle, totals) in self.totals.chunks_exact_mut(lanes).enumerate() {
            let lands = self.from + cycle as i32 + 1;
            add(totals, self.map.row(lands), reach, lands - read, open);
        }
    }

    /// Adds the costs of memory orders that are not kept.
    fn orders(&mut self, state: &State<'_, '_>, node: Node) {
        let lanes = state.array.lanes;
        for &o in &state.problem.orders_of[node] {
            let order = &state.problem.orders[o];
            let weight = order.delay as i32 - state.ii * order.distance as i32;
            if order.from == order.to {
                continue;
            }
            for (cycle, totals) in self.totals.chunks_exact_mut(lanes).enumerate() {
                let time = self.from + cycle as i32;
                let early = match order.to == node {
                    true => state.at[order.from].1 + weight - time,
                    false => time + weight - state.at[order.to].1,
                };
                let price = price_of_early(i64::from(early.max(0)));
                totals.iter_mut().for_each(|total| *total += price);
            }
        }
    }

    /// Draws a position.
    #[inline(always)]
    fn pick(&mut self, lanes: usize, half: i32, random: u32) -> Option<Position> {
        self.least.clear();
        for row in self.totals.chunks_exact(lanes) {
            let mut least = [FAR; VECTOR];
            for costs in row.as_chunks::<VECTOR>().0 {
                for (least, &cost) in least.iter_mut().zip(costs) {
                    *least = cost.min(*least);
                }
            }
            self.least.extend(least.iter().min());
        }
        let least = self.least.iter().copied().min()?;
        if least >= FAR {
            return None;
        }
        // What costs more has no weight.
        let most = least + (LIGHTEST + 1) * half / 16;
        let scale = Scale::of(half);
        self.chances.clear();
        let mut sum = 0u64;
        let rows = self.totals.chunks_exact(lanes).zip(&self.least);
        for (cycle, (row, _)) in rows.enumerate().filter(|(_, (_, least))| **least < most) {
            for (part, costs) in row.as_chunks::<VECTOR>().0.iter().enumerate() {
                if costs.iter().all(|&cost| cost >= most) {
                    continue;
                }
                for (lane, &cost) in costs.iter().enumerate().filter(|(_, cost)| **cost < most) {
                    sum += u64::from(scale.weight(cost - least));
                    let at = cycle * lanes + part * VECTOR + lane;
                    self.chances.push((sum, at as u32));
                }
            }
        }
        let drawn = (u64::from(random) * sum) >> 32;
        let index = self.chances.partition_point(|&(up_to, _)| up_to <= drawn);
        let (_, at) = *self.chances.get(index)?;
        let (cycle, lane) = (at as usize / lanes, at as usize % lanes);
        Some((Fu::new(lane), self.from + cycle as i32))
    }
}

/// Adds a row of costs, none more than without a way, which costs the more the less time there is for one.
#[inline(always)]
fn add(totals: &mut [i32], row: Option<&[i16]>, reach: &[i16], late: i32, open: i16) {
    let late = late.clamp(-2 * LATE.most, LATE.most) as i16;
    let (each, most) = (LATE.each as i16, LATE.most as i16);
    let reach = reach.as_chunks::<VECTOR>().0.iter();
    let totals = totals.as_chunks_mut::<VECTOR>().0.iter_mut();
    for (part, (totals, reach)) in totals.zip(reach).enumerate() {
        let mut costs = [0; VECTOR];
        for lane in 0..VECTOR {
            costs[lane] = open + each * (reach[lane] + late).clamp(0, most);
        }
        if let Some(row) = row {
            let row = row[part * VECTOR..].first_chunk::<VECTOR>();
            let row = row.expect("rows are whole vectors");
            for lane in 0..VECTOR {
                costs[lane] = costs[lane].min(row[lane]);
            }
        }
        for lane in 0..VECTOR {
            totals[lane] += i32::from(costs[lane]);
        }
    }
}
