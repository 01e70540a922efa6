//! The traces of `../shared/dram`, and what DRAMsim3 answers.

use std::path::Path;

use srp_archdesc::dram::presets;
use srp_runtime::memory::dram::{Memory, trace};

/// Measurements of DRAMsim3 in the first `cycles` cycles of a trace: bursts read and written, mean latency of
/// a read in cycles, activations, and read commands that hit.
struct Reference {
    name: &'static str,
    cycles: u64,
    reads: u64,
    writes: u64,
    latency: f64,
    activates: u64,
    hits: u64,
}

const fn reference(
    name: &'static str,
    cycles: u64,
    (reads, writes): (u64, u64),
    latency: f64,
    activates: u64,
    hits: u64,
) -> Reference {
    Reference {
        name,
        cycles,
        reads,
        writes,
        latency,
        activates,
        hits,
    }
}

const REFERENCES: [Reference; 5] = [
    reference("random_gap2", 30_000, (11_411, 0), 338.14, 5_724, 5_706),
    reference("random_gap8", 80_000, (19_984, 0), 72.83, 10_013, 9_993),
    reference("random_gap16", 96_000, (11_994, 0), 56.98, 6_010, 5_998),
    reference("stream_gap4", 48_000, (12_088, 0), 190.21, 103, 11_989),
    reference("mixed_gap8", 80_000, (13_260, 6_728), 98.19, 10_027, 6_627),
];

#[track_caller]
fn within(what: &str, ours: f64, theirs: f64, percent: f64) {
    let off = 100.0 * (ours / theirs - 1.0);
    println!("  {what}: {ours:.2}, DRAMsim3 {theirs:.2}, {off:+.2} %");
    assert!(off.abs() <= percent, "{what}: {ours}, not {theirs}");
}

#[test]
fn lpddr3_answers_as_dramsim3_does() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/dram");
    if !folder.exists() {
        println!("skipped: there is no {}", folder.display());
        return;
    }
    let memory = presets()
        .into_iter()
        .find(|p| p.name == "lpddr3-1600")
        .expect("the preset");
    for r in REFERENCES {
        let path = folder.join(format!("{}.trace", r.name));
        let text = std::fs::read_to_string(&path).expect("a trace");
        let trace = trace::parse(r.name, &text, 32).expect("a trace of requests");
        let mut device = Memory::new(&memory.spec);
        let replay = trace::replay(&mut device, trace.offers(), Some(r.cycles));
        let counters = &replay.counters;
        let activates: u64 = counters.channels.iter().map(|c| c.activates).sum();
        let hits: u64 = counters.channels.iter().map(|c| c.read_row_hits).sum();
        let latency = counters.read_cycles as f64 / counters.reads as f64;
        let bytes = (counters.bytes_read + counters.bytes_written) as f64;
        println!("{}", r.name);
        within("bytes", bytes, 32.0 * (r.reads + r.writes) as f64, 2.0);
        within("activates", activates as f64, r.activates as f64, 2.0);
        within("row hits", hits as f64, r.hits as f64, 2.0);
        within("read latency", latency, r.latency, 5.0);
    }
}
