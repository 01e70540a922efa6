//! Scenes, their viewpoints and their trees, for every command that needs one.

use crate::cli::{self, BvhBuilder, Shading};
use crate::failure::Failure;
use crate::talk::{self, Progress};
use crate::{files, machine, render};
use srp_archdesc::arch::Arch;
use srp_runtime::bvh::{self, Builder, Bvh};
use srp_runtime::effect::{self, Effects, Guard};
use srp_runtime::scene::camera::{Camera, Viewpoints};
use srp_runtime::scene::{self, MAX_LIGHTS, Scene};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What a frame is of.
pub(crate) struct Frame {
    pub(crate) arch: Arch,
    /// With the camera, the lights and the options that were asked for.
    pub(crate) scene: Scene,
    /// What kernels are built for, and what stops a frame that calls for more.
    pub(crate) effects: Effects,
    pub(crate) guard: Guard,
}

impl Frame {
    /// Reads the machine and the scene, and changes them as the command line says.
    pub(crate) fn read(args: &cli::Frame) -> Result<Frame, Failure> {
        let arch = machine::read(&args.machine.machine)?;
        let camera = render::camera(&args.camera, args.cameras.as_deref())?;
        let mut scene = read(args.scene.as_deref(), camera)?;
        set_up(&mut scene, &args.shading)?;
        let (effects, guard) = effects(&scene, args.shading.effects.as_deref())?;
        Ok(Frame {
            arch,
            scene,
            effects,
            guard,
        })
    }
}

/// Reads a scene, or makes the default one. Warnings go to standard error.
pub(crate) fn read(path: Option<&Path>, camera: Option<Camera>) -> Result<Scene, Failure> {
    let Some(path) = path else {
        let mut scene = scene::demo::demo();
        if let Some(camera) = camera {
            scene.camera = camera;
        }
        return Ok(scene);
    };
    let spinner = Progress::spinner("reading the scene");
    let loaded = scene::read(path, camera, &mut |path| std::fs::read(path));
    drop(spinner);
    match loaded {
        Ok(loaded) => {
            talk::say_all(&loaded.warnings.render(talk::colour()));
            for lack in effect::lacks(&loaded.scene) {
                talk::say(format_args!("warning: {lack}"));
            }
            Ok(loaded.scene)
        }
        Err(messages) => Err(Failure::Reported(messages.render(talk::colour()))),
    }
}

/// Changes a scene as the command line says.
pub(crate) fn set_up(scene: &mut Scene, args: &Shading) -> Result<(), Failure> {
    let options = &mut scene.options;
    options.samples = args.samples.unwrap_or(options.samples);
    options.bounces = args.bounces.unwrap_or(options.bounces);
    options.inter_reflections = args.inter_reflections.unwrap_or(options.inter_reflections);
    if let Some((count, radius)) = args.occlusion {
        options.occlusion = count;
        let (lo, hi) = scene::bounds(&scene.triangles).unwrap_or_default();
        options.occlusion_radius = radius.unwrap_or(0.1 * (hi - lo).length());
    }
    if !args.light.is_empty() {
        scene.lights.clone_from(&args.light);
    }
    match scene.lights.len() > MAX_LIGHTS {
        true => Err(Failure::Message(format!(
            "there are {} lights, and no more than {MAX_LIGHTS} are possible",
            scene.lights.len()
        ))),
        false => Ok(()),
    }
}

/// What kernels are built for: what the scene calls for, changed as a list says, and the guard that
/// stops a frame which calls for more. What a list leaves out is not guarded: it is not wanted.
pub(crate) fn effects(scene: &Scene, list: Option<&str>) -> Result<(Effects, Guard), Failure> {
    let needed: Effects = effect::find(scene).into_iter().collect();
    let Some(list) = list else {
        return Ok((needed, Guard::default()));
    };
    let (built, whole) = needed.parse(list).map_err(Failure::message)?;
    let guard = match whole {
        true => Guard::of(scene, built).map_err(Failure::message)?,
        false => Guard::default(),
    };
    Ok((built, guard))
}

