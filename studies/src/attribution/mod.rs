//! Where the errors of a picture come from: a frame [without a clock](crate::functional), with
//! [shadows](srp_ir::shadow) in binary64 beside it.
//!
//! The shadow of a ray is followed to the triangle that the unit has hit, by exact formulas; the error of the
//! hit is shared between the ray and the stages of the unit. If the shadow would hit another triangle, that
//! is a flip, and the shadow goes on from the unit's hit.
//!
//! A pixel's colour is the value that its bytes were converted from: nothing here is rounded to bytes. Its
//! error is the sum of the contributions of all sources, exactly. Every tile is a run of its own, as in the
//! frame without shadows, so the result does not depend on the number of threads.

mod exact;
mod explain;
mod flips;
mod pixels;
mod tni;

use crate::functional::{self, FunctionalError, MAX_STEPS, Stage, TileWorld, chosen, each};
use exact::Exact;
use pixels::Share;
use srp_archdesc::Watch;
use srp_archdesc::arch::Arch;
use srp_ir::interp;
use srp_ir::program::Program;
use srp_ir::shadow::Sources;
use srp_runtime::effect::Guard;
use srp_runtime::scene::Triangle;
use srp_runtime::scene_image::SceneImage;
use srp_runtime::tni::arithmetic::stages;
use tni::{FrameShadows, Hardware};

pub use explain::{Explanation, Step, explain};
pub use flips::{Flip, FlipKind};
pub use pixels::{Contribution, Pixel};

/// How a frame is looked into.
pub struct Options<'a> {
    /// Stops the frame where the program meets what it was not built for.
    pub guard: &'a Guard,
    /// Threads of the host; the result is the same for any number.
    pub threads: usize,
    /// The tiles to be looked into; `None` for all of them.
    pub tiles: Option<&'a [u32]>,
    /// Operations of a tile that are remembered at once, 64 bytes each; before that, the history of
    /// its values is made short, which changes no contribution. [`MOST_NODES`] for most purposes.
    pub most_nodes: usize,
    /// Watches the work, tile by tile.
    pub watch: &'a dyn Watch,
}

/// Operations of a tile that are remembered, where nothing else is said: an eighth of a gigabyte
/// for each thread.
pub const MOST_NODES: usize = 1 << 21;

/// A place and an operation, or a unit, that errors come from.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceError {
    /// `file:line`; empty for a unit outside of the program.
    pub at: String,
    /// The operation of the opcode table, or the unit.
    pub what: String,
    /// Its share of the squared error of the picture, summed over pixels and channels, in squared
    /// levels: what it contributes times the whole error. The shares of all sources add up to the
    /// squared error. Negative where it makes the error of others less.
    pub squared: f64,
    /// The squared error that it would make alone.
    pub alone: f64,
    /// Pixels to whose error it contributes most.
    pub pixels: u64,
    /// Flips to which it contributes most.
    pub flips: u64,
}

/// An infinity or a NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct NonFinite {
    /// The operation that made it of finite numbers, by its number in
    /// [`Attribution::sources`].
    pub source: usize,
    /// The value that it made.
    pub value: f32,
    /// How often.
    pub count: u64,
    /// The first pixel that it was made for, if that is known.
    pub pixel: Option<(u32, u32)>,
}

/// Where the errors of a picture come from.
#[derive(Clone, Debug)]
pub struct Attribution {
    /// Width of the picture in pixels.
    pub width: u32,
    /// Its height.
    pub height: u32,
    /// The pixels, row by row; `None` in tiles that were not looked into.
    pub pixels: Vec<Option<Pixel>>,
    /// All sources, by number.
    pub sources: Vec<SourceError>,
    /// The sources that contribute anything, the largest share first, of whatever sign: of two errors that make up for
    /// each other, neither is seen without the other.
    pub ranking: Vec<usize>,
    /// Squared error of the picture, summed over pixels and channels, in squared levels of 0 to 255.
    pub squared_error: f64,
    /// Decisions that binary64 makes otherwise, by tile.
    pub flips: Vec<Flip>,
    /// Infinities and NaNs by what made them, in the order of the sources.
    pub non_finite: Vec<NonFinite>,
    /// True if it was not cancelled.
    pub complete: bool,
}

impl Attribution {
    /// A pixel that was looked into.
    pub fn pixel(&self, x: u32, y: u32) -> Option<&Pixel> {
        let inside = x < self.width && y < self.height;
        let at = (y * self.width + x) as usize;
        self.pixels.get(at).filter(|_| inside)?.as_ref()
    }
}

/// Data that the runs of all tiles share.
struct Studio<'a> {
    stage: Stage<'a>,
    sources: Sources,
    hardware: Hardware<'a>,
    most_nodes: usize,
}

/// Column and row of a pixel.
type Place = (u32, u32);

/// Findings in a tile.
struct Found {
    pixels: Vec<(Place, Pixel)>,
    shares: Vec<Share>,
    flips: Vec<Flip>,
    non_finite: Vec<(srp_ir::shadow::NonFinite, Option<Place>)>,
}

/// Runs the tiles of a frame with shadows. `program` and `image` are as for
/// [`functional::render`], `triangles` those of the scene in the image.
pub fn attribute(
    triangles: &[Triangle],
    image: &SceneImage,
    program: &Program,
    arch: &Arch,
    options: Options<'_>,
) -> Result<Attribution, FunctionalError> {
    let layout = functional::layout(program, arch)?;
    let stage = Stage::of(image, program, arch, &layout, options.guard, MAX_STEPS)?;
    let exact = Exact::of(triangles);
    let studio = Studio::of(stage, &exact, triangles.len(), options.most_nodes);
    let tiles = chosen(options.tiles, image.tiles)?;
    let run = |tile| studio.look_into(tile);
    let runs = each(&tiles, options.threads, run, options.watch);
    let mut attribution = studio.nothing();
    let mut done = 0;
    for (_, found) in runs {
        attribution.add(found?);
        done += 1;
    }
    attribution.complete = done == tiles.len();
    attribution.rank();
    Ok(attribution)
}

