//! [`Arch`]: one SGRT system, the SRP array and the units round it, every name resolved and every
//! default filled in. It is what a machine file means; nothing downstream sees XML.

use crate::cost::operator;
use crate::cost::pipeline;
use crate::cost::special::{self as cost, Builds};
use crate::datapath::rcp_depth;
use crate::entity;
use crate::entity::EntityMap;
use crate::isa::{Class, Opcode, Ty};
use crate::structure::Special;
use crate::system::SystemSpec;
use serde::{Deserialize, Serialize};

pub use crate::precision::{Approx, Fast, NARROWED, Precision, Refine, Subnormals, U};

entity! {
    /// A functional unit of the array.
    Fu = "fu";
    /// A register file.
    RegFile = "rf";
    /// A link from one functional unit's output to another's inputs.
    Link = "link";
    /// A wire that one of several values takes in each cycle.
    Wire = "wire";
    /// A resource that several functional units share.
    Resource = "res";
}

/// A machine: SRPs, and the units round them.
///
/// Made only by [`parse`](crate::parse).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Arch {
    /// The machine's name.
    pub name: String,
    /// The SRP of each core.
    pub srp: Srp,
    /// How exact its special functions are.
    pub precision: Precision,
    /// Structures, shared datapaths and costs of special functions, as far as the file gives them.
    pub builds: Builds,
    /// The units round it.
    pub system: SystemSpec,
}

/// The SRP: an array of functional units, the first of which are the slots of the VLIW engine too.
/// It is all that a scheduler sees of a machine.
///
/// Always holds: names are unique in their kind; every entity mentioned exists; latencies and
/// intervals are at least 1; where there are VLIW slots, they run between them all that control code
/// needs ([`Class::ALL`]), and there is a central file for each type. An SRP without slots is an
/// array alone, onto which graphs can be mapped but not programs compiled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Srp {
    /// Rows of the array.
    pub rows: u32,
    /// Columns of the array.
    pub cols: u32,
    /// Functional units, row by row.
    pub fus: EntityMap<Fu, FuSpec>,
    /// Register files.
    pub files: EntityMap<RegFile, FileSpec>,
    /// Links between functional units.
    pub links: EntityMap<Link, LinkSpec>,
    /// Wires behind multiplexers: those of switches, buses, and ports of crossbars.
    pub wires: EntityMap<Wire, WireSpec>,
    /// How many wires a value passes in one cycle, at most (≥ 1): the clock limits it.
    pub hops: u32,
    /// Shared resources.
    pub resources: EntityMap<Resource, ResourceSpec>,
    /// Depth of the configuration memory: the largest II times the unrolling of a kernel.
    pub contexts: u32,
    /// True if all kernels of a program share that depth, and a launch of one whose contexts are not there brings them
    /// from system memory. Else the memory has that depth for each of them, and all are there from the start.
    pub shared_contexts: bool,
    /// SRP cycles to change between VLIW and array mode, each way.
    pub mode_switch: u32,
    /// How many registers of the array a kernel's entry can set per cycle.
    pub preload_width: u32,
    /// Cycles after a branch's own before its target issues.
    pub branch_delay: u32,
}

impl Srp {
    /// The classes that no unit runs and that [software](Class::has_software) stands in for.
    pub fn in_software(&self) -> Vec<Class> {
        let lacks = |class: &Class| self.fus.values().all(|fu| fu.op(*class).is_none());
        let classes = Class::ALL.iter().copied();
        classes
            .filter(|class| class.has_software() && lacks(class))
            .collect()
    }

    /// The least latency of a class on any unit; `None` where no unit runs it.
    pub fn least_latency(&self, class: Class) -> Option<u32> {
        let ways = self.fus.values().filter_map(|fu| fu.op(class));
        ways.map(|how| how.latency).min()
    }
}

