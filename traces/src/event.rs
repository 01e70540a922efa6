//! The one form of what happens in a trace, which all writers read.

use srp_archdesc::isa::Effect;
use srp_csimgen::Record;
use srp_csimgen::preamble::ops::V4;
use srp_csimgen::spec::{Action, Control, Position, Step};
use srp_runtime::core::Activity;
use srp_runtime::memory::cache::CacheCounters;
use srp_runtime::system::{MemoryRequest, Stall};
use srp_runtime::tni::{Buffers, HitRecord, Occupancy, RayCost, TniCounters};

/// Something that happens. Events come in the order of their cycles; those of one cycle first the registers as they
/// are from this cycle on, then what is done in it.
#[derive(Clone, Copy, Debug)]
pub struct Event<'t> {
    /// The SRP cycle.
    pub cycle: u64,
    /// The core.
    pub core: u32,
    /// What.
    pub what: What<'t>,
}

/// What happens.
#[derive(Clone, Copy, Debug)]
pub enum What<'t> {
    /// A register has this value from this cycle on. Cells of rotating files are in their physical order.
    Cell(u32, V4),
    /// The same of a register that is set for a kernel, and the cell that its value comes from, but for constants.
    Preset(u32, V4, Option<u32>),
    /// The core does this from this cycle on.
    Does(Doing),
    /// The core advances: it issues a bundle or does a context. Its steps follow.
    Turn(Turn),
    /// The control transfer of the bundle.
    Control(&'t Control, Position),
    /// A step is done.
    Step(Done<'t>),
    /// An event of the parts round the core.
    Outside(&'t Outside),
}

/// What a core is busy with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doing {
    /// It runs.
    Runs(Activity),
    /// It stands still.
    Stands(Stall),
}

/// What has its turn in a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// A bundle of VLIW code.
    Bundle(u32),
    /// A context of a kernel.
    Context {
        /// The kernel.
        kernel: u32,
        /// Cycles since an iteration has begun.
        slot: u32,
        /// The iteration that has begun last.
        iteration: u64,
        /// Bit `s`: whether stage `s` has an iteration.
        stages: u64,
    },
}

/// A step that is done, with its values.
#[derive(Clone, Copy, Debug)]
pub struct Done<'t> {
    /// The step.
    pub step: &'t Step,
    /// Its operands, as many as it has.
    pub operands: [V4; 3],
    /// The cells that they come from, but for constants.
    pub sources: [Option<u32>; 3],
    /// Its result; nothing where it has none.
    pub value: V4,
    /// The cells that it writes, at the end of this cycle or when it lands.
    pub dests: &'t [u32],
    /// The iteration that it belongs to.
    pub iteration: Option<u64>,
}

/// An event of the parts round a core, as the system's observer has it.
#[derive(Clone, Debug)]
pub enum Outside {
    /// The core takes a tile, by its number in the frame, or there is none left.
    Tile(Option<u32>),
    /// A packet of rays goes to the T&I unit.
    PacketSent(Box<Packet>),
    /// The core takes its hits, which are in the order of the hit buffer.
    PacketReturned(u64, Vec<HitRecord>),
    /// The T&I unit gives back a ray.
    Ray(RayCost),
    /// A cache asks the memory.
    Requested(MemoryRequest),
    /// Where the rays of the T&I unit are from this cycle on.
    Occupancy(Box<Occupancy>),
    /// Counts so far: of the data cache, the texture cache, and the T&I unit.
    Counts(Box<(CacheCounters, CacheCounters, TniCounters)>),
}

/// A packet of rays.
#[derive(Clone, Debug)]
pub struct Packet {
    /// Its number: the first of the core is 0.
    pub number: u64,
    /// Where its rays are, and where their hits go.
    pub buffers: Buffers,
    /// The ray buffer's contents.
    pub rays: Vec<u8>,
}

impl Doing {
    /// What a core does, in a word, and the kernel that it runs.
    pub fn in_words(self) -> (&'static str, Option<u32>) {
        match self {
            Doing::Runs(Activity::Vliw) => ("vliw", None),
            Doing::Runs(Activity::Array(kernel)) => ("array", Some(kernel)),
            Doing::Runs(Activity::Switch) => ("switch", None),
            Doing::Runs(Activity::Wait(_)) => ("wait", None),
            Doing::Runs(Activity::Halted(_)) => ("halted", None),
            Doing::Stands(Stall::Data) => ("memory_stall", None),
            Doing::Stands(Stall::Texture) => ("texture_stall", None),
            Doing::Stands(Stall::Instructions) => ("instruction_stall", None),
            Doing::Stands(Stall::Contexts) => ("context_stall", None),
            Doing::Stands(Stall::Banks) => ("sram_stall", None),
        }
    }
}

impl Outside {
    /// The records that take as much memory.
    pub(crate) fn records(&self) -> usize {
        let more = match self {
            Outside::PacketSent(packet) => packet.rays.len(),
            Outside::PacketReturned(_, hits) => size_of_val(hits.as_slice()),
            _ => 0,
        };
        4 + more / size_of::<Record>()
    }
}

impl Done<'_> {
    /// The address of an access to memory, if one is made.
    pub fn address(&self) -> Option<u32> {
        let Action::Op { imm, .. } = &self.step.action else {
            return None;
        };
        let is_made = is_access(self.step) && self.operands[0].as_pred();
        is_made.then(|| self.operands[1].as_word().wrapping_add(*imm as u32))
    }
}

/// The parts of a T&I unit with the rays in them: the unit's name, the part's, rays.
pub fn parts(occupancy: &Occupancy) -> impl Iterator<Item = (String, &'static str, u32)> + '_ {
    let trvs = occupancy.trvs.iter().enumerate().flat_map(|(i, trv)| {
        let parts = [
            ("resident", trv.resident),
            ("fifo", trv.fifo),
            ("rau", trv.rau),
            ("pre", trv.pre),
            ("aabb", trv.aabb),
            ("post", trv.post),
        ];
        parts.map(|(part, rays)| (format!("trv{i}"), part, rays))
    });
    let ists = occupancy.ists.iter().enumerate().flat_map(|(i, ist)| {
        let parts = [("fifo", ist.fifo), ("rau", ist.rau), ("pipe", ist.pipe)];
        parts.map(|(part, rays)| (format!("ist{i}"), part, rays))
    });
    trvs.chain(ists)
}

/// True if a step reads or writes memory.
pub fn is_access(step: &Step) -> bool {
    let effect = step.opcode().map(|op| op.info().effect);
    matches!(effect, Some(Effect::Load | Effect::Store))
}
