//! Bare dataflow graphs on an array: the II of each, its bounds, and the obstacles to a lower one.

use crate::bases::Bases;
use crate::loops::{Change, WhatIf};
use crate::proofs::{Impossible, Search};
use schemars::JsonSchema;
use serde::Serialize;
use srp_archdesc::arch::{Arch, Srp};
use srp_archdesc::entity::{Entity, EntityMap};
use srp_archdesc::threads;
use srp_archdesc::watch::{Limited, Stage, Watch};
use srp_ir::check;
use srp_ir::dfg::{Dfg, Node};
use srp_ir::dre::scheduled::{ModuloSchedule, ScheduledLoops};
use srp_ir::graph::Graph;
use srp_ir::program::{Pos, SourceFile};
use srp_scheduler::modulo::{Obstacle, Operation, Unschedulable};
use srp_scheduler::usage::{Share, usage};
use srp_scheduler::what_if;
use srp_scheduler::{LoopResult, modulo};
use srp_toolchain::envelope::Contents;
use srp_toolchain::{Effort, Session};
use std::time::Duration;

/// How graphs are mapped.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options<'a> {
    /// How long schedules are looked for.
    pub search: Effort,
    /// The time of the watch after which the search for a graph ends with the best schedule so far.
    pub timeout: Option<Duration>,
    /// Map without modulo variable expansion, and tell beside it what that gives.
    pub no_expansion: bool,
    /// Try small changes of the machine, and say which lower the II of each graph.
    pub what_if: bool,
    /// The text of the machine's file: changes are told as settings of it.
    pub machine: &'a str,
}

/// Results of mapping graphs on a machine.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Table {
    /// The machine's name, which the envelope of a document has.
    #[serde(skip)]
    pub machine: String,
    /// The graphs, in the order in which they were given.
    pub graphs: Vec<Row>,
}

impl Contents for Table {
    const FORMAT: &'static str = "srp-map";
    const VERSION: u32 = 1;
    const WRITTEN_BY: &'static str = "`srp map --json`";
}

/// A graph of the table.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Row {
    /// Its name.
    pub graph: String,
    /// Its file.
    pub file: String,
    /// Operations.
    pub nodes: usize,
    /// Values and orders between them.
    pub edges: usize,
    /// Seconds that it took on this host.
    pub seconds: f64,
    /// True if the search was cut short by the time-out.
    pub timed_out: bool,
    /// The mapping, if there is one.
    pub mapping: Option<Mapping>,
    /// What modulo variable expansion gives, where `mapping` does without.
    pub expanded: Option<Mapping>,
    /// Changes of the machine that lower the II, if they were asked for.
    pub what_if: Option<WhatIf>,
    /// Why there is none.
    pub error: Option<String>,
    /// Facts that do not stand in the way.
    pub notes: Vec<String>,
}

/// A graph on the array.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Mapping {
    /// Initiation interval, cycles.
    pub ii: u32,
    /// Bound set by units and shared resources.
    pub res_mii: u32,
    /// The resource that sets it.
    pub res_mii_why: String,
    /// Bound set by recurrences.
    pub rec_mii: u32,
    /// The nodes of the recurrence that sets it, in order.
    pub recurrence: Vec<String>,
    /// Why the II below was not reached; `None` where the II is the bound.
    pub why_not_lower: Option<String>,
    /// The parts of the machine of which the loop takes all, or the fullest one where there are none.
    pub fullest: Vec<Fullest>,
    /// IIs that were proved impossible.
    pub impossible: Vec<Impossible>,
    /// What the exact search tried, and why it ended.
    pub search: Search,
    /// Contexts of the configuration memory: the II times the copies that modulo variable expansion makes of
    /// the kernel, where values live longer than the II in files that do not rotate.
    pub contexts: u32,
    /// Iterations that overlap.
    pub stages: u32,
    /// Cycles of one iteration.
    pub length: u32,
    /// Fewest cycles of an iteration at this II: no schedule is shorter.
    pub least_length: u32,
    /// Routing moves of an iteration.
    pub moves: usize,
}

/// A part of the machine, and what a loop takes of it.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Fullest {
    /// The part: a shared resource, ports or registers of a file, a unit, a link or a wire.
    pub part: String,
    /// Taken of it: of registers in the cycle with the most, else in the cycles of an II together.
    pub used: u32,
    /// All of it.
    pub of: u32,
}