/// One functional unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FuSpec {
    /// Its name, `fu_<row>_<column>` unless the file names it.
    pub name: String,
    /// Row, from 0 at the top.
    pub row: u32,
    /// Column, from 0 at the left.
    pub col: u32,
    /// Widest value its output register holds, in bits: 32 or 128. Narrower values fit as well.
    pub width: u32,
    /// True if predicates have an output register of their own; where not, they travel through
    /// the data output as 0 or 1.
    pub pred_out: bool,
    /// Constants of words and vectors that one context word can carry. Those of predicates are part
    /// of the operation.
    pub constants: u32,
    /// The VLIW issue slot that this unit is, if it is one.
    pub slot: Option<u32>,
    /// The operations it runs, sorted by class.
    pub ops: Vec<FuOp>,
}

impl FuSpec {
    /// How this unit runs operations of `class`, or `None` where it does not. Special functions may
    /// run differently each: see [`timing`](Self::timing).
    pub fn op(&self, class: Class) -> Option<&FuOp> {
        self.ops.iter().find(|o| o.class == class)
    }

    /// How this unit runs `op`, or `None` where it does not: it lacks the class, or it is narrower
    /// than an operand or the result.
    pub fn runs(&self, op: Opcode) -> Option<&FuOp> {
        let fits = |ty: Ty| ty.bits() <= self.width;
        let info = op.info();
        let mut operands = info.operands.iter().map(|kind| kind.ty());
        self.timing(op)
            .filter(|_| operands.all(fits) && op.result().is_none_or(fits))
    }

    /// How this unit runs operations of the class of `op`, and `op` of them; however wide it is.
    pub fn timing(&self, op: Opcode) -> Option<&FuOp> {
        let how = self.op(op.class())?;
        (!how.missing.contains(&op)).then(|| how.of(op))
    }
}

/// How one unit runs one class of operations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FuOp {
    /// The class.
    pub class: Class,
    /// Cycles from issue until the result can be read (≥ 1).
    pub latency: u32,
    /// Cycles from issue until this unit can issue any operation again (≥ 1; 1 is fully pipelined).
    pub interval: u32,
    /// Shared resources taken for `interval` cycles from issue.
    pub uses: Vec<Resource>,
    /// Operations of the class that run differently, for their units are built so. They have none.
    pub special: Vec<SpecialOp>,
    /// Operations of the class for which the machine has no unit: fast functions that it does not describe.
    pub missing: Vec<Opcode>,
    /// True where the machine file gives latency, or interval: then the class has them at any clock, and its special
    /// functions whatever their structure.
    pub given: [bool; 2],
}

impl FuOp {
    /// A class of which nothing special is said.
    pub const fn new(class: Class, latency: u32, interval: u32) -> FuOp {
        FuOp {
            class,
            latency,
            interval,
            uses: Vec::new(),
            special: Vec::new(),
            missing: Vec::new(),
            given: [false; 2],
        }
    }

    /// How `op` of this class runs.
    pub fn of(&self, op: Opcode) -> &FuOp {
        let special = self.special.iter().find(|special| special.op == op);
        special.map_or(self, |special| &special.how)
    }

    /// The shortest interval of an operation of this class.
    fn shortest_interval(&self) -> u32 {
        let special = self.special.iter().map(|special| special.how.interval);
        special.min().unwrap_or(self.interval)
    }
}

/// An operation that runs differently from the rest of its class.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpecialOp {
    /// The operation.
    pub op: Opcode,
    /// How it runs.
    pub how: FuOp,
}

/// A register file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FileSpec {
    /// Its name.
    pub name: String,
    /// Width of a register in bits: 1, 32 or 128.
    pub width: u32,
    /// Number of registers.
    pub size: u32,
    /// The kind of file.
    pub kind: FileKind,
    /// Registers that can be read in one cycle, by all readers together.
    pub read_ports: u32,
    /// Registers that can be written in one cycle, by all writers together.
    pub write_ports: u32,
    /// Units whose operand multiplexers can take a register of this file.
    pub readers: Vec<Fu>,
    /// Units whose results can be written into it.
    pub writers: Vec<Fu>,
    /// True if a value that arrives at a writer's inputs over a link or a wire can be written into the
    /// file without passing through the unit.
    pub from_links: bool,
}

impl FileSpec {
    /// True if a value of this type fits in one of its registers.
    pub fn holds(&self, ty: Ty) -> bool {
        ty.bits() <= self.width
    }
}

