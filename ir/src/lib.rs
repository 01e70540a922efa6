//! The program in each of its forms, and what it means.
//!
//! * [`program`]: SSA with block parameters, what the front end makes and the passes change.
//! * [`dfg`]: one loop body as a dataflow graph, what the modulo scheduler places.
//! * [`dre`]: the program divided between VLIW engine and array, unscheduled and scheduled.
//! * [`layout`]: where globals live.

pub mod dfg;
pub mod dre;
pub mod layout;
pub mod program;

pub use dfg::Dfg;
pub use program::Program;
