//! The macros of `rgs.h` that stand for numbers, for Rust code that predicts the work of kernels.

include!(concat!(env!("OUT_DIR"), "/numbers.rs"));
