//! [`SimSpec`]: a scheduled program and its machine as one set of dense tables.
//!
//! Everything that moves in a cycle is a [`Step`]: some cells of state are read, a value is made of
//! them, some cells are written. By the rules of time all reads of a cycle come before all its
//! writes. The linker has put the steps of each cycle into an order in which they can be carried
//! out one after the other with the same outcome, so neither engine keeps two copies of the state.
//!
//! A value whose latency is longer than a cycle waits in cells of its own: those of a kernel are
//! part of the tables ([`Role::Flight`]), because a modulo schedule says when each of them is
//! needed; those of VLIW code are the sequencer's business, because branches decide.

use crate::preamble::border::Banks;
use crate::preamble::sequencer::KernelTimes;
use srp_archdesc::arch::{Carrier, Fu, Precision};
use srp_archdesc::isa::{Effect, Opcode, Ty};
use srp_ir::program::Bits;
use std::collections::BTreeSet;

/// A number in [`SimSpec::positions`].
pub type Position = u32;

/// A machine with a program: all that a simulator is made of.
///
/// Always holds: nothing is left to be looked up, everything is within its range, and the order of
/// everything depends on the program and the machine alone. Made only by [`link`](crate::link()).
#[derive(Clone, Debug, PartialEq)]
pub struct SimSpec {
    /// The machine's name.
    pub machine: String,
    /// All state, in the order of its cells.
    pub stores: Vec<Store>,
    /// Number of cells of all stores.
    pub cells: u32,
    /// How exact the special functions are.
    pub precision: Precision,
    /// SRAM accesses below this address trap.
    pub first_address: u32,
    /// Banks of the SRAM that accesses compete for.
    pub banks: Banks,
    /// Size of SRAM in bytes.
    pub sram_bytes: u32,
    /// Initial contents of SRAM from address 0; the rest is zero.
    pub image: Vec<u8>,
    /// Cycles after a branch's own before its target issues.
    pub branch_delay: u32,
    /// Longest latency of an operation of the VLIW code.
    pub max_latency: u32,
    /// The VLIW code.
    pub bundles: Vec<BundleSpec>,
    /// Name and entry bundle of each function, in the order of function addresses.
    pub functions: Vec<(String, u32)>,
    /// Where execution starts.
    pub start: u32,
    /// The kernels, in the order of the scheduled program.
    pub kernels: Vec<KernelSpec>,
    /// Source positions, `file:line:column`; those from nowhere are empty.
    pub positions: Vec<String>,
}

/// A named piece of state.
#[derive(Clone, Debug, PartialEq)]
pub struct Store {
    /// Its name: an identifier, unique among the stores of the same kernel or of the machine.
    pub name: String,
    /// The type of a cell.
    pub ty: Ty,
    /// Number of cells.
    pub size: u32,
    /// Index of its first cell among those of all stores.
    pub base: u32,
    /// Its role.
    pub role: Role,
}

/// The role of a [`Store`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// An output register of a unit; one cell.
    Output,
    /// A plain register file.
    File,
    /// A register file whose cells are named relative to the running iteration.
    Rotating,
    /// Values on their way in a kernel: results not yet landed, links with registers.
    Flight(u32),
}

/// A cell: a register of a store.
///
/// In a rotating store it is the register that many places (modulo the size) after that of the
/// iteration begun last. Of a ring it is register `index + (n + phase) mod ring`, where `n` is the
/// number of the iteration begun last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// Index in [`SimSpec::stores`].
    pub store: u32,
    /// Index in the store.
    pub index: u32,
    /// Registers of the ring; 1 for a plain register.
    pub ring: u32,
    /// Less than `ring`.
    pub phase: u32,
}

impl Cell {
    /// A plain cell.
    pub fn new(store: u32, index: u32) -> Cell {
        Cell {
            store,
            index,
            ring: 1,
            phase: 0,
        }
    }

