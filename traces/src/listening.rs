//! A bus that hears of tiles, and of banks that keep the core.

use srp_archdesc::ports;
use srp_runtime::core::{Bus, Lanes};
use std::ops::Range;

/// A bus that hears of tiles, and of banks that keep the core.
pub(crate) struct Listening<'a> {
    bus: &'a mut dyn Bus,
    /// Gives out no tile.
    refuses: bool,
    /// A tile was asked for, and not given out.
    pub(crate) refused: bool,
    pub(crate) taken: Option<u32>,
    /// Cycles for which banks of the SRAM keep the core.
    pub(crate) kept: u64,
}

impl<'a> Listening<'a> {
    pub(crate) fn to(bus: &'a mut dyn Bus, refuses: bool) -> Listening<'a> {
        Listening {
            bus,
            refuses,
            refused: false,
            taken: None,
            kept: 0,
        }
    }
}

impl Bus for Listening<'_> {
    fn sram(&mut self) -> &mut [u8] {
        self.bus.sram()
    }

    fn cached_load(&mut self, address: u32, bytes: u32) -> Option<Lanes> {
        self.bus.cached_load(address, bytes)
    }

    fn cached_store(&mut self, address: u32, bytes: u32, value: Lanes) -> Option<()> {
        self.bus.cached_store(address, bytes, value)
    }

    fn prefetch(&mut self, address: u32) {
        self.bus.prefetch(address);
    }

    fn conflict(&mut self, cycles: u32) {
        self.kept += u64::from(cycles);
        self.bus.conflict(cycles);
    }

    fn texture_descriptor(&mut self, address: u32) -> Option<Lanes> {
        self.bus.texture_descriptor(address)
    }

    fn texels(&mut self, addresses: Lanes) -> Result<Lanes, u32> {
        self.bus.texels(addresses)
    }

    fn fetch(&mut self, bundle: u32) -> Range<u32> {
        self.bus.fetch(bundle)
    }

    fn launch(&mut self, kernel: u32) {
        self.bus.launch(kernel);
    }

    fn stalled(&self) -> bool {
        self.bus.stalled()
    }

    fn port_in(&mut self, port: u32) -> Option<u32> {
        if port != ports::TILE {
            return self.bus.port_in(port);
        }
        if self.refuses {
            self.refused = true;
            return None;
        }
        self.taken = self.bus.port_in(port);
        self.taken
    }

    fn port_out(&mut self, port: u32, value: u32) -> bool {
        self.bus.port_out(port, value)
    }
}
