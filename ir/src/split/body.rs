//! A loop's block as a dataflow graph.

use super::MAX_DISTANCE;
use super::shape::{Loop, Outer};
use super::{Reason, Refusal};
use crate::dfg::{Initial, LiveIn, Node, NodeData, Operand};
use crate::program::{InstKind, Pos, Slot, Symbol, Value};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::isa::{Effect, Opcode, Ty};
use std::collections::{BTreeMap, BTreeSet};

/// The identity of a live-in value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Origin {
    Symbol(Symbol, i32),
    Slot(Slot, i32),
    Value(Value),
}

/// The replacement of a loop's value in the control code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum After {
    /// Something it had before.
    Outer(Outer),
    /// The launch's result for this node.
    Node(Node),
}

/// The nodes of a loop, and how its values meet those of the control code.
pub(super) struct Body<'a> {
    lp: &'a Loop<'a>,
    mark_pos: Pos,
    pub(super) nodes: EntityMap<Node, NodeData>,
    /// The node that computes each value of the loop.
    pub(super) node_of: BTreeMap<Value, Node>,
    /// The stores, in order.
    pub(super) stores: Vec<Node>,
    pub(super) live_ins: Vec<LiveIn>,
    /// The value of each live-in in the control code.
    pub(super) sources: Vec<Value>,
    origins: BTreeMap<Origin, u32>,
    /// The operand for each parameter that is used.
    params: Vec<Option<Operand>>,
    /// The replacement of each value used after the loop.
    pub(super) after: BTreeMap<Value, After>,
}

