//! Maps large graphs onto standard meshes and prints a table: initiation intervals beside their bounds,
//! the length of schedules, and the seconds of CPU time they took.
//!
//! `cargo run --release -p srp-scheduler --example large_graphs -- ROWSxCOLS EFFORT ORDERS GRAPH...`,
//! where `GRAPH.edges` and `GRAPH.ops` are files and every graph is mapped with its lines in so many
//! orders.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::{Rng, SeedableRng};
use srp_archdesc::Unwatched;
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::Source;
use srp_archdesc::isa::Class;
use srp_archdesc::xml::{StandardArray, standard};
use srp_ir::check::check_loop;
use srp_ir::graph::{Graph, Options, read_edges};
use srp_scheduler::modulo;
use std::process::ExitCode;

/// Seconds of CPU time of this process, where the host tells.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    let user = after_name.split_whitespace().nth(11);
    user.and_then(|ticks| ticks.parse::<f64>().ok())
        .map_or(0.0, |ticks| ticks / 100.0)
}

/// A graph with its lines in one of many orders; order 0 is that of its files.
fn read(name: &str, order: u64) -> Result<Graph, String> {
    let source = |ending: &str| {
        let path = format!("{name}.{ending}");
        let text = std::fs::read_to_string(&path).map_err(|e| format!("{path}: {e}"))?;
        let mut lines: Vec<&str> = text.lines().collect();
        let mut random = Pcg32::seed_from_u64(order);
        for last in (1..lines.len()).rev().filter(|_| order > 0) {
            lines.swap(last, random.next_u32() as usize % (last + 1));
        }
        Ok::<_, String>(Source::new(path, lines.join("\n")))
    };
    let options = Options {
        any_op: Some(Class::Alu),
    };
    read_edges(&source("edges")?, &source("ops")?, &options).map_err(|e| format!("{name}: {e:?}"))
}

/// Maps a graph and prints its line.
fn map(name: &str, order: u64, graph: &Graph, arch: &Arch, options: &modulo::Options) -> bool {
    let nodes = graph.dfg.nodes.len();
    let short = name.rsplit('/').next().unwrap_or(name);
    let start = cpu_seconds();
    let result = modulo::schedule(&graph.dfg, &arch.srp, options, &Unwatched);
    let seconds = cpu_seconds() - start;
    match result {
        Ok(scheduled) => {
            let schedule = &scheduled.schedule;
            let moves = schedule.ops.values().filter(|op| op.is_move).count();
            let bound = scheduled.bounds.min_ii();
            println!(
                "{short:28} {order:5} {nodes:5} {bound:5} {:5} {:6} {moves:5} {seconds:8.2}",
                schedule.ii, schedule.length
            );
            let wrong = check_loop(schedule, &arch.srp);
            wrong.iter().for_each(|violation| println!("  {violation}"));
            wrong.is_empty()
        }
        Err(why) => {
            println!("{short:28} {order:5} {nodes:5} {why}");
            false
        }
    }
}

fn run(args: &[String]) -> Result<bool, String> {
    let usage = "ROWSxCOLS EFFORT ORDERS GRAPH...";
    let [size, effort, orders, graphs @ ..] = args else {
        return Err(usage.to_owned());
    };
    let number = |text: &str| text.parse::<u64>().map_err(|e| format!("{text}: {e}"));
    let (rows, cols) = size.split_once('x').ok_or(usage)?;
    let spec = StandardArray::mesh(number(rows)? as u32, number(cols)? as u32);
    let arch = srp_archdesc::parse("mesh.xml", &standard(&spec)?).map_err(|e| format!("{e:?}"))?;
    let options = modulo::Options {
        effort: number(effort)?,
        ..modulo::Options::default()
    };
    println!("graph                        order nodes bound    II length moves  seconds");
    let mut right = true;
    for name in graphs {
        for order in 0..number(orders)? {
            right &= map(name, order, &read(name, order)?, &arch, &options);
        }
    }
    Ok(right)
}

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match run(&args) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}
