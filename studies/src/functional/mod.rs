//! A frame without a clock: the program runs by its meaning ([`srp_ir::interp`]), and the T&I unit
//! answers at once.
//!
//! The colour of a pixel depends on its tile alone, so each tile is a run of the whole program that gets one
//! tile and no other: tiles can be run in parallel, or some of them only, and each has counts of its own. The
//! picture is that of the system with a clock, to the bit. The work of the program before its first tile and
//! after its last is [counted](Frame::idle) apart, for every core does it once.

mod world;

use srp_archdesc::arch::Arch;
use srp_archdesc::threads;
use srp_archdesc::watch::{Stage as Steps, Watch};
use srp_ir::interp::{self, Code, Profile};
use srp_ir::layout::{Layout, TooLarge};
use srp_ir::program::{Func, Program};
use srp_runtime::effect::{Guard, Missing};
use srp_runtime::memory::SystemMemory;
use srp_runtime::picture::Picture;
use srp_runtime::scene_image::SceneImage;
use srp_runtime::system;
use srp_runtime::tni::{RayCounts, Untimed};
use std::fmt;
use std::ops::AddAssign;
use std::sync::atomic::{AtomicUsize, Ordering};

pub(crate) use world::TileWorld;

/// How a frame is run.
pub struct Options<'a> {
    /// Stops the frame where the program meets what it was not built for.
    pub guard: &'a Guard,
    /// Threads of the host; the result is the same for any number.
    pub threads: usize,
    /// The tiles to be run, in any order; `None` for all of them.
    pub tiles: Option<&'a [u32]>,
    /// Most instructions of a tile.
    pub steps: u64,
    /// Watches the work, tile by tile.
    pub watch: &'a dyn Watch,
}

/// Instructions after which a tile is given up, where nothing else is said.
pub const MAX_STEPS: u64 = 1 << 33;

/// Counts of a tile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Counts of its rays.
    pub rays: RayCounts,
    /// Instructions, jumps and returns of the program.
    pub steps: u64,
    /// Lookups of the texture unit, four texels each.
    pub texture_lookups: u64,
    /// Loads through the data cache.
    pub cached_loads: u64,
    /// Stores through the data cache.
    pub cached_stores: u64,
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Counts) {
        self.rays += other.rays;
        self.steps += other.steps;
        self.texture_lookups += other.texture_lookups;
        self.cached_loads += other.cached_loads;
        self.cached_stores += other.cached_stores;
    }
}

/// A frame.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The picture; black where no tile was run.
    pub picture: Picture,
    /// Each tile that was run, by number, with what it took beyond [`idle`](Self::idle).
    pub tiles: Vec<(u32, Counts)>,
    /// How often each part of the program ran for all these tiles, beyond a run without a tile.
    pub profile: Profile,
    /// Counts of a core that gets no tile.
    pub idle: Counts,
    /// True if it was not cancelled.
    pub complete: bool,
}

impl Frame {
    /// Returns the counts of all tiles together, with those of the cores before and after them.
    pub fn counts(&self, cores: u32) -> Counts {
        let mut sum = Counts::default();
        for (_, counts) in &self.tiles {
            sum += *counts;
        }
        for _ in 0..cores {
            sum += self.idle;
        }
        sum
    }
}

/// Why there is no frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FunctionalError {
    /// The program has no function `main` without parameters.
    NoMain,
    /// The machine cannot be simulated.
    Machine(String),
    /// The program's data do not fit.
    TooLarge(TooLarge),
    /// There is no such tile.
    Tile {
        /// Its number.
        tile: u32,
        /// Tiles of the frame.
        of: u32,
    },
    /// The program did something that cannot be done.
    Trap {
        /// The tile it was at work on, if it was.
        tile: Option<u32>,
        /// The fault, and where it happened.
        what: String,
    },
    /// The program handed the T&I unit buffers that are not in the SRAM.
    Submission {
        /// Address of the buffer.
        address: u32,
        /// Its size in bytes.
        bytes: u32,
    },
    /// The program has met what it was not built for.
    Effect(Missing),
}

impl fmt::Display for FunctionalError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FunctionalError::NoMain => {
                f.write_str("the program has no function `main` to start with")
            }
            FunctionalError::Machine(why) => write!(f, "this machine cannot be simulated: {why}"),
            FunctionalError::TooLarge(error) => error.fmt(f),
            FunctionalError::Tile { tile, of } => {
                write!(f, "there is no tile {tile}: the frame has {of}")
            }
            FunctionalError::Trap {
                tile: Some(tile),
                what,
            } => write!(f, "in tile {tile}: {what}"),
            FunctionalError::Trap { tile: None, what } => f.write_str(what),
            FunctionalError::Submission { address, bytes } => write!(
                f,
                "the T&I unit was handed a buffer of {bytes} bytes at {address:#x}, which is \
                 outside the SRAM or not aligned to 4 bytes"
            ),
            FunctionalError::Effect(missing) => missing.fmt(f),
        }
    }
}

impl std::error::Error for FunctionalError {}

/// A tile that was run.
struct Tile {
    counts: Counts,
    profile: Profile,
    /// Words written to the frame buffer: bytes from its start, and the word.
    writes: Vec<(u32, u32)>,
}

/// Everything that the runs of all tiles share.
pub(crate) struct Stage<'a> {
    pub(crate) image: &'a SceneImage,
    pub(crate) arch: &'a Arch,
    pub(crate) guard: &'a Guard,
    /// The T&I unit at the start of a tile.
    pub(crate) tni: Untimed,
    pub(crate) code: Code<'a>,
    pub(crate) layout: &'a Layout,
    pub(crate) program: &'a Program,
    pub(crate) main: Func,
    pub(crate) steps: u64,
}

