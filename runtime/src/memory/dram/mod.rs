//! System memory as a device that takes time.
//!
//! [`Dram`] is the border: requests go in, and come out when they are over. Behind it is either
//! [`FixedLatency`], or [`Banked`]: banks with rows ([`mod@device`]) behind controllers that reorder.

mod bank_queue;
mod banked;
mod channel;
pub mod device;
mod fixed;
pub mod mapping;
mod report;
pub mod trace;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use srp_archdesc::dram::{DramModel, DramSpec};

pub use banked::Banked;
pub use fixed::{FixedLatency, INTERLEAVE};
pub use report::{ChannelReport, DramReport};

/// One access to system memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request {
    /// First byte.
    pub address: u32,
    /// How many bytes.
    pub bytes: u32,
    /// True if it writes.
    pub is_write: bool,
    /// Who asks: given back with the answer.
    pub source: u32,
}

/// Counts of a memory. Cycles are those of its clock.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct DramCounters {
    /// Requests that read, as all below counted when they are answered.
    pub reads: u64,
    /// Requests that wrote.
    pub writes: u64,
    /// Bytes read.
    pub bytes_read: u64,
    /// Bytes written.
    pub bytes_written: u64,
    /// Cycles from request to answer, summed over the reads.
    pub read_cycles: u64,
    /// The most of them that a read took.
    pub max_read_cycles: u64,
    /// Each channel.
    pub channels: Vec<ChannelCounters>,
}

impl DramCounters {
    /// Counts an answer, given so many cycles after the request.
    fn answered(&mut self, request: &Request, cycles: u64) {
        if request.is_write {
            self.writes += 1;
            self.bytes_written += u64::from(request.bytes);
        } else {
            self.reads += 1;
            self.bytes_read += u64::from(request.bytes);
            self.read_cycles += cycles;
            self.max_read_cycles = self.max_read_cycles.max(cycles);
        }
    }

    /// Adds the counts of another memory, whose channels follow those that are here.
    pub fn add(&mut self, other: &DramCounters) {
        self.add_requests(other);
        self.channels.extend_from_slice(&other.channels);
    }

    /// Adds, channel by channel, the counts of the same memory, or one like it, at another time.
    pub fn add_run(&mut self, other: &DramCounters) {
        self.add_requests(other);
        let channels = self.channels.len().max(other.channels.len());
        self.channels.resize(channels, ChannelCounters::default());
        for (channel, other) in self.channels.iter_mut().zip(&other.channels) {
            channel.add(other);
        }
    }

    fn add_requests(&mut self, other: &DramCounters) {
        self.reads += other.reads;
        self.writes += other.writes;
        self.bytes_read += other.bytes_read;
        self.bytes_written += other.bytes_written;
        self.read_cycles += other.read_cycles;
        self.max_read_cycles = self.max_read_cycles.max(other.max_read_cycles);
    }
}

/// Counts of a channel. All but `busy_cycles` stay 0 in a memory without banks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ChannelCounters {
    /// Read commands.
    pub reads: u64,
    /// Write commands.
    pub writes: u64,
    /// Rows opened.
    pub activates: u64,
    /// Banks closed, by a command or behind an access.
    pub precharges: u64,
    /// Refreshes of all banks.
    pub refreshes: u64,
    /// Read commands that were not the first access to their row since it was opened.
    pub read_row_hits: u64,
    /// The same for write commands.
    pub write_row_hits: u64,
    /// Bursts read from bytes that wait to be written.
    pub forwarded_reads: u64,
    /// Bursts read together with an earlier request.
    pub joined_reads: u64,
    /// Bursts written together with an earlier request.
    pub merged_writes: u64,
    /// Bursts read, by a command or without one.
    pub read_bursts: u64,
    /// Cycles from the acceptance of a burst to its last data, summed over the bursts read.
    pub read_cycles: u64,
    /// The most of them that a burst took.
    pub max_read_cycles: u64,
    /// Cycles in which data moved.
    pub busy_cycles: u64,
    /// Bursts in the controller's queues, summed over the cycles.
    pub queued_cycles: u64,
}

impl ChannelCounters {
    fn add(&mut self, other: &ChannelCounters) {
        self.reads += other.reads;
        self.writes += other.writes;
        self.activates += other.activates;
        self.precharges += other.precharges;
        self.refreshes += other.refreshes;
        self.read_row_hits += other.read_row_hits;
        self.write_row_hits += other.write_row_hits;
        self.forwarded_reads += other.forwarded_reads;
        self.joined_reads += other.joined_reads;
        self.merged_writes += other.merged_writes;
        self.read_bursts += other.read_bursts;
        self.read_cycles += other.read_cycles;
        self.max_read_cycles = self.max_read_cycles.max(other.max_read_cycles);
        self.busy_cycles += other.busy_cycles;
        self.queued_cycles += other.queued_cycles;
    }

    /// Read and write commands that found their row open, among all, from 0 to 1; 0 where there
    /// were none.
    pub fn row_hit_rate(&self) -> f64 {
        let hits = self.read_row_hits + self.write_row_hits;
        hits as f64 / (self.reads + self.writes).max(1) as f64
    }
}

/// A memory device. Its time is counted in cycles of its own clock and only goes forward.
pub trait Dram: Send {
    /// Takes a request in cycle `now`.
    ///
    /// # Errors
    ///
    /// Where it has no room: a later cycle, in which the request can be offered again, and before
    /// which there will be no room for it.
    fn offer(&mut self, now: u64, request: Request) -> Result<(), u64>;

    /// Simulates up to and including cycle `now`. Adds requests that are over to `done`, each
    /// with the cycle in which its last data moved, in order of these cycles.
    fn advance(&mut self, now: u64, done: &mut Vec<(u64, Request)>);

    /// A cycle before which [`advance`](Self::advance) has nothing to give; `None` where all
    /// requests are answered.
    fn next_event(&self) -> Option<u64>;

    /// Its counts so far.
    fn counters(&self) -> DramCounters;
}

/// A memory of one of the models that there are.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Memory {
    /// Every request takes as long.
    Fixed(FixedLatency),
    /// Banks, rows and a controller.
    Banked(Box<Banked>),
}

impl Memory {
    /// The memory that a machine names.
    pub fn new(spec: &DramSpec) -> Memory {
        match &spec.model {
            DramModel::Fixed => Memory::Fixed(FixedLatency::new(spec)),
            DramModel::Banked(banked) => Memory::Banked(Box::new(Banked::new(spec, banked))),
        }
    }

    fn model(&self) -> &dyn Dram {
        match self {
            Memory::Fixed(memory) => memory,
            Memory::Banked(memory) => &**memory,
        }
    }

    fn model_mut(&mut self) -> &mut dyn Dram {
        match self {
            Memory::Fixed(memory) => memory,
            Memory::Banked(memory) => &mut **memory,
        }
    }
}

impl Dram for Memory {
    fn offer(&mut self, now: u64, request: Request) -> Result<(), u64> {
        self.model_mut().offer(now, request)
    }

    fn advance(&mut self, now: u64, done: &mut Vec<(u64, Request)>) {
        self.model_mut().advance(now, done);
    }

    fn next_event(&self) -> Option<u64> {
        self.model().next_event()
    }

    fn counters(&self) -> DramCounters {
        self.model().counters()
    }
}

/// Whole cycles of a clock that so many nanoseconds take.
fn cycles(ns: u32, mhz: u32) -> u64 {
    (u64::from(ns) * u64::from(mhz)).div_ceil(1000)
}
