//! [`Report`]: what is said of every loop. Text, JSON and page show this and nothing else;
//! `docs/report.md` is the reference of its members. Reports are read back from JSON.

use super::changes::{Advice, WhatIf};
use crate::Error;
use crate::proofs::{Impossible, Search};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use srp_archdesc::diagnostic::Source;
use srp_toolchain::envelope::{self, Contents, Expected, Named};
use srp_toolchain::json;
use std::time::Duration;

/// The report of a program on a machine.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct Report {
    /// The machine, which the envelope of a document has.
    #[serde(skip, default = "no_machine")]
    pub machine: Named,
    /// The machine's array.
    pub array: ArrayShape,
    /// True if the search for schedules went its whole way; not where it was interrupted.
    pub complete: bool,
    /// Loops on the array, in program order.
    pub loops: Vec<LoopReport>,
    /// Loops that were to run on the array and do not.
    pub not_pipelined: Vec<NotPipelined>,
    /// Functions on the VLIW engine, in program order.
    #[serde(default)]
    pub functions: Vec<FunctionReport>,
    /// Changes that lower the II of several loops or of one, the most helpful first; empty unless changes
    /// were tried.
    pub advice: Vec<Advice>,
    /// How long each stage of the compilation took on this host, if that was asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stages: Vec<StageTime>,
}

impl Contents for Report {
    const FORMAT: &'static str = "srp-report";
    const VERSION: u32 = 2;
    const WRITTEN_BY: &'static str = "`srp report --json` and `--loops FILE.json`";
}

/// The machine of a report that does not name any.
fn no_machine() -> Named {
    Named {
        name: "unknown".to_owned(),
        hash: String::new(),
    }
}

/// How long a stage took.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct StageTime {
    /// Its name.
    pub stage: String,
    /// Seconds of this host.
    pub seconds: f64,
}

impl StageTime {
    pub(super) fn of(stage: &str, time: Duration) -> StageTime {
        StageTime {
            stage: stage.to_owned(),
            seconds: time.as_secs_f64(),
        }
    }
}

impl Report {
    /// Reads a report from JSON.
    ///
    /// # Errors
    ///
    /// The text is no JSON, or not that of a report of this version: with the place.
    pub fn read(source: &Source) -> Result<Report, Error> {
        let head = envelope::read(source, &[Expected::of::<Report>()])?;
        let report: Report = json::read(source)?;
        let machine = head.machine.unwrap_or_else(no_machine);
        Ok(Report { machine, ..report })
    }

    /// Leaves out everything but the loops of one name.
    pub(super) fn keep_only(&mut self, kernel: &str, others: &[String]) -> Result<(), Error> {
        let names = self.loops.iter().map(|l| l.kernel.clone());
        let names: Vec<String> = (names.chain(others.iter().cloned()))
            .chain(self.not_pipelined.iter().map(|n| n.kernel.clone()))
            .collect();
        self.loops.retain(|l| l.kernel == kernel);
        self.not_pipelined.retain(|n| n.kernel == kernel);
        self.functions.clear();
        if self.loops.is_empty() && self.not_pipelined.is_empty() {
            let names = names.join(", ");
            return Err(Error::Invalid(format!(
                "no kernel is named {kernel}; there are {names}"
            )));
        }
        Ok(())
    }
}

/// The control code of a function.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct FunctionReport {
    /// Its name.
    pub function: String,
    /// Operations, without control transfers.
    pub operations: u32,
    /// Bundles.
    pub bundles: u32,
    /// Bundles that its stretches of code take at least, by their longest chains and their operations.
    pub least: u32,
    /// Bytes of its stack frame.
    pub frame: u32,
    /// Values that found no register and live on the stack.
    pub spilled: u32,
}

/// The array of a machine, as far as the report needs it.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct ArrayShape {
    /// Rows of the array.
    pub rows: u32,
    /// Columns of the array.
    pub columns: u32,
    /// Contexts of its configuration memory.
    pub contexts: u32,
}

