//! Studies: what is asked of machines, kernels and scenes, on top of the one chain of
//! [`srp_toolchain`].
//!
//! A study is a function from plain options to a report, which is data that `serde` writes. Nothing
//! here prints, parses a command line or makes a page; whoever shows a report is above.

pub mod certificate;
mod error;
pub mod loops;
pub mod map;

pub use error::Error;
