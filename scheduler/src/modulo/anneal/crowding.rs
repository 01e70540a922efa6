//! Registers: how many each value needs, and which units have too few.

use super::super::problem::Problem;
use super::super::route::MOVE;
use super::Anneal;
use srp_archdesc::arch::Fu;
use srp_archdesc::resource::Place;
use srp_ir::dfg::Node;

/// The part of a unit's registers, in 16ths, beyond which it counts as crowded: the estimate
/// ignores conflicts between values.
const PART: u32 = 6;

impl Anneal<'_, '_> {
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
    pub(super) fn count_all(&mut self) {
        self.load.values_mut().for_each(|load| *load = 0);
        for node in self.problem.nodes() {
            self.life[node] = self.lifetime(node);
            self.load[self.at[node].0] += self.life[node];
        }
    }

    /// Returns the price of the registers that a unit is short of: the cost of moving their values
    /// away.
    fn crowding(&self, fu: Fu) -> i64 {
        let over = (self.load[fu] - self.capacity[fu]).max(0);
        i64::from(over) * i64::from(MOVE) / i64::from(self.ii)
    }

    /// Counts the registers of nodes and of the values they read anew; returns the change of the
    /// price of crowding.
    pub(super) fn recount(&mut self, nodes: &[Node], homes: &[(Node, Fu)]) -> i64 {
        let mut change = 0;
        let mut add = |a: &mut Self, fu: Fu, by: i32| {
            if by != 0 {
                change -= a.crowding(fu);
                a.load[fu] += by;
                change += a.crowding(fu);
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
}

/// Cycles of registers, out of each II, that a unit has for results of its own: a share of each file
/// that it writes.
pub(super) fn capacity(problem: &Problem<'_>, fu: Fu, ii: u32) -> i32 {
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
            .map_or(0, |rf| problem.srp.files[rf].size);
        size / writers.max(1) as u32
    };
    (problem.graph.writes[fu].iter().map(share).sum::<u32>() * ii * PART / 16) as i32
}
