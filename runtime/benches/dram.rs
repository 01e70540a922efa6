//! How fast the memory is simulated: `cargo bench -p srp-runtime --bench dram`.

use std::time::Instant;

use srp_archdesc::dram::presets;
use srp_runtime::memory::dram::trace::{self, Offer};
use srp_runtime::memory::dram::{Memory, Request};

/// Random reads and writes of 64 bytes, one every `gap` cycles.
fn random(count: u64, gap: u64) -> Vec<Offer> {
    let mut state = 1u64;
    let offer = |i| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let request = Request {
            address: (state >> 33) as u32 & !63,
            bytes: 64,
            is_write: state >> 60 == 0,
            source: 0,
        };
        let cycle = i * gap;
        Offer { request, cycle }
    };
    (0..count).map(offer).collect()
}

fn main() {
    for preset in presets() {
        for (gap, count) in [
            (1, 500_000),
            (16, 500_000),
            (100, 200_000),
            (10_000, 20_000),
        ] {
            let trace = random(count, gap);
            let mut device = Memory::new(&preset.spec);
            let start = Instant::now();
            let replay = trace::replay(&mut device, trace.iter().copied(), None);
            let seconds = start.elapsed().as_secs_f64();
            println!(
                "{:18} a request every {gap:6} cycles: {:9.1} Mcycles/s, {:6.2} Mrequests/s",
                preset.name,
                replay.cycles as f64 / seconds / 1e6,
                replay.taken as f64 / seconds / 1e6
            );
        }
    }
}
