//! The simplest memory: every access takes the same time.

use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

use srp_archdesc::dram::DramSpec;

use super::{ChannelCounters, Dram, DramCounters, Request};

/// Neighbouring blocks of this many bytes lie in different channels.
pub const INTERLEAVE: u32 = 64;

/// A device in which every access takes the same time, and each channel moves at most two words
/// of its width a cycle. An access that crosses from one block of [`INTERLEAVE`] bytes into the
/// next is one for each, and over with the last.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FixedLatency {
    latency: u64,
    bytes_per_cycle: u32,
    /// For each channel: the cycle from which it is free.
    free: Vec<u64>,
    /// Answers to come: their cycle, the cycle in which they were asked for, and the request; in order of cycles.
    answers: VecDeque<(u64, u64, Request)>,
    counters: DramCounters,
}

impl FixedLatency {
    /// An idle device.
    pub fn new(spec: &DramSpec) -> FixedLatency {
        let channels = spec.channels.max(1) as usize;
        FixedLatency {
            latency: super::cycles(spec.latency_ns, spec.mhz),
            bytes_per_cycle: (spec.bits / 4).max(1),
            free: vec![0; channels],
            answers: VecDeque::new(),
            counters: DramCounters {
                channels: vec![ChannelCounters::default(); channels],
                ..DramCounters::default()
            },
        }
    }

    /// Moves the bytes of one block. Returns the cycle in which that is over.
    fn stretch(&mut self, now: u64, address: u32, bytes: u32) -> u64 {
        let channel = (address / INTERLEAVE) as usize % self.free.len();
        let burst = u64::from(bytes.div_ceil(self.bytes_per_cycle));
        let over = (now + self.latency).max(self.free[channel]) + burst;
        self.free[channel] = over;
        self.counters.channels[channel].busy_cycles += burst;
        over
    }
}

impl Dram for FixedLatency {
    fn offer(&mut self, now: u64, request: Request) -> Result<(), u64> {
        let (mut address, mut left) = (request.address, request.bytes);
        let mut over = now;
        loop {
            let bytes = left.min(INTERLEAVE - address % INTERLEAVE);
            over = over.max(self.stretch(now, address, bytes));
            left -= bytes;
            if left == 0 {
                break;
            }
            address = address.wrapping_add(bytes);
        }
        // Of answers in one cycle, the one that was asked for first comes first.
        let place = self.answers.partition_point(|(at, ..)| *at <= over);
        self.answers.insert(place, (over, now, request));
        Ok(())
    }

    fn advance(&mut self, now: u64, done: &mut Vec<(u64, Request)>) {
        while let Some(answer) = self.answers.pop_front_if(|(over, ..)| *over <= now) {
            let (over, from, request) = answer;
            self.counters.answered(&request, over - from);
            done.push((over, request));
        }
    }

    fn next_event(&self) -> Option<u64> {
        self.answers.front().map(|(over, ..)| *over)
    }

    fn counters(&self) -> DramCounters {
        self.counters.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use srp_archdesc::dram::FIXED;

    fn device() -> FixedLatency {
        FixedLatency::new(&DramSpec {
            latency_ns: 100,
            ..FIXED
        })
    }

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
        let mut dram = device();
        assert_eq!(dram.offer(5, read(0)), Ok(()));
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
        let mut dram = device();
        for i in 0..100 {
            assert_eq!(dram.offer(0, read(64 * i)), Ok(()));
        }
        let mut done = Vec::new();
        dram.advance(u64::MAX, &mut done);
        assert_eq!(done.len(), 100);
        assert_eq!(done.last().map(|d| d.0), Some(80 + 50 * 8));
        assert!(done.is_sorted_by_key(|d| d.0));
    }

    #[test]
    fn an_access_across_stretches_is_one_for_each() {
        let mut dram = device();
        assert_eq!(dram.offer(0, read(48)), Ok(()));
        // 16 bytes of channel 0 in 2 cycles, 48 bytes of channel 1 in 6.
        assert_eq!(dram.next_event(), Some(86));
        let busy: Vec<u64> = (dram.counters().channels.iter())
            .map(|c| c.busy_cycles)
            .collect();
        assert_eq!(busy, [2, 6]);
    }
}
