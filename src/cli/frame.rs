//! What every command line about frames has: the scene and who looks at it, what is shaded, and how kernels
//! and tree are built.

use super::{Choice, Feature, MachineFile, fast_math};
use crate::failure::Failure;
use crate::limits;
use clap::Args;
use srp_kernels::effect;
use srp_kernels::form::{self, Forms};
use srp_runtime::bvh::{self, Builder};
use srp_runtime::scene::{self, Light, MAX_BOUNCES, MAX_COORDINATE, MAX_SAMPLES};
use srp_toolchain::scene::{Shading as ShadingOptions, Views as ViewFile};
use srp_toolchain::{Build, FrameOptions, Kernels};
use std::path::{Path, PathBuf};

/// A camera of one's own.
#[derive(Args)]
pub(crate) struct Camera {
    /// Position, direction and angle of view (degrees, of the shorter side of the image)
    #[arg(
        long,
        value_name = "X,Y,Z/DX,DY,DZ/FOV",
        conflicts_with = "cameras",
        allow_hyphen_values = true
    )]
    pub(crate) camera: Option<String>,
}

/// How far light is followed, and what the kernels are built for.
#[derive(Args)]
pub(crate) struct Shading {
    /// Build the kernels for more or less than the scene calls for: +NAME and -NAME change its set, where of an effect that is
    /// left out the pixels are told that it touches; names alone are a set, and a frame that meets what is not in it stops
    /// (see `srp effects`)
    #[arg(long, value_name = "LIST", allow_hyphen_values = true, value_parser = parse_effects)]
    pub(crate) effects: Option<String>,
    /// Rays through each pixel
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SAMPLES)))]
    pub(crate) samples: Option<u32>,
    /// Most secondary rays in a row
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=i64::from(MAX_BOUNCES)))]
    pub(crate) bounces: Option<u32>,
    /// Ambient occlusion rays from each point, and how far they reach (a tenth of the scene)
    #[arg(long, value_name = "N[/RADIUS]", value_parser = parse_occlusion)]
    pub(crate) occlusion: Option<(u32, Option<f32>)>,
    /// Diffuse reflections in a row that are followed, one ray for each
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=i64::from(MAX_BOUNCES)))]
    pub(crate) inter_reflections: Option<u32>,
    /// A point light, instead of the scene's; several are possible
    #[arg(long, value_name = "X,Y,Z[/R,G,B]", allow_hyphen_values = true, value_parser = parse_light)]
    pub(crate) light: Vec<Light>,
}

/// Bytes of the host's memory that a pixel takes, by the level of simulation that takes least.
const PIXEL_BYTES: u64 = 32;

/// What a frame is of: a scene, seen and lit, and the machine that renders it.
#[derive(Args)]
pub(crate) struct Frame {
    /// Scene to render; the default scene where none is given
    pub(crate) scene: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: MachineFile,
    #[command(flatten)]
    pub(crate) camera: Camera,
    /// View N of the scene NAME in a file of cameras
    #[arg(long, value_name = "FILE.json:NAME/N")]
    pub(crate) cameras: Option<String>,
    #[command(flatten)]
    pub(crate) shading: Shading,
}

impl Camera {
    /// The camera that is asked for, if one is, where `cameras` names a view of a file.
    fn chosen(&self, cameras: Option<&str>) -> Result<Option<scene::Camera>, Failure> {
        if let Some(text) = &self.camera {
            return scene::Camera::parse(text).map(Some).map_err(Failure::usage);
        }
        let Some(which) = cameras else {
            return Ok(None);
        };
        let Some((path, name, Some(number))) = parse_cameras(which) else {
            return Err(Failure::Usage(format!(
                "--cameras {which}: write FILE.json:NAME/N"
            )));
        };
        Ok(Some(ViewFile::read(path, name)?.camera(number)?))
    }
}

/// The parts of `FILE.json:NAME` and, where it is there, `/N`.
pub(crate) fn parse_cameras(which: &str) -> Option<(&Path, &str, Option<usize>)> {
    let (path, name) = which.rsplit_once(':')?;
    match name.rsplit_once('/') {
        Some((name, number)) => Some((Path::new(path), name, Some(number.parse().ok()?))),
        None => Some((Path::new(path), name, None)),
    }
}

impl Frame {
    /// What a frame is of, whose tree is built so.
    pub(crate) fn options(
        &self,
        building: Option<&Building>,
        builder: Builder,
        size: (u32, u32),
    ) -> Result<FrameOptions, Failure> {
        let pixels = u64::from(size.0) * u64::from(size.1);
        limits::fits(
            format_args!("a picture of {}x{}", size.0, size.1),
            pixels * PIXEL_BYTES,
        )
        .map_err(Failure::Message)?;
        let Shading {
            effects,
            samples,
            bounces,
            occlusion,
            inter_reflections,
            light,
        } = &self.shading;
        Ok(FrameOptions {
            scene: self.scene.clone(),
            camera: self.camera.chosen(self.cameras.as_deref())?,
            shading: ShadingOptions {
                effects: effects.clone(),
                samples: *samples,
                bounces: *bounces,
                occlusion: *occlusion,
                inter_reflections: *inter_reflections,
                lights: light.clone(),
            },
            bvh: bvh::Options {
                builder,
                ..bvh::Options::default()
            },
            size,
            kernels: building.and_then(|b| b.kernels.clone()),
            forms: building.map_or(Ok(Forms::default()), Building::forms)?,
            fast_math: fast_math(building.map_or(&[], |b| &b.feature)),
            prefetch: building.is_some_and(Building::prefetches),
        })
    }
}

