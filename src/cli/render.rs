//! `srp render` and `srp effects`.

use super::fidelity::Level;
use super::frame::{BUILDERS, Building, Frame, parse_size};
use super::{
    Checkpoints, ENGINES, Loops, Search, Sharing, Trace, one_of, parse_pixel, parse_threads,
};
use clap::Args;
use srp_runtime::bvh::Builder;
use srp_toolchain::Engine;
use std::path::PathBuf;

/// `srp render`
#[derive(Args)]
#[command(after_help = "\
Examples:
  srp render
  srp render sibenik.obj --cameras cameras.json:sibenik/0 --size 320x240 -o sibenik.png
  srp render scene.obj --camera 0,1,5/0,0,-1/60 --machine wide --report frame.json --loops loops.html
  srp render --trace kernel:shade_hit#10@2 --trace-output shade.fst
  srp render --trace pixel:160,120 --trace-output pixel.pftrace
  srp render --pixel 160,120
  srp render --effects all --prepare; for s in *.obj; do srp render $s --ready -o ${s%.obj}.png; done")]
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
    /// Warnings about the kernels, as of `srp compile`: no-error=kernel lets loops that the array cannot
    /// run stay on the VLIW engine
    #[arg(short = 'W', value_name = "NAME")]
    pub(crate) warnings: Vec<String>,
    #[command(flatten)]
    pub(crate) search: Search,
    #[command(flatten)]
    pub(crate) level: Level,
    /// Take kernels that are ready: of those that do all that the scene calls for and whose schedules the cache has,
    /// the ones of the fewest effects; the picture is the same, its cycles are those of these kernels. A process that
    /// goes on by itself schedules what is not ready for the next time. Where nothing is ready, kernels of all effects are scheduled
    #[arg(long, conflicts_with_all = ["effects", "prepare", "restore", "checkpoint_at"])]
    pub(crate) ready: bool,
    /// Only schedule the kernels, so that later frames find them ready, and render nothing
    #[arg(long)]
    pub(crate) prepare: bool,
    /// Threads of the host for --fidelity sampled, as many as it has processors by default; they change
    /// no figure
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub(crate) threads: Option<usize>,
    /// How the bounding volume hierarchy is built
    #[arg(long, value_name = "BUILDER", default_value = "best", value_parser = one_of(BUILDERS))]
    pub(crate) bvh: Builder,
    /// The image
    #[arg(short, long, value_name = "FILE.png", default_value = "out.png")]
    pub(crate) output: PathBuf,
    /// Write the whole account as JSON too
    #[arg(long, value_name = "FILE.json")]
    pub(crate) report: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) loops: Loops,
    /// Write where every cycle of the cores went, by function, loop and source line: a page if the name ends in
    /// .html, JSON if in .json, else text; `-` is standard output. The interpreter counts, so it renders
    #[arg(long, value_name = "FILE")]
    pub(crate) profile: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) trace: Trace,
    #[command(flatten)]
    pub(crate) checkpoints: Checkpoints,
    /// Tell, instead of the account, all that made a pixel, in its order and with its cycles: launches of kernels, rays
    /// and their hits, texture samples and values. 0,0 is the upper left corner; with --json every operation
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel, conflicts_with = "restore")]
    pub(crate) pixel: Option<(u32, u32)>,
    /// Print the account as JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) sharing: Sharing,
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
    #[command(flatten)]
    pub(crate) search: Search,
    /// Width and height of the frames that are measured
    #[arg(long, value_name = "WxH", default_value = "64x48", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// What simulates the SRP in these frames
    #[arg(long, value_name = "ENGINE", default_value = "interp", value_parser = one_of(ENGINES))]
    pub(crate) engine: Engine,
    /// How the bounding volume hierarchy is built
    #[arg(long, value_name = "BUILDER", default_value = "best", value_parser = one_of(BUILDERS))]
    pub(crate) bvh: Builder,
    /// Write the report as a page too
    #[arg(long, value_name = "FILE.html")]
    pub(crate) html: Option<PathBuf>,
    /// Print the report as JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}
