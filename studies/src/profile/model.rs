//! The profile as data.

use super::timeline::Timeline;
use crate::energy::Use;
use crate::settings;
use schemars::JsonSchema;
use serde::Serialize;
use srp_runtime::tni::{LevelCounts, StallAccount};
use std::ops::AddAssign;

/// A line of a source file; file `""` and line 0 stand for what no line is known of.
pub(super) type Line = (String, u32);

/// SRP cycles by what they were spent on. All of them sum to the cycles of the cores until their programs ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Parts {
    /// Bundles of VLIW code with an operation.
    pub vliw: u64,
    /// Bundles without one: results or branches that are waited for.
    pub empty: u64,
    /// Loops on the array.
    pub array: u64,
    /// Changes between VLIW engine and array.
    pub switch: u64,
    /// Standing still for the data cache.
    pub memory_stall: u64,
    /// Standing still for the texture cache alone.
    pub texture_stall: u64,
    /// Standing still for the instruction cache.
    pub instruction_stall: u64,
    /// Standing still for the contexts of a loop.
    pub context_stall: u64,
    /// Standing still for banks of the SRAM.
    pub sram_stall: u64,
    /// Waiting for ports: for the T&I unit, in a frame.
    pub wait: u64,
}

impl Parts {
    /// How many parts there are.
    pub const COUNT: usize = 10;

    /// The parts with their names, in this order everywhere.
    pub fn named(&self) -> [(&'static str, u64); Parts::COUNT] {
        [
            ("VLIW", self.vliw),
            ("empty", self.empty),
            ("array", self.array),
            ("switch", self.switch),
            ("memory", self.memory_stall),
            ("texture", self.texture_stall),
            ("instructions", self.instruction_stall),
            ("contexts", self.context_stall),
            ("banks", self.sram_stall),
            ("wait", self.wait),
        ]
    }

    /// All cycles.
    pub fn total(&self) -> u64 {
        self.named().iter().map(|(_, cycles)| cycles).sum()
    }

    pub(super) fn add(&mut self, other: &Parts) {
        *self += *other;
    }
}

impl AddAssign for Parts {
    fn add_assign(&mut self, other: Parts) {
        self.vliw += other.vliw;
        self.empty += other.empty;
        self.array += other.array;
        self.switch += other.switch;
        self.memory_stall += other.memory_stall;
        self.texture_stall += other.texture_stall;
        self.instruction_stall += other.instruction_stall;
        self.context_stall += other.context_stall;
        self.sram_stall += other.sram_stall;
        self.wait += other.wait;
    }
}

/// Where the cycles of a program went.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Profile {
    /// The machine's name, which the envelope of a document has.
    #[serde(skip)]
    pub machine: String,
    /// Cores that ran the program.
    pub cores: u32,
    /// All cycles of all cores.
    pub parts: Parts,
    /// Functions with their own code and the loops that they launch, most cycles first. What was inlined is part
    /// of its caller.
    pub functions: Vec<FunctionProfile>,
    /// Loops on the array, most cycles first.
    pub loops: Vec<LoopProfile>,
    /// Lines that took cycles, by file and number. They sum to all cycles.
    pub lines: Vec<LineProfile>,
    /// Cycles of each line in each function and loop: what the other lists are sums of. By function, loop and line.
    pub code: Vec<CodeProfile>,
    /// The work of the caches and T&I units of a frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<FrameProfile>,
    /// What the cores of a frame did in the course of time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub timeline: Option<Timeline>,
    /// What to do about the largest costs of a frame, the largest first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub advice: Vec<Advice>,
}

/// What to do about a cost.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Advice {
    /// Its part of all cycles, from 0 to 1: more is not to be had.
    pub share: f64,
    /// The reason, in a sentence.
    pub reason: String,
    /// What to change, in a sentence.
    pub change: String,
    /// Attributes of the machine and their values, as `srp sweep --set` takes them.
    pub set: Vec<(String, String)>,
}

impl Advice {
    /// The arguments that set them.
    pub fn arguments(&self) -> Vec<String> {
        let set = self.set.iter();
        set.map(|(attribute, value)| settings::argument(&format!("{attribute}={value}")))
            .collect()
    }
}

/// The words that stand for the name where there is no function.
pub const BEFORE_ALL: &str = "before all functions";

/// The cycles of a function.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct FunctionProfile {
    /// Its name; empty for code that belongs to none, before all functions.
    pub name: String,
    /// Its cycles.
    #[serde(flatten)]
    pub parts: Parts,
}

