//! Checks of wires: what each takes in each slot of the II, and that this leads back to an output.

use super::{Checker, MAX_LENGTH, numbered};
use crate::check::Rule;
use crate::dfg::Node;
use crate::dre::scheduled::{PlacedHop, Source};
use srp_archdesc::arch::{Carrier, Input, Wire};
use srp_archdesc::isa::Ty;
use srp_archdesc::resource::Place;

impl Checker<'_> {
    /// Checks that the numbers of hops name things that exist.
    pub(super) fn hop_numbers(&mut self) {
        for hop in &self.schedule.hops {
            let node = self.schedule.dfg.nodes.get(hop.node);
            let input = match hop.from {
                Input::Unit(fu) => self.srp.fus.get(fu).is_some(),
                Input::Wire(wire) => self.is_wire(wire),
            };
            if node.is_none_or(|n| n.op.result().is_none()) || !input || !self.is_wire(hop.wire) {
                let message = "a hop of nothing, from nothing or on to no wire".to_owned();
                self.report(Rule::Range, message);
            } else if hop.time > MAX_LENGTH {
                self.report(Rule::Contexts, format!("a hop in cycle {}", hop.time));
            }
        }
    }

    fn is_wire(&self, wire: Wire) -> bool {
        self.srp.wires.get(wire).is_some()
    }

    pub(super) fn slot(&self, cycle: i64) -> u32 {
        let slot = cycle.rem_euclid(i64::from(self.schedule.ii));
        u32::try_from(slot).expect("a slot is smaller than the II")
    }

    /// Checks that wires have the inputs that they take and take one in a cycle, that values fit, and that they
    /// pass no more wires than they may.
    pub(super) fn wires(&mut self) {
        for &hop in &self.schedule.hops {
            let PlacedHop { node, wire, .. } = hop;
            let name = &self.srp.wires[wire].name;
            let (from, to) = (self.start(hop), self.graph.wire[wire][0]);
            match self.graph.hops[from].iter().find(|way| way.to == to) {
                None => {
                    let message = format!("{node} is taken by {name} from where it takes nothing");
                    self.report(Rule::Routing, message);
                }
                Some(way) if way.width < self.value(node).bits() => {
                    self.report(Rule::Width, format!("{node} does not fit on {name}"));
                }
                Some(_) => {}
            }
            let slot = self.slot(hop.time.into());
            if let Some(other) = self.hops.insert((wire, slot), hop) {
                let message = format!("{name} takes {node} and {} in slot {slot}", other.node);
                self.report(Rule::Wire, message);
            }
        }
        for &hop in &self.schedule.hops {
            self.way_back(hop);
        }
        self.taken_from_wires();
    }

    /// The place that a hop starts from.
    fn start(&self, hop: PlacedHop) -> Place {
        match hop.from {
            Input::Unit(fu) => self.output(fu, self.value(hop.node)),
            Input::Wire(wire) => self.graph.wire[wire][0],
        }
    }

    fn value(&self, node: Node) -> Ty {
        let ty = self.schedule.dfg.ty(node);
        ty.expect("what hops was found to be a value")
    }

    /// Follows a hop back to the output that it begins at.
    fn way_back(&mut self, hop: PlacedHop) {
        let name = &self.srp.wires[hop.wire].name;
        let (mut at, mut cycle) = (hop, i64::from(hop.time));
        // Hops of the cycle, and all.
        let (mut hops, mut steps) = (1, 0);
        while let Input::Wire(before) = at.from {
            let delay = self.srp.wires[before].delay;
            cycle -= i64::from(delay);
            hops = if delay > 0 { 1 } else { hops + 1 };
            steps += 1;
            let most = self.srp.hops;
            if hops > most || steps > self.schedule.hops.len() {
                let way = match steps > self.schedule.hops.len() {
                    true => "in a circle".to_owned(),
                    false => format!("over {hops} wires in a cycle, not {most}"),
                };
                let message = format!("{} comes to {name} {way}", hop.node);
                return self.report(Rule::Wire, message);
            }
            match self.hops.get(&(before, self.slot(cycle))) {
                Some(earlier) if earlier.node == hop.node => at = *earlier,
                _ => {
                    let before = &self.srp.wires[before].name;
                    let message =
                        format!("{name} takes {} from {before}, which has it not", hop.node);
                    return self.report(Rule::Routing, message);
                }
            }
        }
    }

    /// Checks that wires from which something is taken have something of its type.
    fn taken_from_wires(&mut self) {
        let lacks = |this: &Self, wire: Wire, taken: i64, ty: Ty| {
            let hop = this.hops.get(&(wire, this.slot(taken)));
            hop.is_none_or(|hop| this.value(hop.node) != ty)
        };
        for (number, op) in numbered(self.schedule) {
            for (source, ty) in op.operands.iter().zip(self.operand_types(op)) {
                let Source::Wire(wire) = *source else {
                    continue;
                };
                let spec = &self.srp.wires[wire];
                if lacks(self, wire, i64::from(op.time) - i64::from(spec.delay), ty) {
                    let message = format!("{} has nothing of type {ty} then", spec.name);
                    self.report_op(number, Rule::Routing, message);
                }
            }
        }
        for transfer in &self.schedule.transfers {
            if let Carrier::Wire(wire) = transfer.over
                && lacks(self, wire, transfer.time.into(), self.value(transfer.node))
            {
                let name = &self.srp.wires[wire].name;
                let message = format!(
                    "{} is transferred from {name}, which has it not",
                    transfer.node
                );
                self.report(Rule::Routing, message);
            }
        }
    }
}
