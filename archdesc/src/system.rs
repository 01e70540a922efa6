//! [`SystemSpec`]: the units round the array. Sizes are bytes, clocks MHz, latencies cycles of the
//! unit's own clock unless the name says otherwise.

use crate::cost::FO4_PS;
use crate::cost::special::Build;
use crate::datapath::{FpLatency, Intersection};
use crate::dram::DramSpec;
use crate::precision::Approx;
use serde::{Deserialize, Serialize};

/// The units round the SRP array.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SystemSpec {
    /// SGRT cores: each one SRP and one T&I unit.
    pub cores: u32,
    /// Tiles on each side of the blocks in which cores get them, at most; 1: tile by tile, in rows.
    pub tile_block: u32,
    /// Clock of the SRP, MHz.
    pub srp_mhz: u32,
    /// Clock of the T&I unit, MHz.
    pub tni_mhz: u32,
    /// Delay of an inverter with a fan-out of four, ps: how quick the gates of the chip are. [`FO4_PS`] at 65 nm.
    pub fo4_ps: u32,
    /// SRAM of one core.
    pub sram_bytes: u32,
    /// Banks of the SRAM that accesses of a cycle compete for. Without them every access finds its place free.
    pub sram_banks: Option<BankSpec>,
    /// Data cache of one core's cached loads and stores.
    pub data_cache: CacheSpec,
    /// Texture cache of one core.
    pub texture_cache: CacheSpec,
    /// Instruction cache of one core's VLIW engine. Without one its code is in a memory of its own, which is never
    /// waited for.
    pub instruction_cache: Option<CacheSpec>,
    /// Ray and hit buffers between SRP and T&I unit.
    pub buffers: BufferSpec,
    /// The T&I unit.
    pub tni: TniSpec,
    /// The bus between the cores and the memory.
    pub bus: BusSpec,
    /// System memory.
    pub dram: DramSpec,
}

impl SystemSpec {
    /// The clock of the SRP in the gates of 65 nm, MHz: the one at which as many of them fit in a cycle.
    pub fn srp_mhz_at_65nm(&self) -> u32 {
        self.at_65nm(self.srp_mhz)
    }

    /// That of the T&I unit.
    pub fn tni_mhz_at_65nm(&self) -> u32 {
        self.at_65nm(self.tni_mhz)
    }

    fn at_65nm(&self, mhz: u32) -> u32 {
        (mhz * self.fo4_ps / FO4_PS as u32).max(1)
    }
}

/// Most banks of an SRAM.
pub const MAX_SRAM_BANKS: u32 = 64;

/// Banks of an SRAM: words of `width` bytes take turns among them. Each bank does one access a cycle; where a cycle has
/// more of one bank, the core stands still until all are done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BankSpec {
    /// Banks, a power of two up to [`MAX_SRAM_BANKS`].
    pub count: u32,
    /// Bytes of a bank's word, a power of two.
    pub width: u32,
    /// True if the T&I unit takes rays and gives hits through these banks too: all of them are its own while a packet
    /// moves, and the core stands still. Else the unit has ports of its own.
    pub shared: bool,
}

impl std::fmt::Display for BankSpec {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let banks = if self.count == 1 { "bank" } else { "banks" };
        write!(f, "{} {banks} of {} bytes", self.count, self.width)
    }
}

impl BankSpec {
    /// Cycles in which so many bytes go through all banks.
    pub fn cycles(&self, bytes: u64) -> u64 {
        bytes.div_ceil(u64::from(self.count * self.width))
    }
}

/// One set-associative cache, least recently used line replaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CacheSpec {
    /// Capacity.
    pub bytes: u32,
    /// Ways per set.
    pub ways: u32,
    /// Line size.
    pub line: u32,
    /// Cycles of a hit (≥ 1).
    pub latency: u32,
    /// Banks that can each be asked once a cycle.
    pub banks: u32,
    /// Misses that may be outstanding.
    pub misses: u32,
    /// Of the caches of the SRP: true if a load that misses freezes the core at once, until its line is there. Else
    /// the core runs on, and freezes where the value of a load is due and its line is not there, or where a load
    /// misses while as many misses as may be are outstanding. The T&I unit's caches never block, and have `false`.
    pub blocking: bool,
}

impl CacheSpec {
    /// Number of sets.
    pub fn sets(&self) -> u32 {
        self.bytes / (self.ways * self.line)
    }
}

/// Bytes of a ray as kernels write it and the T&I unit reads it.
pub const RAY_BYTES: u32 = 64;

/// Bytes of a hit as the T&I unit writes it and kernels read it.
pub const HIT_BYTES: u32 = 24;

/// Ray and hit buffers (SGRT section 3.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BufferSpec {
    /// Rays of one buffer, which is the size of a packet.
    pub rays: u32,
    /// Ray buffers.
    pub ray_buffers: u32,
    /// Hit buffers.
    pub hit_buffers: u32,
    /// Bytes of a ray, [`RAY_BYTES`].
    pub ray_bytes: u32,
    /// Bytes of a hit, [`HIT_BYTES`].
    pub hit_bytes: u32,
}

