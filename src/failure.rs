//! Why a command fails.

use crate::talk;
use srp_toolchain::Error;
use srp_toolchain::files::FileError;

/// A failure that is the input's, said once on standard error; the exit status is 1 unless something else is said.
#[derive(Debug)]
pub(crate) enum Failure {
    /// One sentence.
    Message(String),
    /// Arguments that do not go together, in one sentence; the exit status is 2.
    Usage(String),
    /// Diagnostics, rendered already.
    Reported(String),
    /// The user asked for an end.
    Interrupted,
}

impl Failure {
    /// A failure of one sentence.
    pub(crate) fn message(text: impl std::fmt::Display) -> Failure {
        Failure::Message(text.to_string())
    }

    /// The failure of a study that was begun with nothing but arguments.
    pub(crate) fn of_arguments(error: srp_studies::Error) -> Failure {
        match error {
            srp_studies::Error::Invalid(text) => Failure::Usage(text),
            error => error.into(),
        }
    }

    /// A failure of arguments, in one sentence.
    pub(crate) fn usage(text: impl std::fmt::Display) -> Failure {
        Failure::Usage(text.to_string())
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Failure {
        Failure::message(error)
    }
}

impl From<srp_studies::Error> for Failure {
    fn from(error: srp_studies::Error) -> Failure {
        match error {
            srp_studies::Error::Toolchain(error) => error.into(),
            srp_studies::Error::Simulator {
                source: Error::Cancelled,
                ..
            } => Failure::Interrupted,
            error => Failure::message(error),
        }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Failure {
        match error {
            Error::Messages(messages) => Failure::Reported(messages.render(talk::colour())),
            Error::Cancelled => Failure::Interrupted,
            error => Failure::message(error),
        }
    }
}
