//! A memory at rest: the latency of a read that nothing delays, and a memory with this fixed latency.

use srp_archdesc::SystemSpec;
use srp_archdesc::dram::{DramModel, DramSpec};

use super::BASE;
use super::dram::{Dram, Memory, Request};
use super::path::Clock;

/// Reads whose mean is the latency.
const READS: u32 = 512;

/// Cycles of the memory between two of them, in which it comes to rest.
const REST: u64 = 4096;

/// The mean time of a read of a line that finds the machine's memory at rest, in ns: reads at places that
/// look random, one at a time.
pub fn unloaded_ns(spec: &SystemSpec) -> f64 {
    let mut memory = Memory::new(&spec.dram);
    let line = spec.tni.trv_l2.line;
    let (mut state, mut now, mut done) = (1u32, 0, Vec::new());
    let mut sum = 0;
    for _ in 0..READS {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let request = Request {
            address: BASE + (state >> 4) / line * line,
            bytes: line,
            is_write: false,
            source: 0,
        };
        let from = now;
        while let Err(later) = memory.offer(now, request) {
            now = later.max(now + 1);
            memory.advance(now, &mut done);
        }
        while done.is_empty() {
            now = memory.next_event().unwrap_or(now).max(now + 1);
            memory.advance(now, &mut done);
        }
        sum += done.drain(..).map(|(over, _)| over).max().unwrap_or(now) - from;
        now += REST;
        memory.advance(now, &mut done);
        done.clear();
    }
    sum as f64 / f64::from(READS) * 1e3 / f64::from(spec.dram.mhz)
}

/// Cycles of the T&I unit from a request to its line, where nothing else is on the way: bus, memory at
/// rest, and bus.
pub fn line_cycles(spec: &SystemSpec) -> u64 {
    let bus = Clock::new(spec.bus.mhz);
    let beats = spec.tni.trv_l2.line.div_ceil(spec.bus.width.max(1));
    let way = bus.start(u64::from(2 * spec.bus.latency + beats));
    Clock::new(spec.tni_mhz).cycle_from(way + (1e3 * unloaded_ns(spec)) as u64)
}

/// A memory with the clock and the width of a machine's, whose reads all take as long as those of the
/// machine's memory at rest.
pub fn with_fixed_latency(spec: &SystemSpec) -> DramSpec {
    if spec.dram.model == DramModel::Fixed {
        return spec.dram.clone();
    }
    // What moving the line takes comes on top.
    let bytes_per_cycle = (spec.dram.bits / 4).max(1);
    let moving = f64::from(spec.tni.trv_l2.line.div_ceil(bytes_per_cycle));
    let moving = moving * 1e3 / f64::from(spec.dram.mhz);
    DramSpec {
        latency_ns: (unloaded_ns(spec) - moving).max(0.0).round() as u32,
        model: DramModel::Fixed,
        ..spec.dram.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fixed_memory_answers_as_the_banks_do_at_rest() {
        for file in srp_archdesc::machines::ALL {
            let arch = srp_archdesc::parse(file.name, file.xml).expect("the machine is valid");
            let mut fixed = arch.system.clone();
            fixed.dram = with_fixed_latency(&arch.system);
            assert_eq!(fixed.dram.model, DramModel::Fixed);
            let (banks, fixed) = (unloaded_ns(&arch.system), unloaded_ns(&fixed));
            assert!(
                (banks - fixed).abs() < 3.0,
                "{}: {banks} {fixed}",
                file.name
            );
        }
    }
}
