//! Checks that a scheduled program can run on a machine and means what it should. The checks do not
//! depend on the scheduler and share no code with it.
//!
//! [`check`] runs all checks and returns a [`Checked`], which later stages demand:
//!
//! * [`check_control`] goes through the VLIW code along all its paths.
//! * [`check_sequence`] compares the bundles with the operations in sequence: values, memory,
//!   transfers. Only the scheduler that made the bundles knows the sequence, so [`check_against`]
//!   takes it.
//! * [`check_kernels`] runs each kernel with *tokens* for values (node and iteration) on the array,
//!   by the timing of [`ResourceGraph`](srp_archdesc::ResourceGraph), and checks that each operand
//!   finds the token that the dataflow graph asks for. [`check_loop`] does so for a single modulo
//!   schedule.
//!
//! [`diagnostics()`] says where the file of a schedule breaks them.
//!
//! [`Rule`] lists the rules.

mod checked;
mod modulo;
mod places;
pub mod sequence;
mod vliw;

pub use checked::{Checked, Refused, check, check_against};
pub use modulo::{check_kernels, check_loop, check_loops};
pub use places::diagnostics;
pub use vliw::{check_control, check_sequence};

use crate::dre::scheduled::{Bundle, Placed, ScheduledDre};
use crate::program::{Kernel, Pos};
use srp_archdesc::arch::Fu;
use srp_archdesc::entity::Entity;
use std::fmt;

/// A rule that a schedule breaks.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Violation {
    /// Where.
    pub at: Place,
    /// Which rule.
    pub rule: Rule,
    /// The message.
    pub message: String,
}

/// A part of a scheduled program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// The program as a whole.
    Program,
    /// A bundle of VLIW code.
    Bundle(Bundle),
    /// The operation of a bundle in the slot of this unit.
    Slot(Bundle, Fu),
    /// The control transfer of a bundle.
    Transfer(Bundle),
    /// A kernel.
    Kernel(Kernel),
    /// An operation of a kernel.
    Op(Kernel, Placed),
}

/// The rules.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rule {
    /// Numbers name things that exist: bundles, units, links, registers of a file, kernels, nodes.
    Range,
    /// An operation has the operands, the immediate and the result of the opcode table; a dataflow graph
    /// is valid (`Dfg::verify`).
    Form,
    /// Each node of a loop is placed exactly once, in its place of the list; everything else is a
    /// move of a value. Each operation of a stretch of VLIW code is in exactly one of its bundles.
    Placement,
    /// VLIW operations are on slots, one operation a slot and bundle.
    Slot,
    /// A unit runs operations of its classes only; ports are for VLIW code, one a bundle.
    Class,
    /// A value fits in every unit, link and register that it passes.
    Width,
    /// A value takes only ways that the machine has: readers and writers of files, links, inputs of wires.
    Routing,
    /// A wire takes one value in a cycle. A value passes no more wires in a cycle than the machine allows, and
    /// none in a circle.
    Wire,
    /// A context has room for its constants of words and vectors.
    Constants,
    /// A unit issues nothing for `interval` cycles from an issue on.
    IssueInterval,
    /// A shared resource is not used more often in a cycle than there are of it.
    Resource,
    /// No more distinct registers of a file are read in a cycle than it has ports.
    ReadPorts,
    /// No more results arrive in a file in a cycle than it has ports.
    WritePorts,
    /// Two results do not arrive in one place in one cycle.
    Collision,
    /// A bundle has at most one control transfer, none while another's delay runs, and a free unit
    /// of class branch for it; code does not run into the next function or off the end.
    ControlFlow,
    /// When a launch, or the target of a call or return, begins, no result is in flight and no unit
    /// is taken.
    InFlight,
    /// A register that is read has been written before, on every path there.
    Undefined,
    /// An operand finds the value that the dataflow graph asks for, of the right iteration; in VLIW
    /// code the one that it has in sequence.
    Dataflow,
    /// Memory accesses keep the order of the dataflow graph, or that of the sequence.
    MemoryOrder,
    /// Live-in values and registers set at entry fit the dataflow graph and do not meet.
    LiveIn,
    /// Live-out values of the last iteration stand in their registers at the end.
    LiveOut,
    /// Initiation interval, rings and length fit together and into the configuration memory.
    Contexts,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Program => f.write_str("program"),
            Place::Bundle(bundle) | Place::Transfer(bundle) => write!(f, "bundle {bundle}"),
            Place::Slot(bundle, fu) => write!(f, "bundle {bundle}, {fu}"),
            Place::Kernel(kernel) => write!(f, "kernel {}", kernel.index()),
            Place::Op(kernel, op) => {
                write!(f, "kernel {}, operation {}", kernel.index(), op.index())
            }
        }
    }
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} ({:?})", self.at, self.message, self.rule)
    }
}

impl Violation {
    /// The violation with the source position of its place, where that has one, and with the names of
    /// `program`, in which it was found.
    pub fn describe(&self, program: &ScheduledDre) -> String {
        let Violation { at, rule, message } = self;
        let pos = at.pos(program).filter(|pos| pos.line > 0);
        let source = pos.and_then(|pos| {
            let file = program.files.get(pos.file)?;
            Some(format!("{file}:{}:{}: ", pos.line, pos.column))
        });
        let source = source.unwrap_or_default();
        let place = match *at {
            Place::Program => "the program".to_owned(),
            Place::Bundle(bundle) | Place::Slot(bundle, _) | Place::Transfer(bundle) => {
                format!("bundle {bundle}")
            }
            Place::Kernel(kernel) | Place::Op(kernel, _) => {
                let schedule = program.kernels.get(kernel);
                let name = schedule.map_or("", |schedule| &schedule.dfg.name);
                format!("kernel `{name}`")
            }
        };
        format!("{source}{place}: {message} ({rule:?})")
    }
}

impl Place {
    /// The kernel, if it is one or in one.
    pub fn kernel(self) -> Option<Kernel> {
        match self {
            Place::Kernel(kernel) | Place::Op(kernel, _) => Some(kernel),
            Place::Program | Place::Bundle(_) | Place::Slot(..) | Place::Transfer(_) => None,
        }
    }

    /// Where the code of a place comes from.
    fn pos(self, program: &ScheduledDre) -> Option<Pos> {
        match self {
            Place::Program | Place::Bundle(_) => None,
            Place::Slot(bundle, fu) => {
                let ops = &program.bundles.get(bundle)?.ops;
                ops.iter().find(|op| op.fu == fu).map(|op| op.pos)
            }
            Place::Transfer(bundle) => {
                let control = program.bundles.get(bundle)?.control.as_ref();
                control.map(|(_, pos)| *pos)
            }
            Place::Kernel(kernel) => Some(program.kernels.get(kernel)?.dfg.pos),
            Place::Op(kernel, op) => {
                let schedule = program.kernels.get(kernel)?;
                let node = schedule.ops.get(op)?.node;
                schedule.dfg.nodes.get(node).map(|node| node.pos)
            }
        }
    }
}
