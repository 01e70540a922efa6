//! The work of a memory, in figures to read.

use schemars::JsonSchema;
use std::fmt::Write as _;

use serde::{Deserialize, Serialize};
use srp_archdesc::dram::DramSpec;

use super::DramCounters;
use crate::digits::thousands;

/// The work of one memory, or of the memories of all cores, in some time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DramReport {
    /// Its clock, MHz.
    pub mhz: u32,
    /// How many memories there are: one, or one for each core. The channels of each follow those
    /// of the one before.
    pub memories: u32,
    /// Cycles of its clock.
    pub cycles: u64,
    /// Gigabytes a second that the data lines of all channels could move.
    pub peak_gigabytes_per_second: f64,
    /// Gigabytes a second that were asked for and moved.
    pub gigabytes_per_second: f64,
    /// Nanoseconds from a read's arrival at the memory to its last data, on average.
    pub mean_read_ns: f64,
    /// The most that a read took.
    pub max_read_ns: f64,
    /// The work of the channels, as shares.
    pub channels: Vec<ChannelReport>,
    /// The figures that all this comes from.
    pub counters: DramCounters,
}

/// The work of one channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChannelReport {
    /// Gigabytes a second on its data lines: whole bursts.
    pub gigabytes_per_second: f64,
    /// Part of the time in which data moved, from 0 to 1.
    pub busy: f64,
    /// Accesses that found their row open, among all, from 0 to 1.
    pub row_hit_rate: f64,
    /// Bursts in the controller's queues, on average.
    pub queued: f64,
}

impl DramReport {
    /// The report of memories that are like `spec`, after so many cycles of their clock.
    pub fn of(spec: &DramSpec, memories: u32, cycles: u64, counters: DramCounters) -> DramReport {
        let cycle_ns = 1000.0 / f64::from(spec.mhz.max(1));
        let ns = cycles as f64 * cycle_ns;
        let ratio = |part: f64, all: f64| if all > 0.0 { part / all } else { 0.0 };
        // Two words of the channel's width in a cycle.
        let bytes_per_cycle = f64::from(spec.bits) / 4.0;
        let channels: Vec<ChannelReport> = (counters.channels.iter())
            .map(|c| ChannelReport {
                gigabytes_per_second: ratio(c.busy_cycles as f64 * bytes_per_cycle, ns),
                busy: ratio(c.busy_cycles as f64, cycles as f64),
                row_hit_rate: c.row_hit_rate(),
                queued: ratio(c.queued_cycles as f64, cycles as f64),
            })
            .collect();
        let bytes = counters.bytes_read + counters.bytes_written;
        DramReport {
            mhz: spec.mhz,
            memories,
            cycles,
            peak_gigabytes_per_second: channels.len() as f64 * bytes_per_cycle / cycle_ns,
            gigabytes_per_second: ratio(bytes as f64, ns),
            mean_read_ns: cycle_ns * ratio(counters.read_cycles as f64, counters.reads as f64),
            max_read_ns: cycle_ns * counters.max_read_cycles as f64,
            channels,
            counters,
        }
    }

    /// The report as text, for people.
    pub fn text(&self) -> String {
        let c = &self.counters;
        let mut out = format!(
            "memory: {} bytes read, {} written, {:.3} GB/s of {:.1}; reads take {:.1} ns, at most \
             {:.1}\n",
            thousands(c.bytes_read),
            thousands(c.bytes_written),
            self.gigabytes_per_second,
            self.peak_gigabytes_per_second,
            self.mean_read_ns,
            self.max_read_ns,
        );
        if c.channels
            .iter()
            .all(|channel| channel.reads + channel.writes == 0)
            && c.reads + c.writes > 0
        {
            out += "  channels and banks are not simulated: all accesses take the same time\n";
            return out;
        }
        let head = [
            "channel",
            "GB/s",
            "busy",
            "reads",
            "writes",
            "row hits",
            "opened",
            "refreshes",
            "queued",
        ];
        let mut line = |cells: [String; 9]| {
            let [name, rest @ ..] = cells;
            let widths = [7, 7, 12, 12, 8, 12, 9, 7];
            let _ = write!(out, "{name:16}");
            for (cell, width) in rest.iter().zip(widths) {
                let _ = write!(out, " {cell:>width$}");
            }
            out.push('\n');
        };
        line(head.map(str::to_owned));
        let per_memory = self.channels.len() / self.memories.max(1) as usize;
        for (i, (share, count)) in self.channels.iter().zip(&c.channels).enumerate() {
            let number = i % per_memory.max(1);
            let name = match self.memories {
                1 => number.to_string(),
                _ => format!("core {}, {number}", i / per_memory.max(1)),
            };
            line([
                name,
                format!("{:.3}", share.gigabytes_per_second),
                format!("{:.1} %", 100.0 * share.busy),
                thousands(count.reads),
                thousands(count.writes),
                format!("{:.1} %", 100.0 * share.row_hit_rate),
                thousands(count.activates),
                thousands(count.refreshes),
                format!("{:.2}", share.queued),
            ]);
        }
        out
    }
}
