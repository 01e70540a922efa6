//! The units that nodes begin on: spread over the array, near to those that they have values from and for.
//!
//! On a large array a node would take long to find its neighbours by steps of the search, which route everything. Here
//! times stand still, a way costs its hops, and an issue slot has room for one, so that a move takes nanoseconds
//! (*placement by annealing*, as of Sechen and Sangiovanni-Vincentelli, 1985).

use super::array::Array;
use crate::modulo::noise::noise;
use crate::modulo::problem::Problem;
use crate::modulo::scale::Scale;
use crate::modulo::slots::Slots;
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_ir::dfg::Node;

/// Tries for each node, in so many stages.
const TRIES: usize = 1200;
const STAGES: i32 = 40;
/// The cost of a hop.
const HOP: i32 = 16;
/// By how many 16ths a cost has to rise to be half as likely, in the first stage and in the last.
const HALF: (i32, i32) = (1200, 60);
/// The cost of another node in the same issue slot, and on the same unit.
const SAME_SLOT: i32 = 60;
const SAME_UNIT: i32 = 6;

/// Units and what is on them.
struct Spread<'a, 'p> {
    problem: &'a Problem<'p>,
    array: &'a Array,
    slots: Vec<usize>,
    units: EntityMap<Node, Fu>,
    /// Nodes in each issue slot and on each unit.
    in_slot: Vec<u16>,
    on_unit: Vec<u16>,
    seed: u64,
    draws: u64,
}

/// Puts each node on a unit that runs it.
pub(super) fn units(
    problem: &Problem<'_>,
    array: &Array,
    times: &EntityMap<Node, i32>,
    ii: u32,
    seed: u32,
) -> EntityMap<Node, Fu> {
    let slot_of = Slots::of(ii as i32);
    let count = problem.dfg.nodes.len();
    let mut spread = Spread {
        problem,
        array,
        slots: times.values().map(|&time| slot_of.slot(time)).collect(),
        units: EntityMap::filled(count, Fu::new(0)),
        in_slot: vec![0; ii as usize * array.lanes],
        on_unit: vec![0; array.lanes],
        seed: u64::from(seed),
        draws: 0,
    };
    for node in problem.nodes() {
        let unit = spread.any_unit(node);
        spread.put(node, unit);
    }
    for stage in 0..STAGES {
        let (first, last) = HALF;
        let left = STAGES - 1 - stage;
        let half = last + (first - last) * left * left / ((STAGES - 1) * (STAGES - 1));
        let scale = Scale::of(half);
        for _ in 0..count * TRIES / STAGES as usize {
            spread.step(scale);
        }
    }
    spread.units
}

/// Hops of all values to all consumers, beyond those that a link makes.
pub(super) fn hops(problem: &Problem<'_>, array: &Array, units: &EntityMap<Node, Fu>) -> u64 {
    let hops = problem.edges.iter().filter_map(|edge| {
        let (from, to) = (units[edge.from], units[edge.to()?]);
        u64::try_from(array.from[from.index()][to.index()]).ok()
    });
    hops.sum()
}

impl Spread<'_, '_> {
    fn random(&mut self) -> u32 {
        self.draws += 1;
        noise(self.seed, self.draws, 0x59ead)
    }

    fn below(&mut self, below: usize) -> usize {
        ((u64::from(self.random()) * below as u64) >> 32) as usize
    }

    fn any_unit(&mut self, node: Node) -> Fu {
        let units = &self.problem.units[node];
        units[self.below(units.len())]
    }

    fn put(&mut self, node: Node, unit: Fu) {
        self.units[node] = unit;
        self.on_unit[unit.index()] += 1;
        self.in_slot[self.slots[node.index()] * self.array.lanes + unit.index()] += 1;
    }

    fn lift(&mut self, node: Node) {
        let unit = self.units[node];
        self.on_unit[unit.index()] -= 1;
        self.in_slot[self.slots[node.index()] * self.array.lanes + unit.index()] -= 1;
    }

    /// The cost of a node on a unit, when it is on none.
    fn cost(&self, node: Node, unit: Fu) -> i32 {
        let slot = self.slots[node.index()] * self.array.lanes;
        let same_slot = i32::from(self.in_slot[slot + unit.index()]);
        let same_unit = i32::from(self.on_unit[unit.index()]);
        let mut hops = 0;
        for &e in &self.problem.edges_of[node] {
            let edge = &self.problem.edges[e];
            let to = edge
                .to()
                .expect("arrays of this kind keep no value after a loop");
            hops += match (edge.from == node, to == node) {
                (true, true) => 0,
                (true, false) => self.array.from[unit.index()][self.units[to].index()],
                (false, _) => self.array.to[unit.index()][self.units[edge.from].index()],
            };
        }
        i32::from(hops) * HOP + same_slot * SAME_SLOT + same_unit * SAME_UNIT
    }

    /// Moves a node to a unit: any, or one that a neighbour is on or next to.
    fn step(&mut self, scale: Scale) {
        let node = Node::new(self.below(self.problem.dfg.nodes.len()));
        let unit = self.any_unit(node);
        let before = self.units[node];
        self.lift(node);
        let change = self.cost(node, unit) - self.cost(node, before);
        let random = self.random();
        let to = if scale.accepts(change, random) {
            unit
        } else {
            before
        };
        self.put(node, to);
    }
}
