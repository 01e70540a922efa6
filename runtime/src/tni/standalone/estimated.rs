//! Units whose rays go through them one by one: rates from counts, hit rates and bounds.

use srp_archdesc::system::SystemSpec;

use super::{BLOCK, Outcome};
use crate::fidelity;
use crate::memory::SystemMemory;
use crate::tni::arithmetic::Ray;
use crate::tni::{HIT_BYTES, RAY_BYTES, Tni, TniCounters, Tree};

/// Units, each with a memory of its own.
pub struct Estimated<'a> {
    memory: &'a SystemMemory,
    units: Vec<Tni>,
    /// When each unit is done with what it has.
    ends: Vec<u64>,
    sram: Vec<u8>,
    /// Rays of a packet.
    packet: usize,
    packets: usize,
    /// Cycles until a line from memory is there.
    latency: u64,
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
        Estimated {
            memory,
            units: (0..units.max(1))
                .map(|_| Tni::new(&spec.tni, tree, 1))
                .collect(),
            ends: vec![0; units.max(1) as usize],
            sram: vec![0; (packet * (RAY_BYTES + HIT_BYTES)) as usize],
            packet: packet as usize,
            packets: 0,
            latency: fidelity::line_cycles(spec),
        }
    }

    /// Traces rays, in packets of the machine's size.
    pub fn feed(&mut self, rays: &[Ray]) {
        for packet in rays.chunks(self.packet) {
            let unit = self.packets / BLOCK as usize % self.units.len();
            self.packets += 1;
            super::station::write_rays(&mut self.sram, packet);
            let tni = &mut self.units[unit];
            let hits = self.packet as u32 * RAY_BYTES;
            tni.submit(0, hits, packet.len() as u32, self.sram.len())
                .expect("the buffers lie inside the SRAM, and the unit is empty");
            // Rays follow each other as soon as stacks are free.
            let end = tni.answer_by_estimate(0, self.latency, self.memory, &mut self.sram);
            self.ends[unit] = self.ends[unit].max(end);
            tni.take_finished();
        }
    }

    /// What it comes to.
    pub fn finish(self) -> Outcome {
        let mut counters = TniCounters::default();
        for (unit, &end) in self.units.iter().zip(&self.ends) {
            let mut of = unit.progress();
            of.unit.active_cycles = end;
            (of.trvs, of.ists) = (unit.trvs.len() as u64, unit.ists.len() as u64);
            counters.add(&of);
        }
        let lines = counters.trv_l2.misses + counters.ist_l1.misses;
        Outcome {
            cycles: self.ends.iter().copied().max().unwrap_or(0),
            bytes: lines * u64::from(self.units[0].line_bytes()),
            counters,
            dram: Vec::new(),
            relative_error: None,
            at_work: self.ends.iter().filter(|&&end| end > 0).count() as u64,
            spent: Vec::new(),
            hits: Vec::new(),
            runs: Vec::new(),
            costs: Vec::new(),
        }
    }
}
