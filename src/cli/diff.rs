//! The command line of `srp diff`.

use clap::Args;
use std::path::PathBuf;

/// `srp diff`
#[derive(Args)]
#[command(after_help = "\
Two accounts of one frame (srp render --report FILE.json), two profiles (--profile FILE.json), or two reports
of loops (srp report --json). Exit status: 0 the second is not slower than the first, 1 it is, or they do not fit
each other.

Examples:
  srp render --report a.json; srp render --machine mine.xml --report b.json; srp diff a.json b.json
  srp run fir.c --profile a.json; …; srp run fir.c --profile b.json; srp diff a.json b.json
  srp diff a.json b.json --tolerance 2 --json")]
pub(crate) struct Diff {
    /// The first run
    #[arg(value_name = "OLD.json")]
    pub(crate) old: PathBuf,
    /// The second run
    #[arg(value_name = "NEW.json")]
    pub(crate) new: PathBuf,
    /// More cycles by up to so many per cent are not slower
    #[arg(long, value_name = "PERCENT", default_value = "0", value_parser = parse_percent)]
    pub(crate) tolerance: f64,
    /// Print all changes, not the largest alone
    #[arg(long)]
    pub(crate) all: bool,
    /// Print the changes as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

fn parse_percent(text: &str) -> Result<f64, String> {
    let percent = text.parse().ok();
    let percent = percent.filter(|percent: &f64| percent.is_finite() && *percent >= 0.0);
    percent.ok_or_else(|| "write a number from 0 up".to_owned())
}