impl<'a> Body<'a> {
    pub(super) fn of(lp: &'a Loop<'a>, mark_pos: Pos) -> Result<Body<'a>, Refusal> {
        let mut body = Body {
            lp,
            mark_pos,
            nodes: EntityMap::new(),
            node_of: BTreeMap::new(),
            stores: Vec::new(),
            live_ins: Vec::new(),
            sources: Vec::new(),
            origins: BTreeMap::new(),
            params: vec![None; lp.params().len()],
            after: BTreeMap::new(),
        };
        let needed = needed_values(lp);
        body.number_insts(&needed);
        for (i, param) in lp.params().iter().enumerate() {
            if needed.contains(param) {
                body.resolve_param(i)?;
            }
        }
        body.fill_nodes();
        body.resolve_after();
        body.put_in_order();
        body.drop_unused_live_ins();
        Ok(body)
    }

    /// The operations that are needed become nodes, in source order.
    fn number_insts(&mut self, needed: &BTreeSet<Value>) {
        for &inst in &self.lp.func.blocks[self.lp.block].insts {
            let data = &self.lp.func.insts[inst];
            let InstKind::Op { op, imm, .. } = data.kind else {
                continue;
            };
            let result = data.results.first().copied();
            if result.is_some_and(|r| !needed.contains(&r)) {
                continue;
            }
            let node = self.nodes.push(NodeData {
                op,
                operands: Vec::new(),
                // What makes a `restrict` pointer is a move like others here.
                imm: if op == Opcode::Mov { 0 } else { imm },
                pos: data.pos,
            });
            match result {
                Some(result) => drop(self.node_of.insert(result, node)),
                None if op.info().effect == Effect::Store => self.stores.push(node),
                None => {}
            }
        }
    }

    fn fill_nodes(&mut self) {
        let mut node = 0;
        for &inst in &self.lp.func.blocks[self.lp.block].insts {
            let data = &self.lp.func.insts[inst];
            let InstKind::Op { args, .. } = &data.kind else {
                continue;
            };
            let is_node = data
                .results
                .first()
                .is_none_or(|r| self.node_of.contains_key(r));
            if is_node {
                let operands = args.iter().map(|a| self.operand(*a, data.pos)).collect();
                self.nodes[Node::new(node)].operands = operands;
                node += 1;
            }
        }
    }

    /// A value as an operand of iteration `i`.
    fn operand(&mut self, value: Value, pos: Pos) -> Operand {
        if let Some(i) = self.lp.param_index(value) {
            return self.params[i]
                .clone()
                .expect("used parameters are resolved");
        }
        if let Some(&node) = self.node_of.get(&value) {
            let init = Vec::new();
            return Operand::Node { node, init };
        }
        match self.lp.outer(value) {
            Outer::Const(bits) => Operand::Const(bits),
            Outer::Value(value) => Operand::LiveIn(self.live_in(value, pos)),
        }
    }

    /// The live-in with this value in the control code.
    pub(super) fn live_in(&mut self, value: Value, pos: Pos) -> u32 {
        let origin = match self.lp.inst(value).map(|data| &data.kind) {
            Some(InstKind::SymbolAddr(symbol, offset)) => Origin::Symbol(*symbol, *offset),
            Some(InstKind::SlotAddr(slot, offset)) => Origin::Slot(*slot, *offset),
            _ => Origin::Value(value),
        };
        if let Some(&known) = self.origins.get(&origin) {
            return known;
        }
        let ty = self.lp.ty(value);
        self.add_live_in(LiveIn { ty, pos }, value, origin)
    }

    fn add_live_in(&mut self, live_in: LiveIn, source: Value, origin: Origin) -> u32 {
        let number = u32::try_from(self.live_ins.len()).expect("values are numbered by u32");
        self.live_ins.push(live_in);
        self.sources.push(source);
        self.origins.insert(origin, number);
        number
    }

    /// The live-in of the trip count, which the control code has as `source`.
    pub(super) fn trip_live_in(&mut self, source: Value) -> u32 {
        let known = self.sources.iter().position(|s| *s == source);
        known.map_or_else(
            || {
                let (ty, pos) = (Ty::Word, self.mark_pos);
                self.add_live_in(LiveIn { ty, pos }, source, Origin::Value(source))
            },
            |i| i as u32,
        )
    }

    fn initial(&mut self, i: usize) -> Initial {
        match self.lp.initial[i] {
            Outer::Const(bits) => Initial::Const(bits),
            Outer::Value(v) => Initial::LiveIn(self.live_in(v, self.mark_pos)),
        }
    }

    /// Finds the value of parameter `i` in iteration `i`, and of the parameters on which it
    /// depends.
    fn resolve_param(&mut self, i: usize) -> Result<(), Refusal> {
        // The parameters that it takes its values from, one iteration apart.
        let mut chain = vec![i];
        let end = loop {
            let last = *chain.last().expect("starts with one");
            if self.params[last].is_some() {
                chain.pop();
                break self.params[last].clone();
            }
            let next = self.lp.next[last];
            let Some(j) = self.lp.param_index(next) else {
                break None;
            };
            if let Some(start) = chain.iter().position(|k| *k == j) {
                self.resolve_ring(&chain[start..]);
                chain.truncate(start);
                break self.params[j].clone();
            }
            chain.push(j);
        };
        // From the last to the first: each is the value that the one before had.
        let mut before = end;
        for &k in chain.iter().rev() {
            let previous = match before.take() {
                Some(operand) => operand,
                None => self.operand(self.lp.next[k], self.mark_pos),
            };
            let operand = self.one_later(k, previous);
            if operand
                .producer()
                .is_some_and(|(_, d)| d as usize > MAX_DISTANCE)
            {
                return Err(Refusal {
                    pos: self.mark_pos,
                    reason: Reason::CarriedTooFar,
                });
            }
            self.params[k] = Some(operand.clone());
            before = Some(operand);
        }
        Ok(())
    }

    /// Parameter `k`: its initial value first, then what `previous` was one iteration before.
    fn one_later(&mut self, k: usize, previous: Operand) -> Operand {
        let initial = self.initial(k);
        match (previous, initial) {
            (Operand::Node { node, mut init }, _) => {
                init.push(initial);
                Operand::Node { node, init }
            }
            (Operand::Const(a), Initial::Const(b)) if a == b => Operand::Const(a),
            (Operand::LiveIn(a), Initial::LiveIn(b)) if a == b => Operand::LiveIn(a),
            (unchanging, _) => {
                let node = self.add_move(self.lp.params()[k], unchanging);
                let init = vec![initial];
                Operand::Node { node, init }
            }
        }
    }

    /// Parameters that only pass their values round: one of them becomes a move from itself, as
    /// many iterations ago as there are parameters.
    fn resolve_ring(&mut self, ring: &[usize]) {
        let first = ring[0];
        if let [alone] = ring {
            let unchanging = match self.lp.initial[*alone] {
                Outer::Const(bits) => Operand::Const(bits),
                Outer::Value(v) => Operand::LiveIn(self.live_in(v, self.mark_pos)),
            };
            self.params[first] = Some(unchanging);
            return;
        }
        // Iteration `i` of the first has the initial value of the `i`-th; the last of these stands
        // for iteration -1.
        let init: Vec<_> = ring.iter().rev().map(|k| self.initial(*k)).collect();
        let own = Node::new(self.nodes.len());
        let node = self.add_move(self.lp.params()[first], Operand::Node { node: own, init });
        let init = Vec::new();
        self.params[first] = Some(Operand::Node { node, init });
    }

    fn add_move(&mut self, value: Value, operand: Operand) -> Node {
        self.nodes.push(NodeData {
            op: Opcode::mov(self.lp.ty(value)),
            operands: vec![operand],
            imm: 0,
            pos: self.mark_pos,
        })
    }

    /// Finds the replacements of the values used after the loop: those of the last iteration.
    fn resolve_after(&mut self) {
        for &value in &self.lp.used_after {
            let is_op = self.lp.op(value).is_some();
            if !is_op && self.lp.param_index(value).is_none() {
                // An instruction that control code keeps.
                self.after.insert(value, After::Outer(Outer::Value(value)));
                continue;
            }
            let after = match self.operand(value, self.mark_pos) {
                Operand::Const(bits) => After::Outer(Outer::Const(bits)),
                Operand::LiveIn(i) => After::Outer(Outer::Value(self.sources[i as usize])),
                Operand::Node { node, ref init } if init.is_empty() => After::Node(node),
                earlier @ Operand::Node { .. } => After::Node(self.add_move(value, earlier)),
            };
            self.after.insert(value, after);
        }
    }

    /// Forgets live-ins that no node takes.
    fn drop_unused_live_ins(&mut self) {
        let mut used = BTreeSet::new();
        for data in self.nodes.values_mut() {
            for_each_live_in(data, |i| {
                used.insert(*i);
            });
        }
        let place: BTreeMap<u32, u32> = used.iter().copied().zip(0..).collect();
        for data in self.nodes.values_mut() {
            for_each_live_in(data, |i| *i = place[i]);
        }
        self.origins.retain(|_, i| place.contains_key(i));
        self.origins.values_mut().for_each(|i| *i = place[i]);
        let mut number = 0..;
        self.live_ins
            .retain(|_| number.next().is_some_and(|i| used.contains(&i)));
        let mut number = 0..;
        self.sources
            .retain(|_| number.next().is_some_and(|i| used.contains(&i)));
    }

    /// Puts moves that stand for a parameter before the nodes that read it in the same iteration.
    fn put_in_order(&mut self) {
        let moves: BTreeSet<Node> = self
            .params
            .iter()
            .flatten()
            .filter_map(Operand::producer)
            .filter(|(node, distance)| *distance == 0 && !self.is_inst(*node))
            .map(|(node, _)| node)
            .collect();
        let rest = self.nodes.keys().filter(|n| !moves.contains(n));
        let order: Vec<Node> = moves.iter().copied().chain(rest).collect();
        let mut place = EntityMap::filled(order.len(), Node::new(0));
        for (i, &node) in order.iter().enumerate() {
            place[node] = Node::new(i);
        }
        let mut nodes: EntityMap<Node, NodeData> =
            order.iter().map(|n| self.nodes[*n].clone()).collect();
        for data in nodes.values_mut() {
            for operand in &mut data.operands {
                if let Operand::Node { node, .. } = operand {
                    *node = place[*node];
                }
            }
        }
        self.nodes = nodes;
        for node in self.node_of.values_mut() {
            *node = place[*node];
        }
        for node in &mut self.stores {
            *node = place[*node];
        }
        for after in self.after.values_mut() {
            if let After::Node(node) = after {
                *node = place[*node];
            }
        }
    }

    fn is_inst(&self, node: Node) -> bool {
        self.node_of.values().any(|n| *n == node)
    }
}