impl<'a> Studio<'a> {
    fn of(stage: Stage<'a>, exact: &'a Exact, triangles: usize, most_nodes: usize) -> Studio<'a> {
        let test = stage.arch.system.tni.intersection;
        let units = tni::units(stages(test));
        let units: Vec<&str> = units.iter().map(String::as_str).collect();
        Studio {
            sources: Sources::of(stage.program, &units),
            hardware: Hardware::of(&stage, exact, triangles),
            stage,
            most_nodes,
        }
    }

    /// Runs a tile with shadows.
    fn run(
        &self,
        tile: u32,
        most_nodes: usize,
    ) -> Result<(FrameShadows<'_>, TileWorld<'_>), FunctionalError> {
        let mut world = TileWorld::new(&self.stage, Some(tile));
        let mut shadows =
            FrameShadows::new(&self.hardware, &self.sources, self.stage.arch, most_nodes);
        let ran = interp::run_observed(
            &self.stage.code,
            self.stage.main,
            &[],
            &mut world,
            &mut shadows,
            &self.stage.options(),
        );
        world.judge(ran, Some(tile), self.stage.program)?;
        Ok((shadows, world))
    }

    fn look_into(&self, tile: u32) -> Result<Found, FunctionalError> {
        let (shadows, world) = self.run(tile, self.most_nodes)?;
        let (_, writes) = world.finish();
        let mut found = pixels::of(&shadows.shadows, &self.stage.image.frame, &writes);
        let place = |tag: u32| self.place(tile, tag);
        found.flips = flips::of(self, &shadows, &place);
        for flip in &found.flips {
            let pixel = found
                .pixels
                .iter_mut()
                .find(|(at, _)| Some(*at) == flip.pixel);
            if let Some((_, pixel)) = pixel {
                pixel.flips += 1;
            }
        }
        let non_finite = shadows.shadows.non_finite.iter();
        found.non_finite = non_finite.map(|n| (*n, place(n.tag))).collect();
        Ok(found)
    }

    /// The pixel of a tile with this tag: the number of its ray in a packet of primary rays.
    fn place(&self, tile: u32, tag: u32) -> Option<(u32, u32)> {
        let image = self.stage.image;
        let (width, height) =
            srp_runtime::scene_image::tile_size(self.stage.arch.system.buffers.rays);
        let across = image.frame.stride / width;
        if tag >= width * height {
            return None;
        }
        let (x, y) = (
            tile % across * width + tag % width,
            tile / across * height + tag / width,
        );
        (x < image.frame.width && y < image.frame.height).then_some((x, y))
    }

    /// `file:line` of a source, and what it is.
    fn name(&self, source: u32) -> (String, String) {
        let Some(source) = self.sources.get(source) else {
            return Default::default();
        };
        let at = source
            .at
            .filter(|(_, line)| *line > 0)
            .and_then(|(file, line)| {
                let file = self.stage.program.files.get(file)?;
                Some(format!("{file}:{line}"))
            });
        (at.unwrap_or_default(), source.what.to_string())
    }

    fn nothing(&self) -> Attribution {
        let frame = &self.stage.image.frame;
        let source = |i| {
            let (at, what) = self.name(i);
            SourceError {
                at,
                what,
                squared: 0.0,
                alone: 0.0,
                pixels: 0,
                flips: 0,
            }
        };
        Attribution {
            width: frame.width,
            height: frame.height,
            pixels: vec![None; (frame.width * frame.height) as usize],
            sources: (0..self.sources.len() as u32).map(source).collect(),
            ranking: Vec::new(),
            squared_error: 0.0,
            flips: Vec::new(),
            non_finite: Vec::new(),
            complete: false,
        }
    }
}

impl Attribution {
    fn add(&mut self, found: Found) {
        for ((x, y), pixel) in found.pixels {
            self.squared_error += pixel.squared_error();
            if let Some(top) = pixel.top.first() {
                self.sources[top.source].pixels += 1;
            }
            self.pixels[(y * self.width + x) as usize] = Some(pixel);
        }
        for (source, share) in found.shares.iter().enumerate() {
            self.sources[source].squared += share.squared;
            self.sources[source].alone += share.alone;
        }
        for flip in &found.flips {
            if let Some(top) = flip.because.first() {
                self.sources[top.source].flips += 1;
            }
        }
        self.flips.extend(found.flips);
        for (made, pixel) in found.non_finite {
            let (source, value) = (made.source as usize, made.value);
            let same =
                |n: &&mut NonFinite| n.source == source && n.value.to_bits() == value.to_bits();
            match self.non_finite.iter_mut().find(same) {
                Some(known) => known.count += 1,
                None => self.non_finite.push(NonFinite {
                    source,
                    value,
                    count: 1,
                    pixel,
                }),
            }
        }
    }

    fn rank(&mut self) {
        let sources = &self.sources;
        let counts = |i: &usize| sources[*i].alone > 0.0 || sources[*i].flips > 0;
        self.ranking = (0..sources.len()).filter(counts).collect();
        self.ranking.sort_by(|&a, &b| {
            sources[b]
                .squared
                .abs()
                .total_cmp(&sources[a].squared.abs())
        });
        self.non_finite
            .sort_by_key(|n| (n.source, n.value.to_bits()));
    }
}
