//! Pictures: the contents of the frame buffer, and PNG.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use serde::{Deserialize, Serialize};

use crate::memory::SystemMemory;
use crate::scene_image::FrameBuffer;

/// A picture of 8 bits a channel, row by row from the upper left corner.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue, alpha of each pixel.
    pub rgba: Vec<u8>,
}

impl Picture {
    /// The contents of the frame buffer, without the pixels that only fill tiles.
    pub fn of(memory: &SystemMemory, frame: &FrameBuffer) -> Picture {
        let mut rgba = Vec::with_capacity((frame.width * frame.height * 4) as usize);
        for y in 0..frame.height {
            let address = frame.address + y * frame.stride * 4;
            let row = memory.get(address, frame.width * 4);
            rgba.extend_from_slice(row.expect("the frame buffer lies in memory"));
        }
        Picture {
            width: frame.width,
            height: frame.height,
            rgba,
        }
    }

    /// The number of pixels that differ from those of another picture of the same size.
    pub fn differences(&self, other: &Picture) -> u64 {
        let both = self.rgba.chunks_exact(4).zip(other.rgba.chunks_exact(4));
        both.filter(|(a, b)| a != b).count() as u64
    }

    /// The picture as a PNG file of 8-bit RGB; the same bytes on every host.
    pub fn png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let encoder = PngEncoder::new_with_quality(
            &mut bytes,
            CompressionType::Default,
            FilterType::Adaptive,
        );
        let rgb: Vec<u8> = self
            .rgba
            .chunks_exact(4)
            .flat_map(|p| [p[0], p[1], p[2]])
            .collect();
        encoder
            .write_image(&rgb, self.width, self.height, ExtendedColorType::Rgb8)
            .expect("writing to a Vec does not fail, and the sizes agree");
        bytes
    }
}