    /// True if two cells are, or may be in some iteration, the same.
    pub fn meets(self, other: Cell) -> bool {
        let apart = self.index + self.ring <= other.index || other.index + other.ring <= self.index;
        let same_ring = (self.index, self.ring) == (other.index, other.ring);
        self.store == other.store && !apart && (!same_ring || self.phase == other.phase)
    }
}

/// Something that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operand {
    /// A constant.
    Const(Bits),
    /// A cell.
    Cell(Cell),
}

/// The work of one unit or one wire in one cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The stage whose predicate must be set; `None` in VLIW code and where nothing can go wrong.
    pub stage: Option<u32>,
    /// The computation.
    pub action: Action,
    /// Type of the result; `None` where there is none. A narrow value is written into the low lane
    /// of a wide cell and leaves the other lanes as they are.
    pub ty: Option<Ty>,
    /// Where the result goes.
    pub dests: Vec<Cell>,
    /// When it goes there; always in place in kernels.
    pub landing: Landing,
    /// The part of the machine that does it.
    pub origin: Origin,
    /// Where it comes from.
    pub at: Position,
}

/// The part of the machine that does a [`Step`]. Engines need not know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A unit: an operation, or a move through it.
    Unit {
        /// The unit.
        unit: Fu,
        /// Cycles until the result stands in its places, 1 where there is none.
        latency: u32,
    },
    /// A link or a wire: a transfer into a register file.
    Over {
        /// The link, or the last of the wires.
        carrier: Carrier,
        /// Cycles until the value stands in the file.
        latency: u32,
    },
    /// A value that was made before comes nearer to its place.
    Way,
}

/// When the result of a step is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Landing {
    /// By the step itself: no later step of the cycle reads what it writes.
    InPlace,
    /// By the sequencer, at the end of the n-th cycle (≥ 1), this one being the first.
    After(u32),
}

/// The computation of a [`Step`].
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// An operation.
    Op {
        /// Which.
        op: Opcode,
        /// Its operands.
        operands: Vec<Operand>,
        /// The immediate.
        imm: i32,
    },
    /// The value of a cell.
    Copy(Cell),
}

/// The operations that the VLIW engine issues in one cycle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BundleSpec {
    /// The operations, a port operation first.
    pub steps: Vec<Step>,
    /// The control transfer; it reads its registers before any step writes.
    pub control: Option<(Control, Position)>,
}

/// Control transfers, as [`srp_ir::dre::scheduled::Control`] with everything looked up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Control {
    /// To a bundle.
    Jump(u32),
    /// To bundle `target` if predicate `cond` is `sense`.
    Branch {
        /// The predicate.
        cond: Cell,
        /// Taken if it has this value.
        sense: bool,
        /// Where to.
        target: u32,
    },
    /// To a bundle, with the way back in `link`.
    Call {
        /// Where to.
        target: u32,
        /// Where the way back is written.
        link: Cell,
        /// The bundle to come back to.
        back: u32,
        /// Cycles until `link` is written.
        latency: u32,
    },
    /// To the function whose address is in `target`, with the way back in `link`.
    CallReg {
        /// The address.
        target: Cell,
        /// Where the way back is written.
        link: Cell,
        /// The bundle to come back to.
        back: u32,
        /// Cycles until `link` is written.
        latency: u32,
    },
    /// To the bundle whose number is in a cell.
    Return(Cell),
    /// Runs a kernel.
    Launch(u32),
    /// Ends the program with the status in a cell.
    Halt(Cell),
    /// Traps: must not be reached.
    Unreachable,
    /// Traps: the stack has run into the data below it.
    StackOverflow,
}

