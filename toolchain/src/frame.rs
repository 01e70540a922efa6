//! Frames: the scene, the build of the kernels, and rendering.

use crate::cache::{Key, Kind, key};
use crate::compile::{Compiled, compile};
use crate::front_end::{self, WithTexts};
use crate::input::{self, Input};
use crate::scene::{self, Loaded, Shading};
use crate::{Effort, Engines, Error, Options, Session};
use srp_archdesc::arch::Arch;
use srp_archdesc::diagnostic::{Messages, Source};
use srp_archdesc::watch::Event;
use srp_ir::dre::encoding;
use srp_ir::dre::scheduled::ScheduledDre;
use srp_ir::pass::FastMath;
use srp_ir::program::Program;
use srp_kernels::form::Forms;
use srp_runtime::bvh::{self, Bvh};
use srp_runtime::effect::{Effect, Effects, Guard};
use srp_runtime::picture::Picture;
use srp_runtime::scene::{Camera, Scene};
use srp_runtime::scene_image::{self, SceneImage};
use srp_runtime::system::{self, CodeSizes, Report, TileQueue, Timing};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Most SRP cycles of a frame; far beyond any that ends.
pub const MAX_CYCLES: u64 = 1 << 44;

/// The kernels of a frame: those that come along, or all C files of a folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Kernels(Option<Folder>);

#[derive(Clone, Debug, PartialEq, Eq)]
struct Folder {
    path: PathBuf,
    /// Names the contents of all files in it that C files can include.
    digest: String,
}

impl Kernels {
    /// The kernels of a folder, or those that come along.
    ///
    /// # Errors
    ///
    /// The folder or a file in it cannot be read, or there is no C file.
    pub fn of(folder: Option<&Path>) -> Result<Kernels, Error> {
        let Some(path) = folder else {
            return Ok(Kernels::default());
        };
        let mut key = Key::of(Kind::Trials);
        // Before any file is included, at least one C file has to be there.
        input::c_files(path)?;
        for (name, bytes) in input::all_in(path)? {
            key = key.text(&name).bytes(&bytes);
        }
        Ok(Kernels(Some(Folder {
            path: path.to_owned(),
            digest: key.finish().to_string(),
        })))
    }

    /// Names the contents of the folder; empty of those that come along, which the build of the tools covers.
    pub fn digest(&self) -> &str {
        self.0.as_ref().map_or("", |folder| &folder.digest)
    }

    fn sources(&self) -> Result<Vec<Source>, Error> {
        match &self.0 {
            None => Ok(input::kernels()),
            Some(folder) => input::kernels_in(&folder.path),
        }
    }
}

/// The choices with which the kernels of a frame are built, besides the machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Build {
    /// The kernels.
    pub kernels: Kernels,
    /// Effects that the kernels have.
    pub effects: Effects,
    /// Secondary rays in a row that there is room for.
    pub bounces: u32,
    /// The forms in which the kernels compute.
    pub forms: Forms,
    /// Permissions to change results of floating-point arithmetic.
    pub fast_math: FastMath,
    /// Loops on the array ask for lines of system memory ahead.
    pub prefetch: bool,
    /// How long their loops are scheduled.
    pub effort: Effort,
}

impl Build {
    /// Kernels in their usual forms, compiled as usual.
    pub fn new(effects: Effects, bounces: u32) -> Build {
        Build {
            kernels: Kernels::default(),
            effects,
            bounces,
            forms: Forms::default(),
            fast_math: FastMath::default(),
            prefetch: false,
            effort: Effort::default(),
        }
    }

    /// Reads a scene. Returns it with the build of its kernels, and the guard that stops a frame which needs
    /// more. `told` gets the doubts about the scene's files.
    ///
    /// # Errors
    ///
    /// The scene cannot be read, or the options do not fit it.
    pub fn of_scene(
        options: &FrameOptions,
        told: &mut dyn FnMut(&Loaded),
        session: &Session<'_>,
    ) -> Result<(Scene, Build, Guard), Error> {
        let mut loaded = scene::read(options.scene.as_deref(), options.camera, session)?;
        told(&loaded);
        options.shading.apply(&mut loaded.scene)?;
        let scene = loaded.scene;
        let note = &mut |note: &str| session.watch.tell(Event::Note(note));
        let (effects, guard) = options.shading.effects(&scene, note)?;
        let build = Build {
            kernels: Kernels::of(options.kernels.as_deref())?,
            forms: options.forms,
            fast_math: options.fast_math,
            prefetch: options.prefetch,
            ..Build::new(effects, scene.options.bounces)
        };
        Ok((scene, build, guard))
    }

