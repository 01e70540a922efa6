//! [`ScheduledDre`]: where and when every operation runs. Data only: who made it does not matter.

use crate::dfg::{Dfg, Initial, Node};
use crate::program::{Bits, Kernel, Pos, SourceFile};
use serde::{Deserialize, Serialize};
use srp_archdesc::arch::{Carrier, Fu, Input, Link, RegFile, Wire};
use srp_archdesc::entity;
use srp_archdesc::entity::EntityMap;
use srp_archdesc::isa::{Opcode, Ty};

entity! {
    /// A bundle: what the VLIW engine issues in one cycle. Numbered through the whole program.
    Bundle = "b";
    /// A placed operation of a modulo schedule: a node or a routing move.
    Placed = "op";
}

/// A scheduled program for one machine.
///
/// Anybody may have made it, so nothing holds of it before [`check`](mod@crate::check) has seen it; a
/// [`Checked`](crate::check::Checked) is one that keeps the rules.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScheduledDre {
    /// The machine's name, for messages.
    pub machine: String,
    /// Names of the source files.
    pub files: EntityMap<SourceFile, String>,
    /// Initial contents of SRAM from address 0; the rest is zero.
    pub image: Vec<u8>,
    /// Addresses and sizes of the globals, by name, in address order.
    pub symbols: Vec<DataSymbol>,
    /// The VLIW code.
    pub bundles: EntityMap<Bundle, BundleData>,
    /// Entry bundles of the functions; function addresses are `FUNC_BASE + 4 · index` in this list.
    pub functions: Vec<FunctionEntry>,
    /// Where execution starts: sets up the stack, calls `main`, and halts with its result.
    pub start: Bundle,
    /// The kernels.
    pub kernels: EntityMap<Kernel, ModuloSchedule>,
}

/// The address of the first function; the others follow, 4 apart.
pub const FUNC_BASE: u32 = 0x4000_0000;

/// A global object in SRAM.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DataSymbol {
    /// Its name.
    pub name: String,
    /// Its address.
    pub address: u32,
    /// Its size in bytes.
    pub size: u32,
}

/// A function's first bundle.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FunctionEntry {
    /// Its name.
    pub name: String,
    /// Where it starts.
    pub bundle: Bundle,
}

/// A register.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Reg {
    /// Its file.
    pub file: RegFile,
    /// Its number.
    pub index: u32,
}

/// The operations that the VLIW engine issues in one cycle: at most one a slot, with at most one
/// control transfer. Operands are read at issue; results are written to their registers `latency`
/// cycles later. There are no interlocks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BundleData {
    /// Operations, by slot.
    pub ops: Vec<SlotOp>,
    /// The control transfer, if any. Its target issues `branch_delay + 1` cycles later; the bundles
    /// in between are issued in any case.
    pub control: Option<(Control, Pos)>,
}

/// An operation in a VLIW slot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SlotOp {
    /// The unit of the slot.
    pub fu: Fu,
    /// The opcode.
    pub op: Opcode,
    /// Its operands.
    pub srcs: Vec<Src>,
    /// The immediate.
    pub imm: i32,
    /// Where the result goes.
    pub dst: Option<Reg>,
    /// Where it comes from.
    pub pos: Pos,
}

/// An operand of VLIW code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Src {
    /// A register of a central file.
    Reg(Reg),
    /// A constant.
    Const(Bits),
}

/// Control transfers. All of them take a branch unit: that of the first slot with class `branch`
/// that is free.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Control {
    /// To a bundle.
    Jump(Bundle),
    /// To a bundle if the predicate register is `sense`, else on.
    Branch {
        /// The predicate register.
        cond: Reg,
        /// Taken if it has this value.
        sense: bool,
        /// Where to.
        target: Bundle,
    },
    /// To a function. The number of the bundle after the delay is written into the link register,
    /// where it stands from the cycle in which the target issues.
    Call {
        /// Its first bundle.
        target: Bundle,
        /// The link register.
        link: Reg,
    },
    /// To the function whose address is in a register; traps where it is none.
    CallReg {
        /// The register with the address.
        target: Reg,
        /// The link register.
        link: Reg,
    },
    /// To the bundle whose number is in a register.
    Return(Reg),
    /// Runs a kernel, then goes on with the next bundle. No delay: the mode switch is the cost.
    Launch(Kernel),
    /// The program ends with the status in this register.
    Halt(Reg),
    /// Must not be reached.
    Unreachable,
    /// Traps: the stack has run into the data below it.
    StackOverflow,
}

