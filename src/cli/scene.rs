//! The command lines of what works on scenes: `srp render`, `srp tni`, `srp paper`.

use super::{
    Choice, ENGINES, Feature, Level, Loops, MachineFile, fast_math, one_of, parse_threads,
};
use crate::failure::Failure;
use clap::{Args, ValueEnum};
use srp_kernels::effect;
use srp_kernels::form::{self, Forms};
use srp_runtime::bvh::{self, Builder};
use srp_runtime::scene::{self, Light, MAX_BOUNCES, MAX_COORDINATE, MAX_SAMPLES};
use srp_studies::rays::Order;
use srp_toolchain::scene::{Shading as ShadingOptions, Views as ViewFile};
use srp_toolchain::{Build, Engine, FrameOptions};
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

/// What changes how units alone are measured, and no view.
#[derive(Args)]
pub(crate) struct Measuring {
    /// Most triangles of a leaf
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=255))]
    pub(crate) max_leaf: Option<u32>,
    /// Threads of the host, as many as it has processors by default; they change no figure
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub(crate) threads: Option<usize>,
}

impl Measuring {
    /// How the tree is built.
    pub(crate) fn tree(&self, builder: Builder) -> bvh::Options {
        let default = bvh::Options::default();
        bvh::Options {
            builder,
            max_leaf: self.max_leaf.unwrap_or(default.max_leaf),
            ..default
        }
    }
}

