//! T&I.
pub mod arithmetic;
