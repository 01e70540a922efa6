//! Studies that are held against other arithmetic, other tracers and other ways: one program, so that long ones run beside
//! each other.

mod kernel;
mod leaks;
#[path = "../../../runtime/tests/support/mod.rs"]
mod support;
mod tni;
mod truth;
