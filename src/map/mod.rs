//! `srp map`: bare dataflow graphs onto an array, one after another, and the table of what they
//! reach.

mod input;
mod text;

use crate::cli::map::{Map, Target};
use crate::failure::Failure;
use crate::proof::{self, Proved};
use crate::talk::CONSOLE;
use crate::talk::{self, Progress};
use crate::{files, interrupt, machine};
use input::Found;
use serde::Serialize;
use srp_archdesc::arch::Arch;
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::watch::{Limited, Watch};
use srp_ir::dfg::{Dfg, Node};
use srp_ir::dre;
use srp_ir::dre::scheduled::ScheduledLoops;
use srp_ir::graph::{self, Graph};
use srp_ir::program::{Pos, SourceFile};
use srp_scheduler::{check, modulo};

use srp_archdesc::threads;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Nodes of a graph that is given more effort than a loop of a program, and how many times as much; twice
/// that from so many nodes on.
const LARGE: usize = 80;
const LARGE_EFFORT: u64 = 4;
const LARGEST: usize = 256;

/// What graphs reach on a machine.
#[derive(Serialize)]
pub(crate) struct Table {
    /// The machine's name.
    pub(crate) machine: String,
    /// The graphs, in the order of the command line, those of a folder by name.
    pub(crate) graphs: Vec<Row>,
}

/// A graph of the table.
#[derive(Serialize)]
pub(crate) struct Row {
    /// Its name.
    pub(crate) graph: String,
    /// Its file.
    pub(crate) file: String,
    /// Operations.
    pub(crate) nodes: usize,
    /// Values and orders between them.
    pub(crate) edges: usize,
    /// Seconds that it took on this host.
    pub(crate) seconds: f64,
    /// Whether the search was cut short by the time-out.
    pub(crate) timed_out: bool,
    /// The mapping, if there is one.
    pub(crate) mapping: Option<Mapping>,
    /// Why there is none.
    pub(crate) error: Option<String>,
    /// Facts that do not stand in the way.
    pub(crate) notes: Vec<String>,
}

/// A graph on the array.
#[derive(Serialize)]
pub(crate) struct Mapping {
    /// Initiation interval, cycles.
    pub(crate) ii: u32,
    /// Bound set by units and shared resources.
    pub(crate) res_mii: u32,
    /// What sets it.
    pub(crate) res_mii_why: String,
    /// Bound set by recurrences.
    pub(crate) rec_mii: u32,
    /// The nodes of the recurrence that sets it, in order.
    pub(crate) recurrence: Vec<String>,
    /// Why the II below was not reached; `None` where the II is the bound.
    pub(crate) why_not_lower: Option<String>,
    /// IIs that were proved impossible.
    pub(crate) impossible: Vec<Impossible>,
    /// Iterations that overlap.
    pub(crate) stages: u32,
    /// Cycles of one iteration.
    pub(crate) length: u32,
    /// Routing moves of an iteration.
    pub(crate) moves: usize,
}

/// A proof that an II cannot be kept.
#[derive(Serialize)]
pub(crate) struct Impossible {
    /// The II.
    pub(crate) ii: u32,
    /// Cycles beyond the critical path that iterations may take at most for the proof to hold.
    pub(crate) slack: u32,
}

