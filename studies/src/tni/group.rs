//! Units that share a memory.

use serde::Serialize;
use srp_archdesc::Watch;
use srp_archdesc::system::SystemSpec;

use super::fed_unit::FedUnit;
use srp_runtime::memory::SystemMemory;
use srp_runtime::memory::dram::{DramCounters, Request};
use srp_runtime::memory::path::{Clock, MemoryPath};
use srp_runtime::tni::Client;

/// Who shares a memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Memories {
    /// All units have one.
    Shared,
    /// Every unit has its own.
    Private,
}

/// Cycles between two looks at whether to go on.
const LOOK_UP: u64 = 1 << 16;

/// Numbers of requesters for each unit: 0 is its level-2 cache, the next ones are its intersection units.
const CLIENTS: u32 = 1 << 8;

/// Units, their memory, and their clock.
pub(super) struct Group {
    pub(super) units: Vec<FedUnit>,
    path: MemoryPath,
    clock: Clock,
    now: u64,
}

impl Group {
    pub(super) fn new(spec: &SystemSpec, units: Vec<FedUnit>) -> Group {
        Group {
            units,
            path: MemoryPath::new(spec),
            clock: Clock::new(spec.tni_mhz),
            now: 0,
        }
    }

    /// Runs until a unit has taken the last packet that waits for it, or until all are done.
    /// `false` where the watch ended that.
    pub(super) fn run(
        &mut self,
        memory: &SystemMemory,
        to_the_end: bool,
        watch: &dyn Watch,
    ) -> bool {
        loop {
            let all_idle = self.units.iter().all(FedUnit::is_idle);
            let in_stretch = self.units.iter().any(FedUnit::is_in_stretch);
            for unit in &mut self.units {
                unit.fill(self.now, all_idle, in_stretch);
            }
            let over = match to_the_end {
                true => self.units.iter().all(FedUnit::is_done),
                false => self.units.iter().any(FedUnit::is_fed),
            };
            if over {
                return true;
            }
            self.cycle(memory);
            if self.now.is_multiple_of(LOOK_UP) && watch.cancelled() {
                return false;
            }
        }
    }

    fn cycle(&mut self, memory: &SystemMemory) {
        let now = self.now;
        let time = self.clock.start(now);
        while let Some(answer) = self.path.answer(time) {
            let unit = &mut self.units[(answer.source / CLIENTS) as usize];
            let client = match answer.source % CLIENTS {
                0 => Client::TrvL2,
                i => Client::IstL1(i - 1),
            };
            unit.tni.fill(now, client, answer.address);
        }
        for (i, unit) in (0..).zip(&mut self.units) {
            unit.tick(now, memory);
            while let Some(line) = unit.tni.take_request() {
                let client = match line.client {
                    Client::TrvL2 => 0,
                    Client::IstL1(i) => i + 1,
                };
                let request = Request {
                    address: line.address,
                    bytes: line.bytes,
                    is_write: false,
                    source: i * CLIENTS + client,
                };
                self.path.request(time, request);
            }
            unit.collect(now);
        }
        self.now += 1;
    }

    /// Returns the counters of the memory.
    pub(super) fn dram(&self) -> DramCounters {
        self.path.counters()
    }
}
