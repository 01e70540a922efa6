//! A frame that somebody else advances, instant by instant, and can take back to where it was.

use srp_archdesc::Arch;

use super::simulation::Simulation;
use super::snapshot::{Instant, SystemSnapshot};
use super::{Options, SystemError, check_options};
use crate::core::Core;
use crate::memory::SystemMemory;
use crate::scene_image::SceneImage;

/// A frame that is advanced from outside.
pub struct System<'a> {
    simulation: Simulation<'a>,
    at: Instant,
}

impl<'a> System<'a> {
    /// A frame at its start: one SGRT core of the machine for each engine, over the scene in `image`.
    ///
    /// # Errors
    ///
    /// The machine cannot be simulated.
    pub fn new(
        image: SceneImage,
        engines: Vec<Box<dyn Core>>,
        arch: &Arch,
        options: Options<'a>,
    ) -> Result<System<'a>, SystemError> {
        check_options(&engines, arch, &options)?;
        Ok(System {
            simulation: Simulation::new(image, engines, arch, options)?,
            at: Instant::default(),
        })
    }

    /// The SRP cycle that comes next.
    pub fn cycle(&self) -> u64 {
        self.at.srp
    }

    /// True when all cores have ended and everything is written.
    pub fn is_over(&self) -> bool {
        self.simulation.is_over()
    }

    /// Advances to the next instant at which something can happen.
    ///
    /// # Errors
    ///
    /// The frame cannot go on.
    pub fn advance(&mut self) -> Result<(), SystemError> {
        self.simulation.advance(&mut self.at)?;
        self.simulation.check_length(self.at.srp)
    }

    /// The SRAM of a core.
    pub fn sram(&self, core: u32) -> Option<&[u8]> {
        let core = self.simulation.cores.get(core as usize)?;
        Some(&core.periphery.sram)
    }

    /// The memory that all cores share.
    pub fn memory(&self) -> &SystemMemory {
        &self.simulation.shared.memory
    }

    /// The text that a core's program has printed.
    pub fn output(&self, core: u32) -> &[u8] {
        let core = self.simulation.cores.get(core as usize);
        core.map_or(&[], |core| &core.periphery.ports.output)
    }

    /// Who waits for what, one line each.
    pub fn waits(&self) -> String {
        self.simulation.waits()
    }

    /// All of it. Where the memory is as in `last`, the two share it. `None` where an engine keeps its state to
    /// itself.
    pub fn snapshot(&self, last: Option<&SystemSnapshot>) -> Option<SystemSnapshot> {
        self.simulation.snapshot(self.at, last)
    }

    /// Goes back, or on, to a snapshot of the same frame. `false` where an engine does not, after which the frame is
    /// of no use.
    pub fn restore(&mut self, from: &SystemSnapshot) -> bool {
        let restored = self.simulation.restore(from);
        self.at = restored.unwrap_or(self.at);
        restored.is_some()
    }
}
