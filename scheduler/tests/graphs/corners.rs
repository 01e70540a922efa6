//! Small graphs on large arrays: they reach the II that they have on a small array, and the checker of schedules
//! accepts on the whole array what was found in a corner.

use super::{graph, machine, map, mesh, tree};
use srp_archdesc::Unwatched;
use srp_archdesc::arch::Arch;
use srp_archdesc::xml::{StandardArray, standard};
use srp_ir::graph::Graph;
use srp_scheduler::modulo;
use std::fmt::Write;

/// A filter of one tap, with a sum that goes round.
fn fir() -> Graph {
    let text = "digraph { x [op=load]; m [opcode=mul]; sum [op=add]; y [op=store]; x -> m; m -> sum -> y; \
                sum -> sum [distance=1]; y -> x [kind=order, distance=1]; }";
    graph("fir.dot", text.to_owned())
}

/// The butterflies of a transform of so many points.
fn butterflies(points: u32) -> Graph {
    let mut text = String::from("digraph {");
    for i in 0..points {
        write!(text, " s0_{i} [op=load];").expect("strings can be written");
    }
    for stage in 1..=points.ilog2() {
        for i in 0..points {
            let (before, other) = (stage - 1, i ^ (1 << (stage - 1)));
            write!(
                text,
                " s{stage}_{i} [op=add]; s{before}_{i} -> s{stage}_{i}; s{before}_{other} -> s{stage}_{i};"
            )
            .expect("strings can be written");
        }
    }
    text.push('}');
    graph("butterflies.dot", text)
}

#[test]
fn large_arrays_are_no_worse_than_small_ones() {
    let graphs = [fir(), butterflies(4), tree(8), tree(16)];
    for graph in &graphs {
        let small = map(graph, &mesh(8, 8));
        for side in [16, 24, 32, 64] {
            let large = map(graph, &mesh(side, side));
            let (found, known) = (large.schedule.ii, small.schedule.ii);
            assert!(found <= known, "{} on {side}: {found}", graph.dfg.name);
            assert_eq!(large.bounds.recurrences, small.bounds.recurrences);
            assert!(large.least_length <= large.schedule.length);
        }
    }
}

/// A mesh of 24×24 units with wires.
fn wired(wires: &str) -> Arch {
    let array = StandardArray {
        wires: wires.to_owned(),
        ..StandardArray::mesh(24, 24)
    };
    machine(&standard(&array).expect("such an array there is"))
}

#[test]
fn corners_have_the_switches_and_buses_within() {
    for wires in ["mesh", "row column", "mesh row"] {
        let scheduled = map(&tree(8), &wired(wires));
        assert_eq!(scheduled.schedule.ii, 1, "{wires}");
    }
}

#[test]
fn the_bound_is_that_of_the_whole_array() {
    // Only the first column loads: 15 loads take 24 units once, and a corner of four rows four times.
    let mut arch = mesh(24, 24);
    for fu in arch.srp.fus.values_mut().filter(|fu| fu.col > 0) {
        let is_load = |op: &srp_archdesc::arch::FuOp| op.class == srp_archdesc::isa::Class::Load;
        fu.ops.retain(|op| !is_load(op));
    }
    let scheduled = map(&tree(8), &arch);
    assert_eq!(scheduled.bounds.resources, 1);
    assert_eq!(scheduled.schedule.ii, 1);
}

#[test]
fn a_graph_has_the_same_schedule_again() {
    let arch = mesh(32, 32);
    let graph = butterflies(4);
    let options = modulo::Options::default();
    let once = modulo::schedule(&graph.dfg, &arch.srp, &options, &Unwatched);
    let twice = modulo::schedule(&graph.dfg, &arch.srp, &options, &Unwatched);
    assert_eq!(once, twice);
}