/// A modulo schedule: the kernel's configuration for the array.
///
/// Iteration `i` issues the operation placed at `time` in cycle `time + ii · i`; the operation is
/// active only in iterations `0 .. trip`, which stage predicates see to. The array runs for
/// `ii · (trip − 1) + length` cycles. Times and the meaning of places are those of
/// [`ResourceGraph`](srp_archdesc::ResourceGraph).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModuloSchedule {
    /// The loop that it implements.
    pub dfg: Dfg,
    /// Initiation interval.
    pub ii: u32,
    /// Cycles until everything that iteration 0 issued stands in its place.
    pub length: u32,
    /// Nodes and routing moves. The first `dfg.nodes.len()` are the nodes, in their order.
    pub ops: EntityMap<Placed, PlacedOp>,
    /// Values written from links and wires into files past a unit.
    pub transfers: Vec<PlacedTransfer>,
    /// Values taken by wires.
    pub hops: Vec<PlacedHop>,
    /// Registers set at entry, `preload_width` a cycle: loop invariants and initial values.
    pub preloads: Vec<Preload>,
    /// The central register of each live-in that the launch's caller has set, in their order.
    pub live_in_regs: Vec<Reg>,
    /// The central register where each live-out stands after the kernel, in their order.
    pub live_out_regs: Vec<Reg>,
}

/// A node or a routing move in its place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlacedOp {
    /// The node it is, or the node whose value it moves.
    pub node: Node,
    /// True if it is a routing move (the `mov` of the node's type) and not the node itself.
    pub is_move: bool,
    /// The unit.
    pub fu: Fu,
    /// Issue cycle in iteration 0.
    pub time: u32,
    /// Where each operand is taken from. A move has one.
    pub operands: Vec<Source>,
    /// Registers that the result is written into, besides the unit's output. At most one a file.
    pub writes: Vec<RegAt>,
}

/// Where an operand is taken from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// A constant of the context.
    Const(Bits),
    /// An output register: of the unit itself where `link` is `None`, else over that link. The
    /// predicate output if the operand is a predicate and the machine has one, else the data output.
    Out(Option<Link>),
    /// What a wire has, which it took as many cycles before as it has registers.
    Wire(Wire),
    /// A register that the unit can read, as iteration `i - distance` names it.
    Reg {
        /// The register.
        reg: RegAt,
        /// Iterations back.
        distance: u32,
    },
}

/// A register as an iteration names it. In iteration `i` it is register `(index + i) mod size` of a
/// rotating file, and register `index + (i mod ring)` of any other: `ring` of 1 is the same register
/// in every iteration, more is modulo variable expansion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct RegAt {
    /// The file.
    pub file: RegFile,
    /// The first register.
    pub index: u32,
    /// Registers of the ring; 1 in rotating files.
    pub ring: u32,
}

/// A value taken from a link or a wire into a file in one cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlacedTransfer {
    /// Whose value it is.
    pub node: Node,
    /// The link or wire it comes over.
    pub over: Carrier,
    /// The cycle of iteration 0 in which the value stands in the output at the link's start, or in which the
    /// wire takes it.
    pub time: u32,
    /// Where it goes; stands there from `time + delay + 1`.
    pub to: RegAt,
}

/// A value taken by a wire in one cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct PlacedHop {
    /// Whose value it is; its type says which output of a unit is taken.
    pub node: Node,
    /// The wire.
    pub wire: Wire,
    /// The input that it takes.
    pub from: Input,
    /// The cycle of iteration 0 in which it does; the wire takes this input in every cycle of the slot.
    pub time: u32,
}

/// A register set before the first iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Preload {
    /// The file.
    pub file: RegFile,
    /// The physical register.
    pub index: u32,
    /// The value: a constant, or a live-in taken from its central register; never [`Initial::Any`].
    pub value: Initial,
    /// Its storage.
    pub ty: Ty,
}

/// Modulo schedules without a program around them, as those of bare graphs are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScheduledLoops {
    /// The machine's name.
    pub machine: String,
    /// Files that positions name.
    pub files: EntityMap<SourceFile, String>,
    /// The schedules.
    pub loops: Vec<ModuloSchedule>,
}

impl RegAt {
    /// The physical register in iteration `i` (which may be negative), in a file of `size`
    /// registers that rotates or not.
    pub fn physical(self, i: i64, rotating: bool, size: u32) -> u32 {
        let (base, modulus) = if rotating {
            (0, size)
        } else {
            (self.index, self.ring)
        };
        let offset = if rotating {
            i64::from(self.index) + i
        } else {
            i
        };
        base + u32::try_from(offset.rem_euclid(i64::from(modulus.max(1))))
            .expect("a remainder is smaller than its modulus")
    }
}

impl ModuloSchedule {
    /// Number of stages: iterations that overlap.
    pub fn stages(&self) -> u32 {
        self.length.div_ceil(self.ii).max(1)
    }

    /// Contexts the kernel takes: `ii` times the least common multiple of all rings.
    pub fn contexts(&self) -> u32 {
        let rings = self.ops.values().flat_map(|op| {
            let reads = op.operands.iter().filter_map(|s| match s {
                Source::Reg { reg, .. } => Some(reg.ring),
                Source::Const(_) | Source::Out(_) | Source::Wire(_) => None,
            });
            reads.chain(op.writes.iter().map(|w| w.ring))
        });
        let rings = rings.chain(self.transfers.iter().map(|t| t.to.ring));
        self.ii * rings.fold(1, lcm)
    }
}

fn lcm(a: u32, b: u32) -> u32 {
    let (mut x, mut y) = (a, b);
    while y != 0 {
        (x, y) = (y, x % y);
    }
    a / x * b
}
