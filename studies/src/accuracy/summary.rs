//! Where a picture's error comes from: the run of its program with shadows in binary64, summed up.

use super::compare::{Comparison, DECIDED};
use crate::Error;
use crate::attribution::{self, Attribution, Flip, FlipKind, MOST_NODES, Options};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use srp_runtime::effect::Guard;
use srp_runtime::scene_image::{self, SceneImage};
use srp_toolchain::{Frame, Session};
use std::collections::BTreeMap;

/// Sources that are told.
const MOST_TOLD: usize = 24;

/// Decisions that are told, and tiles that are looked into only for them.
const MOST_DECISIONS: usize = 32;
const MOST_TILES: usize = 3;

/// Where the errors of a picture come from, and which decisions binary64 makes otherwise.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct AttributionSummary {
    /// Tiles that were looked into, and all of them.
    pub tiles: (u32, u32),
    /// Decisions that binary64 makes otherwise, by kind.
    pub flips: BTreeMap<String, u64>,
    /// Pixels on whose way there are any.
    pub flipped_pixels: u32,
    /// Squared difference of bytes from the renderer in binary64, over pixels and channels of these tiles, in squared levels.
    pub picture_error: f64,
    /// The part of it that operations and units make, which round where the same program in binary64 does not: squared error
    /// over pixels and channels, in squared levels, before values become bytes.
    pub squared_error: f64,
    /// The part of what operations and units make that lines and units have been named for.
    pub named: f64,
    /// Lines and units, the largest share first.
    pub sources: Vec<ErrorSource>,
    /// The operations that made infinities and NaNs out of finite numbers.
    pub non_finite: Vec<String>,
    /// Decisions that binary64 makes otherwise for pixels that are off by most, with their causes; not all of them.
    pub decisions: Vec<Decision>,
}

/// A decision that binary64 makes otherwise, and the pixel that it changed.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Decision {
    /// Column and row.
    pub pixel: (u32, u32),
    /// Levels by which the pixel is off.
    pub levels: u8,
    /// The kind, as in [`AttributionSummary::flips`].
    pub kind: String,
    /// The line and operation, or the unit, that decides.
    pub at: String,
    /// The decision in words, beside that of binary64.
    pub what: String,
    /// The lines and units whose errors turned it, the largest first.
    pub because: Vec<String>,
}

/// A line and its operation, or a unit.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ErrorSource {
    /// `file:line`; empty for a unit outside of the program.
    pub at: String,
    /// The operation, or the unit.
    pub what: String,
    /// Its part of the squared error; negative where it makes that of others less.
    pub part: f64,
    /// Pixels to whose error it contributes most.
    pub pixels: u64,
    /// Decisions that fall otherwise mostly for it.
    pub flips: u64,
}

impl ErrorSource {
    /// Its name.
    pub fn name(&self) -> String {
        match self.at.is_empty() {
            true => self.what.clone(),
            false => format!("{} {}", self.at, self.what),
        }
    }
}

impl AttributionSummary {
    /// Attributes the errors in one tile of so many, drawn by a hash of their numbers, and the decisions of the pixels
    /// that are off by most levels, in a few more.
    ///
    /// # Errors
    ///
    /// The kernels do not fit the machine, or the work was cancelled.
    pub(super) fn of(
        frame: &Frame,
        image: &SceneImage,
        one_in: u32,
        comparison: &Comparison,
        session: &Session<'_>,
    ) -> Result<AttributionSummary, Error> {
        let levels = comparison.levels();
        let arch = &frame.arch;
        let (program, _) = frame.build.program(arch)?;
        let attribute = |tiles: &[u32]| -> Result<Attribution, Error> {
            let options = Options {
                guard: &Guard::default(),
                threads: 1,
                tiles: Some(tiles),
                most_nodes: MOST_NODES,
                watch: session.watch,
            };
            let triangles = &frame.scene.triangles;
            let found = attribution::attribute(triangles, image, &program, arch, options);
            session.check()?;
            found.map_err(Error::invalid)
        };
        let tiles: Vec<u32> = (0..image.tiles).filter(|t| drawn(*t, one_in)).collect();
        let found = attribute(&tiles)?;
        let mut decisions = decisions(&found, levels);
        let others: Vec<u32> = worst_tiles(image, arch.system.buffers.rays, levels)
            .filter(|&tile| !drawn(tile, one_in))
            .take(MOST_TILES)
            .collect();
        if !others.is_empty() {
            decisions.extend(self::decisions(&attribute(&others)?, levels));
        }
        decisions.sort_by_key(|d| (std::cmp::Reverse(d.levels), d.pixel.1, d.pixel.0));
        decisions.truncate(MOST_DECISIONS);
        let looked_at = (0..found.pixels.len()).filter(|&i| found.pixels[i].is_some());
        Ok(AttributionSummary {
            picture_error: looked_at.map(|i| comparison.squared(i)).sum(),
            tiles: (tiles.len() as u32, image.tiles),
            decisions,
            ..AttributionSummary::summed(&found)
        })
    }