/// A kernel: what the array does in each cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct KernelSpec {
    /// Its name.
    pub name: String,
    /// The loop statement.
    pub at: Position,
    /// Initiation interval.
    pub ii: u32,
    /// Cycles from the issue of an iteration until all its results have landed.
    pub length: u32,
    /// Cycles of the mode switch before the array starts, setting of registers included.
    pub enter_cycles: u32,
    /// Cycles of the mode switch back.
    pub leave_cycles: u32,
    /// Operations of an iteration, without moves.
    pub operations: u32,
    /// The trip count.
    pub trip: Cell,
    /// Registers set at entry, in order; rotating files are at their physical register.
    pub preloads: Vec<Preset>,
    /// After how many iterations all rings are back at their first register.
    pub unroll: u32,
    /// The steps of each of the `ii` cycles between the beginnings of two iterations.
    pub contexts: Vec<Vec<Step>>,
}

/// A register set when a kernel is entered.
#[derive(Clone, Debug, PartialEq)]
pub struct Preset {
    /// The register.
    pub cell: Cell,
    /// Its value.
    pub value: Operand,
    /// Its type.
    pub ty: Ty,
}

/// Stages that can overlap: stage predicates are the bits of a `u64`.
pub const MAX_STAGES: u32 = 64;

impl SimSpec {
    /// The store of a cell.
    pub fn store(&self, cell: Cell) -> &Store {
        &self.stores[cell.store as usize]
    }

    /// The index of a cell among those of all stores, as things are when iteration `n` has begun,
    /// but for rotating stores, which are taken to be at their first iteration.
    pub fn flat(&self, cell: Cell, n: u32) -> u32 {
        self.store(cell).base + cell.index + (n + cell.phase) % cell.ring
    }

    /// A source position as text, `None` for nowhere.
    pub fn position(&self, at: Position) -> Option<&str> {
        self.positions
            .get(at as usize)
            .map(String::as_str)
            .filter(|text| !text.is_empty())
    }

    /// The function that a bundle belongs to: the last one to start at it or before.
    pub fn function_of(&self, bundle: u32) -> Option<&str> {
        self.functions
            .iter()
            .filter(|(_, entry)| *entry <= bundle)
            .max_by_key(|(_, entry)| *entry)
            .map(|(name, _)| name.as_str())
    }
}

impl Step {
    /// The cells that are read.
    pub fn reads(&self) -> impl Iterator<Item = Cell> + '_ {
        let (operands, copied) = match &self.action {
            Action::Op { operands, .. } => (operands.as_slice(), None),
            Action::Copy(cell) => (&[][..], Some(*cell)),
        };
        let operands = operands.iter().filter_map(|operand| match operand {
            Operand::Cell(cell) => Some(*cell),
            Operand::Const(_) => None,
        });
        operands.chain(copied)
    }

    /// The opcode, unless it is a copy.
    pub fn opcode(&self) -> Option<Opcode> {
        match self.action {
            Action::Op { op, .. } => Some(op),
            Action::Copy(_) => None,
        }
    }
}

impl BundleSpec {
    /// True if it has a port operation, which is then its first step.
    pub fn talks(&self) -> bool {
        let first = self.steps.first().and_then(Step::opcode);
        first.is_some_and(|op| op.info().effect == Effect::Io)
    }

    /// How many operations it has, the control transfer included.
    pub fn operations(&self) -> usize {
        self.steps.len() + usize::from(self.control.is_some())
    }

    /// The kernel that it launches.
    pub fn launches(&self) -> Option<u32> {
        match self.control {
            Some((Control::Launch(kernel), _)) => Some(kernel),
            _ => None,
        }
    }
}

impl KernelSpec {
    /// The stores that its steps use.
    pub fn stores(&self) -> BTreeSet<u32> {
        let steps = self.contexts.iter().flatten();
        let cells = steps.flat_map(|step| step.reads().chain(step.dests.iter().copied()));
        cells.map(|cell| cell.store).collect()
    }

    /// Its times, for an engine whose contexts begin anew after `repetitions` iterations.
    pub fn times(&self, repetitions: u32) -> KernelTimes {
        KernelTimes {
            ii: self.ii,
            contexts: self.ii * repetitions,
            length: self.length,
            enter_cycles: self.enter_cycles,
            leave_cycles: self.leave_cycles,
            operations: self.operations,
        }
    }
}
