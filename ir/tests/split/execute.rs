//! An executor of dataflow graphs of its own: in order, noting every access, or in the order of a
//! schedule.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use srp_archdesc::arch::Precision;
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Effect, Space};
use srp_archdesc::ops::Value;
use srp_ir::Dfg;
use srp_ir::dfg::{Initial, Node, Operand};
use srp_ir::interp::{World, operate};
use srp_ir::program::Bits;

/// An access that was really made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Access {
    pub(crate) node: Node,
    pub(crate) iteration: u32,
    pub(crate) space: Space,
    pub(crate) address: u32,
    pub(crate) bytes: u32,
    pub(crate) is_store: bool,
}

pub(crate) struct Run<'a> {
    dfg: &'a Dfg,
    live_ins: &'a [Bits],
    /// Results by iteration and node.
    results: Vec<Vec<Value>>,
    pub(crate) accesses: Vec<Access>,
}

impl<'a> Run<'a> {
    pub(crate) fn new(dfg: &'a Dfg, live_ins: &'a [Bits]) -> Run<'a> {
        let trip = dfg.trip.expect("loops of programs have one");
        let trip = live_ins[trip as usize].lanes()[0] as usize;
        Run {
            dfg,
            live_ins,
            results: vec![vec![Value::default(); dfg.nodes.len()]; trip],
            accesses: Vec::new(),
        }
    }

    pub(crate) fn trip(&self) -> u32 {
        self.results.len() as u32
    }

    /// Runs one node of one iteration; false if it traps.
    pub(crate) fn step(&mut self, node: Node, iteration: u32, world: &mut dyn World) -> bool {
        let data = &self.dfg.nodes[node];
        let args: Vec<Value> = data
            .operands
            .iter()
            .map(|o| self.operand(o, iteration))
            .collect();
        if let (Some(space), Some(bytes)) = (data.op.space(), data.op.access_bytes())
            && args[0].as_pred()
        {
            self.accesses.push(Access {
                node,
                iteration,
                space,
                address: args[1].as_word().wrapping_add_signed(data.imm),
                bytes,
                is_store: data.op.info().effect == Effect::Store,
            });
        }
        match operate(data.op, &args, data.imm, &Precision::EXACT, world) {
            Ok(Some(value)) => self.results[iteration as usize][node.index()] = value,
            Ok(None) => {}
            Err(_) => return false,
        }
        true
    }

    fn operand(&self, operand: &Operand, iteration: u32) -> Value {
        match operand {
            Operand::Const(bits) => Value::from(*bits),
            Operand::LiveIn(i) => Value::from(self.live_ins[*i as usize]),
            Operand::Node { node, init } => {
                let earlier = i64::from(iteration) - init.len() as i64;
                match usize::try_from(earlier) {
                    Ok(earlier) => self.results[earlier][node.index()],
                    Err(_) => match init[(-1 - earlier) as usize] {
                        Initial::Const(bits) => Value::from(bits),
                        Initial::LiveIn(i) => Value::from(self.live_ins[i as usize]),
                        Initial::Any => Value::default(),
                    },
                }
            }
        }
    }

    pub(crate) fn live_outs(&self) -> Vec<Bits> {
        let last = self.results.last().expect("at least one iteration");
        let outs = self.dfg.live_outs.iter();
        outs.map(|n| Bits::of_lanes(self.dfg.ty(*n).expect("a result"), last[n.index()].0))
            .collect()
    }
}

/// Issue times of a random modulo schedule that keeps all dependences, for random latencies.
pub(crate) fn schedule(dfg: &Dfg, rng: &mut Pcg32) -> (u32, Vec<i64>) {
    let latencies: Vec<u32> = dfg.nodes.keys().map(|_| 1 + rng.next_u32() % 6).collect();
    let (mii, _) = dfg.rec_mii(|n| latencies[n.index()]);
    let ii = mii + rng.next_u32() % 3;
    let mut times: Vec<i64> = latencies
        .iter()
        .map(|_| i64::from(rng.next_u32() % 60))
        .collect();
    for _ in 0..10_000 {
        let mut changed = false;
        for (from, to, dep) in dfg.deps() {
            let delay = dfg.delay(from, dep, latencies[from.index()]);
            let earliest =
                times[from.index()] + i64::from(delay) - i64::from(ii) * i64::from(dep.distance);
            if times[to.index()] < earliest {
                times[to.index()] = earliest;
                changed = true;
            }
        }
        if !changed {
            return (ii, times);
        }
    }
    panic!("an interval of {ii} is too small for the recurrences of {dfg:#?}");
}
