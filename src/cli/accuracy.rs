//! The command line of `srp accuracy`.

use super::frame::{BUILDERS, Building, Frame, parse_pixel, parse_size};
use super::one_of;
use super::parse_threads;
use clap::Args;
use srp_runtime::bvh::Builder;
use srp_studies::accuracy::Target;
use std::path::PathBuf;

/// `srp accuracy`
#[derive(Args)]
#[command(after_help = "\
Examples:
  srp accuracy
  srp accuracy sibenik.obj --cameras cameras.json:sibenik/0 --target psnr=45,leaks=0 -o sibenik
  srp accuracy sibenik.obj --pixel 160,120
  srp accuracy scene.obj --knob 'T&I reciprocal' --knob power --machine mine.xml

The folder has the picture of every trial and a map of what is off in it. Trials are kept in the cache,
so that the command goes on where it was interrupted.")]
pub(crate) struct Accuracy {
    #[command(flatten)]
    pub(crate) frame: Frame,
    #[command(flatten)]
    pub(crate) building: Building,
    /// Turn no knob, but say of one pixel where it parts from binary64, and what follows from it
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel, conflicts_with = "knob")]
    pub(crate) pixel: Option<(u32, u32)>,
    /// Turn only this knob; several are possible
    #[arg(long, value_name = "NAME")]
    pub(crate) knob: Vec<String>,
    /// What a setting has to keep to: psnr=DB and flip=MEAN of the picture, leaks=N rays that get
    /// through between triangles, pixels=N that are off by more than eight levels
    #[arg(long, value_name = "LIST", default_value = "psnr=45,leaks=0", value_parser = Target::parse)]
    pub(crate) target: Target,
    /// Width and height of the frames
    #[arg(long, value_name = "WxH", default_value = "320x240", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// How the bounding volume hierarchy is built
    #[arg(long, value_name = "BUILDER", default_value = "sweep", value_parser = one_of(BUILDERS))]
    pub(crate) bvh: Builder,
    /// Trials at a time; they change no figure but the host's seconds
    #[arg(long, value_name = "N", default_value = "2", value_parser = parse_threads)]
    pub(crate) threads: usize,
    /// Folder of the report and of all pictures
    #[arg(short, long, value_name = "DIR", default_value = "accuracy")]
    pub(crate) output: PathBuf,
    /// Print the report as JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}
