//! Where a picture's error comes from: the run of its program with shadows in binary64, summed up.

use crate::Error;
use crate::attribution::{self, Attribution, FlipKind, MOST_NODES, Options};
use serde::{Deserialize, Serialize};
use srp_runtime::effect::Guard;
use srp_runtime::scene_image::SceneImage;
use srp_toolchain::{Frame, Session};
use std::collections::BTreeMap;

/// Sources that are told.
const MOST_TOLD: usize = 24;

/// Where the errors of a picture come from, and which decisions binary64 makes otherwise.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct AttributionSummary {
    /// Tiles that were looked into, and all of them.
    pub tiles: (u32, u32),
    /// Decisions that binary64 makes otherwise, by kind.
    pub flips: BTreeMap<String, u64>,
    /// Pixels on whose way there are any.
    pub flipped_pixels: u32,
    /// Squared error over pixels and channels, in squared levels, of pixels that follow the same
    /// decisions.
    pub squared_error: f64,
    /// The part of it that lines and units have been named for.
    pub named: f64,
    /// Lines and units, the largest share first.
    pub sources: Vec<ErrorSource>,
    /// The operations that made infinities and NaNs out of finite numbers.
    pub non_finite: Vec<String>,
}

/// A line and its operation, or a unit.
#[derive(Clone, Debug, Serialize, Deserialize)]
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
    /// Attributes the errors in one tile of so many, drawn by a hash of their numbers.
    ///
    /// # Errors
    ///
    /// The kernels do not fit the machine, or the work was cancelled.
    pub(super) fn of(
        frame: &Frame,
        image: &SceneImage,
        one_in: u32,
        session: &Session<'_>,
    ) -> Result<AttributionSummary, Error> {
        let arch = &frame.arch;
        let (program, _) = frame.build.program(None, arch)?;
        let tiles: Vec<u32> = (0..image.tiles).filter(|t| drawn(*t, one_in)).collect();
        let options = Options {
            guard: &Guard::default(),
            threads: 1,
            tiles: Some(&tiles),
            most_nodes: MOST_NODES,
            watch: session.watch,
        };
        let found = attribution::attribute(&frame.scene.triangles, image, &program, arch, options);
        session.check()?;
        let found = found.map_err(Error::invalid)?;
        Ok(AttributionSummary {
            tiles: (tiles.len() as u32, image.tiles),
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

/// True when a tile is one of those that are looked into.
fn drawn(tile: u32, one_in: u32) -> bool {
    let scrambled = (tile ^ tile >> 7).wrapping_mul(0x9e37_79b9) >> 12;
    scrambled.is_multiple_of(one_in)
}