/// A loop on the array.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct LoopReport {
    /// The kernel's name.
    pub kernel: String,
    /// Where the loop statement is.
    pub at: Position,
    /// Operations of an iteration.
    pub operations: u32,
    /// Those of them that compute in software what no unit of the machine runs.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub software: u32,
    /// Routing moves of an iteration.
    pub moves: u32,
    /// Initiation interval, cycles.
    pub ii: u32,
    /// How the II stands to its bounds.
    pub status: Status,
    /// Bound set by units and shared resources.
    pub res_mii: u32,
    /// The resource that sets it.
    pub res_mii_why: String,
    /// The bound of each resource, the scarcest first.
    pub resources: Vec<Resource>,
    /// Bound set by recurrences.
    pub rec_mii: u32,
    /// The recurrence that sets it, in order; empty where there is none.
    pub recurrence: Vec<Step>,
    /// That recurrence and all others that meet it: everything that depends on its operations and that
    /// they depend on.
    pub recurrence_graph: Graph,
    /// The obstacle one II below, if that is not below a bound.
    pub why_not_lower: Option<Obstacle>,
    /// Lower IIs that were proved impossible.
    pub impossible: Vec<Impossible>,
    /// What the exact search tried, and why it ended.
    #[serde(default)]
    pub search: Search,
    /// The outcome of trying changes of the machine, if that was asked for.
    pub what_if: Option<WhatIf>,
    /// A sentence with advice for a lower II.
    pub hint: String,
    /// Accesses that are kept in order because nothing shows that they need not be.
    pub ordered: Vec<Ordered>,
    /// The bound of the II if the pointers of such accesses were `restrict`, where that is lower.
    pub restrict_bound: Option<u32>,
    /// The II that was found for the loop where they are, if that was tried and is lower.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restrict_ii: Option<u32>,
    /// Iterations that overlap.
    pub stages: u32,
    /// Cycles of one iteration from its first issue to its last result.
    pub length: u32,
    /// The fewest that it can be at this II, of any schedule.
    #[serde(default)]
    pub least_length: u32,
    /// Contexts of the configuration memory.
    pub contexts: u32,
    /// Registers set when the kernel is entered.
    pub preloads: u32,
    /// Cycles an iteration takes where a launch runs as many as a ray buffer holds, entry and exit
    /// included.
    pub cycles_per_ray: f64,
    /// Issue slots taken of each unit.
    pub units: Vec<UnitLoad>,
    /// Loads of shared resources.
    pub shared: Vec<SharedLoad>,
    /// Loads of links.
    pub links: Vec<LinkLoad>,
    /// Loads of wires: those of switches and buses.
    #[serde(default)]
    pub wires: Vec<WireLoad>,
    /// Live registers and port loads of register files.
    pub files: Vec<FileLoad>,
    /// The modulo reservation table: a row a slot, a cell a unit.
    pub table: Vec<Vec<Option<Cell>>>,
    /// Seconds of this host that its schedule was looked for, if that was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
}

impl LoopReport {
    /// The larger of both bounds.
    pub fn bound(&self) -> u32 {
        self.res_mii.max(self.rec_mii)
    }

    /// Cycles beyond the critical path up to which all proofs hold; `None` where they hold at any length.
    pub fn horizon(&self) -> Option<u32> {
        self.impossible.iter().filter_map(|i| i.slack).min()
    }

    /// The part of the array's issue slots that is taken.
    pub fn busy(&self) -> f64 {
        let taken: u32 = self.units.iter().map(UnitLoad::busy).sum();
        part(taken, self.ii * self.units.len() as u32)
    }

    /// The part of the links' slots in which something goes over them.
    pub fn links_busy(&self) -> f64 {
        let taken: u32 = self.links.iter().map(|l| l.slots).sum();
        part(taken, self.ii * self.links.len() as u32)
    }

    /// The part of the wires' slots in which they take something.
    pub fn wires_busy(&self) -> f64 {
        let taken: u32 = self.wires.iter().map(|w| w.slots).sum();
        part(taken, self.ii * self.wires.len() as u32)
    }
}

/// A part of a whole, from 0 to 1.
pub fn part(taken: u32, whole: u32) -> f64 {
    f64::from(taken) / f64::from(whole.max(1))
}

/// A part as a whole number of percent.
pub fn percent(part: f64) -> String {
    format!("{:.0}%", 100.0 * part)
}