    /// How the kernels are compiled.
    pub fn options(&self) -> Options {
        let bounces = ("SRP_BOUNCES".to_owned(), self.bounces.max(1).to_string());
        let defines = self.effects.defines().chain(self.forms.defines());
        Options {
            defines: defines.chain([bounces]).collect(),
            auto_kernel: false,
            fast_math: self.fast_math,
            prefetch: self.prefetch,
            effort: self.effort,
            ..Options::default()
        }
    }

    /// The kernels before they are divided: their meaning without a schedule. With warnings.
    ///
    /// # Errors
    ///
    /// The kernels cannot be read, or are wrong.
    pub fn program(&self, arch: &Arch) -> Result<(Program, Messages), Error> {
        front_end::program(Input::C(self.kernels.sources()?), arch, &self.options())
    }

    /// The same before any pass, with the texts of all files: where variables have their names.
    ///
    /// # Errors
    ///
    /// The kernels cannot be read, or are wrong.
    pub fn front_end(&self, arch: &Arch) -> Result<WithTexts, Error> {
        front_end::with_texts(&self.kernels.sources()?, arch, &self.options())
    }

    /// Compiles the kernels.
    ///
    /// # Errors
    ///
    /// Those of [`compile()`].
    pub fn compile(&self, arch: &Arch, session: &Session<'_>) -> Result<Compiled, Error> {
        let sources = Input::C(self.kernels.sources()?);
        compile(sources, arch, &self.options(), session)
    }

    /// Names the simulator of this build on a machine: another build, machine or kernel has another.
    pub fn name(&self, arch: &Arch) -> String {
        let key = Key::of(Kind::Simulators)
            .value(&self.options())
            .text(self.kernels.digest())
            .value(arch);
        let kernels = srp_kernels::SOURCES.iter().chain(srp_kernels::HEADERS);
        let key = kernels.fold(key, |key, file| key.text(file.name).text(file.text));
        key.finish().to_string()[..16].to_owned()
    }
}

/// Names this build of the tools, by its sources.
pub const BUILD_ID: &str = env!("SRP_BUILD_ID");

/// A name for a text.
pub fn hash(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex()[..16].to_owned()
}

/// Options of a frame.
#[derive(Clone, Debug, Default)]
pub struct FrameOptions {
    /// The scene's file; else the default scene.
    pub scene: Option<PathBuf>,
    /// The camera, instead of the scene's own.
    pub camera: Option<Camera>,
    /// How far light is followed.
    pub shading: Shading,
    /// How the tree is built.
    pub bvh: bvh::Options,
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Folder of the kernels, instead of those that come along.
    pub kernels: Option<PathBuf>,
    /// The forms in which the kernels compute.
    pub forms: Forms,
    /// Permissions to change results of floating-point arithmetic.
    pub fast_math: FastMath,
    /// Loops on the array ask for lines of system memory ahead.
    pub prefetch: bool,
}

/// A frame on a machine, for everything that is done with it.
pub struct Frame {
    /// The machine.
    pub arch: Arch,
    /// The scene, with the camera, lights and options that were asked for.
    pub scene: Scene,
    /// Its tree.
    pub bvh: Bvh,
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// The build of the kernels.
    pub build: Build,
    /// Stops the frame where it calls for more.
    pub guard: Guard,
}

impl Frame {
    /// A frame of a scene, with the kernels that it calls for.
    pub fn new(arch: Arch, scene: Scene, bvh: Bvh, size: (u32, u32)) -> Frame {
        let effects = srp_runtime::effect::find(&scene).into_iter().collect();
        Frame {
            arch,
            build: Build::new(effects, scene.options.bounces),
            scene,
            bvh,
            size,
            guard: Guard::default(),
        }
    }

    /// Reads the scene and builds its tree. `told` gets the doubts about the scene's files.
    ///
    /// # Errors
    ///
    /// The scene cannot be read, or the options do not fit it.
    pub fn read(
        arch: Arch,
        options: &FrameOptions,
        told: &mut dyn FnMut(&Loaded),
        session: &Session<'_>,
    ) -> Result<Frame, Error> {
        let of_scene = Build::of_scene(options, told, session)?;
        Ok(Frame::of(arch, of_scene, options, session))
    }