/// Runs the tiles of a frame. `program` is verified and after the passes: what
/// [`split`](srp_ir::split::split()) and the scheduler would make the program of the system of.
pub fn render(
    image: &SceneImage,
    program: &Program,
    arch: &Arch,
    options: Options<'_>,
) -> Result<Frame, FunctionalError> {
    let layout = layout(program, arch)?;
    let stage = Stage::of(image, program, arch, &layout, options.guard, options.steps)?;
    let tiles = chosen(options.tiles, image.tiles)?;
    let mut idle = stage.run(None)?;
    idle.counts.steps = idle.profile.steps;
    let mut frame = Frame {
        picture: Picture::of(&image.memory, &image.frame),
        tiles: Vec::with_capacity(tiles.len()),
        profile: Profile::new(program),
        idle: idle.counts,
        complete: false,
    };
    let mut memory = image.memory.clone();
    let runs = each(
        &tiles,
        options.threads,
        |tile| stage.run(Some(tile)),
        options.watch,
    );
    for (tile, run) in runs {
        let run = run?;
        write(&mut memory, image.frame.address, &run.writes);
        frame.profile.add_beyond(&run.profile, &idle.profile);
        frame.tiles.push((tile, run.counts.beyond(&idle.counts)));
    }
    frame.complete = frame.tiles.len() == tiles.len();
    frame.picture = Picture::of(&memory, &image.frame);
    Ok(frame)
}

/// The layout of a program in the SRAM of a machine that can be simulated.
pub(crate) fn layout(program: &Program, arch: &Arch) -> Result<Layout, FunctionalError> {
    system::check(&arch.system).map_err(FunctionalError::Machine)?;
    Layout::of(program, arch.system.sram_bytes).map_err(FunctionalError::TooLarge)
}

/// The tiles that were asked for, each once, in order.
pub(crate) fn chosen(tiles: Option<&[u32]>, of: u32) -> Result<Vec<u32>, FunctionalError> {
    let Some(tiles) = tiles else {
        return Ok((0..of).collect());
    };
    let mut tiles = tiles.to_vec();
    tiles.sort_unstable();
    tiles.dedup();
    match tiles.last() {
        Some(&tile) if tile >= of => Err(FunctionalError::Tile { tile, of }),
        _ => Ok(tiles),
    }
}

/// Runs something for each tile, several at once, and gives the results by the order of the tiles:
/// those that were done before it was cancelled or one failed.
pub(crate) fn each<T: Send, E: Send>(
    tiles: &[u32],
    threads: usize,
    run: impl Fn(u32) -> Result<T, E> + Sync,
    watch: &dyn Watch,
) -> Vec<(u32, Result<T, E>)> {
    let stage = Steps::of(watch, "tiles", tiles.len() as u64);
    let failed = AtomicUsize::new(usize::MAX);
    // Tiles before one that failed are run all the same: the first failure counts.
    let state = || ();
    let done = threads::some(threads, tiles.len(), state, |(), i| {
        if i > failed.load(Ordering::Relaxed) || watch.cancelled() {
            return None;
        }
        let result = run(tiles[i]);
        if result.is_err() {
            failed.fetch_min(i, Ordering::Relaxed);
        }
        stage.done(1);
        Some((tiles[i], result))
    });
    done.into_iter().flatten().collect()
}

fn write(memory: &mut SystemMemory, start: u32, writes: &[(u32, u32)]) {
    for &(offset, word) in writes {
        if let Some(bytes) = memory.get_mut(start + offset, 4) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
    }
}

impl<'a> Stage<'a> {
    pub(crate) fn of(
        image: &'a SceneImage,
        program: &'a Program,
        arch: &'a Arch,
        layout: &'a Layout,
        guard: &'a Guard,
        steps: u64,
    ) -> Result<Stage<'a>, FunctionalError> {
        let main = program.main.filter(|&main| {
            let main = &program.funcs[main];
            main.blocks[main.entry()].params.is_empty()
        });
        let spec = &arch.system.tni;
        let ray_buffers = arch.system.buffers.ray_buffers;
        Ok(Stage {
            image,
            arch,
            guard,
            tni: Untimed::new(spec, image.tree, ray_buffers).having_read(&image.memory),
            code: Code::of(program, layout),
            layout,
            program,
            main: main.ok_or(FunctionalError::NoMain)?,
            steps,
        })
    }

    /// How the program is run.
    pub(crate) fn options(&self) -> interp::Options<'_> {
        interp::Options {
            precision: self.arch.precision,
            steps: self.steps,
            ..interp::Options::new(self.layout)
        }
    }

    /// Runs the program with one tile, or none.
    fn run(&self, tile: Option<u32>) -> Result<Tile, FunctionalError> {
        let mut world = TileWorld::new(self, tile);
        let ran = interp::run_observed(
            &self.code,
            self.main,
            &[],
            &mut world,
            &mut (),
            &self.options(),
        );
        let ran = world.judge(ran, tile, self.program)?;
        let (mut counts, writes) = world.finish();
        counts.steps = ran.profile.steps;
        Ok(Tile {
            counts,
            profile: ran.profile,
            writes,
        })
    }
}

impl Counts {
    fn beyond(mut self, idle: &Counts) -> Counts {
        self.steps -= idle.steps.min(self.steps);
        self.cached_loads -= idle.cached_loads.min(self.cached_loads);
        self.cached_stores -= idle.cached_stores.min(self.cached_stores);
        self.texture_lookups -= idle.texture_lookups.min(self.texture_lookups);
        self
    }
}
