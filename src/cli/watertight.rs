//! The command line of `srp watertight`.

use super::{MachineFile, parse_threads};
use clap::Args;
use std::path::PathBuf;

/// `srp watertight`
#[derive(Args)]
#[command(after_help = "\
Rays are aimed at edges and vertices of meshes that are hard, from inside and outside, graze them, and pass
them closely. Exact arithmetic decides which of them meet a triangle. docs/tni.md has a table, and says what
is lost of a mesh of your own, which may be open.

Another ray tracer takes the meshes and rays of --export, and writes DIR/MESH.hits for each mesh: a line for
each ray, 1 where it hits and 0 where it does not. --beside DIR then has it in the table, by the folder's
name. tests/embree/run.sh does so with Embree.

Examples:
  srp watertight
  srp watertight --machine my-machine.xml --rays 10000
  srp watertight --mesh slivers --all
  srp watertight mine.obj other.obj --rays 10000
  srp watertight --export meshes
  srp watertight --beside embree --json")]
pub(crate) struct Watertight {
    /// OBJ files of meshes of your own, instead of ours
    #[arg(value_name = "SCENE.obj")]
    pub(crate) scenes: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) machine: MachineFile,
    /// Rays of each mesh and aim
    #[arg(long, value_name = "N", default_value = "1000",
        value_parser = clap::value_parser!(u32).range(1..=i64::from(srp_studies::watertight::MOST_RAYS)))]
    pub(crate) rays: u32,
    /// Seed that the rays are drawn by
    #[arg(long, value_name = "N", default_value = "1")]
    pub(crate) seed: u64,
    /// Only this mesh
    #[arg(long, value_name = "NAME", conflicts_with = "scenes")]
    pub(crate) mesh: Option<String>,
    /// Print a line for each aim too
    #[arg(long)]
    pub(crate) all: bool,
    /// Answers of another ray tracer
    #[arg(long, value_name = "DIR")]
    pub(crate) beside: Vec<PathBuf>,
    /// Write MESH.obj and MESH.rays for another ray tracer, and shoot none
    #[arg(long, value_name = "DIR", conflicts_with_all = ["beside", "json", "all"])]
    pub(crate) export: Option<PathBuf>,
    /// Threads of the host [default: all processors]
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub(crate) threads: Option<usize>,
    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}