/// The traversal and intersection unit (SGRT section 3.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TniSpec {
    /// Traversal units.
    pub trvs: u32,
    /// Intersection units.
    pub ists: u32,
    /// One deep traversal pipeline or three parallel sub-pipelines.
    pub pipeline: Pipeline,
    /// TRV_PRE sub-pipelines of one traversal unit; 1 in a single pipeline, as of the next two.
    pub pres: u32,
    /// TRV_AABB sub-pipelines.
    pub aabbs: u32,
    /// TRV_POST sub-pipelines.
    pub posts: u32,
    /// Rays resident in one traversal unit, each with a stack.
    pub stacks: u32,
    /// Entries of one stack.
    pub stack_depth: u32,
    /// Which of the next four are given; the others follow from the unit's operators.
    pub given: GivenLatencies,
    /// Cycles through node fetch and classification (TRV_PRE), without the cache.
    pub pre_latency: u32,
    /// Cycles through the ray–box test (TRV_AABB).
    pub aabb_latency: u32,
    /// Cycles through the stack operation (TRV_POST).
    pub post_latency: u32,
    /// Cycles through the ray–triangle test.
    pub ist_latency: u32,
    /// Entries of the FIFOs between sub-pipelines and units.
    pub fifo: u32,
    /// Rows of a ray accumulation unit: distinct lines waited for.
    pub rau_rows: u32,
    /// Rays that one row can hold.
    pub rau_rays: u32,
    /// Level-1 cache of one traversal unit.
    pub trv_l1: CacheSpec,
    /// Level-2 cache shared by the traversal units.
    pub trv_l2: CacheSpec,
    /// Level-1 cache of one intersection unit.
    pub ist_l1: CacheSpec,
    /// How the boxes of nodes are stored.
    pub node_format: NodeFormat,
    /// Bytes of a node in memory, at least those of the format.
    pub node_bytes: u32,
    /// Bytes of a triangle record in memory.
    pub triangle_bytes: u32,
    /// Precision of the reciprocal in the ray–triangle test.
    pub rcp: Approx,
    /// Its build, as the file describes it.
    pub rcp_build: Build,
    /// Cycles through it.
    pub rcp_latency: u32,
    /// Cycles until it can take the next operand: so many are between two tests of an intersection unit.
    pub rcp_interval: u32,
    /// The ray–triangle test.
    pub intersection: Intersection,
    /// True if a ray for which any hit will do ends with its first.
    pub any_hit: bool,
}

/// What a machine file says of the latencies of a T&I unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GivenLatencies {
    /// That of TRV_PRE.
    pub pre: bool,
    /// That of TRV_AABB.
    pub aabb: bool,
    /// That of TRV_POST.
    pub post: bool,
    /// That of the ray–triangle test.
    pub ist: bool,
    /// Those of the operators; `None` where they follow from the clock.
    pub operators: Option<FpLatency>,
}

impl GivenLatencies {
    /// All four are given.
    pub const ALL: GivenLatencies = GivenLatencies {
        pre: true,
        aabb: true,
        post: true,
        ist: true,
        operators: None,
    };
}

impl TniSpec {
    /// Gives the traversal units another form; the single one has one of each sub-pipeline.
    pub fn set_pipeline(&mut self, pipeline: Pipeline) {
        self.pipeline = pipeline;
        if pipeline == Pipeline::Single {
            (self.pres, self.aabbs, self.posts) = (1, 1, 1);
        }
    }

    /// Rays that a traversal unit lets in, at most: more could stand in each other's way for ever.
    ///
    /// A ray stands still only where the FIFO behind its pipeline is full. Then it passes the pipeline again, and one out of
    /// the FIFO in front enters where a stage is free. So rays stand still for ever only round a ring of pipelines of which
    /// every stage and the FIFO behind it are taken. The rings are box tests back to the fetch of nodes (parallel form
    /// only), these through stack operations, and leaves through the intersection units, whose places all traversal units
    /// share. One ray less than the smallest of them holds leaves a place free in each.
    pub fn most_in_flight(&self) -> u32 {
        let fifo = self.fifo.max(1);
        let pre = fifo + self.pres.max(1) * (self.pre_latency + self.trv_l1.latency);
        let aabb = fifo + self.aabbs.max(1) * self.aabb_latency;
        let post = fifo + self.posts.max(1) * self.post_latency;
        let ist = self.ists.max(1) * (fifo + self.ist_latency + self.ist_l1.latency);
        let boxes = match self.pipeline {
            Pipeline::Single => pre + aabb + post,
            Pipeline::Parallel => pre + aabb,
        };
        let leaves = match self.pipeline {
            Pipeline::Single => pre + aabb + post + ist / self.trvs.max(1),
            Pipeline::Parallel => pre + post + ist / self.trvs.max(1),
        };
        boxes.min(leaves) - 1
    }
}

/// Forms of the traversal unit (SGRT Figure 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Pipeline {
    /// One deep pipeline; rays bypass the stages they do not need.
    Single,
    /// TRV_PRE, TRV_AABB and TRV_POST side by side with a crossbar.
    Parallel,
}

/// How the boxes of nodes are stored; what does not fit is rounded outward.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum NodeFormat {
    /// Corners in binary32.
    F32,
    /// Corners in binary16.
    F16,
    /// Corners of two siblings as multiples, 8 bits each, of powers of two from a common corner.
    Q8,
}

impl NodeFormat {
    /// All of them.
    pub const ALL: [NodeFormat; 3] = [NodeFormat::F32, NodeFormat::F16, NodeFormat::Q8];

    /// Its name in machine files.
    pub const fn name(self) -> &'static str {
        match self {
            NodeFormat::F32 => "f32",
            NodeFormat::F16 => "f16",
            NodeFormat::Q8 => "q8",
        }
    }

    /// Bytes of a node: its box, half of the data that the boxes of two siblings share, and a reference of 8.
    #[inline]
    pub const fn bytes(self) -> u32 {
        match self {
            NodeFormat::F32 => 32,
            NodeFormat::F16 => 20,
            NodeFormat::Q8 => 24,
        }
    }
}

/// The bus between cores and memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BusSpec {
    /// Bytes moved per bus cycle.
    pub width: u32,
    /// Bus clock, MHz.
    pub mhz: u32,
    /// Cycles from request to memory, and again from memory back.
    pub latency: u32,
}
