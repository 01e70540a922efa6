//! Kernels: first static checks, then a run with tokens for values.

mod form;
mod table;
mod tokens;
mod wires;

use super::{Place, Rule, Violation};
use crate::dre::scheduled::{ModuloSchedule, Placed, PlacedHop, PlacedOp, ScheduledDre};
use crate::program::Kernel;
use srp_archdesc::ResourceGraph;
use srp_archdesc::arch::{FuOp, Srp, Wire};
use srp_archdesc::entity::Entity;
use srp_archdesc::isa::{Opcode, Ty};
use std::collections::BTreeMap;

/// All rules that the kernels of `dre` break on `srp`, by kernel. They are launched, so none is a
/// bare graph.
pub fn check_kernels(dre: &ScheduledDre, srp: &Srp) -> Vec<Violation> {
    let graph = ResourceGraph::of(srp);
    let mut violations = Vec::new();
    for (kernel, schedule) in dre.kernels.iter() {
        if schedule.dfg.is_bare() {
            violations.push(Violation {
                at: Place::Kernel(kernel),
                rule: Rule::Form,
                message: "has no trip count".to_owned(),
            });
        }
        violations.append(&mut checked(schedule, kernel, srp, &graph));
    }
    violations
}

/// All rules that a modulo schedule by itself breaks on `srp`, as those of kernel 0. The loop may be
/// a bare graph.
pub fn check_loop(schedule: &ModuloSchedule, srp: &Srp) -> Vec<Violation> {
    checked(schedule, Kernel::new(0), srp, &ResourceGraph::of(srp))
}

/// The same of several loops, each as the kernel of its number.
pub fn check_loops(schedules: &[ModuloSchedule], srp: &Srp) -> Vec<Violation> {
    let graph = ResourceGraph::of(srp);
    let numbered = schedules.iter().enumerate();
    let each = numbered.map(|(number, s)| checked(s, Kernel::new(number), srp, &graph));
    each.flatten().collect()
}

fn checked(
    schedule: &ModuloSchedule,
    kernel: Kernel,
    srp: &Srp,
    graph: &ResourceGraph,
) -> Vec<Violation> {
    let mut checker = Checker {
        srp,
        graph,
        kernel,
        schedule,
        hops: BTreeMap::new(),
        violations: Vec::new(),
    };
    checker.check();
    checker.violations.sort();
    checker.violations.dedup();
    checker.violations
}

struct Checker<'a> {
    srp: &'a Srp,
    graph: &'a ResourceGraph,
    kernel: Kernel,
    schedule: &'a ModuloSchedule,
    /// What each wire takes in each slot of the II.
    hops: BTreeMap<(Wire, u32), PlacedHop>,
    violations: Vec<Violation>,
}

impl Checker<'_> {
    fn check(&mut self) {
        // Each part relies on what the ones before it found right.
        let parts = [Self::form, Self::ways, Self::tables, Self::wires, Self::run];
        for part in parts {
            part(self);
            if !self.violations.is_empty() {
                return;
            }
        }
    }

    fn report(&mut self, rule: Rule, message: String) {
        self.violations.push(Violation {
            at: Place::Kernel(self.kernel),
            rule,
            message,
        });
    }

    fn report_op(&mut self, op: Placed, rule: Rule, message: String) {
        self.violations.push(Violation {
            at: Place::Op(self.kernel, op),
            rule,
            message: format!("{}: {message}", self.name(op)),
        });
    }

    /// Returns the opcode of a placed operation: that of its node, or a move.
    fn opcode(&self, op: &PlacedOp) -> Opcode {
        let node = self.schedule.dfg.nodes[op.node].op;
        match node.result() {
            Some(ty) if op.is_move => Opcode::mov(ty),
            _ => node,
        }
    }

    /// How the unit of a placed operation runs it.
    fn how(&self, op: &PlacedOp) -> &FuOp {
        let how = self.srp.fus[op.fu].timing(self.opcode(op));
        how.expect("units were checked to run their operations")
    }

    /// The type of a node's result.
    fn ty(&self, op: &PlacedOp) -> Option<Ty> {
        self.schedule.dfg.ty(op.node)
    }

    fn name(&self, op: Placed) -> String {
        let placed = &self.schedule.ops[op];
        let what = if placed.is_move { "a move of " } else { "" };
        let node = self.schedule.dfg.nodes.get(placed.node);
        let opcode = node.map_or(String::new(), |node| format!(" `{}`", node.op));
        format!("{what}{}{opcode}", placed.node)
    }
}

/// Greatest number of operations that a run with tokens follows; longer schedules are refused.
const MAX_STEPS: u64 = 50_000_000;

/// Longest schedule of one iteration that is looked at, in cycles.
const MAX_LENGTH: u32 = 1 << 20;

/// The operations with their numbers.
fn numbered(schedule: &ModuloSchedule) -> impl Iterator<Item = (Placed, &PlacedOp)> {
    schedule
        .ops
        .values()
        .enumerate()
        .map(|(i, op)| (Placed::new(i), op))
}