/// How far light is followed, and what the kernels are built for.
#[derive(Args)]
pub(crate) struct Shading {
    /// Build the kernels for more or less than the scene calls for: +NAME and -NAME change its set,
    /// names alone are a set, and a frame that meets what is not in it stops (see `srp effects`)
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
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
            return scene::Camera::parse(text)
                .map(Some)
                .map_err(Failure::message);
        }
        let Some(which) = cameras else {
            return Ok(None);
        };
        let Some((path, name, Some(number))) = parse_cameras(which) else {
            return Err(Failure::Message(format!(
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
            forms: building.map_or(Ok(Forms::default()), Building::forms)?,
            fast_math: fast_math(building.map_or(&[], |b| &b.feature)),
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
}

impl Building {
    fn forms(&self) -> Result<Forms, Failure> {
        let choose = |forms: Forms, choice: &String| forms.with(choice).map_err(Failure::message);
        self.form.iter().try_fold(Forms::default(), choose)
    }

    /// What kernels are built for that have these effects.
    pub(crate) fn build(&self, effects: effect::Effects, bounces: u32) -> Result<Build, Failure> {
        Ok(Build {
            forms: self.forms()?,
            fast_math: fast_math(&self.feature),
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

/// `srp render`
#[derive(Args)]
#[command(after_help = "\
Examples:
  srp render
  srp render sibenik.obj --cameras cameras.json:sibenik/0 --size 320x240 -o sibenik.png
  srp render scene.obj --camera 0,1,5/0,0,-1/60 --machine wide --report frame.json --loops loops.html")]
pub(crate) struct Render {
    #[command(flatten)]
    pub(crate) frame: Frame,
    #[command(flatten)]
    pub(crate) building: Building,
    /// Width and height of the image in pixels
    #[arg(long, value_name = "WxH", default_value = "320x240", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// What simulates the SRP; without rustc, csim gives way to interp
    #[arg(long, value_name = "ENGINE", default_value = "auto", value_parser = one_of(ENGINES))]
    pub(crate) engine: Engine,
    /// Folder with the kernels in C, instead of those that come along
    #[arg(long, value_name = "DIR")]
    pub(crate) kernels: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) level: Level,
    /// Threads of the host for --fidelity sampled, as many as it has processors by default; they change
    /// no figure
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub(crate) threads: Option<usize>,
    /// How the bounding volume hierarchy is built
    #[arg(long, value_name = "BUILDER", default_value = "sweep", value_parser = one_of(BUILDERS))]
    pub(crate) bvh: Builder,
    /// The image
    #[arg(short, long, value_name = "FILE.png", default_value = "out.png")]
    pub(crate) output: PathBuf,
    /// Write the whole account as JSON too
    #[arg(long, value_name = "FILE.json")]
    pub(crate) report: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) loops: Loops,
    /// Print the account as JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

/// `srp effects`
#[derive(Args)]
#[command(after_help = "\
Examples:
  srp effects scene.obj
  srp effects scene.obj --no-costs --json
  srp effects --effects +antialiasing,-shadow --html effects.html")]
pub(crate) struct Effects {
    #[command(flatten)]
    pub(crate) frame: Frame,
    #[command(flatten)]
    pub(crate) building: Building,
    /// Measure nothing: only which effects, and why
    #[arg(long)]
    pub(crate) no_costs: bool,
    /// Width and height of the frames that are measured
    #[arg(long, value_name = "WxH", default_value = "64x48", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// What simulates the SRP in these frames
    #[arg(long, value_name = "ENGINE", default_value = "interp", value_parser = one_of(ENGINES))]
    pub(crate) engine: Engine,
    /// How the bounding volume hierarchy is built
    #[arg(long, value_name = "BUILDER", default_value = "sweep", value_parser = one_of(BUILDERS))]
    pub(crate) bvh: Builder,
    /// Write the report as a page too
    #[arg(long, value_name = "FILE.html")]
    pub(crate) html: Option<PathBuf>,
    /// Print the report as JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

/// Kinds of rays.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RayKind {
    /// Through the pixel centres
    Primary,
    /// Ambient occlusion: short, any hit
    Ao,
    /// Diffuse reflection: the nearest hit
    Diffuse,
    /// Those of --ray-file
    File,
}

/// Forms of the traversal unit.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Pipeline {
    /// One deep pipeline
    Single,
    /// Three sub-pipelines side by side
    Parallel,
}

/// Latencies by name.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Latencies {
    /// Those with which the unit has the rates of the paper
    Calibrated,
    /// Those of a 65 nm synthesis: a lower bound
    #[value(name = "65nm")]
    Synthesis65nm,
}

/// Who shares a memory.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TniMemory {
    /// All units have one
    Shared,
    /// Every unit has its own
    Private,
    /// One after the other
    Both,
}

/// Orders of rays.
const ORDERS: &[Choice<Order>] = &[
    Choice {
        value: Order::Morton,
        name: "morton",
        what: "By a Morton key of origin and direction, in batches of 2^20",
    },
    Choice {
        value: Order::Pixels,
        name: "pixels",
        what: "Pixels along a Z-curve, a pixel's rays together",
    },
    Choice {
        value: Order::Rows,
        name: "rows",
        what: "Pixels row by row",
    },
    Choice {
        value: Order::Random,
        name: "random",
        what: "Shuffled",
    },
];

/// What a heat map shows.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum HeatOf {
    /// Cycles from dispatch to result
    Cycles,
    /// Nodes visited
    Visits,
}

/// `srp tni`
#[derive(Args)]
#[command(after_help = "\
Views come from --cameras, or from a cameras.json beside the scene or one folder above that names it.

Examples:
  srp tni sibenik.obj --rays primary --size 1024x768
  srp tni sibenik.obj --rays diffuse --spp 32 --sample 1/64 --units 4 --threads 2
  srp tni sibenik.obj --views 2 --heat heat.png --heat-of visits
  srp tni sibenik.obj --views 2 --ray 160,120")]
pub(crate) struct Tni {
    /// Scene; the default scene where none is given
    pub(crate) scene: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: MachineFile,
    /// Rays to trace
    #[arg(long, value_enum, default_value_t = RayKind::Primary)]
    pub(crate) rays: RayKind,
    /// Rays as text, one a line: ox oy oz dx dy dz, then tmin tmax, then any; the last two may be left out
    #[arg(long, value_name = "FILE")]
    pub(crate) ray_file: Option<PathBuf>,
    /// Form of the traversal units, instead of the machine's
    #[arg(long, value_enum)]
    pub(crate) pipeline: Option<Pipeline>,
    /// Latencies of the unit by name, instead of the machine's
    #[arg(long, value_enum)]
    pub(crate) latencies: Option<Latencies>,
    /// Number of T&I units; the machine's cores where none is given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub(crate) units: Option<u32>,
    /// Who shares a memory, instead of what the machine says
    #[arg(long, value_enum)]
    pub(crate) memory: Option<TniMemory>,
    #[command(flatten)]
    pub(crate) camera: Camera,
    /// Views of the scene NAME in a file of cameras
    #[arg(long, value_name = "FILE.json:NAME")]
    pub(crate) cameras: Option<String>,
    /// Run all views, or view N
    #[arg(long, value_name = "all|N", default_value = "all", value_parser = parse_views)]
    pub(crate) views: Views,
    /// Width and height of the image in pixels
    #[arg(long, value_name = "WxH", default_value = "320x240", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// Secondary rays a pixel
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) spp: u32,
    /// Length of ambient-occlusion rays; else what the file of cameras says, or a tenth of the
    /// scene's diagonal
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    pub(crate) radius: Option<f32>,
    /// Measure one run of packets in N, from cold caches; --fidelity sampled chooses for itself, and warms them
    #[arg(long, value_name = "1/N", value_parser = parse_sample)]
    pub(crate) sample: Option<u64>,
    #[command(flatten)]
    pub(crate) level: Level,
    /// Order of the rays
    #[arg(long, value_name = "ORDER", default_value = "morton", value_parser = one_of(ORDERS))]
    pub(crate) order: Order,
    /// How the bounding volume hierarchy is built
    #[arg(long, value_name = "BUILDER", default_value = "sweep", value_parser = one_of(BUILDERS))]
    pub(crate) bvh: Builder,
    #[command(flatten)]
    pub(crate) measuring: Measuring,
    /// Write what each pixel of the first view costs as a picture
    #[arg(long, value_name = "FILE.png")]
    pub(crate) heat: Option<PathBuf>,
    /// What the picture shows
    #[arg(long, value_enum, default_value_t = HeatOf::Cycles)]
    pub(crate) heat_of: HeatOf,
    /// Trace the first ray of this pixel alone, and tell all that happens to it
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel, conflicts_with = "heat")]
    pub(crate) ray: Option<(u32, u32)>,
    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

