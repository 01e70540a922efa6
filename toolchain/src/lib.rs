//! From files to a scheduled program and a running simulator: every stage in its order.
//!
//! * [`input`] and [`machine`] read the files of a user; [`scene`] reads scenes.
//! * [`compile()`] takes C, or a later form, to a schedule: [`front_end()`], [`optimise()`],
//!   [`divide()`], [`schedule()`].
//! * A [`Build`] holds the choices with which the kernels of a frame are built, a [`Frame`] also its scene, and
//!   [`Frame::render`] renders it.
//! * An [`Engine`] simulates an SRP.
//!
//! Commands, studies, tests and benches call these functions and have no chain of their own. Options
//! are plain data. Work goes on in a [`Session`], which says who watches it and how many threads it
//! may use; nothing here prints.

pub mod amount;
mod approximate;
pub mod cache;
pub mod checkpoint;
mod coarse;
mod compile;
mod divide;
pub mod engine;
pub mod envelope;
mod error;
pub mod files;
mod frame;
mod front_end;
pub mod input;
pub mod json;
mod loops;
pub mod machine;
mod options;
mod ready;
pub mod scene;
mod session;
mod views;

pub use cache::Cache;
pub use compile::{
    Compiled, CompiledLoops, LeastIi, compile, compile_loops, facts_alone, least_iis, schedule,
    schedule_divided,
};
pub use divide::{Divided, NotPipelined, WhyNot, divide};
pub use engine::{Engine, Engines};
pub use error::Error;
pub use frame::{
    BUILD_ID, Build, Frame, FrameOptions, Kernels, MAX_CYCLES, code_sizes, hash, kernel_names,
    system_options,
};
pub use front_end::{
    WithTexts, described, front_end, interface, optimise, program, run_passes, syntax_tree,
    with_texts,
};
pub use input::Input;
pub use loops::schedule_loop;
pub use options::{Effort, Options, Warnings};
pub use ready::{Ready, Scheduled};
pub use session::{Session, Timed, Times};
pub use srp_frontend::interface::{Function, Interface, Object, Shape, StatedRange};
