//! [`Report`]: what is said of every loop. Text, JSON and page show this and nothing else;
//! `docs/report.md` is the reference of its members.

use crate::failure::Failure;
use serde::{Deserialize, Serialize};

/// What a file of a report calls itself.
pub(crate) const FORMAT: &str = "srp-report";

/// The version of the members below. It rises when one changes its meaning or goes away.
pub(crate) const VERSION: u32 = 1;

/// The report of a program on a machine.
#[derive(Serialize, Deserialize)]
pub(crate) struct Report {
    /// [`FORMAT`].
    pub(crate) format: String,
    /// [`VERSION`].
    pub(crate) version: u32,
    /// The machine.
    pub(crate) machine: Machine,
    /// Whether the search for schedules went its whole way; not where it was interrupted.
    pub(crate) complete: bool,
    /// Loops on the array, in program order.
    pub(crate) loops: Vec<LoopReport>,
    /// Loops that were to run on the array and do not.
    pub(crate) not_pipelined: Vec<NotPipelined>,
    /// Functions on the VLIW engine, in program order.
    #[serde(default)]
    pub(crate) functions: Vec<FunctionReport>,
    /// What lowers the II of several loops or of one, the most helpful first; empty unless changes
    /// were tried.
    pub(crate) advice: Vec<Advice>,
}

impl Report {
    /// Leaves out everything but the loops of one name.
    pub(crate) fn keep_only(&mut self, kernel: &str) -> Result<(), Failure> {
        let names = self.loops.iter().map(|l| l.kernel.clone());
        let names: Vec<String> = names
            .chain(self.not_pipelined.iter().map(|n| n.kernel.clone()))
            .collect();
        self.loops.retain(|l| l.kernel == kernel);
        self.not_pipelined.retain(|n| n.kernel == kernel);
        self.functions.clear();
        if self.loops.is_empty() && self.not_pipelined.is_empty() {
            let names = names.join(", ");
            return Err(Failure::Message(format!(
                "no kernel is named {kernel}; there are {names}"
            )));
        }
        Ok(())
    }
}

/// The control code of a function.
#[derive(Serialize, Deserialize)]
pub(crate) struct FunctionReport {
    /// Its name.
    pub(crate) function: String,
    /// Operations, without control transfers.
    pub(crate) operations: u32,
    /// Bundles.
    pub(crate) bundles: u32,
    /// Bundles that its stretches of code take at least, by their longest chains and their operations.
    pub(crate) least: u32,
    /// Bytes of its stack frame.
    pub(crate) frame: u32,
    /// Values that found no register and live on the stack.
    pub(crate) spilled: u32,
}

/// The machine, as far as the report needs it.
#[derive(Serialize, Deserialize)]
pub(crate) struct Machine {
    /// Its name.
    pub(crate) name: String,
    /// Rows of the array.
    pub(crate) rows: u32,
    /// Columns of the array.
    pub(crate) columns: u32,
    /// Contexts of its configuration memory.
    pub(crate) contexts: u32,
}

/// A change of the machine, and the loops that it helps.
#[derive(Serialize, Deserialize)]
pub(crate) struct Advice {
    /// What changes.
    pub(crate) what: String,
    /// The loops.
    pub(crate) lowers: Vec<Lowered>,
}

/// A loop that a change helps.
#[derive(Serialize, Deserialize)]
pub(crate) struct Lowered {
    /// Its kernel.
    pub(crate) kernel: String,
    /// Its II on the machine as it is; null where it is not on the array.
    pub(crate) from: Option<u32>,
    /// Its II on the changed machine.
    pub(crate) to: u32,
}