impl FunctionProfile {
    /// Its name, or words for what belongs to no function.
    pub fn shown(&self) -> &str {
        match self.name.as_str() {
            "" => BEFORE_ALL,
            name => name,
        }
    }
}

/// The cycles of a loop on the array.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct LoopProfile {
    /// Its name.
    pub kernel: String,
    /// Its place, `file:line:column`.
    pub at: Option<String>,
    /// Initiation interval.
    pub ii: u32,
    /// Cycles of an iteration.
    pub length: u32,
    /// How often it was launched.
    pub launches: u64,
    /// How often it went round.
    pub iterations: Iterations,
    /// Its cycles.
    #[serde(flatten)]
    pub parts: Parts,
}

/// Iterations of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Iterations {
    /// Of all launches.
    pub all: u64,
    /// The fewest of a launch.
    pub fewest: u64,
    /// The most of a launch.
    pub most: u64,
}

/// The cycles of a source line.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct LineProfile {
    /// The file's name, empty where none is known.
    pub file: String,
    /// The line, from 1; 0 where none is known.
    pub line: u32,
    /// Its cycles.
    #[serde(flatten)]
    pub parts: Parts,
}

/// The cycles of a source line in one function, as VLIW code or in one loop on the array.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CodeProfile {
    /// The function, or that which launches the loop; empty for what comes before all functions.
    pub function: String,
    /// The loop on the array.
    pub kernel: Option<String>,
    /// The file's name, empty where none is known.
    pub file: String,
    /// The line, from 1; 0 where none is known.
    pub line: u32,
    /// Its cycles.
    #[serde(flatten)]
    pub parts: Parts,
}

/// The work of the caches and T&I units of a frame.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct FrameProfile {
    /// Objects in system memory that were read or written, those first for which cores stood still longest.
    pub objects: Vec<ObjectProfile>,
    /// Lines of the source whose loads and samples missed, by object.
    pub accesses: Vec<AccessProfile>,
    /// Rays by the material that they hit; an empty name stands for none.
    pub materials: Vec<MaterialProfile>,
    /// Levels of the tree, that of the root first.
    pub levels: Vec<LevelCounts>,
    /// Energy by what took it, most first: loops, control code, objects in memory, and parts of the machine.
    pub energy: Vec<Use>,
    /// Energy of what lines of the source do, by file and number.
    pub energy_of_lines: Vec<LineEnergy>,
    /// Pipelines of the T&I units.
    pub pipelines: Vec<PipelineProfile>,
}

/// The energy of a source line: of its operations on the array, of its bundles, and of the bytes that its misses
/// moved.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct LineEnergy {
    /// The file's name, empty where none is known.
    pub file: String,
    /// The line, from 1; 0 where none is known.
    pub line: u32,
    /// mJ at 65 nm.
    pub mj: f64,
}

/// An object in system memory.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct ObjectProfile {
    /// Its name.
    pub object: String,
    /// Its size.
    pub bytes: u64,
    /// SRP cycles that cores stood still for its lines.
    pub stall: u64,
    /// Bytes that the memory gave data caches.
    pub by_data: u64,
    /// Bytes that it gave texture caches.
    pub by_texture: u64,
    /// Bytes that it gave T&I units.
    pub by_tni: u64,
    /// Bytes written.
    pub written: u64,
}

/// The misses of a source line in one object.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct AccessProfile {
    /// The file's name, empty where none is known.
    pub file: String,
    /// The line, from 1; 0 where none is known.
    pub line: u32,
    /// The object.
    pub object: String,
    /// Lines of memory that it asked for.
    pub misses: u64,
    /// Their bytes.
    pub bytes: u64,
    /// SRP cycles that cores stood still for them.
    pub stall: u64,
}

/// The rays whose hits are of one material.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct MaterialProfile {
    /// Its name; empty for rays that hit nothing.
    pub material: String,
    /// The rays.
    pub rays: u64,
    /// T&I cycles from dispatch to result, summed over them.
    pub cycles: u64,
    /// Nodes that they visited.
    pub visits: u64,
    /// Triangles that they tested.
    pub tests: u64,
}

/// The pipelines of one kind, of all T&I units.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct PipelineProfile {
    /// Its name.
    pub pipeline: String,
    /// How many there are in a core.
    pub count: u32,
    /// T&I cycles of the first stage by what they were spent on.
    #[serde(flatten)]
    pub account: StallAccount,
}
