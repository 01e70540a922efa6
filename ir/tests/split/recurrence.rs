//! The recurrence bound against all elementary cycles of small graphs.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::dfg::{Dfg, Initial, LiveIn, Node, NodeData, Operand, Order};
use srp_ir::program::{Bits, Pos};

/// A random graph of adders, loads and stores that keeps the rules.
fn graph(rng: &mut Pcg32) -> Dfg {
    let mut below = |n: u32| rng.next_u32() % n;
    let count = 1 + below(8);
    let mut nodes: EntityMap<Node, NodeData> = EntityMap::new();
    for i in 0..count {
        let op = [Opcode::Fma, Opcode::Fma, Opcode::Lw, Opcode::Sw][below(4) as usize];
        let mut operands = Vec::new();
        for kind in op.info().operands {
            operands.push(match kind.ty() {
                Ty::Pred => Operand::Const(Bits::Pred(true)),
                _ => {
                    let node = below(count);
                    let distance = below(4) + u32::from(node >= i);
                    Operand::Node {
                        node: Node::new(node as usize),
                        init: vec![Initial::LiveIn(0); distance as usize],
                    }
                }
            });
        }
        nodes.push(NodeData {
            op,
            operands,
            imm: 0,
            pos: Pos::nowhere(),
        });
    }
    // Stores have no result to take.
    let is_store: Vec<bool> = nodes.values().map(|n| n.op == Opcode::Sw).collect();
    for data in nodes.values_mut() {
        for operand in &mut data.operands {
            if operand.producer().is_some_and(|(n, _)| is_store[n.index()]) {
                *operand = Operand::LiveIn(0);
            }
        }
    }
    let memory: Vec<Node> = nodes
        .iter()
        .filter(|(_, d)| d.op.space().is_some())
        .map(|(n, _)| n)
        .collect();
    let mut order = Vec::new();
    for &from in &memory {
        for &to in &memory {
            if below(3) == 0 {
                let distance = below(3) + u32::from(from >= to);
                order.push(Order { from, to, distance });
            }
        }
    }
    Dfg {
        name: "random".to_owned(),
        pos: Pos::nowhere(),
        live_ins: vec![LiveIn {
            ty: Ty::Word,
            pos: Pos::nowhere(),
        }],
        trip: Some(0),
        nodes,
        order,
        assumed: Vec::new(),
        live_outs: Vec::new(),
    }
}

/// The largest ratio of all cycles that start at their lowest node, as delay and distance.
fn largest_ratio(dfg: &Dfg, latency: &[u32]) -> Option<(u64, u64)> {
    struct Walk<'a> {
        edges: &'a [(usize, usize, u64, u64)],
        on_path: Vec<bool>,
        best: Option<(u64, u64)>,
    }
    impl Walk<'_> {
        fn from(&mut self, start: usize, at: usize, delay: u64, distance: u64) {
            for &(from, to, d, k) in self.edges {
                if from != at || to < start {
                    continue;
                }
                let (delay, distance) = (delay + d, distance + k);
                if to == start {
                    let steeper = |(p, q): (u64, u64)| delay * q > p * distance;
                    if self.best.is_none_or(steeper) {
                        self.best = Some((delay, distance));
                    }
                } else if !self.on_path[to] {
                    self.on_path[to] = true;
                    self.from(start, to, delay, distance);
                    self.on_path[to] = false;
                }
            }
        }
    }
    let mut edges: Vec<_> = dfg
        .deps()
        .map(|(from, to, dep)| {
            let delay = dfg.delay(from, dep, latency[from.index()]);
            (from.index(), to.index(), delay.into(), dep.distance.into())
        })
        .collect();
    // Of parallel edges alike in distance the longest counts.
    edges.sort();
    edges.dedup();
    let mut walk = Walk {
        edges: &edges,
        on_path: vec![false; dfg.nodes.len()],
        best: None,
    };
    for start in 0..dfg.nodes.len() {
        walk.from(start, start, 0, 0);
    }
    walk.best
}

/// The best ratio that the cycle through these nodes can have, each being followed by the next.
fn ratio_of(dfg: &Dfg, cycle: &[Node], latency: &[u32], ii: u64) -> bool {
    // With an interval one smaller, the steepest edges between the nodes must not fit.
    let slack = |from: Node, to: Node| {
        dfg.deps()
            .filter(|(a, b, _)| (*a, *b) == (from, to))
            .map(|(_, _, dep)| {
                let delay = dfg.delay(from, dep, latency[from.index()]);
                i64::from(delay) - (ii as i64 - 1) * i64::from(dep.distance)
            })
            .max()
            .expect("consecutive nodes depend on each other")
    };
    let following = cycle.iter().cycle().skip(1);
    cycle
        .iter()
        .zip(following)
        .map(|(a, b)| slack(*a, *b))
        .sum::<i64>()
        > 0
}

#[test]
fn bound_is_the_largest_cycle_ratio() {
    let mut rng = Pcg32::new(5, 6);
    let mut interesting = 0;
    for _ in 0..10_000 {
        let dfg = graph(&mut rng);
        dfg.verify().expect("keeps the rules");
        let latency: Vec<u32> = dfg.nodes.keys().map(|_| 1 + rng.next_u32() % 9).collect();
        let (ii, cycle) = dfg.rec_mii(|n| latency[n.index()]);
        let expected = match largest_ratio(&dfg, &latency) {
            None => 1,
            Some((delay, distance)) => delay.div_ceil(distance).max(1),
        };
        assert_eq!(u64::from(ii), expected, "{dfg:#?}");
        if ii > 1 {
            interesting += 1;
            assert!(
                ratio_of(&dfg, &cycle, &latency, ii.into()),
                "{cycle:?} of {dfg:#?}"
            );
        }
    }
    assert!(interesting > 5000, "{interesting} bounds above 1");
}