    fn summed(found: &Attribution) -> AttributionSummary {
        let whole = found.squared_error.max(f64::MIN_POSITIVE);
        let source = |&i: &usize| {
            let s = &found.sources[i];
            ErrorSource {
                at: s.at.clone(),
                what: s.what.clone(),
                part: s.squared / whole,
                pixels: s.pixels,
                flips: s.flips,
            }
        };
        let name = |i: usize| source(&i).name();
        let sources: Vec<ErrorSource> = found.ranking.iter().take(MOST_TOLD).map(source).collect();
        let count = |kind: FlipKind| found.flips.iter().filter(|f| f.kind == kind).count() as u64;
        let flipped = (found.pixels.iter().flatten()).filter(|p| p.flips > 0);
        let non_finite = (found.non_finite.iter()).map(|n| {
            let pixel = n
                .pixel
                .map_or(String::new(), |(x, y)| format!(", first for pixel {x},{y}"));
            format!(
                "{} made {} {} times{pixel}",
                name(n.source),
                n.value,
                n.count
            )
        });
        AttributionSummary {
            tiles: (0, 0),
            picture_error: 0.0,
            flips: (FlipKind::ALL.iter())
                .map(|&kind| (kind.name().to_owned(), count(kind)))
                .collect(),
            flipped_pixels: flipped.count() as u32,
            squared_error: found.squared_error,
            named: found
                .ranking
                .iter()
                .map(|&i| found.sources[i].squared)
                .sum::<f64>()
                / whole,
            sources,
            non_finite: non_finite.collect(),
            decisions: Vec::new(),
        }
    }

    /// How much of the picture's difference from the renderer in binary64 is of roundings, in words: the rest of it no line
    /// is named for.
    pub fn of_picture_in_words(&self) -> String {
        let (all, rounding) = (self.picture_error, self.squared_error);
        if all == 0.0 {
            return "No byte differs from the renderer in binary64.".to_owned();
        }
        let part = 100.0 * rounding / all;
        let (all, rounding) = (squared_levels(all), squared_levels(rounding));
        let first = format!(
            "Of {all} squared levels that bytes differ by from the renderer in binary64, operations that round make \
             {rounding} ({part:.3} %) before values become bytes."
        );
        match part < 50.0 {
            true => format!(
                "{first} The rest is of other causes: values fall on the other side of a byte's edge, the kernels compute \
                 something else (an approximation, another formula), or decide otherwise."
            ),
            false => first,
        }
    }

    /// All decisions together.
    pub fn all_flips(&self) -> u64 {
        self.flips.values().sum()
    }

    /// Decisions by kind, in words.
    pub fn flips_in_words(&self) -> String {
        let some = self.flips.iter().filter(|(_, count)| **count > 0);
        let some: Vec<String> = some
            .map(|(kind, count)| format!("{count} {kind}"))
            .collect();
        match some.is_empty() {
            true => "none".to_owned(),
            false => some.join(", "),
        }
    }
}

/// A squared error with as many digits as count.
fn squared_levels(error: f64) -> String {
    match error {
        ..0.001 => format!("{error:.1e}"),
        0.001..100.0 => format!("{error:.3}"),
        _ => format!("{error:.0}"),
    }
}

/// The decisions of pixels that are off by more than a rounding.
fn decisions(found: &Attribution, levels: &[u8]) -> Vec<Decision> {
    let name = |source: usize| {
        let source = &found.sources[source];
        format!("{} {}", source.at, source.what).trim().to_owned()
    };
    let of_pixel = |flip: &Flip| {
        let (x, y) = flip.pixel?;
        let levels = *levels.get((y * found.width + x) as usize)?;
        (levels > DECIDED).then(|| Decision {
            pixel: (x, y),
            levels,
            kind: flip.kind.name().to_owned(),
            at: name(flip.source),
            what: flip.what.clone(),
            because: flip.because.iter().map(|c| name(c.source)).collect(),
        })
    };
    found.flips.iter().filter_map(of_pixel).collect()
}

/// The tiles with pixels that a decision has changed, those with the most first.
fn worst_tiles(image: &SceneImage, rays: u32, levels: &[u8]) -> impl Iterator<Item = u32> {
    let (width, height) = scene_image::tile_size(rays);
    let across = image.frame.stride / width;
    let mut off = BTreeMap::<u32, u32>::new();
    for (at, _) in (0..).zip(levels).filter(|(_, levels)| **levels > DECIDED) {
        let (x, y): (u32, u32) = (at % image.frame.width, at / image.frame.width);
        *off.entry(y / height * across + x / width).or_default() += 1;
    }
    let mut tiles: Vec<(u32, u32)> = off.into_iter().collect();
    tiles.sort_by_key(|&(tile, count)| (std::cmp::Reverse(count), tile));
    tiles.into_iter().map(|(tile, _)| tile)
}

/// True when a tile is one of those that are looked into.
fn drawn(tile: u32, one_in: u32) -> bool {
    let scrambled = (tile ^ tile >> 7).wrapping_mul(0x9e37_79b9) >> 12;
    scrambled.is_multiple_of(one_in)
}
