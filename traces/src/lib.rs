//! Windows of a simulation as files of viewers: every cycle of them, every operation, every register.
//!
//! A [`Tracer`] makes cores that run as fast as the engine that it is given, record in a [`Window`], and go on as fast
//! as before. What they have recorded, and what the system's observer has seen meanwhile, is a [`Trace`]. It is
//! [replayed](replay::replay()) as one sequence of [`event::Event`]s, from which each writer makes its bytes: [`fst`] waves,
//! [`konata`] a pipeline, [`perfetto`] a timeline. Nothing is looked up, printed or written here.

pub mod event;
mod flow;
pub mod format;
pub mod fst;
pub mod history;
pub mod konata;
mod listening;
pub mod names;
pub mod perfetto;
mod protobuf;
pub mod replay;
mod shared;
pub mod trace;
mod traced;
pub mod tracer;
pub mod window;

pub use format::Format;
pub use trace::Trace;
pub use tracer::{TraceError, Tracer};
pub use window::{MAX_CYCLES, MAX_RECORDS, Window};