/// Kinds of register files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FileKind {
    /// Shared by the VLIW slots and the array: live-in and live-out values pass through it.
    Central,
    /// Local to the array, addressed relative to a base that advances with every iteration.
    Rotating,
    /// Local to the array, plain addressing.
    Static,
}

/// A directed link: in cycle `t` unit `to` sees what the output of `from` was in `t - delay`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LinkSpec {
    /// The unit whose output it carries.
    pub from: Fu,
    /// The unit whose operand multiplexers (and local files, see [`FileSpec::from_links`]) it feeds.
    pub to: Fu,
    /// Registers along it.
    pub delay: u32,
    /// Widest value it carries, in bits: 1 for a link of the predicate network alone.
    pub width: u32,
}

/// A wire with a multiplexer before it, which every context sets: in cycle `t` units in `to`, and wires
/// that have this one among their inputs, see what the input chosen for `t - delay` had then. It keeps nothing.
///
/// A value that passes several wires without registers passes them in one cycle, [`Srp::hops`] of them at
/// most. No choice of inputs that leads a wire back to itself within a cycle may be made, though a machine
/// may be able to make it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WireSpec {
    /// Its name; no unit has the same.
    pub name: String,
    /// The inputs of its multiplexer, at least one, none twice.
    pub from: Vec<Input>,
    /// The units whose operand multiplexers (and local files, see [`FileSpec::from_links`]) it feeds.
    pub to: Vec<Fu>,
    /// Registers at its end.
    pub delay: u32,
    /// Widest value it carries, in bits: 1 for predicates only.
    pub width: u32,
}

/// An input of a wire's multiplexer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Input {
    /// The output of a unit.
    Unit(Fu),
    /// Another wire.
    Wire(Wire),
}

/// The carrier of a value from an output to those that read it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Carrier {
    /// A link.
    Link(Link),
    /// A wire, the last of those that the value passes.
    Wire(Wire),
}

/// A resource that several units share, such as a memory port.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResourceSpec {
    /// Its name.
    pub name: String,
    /// How many uses fit in one cycle.
    pub count: u32,
}

impl Arch {
    /// Returns cycles, area and energy of the unit of a special function of the SRP, the quickest that there is.
    pub fn special_unit(&self, special: Special) -> cost::Unit {
        let op = special.opcodes()[0];
        let intervals = self
            .srp
            .fus
            .values()
            .filter_map(|fu| Some(fu.timing(op)?.interval));
        self.special_unit_every(special, intervals.min().unwrap_or(1))
    }

    /// The same of a unit that takes an operation every so many cycles, where these do not follow from how it is built.
    pub(crate) fn special_unit_every(&self, special: Special, interval: u32) -> cost::Unit {
        let (approx, build) = (self.precision.of(special), self.builds.of(special));
        cost::unit(special, approx, build, self.system.srp_mhz_at_65nm()).taking(interval)
    }