    /// A frame of a scene that was read, with its tree built.
    pub fn of(
        arch: Arch,
        (scene, build, guard): (Scene, Build, Guard),
        options: &FrameOptions,
        session: &Session<'_>,
    ) -> Frame {
        Frame {
            bvh: scene::build(&scene, &options.bvh, session),
            arch,
            scene,
            size: options.size,
            build,
            guard,
        }
    }

    /// System memory at the start of the frame.
    ///
    /// # Errors
    ///
    /// Scene and frame do not fit into memory.
    pub fn image(&self) -> Result<SceneImage, Error> {
        self.image_for(self.build.effects)
    }

    /// The image for kernels that are built for some effects.
    ///
    /// # Errors
    ///
    /// Those of [`image`](Self::image).
    pub fn image_for(&self, effects: Effects) -> Result<SceneImage, Error> {
        let Frame { bvh, .. } = self;
        let mut scene = Cow::Borrowed(&self.scene);
        let uses_levels = effects.contains(Effect::Levels);
        if !uses_levels && scene.textures.iter().any(|t| t.smaller_levels() > 0) {
            // Kernels that compute no level of detail would tell the texture unit a wrong one.
            for texture in &mut scene.to_mut().textures {
                texture.levels = false;
            }
        }
        let image = scene_image::build(&scene, bvh, &scene.camera, &self.arch, self.size);
        Ok(image?)
    }

    /// Begins a key of what is made of this frame. It holds all of the frame, as it is and as it lies
    /// in memory, how its kernels are compiled, and the build of these tools, of which the kernels are a
    /// part.
    pub fn key(&self, kind: Kind, image: &SceneImage) -> key::Builder {
        Key::of(kind)
            .text(BUILD_ID)
            .value(&self.arch)
            .value(&self.scene)
            .value(&self.size)
            .value(&self.build.options())
            .text(self.build.kernels.digest())
            .text(&format!("{:?}", self.guard))
            .bytes(image.memory.bytes())
    }

    /// Renders the frame by a scheduled program. The account of a cancelled frame ends where it was cancelled.
    ///
    /// # Errors
    ///
    /// The frame was not finished.
    pub fn render(
        &self,
        image: SceneImage,
        program: &ScheduledDre,
        engines: &Engines,
        session: &Session<'_>,
    ) -> Result<(Picture, Report), Error> {
        self.render_in_order(None, image, program, engines, session)
    }

    /// The same, where cores take the tiles in another order than that of the frame.
    ///
    /// # Errors
    ///
    /// The frame was not finished.
    pub fn render_in_order(
        &self,
        tiles: Option<TileQueue>,
        image: SceneImage,
        program: &ScheduledDre,
        engines: &Engines,
        session: &Session<'_>,
    ) -> Result<(Picture, Report), Error> {
        let taken = image.memory.bytes().len() as u64;
        if let Some(capacity) = self.arch.system.dram.capacity().filter(|&all| all < taken) {
            session.watch.tell(Event::Note(&format!(
                "note: the frame takes {taken} bytes, and the machine's memory has {capacity}: its addresses wrap, and \
                 rows count as open that would not be (dram.rows)"
            )));
        }
        let options = system::Options {
            tiles,
            ..system_options(
                program,
                &self.arch,
                self.guard.clone(),
                Timing::Full,
                session,
            )
        };
        let cores = engines.cores(self.arch.system.cores);
        Ok(system::render(image, cores, &self.arch, options)?)
    }
}

/// How the system runs a scheduled program.
pub fn system_options<'a>(
    program: &'a ScheduledDre,
    arch: &Arch,
    guard: Guard,
    timing: Timing,
    session: &Session<'a>,
) -> system::Options<'a> {
    system::Options {
        max_cycles: MAX_CYCLES.min(session.cycles),
        guard,
        timing,
        kernel_names: kernel_names(program),
        code: code_sizes(program, arch),
        watch: session.watch,
        ..system::Options::new(&program.image)
    }
}

/// The sizes of a program's machine code.
pub fn code_sizes(program: &ScheduledDre, arch: &Arch) -> CodeSizes {
    let kernels = program.kernels.values();
    CodeSizes {
        bundles: encoding::bundle_bytes(program, arch),
        contexts: kernels.map(|k| k.contexts()).collect(),
    }
}

/// The names of a program's kernels, by their numbers.
pub fn kernel_names(program: &ScheduledDre) -> Vec<String> {
    let kernels = program.kernels.values();
    kernels.map(|k| k.dfg.name.clone()).collect()
}