/// Runs `srp map`; 1 where a graph was not mapped.
pub(crate) fn run(args: &Map) -> Result<i32, Failure> {
    if let Some(path) = &args.output {
        files::check_writable(path)?;
    }
    let arch = target(&args.machine)?;
    let inputs = input::find(&args.graphs, args.ops.as_deref())?;
    let options = graph::Options {
        any_op: args.any_op,
    };
    if let Some(class) = args
        .any_op
        .filter(|&class| graph::stands_for(class).is_none())
    {
        let message = format!("--any-op {class}: no unit of an array runs this class in a loop");
        return Err(Failure::Message(message));
    }
    let results = map_all(&inputs, &options, args, &arch);
    let complete = results.len() == inputs.len();
    let failed = results.iter().any(|r| r.row.mapping.is_none());
    if let Some(path) = &args.output
        && !failed
        && complete
    {
        let loops = together(&arch, &results);
        files::write(path, dre::write_loops(&loops, &arch).as_bytes())?;
    }
    if let Some(path) = &args.proof {
        let mapped = results.iter().filter_map(|r| r.mapped.as_ref());
        let proved: Vec<Proved<'_>> = mapped
            .map(|(graph, scheduled)| Proved {
                dfg: &graph.dfg,
                ii: scheduled.schedule.ii,
                impossible: &scheduled.impossible,
            })
            .collect();
        proof::write(path, &proved, &arch)?;
    }
    let table = Table {
        machine: arch.name.clone(),
        graphs: results.into_iter().map(|r| r.row).collect(),
    };
    if args.json {
        let json = serde_json::to_string_pretty(&table).map_err(Failure::message)?;
        talk::print(json + "\n")?;
    } else {
        talk::print(text::table(&table))?;
    }
    if interrupt::requested() {
        return Err(Failure::Interrupted);
    }
    Ok(i32::from(failed))
}

fn target(target: &Target) -> Result<Arch, Failure> {
    match (&target.machine, target.mesh) {
        (Some(path), _) => Ok(srp_toolchain::machine::read(path)?),
        (None, Some((rows, cols))) => machine::standard_mesh(rows, cols),
        (None, None) => Err(Failure::Message("--machine or --mesh is needed".to_owned())),
    }
}

/// What became of a graph.
struct Outcome {
    row: Row,
    /// The graph and what the scheduler found, if it has a schedule.
    mapped: Option<(Graph, modulo::Scheduled)>,
}

/// Maps all graphs, on as many threads as the host has; as far as Ctrl-C lets it.
fn map_all(inputs: &[Found], options: &graph::Options, args: &Map, arch: &Arch) -> Vec<Outcome> {
    let progress = Progress::steps("mapping", inputs.len() as u64);
    let done = AtomicUsize::new(0);
    let map = |(): &mut (), index: usize| {
        if interrupt::requested() {
            return None;
        }
        let outcome = map_one(&inputs[index], options, args, arch);
        progress.at(done.fetch_add(1, Ordering::Relaxed) as u64 + 1);
        Some(outcome)
    };
    let host = std::thread::available_parallelism().map_or(1, usize::from);
    let outcomes = threads::some(host, inputs.len(), || (), map);
    outcomes.into_iter().flatten().collect()
}

fn map_one(found: &Found, options: &graph::Options, args: &Map, arch: &Arch) -> Outcome {
    let mut row = Row {
        graph: found.name(),
        file: found.path.display().to_string(),
        nodes: 0,
        edges: 0,
        seconds: 0.0,
        timed_out: false,
        mapping: None,
        error: None,
        notes: Vec::new(),
    };
    let graph = match found.read(options) {
        Ok(graph) => graph,
        Err(message) => {
            row.error = Some(message);
            return Outcome { row, mapped: None };
        }
    };
    row.graph = graph.dfg.name.clone();
    (row.nodes, row.edges) = (graph.dfg.nodes.len(), graph.dfg.deps().count());
    row.notes = notes(&graph, arch);
    let start = Instant::now();
    let limit = args.timeout.map_or(Duration::MAX, Duration::from_secs_f64);
    let watch = Limited::new(&CONSOLE, limit);
    let options = args.search.effort().modulo();
    let usual = match graph.dfg.nodes.len() {
        0..LARGE => options.effort,
        LARGE..LARGEST => LARGE_EFFORT * options.effort,
        _ => 2 * LARGE_EFFORT * options.effort,
    };
    let options = modulo::Options {
        effort: args.effort.unwrap_or(usual),
        ..options
    };
    let result = modulo::schedule(&graph.dfg, &arch.srp, &options, &watch);
    row.seconds = start.elapsed().as_secs_f64();
    row.timed_out = watch.cancelled();
    let mapped = match checked(result, arch) {
        Ok(scheduled) => {
            row.mapping = Some(mapping(&graph, &scheduled));
            Some((graph, scheduled))
        }
        Err(why) => {
            row.error = Some(why);
            None
        }
    };
    Outcome { row, mapped }
}