/// How an II stands to its bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// It is the bound: there is no smaller one.
    Bound,
    /// It is above the bound, and all IIs in between were proved impossible: there is no smaller one.
    Least,
    /// It is above the bound, and all IIs in between were proved impossible, some of them within a horizon.
    Proved,
    /// It is not known if there is a smaller one.
    Open,
}

impl Status {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Status::Bound => "bound",
            Status::Least => "least",
            Status::Proved => "proved",
            Status::Open => "open",
        }
    }
}

/// The need of a loop for a resource.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct Resource {
    /// Classes of operations, `all operations`, or the name of a shared resource.
    pub resource: String,
    /// True if units share it; else it is issue slots of units.
    pub shared: bool,
    /// Operations of an iteration that need it.
    pub operations: u32,
    /// Cycles for which they take it, together.
    pub uses: u32,
    /// How many of it there are in a cycle: units that run the operations, or uses that fit.
    pub offered: u32,
    /// The smallest II at which it suffices.
    pub bound: u32,
}

/// The obstacle to a lower II.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct Obstacle {
    /// In words.
    pub text: String,
    /// The operations that it names.
    pub operations: Vec<Operation>,
}

/// An operation and where it comes from.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct Operation {
    /// The operation that it performs.
    pub op: String,
    /// Its number in the loop.
    pub node: u32,
    /// Where it comes from.
    pub at: Position,
}

/// Two memory accesses that are kept in order.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct Ordered {
    /// The one.
    pub first: Position,
    /// The other.
    pub second: Position,
    /// The fact that is not known of them.
    pub why: String,
    /// True if they are to the same object, and may meet in an element of it.
    #[serde(default)]
    pub in_one_object: bool,
}

/// A source position.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Position {
    /// The file.
    pub file: String,
    /// The line, from 1; 0 where there is none.
    pub line: u32,
    /// The column, from 1.
    pub column: u32,
}

impl std::fmt::Display for Position {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.line == 0 {
            return f.write_str("(made by the compiler)");
        }
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// A step of a recurrence.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct Step {
    /// The operation.
    pub op: String,
    /// Its number in the loop.
    pub node: u32,
    /// Cycles until the next one can issue: the latency, or the delay of a memory order.
    pub latency: u32,
    /// Iterations between it and the next one.
    pub distance: u32,
    /// Where it comes from.
    pub at: Position,
}

/// Operations that depend on each other in circles.
#[derive(Default, Serialize, Deserialize, JsonSchema)]
pub struct Graph {
    /// The operations, in the loop's order.
    pub nodes: Vec<Operation>,
    /// Their dependences.
    pub edges: Vec<Edge>,
}

/// A dependence.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct Edge {
    /// The number of the operation that comes first.
    pub from: u32,
    /// The number of the operation that depends on it.
    pub to: u32,
    /// Cycles between their issues.
    pub latency: u32,
    /// Iterations between them.
    pub distance: u32,
    /// True if it is a step of the recurrence that sets the bound.
    pub critical: bool,
}

/// How busy a unit is.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct UnitLoad {
    /// The unit's name.
    pub unit: String,
    /// Its row, from 0 at the top.
    pub row: u32,
    /// Its column, from 0 at the left.
    pub column: u32,
    /// Slots of the II in which it issues an operation of the loop.
    pub operations: u32,
    /// Slots in which it issues a routing move.
    pub moves: u32,
    /// Slots in which it can issue nothing yet, because of an operation before.
    pub held: u32,
}

impl UnitLoad {
    /// Slots in which it can issue nothing else.
    pub fn busy(&self) -> u32 {
        self.operations + self.moves + self.held
    }
}

/// How much a shared resource is used.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct SharedLoad {
    /// Its name.
    pub resource: String,
    /// Uses that fit in a cycle.
    pub offered: u32,
    /// Uses, by slot.
    pub uses: Vec<u32>,
}

/// How busy a link is.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct LinkLoad {
    /// The unit that it starts from.
    pub from: String,
    /// The unit that it leads to.
    pub to: String,
    /// Its width in bits; 1 for a link of the predicate network.
    pub width: u32,
    /// Registers along it.
    pub delay: u32,
    /// Slots of the II in which a value is taken from it.
    pub slots: u32,
    /// Those values.
    pub carries: Vec<Carried>,
}