/// Tables of the paper.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Table {
    /// Ray generation and shading by themselves, fed by recorded hits
    Table3,
    /// One unit, traversal with a single and with parallel pipelines
    Table4,
    /// Four units: utilisation, steps, hit rates, bandwidth
    Table5,
    /// Frames per second of the whole system
    Table6,
}

impl Table {
    /// Its name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Table::Table3 => "table3",
            Table::Table4 => "table4",
            Table::Table5 => "table5",
            Table::Table6 => "table6",
        }
    }
}

/// `srp paper`
#[derive(Args)]
#[command(mut_arg("fidelity", |arg| arg.default_value("sampled")))]
#[command(after_help = "\
Views come from a cameras.json beside the scene or one folder above that names it. The paper's figures
are those of the scene of the same name; for others only ours are printed.

Examples:
  srp paper table3 sibenik.obj --effects -texture
  srp paper table4 sibenik.obj
  srp paper table5 sibenik.obj --error 2%
  srp paper table4 sibenik.obj --fidelity cycle+dram --sample 1/64
  srp paper table6 lamborghini.obj --json")]
pub(crate) struct Paper {
    /// Which table
    pub(crate) table: Table,
    /// Scenes to compare on
    pub(crate) scenes: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: MachineFile,
    /// Width and height of the image in pixels [default: 1024x768; table6: 1920x1080]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,
    /// In tables 3 and 6 effects to add to those the scene calls for or to leave out: -texture,…
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    pub(crate) effects: Option<String>,
    #[command(flatten)]
    pub(crate) building: Building,
    /// What runs the kernels in tables 3 and 6
    #[arg(long, value_name = "ENGINE", default_value = "auto", value_parser = one_of(ENGINES))]
    pub(crate) engine: Engine,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// With another level than sampled: measure one run of packets of secondary rays in N, from cold caches
    /// [default: 1/64]
    #[arg(long, value_name = "1/N", value_parser = parse_sample)]
    pub(crate) sample: Option<u64>,
    /// The same of primary rays [default: 1/1]
    #[arg(long, value_name = "1/N", value_parser = parse_sample)]
    pub(crate) sample_primary: Option<u64>,
    #[command(flatten)]
    pub(crate) level: Level,
    /// Order of the rays
    #[arg(long, value_name = "ORDER", default_value = "morton", value_parser = one_of(ORDERS))]
    pub(crate) order: Order,
    #[command(flatten)]
    pub(crate) measuring: Measuring,
}

impl Paper {
    /// One run of packets in so many is measured of secondary rays, and of primary ones.
    pub(crate) fn one_in(&self) -> (u64, u64) {
        match self.level.fidelity {
            srp_studies::fidelity::Fidelity::Sampled => (1, 1),
            _ => (self.sample.unwrap_or(64), self.sample_primary.unwrap_or(1)),
        }
    }

    /// Width and height of the image in pixels: the paper's, unless others are asked for.
    pub(crate) fn size(&self) -> (u32, u32) {
        self.size.unwrap_or(match self.table {
            Table::Table6 => (1920, 1080),
            _ => (1024, 768),
        })
    }
}

/// Views to run: all of them, or this one.
pub(crate) type Views = Option<usize>;

fn parse_views(text: &str) -> Result<Views, String> {
    match text {
        "all" => Ok(None),
        n => n
            .parse()
            .map(Some)
            .map_err(|_| "write `all` or the number of a view, from 0".to_owned()),
    }
}

fn parse_sample(text: &str) -> Result<u64, String> {
    let n = text.strip_prefix("1/").and_then(|n| n.parse().ok());
    n.filter(|n| (1..=1 << 20).contains(n))
        .ok_or_else(|| "a part is 1/N, N from 1 to 1048576".to_owned())
}

fn parse_length(text: &str) -> Result<f32, String> {
    let length = text.parse().ok();
    length
        .filter(|l: &f32| *l > 0.0 && l.is_finite())
        .ok_or_else(|| "a length is a number above 0".to_owned())
}

pub(super) fn parse_pixel(text: &str) -> Result<(u32, u32), String> {
    text.split_once(',')
        .and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)))
        .ok_or_else(|| "a pixel is X,Y, from 0,0 in the upper left corner".to_owned())
}

/// Largest side of an image.
const MAX_SIDE: u32 = 16_384;

pub(super) fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let side = |s: &str| s.parse().ok().filter(|n| (1..=MAX_SIDE).contains(n));
    text.split_once(['x', 'X'])
        .and_then(|(w, h)| Some((side(w)?, side(h)?)))
        .ok_or_else(|| format!("a size is WIDTHxHEIGHT, each from 1 to {MAX_SIDE}"))
}
