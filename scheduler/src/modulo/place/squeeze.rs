//! Squeezing: what lies outside of a shorter schedule is taken out of a complete placement and placed anew.

use super::{Attempt, Conflict, Placement};
use srp_archdesc::Watch;
use srp_ir::dfg::Node;

impl Attempt<'_, '_> {
    /// Goes on from a complete placement. From then on, every node stays within its freedom: those that
    /// are not are taken out, and placed anew in this order, or the most frequent conflict is returned.
    pub(in crate::modulo) fn squeeze(
        &mut self,
        from: &Placement,
        order: &[Node],
        deadline: i32,
        limit: u64,
        watch: &dyn Watch,
    ) -> Result<Placement, Option<Conflict>> {
        self.resume(from);
        self.deadline = Some(deadline);
        let is_outside = |&node: &Node| {
            let (_, time) = from.at[node];
            let within = self.freedom.earliest[node]..=self.freedom.latest[node];
            !within.contains(&time) || from.lands(self.problem, node) > deadline
        };
        let outside: Vec<Node> = self.problem.nodes().filter(is_outside).collect();
        outside.iter().for_each(|&node| self.remove(node));
        self.place_all(order, outside.into_iter(), limit, watch)
    }

    /// Takes everything as it is in a placement.
    fn resume(&mut self, from: &Placement) {
        self.table = from.table.clone();
        self.registers = from.registers.clone();
        self.at = from.at.values().map(|&at| Some(at)).collect();
        self.routes = from.routes.iter().cloned().map(Some).collect();
    }
}
