//! Promises about the files of strangers: for each kind a function that takes any bytes and panics where one is broken.
//! `tests/fuzz` gives these functions to cargo-fuzz, which looks for bytes that lead to new code; the test `strangers` gives
//! them the seeds that were found so far, and changes of these at random.

pub mod cases;
pub mod checkpoint;
pub mod compile;
pub mod document;
pub mod graph;
pub mod machine;
pub mod program;
pub mod scene;
pub mod schedule;

/// A target: its name, which is that of the folder of its seeds, and the function.
pub type Target = (&'static str, fn(&[u8]));

/// All targets.
pub const TARGETS: [Target; 9] = [
    ("cases", cases::any),
    ("checkpoint", checkpoint::any),
    ("compile", compile::any),
    ("document", document::any),
    ("graph", graph::any),
    ("machine", machine::any),
    ("program", program::any),
    ("scene", scene::any),
    ("schedule", schedule::any),
];