impl LinkLoad {
    /// Its ends, and what is not plain about it.
    pub fn name(&self) -> String {
        let kind = if self.width == 1 { " (predicates)" } else { "" };
        format!("{}→{}{kind}", self.from, self.to)
    }
}

/// A value on a link.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct Carried {
    /// The slot in which it is taken from the link.
    pub slot: u32,
    /// The number of the operation whose value it is.
    pub node: u32,
    /// The register file that takes it; null where an operation of the unit does.
    pub file: Option<String>,
}

/// The load of a wire.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct WireLoad {
    /// Its name.
    pub wire: String,
    /// Its width in bits.
    pub width: u32,
    /// Registers at its end.
    pub delay: u32,
    /// Slots of the II in which it takes a value.
    pub slots: u32,
    /// Those values, by slot.
    pub takes: Vec<Taken>,
}

/// A value on a wire.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct Taken {
    /// The slot in which the wire takes it.
    pub slot: u32,
    /// The number of the operation whose value it is.
    pub node: u32,
    /// The unit or wire that it is taken from.
    pub from: String,
    /// The unit whose output it stands in, at the other end of all wires.
    pub unit: String,
    /// The units, wires and register files that take it.
    pub to: Vec<String>,
}

/// Live registers of a register file and the load of its ports.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct FileLoad {
    /// The file's name.
    pub file: String,
    /// Its kind.
    pub kind: FileKind,
    /// The unit that has it to itself; null where several share it.
    pub unit: Option<String>,
    /// Width of a register in bits.
    pub width: u32,
    /// Registers that it has.
    pub capacity: u32,
    /// The most registers that hold something still needed, in any cycle.
    pub live: u32,
    /// The first slot in which they do.
    pub live_slot: u32,
    /// Live registers, by slot.
    pub live_by_slot: Vec<u32>,
    /// Registers that hold one value throughout: invariants, live-ins, live-outs, and those that the calling
    /// convention keeps.
    pub kept: u32,
    /// Reading it.
    pub read: PortLoad,
    /// Writing it.
    pub write: PortLoad,
}

/// Kinds of register files.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum FileKind {
    /// Local to the array, its base advances with every iteration.
    Rotating,
    /// Local to the array, plain addressing.
    Static,
    /// Shared by the VLIW slots and the array.
    Central,
}

impl FileKind {
    /// Its name, as machine files have it.
    pub fn name(self) -> &'static str {
        match self {
            FileKind::Rotating => "rotating",
            FileKind::Static => "static",
            FileKind::Central => "central",
        }
    }
}

/// How busy the ports of a file are in one direction.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct PortLoad {
    /// Ports that there are.
    pub ports: u32,
    /// The most used in any cycle.
    pub most: u32,
    /// The first slot in which they are.
    pub most_slot: u32,
    /// Uses in all slots of the II together.
    pub uses: u32,
}

/// The operation that a unit issues in a slot.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
pub struct Cell {
    /// The operation.
    pub op: String,
    /// Its class.
    pub class: String,
    /// True if it was issued before, and the unit cannot issue again yet.
    pub held: bool,
    /// Its number in the loop.
    pub node: u32,
    /// True if it only moves the value of that operation.
    pub is_move: bool,
    /// Its stage.
    pub stage: u32,
    /// Its operands, in words.
    pub operands: Vec<String>,
    /// Where it comes from.
    pub at: Position,
}

/// A loop that was to run on the array and does not.
#[derive(Serialize, Deserialize, JsonSchema)]
pub struct NotPipelined {
    /// The kernel's name.
    pub kernel: String,
    /// Where the loop statement is.
    pub at: Position,
    /// The obstacle.
    pub reason: String,
    /// Where that is.
    pub reason_at: Position,
    /// True if a pragma asked for it.
    pub required: bool,
    /// The outcome of trying changes of the machine, where the machine is the obstacle and that was asked
    /// for.
    pub what_if: Option<WhatIf>,
}

fn is_zero(count: &u32) -> bool {
    *count == 0
}
