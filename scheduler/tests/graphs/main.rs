//! Bare graphs on standard arrays: schedules pass the checker and read back, other mappers' graphs
//! reach the intervals that are known of them, and larger machines are never worse.

mod corners;
mod ended;
mod lengths;
mod monotone;
mod orders;
mod reads;

use srp_archdesc::Unwatched;
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::{Source, render_all};
use srp_archdesc::entity::EntityMap;
use srp_archdesc::xml::{StandardArray, standard};
use srp_ir::check::check_loop;
use srp_ir::dre::scheduled::ScheduledLoops;
use srp_ir::graph::{Graph, Options, read_dot, read_edges};
use srp_scheduler::modulo::{self, Scheduled, Unschedulable};
use std::fmt::Write;
use std::path::Path;

/// A machine from its file.
fn machine(xml: &str) -> Arch {
    srp_archdesc::parse("array.xml", xml)
        .unwrap_or_else(|errors| panic!("{}", render_all(&errors, xml, false)))
}

fn mesh(rows: u32, cols: u32) -> Arch {
    machine(&standard(&StandardArray::mesh(rows, cols)).expect("a mesh there is"))
}

fn graph(name: &str, text: String) -> Graph {
    read_dot(&Source::new(name, text), &Options::default()).expect("a graph")
}

/// A tree that adds so many values.
fn tree(leaves: u32) -> Graph {
    let mut text = String::from("digraph {");
    for i in 1..2 * leaves {
        let op = if i < leaves { "add" } else { "load" };
        write!(text, " n{i} [op={op}];").expect("strings can be written");
        if i > 1 {
            write!(text, " n{i} -> n{};", i / 2).expect("strings can be written");
        }
    }
    text.push('}');
    graph("tree.dot", text)
}

/// The schedule of a graph, checked.
fn map(graph: &Graph, arch: &Arch) -> Scheduled {
    let name = &graph.dfg.name;
    assert_eq!(graph.dfg.verify(), Ok(()), "{name}");
    let scheduled = modulo::schedule(
        &graph.dfg,
        &arch.srp,
        &modulo::Options::default(),
        &Unwatched,
    )
    .unwrap_or_else(|e| panic!("{name}: {e}"));
    let wrong = check_loop(&scheduled.schedule, &arch.srp);
    assert!(wrong.is_empty(), "{name}: {wrong:?}");
    scheduled
}

const RECURRENCES: &str = "digraph {
    node [op=add];
    a -> b [operand=0]; b -> c; c -> a [distance=1]; a -> a [operand=3, distance=2];
    x [op=load]; x -> a; x -> y; y [op=store]; y -> x [distance=1, kind=order];
    c -> d [distance=3]; c -> d; d -> d [distance=1];
    alone;
}";

#[test]
fn bare_graphs_are_scheduled_and_read_back() {
    let arch = mesh(3, 3);
    let source = Source::new("recurrences.dot", RECURRENCES);
    let graph = read_dot(&source, &Options::default()).expect("a graph");
    let scheduled = map(&graph, &arch);
    assert_eq!(scheduled.bounds.recurrences, 3);
    assert_eq!(scheduled.schedule.ii, 3);
    assert!(
        scheduled.schedule.preloads.is_empty(),
        "nothing is set for values that do not matter"
    );
    let loops = ScheduledLoops {
        machine: arch.name.clone(),
        files: graph.files.clone(),
        loops: vec![scheduled.schedule.clone(); 2],
    };
    let file = srp_ir::dre::write_loops(&loops, &arch);
    let again = srp_ir::dre::read_loops(&file, &arch).unwrap_or_else(|e| panic!("{e}\n{file}"));
    assert!(again == loops, "read differently:\n{file}");
    // A program cannot launch it.
    let program = srp_ir::dre::scheduled::ScheduledDre {
        machine: arch.name.clone(),
        files: EntityMap::new(),
        image: Vec::new(),
        symbols: Vec::new(),
        bundles: EntityMap::new(),
        functions: Vec::new(),
        start: srp_archdesc::entity::Entity::new(0),
        kernels: [scheduled.schedule].into_iter().collect(),
    };
    let refused = srp_ir::check::check_kernels(&program, &arch.srp);
    assert!(
        refused.iter().any(|v| v.message.contains("trip count")),
        "{refused:?}"
    );
}

#[test]
fn the_checker_follows_values_of_bare_graphs() {
    let arch = mesh(3, 3);
    let source = Source::new("recurrences.dot", RECURRENCES);
    let graph = read_dot(&source, &Options::default()).expect("a graph");
    let right = map(&graph, &arch).schedule;
    let mut noticed = 0;
    for (number, op) in right.ops.iter() {
        for later in [1, 2] {
            let mut wrong = right.clone();
            wrong.ops[number].time += later;
            wrong.length += later;
            noticed += u32::from(!check_loop(&wrong, &arch.srp).is_empty());
        }
        for operand in 1..op.operands.len() {
            let mut wrong = right.clone();
            wrong.ops[number].operands.swap(operand - 1, operand);
            let same = op.operands[operand - 1] == op.operands[operand];
            let found = check_loop(&wrong, &arch.srp);
            let nodes: Vec<_> = right.dfg.nodes[op.node].operands.clone();
            assert!(
                same || nodes[operand - 1] == nodes[operand] || !found.is_empty(),
                "{number}"
            );
        }
    }
    assert!(noticed > right.ops.len() as u32 / 2, "{noticed}");
}

