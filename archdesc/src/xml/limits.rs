//! The named limits of a machine. They keep every derived size (places, links, tables of a
//! simulator) far from what a host cannot hold, and catch slips such as bytes for kilobytes.

/// The values an attribute may take, both ends included.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limit {
    /// The attribute.
    pub(super) name: &'static str,
    pub(super) min: u32,
    pub(super) max: u32,
    /// True if it is a size in bytes, for which `K` and `M` may be written.
    pub(super) bytes: bool,
}

const fn count(name: &'static str, min: u32, max: u32) -> Limit {
    Limit {
        name,
        min,
        max,
        bytes: false,
    }
}

const fn bytes(name: &'static str, min: u32, max: u32) -> Limit {
    Limit {
        name,
        min,
        max,
        bytes: true,
    }
}

pub(super) const ROWS: Limit = count("rows", 1, 64);
pub(super) const COLS: Limit = count("cols", 1, 64);
pub(super) const ROW: Limit = count("row", 0, 63);
pub(super) const COL: Limit = count("col", 0, 63);
pub(super) const CONTEXTS: Limit = count("contexts", 1, 4096);
pub(super) const LINK_DELAY: Limit = count("link-delay", 0, 8);
pub(super) const DELAY: Limit = count("delay", 0, 8);
pub(super) const WIRES: Limit = count("wires", 1, 64);
pub(super) const WIRE_DELAY: Limit = count("wire-delay", 0, 8);
pub(super) const HOPS: Limit = count("hops", 1, 16);
pub(super) const SLOTS: Limit = count("slots", 0, 64);
pub(super) const SLOT: Limit = count("slot", 0, 63);
pub(super) const BRANCH_DELAY: Limit = count("branch-delay", 0, 8);
pub(super) const MODE_SWITCH: Limit = count("mode-switch", 0, 1024);
pub(super) const PRELOAD_WIDTH: Limit = count("preload-width", 1, 64);
pub(super) const LATENCY: Limit = count("latency", 1, 64);
pub(super) const INTERVAL: Limit = count("interval", 1, 64);
pub(super) const CONSTANTS: Limit = count("constants", 0, 4);
pub(super) const RESOURCE_COUNT: Limit = count("count", 1, 256);
pub(super) const FILE_SIZE: Limit = count("size", 1, 1024);
pub(super) const READ_PORTS: Limit = count("read-ports", 1, 256);
pub(super) const WRITE_PORTS: Limit = count("write-ports", 1, 256);
pub(super) const APPROX_BITS: Limit = count("bits", 4, 23);
pub(super) const APPROX_STEPS: Limit = count("steps", 0, 3);
pub(super) const DATAPATH: Limit = count("datapath", 0, 15);
pub(super) const AREA: Limit = count("area-um2", 0, 1_000_000_000);
pub(super) const ENERGY: Limit = count("energy-fj", 0, 1_000_000_000);
pub(super) const DEGREE: Limit = count("degree", 1, 3);
pub(super) const SEGMENTS: Limit = count("segments", 1, 1 << crate::structure::MAX_SEGMENTS);
pub(super) const OFFSET_TABLES: Limit = count("tables", 1, 4);
pub(super) const RADIX: Limit = count("radix", 2, 16);

/// Links of one array, generated and written.
pub(super) const MAX_LINKS: usize = 65_536;

/// Wires of one array, generated and written.
pub(super) const MAX_WIRES: usize = 65_536;

/// Inputs and readers of all wires together.
pub(super) const MAX_WIRE_USERS: usize = 262_144;

/// Resources of one machine.
pub(super) const MAX_RESOURCES: usize = 64;

/// Register files that a unit has for itself.
pub(super) const MAX_LOCAL_FILES: usize = 8;

/// Readers and writers of all register files together.
pub(super) const MAX_FILE_USERS: usize = 262_144;

/// Characters of a name.
pub(super) const MAX_NAME: usize = 64;

