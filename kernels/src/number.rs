//! The macros of `rgs.h` that stand for numbers, for Rust code that foretells what kernels do.

include!(concat!(env!("OUT_DIR"), "/numbers.rs"));
