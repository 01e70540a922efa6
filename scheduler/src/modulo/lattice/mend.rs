//! The end of a run that has left few conflicts: what surrounds one is taken out and put in again node by node (*ruin
//! and recreate*, Schrimpf et al., Journal of Computational Physics 2000), so that many nodes change places at once.
//! Runs that end with two nodes in conflict are common, and no chain of moves mends those.

use super::{MENDING, Manner, Search};
use crate::modulo::place::Placement;
use crate::modulo::scale::Scale;
use srp_archdesc::Watch;
use srp_ir::dfg::Node;

/// Nodes that are taken out at once, at least and at most.
const LEAST: u32 = 3;
const MOST: u32 = 14;
/// Draws for each node that is looked for around a conflict: many are drawn again.
const DRAWS: u32 = 4;

impl Search<'_, '_> {
    /// Mends what is left at the last temperature of a manner, until nothing is in conflict or so much effort has been
    /// spent; `each` are the steps of a stage.
    pub(super) fn mend(
        &mut self,
        manner: &Manner,
        each: u64,
        limit: u64,
        watch: &dyn Watch,
    ) -> Option<Placement> {
        for _ in 0..MENDING {
            let end = self.steps + each;
            while self.steps < end {
                self.find_conflicts();
                if let Some(placement) = self.settled() {
                    return Some(placement);
                }
                if watch.cancelled() || self.effort() > limit {
                    return None;
                }
                self.replace(manner.half(Manner::LAST));
            }
            self.reprice(manner.penalty(Manner::LAST));
        }
        self.find_conflicts();
        self.settled()
    }

    /// Takes nodes around a conflict out, and puts them in again in any order; keeps that, or nothing.
    fn replace(&mut self, half: i32) {
        let mut nodes = std::mem::take(&mut self.moved);
        self.gather(&mut nodes);
        let mut change = 0;
        for &node in &nodes {
            change -= self.take_out(node);
        }
        let mut left = nodes.clone();
        let mut fit = true;
        while fit && !left.is_empty() {
            let i = self.below(left.len() as u32);
            let put = self.put_anew(left.swap_remove(i as usize), half);
            fit = put.is_some();
            change += put.unwrap_or(0);
        }
        self.moved = nodes;
        let random = self.random();
        match fit && Scale::of(half).accepts(change, random) {
            true => self.state.commit(),
            false => self.state.undo(),
        }
    }

    /// Lists a node in conflict and others around it.
    fn gather(&mut self, nodes: &mut Vec<Node>) {
        nodes.clear();
        nodes.push(self.any_or_in_conflict(false));
        let wanted = LEAST + self.below(MOST - LEAST + 1);
        for _ in 0..wanted * DRAWS {
            if nodes.len() as u32 >= wanted {
                break;
            }
            let from = nodes[self.below(nodes.len() as u32) as usize];
            let next = self.near(from);
            nodes.extend(next.filter(|next| !nodes.contains(next)));
        }
    }

    /// A node that has to do with this one: a neighbour in the graph, or one that takes an issue slot close by.
    fn near(&mut self, node: Node) -> Option<Node> {
        let nets = self.state.nets_of[node].len() as u32;
        if nets > 0 && self.below(2) == 0 {
            let i = self.below(nets) as usize;
            let net = &self.state.nets[self.state.nets_of[node][i]];
            return Some(if net.from == node { net.to } else { net.from });
        }
        let (lane, time) = self.state.place(node);
        let link = self.below(self.state.array.links.len() as u32) as usize;
        let lane = usize::from(lane).checked_add_signed(self.state.array.links[link].shift)?;
        let time = time + self.below(3) as i32 - 1;
        let random = self.random();
        self.state.taker(lane, time, random)
    }
}
