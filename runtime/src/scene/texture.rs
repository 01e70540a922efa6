//! Pictures that surfaces are covered with, as the texture unit reads them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{fmt, io};

use image::ImageReader;
use serde::Serialize;

use super::load::{Load, Part};
use super::mipmap::{self, Level};
use crate::memory::MAX_BYTES;

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
    /// True if it has smaller levels, from which it is sampled where it is seen from far.
    pub levels: bool,
}

impl Texture {
    /// The texel at this column and row, the lowest row being 0.
    pub fn texel(&self, x: u32, y: u32) -> u32 {
        self.texels[y as usize * self.width as usize + x as usize]
    }

    /// How many smaller levels it has: each side halves until both are 1.
    pub fn smaller_levels(&self) -> u32 {
        match self.levels {
            true => self.width.max(self.height).max(1).ilog2(),
            false => 0,
        }
    }

    /// Its smaller levels, the largest first.
    pub fn smaller(&self) -> impl Iterator<Item = Level> + '_ {
        let levels = self.smaller_levels() as usize;
        mipmap::smaller(self.width, self.height, |x, y| self.texel(x, y)).take(levels)
    }

    /// Bytes that it takes in memory with its smaller levels: tiles of 4 × 4 texels, each 64 bytes.
    pub fn bytes(&self) -> u64 {
        let side = |texels: u32, level: u32| u64::from((texels >> level).max(1).div_ceil(4));
        let levels = 0..=self.smaller_levels();
        levels
            .map(|level| side(self.width, level) * side(self.height, level) * 64)
            .sum()
    }

    /// The texels of all levels as `srp_texture_map` of `kernels/scene.h` has them, level by level.
    pub fn tiles(&self) -> impl Iterator<Item = Vec<u8>> + '_ {
        let whole = std::iter::once_with(|| tiles(self.width, self.height, &self.texels));
        whole.chain((self.smaller()).map(|level| tiles(level.width, level.height, &level.texels)))
    }
}

/// Texels in tiles, with 0 where a tile is not full.
fn tiles(width: u32, height: u32, texels: &[u32]) -> Vec<u8> {
    let size = width.next_multiple_of(4) as usize * height.next_multiple_of(4) as usize;
    let mut bytes = Vec::with_capacity(4 * size);
    for tile_y in (0..height).step_by(4) {
        for tile_x in (0..width).step_by(4) {
            for (y, x) in (0..16).map(|i| (tile_y + i / 4, tile_x + i % 4)) {
                let texel = match x < width && y < height {
                    true => texels[y as usize * width as usize + x as usize],
                    false => 0,
                };
                bytes.extend_from_slice(&texel.to_le_bytes());
            }
        }
    }
    bytes
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

/// Most texels of all pictures of a scene: half of system memory, and two thirds with their smaller levels.
const MAX_TEXELS: u64 = MAX_BYTES as u64 / 8;

/// Most bytes that decoding a picture may take besides its texels.
const MAX_DECODING: u64 = 1 << 30;

/// Why a picture cannot be used.
#[derive(Debug)]
pub(super) enum TextureError {
    Missing(io::Error),
    Picture(image::ImageError),
    TooMany,
}

impl fmt::Display for TextureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TextureError::Missing(why) => why.fmt(f),
            TextureError::Picture(why) => why.fmt(f),
            TextureError::TooMany => {
                write!(
                    f,
                    "all pictures together have more than {MAX_TEXELS} texels"
                )
            }
        }
    }
}

/// The pictures read so far, each once for each use of its channels.
#[derive(Debug, Default)]
pub(super) struct Pictures {
    /// The index of each, or why it cannot be used.
    read: BTreeMap<(PathBuf, Channel), Result<u32, String>>,
    texels: u64,
    pub(super) textures: Vec<Texture>,
}

impl Pictures {
    /// The index of the picture at `path`, or why it cannot be used.
    pub(super) fn read(
        &mut self,
        path: &Path,
        channel: Channel,
        load: &mut Load<'_>,
    ) -> Result<u32, String> {
        let key = (path.to_owned(), channel);
        if let Some(known) = self.read.get(&key) {
            return known.clone();
        }
        let read = self.add(path, channel, load).map_err(|e| e.to_string());
        self.read.insert(key, read.clone());
        read
    }

    fn add(
        &mut self,
        path: &Path,
        channel: Channel,
        load: &mut Load<'_>,
    ) -> Result<u32, TextureError> {
        let bytes = load(path, Part::Picture).map_err(TextureError::Missing)?;
        let name = path.display().to_string();
        let texture = decode(&name, &bytes, channel, MAX_TEXELS - self.texels)?;
        self.texels += texture.texels.len() as u64;
        self.textures.push(texture);
        Ok(self.textures.len() as u32 - 1)
    }
}

/// The picture in a png or jpg file, if it has no more than so many texels. These are counted before anything is
/// decoded: a few bytes can stand for a picture of any size.
fn decode(name: &str, bytes: &[u8], channel: Channel, most: u64) -> Result<Texture, TextureError> {
    let wrong = |e: io::Error| TextureError::Picture(e.into());
    let reader = || {
        let reader = ImageReader::new(io::Cursor::new(bytes));
        let mut reader = reader.with_guessed_format().map_err(wrong)?;
        let mut limits = image::Limits::default();
        limits.max_image_width = Some(MAX_TEXTURE_SIDE);
        limits.max_image_height = Some(MAX_TEXTURE_SIDE);
        limits.max_alloc = Some(MAX_DECODING);
        reader.limits(limits);
        Ok(reader)
    };
    let (width, height) = (reader()?.into_dimensions()).map_err(TextureError::Picture)?;
    if u64::from(width) * u64::from(height) > most {
        return Err(TextureError::TooMany);
    }
    let picture = reader()?.decode().map_err(TextureError::Picture)?;
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
    let mut texels = Vec::with_capacity(width as usize * height as usize);
    for row in picture.rows().rev() {
        texels.extend(row.map(word));
    }
    Ok(Texture {
        name: name.to_owned(),
        width,
        height,
        texels,
        levels: true,
    })
}
