//! The cost of each pixel, as a picture.

use crate::cli::HeatOf;
use crate::failure::Failure;
use crate::talk;
use srp_runtime::picture::Picture;
use srp_studies::tni::{Outcome, PixelCost};

/// Colours from nothing to the most.
const SCALE: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.02],
    [0.25, 0.05, 0.45],
    [0.72, 0.16, 0.40],
    [0.96, 0.45, 0.13],
    [0.99, 0.80, 0.20],
    [1.0, 1.0, 0.9],
];

/// The picture of a view as PNG. The brightest colour stands for the 99.5th percentile; what it is
/// goes to standard error.
pub(super) fn picture(
    outcome: &Outcome,
    (width, height): (u32, u32),
    of: HeatOf,
) -> Result<Vec<u8>, Failure> {
    let pixels = width as usize * height as usize;
    if outcome.costs.len() > pixels {
        return Err(Failure::Message(format!(
            "the rays have {} pixels, and the picture {pixels}: give a larger --size",
            outcome.costs.len()
        )));
    }
    let value = |cost: &PixelCost| match of {
        HeatOf::Cycles => cost.cycles,
        HeatOf::Visits => cost.visits,
    };
    let mut values: Vec<u64> = outcome.costs.iter().map(value).collect();
    values.resize(pixels, 0);
    let mut sorted = values.clone();
    sorted.sort_unstable();
    let most = sorted[(pixels * 995 / 1000).min(pixels - 1)].max(1);
    talk::say(format_args!(
        "{} a pixel: up to {most} shown, {} at most",
        match of {
            HeatOf::Cycles => "cycles",
            HeatOf::Visits => "node visits",
        },
        sorted[pixels - 1]
    ));
    let rgba = values
        .iter()
        .flat_map(|&value| colour((value as f64 / most as f64).min(1.0)))
        .collect();
    let picture = Picture {
        width,
        height,
        rgba,
    };
    Ok(picture.png())
}

fn colour(part: f64) -> [u8; 4] {
    let at = part * (SCALE.len() - 1) as f64;
    let below = (at as usize).min(SCALE.len() - 2);
    let part = at - below as f64;
    let channel = |i: usize| {
        let mixed = SCALE[below][i] * (1.0 - part) + SCALE[below + 1][i] * part;
        (255.0 * mixed + 0.5) as u8
    };
    [channel(0), channel(1), channel(2), 255]
}
