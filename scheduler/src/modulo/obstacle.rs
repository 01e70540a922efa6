//! Why a loop has no schedule, or none with a lower II: reasons as data, which print as the words
//! that reports and messages have for them.

use super::place::Conflict;
use super::problem::{Goal, Problem};
use serde::{Deserialize, Serialize};
use srp_archdesc::arch::RegFile;
use srp_archdesc::isa::{Opcode, Ty};
use srp_ir::dfg::{Dfg, Node};

/// An operation of a loop, with its name in messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Operation {
    /// The operation.
    pub node: Node,
    /// The opcode.
    pub op: Opcode,
    /// Its source line, from 1; 0 where it has none.
    pub line: u32,
}

impl Operation {
    pub(super) fn of(dfg: &Dfg, node: Node) -> Operation {
        let data = &dfg.nodes[node];
        Operation {
            node,
            op: data.op,
            line: data.pos.line,
        }
    }

    /// The same operation in a loop that differs from its own only in source positions.
    fn relocate(&mut self, dfg: &Dfg) {
        *self = Operation::of(dfg, self.node);
    }
}

impl std::fmt::Display for Operation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "`{}` of line {}", self.op, self.line)
    }
}

/// Where a value has to go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Destination {
    /// An operation that takes it.
    Operation(Operation),
    /// The central register that keeps it after the loop: an index into the loop's live-outs.
    LiveOut(u32),
}

impl Destination {
    fn relocate(&mut self, dfg: &Dfg) {
        if let Destination::Operation(to) = self {
            to.relocate(dfg);
        }
    }
}

/// The most frequent obstacle to a schedule at one II.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Obstacle {
    /// No unit that runs an operation was free when it had to be issued.
    NoUnit(Operation),
    /// Units that run an operation were free when it had to be issued, but not their outputs when its result lands.
    NoOutput(Operation),
    /// Units that run an operation were free, but none near enough to those that it takes from or gives to.
    NoReach(Operation),
    /// A value found no way over links and registers.
    NoRoute {
        /// The operation whose value it is.
        from: Operation,
        /// Where it has to go.
        to: Destination,
    },
    /// Values did not fit in the registers of a file.
    Registers {
        /// The file.
        file: RegFile,
        /// Its name.
        name: String,
    },
    /// A value lives so long in a file that does not rotate that it needs more copies of the loop than there are contexts for.
    Copies {
        /// The file.
        file: RegFile,
        /// Its name.
        name: String,
    },
    /// Constants and values from outside the loop could not be read from a file.
    ReadPorts {
        /// The file.
        file: RegFile,
        /// Its name.
        name: String,
    },
    /// Nothing in particular: the attempts ran out.
    AttemptsExhausted,
    /// The watch ended the search at this II, the last that was tried, before there was a schedule: the one that there is
    /// has its operations in sequence, and says nothing of lower IIs.
    CutShort,
}

impl Obstacle {
    pub(super) fn of(problem: &Problem<'_>, conflict: Option<Conflict>) -> Obstacle {
        let operation = |node| Operation::of(problem.dfg, node);
        let file = |place| {
            let file = problem.graph.as_file(place);
            let file = file.expect("only files have registers and ports that can run out");
            (file, problem.srp.files[file].name.clone())
        };
        match conflict {
            None => Obstacle::AttemptsExhausted,
            Some(Conflict::Unit(node)) => Obstacle::NoUnit(operation(node)),
            Some(Conflict::Output(node)) => Obstacle::NoOutput(operation(node)),
            Some(Conflict::Reach(node)) => Obstacle::NoReach(operation(node)),
            Some(Conflict::Route(edge)) => {
                let edge = &problem.edges[edge];
                Obstacle::NoRoute {
                    from: operation(edge.from),
                    to: match edge.goal {
                        Goal::Operand(to, _) => Destination::Operation(operation(to)),
                        Goal::LiveOut(index) => Destination::LiveOut(index),
                    },
                }
            }
            Some(Conflict::Registers(place)) => {
                let (file, name) = file(place);
                Obstacle::Registers { file, name }
            }
            Some(Conflict::Copies(place)) => {
                let (file, name) = file(place);
                Obstacle::Copies { file, name }
            }
            Some(Conflict::ReadPorts(place)) => {
                let (file, name) = file(place);
                Obstacle::ReadPorts { file, name }
            }
        }
    }

