//! Frames at every level of simulation.

pub(crate) mod census;
mod clock;
pub(crate) mod table;
mod text;

use crate::failure::Failure;
use crate::interrupt;
use crate::talk::CONSOLE;
use clock::{Took, Watch};
use srp_archdesc::arch::Arch;
use srp_ir::dre::scheduled::ScheduledDre;
use srp_runtime::effect::{Effects, Guard};
use srp_runtime::picture::Picture;
use srp_runtime::scene::{Camera, Scene};
use srp_runtime::scene_image::{SceneImage, tile_size};
use srp_runtime::system;
use srp_studies::fidelity::Fidelity;
use srp_studies::fidelity::sampled::{self, FirstPass, Frame, Sampled, TracedFrame};
use srp_studies::fidelity::{self, FrameFigure};

use srp_toolchain::{Engines, MAX_CYCLES, kernel_names};

pub(crate) use text::{frame_text, sampled_text};

/// A frame that is ready to be run.
pub(crate) struct Shot<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) camera: &'a Camera,
    pub(crate) arch: &'a Arch,
    pub(crate) program: &'a ScheduledDre,
    pub(crate) engines: &'a Engines,
    pub(crate) image: SceneImage,
    pub(crate) effects: Effects,
    pub(crate) guard: Guard,
    pub(crate) size: (u32, u32),
    pub(crate) threads: usize,
    /// Whether T&I units answer at once, whatever the level.
    pub(crate) recorded_hits: bool,
}

/// A frame, all of it, at some level.
pub(crate) struct Whole {
    pub(crate) picture: Picture,
    pub(crate) figures: Vec<FrameFigure>,
    pub(crate) took: Took,
}

impl Shot<'_> {
    /// Names of the kernels, by their numbers.
    pub(crate) fn kernel_names(&self) -> Vec<String> {
        kernel_names(self.program)
    }

    /// Runs all of the frame at a level, which is not `sampled`.
    pub(crate) fn whole(&self, level: Fidelity) -> Result<Whole, Failure> {
        let arch = level.machine(self.arch);
        let names = self.kernel_names();
        let mut image = self.image.clone();
        let options = system::Options {
            guard: self.guard.clone(),
            timing: level.timing(),
            max_cycles: MAX_CYCLES,
            kernel_names: names.clone(),
            watch: &CONSOLE,
            ..system::Options::new(&self.program.image)
        };
        let cores = self.engines.cores(arch.system.cores);
        let watch = Watch::start();
        let part =
            interrupt::looked_for(|| fidelity::render_tiles(&mut image, cores, &arch, options))
                .map_err(Failure::message)?;
        let took = watch.took();
        interrupt::end_if_requested()?;
        Ok(Whole {
            figures: fidelity::known(&part, &arch, &names),
            picture: Picture::of(&image.memory, &image.frame),
            took,
        })
    }

    fn traced(&self) -> TracedFrame<'_> {
        let spec = &self.arch.system;
        TracedFrame {
            scene: self.scene,
            image: &self.image,
            spec: &spec.tni,
            fan: self.camera.ray_fan(self.size.0, self.size.1),
            eye: self.camera.position,
            size: self.size,
            tile: tile_size(spec.buffers.rays),
            effects: self.effects,
            texel_bits: self.arch.precision.texture_weight_bits,
        }
    }

    /// Samples the frame, and what that took with the first pass.
    pub(crate) fn sampled(&self, seed: u64, error: f64) -> Result<(Sampled, Took), Failure> {
        let watch = Watch::start();
        let first_pass = FirstPass::of(&self.traced(), self.arch, self.threads);
        let names = self.kernel_names();
        let frame = Frame {
            image: &self.image,
            first_pass: &first_pass,
            engines: &|| self.engines.cores(self.arch.system.cores),
            arch: self.arch,
            sram_image: &self.program.image,
            guard: self.guard.clone(),
            recorded_hits: self.recorded_hits,
            kernel_names: &names,
            max_cycles: MAX_CYCLES,
            threads: self.threads,
            watch: &CONSOLE,
        };
        let sampled = interrupt::looked_for(|| sampled::sample(&frame, seed, error));
        let sampled = sampled.map_err(Failure::message)?;
        let sampled = sampled.ok_or(Failure::Interrupted)?;
        Ok((sampled, watch.took()))
    }
}
