//! The C library: headers for `#include <…>`, and sources. A program gets the functions that it uses and
//! does not define.

use crate::{File, files};

/// The sources. Functions begin in the first column, by which the front end finds the source of a function
/// without parsing all of them.
pub static SOURCES: &[File] = files::LIBC_SOURCES;

/// The headers.
pub static HEADERS: &[File] = files::LIBC_HEADERS;

/// The path of the source whose functions stand in for operations that no unit of a machine runs.
pub const SOFTWARE: &str = "kernels/libc/software.c";

/// The header with this name.
pub fn header(name: &str) -> Option<&'static File> {
    HEADERS.iter().find(|file| file.name == name)
}

/// The file at this path, `kernels/libc/NAME`.
pub fn at(path: &str) -> Option<&'static File> {
    HEADERS.iter().chain(SOURCES).find(|file| file.path == path)
}
