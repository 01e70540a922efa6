//! Frames at every level of simulation.

pub(crate) mod census;
mod clock;
pub(crate) mod table;
mod text;

use crate::engine::Factory;
use crate::failure::Failure;
use crate::talk::Progress;
use crate::{interrupt, render};
use clock::Watch;
use srp_archdesc::arch::Arch;
use srp_ir::dre::scheduled::ScheduledDre;
use srp_runtime::effect::{Effects, Guard};
use srp_runtime::fidelity::Fidelity;
use srp_runtime::picture::Picture;
use srp_runtime::preview::{self, Preview, View};
use srp_runtime::scene::{Camera, Scene};
use srp_runtime::scene_image::{SceneImage, tile_size};
use srp_runtime::system::sampled::{self, Figure, Frame, Sampled, Tiles, Turns};
use srp_runtime::system::{self, Timing};

pub(crate) use text::{frame_text, sampled_text};

/// A frame that is ready to be run.
pub(crate) struct Shot<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) camera: &'a Camera,
    pub(crate) arch: &'a Arch,
    pub(crate) program: &'a ScheduledDre,
    pub(crate) factory: &'a Factory,
    pub(crate) image: SceneImage,
    pub(crate) effects: Effects,
    pub(crate) guard: Guard,
    pub(crate) size: (u32, u32),
    pub(crate) threads: usize,
    /// Whether T&I units answer at once, whatever the level.
    pub(crate) recorded_hits: bool,
}

/// What is known of a frame before it is sampled.
pub(crate) struct First {
    pub(crate) tiles: Tiles,
    pub(crate) preview: Preview,
    pub(crate) turns: Turns,
}

/// A frame, all of it, at some level.
pub(crate) struct Whole {
    pub(crate) picture: Picture,
    pub(crate) figures: Vec<Figure>,
    pub(crate) seconds: f64,
}

impl Shot<'_> {
    /// Names of the kernels, by their numbers.
    pub(crate) fn kernel_names(&self) -> Vec<String> {
        let kernels = self.program.kernels.values();
        kernels.map(|k| k.dfg.name.clone()).collect()
    }

    /// Runs all of the frame at a level, which is not `sampled`.
    pub(crate) fn whole(&self, level: Fidelity) -> Result<Whole, Failure> {
        let arch = level.machine(self.arch);
        let names = self.kernel_names();
        let progress = Progress::steps("rendering", u64::from(self.image.tiles));
        let mut image = self.image.clone();
        let options = system::Options {
            guard: self.guard.clone(),
            timing: level.timing(),
            chosen: None,
            warm: None,
            max_cycles: render::MAX_CYCLES,
            sram_image: &self.program.image,
            kernel_names: names.clone(),
            progress: &mut |p| progress.at(u64::from(p.tiles)),
            cancelled: &interrupt::requested,
        };
        let cores = self.factory.cores(arch.system.cores);
        let watch = Watch::start();
        let part = interrupt::looked_for(|| system::render_part(&mut image, cores, &arch, options))
            .map_err(Failure::message)?;
        let seconds = watch.seconds();
        drop(progress);
        interrupt::end_if_requested()?;
        Ok(Whole {
            figures: sampled::known(&part, &arch, &names),
            picture: Picture::of(&image.memory, &image.frame),
            seconds,
        })
    }

    fn view(&self) -> View<'_> {
        let spec = &self.arch.system;
        View {
            scene: self.scene,
            image: &self.image,
            spec: &spec.tni,
            fan: self.camera.ray_fan(self.size.0, self.size.1),
            eye: self.camera.position,
            size: self.size,
            tile: tile_size(spec.buffers.rays),
            effects: self.effects,
        }
    }

    /// What is known of the frame before it is sampled, and the seconds that it took.
    pub(crate) fn look(&self) -> Result<(First, f64), Failure> {
        let watch = Watch::start();
        let preview = preview::look(&self.view());
        let tiles = Tiles::of(&preview.sizes, sampled::across(self.size.0, self.arch));
        let options = system::Options {
            guard: self.guard.clone(),
            timing: match self.recorded_hits {
                true => Timing::RecordedHits,
                false => Timing::Full,
            },
            chosen: None,
            warm: None,
            max_cycles: render::MAX_CYCLES,
            sram_image: &self.program.image,
            kernel_names: self.kernel_names(),
            progress: &mut |_| {},
            cancelled: &interrupt::requested,
        };
        let cores = self.factory.cores(self.arch.system.cores);
        let turns = Turns::of(&self.image, cores, self.arch, options).map_err(Failure::message)?;
        let first = First {
            tiles,
            preview,
            turns,
        };
        Ok((first, watch.seconds()))
    }

    /// Does something with the frame as it is sampled.
    pub(crate) fn framed<R>(
        &self,
        first: &First,
        progress: &(dyn Fn(usize) + Sync),
        act: impl FnOnce(&Frame<'_>) -> R,
    ) -> R {
        let engines = || self.factory.cores(self.arch.system.cores);
        let names = self.kernel_names();
        act(&Frame {
            image: &self.image,
            view: &self.view(),
            preview: &first.preview,
            turns: &first.turns,
            engines: &engines,
            arch: self.arch,
            sram_image: &self.program.image,
            guard: self.guard.clone(),
            recorded_hits: self.recorded_hits,
            kernel_names: &names,
            max_cycles: render::MAX_CYCLES,
            threads: self.threads,
            progress,
            cancelled: &interrupt::requested,
        })
    }

    /// Samples the frame, and the seconds that it took with the first look.
    pub(crate) fn sampled(&self, seed: u64, error: f64) -> Result<(Sampled, f64), Failure> {
        let watch = Watch::start();
        let (first, _) = self.look()?;
        let progress = Progress::steps("sampling", u64::from(self.image.tiles));
        let at = |done: usize| progress.at(done as u64);
        let sampled = interrupt::looked_for(|| {
            self.framed(&first, &at, |frame| {
                sampled::sample(frame, &first.tiles, seed, error)
            })
        });
        drop(progress);
        let sampled = sampled.map_err(Failure::message)?;
        let sampled = sampled.ok_or(Failure::Interrupted)?;
        Ok((sampled, watch.seconds()))
    }
}
