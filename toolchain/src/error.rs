//! Why work of the toolchain fails.

use crate::files::FileError;
use srp_archdesc::diagnostic::Messages;
use srp_csimgen::TooManyStages;
use srp_ir::layout::TooLarge;
use srp_runtime::effect::{Missing, UnknownEffect};
use srp_runtime::scene_image::ImageError;
use srp_runtime::system::SystemError;
use srp_scheduler::ScheduleError;

/// Why work of the toolchain fails.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file or folder cannot be used.
    #[error(transparent)]
    File(#[from] FileError),
    /// A text is wrong: messages with places.
    #[error(transparent)]
    Messages(Messages),
    /// Something that the user asked for is not possible, in one sentence or several lines.
    #[error("{0}")]
    Invalid(String),
    /// A program that is to run has no `main`.
    #[error("the program has no function `main` to start with")]
    NoMain,
    /// The program's data do not fit.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// The program has no schedule.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
    /// Simulators have no room for a kernel.
    #[error(transparent)]
    Link(#[from] TooManyStages),
    /// The scene does not fit into memory.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// There is no such effect.
    #[error(transparent)]
    UnknownEffect(#[from] UnknownEffect),
    /// The kernels are not built for something that the scene calls for.
    #[error(transparent)]
    Missing(#[from] Missing),
    /// The frame was not finished.
    #[error(transparent)]
    System(#[from] SystemError),
    /// The user asked for an end.
    #[error("interrupted")]
    Cancelled,
}

impl Error {
    /// A failure of one sentence.
    pub fn invalid(why: impl std::fmt::Display) -> Error {
        Error::Invalid(why.to_string())
    }
}