/// Builds the tree of a scene, with leaves of so many triangles at most, and says what came of it.
pub(crate) fn build(scene: &Scene, builder: BvhBuilder, max_leaf: Option<u32>) -> Bvh {
    let builder = match builder {
        BvhBuilder::Sweep => Builder::Sweep,
        BvhBuilder::SweepReinsertion => Builder::SweepReinsertion,
        BvhBuilder::Ploc => Builder::Ploc,
    };
    let spinner = Progress::spinner("building the BVH");
    let default = bvh::Options::default();
    let options = bvh::Options {
        builder,
        max_leaf: max_leaf.unwrap_or(default.max_leaf),
        ..default
    };
    let bvh = bvh::build(&scene.triangles, &options);
    drop(spinner);
    if bvh.fell_back {
        talk::say("note: the tree was too deep for the T&I unit; the sweep's is used instead");
    }
    talk::say(format_args!(
        "{} triangles, BVH by {}: SAH cost {:.1}, {} levels",
        scene.triangles.len(),
        builder.name(),
        bvh.sah_cost(options.traversal_cost),
        bvh.depth()
    ));
    bvh
}

/// The viewpoints of one scene in a file of cameras.
pub(crate) struct Views {
    name: String,
    pub(crate) points: Viewpoints,
}

impl Views {
    /// Those under `name` in the file.
    pub(crate) fn read(path: &Path, name: &str) -> Result<Views, Failure> {
        let mut scenes = scenes(path)?;
        let Some(scene) = scenes.remove(name) else {
            let known: Vec<&str> = scenes
                .iter()
                .filter(|(_, v)| v.is_object())
                .map(|(k, _)| k.as_str())
                .collect();
            return Err(Failure::Message(format!(
                "{}: there is no scene `{name}`; there are {}",
                path.display(),
                known.join(", ")
            )));
        };
        let named = format!("{}: scene `{name}`", path.display());
        let points =
            serde_json::from_value(scene).map_err(|e| Failure::Message(format!("{named}: {e}")))?;
        Ok(Views {
            name: named,
            points,
        })
    }

    /// Those that a file `cameras.json` beside the scene, or one folder above, has for it.
    pub(crate) fn beside(scene: &Path) -> Result<Option<Views>, Failure> {
        let Some(name) = scene.file_stem().and_then(|n| n.to_str()) else {
            return Ok(None);
        };
        for folder in scene.ancestors().skip(1).take(2) {
            let path: PathBuf = folder.join("cameras.json");
            if path.is_file() && scenes(&path)?.contains_key(name) {
                return Views::read(&path, name).map(Some);
            }
        }
        Ok(None)
    }

    /// The camera of view `number`.
    pub(crate) fn camera(&self, number: usize) -> Result<Camera, Failure> {
        let camera = self.points.camera(number);
        camera.map_err(|e| Failure::Message(format!("{}: {e}", self.name)))
    }
}

/// All scenes of a file of cameras.
fn scenes(path: &Path) -> Result<BTreeMap<String, serde_json::Value>, Failure> {
    let text = files::read_text(path)?;
    serde_json::from_str(&text).map_err(|e| {
        Failure::Message(format!(
            "{}:{}:{}: {e}",
            path.display(),
            e.line(),
            e.column()
        ))
    })
}

/// The parts of `FILE.json:NAME` and, where it is there, `/N`.
pub(crate) fn parse_cameras(which: &str) -> Option<(&Path, &str, Option<usize>)> {
    let (path, name) = which.rsplit_once(':')?;
    match name.rsplit_once('/') {
        Some((name, number)) => Some((Path::new(path), name, Some(number.parse().ok()?))),
        None => Some((Path::new(path), name, None)),
    }
}
