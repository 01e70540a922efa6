//! System memory as a device that takes time.
//!
//! [`Dram`] is the border: requests go in, and come out when they are over. [`FixedLatency`] is
//! the simplest device behind it.

use std::collections::VecDeque;

use serde::Serialize;
use srp_archdesc::system::DramSpec;

/// Neighbouring stretches of this many bytes lie in different channels.
pub const INTERLEAVE: u32 = 64;

/// One access to system memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// First byte.
    pub address: u32,
    /// How many bytes.
    pub bytes: u32,
    /// Whether it writes.
    pub is_write: bool,
    /// Who asks: given back with the answer.
    pub source: u32,
}

/// What a device did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct DramCounters {
    /// Requests that read.
    pub reads: u64,
    /// Requests that wrote.
    pub writes: u64,
    /// Bytes read.
    pub bytes_read: u64,
    /// Bytes written.
    pub bytes_written: u64,
    /// Cycles in which a channel moved data, summed over the channels.
    pub busy_cycles: u64,
    /// Cycles from request to answer, summed over the reads.
    pub read_cycles: u64,
}

/// A memory device. Its time is counted in cycles of its own clock and only goes forward.
pub trait Dram: Send {
    /// Takes a request in cycle `now`; `false` where it has no room and must be offered again.
    fn offer(&mut self, now: u64, request: Request) -> bool;

    /// Simulates up to and including cycle `now`. Adds requests that are over to `done`, each
    /// with the cycle in which its last data moved, in order of these cycles.
    fn advance(&mut self, now: u64, done: &mut Vec<(u64, Request)>);

    /// A cycle before which [`advance`](Self::advance) has nothing to give; `None` where the
    /// device is idle.
    fn next_event(&self) -> Option<u64>;

    /// What it did so far.
    fn counters(&self) -> DramCounters;
}

/// A device in which every access takes the same time, and each channel moves at most two words
/// of its width a cycle.
#[derive(Clone, Debug)]
pub struct FixedLatency {
    latency: u64,
    bytes_per_cycle: u32,
    /// For each channel: the cycle from which it is free, and what it is going to answer.
    channels: Vec<(u64, VecDeque<(u64, Request)>)>,
    counters: DramCounters,
}

impl FixedLatency {
    /// An idle device.
    pub fn new(spec: &DramSpec) -> FixedLatency {
        let cycles = (u64::from(spec.latency_ns) * u64::from(spec.mhz)).div_ceil(1000);
        FixedLatency {
            latency: cycles,
            bytes_per_cycle: (spec.bits / 4).max(1),
            channels: vec![(0, VecDeque::new()); spec.channels.max(1) as usize],
            counters: DramCounters::default(),
        }
    }
}

impl Dram for FixedLatency {
    fn offer(&mut self, now: u64, request: Request) -> bool {
        let channels = self.channels.len() as u32;
        let (free, queue) = &mut self.channels[(request.address / INTERLEAVE % channels) as usize];
        let burst = u64::from(request.bytes.div_ceil(self.bytes_per_cycle));
        let over = (now + self.latency).max(*free) + burst;
        *free = over;
        queue.push_back((over, request));
        let counters = &mut self.counters;
        counters.busy_cycles += burst;
        if request.is_write {
            counters.writes += 1;
            counters.bytes_written += u64::from(request.bytes);
        } else {
            counters.reads += 1;
            counters.bytes_read += u64::from(request.bytes);
            counters.read_cycles += over - now;
        }
        true
    }

    fn advance(&mut self, now: u64, done: &mut Vec<(u64, Request)>) {
        let before = done.len();
        for (_, queue) in &mut self.channels {
            while let Some(answer) = queue.pop_front_if(|(over, _)| *over <= now) {
                done.push(answer);
            }
        }
        // Stable: of answers in one cycle, the first channel's comes first.
        done[before..].sort_by_key(|(over, _)| *over);
    }

    fn next_event(&self) -> Option<u64> {
        let fronts = self.channels.iter().filter_map(|(_, q)| q.front());
        fronts.map(|(over, _)| *over).min()
    }

    fn counters(&self) -> DramCounters {
        self.counters
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPEC: DramSpec = DramSpec {
        mhz: 800,
        channels: 2,
        bits: 32,
        latency_ns: 100,
    };

    fn read(address: u32) -> Request {
        Request {
            address,
            bytes: 64,
            is_write: false,
            source: 0,
        }
    }

    #[test]
    fn one_read_takes_latency_and_burst() {
        let mut dram = FixedLatency::new(&SPEC);
        assert!(dram.offer(5, read(0)));
        // 100 ns are 80 cycles of 1.25 ns; 64 bytes are 8 cycles of two 4-byte words.
        assert_eq!(dram.next_event(), Some(93));
        let mut done = Vec::new();
        dram.advance(92, &mut done);
        assert!(done.is_empty());
        dram.advance(93, &mut done);
        assert_eq!(done, [(93, read(0))]);
        assert_eq!(dram.next_event(), None);
    }

    #[test]
    fn a_channel_moves_its_peak_rate_and_channels_run_side_by_side() {
        let mut dram = FixedLatency::new(&SPEC);
        for i in 0..100 {
            dram.offer(0, read(64 * i));
        }
        let mut done = Vec::new();
        dram.advance(u64::MAX, &mut done);
        assert_eq!(done.len(), 100);
        assert_eq!(done.last().map(|d| d.0), Some(80 + 50 * 8));
        assert!(done.is_sorted_by_key(|d| d.0));
    }
}
