//! The order of a graph's lines decides nothing of weight: a graph has a schedule on every array in every
//! order, and its II is within 1 of that of the best order.
//!
//! A longer run: `SRP_ORDERS=20 cargo test --release -p srp-scheduler --test graphs orders`, with so many
//! orders of every small graph on every array from 2 to 12 rows and columns; with `SRP_ORDERS_SECONDS`, on arrays drawn at
//! random until the time is over.

use super::{FOLDER, mesh};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::{Rng, SeedableRng};
use srp_archdesc::Unwatched;
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::Source;
use srp_ir::check::check_loop;
use srp_ir::graph::{Graph, Options, read_edges};
use srp_scheduler::modulo;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Bytes of the edges of a graph that is small enough for this test: some 30 nodes.
const SMALL: usize = 400;

fn shuffle<T>(items: &mut [T], random: &mut Pcg32) {
    for last in (1..items.len()).rev() {
        items.swap(last, random.next_u32() as usize % (last + 1));
    }
}

/// A graph with the lines of its files in one of many orders.
fn shuffled(path: &Path, order: u64) -> Graph {
    let source = |ending: &str| {
        let path = path.with_extension(ending);
        let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path:?}: {e}"));
        let mut lines: Vec<&str> = text.lines().collect();
        shuffle(&mut lines, &mut Pcg32::seed_from_u64(order));
        Source::new(path.display().to_string(), lines.join("\n"))
    };
    read_edges(&source("edges"), &source("ops"), &Options::default())
        .unwrap_or_else(|mistakes| panic!("{path:?}: {mistakes:?}"))
}

/// The II of a graph on an array, or why it has none.
fn ii(graph: &Graph, arch: &Arch) -> Result<u32, String> {
    let options = modulo::Options {
        compaction: 0,
        ..modulo::Options::default()
    };
    let scheduled = modulo::schedule(&graph.dfg, &arch.srp, &options, &Unwatched);
    let schedule = scheduled.map_err(|refused| refused.to_string())?.schedule;
    let wrong = check_loop(&schedule, &arch.srp);
    match wrong.is_empty() {
        true => Ok(schedule.ii),
        false => Err(format!("{wrong:?}")),
    }
}

/// The small graphs of the folder, in order.
fn small_graphs(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("the folder can be read");
    let paths = entries.map(|entry| entry.expect("an entry can be read").path());
    let is_small = |path: &PathBuf| {
        path.extension().is_some_and(|ending| ending == "edges")
            && std::fs::metadata(path).is_ok_and(|file| file.len() < SMALL as u64)
    };
    let mut graphs: Vec<PathBuf> = paths.filter(is_small).collect();
    graphs.sort();
    graphs
}

#[test]
fn orders_of_lines_make_no_difference() {
    let folder = Path::new(FOLDER);
    if !folder.is_dir() {
        println!("skipped: there is no {FOLDER}");
        return;
    }
    let number = |name: &str| -> Option<u64> { std::env::var(name).ok()?.parse().ok() };
    let asked = number("SRP_ORDERS");
    let sizes: Vec<(u32, u32)> = match asked {
        None => vec![(5, 6), (6, 6), (2, 7)],
        Some(_) => (2..=12)
            .flat_map(|r| (2..=12).map(move |c| (r, c)))
            .collect(),
    };
    let step = if asked.is_some() { 1 } else { 5 };
    let graphs = small_graphs(folder);
    let of_size = |&size| graphs.iter().step_by(step).map(move |path| (path, size));
    let mut all: Vec<(&PathBuf, (u32, u32))> = sizes.iter().flat_map(of_size).collect();
    let end = number("SRP_ORDERS_SECONDS").map(|seconds| {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        let seed = since.map_or(0, |since| since.as_secs());
        println!("arrays drawn with seed {seed}");
        shuffle(&mut all, &mut Pcg32::seed_from_u64(seed));
        Instant::now() + Duration::from_secs(seconds)
    });
    let (mut faults, mut tried) = (Vec::new(), 0);
    for (path, (rows, cols)) in all {
        if end.is_some_and(|end| Instant::now() > end) {
            break;
        }
        let arch = mesh(rows, cols);
        let orders = 0..asked.unwrap_or(3);
        let results: Vec<_> = orders
            .map(|order| ii(&shuffled(path, order), &arch))
            .collect();
        tried += results.len();
        let best = results.iter().flatten().min().copied();
        for (order, result) in results.iter().enumerate() {
            if !matches!((result, best), (Ok(ii), Some(best)) if *ii <= best + 1) {
                let name = path.display();
                faults.push(format!(
                    "{name} on {rows}x{cols}, order {order}: {result:?}"
                ));
            }
        }
    }
    println!("{tried} graphs were scheduled");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
