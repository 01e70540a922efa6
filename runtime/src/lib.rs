//! The ground of all simulators: the scene, the memory, the T&I unit, and the clock that runs them
//! together with the simulated cores.
//!
//! An engine is whatever implements [`core::Core`]; the compiler crates are unknown here. Nothing
//! in this crate opens a file or looks at a clock.

pub mod bvh;
pub mod core;
pub mod digits;
pub mod effect;
pub mod memory;
pub mod picture;
pub mod scene;
pub mod scene_image;
pub mod solo;
mod sums;
pub mod system;
pub mod tni;
pub use srp_archdesc::ports;
