//! Where a picture's error comes from: the run of its program with shadows in binary64.

use super::setting::Subject;
use super::trial::Studio;
use crate::failure::Failure;
use crate::interrupt;
use serde::{Deserialize, Serialize};
use srp_runtime::effect::Guard;
use srp_runtime::scene_image;
use srp_studies::attribution::{
    self, Attribution, FlipKind, MOST_NODES, Options, reflecting_lines,
};
use std::collections::{BTreeMap, BTreeSet};

/// Sources that are told.
const MOST_TOLD: usize = 24;

/// Where the errors of a picture come from, and what was decided otherwise.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Blame {
    /// Tiles that were looked into, and all of them.
    pub(super) tiles: (u32, u32),
    /// Decisions that binary64 makes otherwise, by kind.
    pub(super) flips: BTreeMap<String, u64>,
    /// Pixels on whose way there are any.
    pub(super) flipped_pixels: u32,
    /// Squared error over pixels and channels, in squared levels, of pixels that follow the same
    /// decisions.
    pub(super) squared_error: f64,
    /// The part of it that lines and units have been named for.
    pub(super) named: f64,
    /// Lines and units, the largest share first.
    pub(super) sources: Vec<Source>,
    /// What made infinities and NaNs out of finite numbers.
    pub(super) non_finite: Vec<String>,
}

/// A line and its operation, or a unit.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Source {
    /// `file:line`; empty for a unit outside of the program.
    pub(super) at: String,
    /// The operation, or the unit.
    pub(super) what: String,
    /// Its part of the squared error; negative where it makes that of others less.
    pub(super) part: f64,
    /// Pixels to whose error it contributes most.
    pub(super) pixels: u64,
    /// Decisions that fall otherwise mostly for it.
    pub(super) flips: u64,
}

impl Source {
    /// Its name.
    pub(super) fn name(&self) -> String {
        match self.at.is_empty() {
            true => self.what.clone(),
            false => format!("{} {}", self.at, self.what),
        }
    }
}

impl Blame {
    /// Looks into one tile of so many, drawn by a hash of their numbers.
    pub(super) fn of(
        studio: &Studio<'_>,
        subject: &Subject,
        one_in: u32,
    ) -> Result<Blame, Failure> {
        let scene = studio.scene_of(subject);
        let arch = &subject.arch;
        let (program, _) = subject.build.program(None, arch)?;
        let image = scene_image::build(&scene, studio.bvh, &scene.camera, arch, studio.size)
            .map_err(Failure::message)?;
        let tiles: Vec<u32> = (0..image.tiles).filter(|t| drawn(*t, one_in)).collect();
        let options = Options {
            guard: &Guard::default(),
            threads: 1,
            tiles: Some(&tiles),
            total_reflection: &lines(),
            most_nodes: MOST_NODES,
            watch: studio.session.watch,
        };
        let found = attribution::attribute(&scene.triangles, &image, &program, arch, options);
        interrupt::end_if_requested()?;
        let found = found.map_err(Failure::message)?;
        Ok(Blame {
            tiles: (tiles.len() as u32, image.tiles),
            ..Blame::summed(&found)
        })
    }

    fn summed(found: &Attribution) -> Blame {
        let whole = found.squared_error.max(f64::MIN_POSITIVE);
        let source = |&i: &usize| {
            let s = &found.sources[i];
            Source {
                at: s.at.clone(),
                what: s.what.clone(),
                part: s.squared / whole,
                pixels: s.pixels,
                flips: s.flips,
            }
        };
        let name = |i: usize| source(&i).name();
        let sources: Vec<Source> = found.ranking.iter().take(MOST_TOLD).map(source).collect();
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
        Blame {
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
    pub(super) fn all_flips(&self) -> u64 {
        self.flips.values().sum()
    }
}

/// Whether a tile is one of those that are looked into.
fn drawn(tile: u32, one_in: u32) -> bool {
    let scrambled = (tile ^ tile >> 7).wrapping_mul(0x9e37_79b9) >> 12;
    scrambled.is_multiple_of(one_in)
}

/// The lines of the kernels that decide about total reflection.
pub(super) fn lines() -> BTreeSet<(String, u32)> {
    let sources = srp_kernels::SOURCES.iter();
    sources
        .flat_map(|s| reflecting_lines(s.path, s.text))
        .collect()
}
