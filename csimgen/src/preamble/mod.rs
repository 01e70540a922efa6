//! Machinery under both engines, and part of every generated simulator as it stands.
//!
//! These files are compiled and linted here, where the interpreter uses them; `emit` puts their
//! text into the simulator. There they find the same neighbours under the same names: the border of
//! a core (`srp_runtime::core`) and what opcodes compute (`srp_archdesc::ops::semantics`).

pub mod abi;
pub mod border;
pub mod issue;
pub mod registers;
pub mod saved;
pub mod sequencer;

/// [`srp_runtime::core`].
pub use srp_runtime::core as core_border;

/// [`srp_archdesc::ops::semantics`].
pub mod ops {
    pub use srp_archdesc::ops::semantics::elementary::*;
    pub use srp_archdesc::ops::semantics::lanes::*;
    pub use srp_archdesc::ops::semantics::texture;
    pub use srp_archdesc::ops::semantics::word::*;
}
