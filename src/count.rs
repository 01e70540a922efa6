//! Numbers of things in words.

use std::fmt::Display;

/// A number and the thing counted, in the plural unless the number is 1.
pub(crate) fn count<N: Display + PartialEq + From<u8>>(n: N, what: &str) -> String {
    let plural = if n == N::from(1) { "" } else { "s" };
    format!("{n} {what}{plural}")
}