/// How the kernels of a frame are built.
#[derive(Args)]
pub(crate) struct Building {
    #[arg(long, value_name = "NAME=VALUE", help = form_help())]
    pub(crate) form: Vec<String>,
    /// What the compiler may do besides, as of `srp compile`
    #[arg(short = 'f', value_name = "FEATURE", value_enum)]
    pub(crate) feature: Vec<Feature>,
    /// Folder with the kernels in C, instead of those that come along
    #[arg(long, value_name = "DIR")]
    pub(crate) kernels: Option<PathBuf>,
}

impl Building {
    /// True if loops are to ask for lines ahead.
    pub(crate) fn prefetches(&self) -> bool {
        self.feature.contains(&Feature::PrefetchLoopArrays)
    }

    fn forms(&self) -> Result<Forms, Failure> {
        let choose = |forms: Forms, choice: &String| forms.with(choice).map_err(Failure::usage);
        self.form.iter().try_fold(Forms::default(), choose)
    }

    /// What kernels are built for that have these effects.
    pub(crate) fn build(&self, effects: effect::Effects, bounces: u32) -> Result<Build, Failure> {
        Ok(Build {
            kernels: Kernels::of(self.kernels.as_deref())?,
            forms: self.forms()?,
            fast_math: fast_math(&self.feature),
            prefetch: self.prefetches(),
            ..Build::new(effects, bounces)
        })
    }
}

/// What forms there are, and their values.
fn form_help() -> String {
    let forms = form::TABLE.iter().map(|form| {
        let values: Vec<&str> = form.values.iter().map(|(value, _)| *value).collect();
        format!("{} ({}): {}", form.name, form.what, values.join(", "))
    });
    let forms: Vec<String> = forms.collect();
    format!(
        "Form of the kernels, the first of its values by default: {}",
        forms.join("; ")
    )
}

/// Samples, and the radius behind a slash.
/// Looks at the names of a list of effects.
pub(super) fn parse_effects(text: &str) -> Result<String, String> {
    let parsed = effect::Effects::NONE.parse(text);
    parsed.map_err(|e| e.to_string()).map(|_| text.to_owned())
}

fn parse_occlusion(text: &str) -> Result<(u32, Option<f32>), String> {
    let (count, radius) = match text.split_once('/') {
        Some((count, radius)) => (count, Some(radius)),
        None => (text, None),
    };
    let count = count.parse().ok().filter(|&n| n <= MAX_SAMPLES);
    let count = count.ok_or_else(|| format!("`{text}` is not a number up to {MAX_SAMPLES}"))?;
    let positive = |r: &f32| r.is_finite() && *r > 0.0;
    match radius.map(|r| r.parse().ok().filter(positive)) {
        Some(None) => Err(format!("`{text}`: the radius is not a positive number")),
        radius => Ok((count, radius.flatten())),
    }
}

/// A position, and a colour behind a slash.
fn parse_light(text: &str) -> Result<Light, String> {
    let (position, colour) = text.split_once('/').unwrap_or((text, "1,1,1"));
    let three = |part: &str| {
        let numbers: Option<Vec<f32>> = part.split(',').map(|n| n.trim().parse().ok()).collect();
        let numbers = numbers.filter(|n| n.iter().all(|x| x.abs() <= MAX_COORDINATE));
        <[f32; 3]>::try_from(numbers?).ok()
    };
    let wrong = || format!("`{text}` is not X,Y,Z or X,Y,Z/R,G,B");
    let colour = three(colour).ok_or_else(wrong)?;
    match colour.iter().any(|&c| c < 0.0) {
        true => Err(format!("`{text}`: a colour is not negative")),
        false => Ok(Light {
            position: three(position).ok_or_else(wrong)?.into(),
            colour,
        }),
    }
}

/// How bounding volume hierarchies are built.
pub(crate) const BUILDERS: &[Choice<Builder>] = &[
    Choice {
        value: Builder::Best,
        name: Builder::Best.name(),
        what: "The tree of these three that costs least, measured on rays",
    },
    Choice {
        value: Builder::Sweep,
        name: Builder::Sweep.name(),
        what: "Full-sweep surface area heuristic",
    },
    Choice {
        value: Builder::SweepReinsertion,
        name: Builder::SweepReinsertion.name(),
        what: "The same, then improved by reinsertion",
    },
    Choice {
        value: Builder::Ploc,
        name: Builder::Ploc.name(),
        what: "Parallel locally-ordered clustering",
    },
];

/// Largest side of an image.
const MAX_SIDE: u32 = 16_384;

pub(super) fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let side = |s: &str| s.parse().ok().filter(|n| (1..=MAX_SIDE).contains(n));
    text.split_once(['x', 'X'])
        .and_then(|(w, h)| Some((side(w)?, side(h)?)))
        .ok_or_else(|| format!("a size is WIDTHxHEIGHT, each from 1 to {MAX_SIDE}"))
}
