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

#[cfg(test)]
mod tests {
    use super::*;
    use srp_archdesc::diagnostic::Source;
    use srp_archdesc::machines::SGRT;
    use srp_archdesc::xml::Change;
    use srp_ir::graph::{Options, read_edges};

    /// The machine that comes along with a setting, as a loop sees it that loads, computes a root and adds.
    fn seen(setting: &str) -> Srp {
        let (edges, ops) = (
            Source::new("g.edges", "a b 0\nb c 0\nc c 1"),
            "a load\nb rsqrt\nc fadd",
        );
        let graph = read_edges(&edges, &Source::new("g.ops", ops), &Options::default());
        let graph = graph.expect("a graph");
        let change: Change = setting.parse().expect("a setting");
        let xml = change.make(SGRT.xml).expect("the machine has it");
        let arch = srp_archdesc::parse("sgrt.xml", &xml).expect("a machine");
        seen_by(&graph.dfg, &arch.srp)
    }

    #[test]
    fn a_loop_sees_what_it_uses_and_nothing_else() {
        let as_it_is = seen("array.rows=4");
        for unseen in [
            "vliw.branch-delay=3",
            "vliw.mode-switch=9",
            "vliw.preload-width=2",
            "op[class=fdiv].latency=20",
            "op[class=tex].interval=2",
            "op[class=store].latency=3",
            "resource[name=texture_port].count=3",
        ] {
            assert_eq!(seen(unseen), as_it_is, "{unseen}");
        }
        for seen_of in [
            "op[class=load].latency=5",
            "op[class=fadd].interval=2",
            "op[class=sfu].latency=9",
            "op[class=alu].latency=2",
            "op[class=lane].latency=2",
            "resource[name=sram_port].count=3",
            "array.contexts=64",
            "fu-type[*]/file[*].size=8",
        ] {
            assert_ne!(seen(seen_of), as_it_is, "{seen_of}");
        }
    }
}
