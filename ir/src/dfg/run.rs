//! The semantics of a [`Dfg`]: runs one iteration after the other.

use super::{Dfg, Initial, Node, Operand, Watched};
use crate::interp::{Stop, Trap, TrapKind, World, operate};
use crate::program::Bits;
use srp_archdesc::arch::Precision;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::ops::Value;

/// Where an operand of the next operation is found.
enum Fetch {
    Known(Value),
    /// A node's value of `distance` iterations ago; before that, `initial`.
    Node {
        node: Node,
        distance: usize,
        initial: Vec<Value>,
    },
}

/// The last values of a node, by iteration.
#[derive(Clone)]
struct History {
    values: Vec<Value>,
}

impl History {
    fn at(&mut self, iteration: u64) -> &mut Value {
        let slot = iteration % self.values.len() as u64;
        &mut self.values[slot as usize]
    }
}

/// Runs a [verified](Dfg::verify) loop with these live-ins, the trip count among them, and gives the
/// live-outs. Every operation takes one of `steps`. Initial values on which nothing depends are zero.
///
/// # Panics
///
/// If the live-ins are not as many as the graph has, or the graph is bare.
pub fn run(
    dfg: &Dfg,
    live_ins: &[Bits],
    world: &mut dyn World,
    precision: &Precision,
    steps: &mut u64,
) -> Result<Vec<Bits>, Trap> {
    assert_eq!(live_ins.len(), dfg.live_ins.len(), "one value a live-in");
    let fetches: Vec<Vec<Fetch>> = dfg
        .nodes
        .values()
        .map(|data| data.operands.iter().map(|o| fetch(o, live_ins)).collect())
        .collect();
    let mut kept = EntityMap::filled(dfg.nodes.len(), 1);
    for (from, distance) in dfg.nodes.values().flat_map(|data| data.producers()) {
        kept[from] = kept[from].max(distance as usize + 1);
    }
    let mut history: EntityMap<Node, History> = kept
        .values()
        .map(|len| History {
            values: vec![Value::default(); *len],
        })
        .collect();
    let order = dfg.topological();
    let mut watched = Watched::of(dfg);
    let trip = dfg.trip.expect("a bare graph is not launched");
    let trip = match live_ins[trip as usize].lanes()[0] {
        0 => 1 << 32,
        trip => u64::from(trip),
    };
    for iteration in 0..trip {
        for &node in &order {
            let data = &dfg.nodes[node];
            let trap = |kind| Trap {
                kind,
                func: None,
                pos: data.pos,
                calls: Vec::new(),
            };
            *steps = steps.checked_sub(1).ok_or(trap(TrapKind::StepLimit))?;
            let mut args = [Value::default(); 3];
            for (arg, from) in args.iter_mut().zip(&fetches[node.index()]) {
                *arg = get(from, iteration, &mut history);
            }
            let args = &args[..data.operands.len().min(3)];
            if let (Some(watched), Some(bytes)) = (&mut watched, data.op.access_bytes())
                && args[0].as_pred()
            {
                let address = args[1].as_word().wrapping_add_signed(data.imm);
                if let Some(other) = watched.touch(node, iteration, address, bytes) {
                    let other = dfg.nodes[other].pos;
                    return Err(trap(TrapKind::Overlap { address, other }));
                }
            }
            let result = operate(data.op, args, data.imm, precision, world);
            let result = result.map_err(|stop| match stop {
                Stop::Trap(kind) => trap(kind),
                // Ports are refused by the rules.
                Stop::Exit(_) => trap(TrapKind::Unreachable),
            })?;
            if let Some(value) = result {
                *history[node].at(iteration) = value;
            }
        }
    }
    let outs = dfg.live_outs.iter().map(|node| {
        let ty = dfg.ty(*node).expect("live-outs have a result");
        Bits::of_lanes(ty, history[*node].at(trip - 1).0)
    });
    Ok(outs.collect())
}

fn fetch(operand: &Operand, live_ins: &[Bits]) -> Fetch {
    match operand {
        Operand::Const(bits) => Fetch::Known(Value::from(*bits)),
        Operand::LiveIn(i) => Fetch::Known(Value::from(live_ins[*i as usize])),
        Operand::Node { node, init } => {
            let initial = |initial: &Initial| match initial {
                Initial::Const(bits) => Value::from(*bits),
                Initial::LiveIn(i) => Value::from(live_ins[*i as usize]),
                Initial::Any => Value::default(),
            };
            Fetch::Node {
                node: *node,
                distance: init.len(),
                initial: init.iter().map(initial).collect(),
            }
        }
    }
}

fn get(from: &Fetch, iteration: u64, history: &mut EntityMap<Node, History>) -> Value {
    match from {
        Fetch::Known(value) => *value,
        Fetch::Node {
            node,
            distance,
            initial,
        } => match iteration.checked_sub(*distance as u64) {
            Some(earlier) => *history[*node].at(earlier),
            None => initial[distance - 1 - iteration as usize],
        },
    }
}
