//! Nodes as units see them: those that have the same needs on many units are looked at together.

use super::FAR;
use crate::modulo::negotiate::state::State;
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::Entity;
use srp_ir::dfg::Node;
use std::collections::BTreeMap;

/// The units that run a node, those apart that it costs nothing but an issue slot and an output.
pub(super) struct Kind {
    pub(super) groups: Vec<Group>,
    /// The other units that run it.
    pub(super) odd: Vec<Fu>,
    /// The latency on all of them, if it is one.
    pub(super) latency: Option<i32>,
}

/// Units that run a node alike.
pub(super) struct Group {
    /// The lane of unit 0's output, if its result stands there, and the latency.
    pub(super) result: Option<(usize, i32)>,
    /// 0 for these units, [`FAR`] for others.
    pub(super) mask: Vec<i32>,
}

impl Kind {
    pub(super) fn of(state: &State<'_, '_>, node: Node, stride: usize) -> Kind {
        let problem = state.problem;
        let mut groups: BTreeMap<Option<(usize, i32)>, Vec<i32>> = BTreeMap::new();
        let mut odd = Vec::new();
        let op = problem.dfg.nodes[node].op;
        for &fu in &problem.units[node] {
            let timing = problem.timing(node, fu);
            let lane = problem
                .graph
                .result_place(fu, op)
                .map(|p| state.lanes.of[p]);
            let block = lane.map(|lane| lane.checked_sub(fu.index()));
            let plain = timing.interval == 1 && timing.uses.is_empty();
            if !plain || state.problem.needs(node, fu).is_some() || block == Some(None) {
                odd.push(fu);
                continue;
            }
            let result = block.flatten().map(|block| (block, timing.latency as i32));
            let mask = groups.entry(result).or_insert_with(|| vec![FAR; stride]);
            mask[fu.index()] = 0;
        }
        let mut latencies = problem.units[node]
            .iter()
            .map(|&fu| problem.timing(node, fu).latency);
        let first = latencies.next();
        let groups = groups.into_iter();
        Kind {
            groups: groups
                .map(|(result, mask)| Group { result, mask })
                .collect(),
            odd,
            latency: first
                .filter(|&l| latencies.all(|other| other == l))
                .map(|l| l as i32),
        }
    }
}
