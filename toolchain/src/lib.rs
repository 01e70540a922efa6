//! From files to a scheduled program and a running simulator: every stage in its order.
//!
//! * [`input`] and [`machine`] read what a user gives; [`scene`] reads what is rendered.
//! * [`compile()`] takes C, or a later form, to a schedule: [`front_end()`], [`optimise()`],
//!   [`divide()`], [`schedule()`].
//! * [`Build`] says what the kernels of a frame are built for, [`Frame`] what is rendered, and
//!   [`Frame::render`] runs it.
//! * [`Engine`] is what simulates an SRP.
//!
//! Commands, studies, tests and benches call these functions and have no chain of their own. Options
//! are plain data. Work goes on in a [`Session`], which says who watches it and how many threads it
//! may use; nothing here prints.

pub mod cache;
mod compile;
mod divide;
pub mod engine;
mod error;
pub mod files;
mod frame;
mod front_end;
pub mod input;
mod loops;
pub mod machine;
mod options;
pub mod scene;
mod session;

pub use cache::Cache;
pub use compile::{Compiled, CompiledLoops, compile, compile_loops, facts_alone, schedule};
pub use divide::{Divided, NotPipelined, WhyNot, divide};
pub use engine::{Engine, Engines};
pub use error::Error;
pub use frame::{
    BUILD_ID, Build, Frame, FrameOptions, MAX_CYCLES, hash, kernel_names, system_options,
};
pub use front_end::{front_end, optimise, program, run_passes, syntax_tree};
pub use input::Input;
pub use loops::schedule_loop;
pub use options::{Effort, Options, Warnings};
pub use session::{Session, Timed, Times};
