//! Operations of an SRP, and the parts of one SGRT system.
//!
//! This is the ground floor: every other crate stands on it, and it imports none of them.
//!
//! * [`isa`]: the one opcode table.
//! * [`ops`]: the function of each opcode, written once.
//! * [`ports`]: the numbers by which programs talk to the units round an SRP.
//! * [`arch`], [`system`], [`dram`] and [`precision`]: a machine as data. [`parse`] makes it from the XML file an architecture
//!   designer edits; whatever the file leaves out is filled in there, so nothing downstream knows
//!   of defaults.
//! * [`area`]: the cost of a T&I unit.
//! * [`certify`](mod@certify): the errors of an approximate unit.
//! * [`datapath`]: the tests that the T&I unit can be built for, their operators and depths.
//! * [`resource`]: the machine as a router sees it, derived from [`Arch`].
//! * [`machines`]: the machine files that the toolchain ships.
//! * [`show`](fn@show): a machine as text to read.
//! * [`diagnostic`]: messages about a user's text, with positions; the C front end reports through
//!   it too.
//! * [`watch`] and [`threads`]: how long work is watched, and how it is shared among threads.

pub mod arch;
pub mod area;
pub mod certify;
pub mod chip;
pub mod choice;
pub mod cost;
pub mod datapath;
pub mod diagnostic;
pub mod dram;
pub mod entity;
pub mod format;
pub mod haste;
pub mod isa;
pub mod machines;
pub mod nearest;
pub mod ops;
pub mod ports;
pub mod precision;
pub mod resource;
pub mod show;
pub mod structure;
pub mod system;
pub mod threads;
pub mod watch;
pub mod xml;

pub use arch::Arch;
pub use diagnostic::Diagnostic;
pub use isa::{Class, Opcode, Ty};
pub use resource::ResourceGraph;
pub use show::show;
pub use system::SystemSpec;
pub use watch::{Unwatched, Watch};
pub use xml::parse;
