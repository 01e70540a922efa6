//! The command line of `srp new`.

use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// `srp new`
#[derive(Args)]
#[command(after_help = "\
The comment at the beginning of each says what to try. Nothing that exists is written over.

Examples:
  srp new program fog.c && srp run fog.c
  srp new kernels mine && srp render --kernels mine
  srp new machine mine.xml && srp report --frame --machine mine.xml
  srp new sweep plan.toml && srp sweep plan.toml -o sweep
  srp new cases my.cases && srp hard-cases --cases my.cases")]
pub(crate) struct New {
    /// The kind of starting point
    #[arg(value_enum)]
    pub(crate) kind: Kind,
    /// File or folder to make
    pub(crate) path: PathBuf,
}

/// A kind of starting point.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum Kind {
    /// A C program with a loop for the array
    Program,
    /// A folder with the kernels of a frame, to be changed
    Kernels,
    /// A machine file
    Machine,
    /// A plan of a sweep
    Sweep,
    /// Hard cases
    Cases,
}