pub(super) const CORES: Limit = count("cores", 1, 64);
pub(super) const TILE_BLOCK: Limit = count("tile-block", 1, 1024);
pub(super) const SRP_MHZ: Limit = count("srp-mhz", 1, 10_000);
pub(super) const TNI_MHZ: Limit = count("tni-mhz", 1, 10_000);
/// From gates beyond all technologies to those of tubes.
pub(super) const FO4_PS: Limit = count("fo4-ps", 1, 10_000);
pub(super) const MHZ: Limit = count("mhz", 1, 10_000);
pub(super) const SRAM_SIZE: Limit = bytes("size", 4 << 10, 64 << 20);
pub(super) const SRAM_BANKS: Limit = count("banks", 0, crate::system::MAX_SRAM_BANKS);
pub(super) const BANK_WIDTH: Limit = bytes("width", 4, 16);
pub(super) const CACHE_SIZE: Limit = bytes("size", 64, 64 << 20);
pub(super) const WAYS: Limit = count("ways", 1, 32);
pub(super) const LINE: Limit = bytes("line", 16, 512);
pub(super) const CACHE_LATENCY: Limit = count("latency", 1, 256);
pub(super) const BANKS: Limit = count("banks", 1, 64);
pub(super) const MISSES: Limit = count("misses", 1, 256);
pub(super) const WEIGHT_BITS: Limit = count("weight-bits", 0, 12);
pub(super) const RAYS: Limit = count("rays", 1, 4096);
pub(super) const RAY_BUFFERS: Limit = count("ray-buffers", 2, 64);
pub(super) const HIT_BUFFERS: Limit = count("hit-buffers", 1, 64);
pub(super) const RAY_BYTES: Limit = bytes("ray-bytes", 0, u32::MAX);
pub(super) const HIT_BYTES: Limit = bytes("hit-bytes", 0, u32::MAX);
pub(super) const TRVS: Limit = count("trvs", 1, 64);
pub(super) const ISTS: Limit = count("ists", 1, 64);
pub(super) const STACKS: Limit = count("stacks", 1, 1024);
pub(super) const STACK_DEPTH: Limit = count("stack-depth", 1, 1024);
pub(super) const PRE_LATENCY: Limit = count("pre-latency", 1, 256);
pub(super) const AABB_LATENCY: Limit = count("aabb-latency", 1, 256);
pub(super) const POST_LATENCY: Limit = count("post-latency", 1, 256);
pub(super) const IST_LATENCY: Limit = count("ist-latency", 1, 256);
pub(super) const FIFO: Limit = count("fifo", 1, 1024);
pub(super) const RAU_ROWS: Limit = count("rau-rows", 0, 1024);
pub(super) const RAU_RAYS: Limit = count("rau-rays", 1, 1024);
pub(super) const PRES: Limit = count("pres", 1, 16);
pub(super) const AABBS: Limit = count("aabbs", 1, 16);
pub(super) const POSTS: Limit = count("posts", 1, 16);
pub(super) const FP_ADD: Limit = count("add", 1, 32);
pub(super) const FP_MUL: Limit = count("mul", 1, 32);
pub(super) const FP_CMP: Limit = count("cmp", 1, 32);
pub(super) const FP_RCP: Limit = count("rcp", 1, 64);
pub(super) const NODE_BYTES: Limit = bytes("node-bytes", 32, 256);
pub(super) const TRIANGLE_BYTES: Limit = bytes("triangle-bytes", 48, 256);
pub(super) const BUS_WIDTH: Limit = bytes("width", 1, 256);
pub(super) const BUS_LATENCY: Limit = count("latency", 0, 1024);
pub(super) const CHANNELS: Limit = count("channels", 1, 64);
pub(super) const DRAM_BITS: Limit = count("bits", 8, 1024);
pub(super) const LATENCY_NS: Limit = count("latency-ns", 0, 100_000);
pub(super) const DRAM_BANKS: Limit = count("banks", 1, 64);
pub(super) const DRAM_ROWS: Limit = count("rows", 1, 1 << 24);
pub(super) const DRAM_COLUMNS: Limit = count("columns", 2, 1 << 16);
pub(super) const BURST: Limit = count("burst", 2, 64);
pub(super) const FIELD_BITS: Limit = count("mapping", 0, 24);
pub(super) const CL: Limit = count("cl", 1, 1024);
pub(super) const CWL: Limit = count("cwl", 1, 1024);
pub(super) const RCD: Limit = count("rcd", 1, 1024);
pub(super) const RP: Limit = count("rp", 1, 1024);
pub(super) const RAS: Limit = count("ras", 0, 1024);
pub(super) const RC: Limit = count("rc", 0, 1024);
pub(super) const RRD: Limit = count("rrd", 0, 1024);
pub(super) const FAW: Limit = count("faw", 0, 1024);
pub(super) const WTR: Limit = count("wtr", 0, 1024);
pub(super) const RTW: Limit = count("rtw", 0, 1024);
pub(super) const WR: Limit = count("wr", 0, 1024);
pub(super) const RTP: Limit = count("rtp", 0, 1024);
pub(super) const CCD: Limit = count("ccd", 0, 1024);
pub(super) const RFC: Limit = count("rfc", 0, 100_000);
pub(super) const REFI: Limit = count("refi", 0, 1_000_000);
pub(super) const READ_QUEUE: Limit = count("read-queue", 1, 1024);
pub(super) const WRITE_QUEUE: Limit = count("write-queue", 1, 1024);
pub(super) const COMMAND_QUEUE: Limit = count("command-queue", 1, 256);
pub(super) const ROW_HITS: Limit = count("row-hits", 1, 65_536);
pub(super) const WRITE_DRAIN: Limit = count("write-drain", 0, 1024);
