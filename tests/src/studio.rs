//! Frames of a scene by the kernels that come along, through the whole chain of tools.

use crate::{LITTLE, c_files, compiled_for, machine};
use srp_archdesc::Unwatched;
use srp_archdesc::arch::Arch;
use srp_ir::Program;
use srp_runtime::bvh::{self, Bvh};
use srp_runtime::effect::{Effects, Guard};
use srp_runtime::picture::Picture;
use srp_runtime::scene::Scene;
use srp_runtime::scene_image::{self, SceneImage};
use srp_runtime::system::{self, Report, SystemError};
use srp_studies::attribution::{self, Attribution};
use srp_studies::functional::{self, Frame, FunctionalError};
use srp_toolchain::{Engine, Engines, Session, schedule, system_options};

/// A scene, and what all its frames share.
pub struct Studio {
    /// The machine.
    pub arch: Arch,
    /// The scene.
    pub scene: Scene,
    size: (u32, u32),
    bvh: Bvh,
    session: Session<'static>,
}

impl Studio {
    /// Frames of so many pixels, on the default machine.
    pub fn of(scene: Scene, size: (u32, u32)) -> Studio {
        Studio {
            arch: machine("sgrt"),
            bvh: bvh::build(&scene.triangles, &bvh::Options::default()),
            scene,
            size,
            session: crate::session(),
        }
    }

    /// The same over another tree.
    pub fn with_tree(self, options: &bvh::Options) -> Studio {
        Studio {
            bvh: bvh::build(&self.scene.triangles, options),
            ..self
        }
    }

    /// The kernels built for some effects, after the passes.
    pub fn program(&self, built: Effects) -> Program {
        let defines = built.defines().collect();
        let program = compiled_for(&c_files("kernels"), &self.arch, defines);
        program.unwrap_or_else(|messages| panic!("{built}: {messages}"))
    }

    /// The scene in memory.
    pub fn image(&self) -> SceneImage {
        let Studio { arch, scene, .. } = self;
        let image = scene_image::build(scene, &self.bvh, &scene.camera, arch, self.size);
        image.expect("it fits")
    }

    /// A frame without a clock, by so many threads.
    ///
    /// # Errors
    ///
    /// Why it was not finished.
    pub fn functional(
        &self,
        program: &Program,
        guard: &Guard,
        threads: usize,
    ) -> Result<Frame, FunctionalError> {
        let options = functional::Options {
            guard,
            threads,
            tiles: None,
            steps: functional::MAX_STEPS,
            watch: &Unwatched,
        };
        functional::render(&self.image(), program, &self.arch, options)
    }

    /// Where the errors of a frame come from, by so many threads, each of which remembers so many
    /// operations at once.
    ///
    /// # Errors
    ///
    /// Why it was not finished.
    pub fn attribution(
        &self,
        program: &Program,
        threads: usize,
        most_nodes: usize,
    ) -> Result<Attribution, FunctionalError> {
        let options = attribution::Options {
            guard: &Guard::default(),
            threads,
            tiles: None,
            most_nodes,
            watch: &Unwatched,
        };
        let triangles = &self.scene.triangles;
        attribution::attribute(triangles, &self.image(), program, &self.arch, options)
    }

    /// A frame of kernels that are built for some effects.
    ///
    /// # Errors
    ///
    /// Why it was not finished.
    pub fn frame(&self, built: Effects, guard: Guard) -> Result<(Picture, Report), SystemError> {
        let Studio { arch, session, .. } = self;
        let program = self.program(built);
        let compiled = schedule(program, arch, LITTLE, session);
        let compiled = compiled.unwrap_or_else(|e| panic!("{built}: {e}"));
        assert_eq!(compiled.not_pipelined, [], "{built}");
        let program = &compiled.schedule.program;
        let engines = Engines::of(program, Engine::Interpreter, session);
        let engines = engines.unwrap_or_else(|e| panic!("{built}: {e}"));
        let options = system_options(program, arch, guard, system::Timing::Full, session);
        system::render(
            self.image(),
            engines.cores(arch.system.cores),
            arch,
            options,
        )
    }

    /// The picture of a frame that is finished.
    pub fn picture(&self, built: Effects) -> Picture {
        let frame = self.frame(built, Guard::default());
        frame.unwrap_or_else(|e| panic!("{built}: {e}")).0
    }
}
