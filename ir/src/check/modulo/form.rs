//! Checks of each part by itself: numbers, operands, links between places, live values.

use super::{Checker, MAX_LENGTH, numbered};
use crate::check::Rule;
use crate::dfg::{Initial, Node};
use crate::dre::scheduled::{Placed, PlacedOp, Reg, RegAt, Source};
use crate::program::Bits;
use srp_archdesc::arch::{Carrier, FileKind, RegFile};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Class, Ty};
use srp_archdesc::resource::Place;
use std::collections::BTreeSet;

impl Checker<'_> {
    /// Numbers, and everything placed once.
    pub(super) fn form(&mut self) {
        let schedule = self.schedule;
        let dfg = &schedule.dfg;
        if schedule.ii == 0 || schedule.length == 0 || schedule.length > MAX_LENGTH {
            let message = format!("II {} and length {}", schedule.ii, schedule.length);
            self.report(Rule::Contexts, message);
        }
        self.graph_form();
        if !self.violations.is_empty() {
            return;
        }
        if schedule.ops.len() < dfg.nodes.len() {
            self.report(Rule::Placement, "nodes are missing".to_owned());
        }
        for (number, op) in numbered(schedule) {
            let expected = number.index() < dfg.nodes.len();
            if op.is_move == expected || (expected && op.node != Node::new(number.index())) {
                let message = "not the node that belongs here".to_owned();
                self.report_op(number, Rule::Placement, message);
            }
            self.numbers(number, op);
        }
        for transfer in &schedule.transfers {
            let known = dfg
                .nodes
                .get(transfer.node)
                .is_some_and(|n| n.op.result().is_some())
                && self.is_carrier(transfer.over);
            if !known {
                self.report(
                    Rule::Range,
                    "a transfer of nothing, or over nothing".to_owned(),
                );
            } else if let Some(message) = self.register_fault(transfer.to) {
                self.report(Rule::Range, message);
            }
        }
        self.hop_numbers();
        if self.violations.is_empty() {
            self.live_values();
        }
    }

    fn is_carrier(&self, over: Carrier) -> bool {
        match over {
            Carrier::Link(link) => self.srp.links.get(link).is_some(),
            Carrier::Wire(wire) => self.srp.wires.get(wire).is_some(),
        }
    }

    /// The dataflow graph itself, which has rules of its own.
    fn graph_form(&mut self) {
        for wrong in self.schedule.dfg.verify().err().unwrap_or_default() {
            self.report(Rule::Form, wrong.to_string());
        }
    }

    /// Checks that an operation's numbers name things that exist and fit it.
    fn numbers(&mut self, number: Placed, op: &PlacedOp) {
        let dfg = &self.schedule.dfg;
        let Some(unit) = self.srp.fus.get(op.fu) else {
            return self.report_op(
                number,
                Rule::Range,
                format!("unit {} does not exist", op.fu),
            );
        };
        let Some(data) = dfg.nodes.get(op.node) else {
            return self.report_op(
                number,
                Rule::Range,
                format!("node {} does not exist", op.node),
            );
        };
        if op.is_move && data.op.result().is_none() {
            let message = format!("{} has no value to move", op.node);
            return self.report_op(number, Rule::Placement, message);
        }
        let class = self.opcode(op).class();
        if unit.runs(self.opcode(op)).is_none() || matches!(class, Class::Io | Class::Branch) {
            let message = format!("{} does not run class {class} in a kernel", unit.name);
            self.report_op(number, Rule::Class, message);
        }
        let wanted = if op.is_move { 1 } else { data.operands.len() };
        if op.operands.len() != wanted {
            self.report_op(
                number,
                Rule::Form,
                "the wrong number of operands".to_owned(),
            );
        }
        if op.time > MAX_LENGTH {
            self.report_op(
                number,
                Rule::Contexts,
                format!("issues in cycle {}", op.time),
            );
        }
        let mut carriers = op.operands.iter().filter_map(|source| match *source {
            Source::Out(link) => link.map(Carrier::Link),
            Source::Wire(wire) => Some(Carrier::Wire(wire)),
            Source::Const(_) | Source::Reg { .. } => None,
        });
        if !carriers.all(|over| self.is_carrier(over)) {
            self.report_op(
                number,
                Rule::Range,
                "reads over a link or wire that does not exist".to_owned(),
            );
        }
        let read = op.operands.iter().filter_map(|source| match source {
            Source::Reg { reg, .. } => Some(*reg),
            Source::Const(_) | Source::Out(_) | Source::Wire(_) => None,
        });
        let faults: Vec<String> = read
            .chain(op.writes.iter().copied())
            .filter_map(|at| self.register_fault(at))
            .collect();
        for message in faults {
            self.report_op(number, Rule::Range, message);
        }
    }

    /// Returns the error in a register as an iteration names it, if there is one.
    fn register_fault(&self, at: RegAt) -> Option<String> {
        let Some(file) = self.srp.files.get(at.file) else {
            return Some(format!("file {} does not exist", at.file));
        };
        let fits = match file.kind {
            FileKind::Rotating => at.ring == 1 && at.index < file.size,
            FileKind::Central | FileKind::Static => {
                at.ring > 0 && u64::from(at.index) + u64::from(at.ring) <= u64::from(file.size)
            }
        };
        let (index, ring) = (at.index, at.ring);
        (!fits).then(|| format!("{} has no register {index} with ring {ring}", file.name))
    }

    fn live_values(&mut self) {
        let schedule = self.schedule;
        let dfg = &schedule.dfg;
        if schedule.live_in_regs.len() != dfg.live_ins.len()
            || schedule.live_out_regs.len() != dfg.live_outs.len()
        {
            let message = "not one register for each live-in and live-out".to_owned();
            return self.report(Rule::LiveIn, message);
        }
        let mut seen = BTreeSet::new();
        for (reg, live_in) in schedule.live_in_regs.iter().zip(&dfg.live_ins) {
            self.central(*reg, live_in.ty, Rule::LiveIn);
            if !seen.insert(*reg) {
                let message = "two live-in values in one register".to_owned();
                self.report(Rule::LiveIn, message);
            }
        }
        for (reg, node) in schedule.live_out_regs.iter().zip(&dfg.live_outs) {
            let ty = dfg.ty(*node).expect("live-outs were found to be values");
            self.central(*reg, ty, Rule::LiveOut);
        }
        let mut set = BTreeSet::new();
        for preload in &schedule.preloads {
            let ty = match preload.value {
                Initial::Const(bits) => Some(bits.ty()),
                Initial::LiveIn(k) => dfg.live_ins.get(k as usize).map(|l| l.ty),
                Initial::Any => None,
            };
            let at = RegAt {
                file: preload.file,
                index: preload.index,
                ring: 1,
            };
            let reg = Reg {
                file: preload.file,
                index: preload.index,
            };
            if let Some(message) = self.register_fault(at) {
                self.report(Rule::Range, message);
                continue;
            }
            if ty != Some(preload.ty) || !self.srp.files[preload.file].holds(preload.ty) {
                self.report(
                    Rule::LiveIn,
                    "a register is set to the wrong type".to_owned(),
                );
            }
            let other = schedule.live_in_regs.iter().position(|&r| r == reg);
            let same = other.is_none_or(|k| preload.value == Initial::LiveIn(k as u32));
            if !set.insert(reg) || !same {
                let message = "a register is set twice at entry".to_owned();
                self.report(Rule::LiveIn, message);
            }
        }
    }

    fn central(&mut self, reg: Reg, ty: Ty, rule: Rule) {
        let file = self.srp.files.get(reg.file);
        let fits = file.is_some_and(|file| {
            file.kind == FileKind::Central && reg.index < file.size && file.holds(ty)
        });
        if !fits {
            self.report(rule, format!("{reg:?} is no central register for {ty}"));
        }
    }

    /// Checks that the machine has the links that values take, and that memory orders are kept.
    pub(super) fn ways(&mut self) {
        let schedule = self.schedule;
        for (number, op) in numbered(schedule) {
            self.operand_ways(number, op);
            self.result_ways(number, op);
        }
        for transfer in &schedule.transfers {
            let ty = schedule.dfg.ty(transfer.node);
            let ty = ty.expect("transfers were found to move values");
            let from = match transfer.over {
                Carrier::Link(link) => self.output(self.srp.links[link].from, ty),
                Carrier::Wire(wire) => self.graph.wire[wire][0],
            };
            let to = self.graph.file[transfer.to.file];
            let way = self.graph.transfers[from]
                .iter()
                .find(|t| t.over == transfer.over && t.to == to);
            match way {
                None => {
                    let message = format!("{} is transferred where no way leads", transfer.node);
                    self.report(Rule::Routing, message);
                }
                Some(way) if way.width < ty.bits() => {
                    let message = format!("{} is too wide for its transfer", transfer.node);
                    self.report(Rule::Width, message);
                }
                Some(_) => {}
            }
        }
        for order in &schedule.dfg.order {
            let time = |node: Node| i64::from(schedule.ops[Placed::new(node.index())].time);
            let stores = schedule.dfg.nodes[order.from].op.result().is_none();
            let wait = i64::from(stores);
            let later = time(order.to) + i64::from(schedule.ii) * i64::from(order.distance);
            if later < time(order.from) + wait {
                let message = format!("{} comes too early after {}", order.to, order.from);
                self.report(Rule::MemoryOrder, message);
            }
        }
    }

    /// The output that a value of this type stands in.
    pub(super) fn output(&self, fu: srp_archdesc::arch::Fu, ty: Ty) -> Place {
        match ty {
            Ty::Pred => self.graph.pred_out[fu],
            Ty::Word | Ty::Vec => self.graph.out[fu],
        }
    }

    /// The types of an operation's operands.
    pub(super) fn operand_types(&self, op: &PlacedOp) -> Vec<Ty> {
        let dfg = &self.schedule.dfg;
        if dfg.is_bare() && !op.is_move {
            let operands = dfg.nodes[op.node].operands.iter();
            let ty = |o| dfg.operand_ty(o).expect("operands were found to exist");
            return operands.map(ty).collect();
        }
        let kinds = self.opcode(op).info().operands;
        kinds.iter().map(|kind| kind.ty()).collect()
    }

    fn operand_ways(&mut self, number: Placed, op: &PlacedOp) {
        let mut constants: BTreeSet<Bits> = BTreeSet::new();
        for (source, ty) in op.operands.iter().zip(self.operand_types(op)) {
            let (from, over) = match *source {
                Source::Const(bits) => {
                    // The bit of a predicate is part of the operation.
                    if bits.ty() != Ty::Pred {
                        constants.insert(bits);
                    }
                    if op.is_move || bits.ty() != ty {
                        let message = format!("takes constant {bits}");
                        self.report_op(number, Rule::Form, message);
                    }
                    continue;
                }
                Source::Out(None) => (self.output(op.fu, ty), None),
                Source::Out(Some(link)) => {
                    let from = self.output(self.srp.links[link].from, ty);
                    (from, Some(Carrier::Link(link)))
                }
                Source::Wire(wire) => (self.graph.wire[wire][0], Some(Carrier::Wire(wire))),
                Source::Reg { reg, .. } => (self.graph.file[reg.file], None),
            };
            let paths = self.graph.reads[op.fu].iter();
            let path = paths.clone().find(|p| p.from == from && p.over == over);
            let place = self.graph.name(self.srp, from);
            let unit = &self.srp.fus[op.fu].name;
            match path {
                None => {
                    let message = format!("{unit} cannot read {place} that way");
                    self.report_op(number, Rule::Routing, message);
                }
                Some(path) if path.width < ty.bits() => {
                    let message = format!("a value of type {ty} does not fit from {place}");
                    self.report_op(number, Rule::Width, message);
                }
                Some(_) => {}
            }
        }
        let room = self.srp.fus[op.fu].constants as usize;
        if constants.len() > room {
            let message = format!("{} constants, {room} fit", constants.len());
            self.report_op(number, Rule::Constants, message);
        }
    }

    fn result_ways(&mut self, number: Placed, op: &PlacedOp) {
        let Some(ty) = self.ty(op) else {
            if !op.writes.is_empty() {
                let message = "writes without a result".to_owned();
                self.report_op(number, Rule::Form, message);
            }
            return;
        };
        let out = self.output(op.fu, ty);
        if self.graph.places[out].width < ty.bits() {
            let message = format!("{} is too narrow", self.graph.name(self.srp, out));
            self.report_op(number, Rule::Width, message);
        }
        let mut files: BTreeSet<RegFile> = BTreeSet::new();
        for at in &op.writes {
            let file = &self.srp.files[at.file];
            if !self.graph.writes[op.fu].contains(&self.graph.file[at.file]) {
                let message = format!("{} cannot write {}", self.srp.fus[op.fu].name, file.name);
                self.report_op(number, Rule::Routing, message);
            }
            if !file.holds(ty) {
                let message = format!("does not fit in {}", file.name);
                self.report_op(number, Rule::Width, message);
            }
            if !files.insert(at.file) {
                let message = format!("writes two registers of {}", file.name);
                self.report_op(number, Rule::Routing, message);
            }
        }
    }
}