/// A loop on the array.
#[derive(Serialize, Deserialize)]
pub(crate) struct LoopReport {
    /// The kernel's name.
    pub(crate) kernel: String,
    /// Where the loop statement is.
    pub(crate) at: Position,
    /// Operations of an iteration.
    pub(crate) operations: u32,
    /// Routing moves of an iteration.
    pub(crate) moves: u32,
    /// Initiation interval, cycles.
    pub(crate) ii: u32,
    /// How the II stands to its bounds.
    pub(crate) status: Status,
    /// Bound set by units and shared resources.
    pub(crate) res_mii: u32,
    /// What sets it.
    pub(crate) res_mii_why: String,
    /// The bound of each resource, the scarcest first.
    pub(crate) resources: Vec<Resource>,
    /// Bound set by recurrences.
    pub(crate) rec_mii: u32,
    /// The recurrence that sets it, in order; empty where there is none.
    pub(crate) recurrence: Vec<Step>,
    /// That recurrence and all others that meet it: everything that depends on its operations and that
    /// they depend on.
    pub(crate) recurrence_graph: Graph,
    /// What failed one II below, if that is not below a bound.
    pub(crate) why_not_lower: Option<Obstacle>,
    /// Lower IIs that were proved impossible.
    pub(crate) impossible: Vec<Impossible>,
    /// What became of trying changes of the machine, if that was asked for.
    pub(crate) what_if: Option<WhatIf>,
    /// In a sentence, what to do for a lower II.
    pub(crate) hint: String,
    /// Accesses that are kept in order because nothing shows that they need not be.
    pub(crate) ordered: Vec<Ordered>,
    /// The bound of the II if the pointers of such accesses were `restrict`, where that is lower.
    pub(crate) restrict_bound: Option<u32>,
    /// Iterations that overlap.
    pub(crate) stages: u32,
    /// Cycles of one iteration from its first issue to its last result.
    pub(crate) length: u32,
    /// Contexts of the configuration memory.
    pub(crate) contexts: u32,
    /// Registers set when the kernel is entered.
    pub(crate) preloads: u32,
    /// Cycles an iteration takes where a launch runs as many as a ray buffer holds, entry and exit
    /// included.
    pub(crate) cycles_per_ray: f64,
    /// Issue slots taken of each unit.
    pub(crate) units: Vec<UnitLoad>,
    /// What each shared resource is used.
    pub(crate) shared: Vec<SharedLoad>,
    /// What goes over each link.
    pub(crate) links: Vec<LinkLoad>,
    /// What stands in each register file and passes its ports.
    pub(crate) files: Vec<FileLoad>,
    /// The modulo reservation table: a row a slot, a cell a unit.
    pub(crate) table: Vec<Vec<Option<Cell>>>,
    /// Seconds of this host that its schedule was looked for, if that was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) seconds: Option<f64>,
}

impl LoopReport {
    /// The larger of both bounds.
    pub(crate) fn bound(&self) -> u32 {
        self.res_mii.max(self.rec_mii)
    }

    /// Cycles beyond the critical path up to which all proofs hold.
    pub(crate) fn horizon(&self) -> u32 {
        self.impossible.iter().map(|i| i.slack).min().unwrap_or(0)
    }

    /// The part of the array's issue slots that is taken.
    pub(crate) fn busy(&self) -> f64 {
        let taken: u32 = self.units.iter().map(UnitLoad::busy).sum();
        part(taken, self.ii * self.units.len() as u32)
    }

    /// The part of the links' slots in which something goes over them.
    pub(crate) fn links_busy(&self) -> f64 {
        let taken: u32 = self.links.iter().map(|l| l.slots).sum();
        part(taken, self.ii * self.links.len() as u32)
    }
}

/// A part of a whole, from 0 to 1.
pub(crate) fn part(taken: u32, whole: u32) -> f64 {
    f64::from(taken) / f64::from(whole.max(1))
}

/// How an II stands to its bounds.
#[derive(Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Status {
    /// It is the bound: there is no smaller one.
    Bound,
    /// It is above the bound, and all IIs in between were proved impossible, within a horizon.
    Proved,
    /// Whether there is a smaller one is not known.
    Open,
}

/// What a loop needs of a resource.
#[derive(Serialize, Deserialize)]
pub(crate) struct Resource {
    /// Classes of operations, `all operations`, or the name of a shared resource.
    pub(crate) resource: String,
    /// Whether units share it; else it is issue slots of units.
    pub(crate) shared: bool,
    /// Operations of an iteration that need it.
    pub(crate) operations: u32,
    /// Cycles for which they take it, together.
    pub(crate) uses: u32,
    /// How many of it there are in a cycle: units that run the operations, or uses that fit.
    pub(crate) offered: u32,
    /// The smallest II at which it suffices.
    pub(crate) bound: u32,
}

