//! What a simulator stands on.
pub mod core;
pub mod ports;
