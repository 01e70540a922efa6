//! Random memories and random streams of requests.

use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;
use srp_archdesc::dram::{
    AddressField, AddressPart, BankedSpec, ControllerSpec, DramModel, DramSpec, DramTiming,
    RowPolicy,
};
use srp_runtime::memory::dram::Request;

/// The same numbers on every host.
pub(crate) struct Random(Pcg32);

impl Random {
    pub(crate) fn new(seed: u64) -> Random {
        Random(Pcg32::new(seed, 0x0a02_bdbf_7bb3_c0a7))
    }

    pub(crate) fn below(&mut self, n: u32) -> u32 {
        self.0.next_u32() % n
    }

    /// From `lo` to `hi`, both included.
    fn between(&mut self, lo: u32, hi: u32) -> u32 {
        lo + self.below(hi - lo + 1)
    }

    fn power(&mut self, lo: u32, hi: u32) -> u32 {
        1 << self.between(lo, hi)
    }
}

/// A memory of any times and sizes.
pub(crate) fn memory(random: &mut Random) -> (DramSpec, BankedSpec) {
    let timing = DramTiming {
        cl: random.between(1, 20),
        cwl: random.between(1, 20),
        rcd: random.between(1, 25),
        rp: random.between(1, 25),
        ras: random.between(0, 60),
        rc: random.between(0, 80),
        rrd: random.between(0, 20),
        faw: random.between(0, 80),
        wtr: random.between(0, 12),
        rtw: random.between(0, 12),
        wr: random.between(0, 20),
        rtp: random.between(0, 12),
        ccd: random.between(0, 8),
        rfc: random.between(0, 200),
        refi: 0,
    };
    let burst = random.power(1, 4);
    let channels = random.power(0, 2);
    let mut spec = BankedSpec {
        banks: random.power(0, 4),
        rows: random.power(4, 12),
        columns: burst * random.power(0, 6),
        burst,
        mapping: Vec::new(),
        timing,
        controller: ControllerSpec {
            read_queue: random.between(1, 40),
            write_queue: random.between(1, 40),
            command_queue: random.between(1, 12),
            row_policy: [RowPolicy::Open, RowPolicy::Closed][random.below(2) as usize],
            row_hits: random.between(1, 20),
            write_drain: random.between(0, 20),
        },
    };
    if random.below(3) > 0 {
        let least = spec.refresh_and_access();
        spec.timing.refi = random.between(least, 3 * least);
    }
    let mut parts = spec.address_bits(channels);
    for i in (1..parts.len()).rev() {
        parts.swap(i, random.below(i as u32 + 1) as usize);
    }
    spec.mapping = (parts.iter())
        .map(|&(part, bits)| AddressField { part, bits })
        .collect();
    // Some interleave by something smaller than a row.
    let column = spec
        .mapping
        .iter()
        .position(|f| f.part == AddressPart::Column);
    let column = column.expect("columns");
    if spec.mapping[column].bits > 1 {
        spec.mapping[column].bits -= 1;
        spec.mapping.push(AddressField {
            part: AddressPart::Column,
            bits: 1,
        });
    }
    let memory = DramSpec {
        mhz: 1000,
        channels,
        bits: random.power(3, 6),
        shared: true,
        latency_ns: random.below(2) * 30,
        model: DramModel::Banked(spec.clone()),
    };
    (memory, spec)
}

/// A stream that goes on in one place for a while, then elsewhere, and sometimes rests.
pub(crate) fn stream(random: &mut Random, memory: &DramSpec, count: usize) -> Vec<(u64, Request)> {
    let span = match random.below(3) {
        0 => 1 << 12,
        1 => 1 << 18,
        _ => 1 << 30,
    };
    let (writes, gap) = (random.below(100), random.below(30));
    let (mut cycle, mut address) = (0, 0);
    let mut stream = Vec::new();
    for source in 0..count as u32 {
        if random.below(4) == 0 {
            address = random.below(span);
        }
        cycle += match random.below(200) {
            0 => 3000,
            _ => u64::from(random.below(gap + 1)),
        };
        let bytes = 1 + random.below(2 * memory.bits);
        let request = Request {
            address,
            bytes,
            is_write: random.below(100) < writes,
            source,
        };
        stream.push((cycle, request));
        address = address.wrapping_add(bytes) % span;
    }
    stream
}
