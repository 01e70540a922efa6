//! Traces: a window of a simulation, written for viewers.

use crate::cli::{self, TraceOf};
use crate::count::count;
use crate::failure::Failure;
use crate::{files, interrupt, talk};
use srp_archdesc::arch::Arch;
use srp_archdesc::watch::Watch;
use srp_ir::check::Checked;
use srp_runtime::core::Core;
use srp_runtime::memory::SystemMemory;
use srp_runtime::scene_image::{SceneImage, tile_size};
use srp_runtime::solo::{self, Finish, Solo};
use srp_runtime::system::{self, Timing};
use srp_toolchain::{Engines, Error, Frame, Session, system_options};
use srp_traces::{Format, MAX_CYCLES, Trace, TraceError, Tracer, Window};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A file that a trace goes to.
pub(crate) struct Target {
    window: Window,
    format: Format,
    path: PathBuf,
}

impl Target {
    /// The file that is asked for of a program without a frame, which can be written.
    pub(crate) fn of_program(args: &cli::Trace) -> Result<Option<Target>, Failure> {
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
        args: &cli::Trace,
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
    fn to(args: &cli::Trace, window: Window) -> Result<Target, Failure> {
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
        let tracer = Tracer::new(program, self.window.clone()).map_err(refused)?;
        let (cycles, cores) = match &self.window {
            Window::Cycles {
                core: Some(core), ..
            }
            | Window::Launch { core, .. }
                if *core >= cores =>
            {
                return Err(Failure::Message(format!(
                    "--trace: there is no core {core}; {} from 0",
                    count(u64::from(cores), "core")
                )));
            }
            Window::Cycles { cycles, core } => {
                (cycles.end - cycles.start, core.map_or(cores, |_| 1))
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

    /// Records a frame that was run before, with these options but for the observer.
    pub(crate) fn record_frame(
        &self,
        mut tracer: Tracer,
        image: SceneImage,
        engines: &Engines,
        arch: &Arch,
        options: system::Options<'_>,
    ) -> Result<(), Failure> {
        let cores = cores(&mut tracer, engines, arch.system.cores);
        let options = system::Options {
            observer: Some(&mut tracer),
            ..options
        };
        let run = || system::render(image, cores, arch, options);
        interrupt::looked_for(run).map_err(Failure::message)?;
        self.write(&tracer)
    }

    /// Records a program that was run before. How it ends was told then.
    pub(crate) fn record_program(
        &self,
        mut tracer: Tracer,
        mut bus: Solo,
        engines: &Engines,
        limit: u64,
    ) -> Result<(), Failure> {
        let mut core = tracer.core(engines.core());
        let run = || {
            let mut account = Finish::default();
            solo::run_until(core.as_mut(), &mut bus, limit, &Silent, &mut account)
        };
        // How it ends was told before.
        let _ = interrupt::looked_for(run);
        self.write(&tracer)
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

/// Watches a program whose text was printed before.
struct Silent;

impl Watch for Silent {
    fn beneath(&self) -> Option<&dyn Watch> {
        Some(&talk::CONSOLE)
    }

    fn printed(&self, _: &[u8]) -> bool {
        true
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

/// Runs a frame as far as the end of a window of cycles, and records the window. With the memory as it is then.
pub(crate) fn recorded(
    (cycles, core): (Range<u64>, u32),
    image: SceneImage,
    (program, engines): (&Checked, &Engines),
    frame: &Frame,
    session: &Session<'_>,
) -> Result<(Trace, SystemMemory), Failure> {
    let end = cycles.end;
    let window = Window::Cycles {
        cycles,
        core: Some(core),
    };
    let mut tracer = Tracer::new(program, window).map_err(refused)?;
    let cores = cores(&mut tracer, engines, frame.arch.system.cores);
    let options = system_options(
        program,
        &frame.arch,
        frame.guard.clone(),
        Timing::Full,
        session,
    );
    let options = system::Options {
        observer: Some(&mut tracer),
        ..options
    };
    let system = system::System::new(image, cores, &frame.arch, options);
    let mut system = system.map_err(Failure::message)?;
    let mut steps = 0_u32;
    while !system.is_over() && system.cycle() < end {
        system.advance().map_err(Failure::message)?;
        steps = steps.wrapping_add(1);
        if steps.is_multiple_of(1 << 12) {
            interrupt::end_if_requested()?;
        }
    }
    let memory = system.memory().clone();
    drop(system);
    Ok((tracer.trace().map_err(Failure::message)?, memory))
}

fn refused(error: TraceError) -> Failure {
    match error {
        TraceError::TooManyStages(error) => Error::from(error).into(),
        error => Failure::message(error),
    }
}

/// So many cores, which record for a tracer.
pub(crate) fn cores(tracer: &mut Tracer, engines: &Engines, count: u32) -> Vec<Box<dyn Core>> {
    let fast = engines.cores(count).into_iter();
    fast.map(|core| tracer.core(core)).collect()
}
