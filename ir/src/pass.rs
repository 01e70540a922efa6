//! What makes a program better: one file a pass.

mod compact;

pub use compact::{compact, compact_program};
