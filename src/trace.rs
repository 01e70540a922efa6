//! Traces: a window of a simulation, written for viewers.

use crate::cli::{Trace, TraceOf};
use crate::count::count;
use crate::failure::Failure;
use crate::{files, talk};
use srp_archdesc::arch::Arch;
use srp_ir::check::Checked;
use srp_runtime::core::Core;
use srp_runtime::scene_image::tile_size;
use srp_toolchain::{Engines, Error};
use srp_traces::{Format, MAX_CYCLES, TraceError, Tracer, Window};
use std::path::{Path, PathBuf};

/// A file that a trace goes to.
pub(crate) struct Target {
    window: Window,
    format: Format,
    path: PathBuf,
}

impl Target {
    /// The file that is asked for of a program without a frame, which can be written.
    pub(crate) fn of_program(args: &Trace) -> Result<Option<Target>, Failure> {
        match args.trace.clone() {
            None => Ok(None),
            Some(TraceOf::Window(window)) if !matches!(window, Window::Tile(_)) => {
                Target::to(args, window).map(Some)
            }
            Some(_) => {
                let why = "--trace: only frames have tiles and pixels; write A..B or kernel:NAME#N";
                Err(Failure::Usage(why.to_owned()))
            }
        }
    }

    /// The same of a frame of this size.
    pub(crate) fn of_frame(
        args: &Trace,
        arch: &Arch,
        (width, height): (u32, u32),
    ) -> Result<Option<Target>, Failure> {
        let (across, down) = tile_size(arch.system.buffers.rays);
        let columns = width.div_ceil(across);
        let tiles = columns * height.div_ceil(down);
        let window = match args.trace.clone() {
            None => return Ok(None),
            Some(TraceOf::Pixel(x, y)) if x < width && y < height => {
                Window::Tile(y / down * columns + x / across)
            }
            Some(TraceOf::Pixel(x, y)) => {
                return Err(Failure::Message(format!(
                    "--trace pixel:{x},{y}: the frame has {width}x{height} pixels"
                )));
            }
            Some(TraceOf::Window(Window::Tile(tile))) if tile >= tiles => {
                return Err(Failure::Message(format!(
                    "--trace tile:{tile}: the frame has {}, from 0",
                    count(u64::from(tiles), "tile")
                )));
            }
            Some(TraceOf::Window(window)) => window,
        };
        Target::to(args, window).map(Some)
    }

    /// The file that is asked for, which can be written.
    fn to(args: &Trace, window: Window) -> Result<Target, Failure> {
        let path = args.trace_output.clone();
        let format = match args.trace_format.or_else(|| by_name(&path)) {
            Some(format) => format,
            None => {
                return Err(Failure::Usage(format!(
                    "--trace-output {}: its name ends in no form's own way; write --trace-format too",
                    path.display()
                )));
            }
        };
        files::check_writable(&path)?;
        Ok(Target {
            window,
            format,
            path,
        })
    }

    /// A tracer of a program on so many cores. Says how large the file can be.
    pub(crate) fn tracer(&self, program: &Checked, cores: u32) -> Result<Tracer, Failure> {
        let tracer = Tracer::new(program, self.window.clone());
        let tracer = tracer.map_err(|error| match error {
            TraceError::TooManyStages(error) => Error::from(error).into(),
            error => Failure::message(error),
        })?;
        let (cycles, cores) = match &self.window {
            Window::Cycles(cycles) => (cycles.end - cycles.start, cores),
            Window::Launch { core, .. } if *core >= cores => {
                return Err(Failure::Message(format!(
                    "--trace: there is no core {core}; {} from 0",
                    count(u64::from(cores), "core")
                )));
            }
            Window::Launch { .. } | Window::Tile(_) => (MAX_CYCLES, 1),
        };
        let bytes = tracer.largest(self.format, cycles, cores);
        talk::say(format_args!(
            "trace: {}, at most {}: {} has at most {:.1} MB",
            self.window,
            count(cycles, "cycle"),
            self.path.display(),
            bytes as f64 / 1e6
        ));
        Ok(tracer)
    }

    /// Writes what was recorded.
    pub(crate) fn write(&self, tracer: &Tracer) -> Result<(), Failure> {
        let trace = tracer.trace().map_err(Failure::message)?;
        let bytes = self.format.write(&trace).map_err(Failure::message)?;
        files::write(&self.path, &bytes)?;
        let cycles = trace.cycles.clone();
        talk::say(format_args!(
            "trace: cycles {}..{} to {}",
            cycles.start,
            cycles.end,
            self.path.display()
        ));
        if trace.is_cut {
            talk::say("note: the window is longer; a trace has no room for the rest");
        }
        Ok(())
    }
}

/// The form that a file's name asks for.
fn by_name(path: &Path) -> Option<Format> {
    match path.extension()?.to_str()? {
        "fst" => Some(Format::Fst),
        "pftrace" | "perfetto-trace" => Some(Format::Perfetto),
        "kanata" | "konata" | "log" => Some(Format::Konata),
        _ => None,
    }
}

/// So many cores, which record for a tracer.
pub(crate) fn cores(tracer: &mut Tracer, engines: &Engines, count: u32) -> Vec<Box<dyn Core>> {
    let fast = engines.cores(count).into_iter();
    fast.map(|core| tracer.core(core)).collect()
}