/// A schedule that the independent checker has found right.
fn checked(
    result: Result<modulo::Scheduled, modulo::Unschedulable>,
    arch: &Arch,
) -> Result<modulo::Scheduled, String> {
    let scheduled = result.map_err(|e| e.why)?;
    let wrong = check::check_loop(&scheduled.schedule, &arch.srp);
    match wrong.first() {
        None => Ok(scheduled),
        Some(first) => {
            let more = wrong.len();
            Err(format!(
                "the schedule is wrong, a mistake of the scheduler ({more} in all): {first}"
            ))
        }
    }
}

fn mapping(graph: &Graph, scheduled: &modulo::Scheduled) -> Mapping {
    let modulo::Scheduled {
        schedule,
        bounds,
        obstacle,
        impossible,
    } = scheduled;
    Mapping {
        ii: schedule.ii,
        res_mii: bounds.resources,
        res_mii_why: bounds.resources_why.clone(),
        rec_mii: bounds.recurrences,
        recurrence: (bounds.critical_cycle.iter())
            .map(|&node| graph.names[node].clone())
            .collect(),
        why_not_lower: obstacle.clone(),
        impossible: (impossible.iter())
            .map(|proof| Impossible {
                ii: proof.ii,
                slack: proof.slack,
            })
            .collect(),
        stages: schedule.stages(),
        length: schedule.length,
        moves: schedule.ops.values().filter(|op| op.is_move).count(),
    }
}

/// What the graph's file says that the machine's does not.
fn notes(graph: &Graph, arch: &Arch) -> Vec<String> {
    let differs = |&&(node, latency): &&(_, u32)| {
        let class = graph.dfg.nodes[node].op.class();
        let mut ways = arch.srp.fus.values().filter_map(|fu| fu.op(class));
        !ways.any(|way| way.latency == latency)
    };
    let mut notes = Vec::new();
    let others = graph.latencies.iter().filter(differs).count();
    if others > 0 {
        notes.push(format!(
            "{others} operations have another latency on this machine than in the graph; the machine's holds"
        ));
    }
    let name = |node: &Node| graph.names[*node].as_str();
    let carried: Vec<&str> = graph.carried.iter().map(name).collect();
    if !carried.is_empty() {
        let names = carried.join(", ");
        notes.push(format!(
            "edges from a node to itself have no distance, which is taken to be 1: {names}"
        ));
    }
    notes
}

/// All schedules in one file.
fn together(arch: &Arch, outcomes: &[Outcome]) -> ScheduledLoops {
    let mut all = ScheduledLoops {
        machine: arch.name.clone(),
        files: EntityMap::new(),
        loops: Vec::new(),
    };
    for (graph, scheduled) in outcomes.iter().filter_map(|o| o.mapped.as_ref()) {
        let schedule = &scheduled.schedule;
        let first = all.files.len();
        for file in graph.files.values() {
            all.files.push(file.clone());
        }
        let mut schedule = schedule.clone();
        shift(&mut schedule.dfg, first);
        all.loops.push(schedule);
    }
    all
}

/// Makes positions name the files from number `first` on.
fn shift(dfg: &mut Dfg, first: usize) {
    let shifted = |pos: &mut Pos| {
        if *pos != Pos::nowhere() {
            pos.file = SourceFile::new(pos.file.index() + first);
        }
    };
    shifted(&mut dfg.pos);
    dfg.live_ins.iter_mut().for_each(|l| shifted(&mut l.pos));
    for node in dfg.nodes.keys().collect::<Vec<_>>() {
        shifted(&mut dfg.nodes[node].pos);
    }
}