    fn relocate(&mut self, dfg: &Dfg) {
        match self {
            Obstacle::NoUnit(operation)
            | Obstacle::NoOutput(operation)
            | Obstacle::NoReach(operation) => operation.relocate(dfg),
            Obstacle::NoRoute { from, to } => {
                from.relocate(dfg);
                to.relocate(dfg);
            }
            Obstacle::Registers { .. }
            | Obstacle::Copies { .. }
            | Obstacle::ReadPorts { .. }
            | Obstacle::AttemptsExhausted
            | Obstacle::CutShort => {}
        }
    }

    /// The operations that it names, each once.
    pub fn operations(&self) -> Vec<Operation> {
        match *self {
            Obstacle::NoUnit(operation)
            | Obstacle::NoOutput(operation)
            | Obstacle::NoReach(operation) => vec![operation],
            Obstacle::NoRoute { from, to } => match to {
                Destination::Operation(to) if to != from => vec![from, to],
                _ => vec![from],
            },
            Obstacle::Registers { .. }
            | Obstacle::Copies { .. }
            | Obstacle::ReadPorts { .. }
            | Obstacle::AttemptsExhausted
            | Obstacle::CutShort => Vec::new(),
        }
    }
}

impl Obstacle {
    /// In words, where operations have these names.
    fn words(&self, name: &dyn Fn(&Operation) -> String) -> String {
        match self {
            Obstacle::NoUnit(operation) => format!("no unit is free for {}", name(operation)),
            Obstacle::NoOutput(operation) => {
                format!("no output is free when the result of {} lands", name(operation))
            }
            Obstacle::NoReach(operation) => format!(
                "no free unit is near enough for {} between what it takes and what takes it",
                name(operation)
            ),
            Obstacle::NoRoute { from, to } => match to {
                Destination::Operation(to) => {
                    format!("no route from {} to {}", name(from), name(to))
                }
                Destination::LiveOut(_) => {
                    format!("no route from {} to a central register", name(from))
                }
            },
            Obstacle::Registers { name, .. } => format!("the registers of {name} do not suffice"),
            Obstacle::Copies { name, .. } => format!(
                "a value lives longer in {name} than there are contexts for copies of the loop"
            ),
            Obstacle::ReadPorts { name, .. } => format!(
                "the read ports of {name} do not suffice for constants and values from before the loop"
            ),
            Obstacle::AttemptsExhausted => "attempts ran out".to_owned(),
            Obstacle::CutShort => {
                "the search was cut short before it had a schedule: this one has its operations in sequence"
                    .to_owned()
            }
        }
    }
}

impl std::fmt::Display for Obstacle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.words(&Operation::to_string))
    }
}

/// An II that did not work.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FailedIi {
    /// The II.
    pub ii: u32,
    /// The obstacle.
    pub obstacle: Obstacle,
}

impl std::fmt::Display for FailedIi {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "at II = {}, {}", self.ii, self.obstacle)
    }
}

impl FailedIi {
    /// In words, where operations have these names.
    pub fn words(&self, name: &dyn Fn(&Operation) -> String) -> String {
        format!("at II = {}, {}", self.ii, self.obstacle.words(name))
    }

    /// Names operations as in a loop that differs from the one that was scheduled only in source
    /// positions.
    pub fn relocate(&mut self, dfg: &Dfg) {
        self.obstacle.relocate(dfg);
    }
}

/// Why a loop has no schedule on a machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Unschedulable {
    /// Its live-in values do not fit in the central registers.
    LiveIns {
        /// The type of those that share the file which is too small, if they are of one.
        ty: Option<Ty>,
        /// The number of those.
        count: usize,
        /// The number of registers that hold such values.
        room: u32,
    },
    /// The array cannot write a value into the central registers, where it is kept after the loop.
    LiveOut {
        /// Its bits.
        bits: u32,
    },
    /// No unit of the array runs an operation.
    NoUnit(Operation),
    /// No unit that runs an operation has its constants and live-in values within reach.
    NoPlace(Operation),
    /// No way leads from a unit that runs an operation to where its value has to go.
    NoWay {
        /// The operation whose value it is.
        from: Operation,
        /// Where it has to go.
        to: Destination,
        /// True if the value has to come out of a register file, which holds its initial values too.
        in_register: bool,
    },
    /// Its II takes more contexts than the configuration memory has.
    Contexts {
        /// The bound of its II.
        bound: u32,
        /// Contexts that there are.
        contexts: u32,
    },
    /// More values of earlier iterations live at once than the array has places for.
    Storage {
        /// How many live at once, at least.
        held: u64,
        /// Registers, outputs, stages of units and links, together.
        room: u64,
    },
    /// The watch ended the search before there was a schedule.
    Stopped {
        /// The largest II that was tried to no avail, if one was.
        failed: Option<FailedIi>,
    },
    /// No II that the configuration memory has contexts for was found to work.
    NotFound {
        /// The largest II that there are contexts for.
        up_to: u32,
        /// The largest II that was tried to no avail.
        failed: FailedIi,
    },
}

