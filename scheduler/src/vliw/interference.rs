//! The interference graph: which registers must differ because one is written while the other
//! holds a value that is still read.

use super::lir::{Code, Inst, Kind, Vreg};
use super::liveness;
use super::target::Target;
use rustc_hash::FxHashSet;
use srp_archdesc::arch::RegFile;
use srp_archdesc::entity::{Entity, EntityMap};
use std::collections::BTreeSet;

/// The interference graph of one function. Registers that were coalesced are one node, that of
/// their representative.
pub(super) struct Interference {
    /// The central file each register belongs to.
    pub(super) file: EntityMap<Vreg, RegFile>,
    physical: usize,
    edges: FxHashSet<(Vreg, Vreg)>,
    neighbours: EntityMap<Vreg, Vec<Vreg>>,
    leader: EntityMap<Vreg, Vreg>,
    /// Moves between registers with the depth of their loops, deepest first.
    pub(super) copies: Vec<(Vreg, Vreg, u32)>,
    /// What spilling a register would cost: accesses, each weighted with the depth of its loops.
    pub(super) cost: EntityMap<Vreg, f64>,
}

impl Interference {
    /// The graph of `code`.
    pub(super) fn of(code: &Code, target: &Target<'_>) -> Interference {
        let physical = target.physical() as usize;
        let file = code.regs.iter().map(|(reg, data)| {
            if reg.index() < physical {
                target.reg(reg.index() as u32).file
            } else {
                target.file(data.ty)
            }
        });
        let mut graph = Interference {
            file: file.collect(),
            physical,
            edges: FxHashSet::default(),
            neighbours: EntityMap::filled(code.regs.len(), Vec::new()),
            leader: code.regs.keys().collect(),
            copies: Vec::new(),
            cost: EntityMap::filled(code.regs.len(), 0.0),
        };
        let out = liveness::live_out(code);
        for &label in &code.order {
            let block = &code.blocks[label];
            let weight = 10f64.powi(block.depth.min(8) as i32);
            // Few registers are live at once, of which there may be many.
            let mut live: BTreeSet<Vreg> = out[label].iter().collect();
            for reg in block.end.uses() {
                live.insert(reg);
                graph.cost[reg] += weight;
            }
            for inst in block.insts.iter().rev() {
                graph.visit(inst, &live, weight, block.depth);
                for reg in inst.defs.iter().chain(&inst.clobbers) {
                    live.remove(reg);
                }
                live.extend(inst.uses());
            }
        }
        graph
            .copies
            .sort_by_key(|&(dst, src, depth)| (std::cmp::Reverse(depth), dst, src));
        graph
    }

    fn visit(&mut self, inst: &Inst, live: &BTreeSet<Vreg>, weight: f64, depth: u32) {
        let copy = inst.as_copy();
        if let Some((dst, src)) = copy {
            self.copies.push((dst, src, depth));
        }
        let source = copy.map(|(_, src)| src);
        for &def in inst.defs.iter().chain(&inst.clobbers) {
            for &other in live.iter().filter(|&&r| Some(r) != source) {
                self.add(def, other);
            }
        }
        // Results of one instruction, and what it destroys, are all written.
        if !matches!(inst.kind, Kind::Op(_)) {
            for &def in &inst.defs {
                let others = inst.defs.iter().chain(&inst.clobbers);
                others.for_each(|&other| self.add(def, other));
            }
        }
        let spilled = inst.defs.iter().copied().chain(inst.uses());
        spilled.for_each(|reg| self.cost[reg] += weight);
    }

    fn add(&mut self, a: Vreg, b: Vreg) {
        let both_physical = self.is_physical(a) && self.is_physical(b);
        if a == b || both_physical || self.file[a] != self.file[b] {
            return;
        }
        if self.edges.insert((a.min(b), a.max(b))) {
            self.neighbours[a].push(b);
            self.neighbours[b].push(a);
        }
    }

    /// Whether it is a register of the machine.
    pub(super) fn is_physical(&self, reg: Vreg) -> bool {
        reg.index() < self.physical
    }

    /// The node that a register is part of.
    pub(super) fn find(&self, mut reg: Vreg) -> Vreg {
        while self.leader[reg] != reg {
            reg = self.leader[reg];
        }
        reg
    }

    /// Whether two nodes must differ.
    pub(super) fn interfere(&self, a: Vreg, b: Vreg) -> bool {
        self.edges.contains(&(a.min(b), a.max(b)))
    }

    /// The nodes that a node must differ from, in order, each once.
    pub(super) fn neighbours(&self, node: Vreg) -> Vec<Vreg> {
        let mut list: Vec<Vreg> = self.neighbours[node]
            .iter()
            .map(|&r| self.find(r))
            .collect();
        list.sort_unstable();
        list.dedup();
        list
    }

    /// Makes `b` part of `a`, which must not interfere.
    pub(super) fn merge(&mut self, a: Vreg, b: Vreg) {
        self.leader[b] = a;
        self.cost[a] += self.cost[b];
        for other in std::mem::take(&mut self.neighbours[b]) {
            let other = self.find(other);
            if self.edges.insert((a.min(other), a.max(other))) {
                self.neighbours[a].push(other);
                self.neighbours[other].push(a);
            }
        }
    }
}
