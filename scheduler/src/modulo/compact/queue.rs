//! Queues: operations of one iteration that need the same units, or the same shared resource, issue one after
//! the other, so many at a time.

use crate::modulo::problem::Problem;
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::EntityMap;
use srp_ir::dfg::Node;
use std::collections::{BTreeMap, BTreeSet};

/// The fewest cycles of a schedule in which nodes have these cycles before and after their issue, as far as
/// queues tell.
pub(super) fn length(
    problem: &Problem<'_>,
    heads: &EntityMap<Node, i32>,
    tails: &EntityMap<Node, i32>,
) -> i32 {
    let queues = queues(problem);
    let lengths = queues.iter().map(|queue| queue.length(heads, tails));
    lengths.max().unwrap_or(0)
}

/// Operations that need one resource.
struct Queue {
    nodes: Vec<Node>,
    /// How many of them can issue in a cycle.
    servers: u32,
    /// Fewest cycles for which each keeps it.
    interval: u32,
}

fn queues(problem: &Problem<'_>) -> Vec<Queue> {
    let interval = |&n: &Node| {
        let units = problem.units[n].iter();
        units
            .map(|&fu| problem.timing(n, fu).interval)
            .min()
            .unwrap_or(1)
    };
    let queue = |nodes: Vec<Node>, servers: u32| Queue {
        interval: nodes.iter().map(interval).min().unwrap_or(1),
        nodes,
        servers: servers.max(1),
    };
    // Of nodes that the same units run, those that keep them for long may queue longer than all.
    let mut by_units: BTreeMap<(&[Fu], u32), ()> = BTreeMap::new();
    for node in problem.nodes() {
        by_units.insert((&problem.units[node], interval(&node)), ());
    }
    let of_units = by_units.keys().map(|&(units, least)| {
        let all: BTreeSet<Fu> = units.iter().copied().collect();
        let needs =
            |n: &Node| interval(n) >= least && problem.units[*n].iter().all(|fu| all.contains(fu));
        queue(problem.nodes().filter(needs).collect(), units.len() as u32)
    });
    let shared = problem.srp.resources.iter().map(|(resource, spec)| {
        let needs = |n: &Node| {
            let mut units = problem.units[*n].iter();
            units.all(|&fu| problem.timing(*n, fu).uses.contains(&resource))
        };
        queue(problem.nodes().filter(needs).collect(), spec.count)
    });
    of_units.chain(shared).collect()
}

impl Queue {
    /// Of those that issue no earlier than some cycle and have at least so much behind them, the last issues when
    /// all others have.
    fn length(&self, heads: &EntityMap<Node, i32>, tails: &EntityMap<Node, i32>) -> i32 {
        let mut by_head = self.nodes.clone();
        by_head.sort_by_key(|&n| std::cmp::Reverse(heads[n]));
        let ends: BTreeSet<i32> = self.nodes.iter().map(|&n| tails[n]).collect();
        let mut longest = 0;
        for tail in ends {
            let mut count = 0;
            for &node in by_head.iter().filter(|&&n| tails[n] >= tail) {
                count += 1u32;
                let waits = ((count - 1) / self.servers * self.interval) as i32;
                longest = longest.max(heads[node] + waits + tail);
            }
        }
        longest
    }
}
