//! The program in each of its forms, and what it means.
//!
//! * [`program`]: SSA with block parameters, what the front end makes and the passes change.
//! * [`dfg`]: one loop body as a dataflow graph, what the modulo scheduler places.
//! * [`dre`]: the program divided between VLIW engine and array, unscheduled and scheduled.
//! * [`check`]: what holds of every scheduled program.
//! * [`graph`]: dataflow graphs that come from elsewhere, read.
//! * [`split`]: makes a `Dre` of a `Program`.
//! * [`flow`]: predecessors, dominators, loops.
//! * [`layout`]: where globals live.
//! * [`text`]: the listing of a program, written and read back.
//! * [`verify()`]: what holds of every program.
//! * [`interp`]: what a program means.
//! * [`shadow`]: where its rounding errors come from.
//! * [`pass`]: what makes it better.

pub mod check;
pub mod dfg;
pub mod dre;
pub mod flow;
pub mod graph;
pub mod interp;
pub mod layout;
pub mod pass;
pub mod program;
pub mod shadow;
pub mod split;
pub mod text;
pub mod verify;

pub use dfg::Dfg;
pub use program::Program;
pub use verify::verify;
