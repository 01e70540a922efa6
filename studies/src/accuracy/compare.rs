//! How far a picture is from the reference.

use super::flip::flip;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use srp_runtime::picture::Picture;

/// A pixel of which a channel is off by more levels has had another decision.
pub(super) const DECIDED: u8 = 8;

/// The difference of two pictures over some of their pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Difference {
    /// Peak signal-to-noise ratio in dB of the bytes; `None` where no byte differs.
    pub psnr: Option<f64>,
    /// Mean of FLIP, from 0 to 1.
    pub flip: f64,
    /// Pixels of which a channel is off by more than a level.
    pub beyond_1: u32,
    /// Pixels of which a channel is off by more than eight levels.
    pub beyond_8: u32,
    /// Pixels that were compared.
    pub pixels: u32,
}

/// A picture beside the reference.
pub(crate) struct Comparison {
    /// The largest difference of a channel of each pixel, in levels.
    pub(super) levels: Vec<u8>,
    squares: Vec<f64>,
    flip: Vec<f64>,
}

impl Comparison {
    /// Compares bytes with the reference, which is rounded to bytes.
    pub(crate) fn of(picture: &Picture, reference: &[DVec3]) -> Comparison {
        let ours: Vec<[f64; 3]> = (picture.rgba.chunks_exact(4))
            .map(|p| [p[0], p[1], p[2]].map(f64::from))
            .collect();
        let theirs: Vec<[f64; 3]> = (reference.iter()).map(|p| p.round().to_array()).collect();
        let unit = |picture: &[[f64; 3]]| -> Vec<[f64; 3]> {
            picture.iter().map(|p| p.map(|c| c / 255.0)).collect()
        };
        let off = |a: &[f64; 3], b: &[f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let both = || ours.iter().zip(&theirs).map(|(a, b)| off(a, b));
        Comparison {
            levels: both()
                .map(|d| d.into_iter().fold(0.0, |m: f64, d| m.max(d.abs())) as u8)
                .collect(),
            squares: both().map(|d| d.into_iter().map(|d| d * d).sum()).collect(),
            flip: flip(&unit(&theirs), &unit(&ours), picture.width as usize),
        }
    }

    /// The largest difference of a channel of each pixel, in levels.
    pub(crate) fn levels(&self) -> &[u8] {
        &self.levels
    }

    /// The squared difference of a pixel, in squared levels, its channels together.
    pub(super) fn squared(&self, pixel: usize) -> f64 {
        self.squares[pixel]
    }

    /// The difference over the pixels for which `counts`.
    pub(crate) fn over(&self, counts: impl Fn(usize) -> bool) -> Difference {
        let pixels: Vec<usize> = (0..self.levels.len()).filter(|&i| counts(i)).collect();
        let sum = |values: &[f64]| pixels.iter().map(|&i| values[i]).sum::<f64>();
        let many = |levels: u8| pixels.iter().filter(|&&i| self.levels[i] > levels).count() as u32;
        let count = pixels.len().max(1) as f64;
        let mean = sum(&self.squares) / (3.0 * count);
        Difference {
            psnr: (mean > 0.0).then(|| 10.0 * libm::log10(255.0 * 255.0 / mean)),
            flip: sum(&self.flip) / count,
            beyond_1: many(1),
            beyond_8: many(8),
            pixels: pixels.len() as u32,
        }
    }
}
