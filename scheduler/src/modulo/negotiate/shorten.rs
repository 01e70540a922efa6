//! Shorter schedules, and smaller IIs, by negotiation: a run goes on from a placement some nodes of which have moved.

use super::state::Path;
use super::{Cooling, Lanes, Negotiation, tiles};
use crate::modulo::order::Freedom;
use crate::modulo::place::{Conflict, Placement};
use crate::modulo::problem::Problem;
use srp_archdesc::Watch;
use srp_archdesc::entity::EntityMap;
use srp_ir::dfg::Node;
use srp_ir::dre::scheduled::Reg;

impl<'a, 'p> Negotiation<'a, 'p> {
    /// A run at an II from a placement whose nodes go to other cycles. Every node stays within its freedom, and everything
    /// lands by a deadline. The edges of nodes that have moved lose their routes, and all do at another II.
    pub(in crate::modulo) fn from(
        problem: &'a Problem<'p>,
        lanes: &'a Lanes,
        (placement, times): (&Placement, &EntityMap<Node, i32>),
        (freedom, deadline): (&'a Freedom, i32),
        fixed: &'a [Reg],
        ii: u32,
        seed: u32,
    ) -> Negotiation<'a, 'p> {
        let mut run = Negotiation::empty(problem, lanes, ii, freedom, fixed, seed);
        run.state.deadline = Some(deadline);
        run.state.tiles = match ii == placement.ii {
            true => tiles::of_schedule(problem, ii, &placement.at),
            false => tiles::tiles(problem, ii, seed),
        };
        for (node, &(fu, _)) in placement.at.iter() {
            run.state.put(node, (fu, times[node]));
        }
        for (e, route) in placement.routes.iter().enumerate() {
            let edge = &problem.edges[e];
            let stays = |node| ii == placement.ii && run.state.at[node] == placement.at[node];
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
        self.state.deadline.is_none_or(by)
    }
}
