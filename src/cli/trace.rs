//! What of a simulation is recorded, cycle by cycle.

use super::{Choice, one_of, parse_pixel};
use clap::Args;
use srp_traces::{Format, Window};
use std::path::PathBuf;

/// A window of the simulation as a file of viewers.
#[derive(Args)]
pub(crate) struct Trace {
    /// Record every operation and register of some cycles: A..B, kernel:NAME#N (the N-th launch; @CORE behind it for
    /// another core than 0), or of a frame tile:N or pixel:X,Y. The engine runs as fast as ever outside of them
    #[arg(long, value_name = "WINDOW", value_parser = parse_window)]
    pub(crate) trace: Option<TraceOf>,
    /// The form of the file with the window: by its name's ending where this is left out
    #[arg(long, value_name = "FORMAT", requires = "trace", value_parser = one_of(FORMATS))]
    pub(crate) trace_format: Option<Format>,
    /// The file with the window; `-` is standard output
    #[arg(
        long,
        value_name = "FILE",
        requires = "trace",
        default_value = "trace.fst"
    )]
    pub(crate) trace_output: PathBuf,
}

/// What is recorded.
#[derive(Clone, Debug)]
pub(crate) enum TraceOf {
    /// A window.
    Window(Window),
    /// The tile with a pixel.
    Pixel(u32, u32),
}

fn parse_window(text: &str) -> Result<TraceOf, String> {
    match text.strip_prefix("pixel:") {
        Some(pixel) => parse_pixel(pixel).map(|(x, y)| TraceOf::Pixel(x, y)),
        None => Window::parse(text).map(TraceOf::Window),
    }
}

/// The forms of a file with a window.
const FORMATS: &[Choice<Format>] = &[
    Choice {
        value: Format::Perfetto,
        name: "perfetto",
        what: "A timeline, for ui.perfetto.dev (.pftrace, .perfetto-trace)",
    },
    Choice {
        value: Format::Fst,
        name: "fst",
        what: "Waves, for GTKWave and Surfer (.fst)",
    },
    Choice {
        value: Format::Konata,
        name: "konata",
        what: "A line for each operation, for Konata (.kanata, .log)",
    },
];
