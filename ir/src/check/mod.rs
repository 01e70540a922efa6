//! Whether a scheduled program can run on a machine, and means what it should. It does not matter who
//! made the schedule, and the code that makes schedules is not seen from here.
//!
//! * [`check_control`] goes through the VLIW code along all its paths.
//! * [`check_sequence`] holds the bundles against the operations that they are to do, one after
//!   another: values, memory, transfers.
//! * [`check_kernels`] runs each kernel with *tokens* for values (node and iteration) through the
//!   array, by the rules of time of [`ResourceGraph`](srp_archdesc::ResourceGraph), and looks
//!   whether each operand finds the token that the dataflow graph asks for. [`check_loop`] does so
//!   for one modulo schedule by itself.
//!
//! [`Rule`] lists the rules.

mod modulo;
pub mod sequence;
mod vliw;

pub use modulo::{check_kernels, check_loop};
pub use vliw::{check_control, check_sequence};

use crate::dre::scheduled::{Bundle, Placed, ScheduledDre};
use crate::program::Kernel;
use srp_archdesc::arch::Arch;
use srp_archdesc::entity::Entity;
use std::fmt;

/// A rule that a schedule breaks.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Violation {
    /// Where.
    pub at: Place,
    /// Which rule.
    pub rule: Rule,
    /// What is wrong, in words.
    pub message: String,
}

/// A part of a scheduled program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// The program as a whole.
    Program,
    /// A bundle of VLIW code.
    Bundle(Bundle),
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
    /// An operation has the operands, the immediate and the result of the opcode table.
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
    /// A value takes only ways that the machine has: readers and writers of files, links.
    Path,
    /// A context has room for its constants of words and vectors.
    Constants,
    /// A unit issues nothing for `interval` cycles from an issue on.
    Unit,
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
    Control,
    /// When a launch, or the target of a call or return, begins, no result is in flight and no unit
    /// is taken.
    InFlight,
    /// What is read has been written before, on every way there.
    Undefined,
    /// An operand finds the value that the dataflow graph asks for, of the right iteration; in VLIW
    /// code the one that it has in sequence.
    Value,
    /// Memory accesses keep the order of the dataflow graph, or that of the sequence.
    Order,
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
            Place::Bundle(bundle) => write!(f, "bundle {}", bundle.index()),
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

/// All rules that `dre` breaks on `srp`.
pub fn check(dre: &ScheduledDre, arch: &Arch) -> Result<(), Vec<Violation>> {
    let mut violations = check_control(dre, arch);
    violations.extend(check_kernels(dre, &arch.srp));
    if violations.is_empty() {
        Ok(())
    } else {
        Err(violations)
    }
}
