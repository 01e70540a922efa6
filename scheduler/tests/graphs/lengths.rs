//! After the II: schedules are made shorter at that II or a smaller one, and are no shorter than their bound.
//!
//! A longer run: `SRP_LENGTH_GRAPHS=1000 cargo test --release -p srp-scheduler --test graphs lengths`, from the graph of
//! number `SRP_LENGTH_SEED` on.

use super::monotone::{Array, graph};
use super::{map, mesh};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::SeedableRng;
use srp_archdesc::Unwatched;
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::Source;
use srp_ir::check::check_loop;
use srp_ir::graph::{Graph, Options, read_dot};
use srp_scheduler::modulo::{self, Scheduled};

/// The schedule of a graph as it is found at its II, before it is made shorter; `None` where there is none.
fn as_found(graph: &Graph, arch: &Arch) -> Option<Scheduled> {
    let options = modulo::Options {
        compaction: 0,
        ..modulo::Options::default()
    };
    modulo::schedule(&graph.dfg, &arch.srp, &options, &Unwatched).ok()
}

/// Length and contexts of a schedule: what is made less, in this order.
fn worth(scheduled: &Scheduled) -> (u32, u32) {
    (scheduled.schedule.length, scheduled.schedule.contexts())
}

#[test]
fn schedules_are_shorter_and_no_shorter_than_their_bound() {
    let number = |name: &str| std::env::var(name).ok().and_then(|s| s.parse::<u64>().ok());
    let graphs = number("SRP_LENGTH_GRAPHS").unwrap_or(12);
    let first = number("SRP_LENGTH_SEED").unwrap_or(0);
    let (mut found, mut kept) = (0, 0);
    for seed in first..first + graphs {
        let mut random = Pcg32::seed_from_u64(seed);
        let (graph, array) = (graph(&mut random), Array::random(&mut random));
        let arch = array.arch();
        let Some(before) = as_found(&graph, &arch) else {
            continue;
        };
        let after = map(&graph, &arch);
        assert!(after.schedule.ii <= before.schedule.ii, "seed {seed}");
        if after.schedule.ii < before.schedule.ii {
            continue;
        }
        assert!(worth(&after) <= worth(&before), "seed {seed}");
        // Each bound holds for both, whatever schedule it was computed beside.
        let least = before.least_length.max(after.least_length);
        assert!(least <= after.schedule.length, "seed {seed}: {least}");
        found += before.schedule.length;
        kept += after.schedule.length;
    }
    assert!(kept < found, "{kept} of {found} cycles are left");
}

/// Four taps of a filter: each a product of what comes in, from an iteration earlier than the one before, and all of
/// them added up.
const FILTER: &str = "digraph {
    x [op=load]; y [op=store];
    node [op=mul]; p0; p1; p2; p3;
    node [op=add]; s1; s2; s3; a; b; c;
    a -> x; a -> a [distance=1]; b -> y; b -> b [distance=1]; c -> c [distance=1];
    x -> p0; x -> p1 [distance=1]; x -> p2 [distance=2]; x -> p3 [distance=3];
    p0 -> s1; p1 -> s1; p2 -> s2; p3 -> s2; s1 -> s3; s2 -> s3; s3 -> y;
}";

#[test]
fn a_filter_takes_its_critical_path() {
    let source = Source::new("filter.dot", FILTER);
    let graph = read_dot(&source, &Options::default()).expect("a graph");
    // Address, load, product, two sums and a store, one cycle each.
    let least = 6;
    for (rows, cols) in [(2, 3), (3, 3), (4, 4)] {
        let scheduled = map(&graph, &mesh(rows, cols));
        let wrong = check_loop(&scheduled.schedule, &mesh(rows, cols).srp);
        assert!(wrong.is_empty(), "{wrong:?}");
        let (length, bound) = (scheduled.schedule.length, scheduled.least_length);
        assert!(
            (least..=bound + 1).contains(&length),
            "{rows}x{cols}: {length}"
        );
    }
}
