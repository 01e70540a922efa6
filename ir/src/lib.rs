//! The program in each of its forms, and its semantics.
//!
//! * [`program`]: SSA with block parameters, made by the front end and changed by the passes.
//! * [`dfg`]: one loop body as a dataflow graph, placed by the modulo scheduler.
//! * [`dre`]: the program divided between VLIW engine and array, unscheduled and scheduled.
//! * [`described`]: the types and variables of a source, for debuggers.
//! * [`check`]: checks every scheduled program.
//! * [`graph`]: reads dataflow graphs that come from elsewhere.
//! * [`split`]: makes a `Dre` of a `Program`.
//! * [`flow`]: predecessors, dominators, loops.
//! * [`layout`]: where globals live.
//! * [`text`]: the listing of a program, written and read back.
//! * [`verify()`]: checks the invariants of every program.
//! * [`interp`]: interprets a program.
//! * [`shadow`]: finds the sources of its rounding errors.
//! * [`pass`]: optimises it.

pub mod check;
pub mod described;
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
