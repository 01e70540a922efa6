//! The C that comes along, as text, and the tables that C and Rust share.
//!
//! * [`SOURCES`] and [`HEADERS`]: the kernels of a frame and their job queue (SGRT 3.4.3).
//! * [`libc`]: the C library that programs are linked with.
//! * [`MICRO`]: small programs whose loops are measured.
//! * [`effect`] and [`form`]: the choices with which the kernels of a frame can be built.
//! * [`decision`]: the lines that decide what studies count by name.
//! * [`layout`] and [`number`]: the structures of `scene.h` and the numbers of `rgs.h`.
//!
//! The build script lists the files: a new `kernels/x.c` is part of a frame, and a new
//! `kernels/libc/x.c` part of the library, without a line elsewhere.

pub mod decision;
pub mod effect;
pub mod form;
pub mod layout;
pub mod libc;
pub mod number;

/// A file that comes along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct File {
    /// Its name within its folder, as `#include` has it.
    pub name: &'static str,
    /// Its path from the root of the repository, as messages have it.
    pub path: &'static str,
    /// Its text.
    pub text: &'static str,
}

mod files {
    use super::File;

    include!(concat!(env!("OUT_DIR"), "/files.rs"));
}

/// The sources of a frame: ray generation, shading, output and the job queue.
pub static SOURCES: &[File] = files::SOURCES;

/// The headers of the kernels, which every source can include.
pub static HEADERS: &[File] = files::HEADERS;

/// Programs with loops of the kinds that are measured everywhere, each with a `main`.
pub static MICRO: &[File] = files::MICRO;

/// The header of the kernels with this name.
pub fn header(name: &str) -> Option<&'static File> {
    HEADERS.iter().find(|file| file.name == name)
}
