//! Effects: capabilities that the kernels can be built with, and those that a scene calls for.
//!
//! An effect is a capability. Kernels that are built for more than a scene needs make the same
//! picture, bit for bit, in more cycles; kernels that are built for less cannot make it, and the
//! [guard](Guard) stops a frame that needs an effect they lack.

mod find;
mod guard;
mod unsupported;

pub use find::{Finding, find};
pub use guard::{Guard, Missing};
pub use srp_kernels::effect::{Effect, Effects, TABLE, UnknownEffect};
pub use unsupported::{Unsupported, unsupported};
