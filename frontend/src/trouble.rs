//! [`Trouble`]: where the generated parser stopped.

use crate::token::Tok;
use lalrpop_util::{ErrorRecovery, ParseError};

/// Something the parser did not understand.
#[derive(Clone, Debug)]
pub(crate) struct Trouble {
    /// The number of the token where it stopped.
    pub(crate) at: usize,
    /// Names of the tokens that could stand there.
    pub(crate) expected: Vec<String>,
}

impl Trouble {
    /// From the parser's report.
    pub(crate) fn of(recovery: ErrorRecovery<usize, Tok, ()>) -> Trouble {
        Trouble::of_error(recovery.error)
    }

    /// The same where the parser could not go on.
    pub(crate) fn of_error(error: ParseError<usize, Tok, ()>) -> Trouble {
        let (at, expected) = match error {
            ParseError::UnrecognizedToken { token, expected } => (token.0, expected),
            ParseError::UnrecognizedEof { expected, .. } => (usize::MAX, expected),
            ParseError::ExtraToken { token } => (token.0, Vec::new()),
            ParseError::InvalidToken { location } => (location, Vec::new()),
            ParseError::User { .. } => (usize::MAX, Vec::new()),
        };
        Trouble { at, expected }
    }
}
