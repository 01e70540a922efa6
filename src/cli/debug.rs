//! `srp debug` and `srp tandem`.

use super::compiling::Compilation;
use super::frame::parse_size;
use super::{Choice, ENGINES, one_of};
use clap::Args;
use srp_toolchain::Engine;
use std::path::PathBuf;

/// A program or a frame that is looked into.
#[derive(Args)]
pub(crate) struct Inspected {
    /// C files, or one file of a later form; with --frame they take the place of the kernels of the same name
    #[arg(required_unless_present = "frame")]
    pub(crate) files: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) compilation: Compilation,
    /// A frame on all cores, with T&I units and memory, instead of a program by itself: of this scene, or the default
    /// one
    #[arg(long, value_name = "SCENE", num_args = 0..=1, require_equals = true, default_missing_value = "")]
    pub(crate) frame: Option<String>,
    /// Width and height of the frame in pixels
    #[arg(long, value_name = "WxH", default_value = "64x48", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
}

/// `srp debug`
#[derive(Args)]
#[command(after_help = "\
Without --terminal it talks the Debug Adapter Protocol over standard input and output; docs/debug.md has the
configurations of editors.

Examples:
  srp debug program.c --terminal
  srp debug --frame=church.obj --size 32x24 --terminal
  printf 'break program.c:12\\nrun\\nwhere\\nback\\n' | srp debug program.c --terminal
  srp debug program.c                                     an editor starts it so")]
pub(crate) struct Debug {
    #[command(flatten)]
    pub(crate) of: Inspected,
    /// Take commands, one a line, from standard input; `help` lists them
    #[arg(long)]
    pub(crate) terminal: bool,
}

/// `srp tandem`
#[derive(Args)]
#[command(after_help = "\
Exit status: 0 they agree, 1 they differ.

Examples:
  srp tandem program.c
  srp tandem --frame=church.obj --size 32x24
  srp tandem program.c --engine interp                    the interpreter with itself: tries the comparison")]
pub(crate) struct Tandem {
    #[command(flatten)]
    pub(crate) of: Inspected,
    /// The engine that the interpreter follows
    #[arg(long, value_name = "ENGINE", default_value = "csim", value_parser = one_of(FOLLOWED))]
    pub(crate) engine: Engine,
    /// Stop after so many cycles
    #[arg(long, value_name = "N", default_value_t = 20_000_000_000)]
    pub(crate) limit: u64,
}

/// Engines that can be followed: one that is changed on the way would be compared with itself at first.
const FOLLOWED: &[Choice<Engine>] = {
    let [_, csim, interp] = ENGINES else {
        panic!("there are three engines")
    };
    &[
        Choice {
            value: csim.value,
            name: csim.name,
            what: csim.what,
        },
        Choice {
            value: interp.value,
            name: interp.name,
            what: interp.what,
        },
    ]
};