impl Unschedulable {
    /// Names operations as in a loop that differs from the one that was scheduled only in source
    /// positions.
    pub fn relocate(&mut self, dfg: &Dfg) {
        match self {
            Unschedulable::NoUnit(operation) | Unschedulable::NoPlace(operation) => {
                operation.relocate(dfg);
            }
            Unschedulable::Stopped { failed } => {
                failed.iter_mut().for_each(|failed| failed.relocate(dfg));
            }
            Unschedulable::NoWay { from, to, .. } => {
                from.relocate(dfg);
                to.relocate(dfg);
            }
            Unschedulable::NotFound { failed, .. } => failed.relocate(dfg),
            Unschedulable::LiveIns { .. }
            | Unschedulable::LiveOut { .. }
            | Unschedulable::Contexts { .. }
            | Unschedulable::Storage { .. } => {}
        }
    }

    /// The node that it fails on, if it is one.
    pub fn node(&self) -> Option<Node> {
        match self {
            Unschedulable::NoUnit(operation) | Unschedulable::NoPlace(operation) => {
                Some(operation.node)
            }
            _ => None,
        }
    }
}

impl Unschedulable {
    /// In words, where operations have these names.
    pub fn words(&self, name: &dyn Fn(&Operation) -> String) -> String {
        match self {
            Unschedulable::LiveIns { ty, count, room } => {
                let values = match ty {
                    Some(Ty::Pred) => "conditions",
                    Some(Ty::Word) => "words",
                    Some(Ty::Vec) => "vectors",
                    None => "values",
                };
                format!(
                    "{count} {values} from before the loop wait in central registers, of which {room} hold such: compute some of \
                     them in the loop, or give that file more registers"
                )
            }
            Unschedulable::LiveOut { bits } => format!(
                "no unit of the array writes central registers of {bits} bits, where a value stays after the loop"
            ),
            Unschedulable::NoUnit(Operation { op, .. }) => {
                format!("no unit of the array runs `{op}` (class {})", op.class())
            }
            Unschedulable::NoPlace(operation) => format!(
                "no unit that runs {} has places for its constants and values from outside the loop, and ports to read them at \
                 once: give its type more `constants`, or a static register file with as many `read-ports`",
                name(operation)
            ),
            Unschedulable::NoWay {
                from,
                to,
                in_register,
            } => {
                let to = match to {
                    Destination::Operation(to) => format!("a unit that runs {}", name(to)),
                    Destination::LiveOut(_) => "a central register".to_owned(),
                };
                let (through, needs) = match in_register {
                    true => (
                        ", through a register file where its initial values wait,",
                        "links, wires or a file",
                    ),
                    false => ("", "links or wires"),
                };
                let from = name(from);
                format!(
                    "no way leads from a unit that runs {from}{through} to {to}: the array needs {needs} between them"
                )
            }
            Unschedulable::Contexts { bound, contexts } => {
                let are = if *contexts == 1 {
                    "is one context"
                } else {
                    &format!("are {contexts} contexts")
                };
                format!("its II is at least {bound}; there {are}")
            }
            Unschedulable::Storage { held, room } => format!(
                "at least {held} values of earlier iterations live at once; registers, outputs and links of the array \
                 have room for {room}"
            ),
            Unschedulable::Stopped { failed: None } => {
                "stopped before a schedule was found".to_owned()
            }
            Unschedulable::Stopped {
                failed: Some(failed),
            } => format!(
                "stopped before a schedule was found: {}",
                failed.words(name)
            ),
            Unschedulable::NotFound { up_to, failed } => {
                format!("no II up to {up_to} was found: {}", failed.words(name))
            }
        }
    }
}

impl std::fmt::Display for Unschedulable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.words(&Operation::to_string))
    }
}

impl std::error::Error for Unschedulable {}