/// The outcome of mapping a graph.
pub struct Outcome {
    /// Its row of the table.
    pub row: Row,
    /// The graph and what the scheduler found, if it has a schedule.
    pub mapped: Option<(Graph, modulo::Scheduled)>,
}

impl Outcome {
    /// A graph, known by `name`, that could not be read from `file`.
    pub fn unread(name: String, file: String, error: String) -> Outcome {
        let row = Row {
            graph: name,
            file,
            nodes: 0,
            edges: 0,
            seconds: 0.0,
            timed_out: false,
            mapping: None,
            expanded: None,
            what_if: None,
            error: Some(error),
            notes: Vec::new(),
        };
        Outcome { row, mapped: None }
    }
}

/// Maps so many graphs, each by its number, on the threads of the session. Those that are not begun
/// when the watch ends the work are left out.
pub fn map_all(
    count: usize,
    one: impl Fn(usize) -> Outcome + Sync,
    session: &Session<'_>,
) -> Vec<Outcome> {
    let stage = Stage::of(session.watch, "mapping", count as u64);
    let map = |(): &mut (), index: usize| {
        if session.watch.cancelled() {
            return None;
        }
        let outcome = one(index);
        stage.done(1);
        Some(outcome)
    };
    let outcomes = threads::some(session.threads, count, || (), map);
    outcomes.into_iter().flatten().collect()
}

/// How many times the effort of a loop of a program a graph gets, by its nodes: who maps a graph waits for a
/// good schedule of it, not for an answer to an edit.
const EFFORT: u64 = 6;
const LARGE: usize = 80;
const LARGE_EFFORT: u64 = 16;
const VAST: usize = 1024;
const VAST_EFFORT: u64 = 2;
/// The same of the search for a shorter schedule.
const COMPACTION: u64 = 4;

/// Maps a graph of a file onto the array of a machine.
pub fn map(
    graph: Graph,
    file: String,
    arch: &Arch,
    options: &Options<'_>,
    session: &Session<'_>,
) -> Outcome {
    let start = session.watch.elapsed();
    let limit = options.timeout.unwrap_or(Duration::MAX);
    let of_loop = options.search.modulo();
    let times = match graph.dfg.nodes.len() {
        _ if modulo::is_on_lattice(&graph.dfg, &arch.srp) => 1,
        0..LARGE => EFFORT,
        LARGE..VAST => LARGE_EFFORT,
        _ => VAST_EFFORT,
    };
    let search = |expansion: bool, watch: &dyn Watch| {
        let options = modulo::Options {
            effort: of_loop.effort.saturating_mul(times),
            compaction: of_loop.compaction.saturating_mul(COMPACTION),
            expansion,
            ..of_loop
        };
        let result = modulo::schedule(&graph.dfg, &arch.srp, &options, watch);
        checked(result, &graph, arch)
    };
    let watch = Limited::new(session.watch, limit);
    let result = search(!options.no_expansion, &watch);
    let (seconds, timed_out) = (session.watch.elapsed() - start, watch.cancelled());
    let expanded = options.no_expansion.then(|| {
        let watch = Limited::new(session.watch, limit);
        search(true, &watch)
            .ok()
            .map(|scheduled| mapping(&graph, &scheduled, arch))
    });
    // Nothing can be told of changes where no search has made a schedule.
    let is_searched = match &result {
        Ok(scheduled) => !is_cut_short(scheduled),
        Err(_) => !timed_out,
    };
    let what_if = (options.what_if && is_searched).then(|| {
        let watch = Limited::new(session.watch, limit);
        let ii = result.as_ref().map_or(u32::MAX, |s| s.schedule.ii);
        changes(&graph.dfg, ii, options, arch, (session.threads, &watch))
    });
    let mut row = Row {
        graph: graph.dfg.name.clone(),
        file,
        nodes: graph.dfg.nodes.len(),
        edges: graph.dfg.deps().count(),
        seconds: seconds.as_secs_f64(),
        timed_out,
        mapping: None,
        expanded: expanded.flatten(),
        what_if,
        error: None,
        notes: notes(&graph, arch),
    };
    if options.what_if && !is_searched {
        row.notes.push(
            "no change of the machine was tried: the search was cut short before there was a \
             schedule to hold against"
                .to_owned(),
        );
    }
    let mapped = match result {
        Ok(scheduled) => {
            row.mapping = Some(mapping(&graph, &scheduled, arch));
            Some((graph, scheduled))
        }
        Err(why) => {
            row.error = Some(why);
            None
        }
    };
    Outcome { row, mapped }
}

