//! Units whose rays go through them one by one: rates from counts, hit rates and bounds.

use srp_archdesc::system::SystemSpec;

use super::{BLOCK, Outcome};
use srp_runtime::memory::SystemMemory;
use srp_runtime::memory::unloaded::line_cycles;
use srp_runtime::tni::arithmetic::Ray;
use srp_runtime::tni::{self, Buffers, HIT_BYTES, RAY_BYTES, TniCounters, Tree};

/// Units, each with a memory of its own.
pub struct Estimated<'a> {
    memory: &'a SystemMemory,
    units: Vec<tni::Estimated>,
    /// When each unit is done with what it has.
    ends: Vec<u64>,
    sram: Vec<u8>,
    /// Rays of a packet.
    packet: usize,
    packets: usize,
    /// Bytes of a line of the level-2 cache.
    line: u32,
}

impl<'a> Estimated<'a> {
    /// Idle units with empty caches.
    pub fn new(
        spec: &SystemSpec,
        memory: &'a SystemMemory,
        tree: Tree,
        units: u32,
    ) -> Estimated<'a> {
        let packet = spec.buffers.rays.max(1);
        let unit = tni::Estimated::new(&spec.tni, tree, 1, line_cycles(spec));
        Estimated {
            memory,
            units: vec![unit; units.max(1) as usize],
            ends: vec![0; units.max(1) as usize],
            sram: vec![0; (packet * (RAY_BYTES + HIT_BYTES)) as usize],
            packet: packet as usize,
            packets: 0,
            line: spec.tni.trv_l2.line,
        }
    }

    /// Traces rays, in packets of the machine's size.
    pub fn feed(&mut self, rays: &[Ray]) {
        for packet in rays.chunks(self.packet) {
            let unit = self.packets / BLOCK as usize % self.units.len();
            self.packets += 1;
            super::fed_unit::write_rays(&mut self.sram, packet);
            let tni = &mut self.units[unit];
            let buffers = Buffers {
                rays: 0,
                hits: self.packet as u32 * RAY_BYTES,
                count: packet.len() as u32,
            };
            // Rays follow each other as soon as stacks are free.
            let back = tni.submit(0, buffers, self.memory, &mut self.sram);
            let back = back.expect("the buffers lie inside the SRAM, and the unit is empty");
            self.ends[unit] = self.ends[unit].max(back - 1);
            tni.take_finished();
            while tni.take_request().is_some() {}
        }
    }

    /// Returns the outcome.
    pub fn finish(self) -> Outcome {
        let mut counters = TniCounters::default();
        for (unit, &end) in self.units.iter().zip(&self.ends) {
            let mut of = unit.counters();
            of.unit.active_cycles = end;
            counters.add(&of);
        }
        let lines = counters.trv_l2.misses + counters.ist_l1.misses;
        Outcome {
            cycles: self.ends.iter().copied().max().unwrap_or(0),
            bytes: lines * u64::from(self.line),
            counters,
            dram: Vec::new(),
            relative_error: None,
            at_work: self.ends.iter().filter(|&&end| end > 0).count() as u64,
            spent: Vec::new(),
            hits: Vec::new(),
            rays: Vec::new(),
            runs: Vec::new(),
            costs: Vec::new(),
        }
    }
}