/// What became of trying changes of the machine.
#[derive(Serialize, Deserialize)]
pub(crate) struct WhatIf {
    /// Changes that were tried.
    pub(crate) tried: u32,
    /// Those that lower the II, the best first.
    pub(crate) changes: Vec<Change>,
}

/// A change of the machine.
#[derive(Serialize, Deserialize)]
pub(crate) struct Change {
    /// What changes.
    pub(crate) what: String,
    /// The II that the loop then has.
    pub(crate) ii: u32,
}

/// What was in the way of a lower II.
#[derive(Serialize, Deserialize)]
pub(crate) struct Obstacle {
    /// In words.
    pub(crate) text: String,
    /// The operations that it names.
    pub(crate) operations: Vec<Operation>,
}

/// An operation and where it comes from.
#[derive(Serialize, Deserialize)]
pub(crate) struct Operation {
    /// What it does.
    pub(crate) op: String,
    /// Its number in the loop.
    pub(crate) node: u32,
    /// Where it comes from.
    pub(crate) at: Position,
}

/// A proof that there is no schedule with this II.
#[derive(Serialize, Deserialize)]
pub(crate) struct Impossible {
    /// The II.
    pub(crate) ii: u32,
    /// It holds where no operation is issued later than so many cycles after its latest start on
    /// the critical path.
    pub(crate) slack: u32,
}

/// Two memory accesses that are kept in order.
#[derive(Serialize, Deserialize)]
pub(crate) struct Ordered {
    /// The one.
    pub(crate) first: Position,
    /// The other.
    pub(crate) second: Position,
    /// What is not known of them.
    pub(crate) why: String,
}

/// A source position.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Position {
    /// The file.
    pub(crate) file: String,
    /// The line, from 1; 0 where there is none.
    pub(crate) line: u32,
    /// The column, from 1.
    pub(crate) column: u32,
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
#[derive(Serialize, Deserialize)]
pub(crate) struct Step {
    /// The operation.
    pub(crate) op: String,
    /// Its number in the loop.
    pub(crate) node: u32,
    /// Cycles until the next one can issue: the latency, or the delay of a memory order.
    pub(crate) latency: u32,
    /// Iterations between it and the next one.
    pub(crate) distance: u32,
    /// Where it comes from.
    pub(crate) at: Position,
}

/// Operations that depend on each other in circles.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct Graph {
    /// The operations, in the loop's order.
    pub(crate) nodes: Vec<Operation>,
    /// Their dependences.
    pub(crate) edges: Vec<Edge>,
}

/// A dependence.
#[derive(Serialize, Deserialize)]
pub(crate) struct Edge {
    /// The number of the operation that comes first.
    pub(crate) from: u32,
    /// The number of the operation that depends on it.
    pub(crate) to: u32,
    /// Cycles between their issues.
    pub(crate) latency: u32,
    /// Iterations between them.
    pub(crate) distance: u32,
    /// Whether it is a step of the recurrence that sets the bound.
    pub(crate) critical: bool,
}

/// How busy a unit is.
#[derive(Serialize, Deserialize)]
pub(crate) struct UnitLoad {
    /// The unit's name.
    pub(crate) unit: String,
    /// Its row, from 0 at the top.
    pub(crate) row: u32,
    /// Its column, from 0 at the left.
    pub(crate) column: u32,
    /// Slots of the II in which it issues an operation of the loop.
    pub(crate) operations: u32,
    /// Slots in which it issues a routing move.
    pub(crate) moves: u32,
    /// Slots in which it can issue nothing yet, because of an operation before.
    pub(crate) held: u32,
}

impl UnitLoad {
    /// Slots in which it can issue nothing else.
    pub(crate) fn busy(&self) -> u32 {
        self.operations + self.moves + self.held
    }
}

/// How much a shared resource is used.
#[derive(Serialize, Deserialize)]
pub(crate) struct SharedLoad {
    /// Its name.
    pub(crate) resource: String,
    /// Uses that fit in a cycle.
    pub(crate) offered: u32,
    /// Uses, by slot.
    pub(crate) uses: Vec<u32>,
}

