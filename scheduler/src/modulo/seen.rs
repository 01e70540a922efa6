//! The machine as one loop sees it: what another operation takes, or the control code, says nothing of its schedule. So a
//! schedule stays the same while a designer changes these, and need not be looked for again.

use srp_archdesc::arch::{FuOp, Resource, Srp};
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::dfg::Dfg;
use std::collections::BTreeSet;

/// The machine without what no schedule of a loop depends on: classes and special functions that it does not use, the
/// resources of these, and the cycles of control code, switches and preloads. Kernels share contexts with no other in it.
pub fn seen_by(dfg: &Dfg, srp: &Srp) -> Srp {
    let moves = Ty::ALL.iter().map(|&ty| Opcode::mov(ty));
    let opcodes: BTreeSet<Opcode> = dfg.nodes.values().map(|n| n.op).chain(moves).collect();
    let mut seen = srp.clone();
    for fu in seen.fus.values_mut() {
        fu.ops
            .retain(|how| opcodes.iter().any(|op| op.class() == how.class));
        for how in &mut fu.ops {
            how.special.retain(|special| opcodes.contains(&special.op));
            how.missing.retain(|op| opcodes.contains(op));
            how.given = [false; 2];
            for special in &mut how.special {
                special.how.given = [false; 2];
            }
        }
    }
    let uses = |how: &FuOp| {
        let special = how.special.iter().flat_map(|special| &special.how.uses);
        how.uses.iter().chain(special).copied().collect::<Vec<_>>()
    };
    let ops = seen.fus.values().flat_map(|fu| &fu.ops);
    let used: BTreeSet<Resource> = ops.flat_map(uses).collect();
    for (resource, spec) in seen.resources.iter_mut() {
        if !used.contains(&resource) {
            spec.count = 1;
        }
    }
    Srp {
        shared_contexts: false,
        mode_switch: 0,
        preload_width: 1,
        branch_delay: 0,
        ..seen
    }
}
