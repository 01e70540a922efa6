//! Where and when nodes start, by the clock.

use super::{Folded, clock};
use crate::modulo::exact::formula::Lit;

impl Folded<'_, '_> {
    /// A unit and a cycle for every node; the anchor starts in cycle 0.
    pub(super) fn starts(&mut self) {
        let problem = self.problem;
        let anchor = clock::anchor(problem);
        for node in problem.nodes() {
            for &fu in &problem.units[node] {
                let timing = problem.timing(node, fu);
                let unit = &problem.srp.fus[fu].name;
                if timing.interval as usize > self.ii {
                    continue;
                }
                for time in 0..self.round {
                    let name = || format!("start {node} {unit} {time}");
                    let start = self.formula.variable(name);
                    self.start[node][fu].push(start);
                    self.limits.issue(fu, time, timing, start);
                    if anchor == Some(node) && time > 0 {
                        self.formula.clause([-start]);
                    }
                }
            }
            self.starts_once(node);
        }
    }

    /// A node starts in one cycle, on one unit.
    fn starts_once(&mut self, node: srp_ir::dfg::Node) {
        let starts = self.start[node].clone();
        let whens = self.cycles(node);
        for (time, &when) in whens.iter().enumerate() {
            let here: Vec<Lit> = (starts.values())
                .filter_map(|of| of.get(time).copied())
                .collect();
            here.iter()
                .for_each(|&start| self.formula.clause([-start, when]));
            self.formula
                .clause(std::iter::once(-when).chain(here.iter().copied()));
        }
        self.formula.clause(whens.iter().copied());
        self.formula
            .at_most_one(&whens, || format!("one-cycle {node}"));
        let mut wheres = Vec::new();
        for (fu, of) in starts.iter().filter(|(_, of)| !of.is_empty()) {
            let unit = &self.problem.srp.fus[fu].name;
            let on = self.formula.variable(|| format!("on {node} {unit}"));
            wheres.push(on);
            of.iter()
                .for_each(|&start| self.formula.clause([-start, on]));
        }
        self.formula
            .at_most_one(&wheres, || format!("one-unit {node}"));
    }

    /// The variables that a node starts in a cycle.
    fn cycles(&mut self, node: srp_ir::dfg::Node) -> Vec<Lit> {
        let first = |time: usize| format!("at {node} {time}");
        let formula = &mut self.formula;
        let cycles: Vec<Lit> = (0..self.round)
            .map(|time| formula.variable(|| first(time)))
            .collect();
        self.at.push(cycles.clone());
        cycles
    }

    /// Nodes of a recurrence start as far apart as they can in any schedule, if the clock is long enough to tell.
    pub(super) fn windows(&mut self) {
        let round = self.round as i64;
        for ((from, to), (least, most)) in clock::windows(self.problem, self.ii as u32) {
            if most - least + 1 >= round {
                continue;
            }
            for time in 0..self.round {
                let then = (least..=most).map(|by| self.at[to][self.cycle(time as i64 + by)]);
                let clause = std::iter::once(-self.at[from][time]).chain(then);
                self.formula.clause(clause.collect::<Vec<_>>());
            }
        }
    }
}
