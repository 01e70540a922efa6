//! A world for the cases, and the record of what a core did in it.

use srp_runtime::core::{Activity, Bus, Core, Lanes, Trap};
use srp_runtime::solo::Solo;
use std::collections::BTreeMap;
use std::ops::Range;

/// A [`Solo`] with time: accesses to some of system memory stall, and ports can make wait.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct World {
    pub(crate) solo: Solo,
    /// Cycles that each access beyond the first 256 bytes of system memory stalls.
    pub(crate) miss_cycles: u64,
    /// How often a port is asked in vain.
    pub(crate) busy: BTreeMap<u32, u32>,
    pub(crate) stall: u64,
    /// Bundles of a line of code; a line other than the last one stalls, and so does a kernel. 0: no code does.
    pub(crate) line: u32,
    /// The line that was read last, and the kernel that was launched.
    pub(crate) read: Option<u32>,
    pub(crate) loaded: Option<u32>,
}

impl World {
    /// True if `port` must be asked again.
    fn is_busy(&mut self, port: u32) -> bool {
        match self.busy.get_mut(&port) {
            Some(left) if *left > 0 => {
                *left -= 1;
                true
            }
            _ => false,
        }
    }

    fn access(&mut self, address: u32) {
        if address >= 0x8000_0100 {
            self.stall = self.miss_cycles;
        }
    }
}

impl Bus for World {
    fn sram(&mut self) -> &mut [u8] {
        self.solo.sram()
    }

    fn cached_load(&mut self, address: u32, bytes: u32) -> Option<Lanes> {
        self.access(address);
        self.solo.cached_load(address, bytes)
    }

    fn cached_store(&mut self, address: u32, bytes: u32, value: Lanes) -> Option<()> {
        self.access(address);
        self.solo.cached_store(address, bytes, value)
    }

    fn prefetch(&mut self, address: u32) {
        self.access(address);
    }

    fn conflict(&mut self, cycles: u32) {
        self.stall = self.stall.max(u64::from(cycles));
    }

    fn texture_descriptor(&mut self, address: u32) -> Option<Lanes> {
        self.access(address);
        self.solo.texture_descriptor(address)
    }

    fn texels(&mut self, addresses: Lanes) -> Result<Lanes, u32> {
        addresses.iter().for_each(|&address| self.access(address));
        self.solo.texels(addresses)
    }

    fn fetch(&mut self, bundle: u32) -> Range<u32> {
        let Some(line) = bundle.checked_div(self.line) else {
            return 0..u32::MAX;
        };
        if self.read.replace(line) != Some(line) {
            self.stall = self.miss_cycles;
        }
        line * self.line..(line + 1) * self.line
    }

    fn launch(&mut self, kernel: u32) {
        if self.line > 0 && self.loaded.replace(kernel) != Some(kernel) {
            self.stall = self.miss_cycles;
        }
    }

    fn stalled(&self) -> bool {
        self.stall > 0
    }

    fn port_in(&mut self, port: u32) -> Option<u32> {
        if self.is_busy(port) {
            return None;
        }
        self.solo.port_in(port)
    }

    fn port_out(&mut self, port: u32, value: u32) -> bool {
        !self.is_busy(port) && self.solo.port_out(port, value)
    }
}

/// The course of a run: stretches of one activity, stalls apart, and how it ended.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Record {
    pub(crate) activities: Vec<(Activity, u64)>,
    pub(crate) stalled: u64,
    pub(crate) operations: u64,
    pub(crate) end: Option<Result<i32, Trap>>,
}

/// Runs `core` to its end, `budget` cycles at a time; gives up after 100,000.
pub(crate) fn record(core: &mut dyn Core, world: &mut World, budget: u64) -> Record {
    let mut record = Record::default();
    let mut total = 0;
    while total < 100_000 {
        let run = match core.run(world, budget) {
            Ok(run) => run,
            Err(trap) => {
                record.end = Some(Err(trap));
                return record;
            }
        };
        if let Activity::Halted(status) = run.activity {
            assert_eq!(run.cycles, 0);
            record.end = Some(Ok(status));
            return record;
        }
        assert!(
            run.cycles >= 1 && run.cycles <= budget,
            "{run:?} of {budget}"
        );
        total += run.cycles;
        record.operations += run.operations;
        match record.activities.last_mut() {
            Some((activity, cycles)) if *activity == run.activity => *cycles += run.cycles,
            _ => record.activities.push((run.activity, run.cycles)),
        }
        record.stalled += std::mem::take(&mut world.stall);
    }
    record
}