/// Changes of the machine that lower an II.
fn changes(
    dfg: &Dfg,
    ii: u32,
    options: &Options<'_>,
    arch: &Arch,
    (threads, watch): (usize, &dyn Watch),
) -> WhatIf {
    let search = modulo::Options {
        expansion: !options.no_expansion,
        ..modulo::Options::default()
    };
    let bases = Bases::of(arch, Some(options.machine));
    let found = bases.try_changes(dfg, ii, &search, (threads, watch));
    let change = |change: what_if::Change| {
        let ii = change.ii;
        Change::of(&change.into(), ii, &bases)
    };
    WhatIf {
        tried: found.tried,
        changes: found.changes.into_iter().map(change).collect(),
    }
}

/// True if the search was ended before it had a schedule, and this is the one in sequence.
fn is_cut_short(scheduled: &modulo::Scheduled) -> bool {
    let why = scheduled.why_not_lower.as_ref();
    why.is_some_and(|failed| failed.obstacle == Obstacle::CutShort)
}

/// The name of a node in messages: that of the graph's file.
fn name(graph: &Graph, operation: &Operation) -> String {
    format!("`{}`", graph.names[operation.node])
}

/// Why a graph has no schedule; a node that no unit runs is shown with its place.
fn refused(graph: &Graph, why: &Unschedulable) -> String {
    let words = why.words(&|operation| name(graph, operation));
    let Some(node) = why.node() else {
        return words;
    };
    let (name, pos) = (&graph.names[node], graph.dfg.nodes[node].pos);
    match graph.files.get(pos.file).filter(|_| pos.line > 0) {
        Some(file) => format!("{file}:{}: node `{name}`: {words}", pos.line),
        None => format!("node `{name}`: {words}"),
    }
}

/// A schedule that the independent checker has found right.
fn checked(result: LoopResult, graph: &Graph, arch: &Arch) -> Result<modulo::Scheduled, String> {
    let scheduled = result.map_err(|why| refused(graph, &why))?;
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

/// The parts that a schedule takes most of.
fn fullest(schedule: &ModuloSchedule, srp: &Srp) -> Vec<Fullest> {
    let shares = usage(schedule, srp).fullest(srp, schedule.ii);
    let fullest = |share: Share| Fullest {
        part: share.part.in_words(srp),
        used: share.used,
        of: share.of,
    };
    shares.into_iter().map(fullest).collect()
}

fn mapping(graph: &Graph, scheduled: &modulo::Scheduled, arch: &Arch) -> Mapping {
    let modulo::Scheduled {
        schedule,
        bounds,
        why_not_lower,
        impossible,
        search,
        least_length,
    } = scheduled;
    Mapping {
        ii: schedule.ii,
        res_mii: bounds.resources,
        res_mii_why: bounds.resources_why.clone(),
        rec_mii: bounds.recurrences,
        recurrence: (bounds.critical_cycle.iter())
            .map(|&node| graph.names[node].clone())
            .collect(),
        why_not_lower: why_not_lower
            .as_ref()
            .map(|failed| failed.words(&|operation| name(graph, operation))),
        fullest: fullest(schedule, &arch.srp),
        impossible: impossible.iter().map(Impossible::of).collect(),
        search: Search::of(search),
        contexts: schedule.contexts(),
        stages: schedule.stages(),
        length: schedule.length,
        least_length: *least_length,
        moves: schedule.ops.values().filter(|op| op.is_move).count(),
    }
}

/// Returns statements of the graph's file that differ from the machine's.
fn notes(graph: &Graph, arch: &Arch) -> Vec<String> {
    let differs = |&&(node, latency): &&(_, u32)| {
        let op = graph.dfg.nodes[node].op;
        let mut ways = arch.srp.fus.values().filter_map(|fu| fu.timing(op));
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

/// The schedules of all graphs that have one, as they go into one file.
pub fn schedules(outcomes: &[Outcome], arch: &Arch) -> ScheduledLoops {
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
