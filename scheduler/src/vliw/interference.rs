//! The interference graph: which registers must differ because one is written while the other
//! holds a value that is still read.

use super::lir::{Code, Inst, Kind, Vreg};
use super::liveness;
use super::target::Target;
use srp_archdesc::arch::RegFile;
use srp_archdesc::entity::{Entity, EntityMap};
use std::collections::BTreeSet;

/// The interference graph of one function. Registers that were coalesced are one node, that of
/// their representative.
pub(super) struct Interference {
    /// The central file each register belongs to.
    pub(super) file: EntityMap<Vreg, RegFile>,
    physical: usize,
    /// The nodes that interfere with each node.
    neighbours: EntityMap<Vreg, BTreeSet<Vreg>>,
    leader: EntityMap<Vreg, Vreg>,
    /// The registers that each node represents besides itself.
    followers: EntityMap<Vreg, Vec<Vreg>>,
    /// Moves between registers with the depth of their loops, deepest first.
    pub(super) copies: Vec<(Vreg, Vreg, u32)>,
    /// The cost of spilling each register: its accesses, weighted with the depth of their loops.
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
            neighbours: EntityMap::filled(code.regs.len(), BTreeSet::new()),
            leader: code.regs.keys().collect(),
            followers: EntityMap::filled(code.regs.len(), Vec::new()),
            copies: Vec::new(),
            cost: EntityMap::filled(code.regs.len(), 0.0),
        };
        let out = liveness::live_out(code);
        for &label in &code.order {
            let block = &code.blocks[label];
            let weight = 10f64.powi(block.depth.min(8) as i32);
            // A sorted set: few of the many registers are live at once.
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
        self.neighbours[a].insert(b);
        self.neighbours[b].insert(a);
    }

    /// True if it is a register of the machine.
    pub(super) fn is_physical(&self, reg: Vreg) -> bool {
        reg.index() < self.physical
    }

    /// The node that a register is part of.
    pub(super) fn find(&self, reg: Vreg) -> Vreg {
        self.leader[reg]
    }

    /// True if two nodes must have different registers.
    pub(super) fn interfere(&self, a: Vreg, b: Vreg) -> bool {
        self.neighbours[b].contains(&a)
    }

    /// The nodes that a node must differ from, those of the machine first.
    pub(super) fn neighbours(&self, node: Vreg) -> &BTreeSet<Vreg> {
        &self.neighbours[node]
    }

    /// The registers of the machine that a node must differ from.
    pub(super) fn machine_neighbours(&self, node: Vreg) -> impl Iterator<Item = Vreg> + '_ {
        let machine = ..Vreg::new(self.physical);
        self.neighbours[node].range(machine).copied()
    }

    /// Makes `b` part of `a`, which must not interfere.
    pub(super) fn merge(&mut self, a: Vreg, b: Vreg) {
        self.cost[a] += self.cost[b];
        for other in std::mem::take(&mut self.neighbours[b]) {
            self.neighbours[other].remove(&b);
            self.neighbours[other].insert(a);
            self.neighbours[a].insert(other);
        }
        let followers = std::mem::take(&mut self.followers[b]);
        for follower in followers.into_iter().chain([b]) {
            self.leader[follower] = a;
            self.followers[a].push(follower);
        }
    }
}
