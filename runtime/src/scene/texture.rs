//! Pictures that surfaces are covered with, as the texture unit reads them.

use std::path::{Path, PathBuf};
use std::{fmt, io};

use image::ImageReader;
use serde::Serialize;

/// Largest width and height of a picture, in texels.
pub const MAX_TEXTURE_SIDE: u32 = 16384;

/// A picture.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Texture {
    /// The file it comes from, or its name.
    pub name: String,
    /// Texels of a row, 1 to [`MAX_TEXTURE_SIDE`].
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The texels row by row, the lowest row first: red in the low byte, then green, blue and alpha;
    /// the colours in sRGB.
    pub texels: Vec<u32>,
}

impl Texture {
    /// The texel at this column and row, the lowest row being 0.
    pub fn texel(&self, x: u32, y: u32) -> u32 {
        self.texels[y as usize * self.width as usize + x as usize]
    }

    /// Bytes that it takes in memory: tiles of 4 × 4 texels, each 64 bytes.
    pub fn bytes(&self) -> u64 {
        u64::from(self.width.div_ceil(4)) * u64::from(self.height.div_ceil(4)) * 64
    }

    /// The texels as `srp_texture_map` of `kernels/scene.h` has them; 0 where a tile is not full.
    pub fn tiles(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.bytes() as usize);
        for tile_y in (0..self.height).step_by(4) {
            for tile_x in (0..self.width).step_by(4) {
                for (y, x) in (0..16).map(|i| (tile_y + i / 4, tile_x + i % 4)) {
                    let is_there = x < self.width && y < self.height;
                    let texel = if is_there { self.texel(x, y) } else { 0 };
                    bytes.extend_from_slice(&texel.to_le_bytes());
                }
            }
        }
        bytes
    }
}

/// The property of a material that a texture changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channel {
    /// Its colours.
    Colour,
    /// Its dissolve, by which it stops light: the picture's alpha if it has any, else its brightness.
    Dissolve,
}

/// A texture on a material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Map {
    /// Its index among the textures of the scene.
    pub texture: u32,
    /// True if coordinates stop at its edges; else it repeats.
    pub clamp: bool,
}

/// Why a picture cannot be used.
#[derive(Debug)]
pub(super) enum TextureError {
    Missing(io::Error),
    Picture(image::ImageError),
}

impl fmt::Display for TextureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TextureError::Missing(why) => why.fmt(f),
            TextureError::Picture(why) => why.fmt(f),
        }
    }
}

/// The pictures read so far, each once for each use of its channels.
#[derive(Debug, Default)]
pub(super) struct Pictures {
    read: Vec<(PathBuf, Channel)>,
    pub(super) textures: Vec<Texture>,
}

impl Pictures {
    /// The index of the picture at `path`.
    pub(super) fn read(
        &mut self,
        path: &Path,
        channel: Channel,
        load: &mut dyn FnMut(&Path) -> io::Result<Vec<u8>>,
    ) -> Result<u32, TextureError> {
        let key = (path.to_owned(), channel);
        if let Some(known) = self.read.iter().position(|read| *read == key) {
            return Ok(known as u32);
        }
        let bytes = load(path).map_err(TextureError::Missing)?;
        let texture = decode(&path.display().to_string(), &bytes, channel);
        self.textures.push(texture.map_err(TextureError::Picture)?);
        self.read.push(key);
        Ok(self.read.len() as u32 - 1)
    }
}

/// The picture in a png or jpg file.
fn decode(name: &str, bytes: &[u8], channel: Channel) -> Result<Texture, image::ImageError> {
    let mut reader = ImageReader::new(io::Cursor::new(bytes)).with_guessed_format()?;
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_TEXTURE_SIDE);
    limits.max_image_height = Some(MAX_TEXTURE_SIDE);
    limits.max_alloc = Some(2 << 30);
    reader.limits(limits);
    let picture = reader.decode()?;
    let has_alpha = picture.color().has_alpha();
    let picture = picture.into_rgba8();
    let word = |pixel: &image::Rgba<u8>| {
        let [r, g, b, a] = pixel.0;
        let alpha = match channel {
            Channel::Dissolve if !has_alpha => {
                // Rec. 709 luma in 16 bits.
                let luma = 13_933 * u32::from(r) + 46_871 * u32::from(g) + 4_732 * u32::from(b);
                ((luma + (1 << 15)) >> 16) as u8
            }
            _ => a,
        };
        u32::from_le_bytes([r, g, b, alpha])
    };
    let (width, height) = picture.dimensions();
    let rows = picture.rows().rev();
    Ok(Texture {
        name: name.to_owned(),
        width,
        height,
        texels: rows
            .flat_map(|row| row.map(word).collect::<Vec<_>>())
            .collect(),
    })
}