    /// Lets the cycles of classes follow from the clock, and those of special functions from their structure and
    /// precision, where the machine gives none, and those of the triangle test with its reciprocal; and notes which
    /// fast functions there are. Whoever changes any of them calls it.
    pub fn derive_cycles(&mut self) {
        let units = self.precision.specials();
        let units: Vec<_> = units.map(|s| (s, self.special_unit(s))).collect();
        let mhz = self.system.srp_mhz_at_65nm();
        for fu in self.srp.fus.values_mut() {
            for how in &mut fu.ops {
                let (latency, interval) = pipeline::natural(how.class, mhz);
                if !how.given[1] {
                    how.interval = interval;
                }
                if !how.given[0] {
                    how.latency = latency.max(how.interval);
                }
                let mut all = Vec::new();
                for (special, unit) in &units {
                    let build = self.builds.of(*special);
                    let follows = |number: Option<u32>, given: bool| number.filter(|_| !given);
                    let latency = build.latency.or(follows(unit.latency, how.given[0]));
                    let interval = build.interval.or(follows(unit.interval, how.given[1]));
                    let of_class = special
                        .opcodes()
                        .iter()
                        .filter(|op| op.class() == how.class);
                    all.extend(of_class.map(|&op| SpecialOp {
                        op,
                        how: FuOp {
                            uses: how.uses.clone(),
                            ..FuOp::new(
                                how.class,
                                latency.unwrap_or(how.latency),
                                interval.unwrap_or(how.interval),
                            )
                        },
                    }));
                }
                let floats = self.precision.formats;
                let narrow = Opcode::ALL.iter().filter(|op| op.class() == how.class);
                all.extend(narrow.filter(|_| !how.given[0]).map(|&op| {
                    SpecialOp {
                        op,
                        how: FuOp {
                            uses: how.uses.clone(),
                            ..FuOp::new(
                                how.class,
                                operator::cycles_in(
                                    floats.of(op).significand,
                                    how.class,
                                    how.latency,
                                )
                                .max(how.interval),
                                how.interval,
                            )
                        },
                    }
                }));
                let as_others = (how.latency, how.interval);
                all.retain(|s| (s.how.latency, s.how.interval) != as_others);
                how.special = all;
                let class = how.class;
                let missing = Special::ALL.into_iter().filter(|&s| !self.precision.has(s));
                let missing = missing.flat_map(|s| s.opcodes()).copied();
                how.missing = missing.filter(|op| op.class() == class).collect();
            }
        }
        let mhz = self.system.tni_mhz_at_65nm();
        let tni = &mut self.system.tni;
        let unit = cost::unit(Special::Rcp, tni.rcp, &tni.rcp_build, mhz);
        let rcp = unit.latency.unwrap_or_else(|| rcp_depth(mhz));
        tni.ist_latency = (tni.ist_latency + rcp)
            .saturating_sub(tni.rcp_latency)
            .max(1);
        tni.rcp_latency = rcp;
        tni.rcp_interval = unit.interval.unwrap_or(1);
        tni.derive_latencies(mhz);
    }
}

impl Srp {
    /// Registers along a link or at the end of a wire.
    pub fn delay(&self, carrier: Carrier) -> u32 {
        match carrier {
            Carrier::Link(link) => self.links[link].delay,
            Carrier::Wire(wire) => self.wires[wire].delay,
        }
    }

    /// The unit of VLIW slot `slot`.
    pub fn slot(&self, slot: u32) -> Option<Fu> {
        self.fus
            .iter()
            .find(|(_, f)| f.slot == Some(slot))
            .map(|(fu, _)| fu)
    }

    /// The units that are VLIW slots, in slot order.
    pub fn slots(&self) -> Vec<Fu> {
        let mut slots: Vec<_> = self
            .fus
            .iter()
            .filter_map(|(fu, f)| f.slot.map(|s| (s, fu)))
            .collect();
        slots.sort();
        slots.into_iter().map(|(_, fu)| fu).collect()
    }

    /// The central register file that VLIW code keeps values of type `ty` in: the narrowest one
    /// that holds them, the first of equals.
    pub fn central(&self, ty: Ty) -> Option<RegFile> {
        self.files
            .iter()
            .filter(|(_, f)| f.kind == FileKind::Central && f.holds(ty))
            .min_by_key(|(file, f)| (f.width, *file))
            .map(|(file, _)| file)
    }

    /// Peak floating-point operations per cycle of one core: each unit's busiest class, where a
    /// fused multiply-add counts 2 a lane and a unit that issues every n-th cycle counts 1/n.
    pub fn peak_flops_per_cycle(&self) -> f64 {
        self.fus
            .values()
            .map(|fu| {
                fu.ops
                    .iter()
                    .map(|o| f64::from(flops(o.class)) / f64::from(o.shortest_interval()))
                    .fold(0.0, f64::max)
            })
            .sum()
    }
}

/// Floating-point operations that one instruction of a class stands for.
fn flops(class: Class) -> u32 {
    match class {
        Class::Fadd | Class::Fmul | Class::Fdiv | Class::Sfu | Class::Fast => 1,
        Class::Fma => 2,
        Class::Pair => 4,
        Class::Vpair => 16,
        Class::Vfadd | Class::Vfmul => 4,
        Class::Vdot => 7,
        Class::Vfma => 8,
        _ => 0,
    }
}
