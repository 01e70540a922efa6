//! Programs and frames that are stopped, looked into, and taken back; and engines in lock step.
//!
//! A [`Session`] runs a program, or a frame on all cores of a system, on interpreters that note every cycle. It stops
//! at breakpoints and watched changes, goes on by cycles, lines, calls and launches, and goes back: it keeps
//! checkpoints, and runs on from the last one before. [`Variables`] tells which operation makes which variable's value.
//! Nothing is printed or looked up here.

pub mod adapter;
mod breakpoint;
mod code;
mod evaluate;
mod expression;
mod history;
mod kept;
mod locals;
mod machine;
mod names;
pub mod session;
pub mod show;
mod stop;
mod stored;
pub mod tandem;
pub mod terminal;
mod typed;
pub mod variables;
mod watched;

pub use breakpoint::{Memory, NoBreakpoint};
pub use expression::{Expression, NoExpression};
pub use machine::End;
pub use session::{Reason, Session, SessionError, Stopped, Until};
pub use show::{Frame, FrameOf, Scope, Variable};
pub use variables::Variables;
