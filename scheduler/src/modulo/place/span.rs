//! The cycles of an iteration: from the first in which something issues to the last in which something
//! arrives.

use super::Placement;
use crate::modulo::problem::Problem;
use crate::modulo::table::{Item, Via};
use srp_ir::dfg::Node;

impl Placement {
    /// The first cycle in which anything issues.
    pub(in crate::modulo) fn start(&self) -> i32 {
        self.at.values().map(|&(_, time)| time).min().unwrap_or(0)
    }

    /// The cycle from which on all that the first iteration issues stands in its place.
    fn end(&self, problem: &Problem<'_>) -> i32 {
        let nodes = problem.nodes();
        nodes.map(|n| self.lands(problem, n)).max().unwrap_or(0)
    }

    /// The cycle in which the last of a node's result, its moves and its transfers lands.
    pub(in crate::modulo) fn lands(&self, problem: &Problem<'_>, node: Node) -> i32 {
        let (fu, time) = self.at[node];
        let result = time + problem.timing(node, fu).latency as i32;
        let Some(ty) = problem.dfg.ty(node) else {
            return result;
        };
        let lands = |item: Item| match item {
            Item::Move(fu, time, ..) => {
                let timing = problem.move_timing(fu, ty);
                Some(time + timing.expect("moves go over movers").latency as i32)
            }
            Item::Written(place, time, tag, Via::Over(_)) => {
                // Where the value stood in the register before, the transfer is left out.
                let stays = self.registers.stays(place);
                let mut own = stays.iter().filter(|s| (s.node, s.tag) == (node, tag));
                let is_first = own.all(|s| time == s.first || !(s.first..=s.last).contains(&time));
                is_first.then_some(time)
            }
            _ => None,
        };
        let items = self.table.items_of(node);
        items
            .filter_map(lands)
            .max()
            .map_or(result, |last| last.max(result))
    }

    /// Cycles of an iteration from its first issue to its last result.
    pub(in crate::modulo) fn length(&self, problem: &Problem<'_>) -> u32 {
        (self.end(problem) - self.start()).max(1) as u32
    }

    /// Iterations that overlap.
    pub(in crate::modulo) fn stages(&self, problem: &Problem<'_>) -> u32 {
        self.length(problem).div_ceil(self.ii)
    }
}
