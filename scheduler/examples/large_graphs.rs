//! Maps large graphs onto standard meshes and prints a table: initiation intervals beside their bounds,
//! the length of schedules, and the seconds of CPU time they took.
//!
//! `cargo run --release -p srp-scheduler --example large_graphs -- ROWSxCOLS EFFORT ORDERS GRAPH...`,
//! where `GRAPH.edges` and `GRAPH.ops` are files and every graph is mapped with its lines in so many
//! orders. `all FOLDER` in place of that prints one table after the other: the graphs of 80 operations and more in a
//! folder and the folders in it, on the array that their size is for, then a random graph on a wide array.

mod seconds;

use rand_pcg::Pcg32;
use rand_pcg::rand_core::{Rng, SeedableRng};
use seconds::cpu_seconds;
use srp_archdesc::Unwatched;
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::Source;
use srp_archdesc::isa::Class;
use srp_archdesc::xml::{StandardArray, standard};
use srp_ir::check::check_loop;
use srp_ir::graph::{Graph, Options, read_edges};
use srp_scheduler::modulo;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Operations from which a graph is mapped onto 4x4, and beyond which onto 8x8.
const MEDIUM: usize = 80;
const LARGE: usize = 150;
/// How far back the operands of a random graph lie at most.
const REACH: u32 = 15;

/// A list of edges with its operations, line by line.
struct Lists {
    name: String,
    edges: String,
    ops: String,
}

impl Lists {
    fn read(name: &str) -> Result<Lists, String> {
        let text = |ending: &str| {
            let path = format!("{name}.{ending}");
            std::fs::read_to_string(&path).map_err(|e| format!("{path}: {e}"))
        };
        Ok(Lists {
            edges: text("edges")?,
            ops: text("ops")?,
            name: name.to_owned(),
        })
    }

    /// A random graph, whose operands are among the last results.
    fn random(nodes: u32) -> Lists {
        let mut random = Pcg32::seed_from_u64(nodes.into());
        let mut below = |n: u32| random.next_u32() % n;
        let (mut edges, mut ops) = (String::new(), String::new());
        for node in 0..nodes {
            let name = ["add", "sub", "mul", "xor", "and"][below(5) as usize];
            ops += &format!("{node} {name}\n");
            let operands = if below(10) < 7 { 2 } else { 1 };
            let operands = (0..operands).filter(|_| node > 0);
            for operand in operands.map(|_| node - 1 - below(node.min(REACH))) {
                edges += &format!("{operand} {node} 0\n");
            }
        }
        Lists {
            name: format!("random{nodes}"),
            edges,
            ops,
        }
    }

    /// The graph with its lines in one of many orders; order 0 is that of its files.
    fn graph(&self, order: u64) -> Result<Graph, String> {
        let source = |text: &str, ending: &str| {
            let mut lines: Vec<&str> = text.lines().collect();
            let mut random = Pcg32::seed_from_u64(order);
            for last in (1..lines.len()).rev().filter(|_| order > 0) {
                lines.swap(last, random.next_u32() as usize % (last + 1));
            }
            Source::new(format!("{}.{ending}", self.name), lines.join("\n"))
        };
        let options = Options {
            any_op: Some(Class::Alu),
        };
        let (edges, ops) = (source(&self.edges, "edges"), source(&self.ops, "ops"));
        read_edges(&edges, &ops, &options).map_err(|e| format!("{}: {e:?}", self.name))
    }
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

/// Maps each graph in so many orders onto a mesh; true if every schedule is right.
fn table(
    (rows, cols): (u32, u32),
    effort: u64,
    orders: u64,
    graphs: &[Lists],
) -> Result<bool, String> {
    let spec = StandardArray::mesh(rows, cols);
    let arch = srp_archdesc::parse("mesh.xml", &standard(&spec)?).map_err(|e| format!("{e:?}"))?;
    let options = modulo::Options {
        effort,
        ..modulo::Options::default()
    };
    println!("{rows}x{cols}");
    println!("graph                        order nodes bound    II length moves  seconds");
    let mut right = true;
    for lists in graphs {
        for order in 0..orders {
            right &= map(&lists.name, order, &lists.graph(order)?, &arch, &options);
        }
    }
    Ok(right)
}

/// The graphs of a folder and the folders in it, in order of their names.
fn graphs(folder: &Path) -> Result<Vec<Lists>, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    let mut found = Vec::new();
    for path in paths {
        if path.is_dir() {
            found.extend(graphs(&path)?);
        } else if path.extension().is_some_and(|ending| ending == "edges") {
            found.push(Lists::read(&path.with_extension("").to_string_lossy())?);
        }
    }
    Ok(found)
}

/// Prints the tables of all sizes.
fn all(folder: &Path) -> Result<bool, String> {
    let effort = modulo::Options::default().effort;
    let size = |lists: &Lists| lists.ops.lines().count();
    let (large, rest): (Vec<Lists>, Vec<Lists>) = graphs(folder)?
        .into_iter()
        .partition(|lists| size(lists) > LARGE);
    let medium = rest.into_iter().filter(|lists| size(lists) >= MEDIUM);
    let medium: Vec<Lists> = medium.collect();
    let (large, small) = (
        table((8, 8), effort, 5, &large)?,
        table((4, 4), effort, 1, &medium)?,
    );
    Ok(large && small && table((16, 16), effort, 1, &[Lists::random(500)])?)
}

fn run(args: &[String]) -> Result<bool, String> {
    let usage = "ROWSxCOLS EFFORT ORDERS GRAPH... | all FOLDER";
    if let [which, folder] = args
        && which == "all"
    {
        return all(Path::new(folder));
    }
    let [size, effort, orders, graphs @ ..] = args else {
        return Err(usage.to_owned());
    };
    let number = |text: &str| text.parse::<u64>().map_err(|e| format!("{text}: {e}"));
    let (rows, cols) = size.split_once('x').ok_or(usage)?;
    let graphs = graphs.iter().map(|name| Lists::read(name));
    let graphs = graphs.collect::<Result<Vec<Lists>, String>>()?;
    let size = (number(rows)? as u32, number(cols)? as u32);
    table(size, number(effort)?, number(orders)?, &graphs)
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
