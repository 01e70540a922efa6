//! From a scheduled program and its machine to a simulator that is exact to the cycle.
//!
//! [`link()`] takes a program that the checker has passed and resolves everything into tables,
//! [`SimSpec`]. Two engines run them:
//!
//! * [`Interpreter`] goes through the tables. It needs no compiler, starts at once, and is the
//!   reference for the other.
//! * [`emit()`] writes them as Rust, a [`Compiler`] has rustc make a library of that, and
//!   [`Simulator`] loads it. It is an order of magnitude faster, and worth its compile time from
//!   some ten million cycles on; the library is kept for the next time.
//!
//! Both implement [`Core`](srp_runtime::core::Core). They share the machinery in [`preamble`]: what
//! a cycle is made of is in tables or code, when which cycle happens is written once. [`Counting`] is the
//! interpreter with counters, for profiles; [`Recorder`] is the interpreter that tells what every cycle does, for
//! traces.

pub mod compile;
pub mod emit;
pub mod interp;
pub mod link;
pub mod load;
pub mod preamble;
pub mod spec;

pub use compile::{CompileError, Compiler};
pub use emit::{SimSource, emit, emit_on_machinery};
pub use interp::{
    Counting, Counts, Interpreter, KernelCounts, Record, Recorder, SharedCounts, Snapshot, Turn,
};
pub use link::{TooManyStages, link};
pub use load::{Functions, LoadError, Simulator};
pub use spec::SimSpec;
