//! A frame: cores, T&I units, bus and memory under one clock.
//!
//! The system ticks and decides nothing: the C code on the cores decides which rays are traced and how
//! their hits are shaded. At any instant the memory comes first, then the T&I
//! units whose cycle begins, then the cores, each in the order of their numbers; so the same input
//! gives the same cycles on any host.
//!
//! An [`Observer`] measures more than the [`Report`] has; a [`TileQueue`] gives the cores less than a whole
//! frame.

mod check;
mod code;
mod core_bus;
mod core_unit;
mod data_cache;
mod error;
mod observer;
mod report;
mod sharing;
mod simulation;
mod snapshot;
mod sram;
mod stepped;
mod texture_cache;
mod tiles;
mod warm;

use srp_archdesc::Arch;
use srp_archdesc::watch::{Unwatched, Watch};

use self::simulation::Simulation;
use crate::core::Core;
use crate::effect::Guard;
use crate::picture::Picture;
use crate::scene_image::SceneImage;

pub use check::check;
pub use code::{CodeSizes, ContextCounters};
pub use error::SystemError;
pub use observer::{
    CoreView, MemoryRequest, Observer, Observers, Requester, SentPacket, Stall, TakenTile,
};
pub use report::{Account, CoreReport, KernelCycles, KernelRuns, PortCycles, Report};
pub use sharing::SharedWords;
pub use simulation::MAX_SILENCE;
pub use snapshot::SystemSnapshot;
pub use stepped::System;
pub use tiles::{QueuedTile, TileQueue, frame_blocks, z_order};
pub use warm::{Misses, WarmCaches};

/// How a frame is run.
pub struct Options<'a> {
    /// Most SRP cycles of a frame.
    pub max_cycles: u64,
    /// Contents of each SRAM at the start, from address 0: the program's data. The rest is zero.
    pub sram_image: &'a [u8],
    /// Stops the frame where the program needs an effect that it was not built for.
    pub guard: Guard,
    /// How the units keep time.
    pub timing: Timing,
    /// Names of the kernels, by their number in the scheduled program.
    pub kernel_names: Vec<String>,
    /// The sizes of the program's code, for machines that fetch code from system memory.
    pub code: CodeSizes,
    /// The tiles that cores take; else all of the frame, in the machine's blocks.
    pub tiles: Option<TileQueue>,
    /// Where the frame begins, if not at its start.
    pub start: Option<&'a SystemSnapshot>,
    /// Takes a snapshot on the way.
    pub checkpoint: Option<&'a mut Checkpoint>,
    /// Sees all events.
    pub observer: Option<&'a mut dyn Observer>,
    /// Watches the frame, tile by tile.
    pub watch: &'a dyn Watch,
}

impl<'a> Options<'a> {
    /// A whole frame, cycle by cycle and without a limit, which nobody watches.
    pub fn new(sram_image: &'a [u8]) -> Options<'a> {
        Options {
            max_cycles: u64::MAX,
            sram_image,
            guard: Guard::default(),
            timing: Timing::default(),
            kernel_names: Vec::new(),
            code: CodeSizes::default(),
            tiles: None,
            start: None,
            checkpoint: None,
            observer: None,
            watch: &Unwatched,
        }
    }
}

/// A snapshot that is taken on the way: at the first instant in or after a cycle at which the frame goes on.
#[derive(Clone, Default)]
pub struct Checkpoint {
    /// The SRP cycle.
    pub cycle: u64,
    /// The snapshot, once it is taken.
    pub taken: Option<SystemSnapshot>,
}

/// How the units of a system keep time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timing {
    /// All of them, cycle by cycle.
    #[default]
    Full,
    /// T&I units answer at once and without memory accesses, so that the kernels can be measured by
    /// themselves.
    RecordedHits,
    /// T&I units answer when the rays would be back if they hindered each other as little as possible.
    Estimated,
    /// T&I units and memory take no time: results are right, and cycles mean nothing.
    Untimed,
}

/// Runs a frame: one SGRT core of the machine for each engine, over the scene in `image`.
/// The picture is the contents of the frame buffer. The account of a cancelled frame ends where it was
/// cancelled, and is not [complete](Report::complete).
///
/// # Errors
///
/// Those of [`run`].
pub fn render(
    mut image: SceneImage,
    engines: Vec<Box<dyn Core>>,
    arch: &Arch,
    options: Options<'_>,
) -> Result<(Picture, Report), SystemError> {
    let report = run(&mut image, engines, arch, options)?;
    Ok((Picture::of(&image.memory, &image.frame), report))
}

/// Runs a frame as [`render`] does; the image gets its pixels.
///
/// # Errors
///
/// The machine cannot be simulated, or the frame was not finished.
pub fn run(
    image: &mut SceneImage,
    engines: Vec<Box<dyn Core>>,
    arch: &Arch,
    options: Options<'_>,
) -> Result<Report, SystemError> {
    check_options(&engines, arch, &options)?;
    let names = options.kernel_names.clone();
    let mut simulation = Simulation::new(image.take(), engines, arch, options)?;
    let cycles = simulation.run();
    let report = cycles.map(|cycles| Report::of(&simulation, cycles, arch, &names));
    image.memory = simulation.into_memory();
    report
}

/// Refuses a frame that cannot begin.
fn check_options(
    engines: &[Box<dyn Core>],
    arch: &Arch,
    options: &Options<'_>,
) -> Result<(), SystemError> {
    if engines.is_empty() {
        return Err(SystemError::NoCores);
    }
    check(&arch.system).map_err(SystemError::Machine)?;
    if arch.system.instruction_cache.is_some() && options.code.bundles.is_empty() {
        let message =
            "it has an instruction cache, and the sizes of the program's bundles are not known";
        return Err(SystemError::Machine(message.to_owned()));
    }
    if arch.srp.shared_contexts && options.code.contexts.is_empty() {
        let message = "its kernels share contexts, and how many each of them has is not known";
        return Err(SystemError::Machine(message.to_owned()));
    }
    let sram_bytes = arch.system.sram_bytes as usize;
    if options.sram_image.len() > sram_bytes {
        return Err(SystemError::Machine(format!(
            "the program's data take {} bytes, and the SRAM has {sram_bytes}",
            options.sram_image.len()
        )));
    }
    Ok(())
}
