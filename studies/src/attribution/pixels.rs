//! The pixels of a tile: their colours, and what each source contributes to their errors.

use super::Found;
use srp_ir::shadow::Shadows;
use srp_ir::shadow::tape::{Contributions, Sweep};
use srp_runtime::scene_image::FrameBuffer;

/// Sources that are kept for each pixel.
const MOST_TOLD: usize = 4;

/// The contribution of a source to the error of a colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// The source, by its number in [`Attribution::sources`](super::Attribution::sources).
    pub source: usize,
    /// The error that it contributes: red, green and blue in levels, for pixels.
    pub error: [f64; 3],
}

impl Contribution {
    /// Its length.
    pub fn size(&self) -> f64 {
        self.error.iter().map(|e| e * e).sum::<f64>().sqrt()
    }
}

/// A pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Pixel {
    /// The value that its bytes were converted from: red, green and blue in levels from 0 to 255, and
    /// whatever the program adds before it converts (the kernels add a half). Where they were not converted
    /// from floats with an error, the bytes.
    pub value: [f64; 3],
    /// The same in binary64, following the run's decisions.
    pub exact: [f64; 3],
    /// Decisions on its way that binary64 makes otherwise.
    pub flips: u32,
    /// The sources that contribute most, the largest first.
    pub top: Vec<Contribution>,
}

impl Pixel {
    /// Value less shadow, by channel.
    pub fn error(&self) -> [f64; 3] {
        std::array::from_fn(|i| self.value[i] - self.exact[i])
    }

    /// Its square, summed over the channels.
    pub fn squared_error(&self) -> f64 {
        self.error().iter().map(|e| e * e).sum()
    }
}

/// The contribution of a source to the squared error.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Share {
    pub(super) squared: f64,
    pub(super) alone: f64,
}

/// The channels of a pixel: its value, its nodes, and how the conversion of each node counts.
pub(super) struct Written {
    pub(super) value: [f64; 3],
    pub(super) nodes: [u32; 3],
}

impl Written {
    /// For a sweep: each channel is a result of its own.
    pub(super) fn roots(&self) -> [(u32, [f64; 3]); 3] {
        std::array::from_fn(|i| {
            let mut weight = [0.0; 3];
            weight[i] = 1.0;
            (self.nodes[i], weight)
        })
    }
}

/// The pixels that were written, with their places.
pub(super) fn written(
    shadows: &Shadows<'_>,
    frame: &FrameBuffer,
    writes: &[(u32, u32)],
) -> Vec<((u32, u32), Written)> {
    let mut floats: std::collections::BTreeMap<u32, _> = shadows.written_bytes().collect();
    let pixel = |&(offset, word): &(u32, u32)| {
        let (x, y) = (offset / 4 % frame.stride, offset / 4 / frame.stride);
        let bytes = word.to_le_bytes();
        let converted = floats.remove(&(frame.address + offset)).unwrap_or_default();
        let written = Written {
            value: std::array::from_fn(|i| match converted[i] {
                Some(converted) => f64::from(converted.value),
                None => f64::from(bytes[i]),
            }),
            nodes: std::array::from_fn(|i| converted[i].map_or(0, |converted| converted.node)),
        };
        ((x, y), written)
    };
    let pixels = writes.iter().map(pixel);
    let inside = |&((x, y), _): &((u32, u32), _)| x < frame.width && y < frame.height;
    pixels.filter(inside).collect()
}

/// The pixels of a tile, and the shares of the sources, by number.
pub(super) fn of(shadows: &Shadows<'_>, frame: &FrameBuffer, writes: &[(u32, u32)]) -> Found {
    let (mut sweep, mut contributions) = (Sweep::default(), Contributions::default());
    let mut shares: Vec<Share> = Vec::new();
    let mut pixels = Vec::new();
    for (place, written) in written(shadows, frame, writes) {
        let error = written.nodes.map(|node| shadows.tape.error(node));
        contributions.collect(&mut sweep, &shadows.tape, &written.roots());
        for &source in &contributions.sources {
            let of = contributions.of(source);
            let source = source as usize;
            if source >= shares.len() {
                shares.resize(source + 1, Share::default());
            }
            for i in 0..3 {
                shares[source].squared += of[i] * error[i];
                shares[source].alone += of[i] * of[i];
            }
        }
        let pixel = Pixel {
            exact: std::array::from_fn(|i| written.value[i] - error[i]),
            value: written.value,
            flips: 0,
            top: largest(&contributions, MOST_TOLD),
        };
        pixels.push((place, pixel));
    }
    Found {
        pixels,
        shares,
        flips: Vec::new(),
        non_finite: Vec::new(),
    }
}

/// The largest contributions, the largest first.
pub(super) fn largest(contributions: &Contributions, most: usize) -> Vec<Contribution> {
    let sources = contributions.sources.iter();
    let mut all: Vec<Contribution> = sources
        .map(|&source| Contribution {
            source: source as usize,
            error: contributions.of(source),
        })
        .filter(|c| c.size() > 0.0)
        .collect();
    all.sort_by(|a, b| b.size().total_cmp(&a.size()));
    all.truncate(most);
    all
}
