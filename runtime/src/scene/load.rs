//! The loader that a caller hands in: it has the files.

use std::io;
use std::path::Path;

/// The part of a scene that a file has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Its geometry: the file that the user names.
    Geometry,
    /// A library of materials, which the geometry names.
    Materials,
    /// A picture, which a library names.
    Picture,
}

/// Gives the bytes of a file that is to have a part of the scene.
pub type Load<'a> = dyn FnMut(&Path, Part) -> io::Result<Vec<u8>> + 'a;