/// How busy a link is.
#[derive(Serialize, Deserialize)]
pub(crate) struct LinkLoad {
    /// The unit that it starts from.
    pub(crate) from: String,
    /// The unit that it leads to.
    pub(crate) to: String,
    /// Its width in bits; 1 for a link of the predicate network.
    pub(crate) width: u32,
    /// Registers along it.
    pub(crate) delay: u32,
    /// Slots of the II in which a value is taken from it.
    pub(crate) slots: u32,
    /// Those values.
    pub(crate) carries: Vec<Carried>,
}

impl LinkLoad {
    /// Its ends, and what is not plain about it.
    pub(crate) fn name(&self) -> String {
        let kind = if self.width == 1 { " (predicates)" } else { "" };
        format!("{}→{}{kind}", self.from, self.to)
    }
}

/// A value on a link.
#[derive(Serialize, Deserialize)]
pub(crate) struct Carried {
    /// The slot in which it is taken from the link.
    pub(crate) slot: u32,
    /// The number of the operation whose value it is.
    pub(crate) node: u32,
    /// The register file that takes it; null where an operation of the unit does.
    pub(crate) file: Option<String>,
}

/// What stands in a register file and passes its ports.
#[derive(Serialize, Deserialize)]
pub(crate) struct FileLoad {
    /// The file's name.
    pub(crate) file: String,
    /// Its kind.
    pub(crate) kind: FileKind,
    /// The unit that has it to itself; null where several share it.
    pub(crate) unit: Option<String>,
    /// Width of a register in bits.
    pub(crate) width: u32,
    /// Registers that it has.
    pub(crate) capacity: u32,
    /// The most registers that hold something still needed, in any cycle.
    pub(crate) live: u32,
    /// The first slot in which they do.
    pub(crate) live_slot: u32,
    /// Live registers, by slot.
    pub(crate) live_by_slot: Vec<u32>,
    /// Registers that hold one thing throughout: invariants, live-ins, live-outs, what the calling
    /// convention keeps.
    pub(crate) kept: u32,
    /// Reading it.
    pub(crate) read: PortLoad,
    /// Writing it.
    pub(crate) write: PortLoad,
}

/// Kinds of register files.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum FileKind {
    /// Local to the array, its base advances with every iteration.
    Rotating,
    /// Local to the array, plain addressing.
    Static,
    /// Shared by the VLIW slots and the array.
    Central,
}

impl FileKind {
    /// Its name, as machine files have it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            FileKind::Rotating => "rotating",
            FileKind::Static => "static",
            FileKind::Central => "central",
        }
    }
}

/// How busy the ports of a file are in one direction.
#[derive(Serialize, Deserialize)]
pub(crate) struct PortLoad {
    /// Ports that there are.
    pub(crate) ports: u32,
    /// The most used in any cycle.
    pub(crate) most: u32,
    /// The first slot in which they are.
    pub(crate) most_slot: u32,
    /// Uses in all slots of the II together.
    pub(crate) uses: u32,
}

/// What a unit issues in a slot.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Cell {
    /// The operation.
    pub(crate) op: String,
    /// Its class.
    pub(crate) class: String,
    /// Whether it was issued before, and the unit cannot issue again yet.
    pub(crate) held: bool,
    /// Its number in the loop.
    pub(crate) node: u32,
    /// Whether it only moves the value of that operation.
    pub(crate) is_move: bool,
    /// Its stage.
    pub(crate) stage: u32,
    /// Its operands, in words.
    pub(crate) operands: Vec<String>,
    /// Where it comes from.
    pub(crate) at: Position,
}

/// A loop that was to run on the array and does not.
#[derive(Serialize, Deserialize)]
pub(crate) struct NotPipelined {
    /// The kernel's name.
    pub(crate) kernel: String,
    /// Where the loop statement is.
    pub(crate) at: Position,
    /// What is in the way.
    pub(crate) reason: String,
    /// Where that is.
    pub(crate) reason_at: Position,
    /// Whether a pragma asked for it.
    pub(crate) required: bool,
    /// What became of trying changes of the machine, where it is the machine that is in the way and
    /// that was asked for.
    pub(crate) what_if: Option<WhatIf>,
}
