//! Why a study fails.

/// Why a study fails.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The chain of tools fails.
    #[error(transparent)]
    Toolchain(#[from] srp_toolchain::Error),
    /// A frame without a clock fails.
    #[error(transparent)]
    Functional(#[from] crate::functional::FunctionalError),
    /// The simulator of so many effects cannot be built, or fails.
    #[error("{source}\nnote: this is the simulator of {effects} effects")]
    Simulator {
        /// Number of effects.
        effects: usize,
        /// The failure.
        source: srp_toolchain::Error,
    },
    /// Something that the user asked for is not possible, in one sentence or several lines.
    #[error("{0}")]
    Invalid(String),
}

impl Error {
    /// A failure of one sentence.
    pub fn invalid(why: impl std::fmt::Display) -> Error {
        Error::Invalid(why.to_string())
    }

    /// The user asked for an end.
    pub fn cancelled() -> Error {
        Error::Toolchain(srp_toolchain::Error::Cancelled)
    }

    /// True if the user asked for an end.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Error::Toolchain(srp_toolchain::Error::Cancelled))
    }
}

impl From<srp_toolchain::files::FileError> for Error {
    fn from(error: srp_toolchain::files::FileError) -> Error {
        Error::Toolchain(error.into())
    }
}
