//! A frame with its program and engines, run at any level.

use super::host_time::{HostTime, Start};
use super::sampled::{self, FirstPass, Sampled, TracedFrame};
use super::{Fidelity, FrameFigure, figures, ledger};
use crate::Error;
use srp_ir::check::Checked;
use srp_ir::dre::write_scheduled;
use srp_runtime::picture::Picture;
use srp_runtime::scene_image::{SceneImage, tile_size};
use srp_toolchain::cache::{Kind, key};
use srp_toolchain::{
    Engines, Frame, MAX_CYCLES, Session, code_sizes, kernel_names, system_options,
};

/// A frame that is ready to be run.
pub struct Prepared<'a> {
    /// The frame.
    pub frame: &'a Frame,
    /// System memory at its start.
    pub image: SceneImage,
    /// Its kernels, scheduled.
    pub program: &'a Checked,
    /// The engines that run them.
    pub engines: &'a Engines,
    /// Threads of the host for samples; they change no figure.
    pub threads: usize,
    /// True if T&I units answer at once, whatever the level.
    pub recorded_hits: bool,
    /// Who watches, and what was made before.
    pub session: &'a Session<'a>,
}

/// A frame, all of it, at some level.
pub struct Whole {
    /// The picture.
    pub picture: Picture,
    /// Its figures.
    pub figures: Vec<FrameFigure>,
    /// Host time of the run.
    pub took: HostTime,
}

impl Prepared<'_> {
    /// Names of the kernels, by their numbers.
    pub fn kernel_names(&self) -> Vec<String> {
        kernel_names(self.program)
    }

    /// Runs all of the frame at a level, which is not `sampled`.
    ///
    /// # Errors
    ///
    /// The frame was not finished.
    pub fn whole(&self, level: Fidelity) -> Result<Whole, Error> {
        let Prepared { frame, session, .. } = self;
        let arch = level.machine(&frame.arch);
        let mut image = self.image.clone();
        let timing = level.timing();
        let options = system_options(
            self.program,
            &frame.arch,
            frame.guard.clone(),
            timing,
            session,
        );
        let cores = self.engines.cores(arch.system.cores);
        let start = Start::now(session.watch);
        let part = ledger::render_tiles(&mut image, cores, &arch, options);
        let took = start.taken();
        session.check()?;
        let part = part.map_err(srp_toolchain::Error::from)?;
        Ok(Whole {
            figures: figures::known(&part, &arch, &self.kernel_names()),
            picture: Picture::of(&image.memory, &image.frame),
            took,
        })
    }

    /// Begins the key of a result of the kind; `program` is the scheduled program as text.
    pub(super) fn key(&self, kind: Kind, program: &str) -> key::Builder {
        let key = self.frame.key(kind, &self.image).text(program);
        key.value(&self.recorded_hits)
    }

    fn traced(&self) -> TracedFrame<'_> {
        let Frame {
            arch, scene, size, ..
        } = self.frame;
        TracedFrame {
            scene,
            image: &self.image,
            spec: &arch.system.tni,
            fan: scene.camera.ray_fan(size.0, size.1),
            eye: scene.camera.position,
            size: *size,
            tile: tile_size(arch.system.buffers.rays),
            effects: self.frame.build.effects,
            texel_bits: arch.precision.texture_weight_bits,
        }
    }

    /// Samples the frame until the cycles are known to a part of `error`; with what that took, the first
    /// pass included.
    ///
    /// # Errors
    ///
    /// A tile was not finished, or the work was cancelled.
    pub fn sampled(&self, seed: u64, error: f64) -> Result<(Sampled, HostTime), Error> {
        let Prepared { frame, session, .. } = self;
        let arch = &frame.arch;
        let start = Start::now(session.watch);
        let first_pass = FirstPass::of(&self.traced(), arch, self.threads);
        let names = self.kernel_names();
        let name = session.shared.as_ref().map(|_| {
            let program = write_scheduled(self.program, arch);
            self.key(Kind::Frames, &program).finish().to_string()
        });
        let population = sampled::Frame {
            image: &self.image,
            first_pass: &first_pass,
            engines: &|| self.engines.cores(arch.system.cores),
            arch,
            sram_image: &self.program.image,
            guard: frame.guard.clone(),
            recorded_hits: self.recorded_hits,
            kernel_names: &names,
            code: &code_sizes(self.program, arch),
            max_cycles: MAX_CYCLES.min(session.cycles),
            threads: self.threads,
            session,
            name: &name.unwrap_or_default(),
        };
        let sampled = sampled::sample(&population, seed, error)?;
        let sampled = sampled.ok_or(srp_toolchain::Error::Cancelled)?;
        Ok((sampled, start.taken()))
    }
}
