//! What strangers bring, by kind: functions that take any bytes and panic where a promise is broken. `tests/fuzz` gives them
//! to cargo-fuzz, which looks for bytes that lead to new code; the test `strangers` gives them what was found so far, and
//! that changed at random.

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
