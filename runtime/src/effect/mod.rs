//! Effects: what the kernels can be built for, and which of it a scene calls for.
//!
//! An effect is a capability. Kernels that are built for more than a scene needs make the same
//! picture, bit for bit, in more cycles; kernels that are built for less cannot make it, and the
//! [guard](Guard) stops a frame that meets what they were not built for.

mod find;
mod guard;
mod unsupported;

pub use find::{Finding, find};
pub use guard::{Guard, Missing};
pub use srp_kernels::effect::{Effect, Effects, TABLE, UnknownEffect};
pub use unsupported::{Unsupported, unsupported};
