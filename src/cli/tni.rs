//! `srp tni`: T&I units on rays of a scene.

use super::fidelity::Level;
use super::frame::{BUILDERS, Camera, parse_size};
use super::{Choice, MachineFile, one_of, parse_pixel, parse_threads};
use clap::{Args, ValueEnum};
use srp_runtime::bvh::{self, Builder};
use srp_studies::rays::Order;
use std::path::PathBuf;

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
pub(super) const ORDERS: &[Choice<Order>] = &[
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
  srp tni sibenik.obj --views 2 --hits rays.csv
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
    #[arg(long, value_name = "BUILDER", default_value = "best", value_parser = one_of(BUILDERS))]
    pub(crate) bvh: Builder,
    #[command(flatten)]
    pub(crate) measuring: Measuring,
    /// Write what each pixel of the first view costs as a picture
    #[arg(long, value_name = "FILE.png")]
    pub(crate) heat: Option<PathBuf>,
    /// What the picture shows
    #[arg(long, value_enum, default_value_t = HeatOf::Cycles)]
    pub(crate) heat_of: HeatOf,
    /// Write each ray with its hit and its cost as a table (CSV): t, u, v, primitive, nodes visited, triangles
    /// tested, cycles
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) hits: Option<PathBuf>,
    /// Trace the first ray of this pixel alone, and tell all that happens to it
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel, conflicts_with_all = ["heat", "hits"])]
    pub(crate) ray: Option<(u32, u32)>,
    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

pub(super) fn parse_sample(text: &str) -> Result<u64, String> {
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