/// Calls `f` on the number of every live-in that a node takes.
fn for_each_live_in(data: &mut NodeData, mut f: impl FnMut(&mut u32)) {
    for operand in &mut data.operands {
        match operand {
            Operand::LiveIn(i) => f(i),
            Operand::Node { init, .. } => {
                for initial in init {
                    if let Initial::LiveIn(i) = initial {
                        f(i);
                    }
                }
            }
            Operand::Const(_) => {}
        }
    }
}

/// The values of the loop that something needs: values stored, what prefetches are of, and values used after the loop.
fn needed_values(lp: &Loop<'_>) -> BTreeSet<Value> {
    let mut open: Vec<Value> = lp.used_after.iter().copied().collect();
    for &inst in &lp.func.blocks[lp.block].insts {
        let data = &lp.func.insts[inst];
        if let InstKind::Op { op, args, .. } = &data.kind
            && matches!(op.info().effect, Effect::Store | Effect::Prefetch)
        {
            open.extend_from_slice(args);
        }
    }
    let mut needed = BTreeSet::new();
    while let Some(value) = open.pop() {
        if !lp.is_inside(value) || !needed.insert(value) {
            continue;
        }
        match lp.param_index(value) {
            Some(i) => open.push(lp.next[i]),
            None => {
                let data = lp.inst(value).expect("defined by an instruction");
                open.extend_from_slice(data.kind.args());
            }
        }
    }
    needed
}

impl Body<'_> {
    /// The constants and addresses of the loop that control code still needs, as instructions.
    pub(super) fn kept_insts(&self) -> Vec<crate::program::Inst> {
        let used = |value: &Value| self.sources.contains(value) || self.after.contains_key(value);
        let insts = self.lp.func.blocks[self.lp.block].insts.iter().copied();
        insts
            .filter(|inst| {
                let data = &self.lp.func.insts[*inst];
                let is_kept = matches!(
                    data.kind,
                    InstKind::Const(_) | InstKind::SymbolAddr(..) | InstKind::SlotAddr(..)
                );
                is_kept && data.results.iter().any(used)
            })
            .collect()
    }
}
