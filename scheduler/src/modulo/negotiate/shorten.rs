//! Shorter schedules by negotiation: a run goes on from a placement in which some nodes are too early or too
//! late.

use super::state::Path;
use super::{Cooling, Lanes, Negotiation};
use crate::modulo::order::Freedom;
use crate::modulo::place::{Conflict, Placement};
use crate::modulo::problem::Problem;
use srp_archdesc::Watch;
use srp_ir::dre::scheduled::Reg;

impl<'a, 'p> Negotiation<'a, 'p> {
    /// A run from a placement. Every node stays within its freedom, and everything lands by a deadline: a node
    /// outside is put where it is allowed next, in its slot if possible, and its edges lose their routes.
    pub(in crate::modulo) fn from(
        problem: &'a Problem<'p>,
        lanes: &'a Lanes,
        placement: &Placement,
        freedom: &'a Freedom,
        deadline: i32,
        fixed: &'a [Reg],
        seed: u32,
    ) -> Negotiation<'a, 'p> {
        let ii = placement.ii;
        let mut run = Negotiation::empty(problem, lanes, ii, freedom, fixed, seed);
        run.deadline = Some(deadline);
        for (node, &(fu, time)) in placement.at.iter() {
            let (first, last) = (freedom.earliest[node], freedom.latest[node]);
            let shift = |by: i32| by.div_euclid(ii as i32) * ii as i32;
            let time = match time {
                _ if time < first => (time - shift(time - first)).min(last),
                _ if time > last => (time + shift(last - time)).max(first),
                _ => time,
            };
            run.state.put(node, (fu, time));
        }
        for (e, route) in placement.routes.iter().enumerate() {
            let edge = &problem.edges[e];
            let stays = |node| run.state.at[node] == placement.at[node];
            let in_time = placement.lands(problem, edge.from) <= deadline;
            if stays(edge.from) && edge.to().is_none_or(stays) && in_time {
                let items = route.items.clone();
                let (read, tag) = (route.read, route.tag);
                run.state.take(e, Path { items, read, tag });
            }
        }
        run
    }

    /// Goes on until nothing is in conflict, with so many steps for each node.
    pub(in crate::modulo) fn shorten(
        &mut self,
        stage: u32,
        steps: u64,
        limit: u64,
        watch: &dyn Watch,
    ) -> Result<Placement, Option<Conflict>> {
        let mut cooling = Cooling::default();
        (0..stage).for_each(|_| cooling.cool());
        self.cool_down(cooling, steps, limit, watch)
    }

    /// True if everything lands by the deadline.
    pub(super) fn is_in_time(&self, placement: &Placement) -> bool {
        let by = |deadline: i32| {
            let mut nodes = self.problem.nodes();
            nodes.all(|node| placement.lands(self.problem, node) <= deadline)
        };
        self.deadline.is_none_or(by)
    }
}
