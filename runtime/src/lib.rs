//! What a simulator stands on.
pub mod core;
pub use srp_archdesc::ports;