/// IIs of `../shared/graphs/README.md` on a 4×4 mesh, for graphs of at most 40 nodes.
const REFERENCE: &[(&str, u32)] = &[
    ("morpher_sum", 1),
    ("morpher_mac", 1),
    ("morpher_matrixmultiply", 1),
    ("morpher_conv2", 2),
    ("morpher_accumulate", 2),
    ("morpher_mults1", 4),
    ("morpher_array_add", 4),
    ("morpher_conv3", 2),
    ("morpher_cap", 2),
    ("morpher_mults2", 2),
    ("morpher_mac2", 2),
    ("morpher_atax", 4),
    ("morpher_cholesky", 4),
    ("morpher_doitgen", 4),
    ("morpher_2mm", 4),
    ("morpher_bicg", 4),
    ("revamp_gemm", 4),
    ("revamp_spmv", 4),
    ("revamp_stencil", 4),
    ("revamp_ellpack", 4),
    ("morpher_finalSAD", 4),
    ("revamp_convolution2d", 4),
];

/// Where other mappers' graphs are on hosts that have them.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/graphs");

#[test]
fn graphs_of_other_mappers_reach_their_known_intervals() {
    let folder = Path::new(FOLDER);
    if !folder.is_dir() {
        println!("skipped: there is no {FOLDER}");
        return;
    }
    let arch = mesh(4, 4);
    let mut worse = Vec::new();
    for (name, known) in REFERENCE {
        let read = |ending: &str| {
            let path = folder.join(format!("{name}.{ending}"));
            let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path:?}: {e}"));
            Source::new(path.display().to_string(), text)
        };
        let graph = read_edges(&read("edges"), &read("ops"), &Options::default());
        let graph = graph.unwrap_or_else(|mistakes| panic!("{mistakes:?}"));
        let ii = map(&graph, &arch).schedule.ii;
        if ii > *known {
            worse.push(format!("{name}: II {ii}, {known} is known"));
        }
    }
    assert!(worse.is_empty(), "{}", worse.join("\n"));
}

/// A running sum over every n-th element: the value is taken so many iterations later.
fn apart(distance: u32) -> Graph {
    let text = format!(
        "digraph {{ x [op=load]; s [op=add]; y [op=store]; x -> s; s -> s [distance={distance}]; s -> y; }}"
    );
    read_dot(&Source::new("apart.dot", text), &Options::default()).expect("a graph")
}

#[test]
fn values_of_many_iterations_ago_go_from_file_to_file() {
    let arch = mesh(4, 4);
    for distance in [1, 8, 9, 20, 60] {
        let scheduled = map(&apart(distance), &arch);
        assert!(scheduled.schedule.ii <= 2, "{distance}");
    }
}

/// A consumer issues so far ahead of its producer that few instances of the value wait, but no iteration has more stages
/// than engines hold.
#[test]
fn consumers_run_ahead_as_far_as_stages_go() {
    let arch = mesh(4, 4);
    for distance in [20, 64, 66] {
        let text = format!("digraph {{ a [op=add]; b [op=add]; a -> b [distance={distance}]; }}");
        let options = Options::default();
        let graph = read_dot(&Source::new("ahead.dot", text), &options).expect("a graph");
        let scheduled = map(&graph, &arch);
        assert!(scheduled.schedule.ii <= 2, "{distance}");
        assert!(
            scheduled.schedule.stages() <= modulo::MAX_STAGES,
            "{distance}"
        );
    }
}

#[test]
fn more_values_than_places_are_refused_at_once() {
    let arch = mesh(4, 4);
    let graph = apart(1000);
    let options = modulo::Options::default();
    let refused = modulo::schedule(&graph.dfg, &arch.srp, &options, &Unwatched);
    let Err(Unschedulable::Storage { held, room }) = refused else {
        panic!("{refused:?}");
    };
    assert!(held > room && held == 999, "{held} {room}");
}

#[test]
fn without_expansion_a_kernel_takes_as_many_contexts_as_cycles() {
    let arch = mesh(4, 4);
    let alone = modulo::Options {
        expansion: false,
        ..modulo::Options::default()
    };
    for distance in [1, 2, 3] {
        let graph = apart(distance);
        // As it is found: a shorter schedule may have no value that lives so long.
        let found = modulo::Options {
            compaction: 0,
            ..modulo::Options::default()
        };
        let expanded = modulo::schedule(&graph.dfg, &arch.srp, &found, &Unwatched);
        let expanded = expanded.expect("there is one").schedule;
        let schedule = modulo::schedule(&graph.dfg, &arch.srp, &alone, &Unwatched);
        let schedule = schedule.expect("there is one").schedule;
        assert!(check_loop(&schedule, &arch.srp).is_empty(), "{distance}");
        assert_eq!(schedule.contexts(), schedule.ii, "{distance}");
        assert!(schedule.ii >= expanded.ii, "{distance}");
        assert!(
            distance == 1 || expanded.contexts() > expanded.ii,
            "{distance}"
        );
    }
}
